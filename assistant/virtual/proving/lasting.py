"""Runs that end when the time of a proof is over, wherever they are."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Final

from assistant.virtual.kernel.task import Ending

if TYPE_CHECKING:
    from assistant.virtual.kernel import Kernel
    from assistant.virtual.kernel.task import Task

LATER: Final = 3
"""Times as long as the source the written program may take; it has to do as much by then."""
LEAST_SECONDS: Final = 2.0
"""Of the first run of the source."""
LOOKED: Final = 64
"""Statements between two looks at the clock."""
OVER: Final = "time"
"""How such a run has ended."""


def first_run(seconds: float, source: bool) -> float:
    """Seconds of the first run of the source, or of what was written, in a proof of so many."""
    return max(seconds, LEAST_SECONDS) * (1 if source else LATER)


def broken_off(kernel: Kernel, seconds: float) -> None:
    """Has the run of a kernel end after so many seconds of the real clock."""
    until = time.monotonic() + seconds
    counted = 0

    def look(task: Task) -> None:
        nonlocal counted
        counted += 1
        if counted % LOOKED == 0 and time.monotonic() > until:
            kernel.halt(task, Ending(OVER, f"it takes more than {seconds:.3g} s"))

    kernel.watch = look
