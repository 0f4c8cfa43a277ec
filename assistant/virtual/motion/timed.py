"""The arm of a controller whose motions take as long as they are planned to."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from assistant.program.arrays import Floats
from assistant.program.geometry import Pose
from assistant.robots.robot import Robot
from assistant.robots.timing.drive import Drive, drive_of
from assistant.robots.timing.plan import Plan
from assistant.virtual.events import Moved, Noted, Switched
from assistant.virtual.kernel.kernel import Ending, Kernel
from assistant.virtual.kernel.motion import Standing
from assistant.virtual.kernel.task import Task
from assistant.virtual.motion.flight import Change, Order, Planned, moment, planned
from assistant.virtual.motion.goals import Refusal
from assistant.virtual.motion.refusals import LATE, message

NEVER_LATE: Final = 0.1
"""Seconds behind the beginning of a corner at which the next motion still comes in time: as if the
controller had read it ahead. How far they read ahead no reference at hand tells."""
MOST_AHEAD: Final = 20_000
"""Motions that wait to be planned, at most."""
NO_TIME: Final = 1e-9
"""Seconds that are none."""


@dataclass(frozen=True, slots=True, eq=False)
class Leg:
    """Part of a plan that the arm went through, from `first` to `last` of its seconds. begin: the
    time of the kernel at its first one.
    """

    begin: float
    plan: Plan
    first: float
    last: float


class Timed:
    """robot: of the catalogue. drive: its speeds and accelerations, None for its own with the tools
    that it carries. joints: (a,) where it stands
    at first, None for its home. ahead: seconds before its corner at which a motion that does not
    stop lets its program go on.
    """

    def __init__(
        self,
        robot: Robot,
        drive: Drive | None = None,
        joints: Sequence[float] | None = None,
        ahead: float = 0.0,
    ) -> None:
        self.robot, self.drive, self.ahead = robot, drive, ahead
        self.start = np.array(robot.home if joints is None else joints, dtype=np.float64)
        self.legs: list[Leg] = []
        self.kernel: Kernel | None = None
        # The flight at hand: its orders from joints where the arm stood, and when it began.
        self._joints, self._queue, self._began = self.start, list[Order](), 0.0
        self.behind = False
        self._held = False
        self._flying: Planned | None = None
        self._braking: Planned | None = None

    # ---------------------------------------------------------------------------- commands

    def go(self, task: Task, moved: Moved, changes: Sequence[Switched] = ()) -> None:
        kernel = self.kernel = task.kernel
        on_way = [change for change in changes if change.at is not None]
        alone = kernel.alone and not on_way and not self._held
        if self.behind and (not alone or self._is_late(kernel) or len(self._queue) >= MOST_AHEAD):
            self.catch_up(kernel)
        if not self.behind:
            self._close(task)
        kernel.tell(task, moved)
        order = Order(task, moved, kernel.log[-1].place, len(kernel.log), kernel.clock)
        order.stops = moved.blend <= 0.0
        order.changes = [Change(change) for change in on_way]
        if not self._queue:
            self._began = max(self._began, kernel.clock)
        self._queue.append(order)
        if alone:
            self.behind = True
        else:
            self._plan(kernel)
            self._wait(task, order)
        for change in changes:
            if change.at is None:
                task.switch(change.signal, change.value)

    def settle(self, task: Task) -> None:
        kernel = task.kernel
        self.catch_up(kernel)
        if self._queue and not self._queue[-1].stops:
            order = self._queue[-1]
            order.stops, order.release = True, math.inf
            kernel.stop_latest()
            self._plan(kernel)
            self._wait(task, order)

    def _wait(self, task: Task, order: Order) -> None:
        """Until an order lets its program go on."""
        kernel = task.kernel
        while (left := order.release - kernel.clock) > NO_TIME:
            if math.isinf(left):
                task.wait(lambda: math.isfinite(order.release), None, "the arm to go on")
            else:
                task.wait(None, left)
        self._rest_from_end(kernel)

    def _is_late(self, kernel: Kernel) -> bool:
        last = self._queue[-1]
        return not last.stops and kernel.clock - last.clock > NEVER_LATE

    def _close(self, task: Task) -> None:
        """Before the next order: the arm has come to rest if that comes too late for a corner."""
        kernel = task.kernel
        self._rest_from_end(kernel)
        if not self._queue or self._held:
            return
        last = self._queue[-1]
        if not last.stops and kernel.clock - last.release > NEVER_LATE:
            made = self._to_rest()
            self._pass(made, len(self._queue) - 1)
            if "rapid" in self.robot.languages:
                kernel.tell(task, Noted(LATE), last.place)

    # -------------------------------------------------------------------------------- time

    def catch_up(self, kernel: Kernel) -> None:
        if not self.behind:
            return
        self.behind = False
        made, refusal = self._made(going_on=True)
        last = self._queue[-1]
        count = len(self._queue) if refusal is None else refusal.index
        if made is not None:
            self._set_times(kernel, count, made)
        if refusal is not None:
            self._refuse(kernel, refusal)
        elif kernel.clock > kernel.most_time:
            while kernel.log and kernel.log[-1].time > kernel.most_time:
                kernel.log.pop()
            kernel.fail(last.task, last.place, Ending("time", f"more than {kernel.most_time:g} s"))

    def _set_times(self, kernel: Kernel, count: int, made: Planned) -> None:
        """Gives what was logged behind orders that the program ran ahead of its time.

        Between motions that stop, the arm stands as long as the statements there take.
        """
        orders, log = self._queue, kernel.log
        shift, passed = self._began, 0.0
        latest = self._began
        for i in range(count):
            order = orders[i]
            if math.isfinite(order.release):
                latest = max(latest, order.release)
                continue
            follows = orders[i + 1] if i + 1 < len(orders) else None
            rows = len(log) if follows is None else follows.row
            spent = (kernel.clock if follows is None else follows.clock) - order.clock
            order.release = shift + float(made.releases[i])
            for row in log[order.row : rows]:
                row.time = latest = max(latest, order.release + row.time - order.clock)
            latest = max(latest, order.release + spent)
            if order.stops and spent > 0.0:
                end = float(made.ends[i])
                self.legs.append(Leg(shift + passed, made.plan, passed, end))
                shift, passed = shift + spent, end
        kernel.clock = latest
        self._flying = made
        stops = [i for i in range(count) if orders[i].stops]
        if stops:
            self._pass(made, stops[-1], shift, passed)
            if self._queue:
                self._flying, _ = self._made(going_on=True)

    def _pass(
        self, made: Planned, last: int, shift: float | None = None, first: float = 0.0
    ) -> None:
        """The arm has come to rest at the end of an order, and the others begin there."""
        shift = self._began if shift is None else shift
        end = float(made.ends[last])
        if end > first:
            self.legs.append(Leg(shift + first, made.plan, first, end))
        self._joints, self._began = made.joints[last], shift + end
        self._queue = self._queue[last + 1 :]
        self._flying = self._braking = None

    def _rest_from_end(self, kernel: Kernel) -> None:
        """The flight is over if the arm has come to its end and stops there."""
        if self._queue and self._flying is not None and not self._held:
            last = self._queue[-1]
            if last.stops and kernel.clock >= last.release - NO_TIME:
                self._pass(self._flying, len(self._queue) - 1)

    def rest(self) -> float:
        if self.kernel is not None:
            self.catch_up(self.kernel)
        if not self._queue or self.kernel is None or self.kernel.ending is not None:
            return -math.inf
        return math.inf if self._held else self._began + float(self._to_rest().ends[-1])

    # ---------------------------------------------------------------------------- planning

    def _made(self, going_on: bool) -> tuple[Planned | None, Refusal | None]:
        drive = self.drive
        if drive is None:
            masses = [order.moved.how.mass for order in self._queue]
            known = [mass for mass in masses if mass is not None]
            load = max(known) if len(known) == len(masses) else None
            drive = drive_of(self.robot, load=load)
        return planned(self._queue, self._joints, self.robot, drive, going_on)

    def _plan(self, kernel: Kernel) -> None:
        """Plans the orders that there are; another one may follow."""
        if self._held:
            return
        made, refusal = self._made(going_on=True)
        if refusal is not None or made is None:
            assert refusal is not None
            self._refuse(kernel, refusal)
            return
        self._flying, self._braking = made, None
        for order, release in zip(self._queue, made.releases.tolist(), strict=True):
            if order.release > kernel.clock:
                early = 0.0 if order.stops else self.ahead
                order.release = max(self._began + release - early, kernel.clock)
            for change in order.changes:
                self._schedule(kernel, made, order, change)

    def _schedule(self, kernel: Kernel, made: Planned, order: Order, change: Change) -> None:
        """Has an output set when the arm comes to its place."""
        if change.done:
            return
        if change.timer is not None:
            change.timer.cancelled = True
        what = change.what
        assert what.at is not None

        def act() -> None:
            change.done = True
            kernel.tell(order.task, what, order.place)
            kernel.board.outputs.set(what.signal, what.value)

        when = self._began + moment(made, order, what.at)
        change.timer = kernel.at(max(when, kernel.clock), act)

    def _to_rest(self) -> Planned:
        """The plan by which the arm stops at the end of the latest order."""
        assert self._flying is not None
        if self._queue[-1].stops:
            return self._flying
        if self._braking is None:
            made, _ = self._made(going_on=False)
            assert made is not None
            self._braking = made
        return self._braking

    def _refuse(self, kernel: Kernel, refusal: Refusal) -> None:
        """Ends the run where a motion cannot be made."""
        order = self._queue[refusal.index]
        self._queue = self._queue[: refusal.index]
        del kernel.log[order.row - 1 :]
        text = message(refusal, self.robot, order.place)
        kernel.fail(order.task, order.place, Ending("error", text))

    # ----------------------------------------------------------------------------- looking

    def stands(self) -> bool:
        return self.kernel is None or self.rest() <= self.kernel.clock

    def where(self) -> Standing:
        if self.kernel is not None:
            self.catch_up(self.kernel)
        joints = self._now()
        p, q = self.robot.fk(joints[None])
        six = [0.0] * max(6, len(joints))
        for place, value in zip(self.robot.places, joints.tolist(), strict=True):
            six[place] = value
        return Pose.of(p[0], q[0]), tuple(six)

    def _now(self) -> Floats:
        """(a,) joints."""
        if not self._queue or self.kernel is None or self._held:
            return self._joints
        made = self._to_rest()
        return np.asarray(made.plan.at(np.array([self.kernel.clock - self._began])).joints[0])

    def progress(self) -> tuple[float, float] | None:
        if self.kernel is None:
            return None
        self.catch_up(self.kernel)
        if not self._queue or self._held:
            return None
        made, gone = self._to_rest(), self.kernel.clock - self._began
        at = min(int(np.searchsorted(made.ends, gone, side="right")), len(self._queue) - 1)
        order = self._queue[at]
        place = made.plan.place(gone)
        left, whole = order.end - place, order.end - order.begin
        return max(left, 0.0), 100.0 if whole <= 0.0 else 100.0 * min(1.0 - left / whole, 1.0)

    # ------------------------------------------------------------------------- interfering

    def cut(self, task: Task) -> Standing:
        kernel = task.kernel
        self.hold(kernel)
        for order in self._queue:
            order.release = min(order.release, kernel.clock)
        self._queue, self._held = [], False
        return self.where()

    def hold(self, kernel: Kernel) -> None:
        """The arm stops at once, where it is."""
        self.catch_up(kernel)
        if self._held:
            return
        self._held = True
        if not self._queue:
            return
        made, gone = self._to_rest(), kernel.clock - self._began
        at = int(np.searchsorted(made.ends, gone + NO_TIME))
        stood = min(gone, float(made.ends[-1]))
        self.legs.append(Leg(self._began, made.plan, 0.0, stood))
        rest = self._queue[at:]
        if rest and rest[0].moved.via is not None:  # An arc goes on through a place still to come.
            middle = (gone + float(made.ends[at])) / 2.0
            p, q = self.robot.fk(made.plan.at(np.array([middle])).joints)
            rest[0].moved = replace(rest[0].moved, via=Pose.of(p[0], q[0]))
        self._joints = made.plan.at(np.array([stood])).joints[0]
        for order in self._queue:
            if order.release > kernel.clock:
                order.release = math.inf
            for change in order.changes:
                if change.timer is not None:
                    change.timer.cancelled = True
        self._queue = rest
        self._flying = self._braking = None

    def resume(self, kernel: Kernel) -> None:
        if not self._held:
            return
        self._held = False
        self._began = kernel.clock
        if self._queue:
            self._plan(kernel)

    def done(self) -> list[Leg]:
        """All that the arm went through until now."""
        legs = list(self.legs)
        if self._queue and self.kernel is not None and not self._held:
            made = self._to_rest()
            last = min(self.kernel.clock - self._began, float(made.ends[-1]))
            legs.append(Leg(self._began, made.plan, 0.0, last))
        return legs
