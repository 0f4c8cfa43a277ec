"""A flight: motions from one standstill to the next, planned together."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np

from assistant.base.arrays import Floats, Rows
from assistant.program.geometry import Pose
from assistant.robots.robot import Robot
from assistant.robots.timing.course import ON_THE_SPOT, STILL, TURN_OF_ZONE, sums
from assistant.robots.timing.drive import Drive, drive_of
from assistant.robots.timing.plan import Plan, plan_of
from assistant.robots.timing.rows import Moves, joined
from assistant.virtual.events import Moved, OnWay, Place, Switched
from assistant.virtual.kernel.motion import Progress
from assistant.virtual.kernel.task import Task
from assistant.virtual.kernel.timers import Timer
from assistant.virtual.motion.goals import Refusal, goals_of

NO_TIME: Final = 1e-9
"""Seconds that are none."""


@dataclass(slots=True, eq=False)
class Change:
    """An output that is set on the way. timer: when, None before that is known."""

    what: Switched
    timer: Timer | None = None
    done: bool = False

    def cancel(self) -> None:
        """It does not come to pass when it was thought to."""
        if self.timer is not None:
            self.timer.cancelled = True


@dataclass(slots=True, eq=False)
class Order:
    """A motion that was commanded.

    place: of its statement. row: in the log, of the first event behind it. clock: of the kernel
    when it was commanded. stops: whether the arm comes to rest at its end. release: when the
    program goes on behind it. begin, end: where it lies on the way of its plan.
    """

    task: Task
    moved: Moved
    place: Place | None
    row: int
    clock: float
    stops: bool = False
    changes: list[Change] = field(default_factory=list)
    release: float = math.inf
    begin: float = 0.0
    end: float = 0.0

    def is_changed(self, release: float) -> bool:
        """Whether the program goes on at another time than was thought."""
        return self.release != release


@dataclass(slots=True, eq=False)
class Planned:
    """A plan of n orders. began: the time of the kernel at its beginning. first: seconds from there
    on which it holds. releases: (n,) seconds from its beginning at which each order lets its
    program go on: at its end, or where its corner begins. ends: (n,) seconds at which each is over.
    joints: (n, a) there. guessed: those on whose way the arm cannot stay in one branch.
    """

    plan: Plan
    began: float
    first: float
    releases: Floats
    ends: Floats
    joints: Floats
    guessed: tuple[int, ...] = ()

    def leg(self, until: float) -> Leg:
        """What the arm goes through until so many seconds from the beginning."""
        return Leg(self.began + self.first, self.plan, self.first, max(until, self.first))


@dataclass(frozen=True, slots=True, eq=False)
class Leg:
    """Part of a plan that the arm went through, from `first` to `last` of its seconds. begin: the
    time of the kernel at its first one.
    """

    begin: float
    plan: Plan
    first: float
    last: float

    def joints(self, clock: float) -> Floats:
        """(a,) at a time of the kernel."""
        return np.asarray(self.plan.at(np.array([self.first + clock - self.begin])).joints[0])


@dataclass(frozen=True, slots=True, eq=False)
class Start:
    """Where orders begin: at joints (a,), from rest at a time of the kernel. speed: None for that,
    else in mm/s where they go on from others, so that the arm is in the middle of the first of them
    at that time.
    """

    joints: Floats
    time: float
    speed: float | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Model:
    """What moves. drive: None for the robot's own with the tools that it carries. strict: see
    `goals_of`.
    """

    robot: Robot
    drive: Drive | None = None
    strict: bool = False


class Flight:
    """Orders from a start on."""

    def __init__(self, model: Model, start: Start) -> None:
        self.model, self.start = model, start
        self.orders: list[Order] = []
        self.refusal: Refusal | None = None
        self._moves: Moves | None = None
        self._last: Rows = np.empty(0, dtype=np.intp)

    def planned(self, going_on: bool) -> Planned | None:
        """The orders as far as they can be followed, which `refusal` tells; None for none of them.

        going_on: whether another one may follow the last, whose corner is then not braked for.
        """
        self._solve()
        if self._moves is None:
            return None
        last, orders = self._last, self.orders[: len(self._last)]
        stops = np.array([order.stops for order in orders])
        going_on = going_on and self.refusal is None and not stops[-1]
        stops[-1] |= not going_on
        rests = last[stops]
        entry, leaving = self._moves.entry.copy(), self._moves.leaving.copy()
        entry[rests] = leaving[rests] = 0.0
        moves = replace(self._moves, entry=entry, leaving=leaving)
        start = self.start
        speeds = start.speed or 0.0, math.inf if going_on else 0.0
        plan = plan_of(moves, start.joints, self.model.robot, self._drive(), speeds)
        places, ends = _corner_borders(moves, plan)
        begin = 0.0
        for order, end in zip(orders, ends[last].tolist(), strict=True):
            order.begin, order.end = begin, end
            begin = end
        times = plan.passing(places[last]), plan.passing(ends[last])
        first = 0.0 if start.speed is None else _time_at(plan, orders[0].end / 2.0)
        guessed = tuple(np.unique(np.searchsorted(last, plan.course.knots.guessed)).tolist())
        return Planned(plan, start.time - first, first, *times, moves.joints[last], guessed)

    def _solve(self) -> None:
        """Finds the joints at the ends of those orders that are new."""
        known = len(self._last)
        new = self.orders[known:]
        if not new or self.refusal is not None:
            return
        start = self.start.joints if self._moves is None else self._moves.joints[-1]
        motions = [order.moved for order in new]
        goals = goals_of(motions, start, self.model.robot, self.model.strict)
        if goals.refusal is not None:
            self.refusal = replace(goals.refusal, index=goals.refusal.index + known)
        if goals.moves is not None:
            before = 0 if self._moves is None else len(self._moves)
            self._last = np.concatenate([self._last, goals.rows + before])
            parts = [goals.moves] if self._moves is None else [self._moves, goals.moves]
            self._moves = joined(parts)

    def begin(self, index: int, start: Start) -> None:
        """The orders before one of them are over."""
        self.start, self.orders = start, self.orders[index:]
        if index >= len(self._last):
            self._moves, self._last = None, self._last[:0]
        elif index and self._moves is not None:
            rows = int(self._last[index - 1]) + 1
            self._moves, self._last = self._moves.rest(rows), self._last[index:] - rows

    def leave_out(self, index: int) -> None:
        """An order is refused and not made, nor are those behind it; what flies goes on."""
        self.refusal = None
        del self.orders[index:]

    def _drive(self) -> Drive:
        if self.model.drive is not None:
            return self.model.drive
        masses = [order.moved.how.mass for order in self.orders]
        known = [mass for mass in masses if mass is not None]
        return drive_of(self.model.robot, load=max(known) if len(known) == len(masses) else None)


def _corner_borders(moves: Moves, plan: Plan) -> tuple[Floats, Floats]:
    """(n,) along the course, where the corner at the end of each move begins, and that end."""
    course, n = plan.course, len(moves)
    ends = np.cumsum(sums(course.row, course.distance, n))
    if not len(course.step):
        return ends, ends
    knots = np.concatenate([[0.0], np.cumsum(course.distance)])
    # The knot at the end of each move, and the first one of its corner.
    at = np.searchsorted(course.row, np.arange(n), side="right")
    outside = np.where(course.inside, 0, np.arange(1, len(course.step) + 1))
    first = np.concatenate([[0], np.maximum.accumulate(outside)])[at]
    cut = course.corner[at]
    places = np.where(cut, knots[first] - course.room[first], ends)
    own = course.row == n - 1
    if own.any() and moves.entry[-1] > 0.0:
        length = float(course.knots.length[course.step[own]].sum())
        turn = float(course.knots.turn[course.step[own]].sum())
        zone = moves.entry[-1]
        if not (length > STILL and length > ON_THE_SPOT * turn):
            zone *= TURN_OF_ZONE
        whole = float(course.distance[own].sum())
        places[-1] = ends[-1] - min(zone, whole / 2.0)
    return places, ends


def trigger_time(planned: Planned, order: Order, at: OnWay) -> float:
    """Seconds from the beginning of a plan, when something on the way of an order is come to."""
    begin, end = order.begin, order.end
    first, last = (float(v) for v in planned.plan.passing(np.array([begin, end])))
    match at.measure:
        case "time":
            when = last - at.amount
        case "start":
            when = _time_at(planned.plan, begin + at.amount)
        case "end":
            when = _time_at(planned.plan, end - at.amount)
        case "share":
            when = _time_at(planned.plan, begin + (end - begin) * at.amount / 100.0)
    return min(max(when - at.ahead, first), last)


def progress(planned: Planned, orders: Sequence[Order], gone: float) -> Progress:
    """Of the order that is followed so many seconds from the beginning of a plan."""
    at = min(int(np.searchsorted(planned.ends, gone, side="right")), len(orders) - 1)
    begin, end = orders[at].begin, orders[at].end
    place = min(max(planned.plan.place(gone)[0], begin), end)
    if gone >= float(planned.ends[-1]) or end <= begin:
        return Progress()
    speed = float(planned.plan.at(np.array([gone])).speeds[0])
    return Progress(end - place, 100.0 * (place - begin) / (end - begin), speed)


def cut_plan(planned: Planned, orders: Sequence[Order], index: int) -> tuple[Leg, Start]:
    """A plan that is only followed to the middle of one of its orders, from which on they are
    planned anew.
    """
    order, plan = orders[index], planned.plan
    seconds = _time_at(plan, (order.begin + order.end) / 2.0)
    speed = plan.place(seconds)[1]
    start = Start(planned.joints[index - 1], planned.began + seconds, speed)
    return planned.leg(seconds), start


def stopped_leg(
    planned: Planned, orders: Sequence[Order], clock: float, robot: Robot
) -> tuple[Leg, Floats, list[Order]]:
    """A plan that is only followed until a time of the kernel; the joints (a,) where the arm stands
    then, and the orders still to come. An arc among them goes on through a place still to come.
    """
    gone, plan = clock - planned.began, planned.plan
    at = int(np.searchsorted(planned.ends, gone + NO_TIME))
    stood = min(gone, float(planned.ends[-1]))
    rest = list(orders[at:])
    if rest and rest[0].moved.via is not None:
        middle = (gone + float(planned.ends[at])) / 2.0
        p, q = robot.fk(plan.at(np.array([middle])).joints)
        rest[0].moved = replace(rest[0].moved, via=Pose.of(p[0], q[0]))
    return planned.leg(stood), plan.at(np.array([stood])).joints[0], rest


def _time_at(plan: Plan, place: float) -> float:
    return float(plan.passing(np.array([place]))[0])
