"""A flight: motions from one standstill to the next, planned together, and their goal joints.

`_goals_of` solves the goals of motions, one row each (two of an arc); a `Flight` plans them in one
course and tells where the arm is at a time.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import field, replace
from typing import Final, Literal

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats, Rows, norms
from assistant.base.data_classes import dataclass
from assistant.program.geometry import Frame, Pose, Tool
from assistant.program.motion import UNSTATED, Kind
from assistant.robots.arms.arm import CLOSING
from assistant.robots.motion.interpolation import arcs_of
from assistant.robots.motion.run import from_flange
from assistant.robots.robot import Robot
from assistant.robots.timing.course import (
    NO_STEP,
    ON_THE_SPOT,
    TURN_OF_ZONE,
    Mount,
    Moves,
    join_moves,
    sums_by_move,
)
from assistant.robots.timing.plan import Drive, Plan, drive_of, plan_of
from assistant.virtual.events import Moved, OnWay, Place, Switched
from assistant.virtual.kernel.kernel import Progress, Timer
from assistant.virtual.kernel.task import Task

Reason = Literal["reach", "joints", "configuration", "nowhere"]

_ANY_CONFIGURATION: Final = (UNSTATED, 0, 0, 0, 0, 0)
_KIND_OF_MOVE: Final = {"joint": Kind.JOINT, "linear": Kind.LINEAR, "circular": Kind.END}


@dataclass(frozen=True, slots=True)
class Refusal:
    """Why the arm cannot go through a motion, which is the `index`-th of some.

    reason: out of `reach`, `joints` past their limits, in another `configuration` only, or what
    leads `nowhere` that is known. axis: the joint that passes its limit, or "".
    """

    index: int
    reason: Reason
    axis: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class _Goals:
    """Motions in columns: one row each, of an arc two.

    rows: (n,) the last row of each motion. moves: of the motions before the first that is refused.
    """

    moves: Moves | None
    rows: Rows
    refusal: Refusal | None


def _goals_of(motions: Sequence[Moved], start: Floats, robot: Robot, strict: bool) -> _Goals:
    """The moves of motions from joints (a,).

    strict: whether axes that turn further than a configuration says are refused; else they turn as
    little as they can in its arm branch.
    """
    rows = _GoalRows(motions, robot)
    joints, refusal = rows.joints(start, strict)
    last = rows.last if refusal is None else rows.last[: refusal.index]
    count = int(last[-1]) + 1 if len(last) else 0
    joints = joints[:count]
    if not count:
        return _Goals(None, last, refusal)
    positions, quaternions = rows.tips(joints)
    of = rows.of[:count]
    how = [motion.how for motion in motions]

    def column(values: Sequence[float]) -> Floats:
        return np.asarray(np.array(values, dtype=np.float64)[of])

    behind = [m.blend if m.how.behind is None else m.how.behind for m in motions]
    tcp = column([math.inf if m.speed is None else m.speed for m in motions])
    rotation = column([h.rotation for h in how])
    if any(h.seconds is not None for h in how):
        _set_times(motions, of, (positions, quaternions), rows, start, (tcp, rotation))
    kinds = rows.kinds[:count]
    moves = Moves(
        kinds=kinds,
        joints=joints,
        positions=positions,
        quaternions=quaternions,
        mount=rows.mount[:count],
        mounts=rows.mounts,
        tcp=tcp,
        rotation=rotation,
        percent=column([np.nan if m.percent is None else m.percent for m in motions]),
        override=np.ones(count),
        acceleration=column([h.acceleration for h in how]),
        deceleration=column([h.deceleration for h in how]),
        # A via point is passed on the arc, without a corner.
        entry=np.where(kinds == Kind.VIA, np.inf, column([m.blend for m in motions])),
        leaving=column(behind),
    )
    return _Goals(moves, last, refusal)


def _set_times(
    motions: Sequence[Moved],
    of: Rows,
    tips: tuple[Floats, Floats],
    rows: _GoalRows,
    start: Floats,
    speeds: tuple[Floats, Floats],
) -> None:
    """The speeds of motions that state how long they are to take."""
    # The start counts as a row before the first, so that each difference is one motion.
    p, q = (np.concatenate([one, end]) for one, end in zip(rows.tip_at(start), tips, strict=True))
    lengths, turns = norms(np.diff(p, axis=0)), rotations.angle_between(q[:-1], q[1:])
    vias = np.flatnonzero(rows.kinds[: len(of)] == Kind.VIA)
    arcs = arcs_of(vias, p[vias], p[vias + 1], p[vias + 2]) if len(vias) else None
    if arcs is not None:
        lengths[arcs.rows] = arcs.lengths
    for i in np.unique(of):
        seconds = motions[i].how.seconds
        if seconds is not None and seconds > 0.0:
            own = of == i
            for values, speed in zip((lengths, turns), speeds, strict=True):
                way = float(values[own].sum())
                # Without a way there is no speed to keep: the other quantity sets the time.
                speed[own] = way / seconds if way > 0.0 else math.inf


def refusal_of(motion: Moved, robot: Robot) -> Refusal | None:
    """Return why an arm cannot end a motion where it leads, None if it can."""
    _, refusal = _GoalRows([motion], robot).joints(np.array(robot.home, dtype=float), False)
    return refusal


class _GoalRows:
    """n motions as k rows. of: (k,) the motion of each; last: (n,) the last row of each."""

    def __init__(self, motions: Sequence[Moved], robot: Robot) -> None:
        self.motions, self.robot = motions, robot
        flanges: list[Pose | None] = []
        of: list[int] = []
        kinds: list[int] = []
        tools: dict[Pose, int] = {}
        for index, motion in enumerate(motions):
            if motion.via is not None:
                flanges.append(motion.via)
                of.append(index)
                kinds.append(Kind.VIA)
            flanges.append(motion.flange)
            of.append(index)
            kinds.append(_KIND_OF_MOVE[motion.kind])
            tools.setdefault(motion.tool, len(tools))
        self.of, self.kinds = np.array(of), np.array(kinds, dtype=np.uint8)
        # The last row of each motion: an arc has two, its via point and its end.
        self.last = np.searchsorted(self.of, np.arange(len(motions)), side="right") - 1
        self.mounts = tuple(Mount(Tool(tip), Frame()) for tip in tools)
        mount = np.array([tools[motion.tool] for motion in motions], dtype=np.int32)
        self.mount = mount[self.of]
        self.known = np.array([flange is not None for flange in flanges])
        poses = [flange or Pose() for flange in flanges]
        self.p = np.array([pose.position for pose in poses])
        self.q = np.array([pose.quaternion for pose in poses])

    def joints(self, start: Floats, strict: bool) -> tuple[Floats, Refusal | None]:
        """(k, a) at the ends, and the first that cannot be."""
        robot, motions = self.robot, self.motions
        joints = np.full((len(self.of), len(robot.axes)), np.nan)
        named = np.array([motion.joints is not None for motion in motions])[self.of]
        stated = np.array([m.how.configuration is not None for m in motions])[self.of]
        stated &= ~named & (self.kinds != Kind.VIA) & robot.arm.named
        for row in np.flatnonzero(named):
            given = motions[self.of[row]].joints
            assert given is not None
            # RAPID states six robot axes; a longer arm gets zeros for those that it does not name.
            own = robot.own_joints((*given, *(0.0,) * 6)[: max(6, len(given))])
            if len(own) == len(robot.axes):
                joints[row] = own
        open_, branch = ~stated & ~named & self.known, np.full(len(self.of), -1)
        rows = np.flatnonzero(stated)
        if len(rows):
            wanted = np.array(
                [motions[i].how.configuration or _ANY_CONFIGURATION for i in self.of[rows]]
            )
            joints[rows] = robot.joints_of(self.p[rows], self.q[rows], wanted)
            if not strict:
                branch[rows] = robot.branch_of(wanted)
                open_[rows] = np.isnan(joints[rows]).any(axis=1)
        rows = np.flatnonzero(open_)
        if len(rows):
            self._nearest(joints, rows, branch[rows], start)
        bad = np.flatnonzero(~robot.inside(joints))
        if not len(bad):
            return joints, None
        return joints, self._refusal(int(bad[0]), joints)

    def _nearest(self, joints: Floats, rows: Rows, branch: Rows, start: Floats) -> None:
        """Sets rows to the joints in a branch, -1 for any, that are nearest to those before."""
        robot = self.robot
        # All branches at once: the solver works in columns, only the choice goes from row to row.
        solved, excess = robot.solve(self.p[rows], self.q[rows])
        found = np.ascontiguousarray(np.moveaxis(solved, (2, 1), (0, 1)))
        found[excess.T >= CLOSING] = np.nan
        found[(branch[:, None] >= 0) & (np.arange(robot.branches) != branch[:, None])] = np.nan
        for place, row in enumerate(rows):
            # Each row begins where the one before ends, so
            # that the choice cannot be made in columns.
            at = joints[row - 1] if row else start
            if not np.isfinite(at).all():  # unreachable before: no row after it can be chosen
                return
            # An axis that turns several times: the turn
            # nearest to where it is, if the limits allow it.
            near = at + robot.wound(found[place] - at)
            both = np.concatenate([near, found[place]])
            far = np.abs(both - at).max(axis=1)
            far[~robot.inside(both)] = np.inf
            best = int(far.argmin())
            if np.isfinite(far[best]):
                joints[row] = both[best]
        # A solution beside the target, as the solver gives for poses out of reach, is none.
        joints[rows[~robot.closes(joints[rows], self.p[rows], self.q[rows])]] = np.nan

    def _refusal(self, row: int, joints: Floats) -> Refusal:
        robot, index = self.robot, int(self.of[row])
        if np.isfinite(joints[row]).all():
            low, high = robot.limits.T
            past = np.maximum(low - joints[row], joints[row] - high)
            return Refusal(index, "joints", robot.axes[int(past.argmax())])
        if not self.known[row]:
            return Refusal(index, "nowhere")
        # Reached in another branch: the configuration refuses it, not the reach.
        found, valid = robot.ik(self.p[row : row + 1], self.q[row : row + 1])
        if valid.any():
            return Refusal(index, "configuration")
        near = found[0][np.isfinite(found[0]).all(axis=1)]
        if not len(near):
            return Refusal(index, "reach")
        # The branch closest to its limits names the axis.
        low, high = robot.limits.T
        past = np.maximum(low - near, near - high).max(axis=1)
        best = near[int(past.argmin())]
        return Refusal(
            index, "joints", robot.axes[int(np.maximum(low - best, best - high).argmax())]
        )

    def tips(self, joints: Floats) -> tuple[Floats, Floats]:
        """(m, 3), (m, 4) of the tools at the ends of the first m rows."""
        count = len(joints)
        p, q = np.empty((count, 3)), np.empty((count, 4))
        for index, mount in enumerate(self.mounts):
            rows = np.flatnonzero((self.mount[:count] == index) & self.known[:count])
            p[rows], q[rows] = from_flange(self.p[rows], self.q[rows], mount.tool, mount.frame)
            # A motion to joints without a pose: the pose follows from the joints.
            rows = np.flatnonzero((self.mount[:count] == index) & ~self.known[:count])
            p[rows], q[rows] = mount.tip(self.robot, joints[rows])
        return p, q

    def tip_at(self, start: Floats) -> tuple[Floats, Floats]:
        """(1, 3), (1, 4) of the first tool where the arm begins."""
        mount: Mount = self.mounts[self.mount[0]]
        return mount.tip(self.robot, start[None])


NO_TIME: Final = 1e-9
"""Seconds that count as zero."""


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

    place: source location of its statement. row: index in the log of the first event after it.
    clock: kernel time when it was commanded. stops: whether the arm comes to rest at its end.
    release: time at which the program continues after it. begin, end: its section of the path of
    its plan.
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
        """True if the program continues at another time than expected."""
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
        """Return the part of the plan that the arm covers until so many seconds from the
        beginning.
        """
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
    """Start of orders: at joints (a,), from rest at a time of the kernel. speed: None for a start
    from rest; otherwise mm/s of a continued motion, so that the arm is in the middle of the first
    order at that time.
    """

    joints: Floats
    time: float
    speed: float | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Model:
    """Model of the moving arm. drive: None for the robot's default with the tools that it carries.
    strict: see `_goals_of`.
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
        # No corner is cut on either side of a stop.
        rests = last[stops]
        # Copies: the moves are planned again when the next order follows.
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
        # A continued flight begins in the middle of its first order: its first half is over.
        guessed = tuple(np.unique(np.searchsorted(last, plan.course.knots.guessed)).tolist())
        return Planned(plan, start.time - first, first, *times, moves.joints[last], guessed)

    def _solve(self) -> None:
        """Finds the joints at the ends of those orders that are new."""
        known = len(self._last)
        new = self.orders[known:]
        if not new or self.refusal is not None:
            return
        # Solved orders stay as they are: the next ones begin at their end.
        start = self.start.joints if self._moves is None else self._moves.joints[-1]
        motions = [order.moved for order in new]
        goals = _goals_of(motions, start, self.model.robot, self.model.strict)
        if goals.refusal is not None:
            self.refusal = replace(goals.refusal, index=goals.refusal.index + known)
        if goals.moves is not None:
            before = 0 if self._moves is None else len(self._moves)
            self._last = np.concatenate([self._last, goals.rows + before])
            parts = [goals.moves] if self._moves is None else [self._moves, goals.moves]
            self._moves = join_moves(parts)

    def begin(self, index: int, start: Start) -> None:
        """The orders before one of them are over."""
        # Rows of an arc are two, so that orders and rows have to be counted apart.
        self.start, self.orders = start, self.orders[index:]
        if index >= len(self._last):
            self._moves, self._last = None, self._last[:0]
        elif index and self._moves is not None:
            rows = int(self._last[index - 1]) + 1
            self._moves, self._last = self._moves.rest(rows), self._last[index:] - rows

    def leave_out(self, index: int) -> None:
        """Drop a refused order and those after it; the orders before it continue."""
        self.refusal = None
        del self.orders[index:]

    def _drive(self) -> Drive:
        if self.model.drive is not None:
            return self.model.drive
        masses = [order.moved.how.mass for order in self.orders]
        # Masses that are unknown for one motion leave the load unknown for the flight.
        known = [mass for mass in masses if mass is not None]
        return drive_of(self.model.robot, load=max(known) if len(known) == len(masses) else None)


