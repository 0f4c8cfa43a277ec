"""A flight: motions from one standstill to the next, planned together."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from assistant.program.arrays import Floats
from assistant.robots.robot import Robot
from assistant.robots.timing.course import ON_THE_SPOT, STILL, TURN_OF_ZONE, sums
from assistant.robots.timing.drive import Drive
from assistant.robots.timing.plan import Plan, plan_of
from assistant.robots.timing.rows import Moves
from assistant.virtual.events import Moved, OnWay, Place, Switched
from assistant.virtual.kernel.kernel import Timer
from assistant.virtual.kernel.task import Task
from assistant.virtual.motion.goals import Refusal, goals_of

AT_REST: Final = (0.0, 0.0)
GOING_ON: Final = (0.0, math.inf)


@dataclass(slots=True, eq=False)
class Change:
    """An output that is set on the way. timer: when, None before that is known."""

    what: Switched
    timer: Timer | None = None
    done: bool = False


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


@dataclass(slots=True, eq=False)
class Planned:
    """A plan of n orders. releases: (n,) seconds from its beginning at which each lets its program
    go on: at its end, or where its corner begins. ends: (n,) seconds at which each is over.
    joints: (n, a) there.
    """

    plan: Plan
    releases: Floats
    ends: Floats
    joints: Floats


def planned(
    orders: Sequence[Order], start: Floats, robot: Robot, drive: Drive, going_on: bool
) -> tuple[Planned | None, Refusal | None]:
    """The orders from joints (a,), as far as they can be followed.

    going_on: whether another one may follow the last, whose corner is then not braked for.
    """
    stops = np.array([order.stops for order in orders])
    if not going_on:
        stops[-1] = True
    goals = goals_of([order.moved for order in orders], stops, start, robot)
    if goals.moves is None:
        return None, goals.refusal
    moves, last = goals.moves, goals.rows
    whole = going_on and goals.refusal is None and not stops[-1]
    plan = plan_of(moves, start, robot, drive, GOING_ON if whole else AT_REST)
    places, ends = _borders(moves, plan)
    for order, row in zip(orders, last, strict=False):
        order.end = float(ends[row])
    begins = [0.0, *(float(ends[row]) for row in last)]
    for order, begin in zip(orders, begins, strict=False):
        order.begin = begin
    times = plan.passing(places[last]), plan.passing(ends[last])
    return Planned(plan, *times, moves.joints[last]), goals.refusal


def _borders(moves: Moves, plan: Plan) -> tuple[Floats, Floats]:
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


def moment(planned: Planned, order: Order, at: OnWay) -> float:
    """Seconds from the beginning of a plan, when something on the way of an order is come to."""
    begin, end = order.begin, order.end
    first, last = (float(v) for v in planned.plan.passing(np.array([begin, end])))
    match at.measure:
        case "time":
            when = last - at.amount
        case "start":
            when = _at(planned, begin + at.amount)
        case "end":
            when = _at(planned, end - at.amount)
        case "share":
            when = _at(planned, begin + (end - begin) * at.amount / 100.0)
    return min(max(when - at.ahead, first), last)


def _at(planned: Planned, place: float) -> float:
    return float(planned.plan.passing(np.array([place]))[0])
