"""A task: one program that runs beside others as a coroutine, and what can be seen of it.

A `Level` is a call that runs, with its data, for a debugger that looks at a held task.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING

from greenlet import greenlet

from assistant.base.budgets import internal_error, traceback_wanted
from assistant.base.data_classes import dataclass
from assistant.virtual.events import Event, OnWay, Place, Switched, Waited, Why

if TYPE_CHECKING:
    from assistant.virtual.kernel.kernel import Kernel


@dataclass(frozen=True, slots=True)
class Shown:
    """A piece of data. value: as the language writes it. parts: its components or elements."""

    name: str
    value: str
    type: str = ""
    parts: Callable[[], Sequence[Shown]] | None = None


@dataclass(frozen=True, slots=True)
class Level:
    """A call that runs. groups: data by scope, evaluated on request."""

    name: str
    place: Place | None
    groups: Mapping[str, Callable[[], Sequence[Shown]]]


@dataclass(frozen=True, slots=True)
class Ending:
    """End of a task; see `Run`. place: its source location, None for its present one."""

    ended: Why = "end"
    message: str = ""
    place: Place | None = None


class Broken(Exception):
    """End of a task for a reason outside its program, as a motion that cannot be made."""

    def __init__(self, ending: Ending) -> None:
        super().__init__(ending.message)
        self.ending = ending


Body = Callable[["Task"], Ending]


class Task:
    """A task of a kernel. name: as in the log and in messages. body: runs the program to its end.

    lines: statements until the next task has its turn. essential: whether the run continues until
    it ends; others end with the last of those. where: returns the source location of the current
    statement. levels: returns the calls that run, the innermost first. closed: interrupts wait
    while it is above 0. looks: checks before each statement, and while one waits, whether an
    interrupt is due. sampling: seconds between checks of a wait, None if only an event may end it.
    ended: None while it runs.
    """

    def __init__(
        self, kernel: Kernel, name: str, body: Body, lines: int = 1, essential: bool = True
    ) -> None:
        self.kernel, self.name, self.body = kernel, name, body
        self.lines, self.essential = lines, essential
        self.where: Callable[[], Place | None] = lambda: None
        self.levels: Callable[[], Sequence[Level]] = lambda: ()
        self.closed = 0
        self.looks: Callable[[], None] | None = None
        self.sampling: float | None = None
        self.ended: Ending | None = None
        # Made at once, started by its first turn: a task may be looked at before.
        self.coroutine = greenlet(self._run, kernel.hub)
        self.waits_for = ""
        self.outside = False
        self.until: Callable[[], bool] | None = None
        self.wakes = -math.inf
        self.waiting = False
        self._posted: deque[Callable[[], None]] = deque()
        self._left = lines

    # ---------------------------------------------------------------- what a language says

    def step(self) -> None:
        """A statement is about to run. Interrupts come between statements."""
        kernel = self.kernel
        kernel.count(self)
        if self.looks is not None:
            self.looks()
        self.interrupted()
        self._left -= 1
        if self._left <= 0:
            self._left = self.lines
            # A single task need not give its turn away, which costs two switches of coroutine.
            if kernel.shared:
                self._pause()

    def prompt(self) -> None:
        """Before it begins: its first statements run in its first turn."""
        self._left = self.lines + 1

    def tell(self, event: Event) -> None:
        """Something happens to the world."""
        self.kernel.tell(self, event)

    def switch(
        self, signal: str, value: float, at: OnWay | None = None, after: float | None = None
    ) -> None:
        """Sets an output. at: where on the way of the motion before; None for here."""
        self.kernel.tell(self, Switched(signal, value, at, after))
        self.kernel.board.outputs.set(signal, value)

    def delay(self, seconds: float) -> None:
        """Waits for a time that the program states."""
        self.tell(Waited(seconds))
        self.wait(None, seconds)

    def wait(
        self,
        until: Callable[[], bool] | None,
        seconds: float | None = None,
        what: str = "",
        outside: bool = False,
    ) -> bool:
        """Waits until a condition holds, for some seconds at most; False if it did not come to.

        what: what is waited for, for the message if it never can come. outside: it may come from
        outside of the run, so that simulated time passes as real time does. Interrupts come
        meanwhile.
        """
        end = math.inf if seconds is None else self.kernel.now + seconds
        # `stirred` keeps time from passing in this round; the wait is due for a check at once.
        self.kernel.stirred, self.wakes = True, -math.inf
        while True:
            # Interrupts may change what is waited for: they come before the check.
            self.interrupted()
            if self.looks is not None:
                self.looks()
            if until is not None and until():
                self.met(until)
                return True
            if self.kernel.now >= end:
                return False
            self.waiting, self.waits_for = True, what
            self.wakes = end if self.sampling is None else self._sample(end)
            self.outside = outside
            self.until = until
            self._pause()
            self.waiting = self.outside = False

    def met(self, until: Callable[[], bool]) -> None:
        """Report a wait that its condition has ended."""
        if self.kernel.met is not None:
            self.kernel.met(self, until)

    def looked(self, since: float, *, over: bool) -> None:
        """Report one check of a wait for a timer. since: when the wait began."""
        if self.kernel.looked is not None:
            self.kernel.looked(self, since, over)

    # ------------------------------------------------------------------------- interrupts

    def _sample(self, end: float) -> float:
        """Return when to check a wait again that only time may interrupt; it counts as a
        statement.
        """
        # A check that is still to come is not counted anew.
        if self.wakes > self.kernel.now:
            return min(end, self.wakes)
        self.kernel.spend()
        return min(end, self.kernel.now + (self.sampling or 0.0))

    def post(self, action: Callable[[], None]) -> None:
        """Runs an action in the task before its next statement, or while it waits."""
        self._posted.append(action)

    def interrupted(self) -> None:
        """Answers what has come between two statements, or with a motion."""
        while self._posted and not self.closed:
            self.kernel.stirred = True
            self._posted.popleft()()

    # ------------------------------------------------------------------------- coroutine

    def _pause(self) -> None:
        """Until the kernel gives the task its next turn."""
        self.kernel.hub.switch()

    def _run(self) -> None:
        try:
            self.ended = self.body(self)
        except Broken as broken:
            self.ended = broken.ending
        except Exception as error:
            # Nobody's program may take the whole controller down with it.
            # A program that breaks the interpreter ends alone in a controller that lives on.
            if self.kernel.live is None or traceback_wanted():
                raise
            self.ended = Ending("unknown", internal_error(error).message)

    def kill(self) -> None:
        """Ends it where it is."""
        # greenlet ends a coroutine by raising GreenletExit in it.
        if self.coroutine and not self.coroutine.dead:
            self.coroutine.throw()
