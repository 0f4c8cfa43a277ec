"""The controller that a studio is connected to: all that it is asked goes through one thread."""

from __future__ import annotations

import threading
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, suppress
from dataclasses import replace
from functools import partial
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Final, TypeVar

from assistant.base.budgets import internal_error
from assistant.base.diagnostics import Diagnostic, Refused
from assistant.controllers import Controller, Named, Programs, connect
from assistant.controllers import rules as controller_rules
from assistant.controllers.arm_stop import PATIENCE, Rest, brought_to_rest, stop_at_once, stopped
from assistant.controllers.rules import Lost
from assistant.controllers.states import Identity, Sample, record
from assistant.studio import rules
from assistant.studio.answering import finding_records, plain_value
from assistant.studio.windows import Notify

if TYPE_CHECKING:
    from assistant.robots import Robot

CONTROLLER_PERIOD: Final = 0.4
"""Seconds between two looks at a controller."""
CLOSE_TIMEOUT: Final = 15.0
"""Seconds that what still goes on has to come to its end."""
T = TypeVar("T")


class Connection:
    """Opens a session with a controller of a project, and tells windows what it sees there.

    one: of the project. kept: folder in which a virtual one of the project is kept. password: for
    the sessions of this connection only; None for what environment or keyring hold. tell: told
    what is seen, from another thread. lost: called when there is no session any more. Raises
    Refused.

    Sessions know one thread only, and so does a virtual controller, so `do` is the way to them.
    """

    def __init__(
        self,
        one: Named,
        kept: FilePath,
        tell: Notify,
        lost: Callable[[], None],
        password: str | None = None,
    ) -> None:
        from assistant.compiler.arms import robot_of

        self.one = one
        self.robot: Robot | None = robot_of(one.robot)
        self.identity = Identity()
        self.signals: tuple[str, ...] = ()
        self._kept, self._tell, self._lost = kept, tell, lost
        self._clients: Callable[[], Programs] = partial(connect, one, password=password)
        self._quick: Callable[[], Programs] = partial(self._clients, timeout=PATIENCE)
        self._open = ExitStack()
        self._looks: Iterator[Sample] | None = None
        self._ended = threading.Event()
        self._worker = ThreadPoolExecutor(1, thread_name_prefix="controller")
        try:
            self.session: Programs = self._worker.submit(self._begin).result()
        except BaseException:
            self.end()
            raise
        self._watcher = threading.Thread(target=self._watch, name="monitor", daemon=True)
        if isinstance(self.session, Controller):
            self._watcher.start()

    def _begin(self) -> Programs:
        if self.one.virtual is not None:
            from assistant.project.virtual import running_clients

            self._clients = self._quick = self._open.enter_context(
                running_clients(self.one, self._kept)
            )
        session = self._open.enter_context(self._clients())
        if isinstance(session, Controller):
            self.identity = session.identify()
        return session

    @property
    def operates(self) -> bool:
        """Whether it can be looked at and operated, beside the programs that it keeps."""
        return isinstance(self.session, Controller)

    def quick(self) -> Programs:
        """Another session, not connected yet, which any thread may open, and that waits shortly."""
        return self._quick()

    def do(self, does: Callable[[Controller], T]) -> T:
        """What is done with the session, after all that was asked before; raises Refused."""
        if not isinstance(self.session, Controller):
            raise Refused(self._only_keeps())
        return self.kept(lambda session: does(session))  # type: ignore[arg-type]

    def kept(self, does: Callable[[Programs], T]) -> T:
        """The same of a controller of which only the programs are wanted."""

        def in_turn() -> T:
            if self._ended.is_set():
                raise Refused(rules.NOT_CONNECTED())
            return does(self.session)

        try:
            asked = self._worker.submit(in_turn)
        except RuntimeError:  # it was left meanwhile
            raise Refused(rules.NOT_CONNECTED()) from None
        try:
            return asked.result()
        except Lost as lost:
            self._gone(lost.findings)
            raise

    def apart(self, does: Callable[[Programs], T]) -> T:
        """What opens a session by itself, with ours: many controllers have no line for another."""

        def done(session: Programs) -> T:
            self._end_looks()
            session.__exit__(None, None, None)
            try:
                return does(session)
            finally:
                self._back(session)

        return self.kept(done)

    def stop(self) -> Rest:
        """Stops the arm and all programs; where no line is free for that, after what goes on."""
        done = threading.Event()

        def in_turn() -> None:
            if not done.is_set():
                stop_at_once(self.session)

        with suppress(RuntimeError):  # it was left meanwhile
            self._worker.submit(in_turn)
        rest = brought_to_rest(self.quick)
        if rest.state is not None:
            done.set()
            return rest
        return self.kept(stopped)

    def look_at(self, signals: Sequence[str]) -> None:
        """Signals whose values are told from now on; raises Refused if there are none such."""
        wanted = tuple(signals)

        def look(controller: Controller) -> None:
            looks = controller.watch(0.0, wanted)
            next(looks)
            self._looks, self.signals = looks, wanted

        self.do(look)

    def end(self) -> None:
        """Leaves the controller; a virtual one of the project ends."""
        if self._ended.is_set():
            return
        self._ended.set()
        self._worker.submit(self._leave)
        self._worker.shutdown(wait=False)
        watcher = getattr(self, "_watcher", None)
        if watcher is not None and watcher.is_alive() and watcher is not threading.current_thread():
            watcher.join(CLOSE_TIMEOUT)

    def _leave(self) -> None:
        with self._open:
            self._end_looks()

    def _end_looks(self) -> None:
        looks, self._looks = self._looks, None
        if isinstance(looks, Generator):
            looks.close()

    def _back(self, session: Programs) -> None:
        try:
            session.__enter__()
        except Refused as refused:  # what was done meanwhile is told all the same
            self._gone(refused.findings)

    def _watch(self) -> None:
        while not self._ended.wait(CONTROLLER_PERIOD):
            try:
                sample = self.do(self._look)
            except Refused as refused:
                self._tell({"kind": "monitor", "findings": finding_records(refused.findings)})
            except Exception as wrong:  # noqa: BLE001 - who watches goes on
                self._tell(
                    {"kind": "monitor", "findings": finding_records([internal_error(wrong)])}
                )
            else:
                self._tell({"kind": "monitor", **_sample_record(sample)})

    def _look(self, controller: Controller) -> Sample:
        try:
            if self._looks is None:
                self._looks = controller.watch(0.0, self.signals)
            return next(self._looks)
        except BaseException:
            self._looks = None  # which has ended by that
            raise

    def _gone(self, found: Sequence[Diagnostic]) -> None:
        if not self._ended.is_set():
            threading.Thread(target=self._lost, name="lost", daemon=True).start()
            self._tell({"kind": "monitor", "lost": True, "findings": finding_records(found)})

    def _only_keeps(self) -> Diagnostic:
        place = str(self.one.address)
        return controller_rules.NOT_HERE(
            place=place,
            address=place,
            what="be operated",
            reason="its protocol keeps programs and no more",
            cure="name an address by which the controller is operated",
        )


def _sample_record(sample: Sample) -> Mapping[str, object]:
    """A sample as data, in which a number that is none is left out."""
    state = replace(sample.state, faults=sample.state.faults[:20])
    found = record(replace(sample, state=state))
    assert isinstance(found, dict)
    return {key: plain_value(value) for key, value in found.items()}
