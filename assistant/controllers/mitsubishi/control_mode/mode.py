"""Data link control mode (Kohrt et al., A robot manipulator communications and control framework).

A program in slot 3 moves to each joint position that comes over one line, without stopping
between those that are waiting (`Cnt`), while one in slot 2 sends the status over another.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from types import TracebackType
from typing import Final, Self

import numpy as np
from numpy.typing import ArrayLike

from assistant.base.arrays import Floats
from assistant.base.diagnostics import Refused
from assistant.controllers.controller import Controller
from assistant.controllers.mitsubishi.control_mode import programs
from assistant.controllers.mitsubishi.control_mode.points import (
    check_steps,
    checked_points,
    joint_limits,
)
from assistant.controllers.mitsubishi.control_mode.status import (
    STOPPING_TIMEOUT,
    Status,
    Streaming,
    link_to,
)
from assistant.controllers.mitsubishi.data_link import DataLink, Joints, rules
from assistant.controllers.mitsubishi.helpers import BorrowedState
from assistant.controllers.rules import Lost

POINTS_AHEAD: Final = 8
"""Points that are sent before the controller has taken them: what it moves to at most if the
line dies.
"""
ARRIVAL_TOLERANCE: Final = 0.02
"""Degrees; positions are printed with two decimals."""
ARRIVAL_POLL: Final = 0.1
"""Seconds between two looks whether they have."""


class ControlMode(Streaming):
    """A context manager: entering starts the programs and the status stream, leaving stops them.

    controller: is connected; the programs are installed and started through it, and it is as it was
    afterwards. None: somebody else starts them. control_line, status_line: what leads to COM1 and
    COM2 of the programs, a target of `DataLink` or a link that is not open yet.
    limits: (k, 2) lowest and highest degrees of each axis. most_step: degrees that an axis may turn
    between two points, and from where it stands to the first one. ahead: points that are sent
    before the controller takes them. silence: seconds without a status that stop it. timeout:
    seconds in which an arm that is to move does. replace: other programs of the names of ours on
    the controller.
    """

    def __init__(
        self,
        controller: Controller | None,
        control_line: str | DataLink,
        status_line: str | DataLink,
        *,
        limits: ArrayLike,
        most_step: float | None = None,
        ahead: int = POINTS_AHEAD,
        silence: float = 2.0,
        timeout: float = 10.0,
        replace: bool = False,
    ) -> None:
        super().__init__(status_line, silence, timeout)
        self.controller = controller
        self.limits = joint_limits(limits)
        self.most_step = most_step
        self.ahead = ahead
        self.timeout = timeout
        self._replace = replace
        self._control = link_to(control_line, timeout)
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
        if state != STOPPED_REASON and error is None:
            raise Lost(rules.NOT_ENDED(place=self._stream.link.target, state=state))

    def follow(
        self, joints: ArrayLike, *, progress: Callable[[int, int], None] | None = None
    ) -> None:
        """Moves through the points, and comes back when the arm is at the last one.

        joints: (n, k) degrees, NaN for an axis that the arm lacks. progress: is told of how many
        of how many the controller has taken. Whatever fails, ^C too, stops the programs.
        Raises Refused: limits are looked at before anything is sent.
        """
        points = checked_points(joints, self.limits, self.most_step)
        try:
            self._follow(points, progress or (lambda _done, _count: None))
        except BaseException as error:
            state = self.stop()
            if isinstance(error, Refused):
                raise self._with(error, state) from None
            raise

    def lead(self, joints: ArrayLike) -> None:
        """Sends one more point once there is room for it, and does not wait for the arm.

        joints: (k,) degrees, NaN for an axis that the arm lacks. For who works the next point out
        meanwhile; the arm stands at the last one. Limits, and `most_step` from the point before,
        are looked at before it is sent. Whatever fails, ^C too, stops the programs.
        """
        points = checked_points(np.atleast_2d(np.asarray(joints)), self.limits, None)
        try:
            if self.most_step is not None:
                before = self._last if self._last is not None else self._commanded()
                check_steps(np.vstack([before, points]), self.most_step, first=1)
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
            return STOPPED_REASON
        said = self._stream.stop(STOPPING_TIMEOUT, again=self.controller is None)
        if self.controller is not None:
            stands = self._stop_through(self.controller, said)
            said = stands or self._stream.stop(STOPPING_TIMEOUT, again=True)
        self._stopped = said
        return (
            STOPPED_REASON if self._stopped else f"they could not be stopped: {self._stream.state}"
        )

    # ------------------------------------------------------------------------------ inside

    def _begin(self) -> None:
        self._control.prepare()
        self._stream.link.prepare()
        if self.controller is not None:
            programs.check_idle(self.controller)
            self._before = BorrowedState.of(
                self.controller, programs.PROGRAM_NAMES, programs.SHARED_VARIABLES
            )
            programs.install_programs(self.controller, replace=self._replace)
            self.controller.load(programs.STARTING_PROGRAM)
            self._started = True
            self.controller.start()
        self._stream.link.open()
        self._control.open()
        self._started = True
        self._stream.start()
        self._sent, self._last = self.status.taken, None

    def _end(self, error: BaseException | None) -> str:
        """Stop, close the lines and restore the controller; returns the state of the programs."""
        try:
            state = self.stop()
        finally:
            self._close()
        if self._before is not None and state == STOPPED_REASON:
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
            check_steps(np.vstack([self._commanded(), points[:1]]), self.most_step, first=1)

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
        return now.taken == self._sent and bool((away <= ARRIVAL_TOLERANCE).all())

    def _stalled(self, left: int, count: int) -> Refused:
        place = self._control.target
        return Refused(rules.STALLED(place=place, seconds=self.timeout, left=left, count=count))

    def _stop_through(self, controller: Controller, said: bool) -> bool:
        """Whether no program runs any more; they are stopped unless they end by themselves."""
        end = time.monotonic() + (STOPPING_TIMEOUT if said else 0.0)
        try:
            while controller.state().running and time.monotonic() < end:
                time.sleep(ARRIVAL_POLL)
            if controller.state().running:
                controller.stop()
            return not controller.state().running
        except Refused:
            return False

    def _with(self, error: Refused, state: str) -> Refused:
        """An error with what is known of the controller behind it."""
        first, *more = error.findings
        told = replace(first, message=f"{first.message}; {state}{self._why()}")
        return type(error)(told, *more, exit_status=error.exit_status)

    def _why(self) -> str:
        """What the controller says that it stands still for."""
        if self.controller is None:
            return ""
        try:
            found = programs.troubles(self.controller.state())
        except Refused:
            return "; the controller does not answer"
        return f"; the controller says: {', '.join(found)}" if found else ""


STOPPED_REASON: Final = "the programs were stopped"


def _moved(then: Status, now: Status | None) -> bool:
    """Between two looks."""
    return now is not None and (
        now.taken != then.taken
        or not np.array_equal(now.commanded.values, then.commanded.values, equal_nan=True)
    )
