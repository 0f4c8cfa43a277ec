"""Runs that end when the time of a proof is over, wherever they are."""

from __future__ import annotations

import math
import time
from typing import TYPE_CHECKING, Final

from assistant.virtual.kernel.task import Ending

if TYPE_CHECKING:
    from assistant.virtual.events import Run
    from assistant.virtual.kernel import Kernel
    from assistant.virtual.kernel.task import Task

LATER: Final = 3
"""Times as long as the source the written program may take; it has to do as much by then."""
LEAST_SECONDS: Final = 2.0
"""Of the first run of the source."""
LOOKED: Final = 64
"""Statements between two looks at the clock."""
MORE_EVENTS: Final = (1.25, 4)
"""Of the written program, times and beside what the source has told, when that has no end."""
OVER: Final = "time"
"""How such a run has ended."""


def first_run(seconds: float, source: bool) -> float:
    """Seconds of the first run of the source, or of what was written, in a proof of so many."""
    return max(seconds, LEAST_SECONDS) * (1 if source else LATER)


def broken_off(
    kernel: Kernel, seconds: float, after: Run | None = None, most: float = math.inf
) -> None:
    """Has the run of a kernel end after so many seconds of the real clock.

    after: the run that it is compared with. Where that was broken off by its statements, what it
    has told is all that can be compared. most: events that the run may tell.
    """
    until = time.thread_time() + seconds
    counted = 0
    endless = after is not None and after.ended == "steps"
    enough = MORE_EVENTS[0] * len(after.events) + MORE_EVENTS[1] if after and endless else most

    def look(task: Task) -> None:
        nonlocal counted
        counted += 1
        if counted % LOOKED == 0 and time.thread_time() > until:
            kernel.halt(task, Ending(OVER, f"it takes more than {seconds:.3g} s"))
        elif counted % LOOKED == 0 and len(kernel.log) > enough:
            kernel.halt(task, Ending("steps", "it has told as much as the run before"))

    kernel.watch = look
