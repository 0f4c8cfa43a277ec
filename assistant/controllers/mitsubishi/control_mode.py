"""Data link control mode: joint positions on one line, the status of the arm on another.

with ControlMode(controller, "192.168.0.20:10003", "192.168.0.20:10004", limits=limits) as mode:
    mode.follow(joints)
mode.recording.save("run.csv")

After Kohrt et al., A robot manipulator communications and control framework. The program
CONTROLLINK in slot 3 moves to each joint position that arrives, without stopping between those that
are waiting (`Cnt`); DATALINK in slot 2 sends status records from the first message on until a "0".
All programs stop when the "2" of a client that asked to be watched does not arrive for two seconds.
`Measuring` runs MEASURE in slot 2 alone, whatever the controller does in slot 1 meanwhile.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial
from types import TracebackType
from typing import Final, NoReturn, Self

import numpy as np
from numpy.typing import ArrayLike

from assistant.base.arrays import Floats, reals
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Refused, Rule
from assistant.controllers.controller import Controller
from assistant.controllers.mitsubishi import rules
from assistant.controllers.mitsubishi.data_link import (
    AXES,
    DECIMALS,
    DataLink,
    Form,
    Joints,
    Position,
)
from assistant.controllers.mitsubishi.operation import BorrowedState
from assistant.controllers.recording import Recording
from assistant.controllers.rules import Lost
from assistant.controllers.states import State
from assistant.resources import resource

__all__ = ["FORM", "ControlMode", "Measuring", "Status"]

FORM: Final = Form.parse("M_TIMER(1) | P_CURR | J_FBC | J_CURR | M_RSPD(3) | M_04")
"""Form of a line that the program DATALINK prints."""
_READY_WORD: Final = "READY"
_END_WORD: Final = "END"
_STOP_MESSAGE: Final = "0"
_WATCH_MESSAGE: Final = "2"
_WATCH_INTERVAL: Final = 0.4
"""Seconds between two messages of a client that is watched; two seconds stop the programs."""
_STOPPING_TIMEOUT: Final = 5.0
"""Seconds that the programs have to end."""
_STOP_BY_THEMSELVES: Final = "the programs stop by themselves within 2 s of the last message"
_RUN_ON: Final = "no position was sent; programs that run may still wait for one"
"""Known condition of a controller whose status line is gone."""


@dataclass(frozen=True, slots=True)
class Status:
    """A record of the stream.

    seconds: on the controller since its program began. position: of the tool. feedback,
    commanded: joints in degrees, as measured and as asked for. speed: of the tool, mm/s.
    taken: joint positions that the program has read from its line.
    """

    seconds: float
    position: Position
    feedback: Joints
    commanded: Joints
    speed: float
    taken: int


class _StatusStream:
    """silence: seconds without a record after which the arm is not known any more."""

    def __init__(self, link: DataLink, silence: float) -> None:
        self.link = link
        self.silence = silence
        self.recording = FORM.recording("seconds")
        self.latest: Status | None = None
        self.ended = False
        self.failure: Refused | None = None
        self._news = threading.Condition()
        self._stopping = threading.Event()
        self._over = threading.Event()
        self._tried = False
        self._thread = threading.Thread(target=self._run, name="status", daemon=True)

    def start(self) -> None:
        """Asks for the stream; the link is open."""
        self._thread.start()

    def first(self) -> Status:
        """The latest record, once there is one; raises Refused as `wait` does."""
        if self._thread.ident is None:
            raise self._lost("asking for the status", "there is no session")
        while not self.wait(lambda latest: latest is not None, self.link.timeout):
            """The thread tells when that took too long."""
        assert self.latest is not None
        return self.latest

    def wait(self, enough: Callable[[Status | None], bool], timeout: float) -> bool:
        """Waits until a record is enough; False if none was in time.

        Raises Refused once there is no stream any more.
        """
        with self._news:
            self._news.wait_for(lambda: self._gone or enough(self.latest), timeout)
            if self.failure is not None:
                raise self.failure
            if self.ended:
                raise Lost(rules.ENDED(place=self.link.target, state="the arm stands"))
            return enough(self.latest)

    def stop(self, timeout: float, *, again: bool) -> bool:
        """Asks for the end of all programs; whether they said that they end.

        again: whether a line that was cut is connected to once more for that.
        """
        if self._thread.is_alive():
            self._stopping.set()
            with self._news:
                self._news.wait_for(lambda: self._gone, timeout)
        # One more connection, and only once: the programs may still wait for the stop.
        if again and self.failure is not None and not self.ended and not self._tried:
            self._tried = True
            with suppress(Refused):
                self._stop_anew(time.monotonic() + min(timeout, self.link.timeout))
        return self.ended

    def _stop_anew(self, end: float) -> None:
        self._thread.join()
        self.link.close()
        self.link.open()
        while not self.ended and time.monotonic() < end:
            self.link.send(_STOP_MESSAGE)
            heard = time.monotonic()
            while not self.ended and time.monotonic() - heard < _WATCH_INTERVAL:
                self.ended = self.link.wait(_RECORD_SLICE) == _END_WORD

    @property
    def state(self) -> str:
        """Known condition of the programs if nothing more is received from them."""
        return _RUN_ON if self.latest is None else _STOP_BY_THEMSELVES

    def close(self) -> None:
        """Ends the thread and the line."""
        self._over.set()
        if self._thread.is_alive():
            self._thread.join()
        self.link.close()

    @property
    def _gone(self) -> bool:
        return self.ended or self.failure is not None

    def _run(self) -> None:
        # Assumed until `_hear` returns: whatever ends the thread, those who wait get a failure.
        failure: Refused | None = self._lost("listening", "nobody listens any more")
        try:
            self._hear()
            if self.ended:
                failure = None
        except Refused as error:
            failure = error
        finally:  # nobody waits for ever, whatever it was
            with self._news:
                self.failure = failure
                self._news.notify_all()

    def _hear(self) -> None:
        began = heard = time.monotonic()
        # The first message is sent at once.
        said, word = -_WATCH_INTERVAL, ""
        while not self._over.is_set():
            now = time.monotonic()
            asked = _STOP_MESSAGE if self._stopping.is_set() else _WATCH_MESSAGE
            # A stop is sent at once, not at the next interval.
            if now - said >= _WATCH_INTERVAL or asked != word:
                said, word = now, asked
                self.link.send(word)
            line = self.link.wait(_RECORD_SLICE)
            now = time.monotonic()
            if line == _END_WORD:
                with self._news:
                    self.ended = True
                    self._news.notify_all()
                return
            if line is not None and self._take(line, now - began):
                heard = now
            # The first record may take as long as the program needs to begin.
            allowed = self.silence if self.latest is not None else self.link.timeout
            if now - heard > allowed:
                self._fail(rules.SILENT, seconds=allowed)

    def _take(self, line: str, seconds: float) -> bool:
        """True if the line is a record; raises Lost for a line that the program never prints."""
        # READY comes once, before the first record.
        if line == _READY_WORD and self.latest is None:
            return False
        try:
            values = FORM.read(line)
        except ValueError:
            self._fail(rules.LINE_GARBLED, answer=repr(line[:80]))
        match values:
            case (
                float(timer),
                Position() as position,
                Joints() as feedback,
                Joints() as commanded,
                float(speed),
                float(taken),
            ):
                status = Status(timer / 1000, position, feedback, commanded, speed, int(taken))
            case _:
                raise AssertionError(FORM)
        with self._news:
            self.latest = status
            FORM.record(self.recording, values, seconds)
            self._news.notify_all()
        return True

    def _lost(self, doing: str, reason: str) -> Lost:
        target, state = self.link.target, self.state
        return Lost(
            rules.LINE_LOST(place=target, target=target, doing=doing, reason=reason, state=state)
        )

    def _fail(self, rule: Rule, *, seconds: float = 0.0, answer: str = "") -> NoReturn:
        target = self.link.target
        raise Lost(
            rule(place=target, target=target, seconds=seconds, answer=answer, state=self.state)
        )


class Streaming:
    """Base of classes with a status stream; each entry creates another stream."""

    def __init__(self, line: str | DataLink, silence: float, timeout: float) -> None:
        self._stream = _StatusStream(_link_to(line, timeout), silence)

    @property
    def recording(self) -> Recording:
        """Every status that came, in columns; `seconds` are those of this computer."""
        return self._stream.recording

    @property
    def status(self) -> Status:
        """Return the latest status; raises Refused if the stream has ended."""
        return self._stream.first()

    def _anew(self) -> None:
        self._stream = _StatusStream(self._stream.link, self._stream.silence)


def _link_to(line: str | DataLink, timeout: float) -> DataLink:
    """line: a target of `DataLink`, or a link that is not open yet."""
    return line if isinstance(line, DataLink) else DataLink(line, timeout=timeout)


_RECORD_SLICE: Final = 0.1
"""Seconds that a record is waited for at a time."""


def _joint_limits(limits: ArrayLike) -> Floats:
    """Return (k, 2) lowest and highest degrees of each axis; raises Refused for invalid limits."""
    rows = _number_rows(limits, "the limits")
    if rows.ndim != 2 or rows.shape[1:] != (2,) or not 0 < len(rows) <= AXES:
        raise _bad_points(
            f"the limits have the shape {rows.shape}", "give (low, high) in degrees for each axis"
        )
    if not (rows[:, 0] < rows[:, 1]).all():
        raise _bad_points("a limit is no range", "give (low, high) in degrees for each axis")
    return rows


def _checked_points(joints: ArrayLike, limits: Floats, most_step: float | None) -> Floats:
    """(n, k) degrees as they will arrive, NaN for an axis that the arm lacks.

    limits: (k, 2). most_step: degrees that an axis may turn from one point to the next.
    Raises Refused before anything is sent.
    """
    points = _number_rows(joints, "the points")
    if points.ndim != 2 or len(points) == 0 or points.shape[1] != len(limits):
        reason = f"it has the shape {points.shape}, the arm {len(limits)} axes"
        raise _bad_points(reason, "give a row for each point, with an angle for each axis")
    lacking = np.isnan(points)
    if np.isinf(points).any() or (lacking != lacking[0]).any() or lacking.all():
        raise _bad_points(
            "an angle is no number", "leave an axis out (NaN) of all points or of none"
        )
    # Checked as they will arrive: rounded to the decimals that are sent.
    points = points.round(DECIMALS)
    outside = (points < limits[:, 0]) | (points > limits[:, 1])
    if outside.any():
        row, axis = np.argwhere(outside)[0]
        low, high = limits[axis]
        raise Refused(
            rules.OUT_OF_LIMITS(
                place=f"point {row + 1}",
                number=row + 1,
                axis=axis + 1,
                value=points[row, axis],
                low=low,
                high=high,
            )
        )
    if most_step is not None and len(points) > 1:
        _check_steps(points, most_step)
    return points


def _check_steps(points: Floats, most: float, first: int = 2) -> None:
    """Raise Refused for a step that is too large. first: number of the second point."""
    # NaN - NaN is NaN, which no comparison finds: an axis that the arm lacks does not move.
    steps = np.nan_to_num(np.abs(np.diff(points, axis=0)))
    if (far := steps > most).any():
        row, axis = np.argwhere(far)[0]
        raise Refused(
            rules.TOO_FAR(
                place=f"point {row + first}",
                number=row + first,
                axis=axis + 1,
                step=steps[row, axis],
                most=most,
            )
        )


def _number_rows(given: ArrayLike, what: str) -> Floats:
    try:
        return reals(given)
    except ValueError as error:
        raise _bad_points(
            f"{what} are no table of numbers: {error}", "give rows of numbers"
        ) from None


def _bad_points(reason: str, cure: str) -> Refused:
    return Refused(rules.BAD_POINTS(reason=reason, cure=cure), exit_status=2)


_STARTING_PROGRAM: Final = "MULTITASK"
"""Starts and stops the others."""
PROGRAM_NAMES: Final = (_STARTING_PROGRAM, "DATALINK", "CONTROLLINK")
_SHARED_VARIABLES: Final = ("M_01", "M_02", "M_03", "M_04")
"""External variables by which they signal each other."""
MEASURING_PROGRAM: Final = "MEASURE"
"""Program that sends the status independently, in parallel with another slot."""


def program_texts(names: Sequence[str] = PROGRAM_NAMES) -> dict[str, bytes]:
    """The programs by name. They are the same in all versions of the language."""
    folder = "melfa/datalink"
    return {name: resource("samples", f"{folder}/{name}.prg").read_bytes() for name in names}


def _install_programs(
    controller: Controller, names: Sequence[str] = PROGRAM_NAMES, *, replace: bool = False
) -> None:
    """Writes the programs that are not there yet.

    replace: other programs of these names, too; they are refused else.
    """
    wanted = program_texts(names)
    there = {name: controller.read(name) for name in wanted}
    missing = [
        name
        for name, data in there.items()
        if data is None or _steps(controller, data) != _steps(controller, wanted[name])
    ]
    others = [name for name in missing if there[name] is not None]
    if others and not replace:
        raise Refused(
            rules.NOT_READY(
                place=str(controller.address),
                reason=f"other programs are called {', '.join(others)} there",
                cure="back them up, then allow to replace them",
            )
        )
    for name in missing:
        controller.write(name, wanted[name])


def _steps(controller: Controller, data: bytes) -> list[bytes]:
    """The lines of a program without the variables, which it gives other values as it runs."""
    return [line for line in controller.stored(data).splitlines() if line[:1].isdigit()]


def _check_idle(controller: Controller) -> None:
    """Raises Refused for what programs cannot be started in."""
    state = controller.state()
    reason = next(iter(_troubles(state)), "a program runs" if state.running else "")
    if reason:
        cure = "put right what it says, stop the programs, then begin anew"
        finding = rules.NOT_READY(place=str(controller.address), reason=reason, cure=cure)
        raise Refused(finding)


def _troubles(state: State) -> list[str]:
    """Return the reasons why a controller is stopped, in words."""
    found = ["the emergency stop is pressed"] if state.emergency else []
    return found + [f"error {fault.number} ({fault.text})" for fault in state.faults]


_POINTS_AHEAD: Final = 8
"""Points that are sent before the controller has taken them: what it moves to at most if the
line dies.
"""
_ARRIVAL_TOLERANCE: Final = 0.02
"""Degrees; positions are printed with two decimals."""
_ARRIVAL_POLL: Final = 0.1
"""Seconds between two looks whether they have."""


class ControlMode(Streaming):
    """A context manager: entering starts the programs and the status stream, leaving stops them.

    controller: is connected; the programs are installed and started through it, and it is restored
    afterwards. None: the user starts them. control_line, status_line: lines to COM1 and COM2 of the
    programs, a target of `DataLink` or a link that is not open yet. limits: (k, 2) lowest and
    highest degrees of each axis. most_step: degrees that an axis may turn between two points, and
    from the present position to the first one. ahead: points that are sent before the controller
    takes them. silence: seconds without a status that stop it. timeout: seconds in which a
    commanded arm must move. replace: whether other programs with these names on the controller may
    be replaced.
    """

    def __init__(
        self,
        controller: Controller | None,
        control_line: str | DataLink,
        status_line: str | DataLink,
        *,
        limits: ArrayLike,
        most_step: float | None = None,
        ahead: int = _POINTS_AHEAD,
        silence: float = 2.0,
        timeout: float = 10.0,
        replace: bool = False,
    ) -> None:
        super().__init__(status_line, silence, timeout)
        self.controller = controller
        self.limits = _joint_limits(limits)
        self.most_step = most_step
        self.ahead = ahead
        self.timeout = timeout
        self._replace = replace
        self._control = _link_to(control_line, timeout)
        self._sent = 0
        self._last: Floats | None = None
        """The point that was sent last, None before the first."""
        self._started = self._stopped = False
        self._before: BorrowedState | None = None

    def __enter__(self) -> Self:
        self._anew()
        self._started = self._stopped = False
        self._before = None
        try:
            self._begin()
        except BaseException as error:
            state = self._end(error)
            if self._started and isinstance(error, Refused):
                raise self._with(error, state) from None
            raise
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Raises Refused if the programs could not be stopped, unless there is an error already."""
        state = self._end(error)
        if state != _STOPPED_REASON and error is None:
            raise Lost(rules.NOT_ENDED(place=self._stream.link.target, state=state))

    def follow(
        self, joints: ArrayLike, *, progress: Callable[[int, int], None] | None = None
    ) -> None:
        """Move through the points, and return when the arm is at the last one.

        joints: (n, k) degrees, NaN for a missing axis. progress: receives the number of points that
        the controller has taken, and their total. Any failure, ^C too, stops the programs. Raises
        Refused: limits are checked before anything is sent.
        """
        points = _checked_points(joints, self.limits, self.most_step)
        try:
            self._follow(points, progress or (lambda _done, _count: None))
        except BaseException as error:
            state = self.stop()
            if isinstance(error, Refused):
                raise self._with(error, state) from None
            raise

    def lead(self, joints: ArrayLike) -> None:
        """Send one more point once there is room for it, without waiting for the arm.

        joints: (k,) degrees, NaN for a missing axis. For callers that compute the next point
        meanwhile; the arm stops at the last one. Limits, and `most_step` from the point before, are
        checked before it is sent. Any failure, ^C too, stops the programs.
        """
        points = _checked_points(np.atleast_2d(np.asarray(joints)), self.limits, None)
        try:
            if self.most_step is not None:
                before = self._last if self._last is not None else self._commanded()
                _check_steps(np.vstack([before, points]), self.most_step, first=1)
            self._until(lambda now: self._sent - now.taken < self.ahead, self._sent, 1)
            self._control.send(Joints(tuple(points[0].tolist())))
            self._sent, self._last = self._sent + 1, points[0]
        except BaseException as error:
            state = self.stop()
            if isinstance(error, Refused):
                raise self._with(error, state) from None
            raise

    def stop(self) -> str:
        """Stops the arm and the programs; in words, what is known of them."""
        if self._stopped or not self._started:
            return _STOPPED_REASON
        said = self._stream.stop(_STOPPING_TIMEOUT, again=self.controller is None)
        if self.controller is not None:
            # The controller knows whether the programs have
            # ended; without its word the stream is tried again.
            stands = self._stop_through(self.controller, said)
            said = stands or self._stream.stop(_STOPPING_TIMEOUT, again=True)
        self._stopped = said
        return (
            _STOPPED_REASON if self._stopped else f"they could not be stopped: {self._stream.state}"
        )

    # ------------------------------------------------------------------------------ inside

    def _begin(self) -> None:
        self._control.prepare()
        self._stream.link.prepare()
        if self.controller is not None:
            _check_idle(self.controller)
            self._before = BorrowedState.of(self.controller, PROGRAM_NAMES, _SHARED_VARIABLES)
            _install_programs(self.controller, replace=self._replace)
            self.controller.load(_STARTING_PROGRAM)
            # Set before the start: a failure in between must stop the programs.
            self._started = True
            self.controller.start()
        # The programs open their lines when they run;
        # this computer may listen before, see `prepare`.
        self._stream.link.open()
        self._control.open()
        self._started = True
        self._stream.start()
        # Points of an earlier use of the programs are counted already.
        self._sent, self._last = self.status.taken, None

    def _end(self, error: BaseException | None) -> str:
        """Stop, close the lines and restore the controller; returns the state of the programs."""
        try:
            state = self.stop()
        finally:
            self._close()
        if self._before is not None and state == _STOPPED_REASON:
            try:
                self._before.put_back()
            except Refused:
                if error is None:
                    raise
        return state

    def _close(self) -> None:
        self._stream.close()
        self._control.close()

    def _follow(self, points: Floats, progress: Callable[[int, int], None]) -> None:
        before, count, told = self._sent, len(points), 0
        if self.most_step is not None:
            _check_steps(np.vstack([self._commanded(), points[:1]]), self.most_step, first=1)

        def tell(taken: int) -> None:
            nonlocal told
            if taken > told:
                told = taken
                progress(taken, count)

        for point in points:
            self._until(lambda now: self._sent - now.taken < self.ahead, before, count, tell)
            self._control.send(Joints(tuple(point.tolist())))
            self._sent, self._last = self._sent + 1, point
        self._until(lambda now: self._is_at(now, points[-1]), before, count, tell)
        if told < count:
            progress(count, count)

    def _until(
        self,
        enough: Callable[[Status], bool],
        before: int,
        count: int,
        tell: Callable[[int], None] = lambda _taken: None,
    ) -> None:
        """Waits as long as the arm moves or points are taken; raises Refused.

        before: points that were taken before the first of `count`.
        """
        while not enough(then := self.status):
            if not self._stream.wait(partial(_moved, then), self.timeout):
                raise self._stalled(count - (then.taken - before), count)
            tell(self.status.taken - before)

    def _commanded(self) -> Floats:
        return np.array(self.status.commanded.values[: len(self.limits)])

    def _is_at(self, now: Status, goal: Floats) -> bool:
        there = np.array(now.commanded.values[: len(goal)])
        away = np.nan_to_num(np.abs(there - goal))
        # All points have to be taken: an earlier one may be at the same position.
        return now.taken == self._sent and bool((away <= _ARRIVAL_TOLERANCE).all())

    def _stalled(self, left: int, count: int) -> Refused:
        place = self._control.target
        return Refused(rules.STALLED(place=place, seconds=self.timeout, left=left, count=count))

    def _stop_through(self, controller: Controller, said: bool) -> bool:
        """True if no program runs any more; stop the programs unless they end unaided."""
        # Programs that reported their end get time for it.
        end = time.monotonic() + (_STOPPING_TIMEOUT if said else 0.0)
        try:
            while controller.state().running and time.monotonic() < end:
                time.sleep(_ARRIVAL_POLL)
            if controller.state().running:
                controller.stop()
            return not controller.state().running
        except Refused:
            return False

    def _with(self, error: Refused, state: str) -> Refused:
        """Return an error with the known condition of the controller appended."""
        first, *more = error.findings
        told = replace(first, message=f"{first.message}; {state}{self._why()}")
        return type(error)(told, *more, exit_status=error.exit_status)

    def _why(self) -> str:
        """Return the controller's reasons for its stop, in words."""
        if self.controller is None:
            return ""
        try:
            found = _troubles(self.controller.state())
        except Refused:
            return "; the controller does not answer"
        return f"; the controller says: {', '.join(found)}" if found else ""


