"""Connections that the blocks of a model share: opened for the first block, closed after the last.

cell = asked("cell", "melfa://192.168.0.20")
gripper = diagram.add(Gripper("gripper", cell, Hand(1)))

`operated` moves the arm of a CR controller statement by statement; `asked` reads and sets signals.
Both answer from a thread, so no step of a model waits for a controller.
"""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import AbstractContextManager, contextmanager, suppress
from typing import Final, Generic, TypeVar

from assistant.base.diagnostics import Refused
from assistant.blocks.diagrams import closing_all
from assistant.blocks.rules import NO_STATEMENTS, NOT_OPERATED
from assistant.controllers import connect
from assistant.controllers.controller import Controller
from assistant.controllers.mitsubishi.arm_moves import Goal
from assistant.controllers.mitsubishi.cr import Cr
from assistant.controllers.rules import Lost
from assistant.controllers.states import Position

T_co = TypeVar("T_co", covariant=True)
_StatementJob = tuple[Sequence[str], Goal, Future[Position]]

STOP_TIMEOUT: Final = 10.0
"""Seconds that a statement has to come to its end once the arm was stopped."""


class Connection(Generic[T_co]):
    """Named connection that any number of blocks share; another robot has another one.

    opening: returns a context manager, entered when the first block begins and left when the last
    one ends. moves: whether blocks move an arm by it; then a run must receive its name as
    confirmed.
    """

    def __init__(
        self, name: str, opening: Callable[[], AbstractContextManager[T_co]], *, moves: bool = False
    ) -> None:
        self.name, self.moves = name, moves
        self._opening = opening
        self._users = 0
        self._context: AbstractContextManager[T_co] | None = None
        self._value: T_co | None = None

    @property
    def users(self) -> int:
        """Blocks that use it now."""
        return self._users

    @property
    def value(self) -> T_co | None:
        """Return the connected object, None while no block uses it."""
        return self._value

    def take(self) -> T_co:
        """Return the connected object to one more block; raises what opening it raises."""
        if self._context is None:
            context = self._opening()
            self._value = context.__enter__()
            self._context = context
        self._users += 1
        assert self._value is not None
        return self._value

    def leave(self) -> None:
        """One block less; it is closed after the last."""
        self._users -= 1
        if self._users == 0 and self._context is not None:
            context, self._context, self._value = self._context, None, None
            context.__exit__(None, None, None)


class Operator:
    """Executor of statements on a CR controller, one after the other, without waiting for them.

    Closing it stops a running statement: over a separate connection, or over the same one on a
    serial line, which has room for one only.
    """

    def __init__(self, session: Cr) -> None:
        self.session = session
        self._alone = session.address.port == 0
        self._held = True
        self._jobs: queue.SimpleQueue[_StatementJob | None] = queue.SimpleQueue()
        self._open: Future[Position] | None = None
        self._asking = False
        self._lost = False
        """True if the last statement got no answer: the arm may keep moving."""
        self._thread = threading.Thread(target=self._run, name="operator", daemon=True)
        self._thread.start()

    def position(self) -> Position:
        """Return the position of the arm; only while no statement runs."""
        return self.session.position()

    @property
    def busy(self) -> bool:
        """True if statements of any block are running."""
        return self._open is not None and not self._open.done()

    def settled(self, executing: Callable[[], bool]) -> bool:
        """True if nothing is in transit between this and the controller, which runs in lock step.

        executing: returns whether the controller has a running statement while its time is stopped.
        """
        return not self.busy or (self._asking and executing())

    def carry_out(self, statements: Sequence[str], goal: Goal) -> Future[Position]:
        """Begins with statements; what comes of it is where the arm stands then.

        goal: where the last one, which moves the arm, brings it.
        """
        assert not self.busy, "one block at a time moves an arm"
        self._open = Future()
        self._jobs.put((statements, goal, self._open))
        return self._open

    def close(self) -> None:
        """Stops what is under way or may be, and ends."""
        try:
            if self.busy:
                self._stop()
            elif self._lost:
                self.session.stop()
        finally:
            self._jobs.put(None)
            self._thread.join(STOP_TIMEOUT)

    def _stop(self) -> None:
        assert self._open is not None
        self._held = False
        if not self._alone:
            other = connect(self.session.address)
            assert isinstance(other, Controller)
            with other:
                other.stop()
        with suppress(Refused, TimeoutError):  # what ended it was this stop
            self._open.result(STOP_TIMEOUT)

    def _run(self) -> None:
        while (job := self._jobs.get()) is not None:
            statements, goal, done = job
            try:
                with self.session.scratch() as task:
                    for number, statement in enumerate(statements, 1):
                        self._asking = True
                        if self._alone and number == len(statements):
                            self.session.execute_while(statement, goal, lambda: self._held, task)
                        else:
                            self.session.execute(statement, wait=True, task=task)
                        self._asking = False
                done.set_result(self.session.position())
            except Exception as error:  # noqa: BLE001 - it is the block's, which raises it
                self._asking = False
                self._lost = isinstance(error, Lost)
                done.set_exception(error)


