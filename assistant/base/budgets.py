"""Budgets: limits on the bytes read from a file, and on a stage's time and memory for its input.

A stage is entered with the size of its input:

    with within(READING, path, size=len(text)):
        tree = parse(text)

A stage that takes more processor time or memory than `STAGES` states for that size ends in
`Refused`, with a finding, and so does one whose input is nested too deeply or has a number that is
too large.

A watchdog thread checks the running stages a few times a second: the processor time of the threads,
so that a busy machine changes nothing, and the memory of the process. It raises `Reached` in the
thread of a charge that is exceeded, between two instructions of Python. One instruction that takes
all memory at once is stopped by the system, where that limits the data of a process.

Also here: the finding for an internal error, and work without the cycle collector.
"""

from __future__ import annotations

import contextlib
import gc
import math
import os
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache, wraps
from queue import SimpleQueue
from types import TracebackType
from typing import Any, Final, Literal, ParamSpec, TypeVar
from weakref import ReferenceType, ref

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused, error

_PERIOD: Final = 0.05
"""Seconds between two looks."""
_REPEAT_AFTER: Final = 1.0
"""Seconds after which the watchdog raises `Reached` again in a stage that has not ended."""
_MOST_TIMES: Final = 5
"""Most times to raise `Reached` for one charge: one raised as a stage is left reaches no code."""
_RESTS: Final = 20
"""Looks at nothing after which the thread waits to be woken."""
_RESERVED_MARGIN: Final = (1 << 31) + (1 << 26) * (os.cpu_count() or 1)
"""Bytes beyond a charge that may be reserved, as libraries do for their threads, but not used."""


class Reached(BaseException):
    """A charge is used up. No `Exception`: what tries and goes on must not go on with it."""


@dataclass(slots=True, eq=False, weakref_slot=True)
class Charge:
    """Seconds of processor time and bytes of memory from now on.

    reached: which of them is used up.
    """

    seconds: float
    bytes: float
    reached: Literal["", "time", "memory"] = ""
    thread: int = 0
    clock: Callable[[], float] = time.process_time
    began: float = 0.0
    resident: float = 0.0
    data: float = 0.0
    told: float = 0.0
    times: int = 0


class Watchdog:
    """The charges of all threads; an inner charge follows those around it.

    A charge counts as long as its stage holds it: a stage in which `Reached` was raised as it was
    left may never have reported that it left.
    """

    def __init__(self) -> None:
        self.forget()

    def forget(self) -> None:
        """Reset to the start of a process: a fork has the charges of its parent, but no thread."""
        # Both are entered and left in one instruction: written in Python, as a Condition is, they
        # could be told halfway, and nobody would ever release them.
        self._lock = threading.Lock()
        self._woken: SimpleQueue[None] = SimpleQueue()
        self._entered: list[ReferenceType[Charge]] = []
        self._thread: threading.Thread | None = None
        self._resting = False
        self._before: tuple[int, int] | None = None

    def enter(self, charge: Charge) -> None:
        charge.thread = threading.get_ident()
        charge.clock = _clock(charge.thread)
        charge.began = charge.clock()
        charge.resident, charge.data = memory_in_use()
        with self._lock:
            self._entered.append(ref(charge))
            self._limit_data()
            if self._thread is None or not self._thread.is_alive():
                self._thread = threading.Thread(target=self._look, name="budgets", daemon=True)
                self._thread.start()
            elif self._resting:
                self._resting = False
                self._woken.put(None)

    def leave(self, charge: Charge) -> None:
        """End a charge, and those within it; `Reached` that is raised later does not reach it."""
        while True:
            try:
                with self._lock:
                    self._drop(charge)
                    self._limit_data()
            except Reached:
                continue  # it came while leaving
            else:
                return

    def entered(self) -> list[Charge]:
        """The charges that count now."""
        self._entered = [one for one in self._entered if one() is not None]
        return [charge for one in self._entered if (charge := one()) is not None]

    def _drop(self, charge: Charge) -> None:
        charges = self.entered()
        if charge not in charges:
            return
        # `Reached` may have kept inner stages from leaving: their charges end with this one.
        inner = [one for one in charges[charges.index(charge) :] if one.thread == charge.thread]
        self._entered = [ref(one) for one in charges if one not in inner]
        # Python delivers the exception later: one that is still pending must not hit the next
        # stage.
        if any(one.reached for one in inner):
            _cancel(charge.thread)

    def _look(self) -> None:
        idle = 0
        while True:
            with self._lock:
                idle = idle + 1 if self._tell() == 0 else 0
                self._resting = idle > _RESTS
            if self._resting:
                self._woken.get()
                idle = 0
            else:
                time.sleep(_PERIOD)

    def _tell(self) -> int:
        """Looks at each charge and returns how many there are."""
        charges = self.entered()
        if not charges:
            # Charges may be collected without being left: the limit of the process ends with them.
            self._limit_data()
            return 0
        now, (resident, _) = time.monotonic(), memory_in_use()
        worst: Charge | None = None
        for one in charges:
            if (one.times and now - one.told < _REPEAT_AFTER) or one.times >= _MOST_TIMES:
                continue
            with contextlib.suppress(OSError):  # a thread that has ended
                if one.clock() - one.began > one.seconds:
                    _raise(one, "time", now)
                    continue
            over = resident - one.resident - one.bytes
            if over > 0 and (worst is None or over > worst.resident + worst.bytes):
                worst = one
        if worst is not None:
            _raise(worst, "memory", now)
        return len(charges)

    def _limit_data(self) -> None:
        """The system refuses what no charge has room for; without charges all is as it was."""
        if not sys.platform.startswith("linux"):
            return  # elsewhere the limit is another one, or none
        import resource

        charges = self.entered()
        if self._before is None:
            if not charges:
                return
            self._before = resource.getrlimit(resource.RLIMIT_DATA)
        soft, hard = self._before
        if charges:
            # The process has one limit: the smallest room of each thread, and the largest of these.
            least: dict[int, float] = {}
            for one in charges:
                room = one.data + one.bytes + _RESERVED_MARGIN
                least[one.thread] = min(room, least.get(one.thread, room))
            wanted = int(max(least.values()))
            # Never above the limit that the process had before.
            for known in (soft, hard):
                wanted = wanted if known == resource.RLIM_INFINITY else min(wanted, known)
            resource.setrlimit(resource.RLIMIT_DATA, (wanted, hard))
        else:
            resource.setrlimit(resource.RLIMIT_DATA, self._before)
            self._before = None


