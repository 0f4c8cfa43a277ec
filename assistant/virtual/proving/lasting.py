"""Runs that end when the time of a proof is over, wherever they are."""

from __future__ import annotations

import math
import time
from typing import TYPE_CHECKING, Final

from assistant.virtual.events import Awaited, Waited
from assistant.virtual.kernel.task import Ending

if TYPE_CHECKING:
    from collections.abc import Sequence

    from assistant.virtual.events import Logged, Run
    from assistant.virtual.kernel import Kernel

LATER_SHARE: Final = 3
"""Times as long as the source the written program may take; it has to do as much by then."""
LEAST_SECONDS: Final = 2.0
"""Of the first run of the source."""
LOOK_PERIOD: Final = 64
"""Statements between two looks at the clock."""
MORE_EVENTS_THAN_SOURCE: Final = (1.25, 4)
"""Of the written program, times and beside what the source has told, when that has no end."""
MORE_EFFECTS_THAN_SOURCE: Final = 2
"""Times as many visits and changes as the source has told are far more."""
OVER: Final = "time"
"""How such a run has ended."""
QUIET_STATEMENTS: Final = 250_000
"""Statements without an effect: taking a text apart, letter by letter, takes over 100,000."""
RAN_ON: Final = "it runs on without any effect"
"""What a run says that was broken off for this."""


def first_run_seconds(seconds: float, source: bool) -> float:
    """Seconds of the first run of the source, or of what was written, in a proof of so many."""
    return max(seconds, LEAST_SECONDS) * (1 if source else LATER_SHARE)


def limit_run(
    kernel: Kernel,
    seconds: float,
    after: Run | None = None,
    most: float = math.inf,
    ample: float = math.inf,
) -> None:
    """Has the run of a kernel end after so many seconds of the real clock.

    after: the run that it is compared with. Where that was broken off by its statements, what it
    has told is all that can be compared. most: events that the run may tell. ample: statements
    after which it ends where it has done far more, or nothing for a long time.
    """
    until = time.thread_time() + seconds
    counted = told = effects = latest = 0
    endless = after is not None and after.ended == "steps"
    enough = (
        MORE_EVENTS_THAN_SOURCE[0] * len(after.events) + MORE_EVENTS_THAN_SOURCE[1]
        if after and endless
        else most
    )
    far_more = MORE_EFFECTS_THAN_SOURCE * (_effect_count(after.log) + 1) if after else math.inf

    def limit() -> Ending | None:
        nonlocal counted, told, effects, latest
        counted += 1
        if counted % LOOK_PERIOD:
            return None
        if new := _effect_count(kernel.log[told:]):
            effects, latest = effects + new, counted
        told = len(kernel.log)
        if time.thread_time() > until:
            return Ending(OVER, f"it takes more than {seconds:.3g} s")
        if told > enough:
            return Ending("steps", "it has told as much as the run before")
        if counted > ample and effects > far_more:
            return Ending("steps", "it has done far more than the run before")
        if counted > ample and counted - latest > QUIET_STATEMENTS:
            return Ending("steps", RAN_ON)
        return None

    kernel.limit = limit


def _effect_count(log: Sequence[Logged]) -> int:
    return sum(not isinstance(row.what, Awaited | Waited) for row in log)
