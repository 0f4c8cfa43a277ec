"""What is asked of a controller while a model goes on: nobody waits for the answers.

cell = asked("cell", "melfa://192.168.0.20")
gripper = diagram.add(Gripper("gripper", cell, Hand(1)))
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from typing import Generic, TypeVar

from assistant.base.diagnostics import Refused
from assistant.blocks.connections import Connection
from assistant.blocks.library.rules import NOT_OPERATED
from assistant.controllers import connect
from assistant.controllers.controller import Controller

S = TypeVar("S")
T = TypeVar("T")


class Asked(Generic[S]):
    """A session that is used in a thread of its own, one question after the other."""

    def __init__(self, session: S) -> None:
        self.session = session
        self._worker = ThreadPoolExecutor(1, thread_name_prefix="asked")
        self._open: list[Future[object]] = []

    @property
    def busy(self) -> bool:
        """Whether an answer is still to come."""
        self._open = [one for one in self._open if not one.done()]
        return bool(self._open)

    def settled(self, executing: Callable[[], bool]) -> bool:
        """Whether nothing is on its way; see `Operator.settled`."""
        return not self.busy or executing()

    def ask(self, question: Callable[[S], T]) -> Future[T]:
        """What comes of a question, once it is its turn."""
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