_STOPPED_REASON: Final = "the programs were stopped"


def _moved(then: Status, now: Status | None) -> bool:
    """Between two looks."""
    return now is not None and (
        now.taken != then.taken
        or not np.array_equal(now.commanded.values, then.commanded.values, equal_nan=True)
    )


_MEASURING_SLOT: Final = "2"


class Measuring(Streaming):
    """A context manager: entering starts the program and the stream, leaving ends both.

    controller: is connected; the program is installed and started through it, and deleted
    afterwards if it was not there. None: it runs there already, in a slot that always runs. line:
    what leads to COM2 of the program. silence: seconds without a status that are an error. replace:
    another program of its name on the controller.
    """

    def __init__(
        self,
        controller: Controller | None,
        line: str | DataLink,
        *,
        silence: float = 2.0,
        timeout: float = 10.0,
        replace: bool = False,
    ) -> None:
        super().__init__(line, silence, timeout)
        self._controller, self._replace = controller, replace
        self._before: BorrowedState | None = None

    def __enter__(self) -> Self:
        self._anew()
        self._stream.link.prepare()
        try:
            if self._controller is not None:
                self._before = BorrowedState.of(self._controller, (MEASURING_PROGRAM,))
                _install_programs(self._controller, (MEASURING_PROGRAM,), replace=self._replace)
                self._controller.load(MEASURING_PROGRAM, task=_MEASURING_SLOT)
                self._controller.start(_MEASURING_SLOT)
            self._stream.link.open()
            self._stream.start()
            self._stream.first()
        except BaseException:
            self._end(failed=True)
            raise
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._end(failed=error is not None)

    def _end(self, *, failed: bool) -> None:
        """End the stream, restore the controller. A program that gets no stop ends within 2 s."""
        try:
            self._stream.stop(_STOPPING_TIMEOUT, again=True)
        finally:
            self._stream.close()
        if self._before is not None:
            before, self._before = self._before, None
            try:
                before.put_back()
            except Refused:
                if not failed:
                    raise
