"""An arm whose motions take as long as they are planned to, and its track over time.

`Timed` serves all interpreters as their `Motion`; `CrArm` adds the override of a CR controller's
operating panel. A motion that the arm cannot make is refused with the controller's own message.
docs/simulating.md states the model and its limits.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import fields, replace
from functools import partial
from typing import Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats
from assistant.base.data_classes import dataclass
from assistant.program.geometry import Pose
from assistant.robots.robot import Robot
from assistant.robots.timing.plan import Drive
from assistant.virtual.events import Logged, Moved, Noted, Place, Switched
from assistant.virtual.kernel.flight import (
    NO_TIME,
    Change,
    Flight,
    Leg,
    Model,
    Order,
    Planned,
    Reason,
    Refusal,
    Start,
    cut_plan,
    progress,
    stopped_leg,
    trigger_time,
)
from assistant.virtual.kernel.kernel import Kernel, Progress, Standing
from assistant.virtual.kernel.task import Ending, Task

_RAPID_REFUSALS: Final[Mapping[Reason, str]] = {
    "reach": "50050: the position is outside of reach",
    "joints": "50027: joint {axis} is out of its range",
    "configuration": "50080: the position cannot be reached in the configuration of the target",
    "nowhere": "50050: where the motion leads is not known",
}
"""ABB, Operating manual Trouble shooting IRC5 (3HAC020738), 5 xxxx."""
_MELFA_REFUSALS: Final[Mapping[Reason, str]] = {
    "reach": "error 2602: the destination is outside of reach",
    "joints": "error 2602: joint {axis} is past its limit at the destination",
    "configuration": "error 2602: the destination cannot be reached with its structure flags",
    "nowhere": "error 2802: where the motion leads is not known",
}
"""CR750/CR751 troubleshooting, BFP-A8871: 2602 `DSTN pos. exceeds the limit`."""
_CORNER_PATH_FAILURE: Final = "50024: corner path failure, the arm stops in the point"
"""Warning of RAPID: the next motion comes too late for the corner."""


def _refusal_message(refusal: Refusal, robot: Robot, place: Place | None) -> str:
    """Why a motion is refused, with the place of its statement."""
    table = _RAPID_REFUSALS if "rapid" in robot.languages else _MELFA_REFUSALS
    text = table[refusal.reason].format(axis=refusal.axis)
    return text if place is None else f"{place[0]}:{place[1]}: {text}".lstrip(":")


_NEVER_LATE: Final = 0.1
"""Seconds behind the beginning of a corner at which the next motion still comes in time: as if the
controller had read it ahead. How far they read ahead no reference at hand tells."""
_MOST_AHEAD: Final = 20_000
"""Motions that wait to be planned, at most."""
_MOST_ORDERS: Final = 40
_LEAST_ORDERS: Final = 20
"""Motions of a flight that are planned together, where others wait for the time of each."""
_BRAKING: Final = 0.5
"""Seconds from a motion on, that the arm has made, in which a later one does not change it."""
_FEW_ORDERS: Final = 4
"""Motions that are worth to be planned no more."""
_GUESSED: Final = "{}: the arm cannot stay in one branch on its way; its joints there are guessed"


class Timed:
    """robot: of the catalogue. drive: its speeds and accelerations, None for its own with the tools
    that it carries. joints: (a,) where it stands at first, None for its home. ahead: seconds before
    its corner at which a motion that does not stop lets its program go on. strict: whether axes
    that turn further than the configuration of a target says are refused, beside another branch.
    """

    def __init__(
        self,
        robot: Robot,
        drive: Drive | None = None,
        joints: Sequence[float] | None = None,
        ahead: float = 0.0,
        strict: bool = False,
    ) -> None:
        self.robot, self.ahead = robot, ahead
        self.model = Model(robot, drive, strict)
        self.home = np.array(robot.home if joints is None else joints, dtype=np.float64)
        self.legs: list[Leg] = []
        self.kernel: Kernel | None = None
        # The flight at hand, and its plans where another motion follows and where none does.
        self._flight = Flight(self.model, Start(self.home, 0.0))
        self.behind = False
        self._held = False
        self._stored: list[list[Order]] = []
        self._flying: Planned | None = None
        self._braking: Planned | None = None

    # ---------------------------------------------------------------------------- commands

    def go(self, task: Task, moved: Moved, changes: Sequence[Switched] = ()) -> None:
        kernel = self.kernel = task.kernel
        # Outputs on the way need times, so that the program cannot run ahead of the arm here.
        on_way = [change for change in changes if change.at is not None]
        alone = kernel.alone and not on_way and not self._held
        # The program runs ahead as long as nothing can see
        # it; planning many motions at once is cheaper.
        if self.behind and (not alone or self._is_far_ahead(kernel)):
            self.catch_up(kernel)
        # A new motion may come too late for the corner of the one before, which is a stop then.
        if not self.behind:
            self._close(task)
            self._shorten()
        kernel.tell(task, moved)
        order = Order(task, moved, kernel.log[-1].place, len(kernel.log), kernel.clock)
        order.stops = moved.blend <= 0.0
        order.changes = [Change(change) for change in on_way]
        if not self._flight.orders:
            # A flight begins when its first motion is commanded, not when the arm came to rest.
            self._rise(kernel)
        self._flight.orders.append(order)
        if alone:
            self.behind = True
        else:
            self._plan(kernel)
            self._wait(task, order)
        for change in changes:
            if change.at is None:
                kernel.change(task, change)

    def settle(self, task: Task) -> None:
        kernel = task.kernel
        self.catch_up(kernel)
        if self._flight.orders and not self._flight.orders[-1].stops:
            order = self._flight.orders[-1]
            order.stops, order.release = True, math.inf
            kernel.stop_latest()
            self._plan(kernel)
            self._wait(task, order)

    def _rise(self, kernel: Kernel) -> None:
        """The arm begins to move now, or as soon as it stands."""
        start = self._flight.start
        self._flight.start = replace(start, time=max(start.time, kernel.clock))

    def _wait(self, task: Task, order: Order) -> None:
        """Until an order lets its program go on."""
        kernel = task.kernel
        # Other motions change the plan, and with it the time of this one: then wait anew.
        while (left := order.release - kernel.clock) > NO_TIME:
            other = partial(order.is_changed, order.release)
            task.wait(other, None if math.isinf(left) else left, "the arm to go on")
        self._rest_from_end(kernel)

    def _is_far_ahead(self, kernel: Kernel) -> bool:
        """True if the program must not queue more motions for planning."""
        orders = self._flight.orders
        late = not orders[-1].stops and kernel.clock - orders[-1].clock > _NEVER_LATE
        return late or len(orders) >= _MOST_AHEAD

    def _close(self, task: Task) -> None:
        """Before the next order: the arm has come to rest if that comes too late for a corner."""
        kernel = task.kernel
        self._rest_from_end(kernel)
        if not self._flight.orders or self._held:
            return
        last = self._flight.orders[-1]
        if not last.stops and kernel.clock - last.release > _NEVER_LATE:
            # Too late for the corner: the arm has stopped at the target.
            self._pass(self._to_rest(), len(self._flight.orders) - 1)
            if "rapid" in self.robot.languages:
                kernel.tell(task, Noted(_CORNER_PATH_FAILURE), last.place)

    # -------------------------------------------------------------------------------- time

    def catch_up(self, kernel: Kernel) -> None:
        if not self.behind:
            return
        self.behind = False
        made, last = self._flight.planned(going_on=True), self._flight.orders[-1]
        if made is not None:
            self._set_times(kernel, made)
        if self._flight.refusal is not None:
            self._refuse(kernel, self._flight.refusal)
        elif kernel.clock > kernel.most_time:
            # Rows after the longest time were only logged since the program ran ahead.
            while kernel.log and kernel.log[-1].time > kernel.most_time:
                kernel.log.pop()
            kernel.fail(last.task, last.place, Ending("time", f"more than {kernel.most_time:g} s"))

    def _set_times(self, kernel: Kernel, made: Planned) -> None:
        """Gives what was logged behind orders that the program ran ahead of its time.

        Between motions that stop, the arm stands as long as the statements there take.
        """
        orders, log = self._flight.orders, kernel.log
        self._note(kernel, made)
        latest = made.began + made.first
        for i, order in enumerate(orders[: len(made.ends)]):
            if math.isfinite(order.release):
                # Planned and waited for before: its time is a fact.
                latest = max(latest, order.release)
                continue
            follows = orders[i + 1] if i + 1 < len(orders) else None
            rows = len(log) if follows is None else follows.row
            spent = (kernel.clock if follows is None else follows.clock) - order.clock
            order.release = made.began + float(made.releases[i])
            for row in log[order.row : rows]:
                # The rows are as long after the motion as the
                # program was when it ran ahead; never backwards.
                row.time = latest = max(latest, order.release + row.time - order.clock)
            latest = max(latest, order.release + spent)
            if order.stops and spent > 0.0:
                end = float(made.ends[i])
                # The arm stood while the program went on: the rest of the plan shifts by that time.
                self.legs.append(made.leg(end))
                made = replace(made, began=made.began + spent, first=end)
        kernel.clock = latest
        self._flying = made
        stops = [i for i in range(len(made.ends)) if orders[i].stops]
        if stops and self._flight.refusal is None:
            self._pass(made, stops[-1])
            self._flying = self._flight.planned(going_on=True)

    def _pass(self, made: Planned, last: int) -> None:
        """The arm has come to rest at the end of an order, and the others begin there."""
        end = float(made.ends[last])
        if end > made.first:
            self.legs.append(made.leg(end))
        self._flight.begin(last + 1, Start(made.joints[last], made.began + end))
        self._flying = self._braking = None

    def _shorten(self) -> None:
        """A long flight is planned from one of its latest orders on, which the others do not
        change any more.
        """
        # Every new motion plans the flight again, which would cost the square of its length.
        made, orders = self._flying, self._flight.orders
        if made is None or self._held or self.kernel is None:
            return
        over = self.kernel.clock - made.began - _BRAKING
        at = min(int(np.searchsorted(made.ends, over)), len(orders) - _FEW_ORDERS)
        if len(orders) > _MOST_ORDERS:
            at = max(at, len(orders) - _LEAST_ORDERS)
        # Cutting costs a plan; only many motions that are over are worth it.
        if at >= _FEW_ORDERS:
            leg, start = cut_plan(made, orders, at)
            self.legs.append(leg)
            self._flight.begin(at, start)
            self._flying = self._braking = None

    def _rest_from_end(self, kernel: Kernel) -> None:
        """The flight is over if the arm has come to its end and stops there."""
        if self._flight.orders and self._flying is not None and not self._held:
            last = self._flight.orders[-1]
            if last.stops and kernel.clock >= last.release - NO_TIME:
                self._pass(self._flying, len(self._flight.orders) - 1)

    def rest(self) -> float:
        if self.kernel is not None:
            self.catch_up(self.kernel)
        if not self._flight.orders or self.kernel is None or self.kernel.ending is not None:
            return -math.inf
        if self._held:
            return math.inf
        return self._to_rest().began + float(self._to_rest().ends[-1])

    # ---------------------------------------------------------------------------- planning

    def _plan(self, kernel: Kernel) -> None:
        """Plans the orders that there are; another one may follow."""
        if self._held:
            return
        made = self._flight.planned(going_on=True)
        if self._flight.refusal is not None:
            self._refuse(kernel, self._flight.refusal)
        assert made is not None
        self._flying, self._braking = made, None
        self._note(kernel, made)
        for order, release in zip(self._flight.orders, made.releases.tolist(), strict=True):
            # Times that are over are facts; a later motion cannot change them.
            if order.release > kernel.clock:
                early = 0.0 if order.stops else self.ahead
                order.release = max(made.began + release - early, kernel.clock)
            for change in order.changes:
                self._schedule(kernel, made, order, change)

    def _note(self, kernel: Kernel, made: Planned) -> None:
        """Says what is only assumed of the orders."""
        for index in made.guessed:
            place = self._flight.orders[index].place
            where = "a motion" if place is None else f"{place[0]}:{place[1]}".lstrip(":")
            kernel.note(_GUESSED.format(where))

    def _schedule(self, kernel: Kernel, made: Planned, order: Order, change: Change) -> None:
        """Has an output set when the arm comes to its place."""
        if change.done:
            return
        # The plan has changed: the output comes at another time than planned before.
        change.cancel()
        what = change.what
        assert what.at is not None

        def act() -> None:
            change.done = True
            kernel.change(order.task, what, order.place)

        when = made.began + trigger_time(made, order, what.at)
        change.timer = kernel.at(max(when, kernel.clock), act)

    def _to_rest(self) -> Planned:
        """The plan by which the arm stops at the end of the latest order."""
        assert self._flying is not None
        if self._flight.orders[-1].stops:
            return self._flying
        # Made on demand: most flights are never looked at while another motion may still follow.
        if self._braking is None:
            self._braking = self._flight.planned(going_on=False)
            assert self._braking is not None
        return self._braking

    def _refuse(self, kernel: Kernel, refusal: Refusal) -> None:
        """Ends the run where a motion cannot be made."""
        order = self._flight.orders[refusal.index]
        # Events after a refused motion did not happen: the program ran ahead of the refusal.
        del kernel.log[order.row :]
        # A live run goes on with the motions before the refused one.
        if kernel.live is not None:
            self._flight.leave_out(refusal.index)
        text = _refusal_message(refusal, self.robot, order.place)
        kernel.fail(order.task, order.place, Ending("error", text))

    # ----------------------------------------------------------------------------- looking

    def stands(self) -> bool:
        if self._held and self._flight.orders:
            return False
        return self.kernel is None or self.rest() <= self.kernel.clock

    def where(self) -> Standing:
        if self.kernel is not None:
            self.catch_up(self.kernel)
        joints = self._now()
        p, q = self.robot.flange_poses(joints[None])
        six = [0.0] * max(6, len(joints))
        for place, value in zip(self.robot.places, joints.tolist(), strict=True):
            six[place] = value
        return Pose.of(p[0], q[0]), tuple(six)

    def _now(self) -> Floats:
        """(a,) joints."""
        if not self._flight.orders or self.kernel is None or self._held:
            return self._at_rest()
        made = self._to_rest()
        return np.asarray(made.plan.at(np.array([self.kernel.clock - made.began])).joints[0])

    def _at_rest(self) -> Floats:
        """(a,) joints, also while the arm still comes to rest."""
        if self.kernel is None or not self.legs or self.kernel.clock >= self._flight.start.time:
            return self._flight.start.joints
        return self.legs[-1].joints(self.kernel.clock)

    def progress(self) -> Progress:
        if self.kernel is not None:
            self.catch_up(self.kernel)
        orders = self._flight.orders
        if self.kernel is None or not orders or self._held:
            return Progress()
        made = self._to_rest()
        return progress(made, orders, self.kernel.clock - made.began)

    # ------------------------------------------------------------------------- interfering

    def cut(self, task: Task) -> Standing:
        kernel = task.kernel
        self.hold(kernel)
        for order in self._flight.orders:
            # The program does not wait for a motion that will not be made.
            order.release = min(order.release, kernel.clock)
        self._flight, self._held = Flight(self.model, self._flight.start), False
        return self.where()

    def lead(self, kernel: Kernel, joints: Sequence[float]) -> None:
        self.kernel = kernel
        self.catch_up(kernel)
        start = Start(np.array(self.robot.own_joints(joints), dtype=np.float64), kernel.clock)
        self._flight, self._held = Flight(self.model, start), False
        self._flying = self._braking = None

    def hold(self, kernel: Kernel) -> None:
        """The arm stops at once, where it is."""
        self.catch_up(kernel)
        if self._held:
            return
        self._held = True
        if not self._flight.orders:
            return
        leg, joints, rest = stopped_leg(
            self._to_rest(), self._flight.orders, kernel.clock, self.robot
        )
        self.legs.append(leg)
        start = Start(joints, kernel.clock)
        for order in self._flight.orders:
            if order.release > kernel.clock:
                # The program waits for these until the arm goes on.
                order.release = math.inf
            for change in order.changes:
                change.cancel()
        self._flight = Flight(self.model, start)
        self._flight.orders = rest
        self._flying = self._braking = None

    def resume(self, kernel: Kernel) -> None:
        if not self._held:
            return
        self._held = False
        self._rise(kernel)
        if self._flight.orders:
            self._plan(kernel)

    def store(self, kernel: Kernel) -> None:
        self.hold(kernel)
        self._stored.append(self._flight.orders)
        self._flight = Flight(self.model, self._flight.start)
        self._held = False

    def restore(self, task: Task) -> None:
        self.settle(task)
        self.hold(task.kernel)
        self._flight.orders = self._stored.pop() if self._stored else []

    def done(self) -> list[Leg]:
        """All that the arm went through until now."""
        legs = list(self.legs)
        if self._flight.orders and self.kernel is not None and not self._held:
            made = self._to_rest()
            legs.append(made.leg(min(self.kernel.clock - made.began, float(made.ends[-1]))))
        return legs

    def forget(self) -> None:
        # The last leg tells where the arm is while it still comes to rest.
        del self.legs[:-1]


PERIOD: Final = 0.01
"""Seconds between samples."""
_MOST_SAMPLES: Final = 1_000_000


@dataclass(frozen=True, slots=True, eq=False)
class Track:
    """k samples. t: (k,) seconds. position: (k, 3) mm and quaternion: (k, 4) of the tool in the
    base. joints: (k, a) degrees. speed: (k,) mm/s of the tool. signals: (k, s) what the outputs
    were set to, 0 before, by their names.
    """

    t: Floats
    position: Floats
    quaternion: Floats
    joints: Floats
    speed: Floats
    signals: Floats
    names: tuple[str, ...]

    def columns(self) -> dict[str, np.ndarray]:
        """By name, as a file holds them."""
        found = {f.name: getattr(self, f.name) for f in fields(self) if f.name != "names"}
        return {**found, "signal_names": np.array(self.names, dtype=np.str_)}


def track_of(motion: Timed, log: Sequence[Logged], seconds: float, period: float = PERIOD) -> Track:
    """Samples from 0 to the end of a run, farther apart where there would be too many.

    seconds: that the run took.
    """
    # Too many samples of a long run would fill the memory: the period grows instead.
    period = max(period, seconds / _MOST_SAMPLES)
    # 1e-9 absorbs rounding: 0.29 / 0.01 is 28.999999999999996 in floats, and 29 periods.
    t = np.arange(int(seconds / period + 1e-9) + 1, dtype=np.float64) * period
    legs = motion.done()
    begins = np.array([leg.begin for leg in legs])
    index = np.searchsorted(begins, t, side="right") - 1
    p, q = motion.robot.flange_poses(motion.home[None])
    position, quaternion = np.repeat(p, len(t), axis=0), np.repeat(q, len(t), axis=0)
    joints = np.repeat(motion.home[None], len(t), axis=0)
    speed = np.zeros(len(t))
    for at in np.unique(index[index >= 0]):
        leg, rows = legs[at], np.flatnonzero(index == at)
        inside = leg.first + t[rows] - leg.begin
        found = leg.plan.at(np.minimum(inside, leg.last))
        position[rows], quaternion[rows], joints[rows] = (
            *(found.positions, found.quaternions, found.joints),
        )
        speed[rows] = np.where(inside < leg.last, found.speeds, 0.0)
    names, signals = _signal_samples(log, t)
    # Both signs of a quaternion are the same turn:
    # neighbours get the same one, to interpolate well.
    quaternion = rotations.unflipped(quaternion)
    return Track(t, position, quaternion, joints, speed, signals, names)


def _signal_samples(log: Sequence[Logged], t: Floats) -> tuple[tuple[str, ...], Floats]:
    changes = [(row.time, row.what) for row in log if isinstance(row.what, Switched)]
    names = tuple(dict.fromkeys(what.signal for _, what in changes))
    signals = np.zeros((len(t), len(names)))
    for time, what in changes:
        signals[np.searchsorted(t, time - 1e-9) :, names.index(what.signal)] = what.value
    return names, signals


_FULL_OVERRIDE: Final = 100.0


class CrArm(Timed):
    """override: percent of the operating panel (OVRD=), which holds for motions that begin."""

    def __init__(self, robot: Robot, joints: Sequence[float]) -> None:
        super().__init__(robot, joints=joints)
        self.override = _FULL_OVERRIDE

    def go(self, task: Task, moved: Moved, changes: Sequence[Switched] = ()) -> None:
        super().go(task, _scaled_speed(moved, self.override / _FULL_OVERRIDE), changes)

    def halt(self) -> None:
        """Ends all motions where the arm is."""
        if self.kernel is not None:
            self.hold(self.kernel)
            # Leading to where the arm is forgets the held motions, which a reset does not resume.
            self.lead(self.kernel, self.where()[1])


def _scaled_speed(moved: Moved, share: float) -> Moved:
    """A motion at a share of its speed."""
    if share >= 1.0:
        return moved
    how = replace(moved.how, rotation=moved.how.rotation * share)
    if moved.speed is not None:
        return replace(moved, speed=moved.speed * share, how=how)
    percent = _FULL_OVERRIDE if moved.percent is None else moved.percent
    return replace(moved, percent=percent * share, how=how)