def operated(
    name: str, address: str, *, override: int = 10, servo: bool = True, timeout: float = 60.0
) -> Connection[Operator]:
    """A CR controller whose arm blocks move statement by statement, over its controller link.

    address: of the controller, or its name in the project. override: percent of the speed
    meanwhile. servo: whether the servos are switched on before and off after. timeout: seconds of
    the longest move.
    """

    @contextmanager
    def opening() -> Iterator[Operator]:
        session = connect(address, timeout=timeout)
        if not isinstance(session, Cr):
            raise Refused(NO_STATEMENTS(name=name, address=session.address), exit_status=2)
        with session, closing_all() as last:
            last.callback(session.set_override, session.state().override or override)
            session.set_override(override)
            if servo:
                last.callback(session.motors, False)
                session.motors(True)
            operator = Operator(session)
            last.callback(operator.close)
            yield operator

    return Connection(name, opening, moves=True)


S = TypeVar("S")
T = TypeVar("T")


class Asked(Generic[S]):
    """Session that is used in a separate thread, one question after the other."""

    def __init__(self, session: S) -> None:
        self.session = session
        self._worker = ThreadPoolExecutor(1, thread_name_prefix="asked")
        self._open: list[Future[object]] = []

    @property
    def busy(self) -> bool:
        """True if an answer is still due."""
        self._open = [one for one in self._open if not one.done()]
        return bool(self._open)

    def settled(self, executing: Callable[[], bool]) -> bool:
        """True if nothing is in transit; see `Operator.settled`."""
        return not self.busy or executing()

    def ask(self, question: Callable[[S], T]) -> Future[T]:
        """Queue a question and return the future of its result."""
        given: Future[T] = self._worker.submit(question, self.session)
        self._open.append(given)  # type: ignore[arg-type]  # only whether it is done is asked
        return given

    def close(self) -> None:
        """Waits for the answer that is on its way; what was not asked by then never is."""
        self._worker.shutdown(cancel_futures=True)


def asked(
    name: str, address: str, *, password: str | None = None, timeout: float | None = None
) -> Connection[Asked[Controller]]:
    """A controller whose signals blocks read and set.

    address: of the controller, or its name in the project. password: None for that of the
    environment. timeout: seconds to wait for an answer.
    """

    @contextmanager
    def opening() -> Iterator[Asked[Controller]]:
        session = connect(address, password=password, timeout=timeout)
        if not isinstance(session, Controller):
            raise Refused(NOT_OPERATED(name=name, address=session.address), exit_status=2)
        with session:
            asking = Asked[Controller](session)
            try:
                yield asking
            finally:
                asking.close()

    return Connection(name, opening, moves=True)
