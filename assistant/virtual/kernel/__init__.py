"""What the interpreters of all languages run on: tasks on one simulated clock, signals, motions.

It knows no language. A language runs each of its programs in a `Task`: it tells what happens,
waits, and counts statements through it.
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
