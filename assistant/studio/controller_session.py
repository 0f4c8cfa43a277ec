"""The connected controller, and control of its arm by a held key.

All requests to the controller go through one thread. A window that has control is sent a tick every
`_TICK` seconds and answers each with a beat, which names the tick and whether the key is held. So a
beat tells when the window was there, however late it comes: after `WATCH` seconds without a fresh
one the arm is stopped, and the key has to be released before anything moves again. A step is a jog
to a near position, at which the arm stops anyway: it goes no further even if this process dies.

beat: {"kind": "beat", "tick": 17, "hold": 3, "axis": "J1", "by": -1, "frame": "base", "speed": 10}
hold: a number that grows with each press of the key, 0 while it is not held.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, suppress
from dataclasses import replace
from functools import partial
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any, Final, TypeVar

from assistant.base.budgets import internal_error
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused
from assistant.compiler.commanded_motion import JOINT_AXES, LINEAR_AXES, TURNING_AXES, check_jog
from assistant.controllers import Controller, Named, Programs, connect
from assistant.controllers import rules as controller_rules
from assistant.controllers.abilities import JogsHeld
from assistant.controllers.arm_stop import PATIENCE, Rest, brought_to_rest, stop_at_once, stopped
from assistant.controllers.rules import Lost
from assistant.controllers.states import Identity, Jog, Sample, record
from assistant.studio import rules
from assistant.studio.route_answers import finding_records, plain_value
from assistant.studio.studio import Notify

if TYPE_CHECKING:
    from assistant.robots import Robot


_CONTROLLER_PERIOD: Final = 0.4
"""Seconds between two looks at a controller."""
_CLOSE_TIMEOUT: Final = 15.0
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
            from assistant.project.virtual_controllers import running_clients

            self._clients = self._quick = self._open.enter_context(
                running_clients(self.one, self._kept)
            )
        session = self._open.enter_context(self._clients())
        if isinstance(session, Controller):
            self.identity = session.identify()
        return session

    @property
    def operates(self) -> bool:
        """True if it can be monitored and operated, and not only stores programs."""
        return isinstance(self.session, Controller)

    def quick(self) -> Programs:
        """Another session, not connected yet, which any thread may open, and that waits shortly."""
        return self._quick()

    def do(self, does: Callable[[Controller], T]) -> T:
        """Run a function with the session, after all earlier requests; raise Refused."""
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
        """Run a function that opens a separate session, with this one closed: many controllers
        accept no second connection.
        """

        def done(session: Programs) -> T:
            self._end_looks()
            session.__exit__(None, None, None)
            try:
                return does(session)
            finally:
                self._back(session)

        return self.kept(done)

    def stop(self) -> Rest:
        """Stop the arm and all programs; without a free connection, after the current request."""
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
        """Set the signals whose values are reported from now on; raise Refused for unknown ones."""
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
            watcher.join(_CLOSE_TIMEOUT)

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
        while not self._ended.wait(_CONTROLLER_PERIOD):
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
    """Return a sample as data, without numbers that are not finite."""
    state = replace(sample.state, faults=sample.state.faults[:20])
    found = record(replace(sample, state=state))
    assert isinstance(found, dict)
    return {key: plain_value(value) for key, value in found.items()}


_TICK: Final = 0.05
"""Seconds between two ticks."""
WATCH: Final = 0.2
"""Seconds without a fresh beat after which the arm is stopped."""
_AWAY_TIMEOUT: Final = 3.0
"""Seconds without any beat after which control is given up."""
_BEAT_PERIOD: Final = 0.01
"""Seconds between two looks at the beats."""
_KEPT_TICKS: Final = 100
"""Ticks whose times are remembered."""
FASTEST_STEP: Final = 10.0
"""Percent of the full speed that a held key moves at most; `jog` of the command goes faster."""
_STEP_DEGREES, _STEP_LENGTHS = 0.1, 0.5
"""Degrees, and mm along an axis, of a step at each percent of speed: a tenth of a second."""
_STEP_TIMEOUT: Final = 10.0
"""Seconds that a step has to come to its end when control is given up."""
_MOTORS_OFF_TIMEOUT: Final = 8.0
"""Seconds in which motors that do not go off are switched off again and again."""
_MOTORS_OFF_PERIOD: Final = 0.5
"""Seconds between two such trials."""
_STEP_AXES: Final = frozenset({*JOINT_AXES, *LINEAR_AXES, *TURNING_AXES})


@dataclass(frozen=True, slots=True)
class HeldKey:
    """A key that is held. number: of its press. step: that is taken again and again."""

    number: int
    step: Jog


class Control:
    """An arm that one window moves until it gives up control; raises Refused.

    window: its name. say: sends a message to that window. over: is called when control must end
    because the window is away. left_on: receives the reason why motors may still be on, or that
    they are off after all. A separate session is ready for the stop, if the controller accepts
    another connection.
    """

    def __init__(
        self,
        connection: Connection,
        window: str,
        say: Notify,
        over: Callable[[], None],
        left_on: Callable[[Sequence[Diagnostic]], None],
    ) -> None:
        self.window = window
        self._connection, self._say, self._over = connection, say, over
        self._left_on = left_on
        self._changed = threading.Condition()
        self._stopping, self._ending = threading.Lock(), threading.Lock()
        self._ticks: dict[int, float] = {}
        self._held: HeldKey | None = None
        self._cut = 0
        self._stops, self._stopped = 0, float("-inf")
        self._offs = self._switching_on = 0
        self._moving = self._switched = self._ended = self._over_and_done = False
        self._fresh = self._began = time.monotonic()
        connection.do(lambda controller: controller.state())  # one that keeps programs says so
        self._open = ExitStack()
        self._stopper: Programs | None = None
        with suppress(Refused):  # where there is no line for it, the session that jogs stops it
            self._stopper = self._open.enter_context(connection.quick())
        self._threads = [
            threading.Thread(target=does, name=f"control {does.__name__}", daemon=True)
            for does in (self._watch, self._move)
        ]

    def begin(self) -> None:
        """From now on its window has to prove that it is there."""
        self._fresh = self._began = time.monotonic()
        for thread in self._threads:
            thread.start()

    # ---------------------------------------------------------------------------------- asked

    def beat(self, window: str, message: Mapping[str, Any]) -> None:
        """Handle a window's answer to a tick; stale or invalid answers are ignored.

        But a released key counts as released, however late the message, and a key pressed before a
        stop was over moves nothing until it is pressed again.
        """
        tick, number = message.get("tick"), message.get("hold")
        if window != self.window or type(tick) is not int or type(number) is not int:
            return
        step = _beat_step(message) if number > 0 else None
        with self._changed:
            if number == 0:
                self._held = None
            when = self._ticks.get(tick, float("-inf"))
            if self._ended or time.monotonic() - when > WATCH:
                return
            if self._stops or when <= self._stopped:
                self._cut = max(self._cut, number)
            self._fresh = max(self._fresh, when)
            if step is not None and number > self._cut:
                self._held = HeldKey(number, step)
            self._changed.notify_all()

    def let_go(self, only: HeldKey | None = None) -> bool:
        """The key counts as held no more until it is pressed anew; whether it was held.

        only: if it is held so, None for however it is.
        """
        with self._changed:
            held, wanted = self._held, only or self._held
            if held is None or held != wanted:
                return False
            self._cut, self._held = max(self._cut, held.number), None
            return True

    def stop(self) -> Rest:
        """Stops the arm, and all programs, where they are; tells whether the arm stands."""
        with self._changed:
            self._stops += 1
            self.let_go()
        try:
            self._stop_beside()
            return self._connection.stop()
        finally:
            with self._changed:
                self._stops, self._stopped = self._stops - 1, time.monotonic()

    def _stop_beside(self) -> threading.Thread:
        """The stop goes out by the line that waits for it as well, which may be dead by now."""
        stop = threading.Thread(target=self._stop_at_once, name="control stop", daemon=True)
        stop.start()
        return stop

    def _stop_at_once(self) -> None:
        with self._stopping:
            if self._stopper is not None:
                stop_at_once(self._stopper)

    def motors(self, on: bool) -> None:
        """Switches the motors; those that were switched on here go off when control ends."""
        self.let_go()
        if on:
            self._connection.do(partial(self._on, self._offs))
            return
        with self._changed:
            self._offs += 1
            offs = self._offs
        if found := self._tried_off():
            raise Refused(*found)
        with self._changed:
            self._switched &= offs != self._offs or self._switching_on > 0

    def _on(self, offs: int, controller: Controller) -> None:
        """Switch the motors on. offs: number of times they had been switched off when this was
        requested.
        """
        with self._changed:
            if self._ended or self._offs != offs:
                raise Refused(rules.NO_CONTROL() if self._ended else rules.OFF_SINCE())
            self._switched = True
            self._switching_on += 1
        try:
            controller.motors(True)
        finally:
            with self._changed:
                self._switching_on -= 1

    def do(self, does: Callable[[Controller], T]) -> T:
        """Run a function with the arm, if it is under control when its turn comes; raise
        Refused.
        """

        def in_turn(controller: Controller) -> T:
            if self._ended:
                raise Refused(rules.NO_CONTROL())
            return does(controller)

        return self._connection.do(in_turn)

    def end(self) -> None:
        """Gives control up: what moves is stopped, motors that were switched on here go off.

        Comes back when that is done, whoever asked for it first.
        """
        with self._changed:
            self._ended, self._held = True, None
            self._changed.notify_all()
        with self._ending:
            if not self._over_and_done:
                self._over_and_done = True
                self._end()

    def _end(self) -> None:
        found: tuple[Diagnostic, ...] = ()
        if self._moving or self._switched:
            stop = self._stop_beside()
            found = self._insisted_off() if self._switched else ()
            stop.join(PATIENCE)
        for thread in self._threads:
            if thread.is_alive() and thread is not threading.current_thread():
                thread.join(_STEP_TIMEOUT)
        with suppress(Refused, OSError):  # the line for the stop has gone by itself
            self._open.close()
        self._say({"kind": "control", "ended": True, "findings": finding_records(found)})

    def _insisted_off(self) -> tuple[Diagnostic, ...]:
        """Switches the motors off, if need be again and again; findings if they may still be on."""
        until = time.monotonic() + _MOTORS_OFF_TIMEOUT
        found = self._tried_off()
        if found:
            self._left_on(found)
            while found and time.monotonic() < until:
                time.sleep(_MOTORS_OFF_PERIOD)
                found = self._tried_off()
            self._left_on(found)
        return found

    def _tried_off(self) -> tuple[Diagnostic, ...]:
        """Switch the motors off in a separate session, if a connection is free, or in turn with
        other requests.

        If they are just being switched on, the request in turn comes last: the later command
        counts.
        """
        apart, in_turn = self._off_apart, self._off_in_turn
        ways = (apart, in_turn) if self._stopper is not None else (in_turn, apart)
        if self._switching_on:
            with suppress(Exception):  # the other way is gone in any case
                apart()
            ways = (in_turn, apart)
        found: Sequence[Diagnostic] = ()
        for way in ways:
            try:
                way()
            except Refused as refused:
                found = refused.findings
            except Exception as wrong:  # noqa: BLE001 - whatever it is, there is another way
                found = (internal_error(wrong),)
            else:
                return ()
        one = self._connection.one
        return (rules.MOTORS_ON(place=str(one.address), name=one.name), *found)

    def _off_apart(self) -> None:
        with self._connection.quick() as session:
            assert isinstance(session, Controller)
            session.motors(False)

    def _off_in_turn(self) -> None:
        self._connection.do(lambda controller: controller.motors(False))

    # -------------------------------------------------------------------------------- threads

    def _watch(self) -> None:
        """Tells ticks, stops what moves without fresh beats, and gives up what is left alone."""
        count, due = 0, time.monotonic()
        while not self._ended:
            now = time.monotonic()
            if now >= due:
                count, due = count + 1, now + _TICK
                with self._changed:
                    self._ticks[count] = now
                    self._ticks.pop(count - _KEPT_TICKS, None)
                self._say({"kind": "tick", "tick": count})
            with self._changed:
                cut = self._held is not None and now - self._fresh > WATCH
                silent = now - max(self._fresh, self._began)
            if cut:
                self._cut_off()
            elif silent > _AWAY_TIMEOUT:
                threading.Thread(target=self._over, name="control over", daemon=True).start()
                return
            time.sleep(_BEAT_PERIOD)

    def _cut_off(self) -> None:
        try:
            rest = self.stop()
        except Refused as refused:  # it was left meanwhile
            rest = Rest(False, reason=refused.findings[0].message)
        except Exception as wrong:  # noqa: BLE001 - who watches goes on
            rest = Rest(False, reason=internal_error(wrong).message)
        self._began = time.monotonic()  # nobody was told a tick meanwhile
        self._say({"kind": "control", "cut": True, **rest_record(rest)})

    def _move(self) -> None:
        """Takes step after step while the key is held."""
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._ended or self._held is not None)
                hold = self._held
            if self._ended or hold is None:
                return
            found: Sequence[Diagnostic] = ()
            try:
                self._connection.do(partial(self._take, hold))
            except Refused as refused:
                found = refused.findings
            except Exception as wrong:  # noqa: BLE001 - the next press is another matter
                found = (internal_error(wrong),)
            finally:
                self._moving = False
            if found and self.let_go(hold):  # else it is what the stop has brought about
                self._say({"kind": "control", "findings": finding_records(found)})
            time.sleep(_BEAT_PERIOD)

    def _take(self, hold: HeldKey, controller: Controller) -> None:
        check_jog(hold.step, controller.position(), self._connection.robot)
        self._moving = True
        held = partial(self._is_held, hold)
        if isinstance(controller, JogsHeld):
            controller.jog_while(hold.step, held)
        elif held():
            controller.jog(hold.step)

    def _is_held(self, hold: HeldKey) -> bool:
        """True if the key is still held, by a recent beat."""
        with self._changed:
            return self._held == hold and time.monotonic() - self._fresh <= WATCH


def rest_record(rest: Rest) -> dict[str, object]:
    """Return the rest of an arm and its position as plain data."""
    return {"stands": rest.stands, "reason": rest.reason, "position": record(rest.position)}


def _beat_step(message: Mapping[str, Any]) -> Jog | None:
    """Return the step requested by a beat, None for an invalid one."""
    axis, by, speed = message.get("axis"), message.get("by"), message.get("speed")
    frame = message.get("frame", "base")
    if not isinstance(axis, str) or axis not in _STEP_AXES or by not in (1, -1):
        return None
    if frame not in ("base", "tool"):
        return None
    if (
        isinstance(speed, bool)
        or not isinstance(speed, int | float)
        or not 1 <= speed <= FASTEST_STEP
    ):
        return None
    size = (_STEP_LENGTHS if axis in LINEAR_AXES else _STEP_DEGREES) * speed
    return Jog(axis, size * by, frame, float(speed))
