"""Base of the interpreters of all languages: tasks on one simulated clock, signals, motions.

It is independent of any language. A language runs each of its programs in a `Task`, through which
it reports events, waits, and counts statements.
"""

from assistant.virtual.kernel.kernel import MOST_STEPS, Board, Instant, Kernel, Motion, Signals
from assistant.virtual.kernel.kernel_thread import Live
from assistant.virtual.kernel.task import Broken, Ending, Task

__all__ = [
    "MOST_STEPS",
    "Board",
    "Broken",
    "Ending",
    "Instant",
    "Kernel",
    "Live",
    "Motion",
    "Signals",
    "Task",
]