def _clock(thread: int) -> Callable[[], float]:
    """Processor seconds of a thread, of the whole process where the system tells no other."""
    if hasattr(time, "pthread_getcpuclockid"):
        number = time.pthread_getcpuclockid(thread)
        return lambda: time.clock_gettime(number)
    return time.process_time


def memory_in_use() -> tuple[float, float]:
    """Return the bytes of the process in the machine's memory, and the bytes of all its data.

    On systems that do not report these: the highest memory use so far, and 0.
    """
    if sys.platform.startswith("linux"):
        number = os.open("/proc/self/statm", os.O_RDONLY)  # see proc(5): in pages
        try:
            pages = os.read(number, 256).split()
        finally:
            os.close(number)
        return int(pages[1]) * _PAGE, int(pages[5]) * _PAGE
    if sys.platform == "win32":
        return _working_set(), 0.0
    import resource

    unit = 1 if sys.platform == "darwin" else 1024  # getrusage(2): of each system
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit, 0.0


@cache
def installed_memory() -> float:
    """Bytes of memory that the machine has, infinite where the system does not tell."""
    try:
        return float(os.sysconf("SC_PHYS_PAGES")) * _PAGE
    except (AttributeError, ValueError, OSError):
        return float("inf")


_PAGE: Final = 4096 if sys.platform == "win32" else os.sysconf("SC_PAGE_SIZE")


def _working_set() -> float:
    """`WorkingSetSize` of PROCESS_MEMORY_COUNTERS, as Windows' psapi.h lays it out."""
    import ctypes

    counters = (ctypes.c_size_t * 10)()  # two words of 32 bits first, then sizes
    windows = getattr(ctypes, "windll")  # noqa: B009 - there alone
    windows.kernel32.GetCurrentProcess.restype = ctypes.c_void_p
    process = ctypes.c_void_p(windows.kernel32.GetCurrentProcess())
    size = ctypes.sizeof(counters)
    known = windows.kernel32.K32GetProcessMemoryInfo(process, ctypes.byref(counters), size)
    return float(counters[2]) if known else 0.0


def _raise(charge: Charge, what: Literal["time", "memory"], now: float) -> None:
    import ctypes

    if not _QUIET:
        _QUIET.append(sys.unraisablehook)
        sys.unraisablehook = _unheard
    charge.reached, charge.told, charge.times = what, now, charge.times + 1
    kind = ctypes.py_object(Reached)
    ctypes.pythonapi.PyThreadState_SetAsyncExc(ctypes.c_ulong(charge.thread), kind)


class _Cancelled(BaseException):
    """Takes the place of a `Reached` that is pending."""


def _cancel(thread: int) -> None:
    """Leave no `Reached` pending in a thread."""
    import ctypes

    raise_in = ctypes.pythonapi.PyThreadState_SetAsyncExc
    if thread != threading.get_ident():
        raise_in(ctypes.c_ulong(thread), None)
        return
    # CPython 3.11 clears its mark of a pending exception only as it raises one. With the mark set
    # and nothing pending, a profiler makes it look again for ever.
    with contextlib.suppress(_Cancelled):
        raise_in(ctypes.c_ulong(thread), ctypes.py_object(_Cancelled))
        while True:
            time.sleep(0)


