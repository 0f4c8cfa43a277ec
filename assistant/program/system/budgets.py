"""How much of a file is read, and how much time and memory each stage may take for its input.

A stage is entered with the size of its input:

    with within(READING, path, size=len(text)):
        tree = parse(text)

Where it takes more processor time or memory than `STAGES` states for that size it ends in
`Refused`, with a finding, as it does where something is nested too deeply or a number is too large.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from dataclasses import dataclass
from functools import wraps
from types import TracebackType
from typing import Final, ParamSpec, TypeVar

from assistant.program.diagnostics import Diagnostic, Refused, error
from assistant.program.system.watchdog import Charge, Reached, installed_memory, watch

TIME: Final = error(
    "LM001",
    "{stage} takes more than {seconds:.3g} s of processor time, the budget for {size}",
    "look for what nests or repeats without end, or split it; or give it more:"
    " `robot-assistant --budget 10 …`",
)
MEMORY: Final = error(
    "LM002",
    "{stage} takes more memory than the {megabytes:.0f} MB that are the budget for {size}",
    "look for what multiplies, as arrays and blocks do, or split it; or give it"
    " more: `robot-assistant --budget 10 …`",
)
TOO_DEEP: Final = error(
    "LM003",
    "{stage} meets what is nested too deeply to be followed",
    "take the inner parts out: parentheses, blocks, calls or tables in each other",
)
TOO_GREAT: Final = error(
    "LM004",
    "{stage} meets a number that is too large to calculate with ({reason})",
    "write a number that a robot can have",
)
NO_MEMORY: Final = error(
    "LM005",
    "there is not enough memory for {stage}",
    "close other programs, or split the input",
)
NO_FACTOR: Final = error(
    "LM006",
    "`{value}` is no factor for budgets",
    "give a number from {least:g} to {most:g}, such as 10",
)

FACTOR_VARIABLE: Final = "ROBOT_ASSISTANT_BUDGET"
"""Of the environment: the factor that all budgets and sizes are taken times."""
FACTORS: Final = (0.001, 1e6)

MEGABYTE: Final = 1_000_000
FILE: Final = 256 * MEGABYTE
"""Bytes of a file that are read: a program, table, drawing, side table or archive."""
SETTINGS_FILE: Final = 16 * MEGABYTE
"""The same of one that people write: of a process, a robot, a project, a script."""
UNPACKED: Final = 1024 * MEGABYTE
"""Bytes that an archive may unpack to: 10,000,000 poses of 13 columns."""


PART_OF_MACHINE: Final = 0.8
"""Of its memory, which one stage may take."""


@dataclass(frozen=True, slots=True)
class Stage:
    """What a stage may take: a fixed part, and one for each million units of its input.

    unit: what its input is counted in. seconds: of processor time. megabytes: of memory that the
    process has more than before.
    """

    name: str
    unit: str
    seconds: float
    more_seconds: float
    megabytes: float
    more_megabytes: float

    def time_for(self, size: int) -> float:
        return budget_factor() * (self.seconds + self.more_seconds * size / 1e6)

    def memory_for(self, size: int) -> float:
        """Megabytes."""
        return budget_factor() * (self.megabytes + self.more_megabytes * size / 1e6)


READING: Final = Stage("reading", "bytes", 10, 60, 512, 2000)
CHECKING: Final = Stage("checking", "bytes", 10, 60, 512, 1000)
LIFTING: Final = Stage("lifting", "bytes", 10, 80, 512, 1000)
LAYING_OUT: Final = Stage("laying out", "bytes", 10, 60, 512, 1500)
STORED: Final = Stage("reading what a client stored", "bytes", 2, 100, 256, 2000)
TABLE: Final = Stage("reading the table", "bytes", 10, 60, 512, 2000)
DRAWING: Final = Stage("reading the drawing", "bytes", 10, 100, 512, 5000)
INSERTING: Final = Stage("inserting blocks", "entities", 10, 300, 512, 4000)
CONTOURS: Final = Stage("joining contours", "curves", 10, 20000, 512, 90000)
AROUND: Final = Stage("finding ways around", "places", 30, 900_000, 1024, 90000)
MEANING: Final = Stage("checking what it does", "points", 10, 150, 512, 2000)
SOLVING: Final = Stage("solving for the arm", "points", 10, 6000, 512, 10000)
TIMING: Final = Stage("timing", "points", 10, 3000, 512, 20000)
COMPILING: Final = Stage("compiling", "points", 30, 15000, 1024, 500000)
ADAPTING: Final = Stage("adapting", "points", 10, 10000, 1024, 500000)
BUILDING: Final = Stage("building", "points", 10, 500, 512, 5000)
PRINTING: Final = Stage("printing", "points", 10, 500, 512, 5000)
TEMPLATE: Final = Stage("filling in the template", "bytes", 5, 60, 256, 2000)
COMPARING: Final = Stage("comparing", "points", 10, 500, 512, 5000)
DRAFTING: Final = Stage("leaving out what cannot be said", "points", 60, 60000, 1024, 500000)
REPORTING: Final = Stage("reporting", "points", 10, 500, 512, 10000)
RUNNING: Final = Stage("running", "statements", 30, 1000, 1024, 5000)

STAGES: Final = (
    *(READING, CHECKING, LIFTING, LAYING_OUT, STORED),
    *(TABLE, DRAWING, INSERTING, CONTOURS, AROUND, MEANING),
    *(
        SOLVING,
        TIMING,
        COMPILING,
        ADAPTING,
        BUILDING,
        PRINTING,
        TEMPLATE,
        COMPARING,
        DRAFTING,
        REPORTING,
    ),
    RUNNING,
)
"""What each needs was measured with inputs of 1,000 to 1,000,000 units; here is 5 to 10 times that.

