"""What all tasks of a controller share: how it is configured, and its persistent data."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from datetime import datetime
from typing import Final, Literal

from assistant.virtual.kernel.dates import CLOCK_START
from assistant.virtual.kernel.task import Task
from assistant.virtual.rapid.disk import Disk
from assistant.virtual.rapid.loading import Loaded
from assistant.virtual.rapid.scopes import Cell
from assistant.virtual.rapid.types import Types

Kind = Literal["normal", "static", "semistatic"]
"""Of a task: who starts it, and what becomes of it at power on (RAPID overview, Multitasking)."""
RETRIES: Final = 4
"""The system parameter No Of Retry, as controllers are delivered (reference, 2.1)."""


@dataclass(frozen=True, slots=True)
class Options:
    """What differs from controller to controller, or where its manuals leave more than one way.

    retries: of a statement, by RETRY. retries_raise: one more is the error ERR_EXCRTYMAX in that
    statement; else it stops the program. propagates: an error in a routine without a handler
    goes to that of its caller, as the kernel manual says; else it stops the program at once, as
    the overview does. began: when the simulated clock is at 0, as CDate and CTime tell it.
    addresses: real hosts by the address that programs state; others than this computer are not
    reached without it. sockets: whether programs may reach anything outside of the run at all.
    """

    retries: int = RETRIES
    retries_raise: bool = False
    propagates: bool = True
    began: datetime = CLOCK_START
    addresses: Mapping[str, str] = field(default_factory=dict)
    sockets: bool = True


@dataclass(slots=True, eq=False)
class Controller:
    """disk: its files, none at first. persistents: what the tasks share, by name in lower case.

    booked: numbers of errors. tasks: in the order in which they were started. programs: what they
    run. outputs, known: names of signals in lower case that programs set, and of all that they
    use. come: how often a task came to a point of WaitSyncTask, both by name in lower case.
    held: the task that has stopped all motions by StopMove, None while none has.
    looks: are called before each statement of any task, to see whether shared data has changed.
    """

    options: Options = field(default_factory=Options)
    disk: Disk = field(default_factory=Disk)
    persistents: dict[str, Cell] = field(default_factory=dict)
    booked: set[int] = field(default_factory=set)
    outputs: set[str] = field(default_factory=set)
    known: set[str] = field(default_factory=set)
    tasks: list[Task] = field(default_factory=list)
    come: dict[tuple[str, str], int] = field(default_factory=dict)
    programs: list[tuple[Loaded, Types]] = field(default_factory=list)
    looks: list[Callable[[], None]] = field(default_factory=list)
    held: Task | None = None