def _corner_borders(moves: Moves, plan: Plan) -> tuple[Floats, Floats]:
    """(n,) along the course, where the corner at the end of each move begins, and that end."""
    course, n = plan.course, len(moves)
    ends = np.cumsum(sums_by_move(course.row, course.distance, n))
    if not len(course.step):
        return ends, ends
    knots = np.concatenate([[0.0], np.cumsum(course.distance)])
    # The knot at the end of each move, and the first one of its corner.
    at = np.searchsorted(course.row, np.arange(n), side="right")
    outside = np.where(course.inside, 0, np.arange(1, len(course.step) + 1))
    first = np.concatenate([[0], np.maximum.accumulate(outside)])[at]
    cut = course.corner[at]
    places = np.where(cut, knots[first] - course.room[first], ends)
    # The last motion's corner is not planned: its zone tells where it would begin.
    own = course.row == n - 1
    if own.any() and moves.entry[-1] > 0.0:
        length = float(course.knots.length[course.step[own]].sum())
        turn = float(course.knots.turn[course.step[own]].sum())
        zone = moves.entry[-1]
        # A turn on the spot has no length; its zone counts in degrees.
        if not (length > NO_STEP and length > ON_THE_SPOT * turn):
            zone *= TURN_OF_ZONE
        whole = float(course.distance[own].sum())
        # No corner takes more than half of its motion.
        places[-1] = ends[-1] - min(zone, whole / 2.0)
    return places, ends


def trigger_time(planned: Planned, order: Order, at: OnWay) -> float:
    """Return the seconds from the beginning of a plan until a position on the path of an order is
    reached.
    """
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
    # A trigger placed outside of the motion fires at its beginning or its end.
    return min(max(when - at.ahead, first), last)


def progress(planned: Planned, orders: Sequence[Order], gone: float) -> Progress:
    """Return the progress of the order that runs so many seconds after the beginning of a plan."""
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
    # The joints before the cut order: the new flight plans that order again from its start.
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
    # The rest of an arc needs another via point, since the stop may be behind the first one.
    if rest and rest[0].moved.via is not None:
        middle = (gone + float(planned.ends[at])) / 2.0
        p, q = robot.flange_poses(plan.at(np.array([middle])).joints)
        rest[0].moved = replace(rest[0].moved, via=Pose.of(p[0], q[0]))
    return planned.leg(stood), plan.at(np.array([stood])).joints[0], rest


def _time_at(plan: Plan, place: float) -> float:
    return float(plan.passing(np.array([place]))[0])