_QUIET: Final[list[Callable[[Any], object]]] = []


def _unheard(told: Any) -> None:
    """In place of Python's own hook: ignore `Reached` in a callback, as it is raised again."""
    if told.exc_type is not Reached:
        _QUIET[0](told)


watch: Final = Watchdog()
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=watch.forget)


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
_TOO_DEEP: Final = error(
    "LM003",
    "{stage} meets what is nested too deeply to be followed",
    "take the inner parts out: parentheses, blocks, calls or tables in each other",
)
_TOO_GREAT: Final = error(
    "LM004",
    "{stage} meets a number that is too large to calculate with ({reason})",
    "write a number that a robot can have",
)
_NO_MEMORY: Final = error(
    "LM005",
    "there is not enough memory for {stage}",
    "close other programs, or split the input",
)
_NO_FACTOR: Final = error(
    "LM006",
    "`{value}` is no factor for budgets",
    "give a number from {least:g} to {most:g}, such as 10",
)

FACTOR_VARIABLE: Final = "ROBOT_ASSISTANT_BUDGET"
"""Environment variable with the factor by which all budgets and sizes are multiplied."""
FACTORS: Final = (0.001, 1e6)

MEGABYTE: Final = 1_000_000
FILE: Final = 256 * MEGABYTE
"""Bytes of a file that are read: a program, table, drawing, side table or archive."""
SETTINGS_FILE: Final = 16 * MEGABYTE
"""The same of one that people write: of a process, a robot, a project, a script."""
UNPACKED: Final = 1024 * MEGABYTE
"""Bytes that an archive may unpack to: 10,000,000 poses of 13 columns."""


PART_OF_MACHINE: Final = 0.8
"""Fraction of the machine's memory that one stage may take."""


@dataclass(frozen=True, slots=True)
class Stage:
    """Budget of a stage: a fixed part, and one for each million units of its input.

    unit: unit in which its input is counted. seconds: of processor time. megabytes: of memory that
    the process has more than before.
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
"""Budgets of all stages: 5 to 10 times the needs measured with inputs of 1,000 to 1,000,000 units.

A point is a statement, a row of a path, or a declaration. The size of a run is the number of
statements that it may have at most.
"""


def budget_factor() -> float:
    """Return the factor of all budgets; raises Refused if the environment states an invalid one."""
    stated = os.environ.get(FACTOR_VARIABLE)
    return 1.0 if stated is None else read_budget_factor(stated)


def read_budget_factor(text: str) -> float:
    """Read a budget factor from text; raises Refused (exit status 2) for an invalid one."""
    least, most = FACTORS
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not least <= value <= most:
        raise Refused(_NO_FACTOR(value=text, least=least, most=most), exit_status=2)
    return value


def most_unpacked() -> int:
    """Bytes that an archive may unpack to."""
    return int(UNPACKED * budget_factor())


class within:  # noqa: N801 (used as a `with` word)
    """Limit the work in the block to the budget of a stage.

    place: the file. size: of the input, in the stage's unit. Raises Refused where the work reaches
    the budget, the memory of the machine, or Python's limits on nesting and on numbers.
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
    """Make a function a stage. size: returns the size of its input from the arguments of a call."""

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
        return _TOO_DEEP(path=place, stage=stage)
    if isinstance(raised, OverflowError):
        return _TOO_GREAT(path=place, stage=stage, reason=raised)
    if isinstance(raised, MemoryError | Reached):
        return _NO_MEMORY(path=place, stage=stage)
    return None


INTERNAL_ERROR: Final = error(
    "CL900",
    "robot-assistant itself failed: {kind}: {error}",
    "nothing of it was written; set ROBOT_ASSISTANT_TRACEBACK=1 for the details of a report",
)


def traceback_wanted() -> bool:
    """True if an internal error is raised itself, for a report on it."""
    return bool(os.environ.get("ROBOT_ASSISTANT_TRACEBACK"))


def internal_error(error: BaseException) -> Diagnostic:
    """The finding that stands for an error: ours, or of what the machine has no more of."""
    return overrun(error, "the command") or INTERNAL_ERROR(kind=type(error).__name__, error=error)


@contextmanager
def without_gc() -> Iterator[None]:
    """Keeps the cycle collector still: it would look through a growing tree again and again.

    Without this the time to read a text of n lines grows faster than n.
    """
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            gc.enable()


def freeze_loaded_objects() -> None:
    """Exempt all present objects from the cycle collector: tables, grammars, complete programs.

    The collector would search all of them again and again in the middle of an answer. For processes
    that keep answering, and that own what they have loaded.
    """
    gc.collect()
    gc.freeze()
