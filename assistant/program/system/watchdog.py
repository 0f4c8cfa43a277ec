"""Ends what takes more processor time or memory than it was given, in any thread.

A thread of its own looks a few times a second at what is under way: at the processor time of the
threads, so that a busy machine changes nothing, and at the memory of the process. What is beyond
its charge gets `Reached` raised in its thread, between two instructions of Python. One instruction
that takes all memory at once is stopped by the system, where it has a limit of a process's data.
"""

from __future__ import annotations

import contextlib
import os
import sys
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from queue import SimpleQueue
from typing import Any, Final, Literal
from weakref import ReferenceType, ref

PERIOD: Final = 0.05
"""Seconds between two looks."""
REPEAT_AFTER: Final = 1.0
"""Seconds after which what has not ended yet is told once more."""
MOST_TIMES: Final = 5
"""How often one is told: what came in the moment of leaving a stage finds nobody to hear it."""
RESTS: Final = 20
"""Looks at nothing after which the thread waits to be woken."""
RESERVED_MARGIN: Final = 1 << 31
"""Bytes beyond a charge that may be reserved, as libraries do for their threads, but not used."""
MARGIN_PER_PROCESSOR: Final = 1 << 26


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
    """The charges of all threads, those within others behind them.

    A charge counts as long as its stage holds it: one that was told in the moment of leaving its
    stage may never have said that it left.
    """

    def __init__(self) -> None:
        self.forget()

    def forget(self) -> None:
        """As at the begin of a process: a fork has the charges of who forked, but no thread."""
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
        """Ends a charge, and those within it; what it is told from now on does not reach it."""
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
        inner = [one for one in charges[charges.index(charge) :] if one.thread == charge.thread]
        self._entered = [ref(one) for one in charges if one not in inner]
        if any(one.reached for one in inner):
            _cancel(charge.thread)

    def _look(self) -> None:
        idle = 0
        while True:
            with self._lock:
                idle = idle + 1 if self._tell() == 0 else 0
                self._resting = idle > RESTS
            if self._resting:
                self._woken.get()
                idle = 0
            else:
                time.sleep(PERIOD)

    def _tell(self) -> int:
        """Looks at each charge and returns how many there are."""
        charges = self.entered()
        if not charges:
            self._limit_data()
            return 0
        now, (resident, _) = time.monotonic(), memory_in_use()
        worst: Charge | None = None
        for one in charges:
            if (one.times and now - one.told < REPEAT_AFTER) or one.times >= MOST_TIMES:
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
            least: dict[int, float] = {}
            for one in charges:
                room = (
                    one.data
                    + one.bytes
                    + RESERVED_MARGIN
                    + MARGIN_PER_PROCESSOR * (os.cpu_count() or 1)
                )
                least[one.thread] = min(room, least.get(one.thread, room))
            wanted = int(max(least.values()))
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
    """Bytes that the process has in the memory of the machine, and those of its data in all.

    Where the system does not tell: the most there ever were, and 0.
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


def _cancel(thread: int) -> None:
    import ctypes

    ctypes.pythonapi.PyThreadState_SetAsyncExc(ctypes.c_ulong(thread), None)


_QUIET: Final[list[Callable[[Any], object]]] = []


def _unheard(told: Any) -> None:
    """In place of Python's own hook: what is told in a callback is told again, and not printed."""
    if told.exc_type is not Reached:
        _QUIET[0](told)


watch: Final = Watchdog()
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=watch.forget)