A point is a statement, a row of a path, or what is declared. Of a run it is the statements that it
may have at most.
"""


def budget_factor() -> float:
    """What all budgets are taken times; raises Refused if the environment states none."""
    stated = os.environ.get(FACTOR_VARIABLE)
    return 1.0 if stated is None else read_budget_factor(stated)


def read_budget_factor(text: str) -> float:
    """A factor as it is written; raises Refused (exit status 2) for what is none."""
    least, most = FACTORS
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not least <= value <= most:
        raise Refused(NO_FACTOR(value=text, least=least, most=most), exit_status=2)
    return value


def most_unpacked() -> int:
    """Bytes that an archive may unpack to."""
    return int(UNPACKED * budget_factor())


class within:  # noqa: N801 (used as a `with` word)
    """What is done inside takes no more than the budget of a stage.

    place: the file. size: of the input, in the stage's unit. Raises Refused where the budget is
    reached, also the memory of the machine, or how deep Python goes and how far its numbers.
    """

    def __init__(self, stage: Stage, place: str | None, size: int) -> None:
        self._stage, self._place, self._size = stage, place, size
        room = min(stage.memory_for(size) * MEGABYTE, PART_OF_MACHINE * installed_memory())
        self._charge = Charge(stage.time_for(size), room)

    def __enter__(self) -> None:
        watch.enter(self._charge)

    def __exit__(
        self,
        kind: type[BaseException] | None,
        raised: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        watch.leave(self._charge)
        if raised is None and self._charge.reached:
            raised = Reached()  # it came where nobody hears it, as in a callback of weakref
        if raised is None or (finding := self._finding(raised)) is None:
            return
        raised.__traceback__ = None  # its frames hold what took the memory
        raise Refused(finding) from None

    def _finding(self, raised: BaseException) -> Diagnostic | None:
        name, place, charge = self._stage.name, self._place, self._charge
        size = f"{self._size:,} {self._stage.unit}"
        if isinstance(raised, Reached) and not charge.reached:
            return None  # of a stage around this one
        if isinstance(raised, Reached) and charge.reached == "time":
            return TIME(path=place, stage=name, seconds=charge.seconds, size=size)
        if isinstance(raised, Reached | MemoryError):
            return MEMORY(path=place, stage=name, megabytes=charge.bytes / MEGABYTE, size=size)
        return overrun(raised, name, place)


P = ParamSpec("P")
R = TypeVar("R")


def staged(stage: Stage, size: Callable[..., int]) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """A function that is a stage. size: of its input, told by the arguments of a call."""

    def bounded(function: Callable[P, R]) -> Callable[P, R]:
        @wraps(function)
        def run(*given: P.args, **named: P.kwargs) -> R:
            with within(stage, None, size(*given, **named)):
                return function(*given, **named)

        return run

    return bounded


def overrun(
    raised: BaseException | None, stage: str, place: str | None = None
) -> Diagnostic | None:
    """The finding for what Python itself has no more of, None for any other exception."""
    if isinstance(raised, RecursionError):
        return TOO_DEEP(path=place, stage=stage)
    if isinstance(raised, OverflowError):
        return TOO_GREAT(path=place, stage=stage, reason=raised)
    if isinstance(raised, MemoryError | Reached):
        return NO_MEMORY(path=place, stage=stage)
    return None
