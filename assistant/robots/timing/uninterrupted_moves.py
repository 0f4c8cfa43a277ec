"""Moves without a stop of the program between them, as straight stretches of the joints.

The joints are solved anywhere on a course instead of taken between its knots. In a corner the rest
of the move before and the begun part of the move after are added, as `course` states: tool poses
for lines and arcs, joints for joint moves.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import field
from functools import cached_property
from itertools import accumulate
from typing import Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats, Rows, Truths, max_abs
from assistant.base.data_classes import dataclass
from assistant.program.motion import Kind
from assistant.robots.arms.arm import CLOSING
from assistant.robots.motion.interpolation import ToolPaths, joints_along
from assistant.robots.robot import IN_LINE
from assistant.robots.timing.course import Course, MoveEnds
from assistant.robots.timing.plan import CoursePlaces, Plan
from assistant.robots.timing.segments import Segment

_OTHER_BRANCH: Final = 20.0
"""degrees (mm) from the joints between knots beyond which a solution is in another branch."""

SolvedJoints = tuple[Floats, Truths]
"""Joints (m, a), and (m,) whether they were solved; the others are those between the knots."""


class CourseJoints:
    """Joints along one course."""

    def __init__(self, course: Course) -> None:
        self.course, self.moves, self.robot = course, course.moves, course.robot
        self.free = self.moves.kinds == Kind.JOINT
        self.unsolved = np.zeros(len(self.moves), dtype=bool)
        self.unsolved[course.knots.guessed] = True

    @cached_property
    def ends(self) -> MoveEnds:
        return MoveEnds(self.moves, self.course.knots.joints[0], self.robot)

    @cached_property
    def begins(self) -> Floats:
        """(n + 1,) mm along the course at which each move begins, and the last one ends."""
        return np.concatenate([[0.0], np.cumsum(self.course.scale)])

    @cached_property
    def branches(self) -> Rows:
        """(n,) of the ends of the moves."""
        return self.robot.branch_of(self.robot.configuration(self.moves.joints))

    def joints(self, places: Floats, near: Floats) -> SolvedJoints:
        """At places (m,) mm along the course. near: (m, a) joints between the knots there."""
        if not len(self.moves):
            return near, np.ones(len(places), dtype=bool)
        zones = self.course.zones
        row = np.searchsorted(self.begins[1:], places)
        row = np.minimum(row, len(self.moves) - 1)
        out, solved = near.copy(), np.ones(len(places), dtype=bool)
        corner = self._corner(places)
        plain = corner < 0
        some = np.flatnonzero(plain & self.free[row])
        if len(some):
            out[some] = self._between_joints(row[some], places[some])
        some = np.flatnonzero(plain & ~self.free[row])
        if len(some):
            out[some], solved[some] = self._on_move(row[some], places[some], near[some])
        if not len(zones.place):
            return out, solved
        before, after = zones.before[corner], zones.after[corner]
        lines = ~self.free[before] & ~self.free[after]
        lines &= self.moves.mount[before] == self.moves.mount[after]
        for which, solve in ((lines, self._in_corner), (~lines, self._joints_in_corner)):
            some = np.flatnonzero(which & ~plain)
            if len(some):
                out[some], solved[some] = solve(corner[some], places[some], near[some])
        return out, solved

    def _corner(self, places: Floats) -> Rows:
        """(m,) the corner that a place is in, -1 for none."""
        zones = self.course.zones
        out = np.full(len(places), -1)
        if not len(zones.place):
            return out
        after = np.searchsorted(zones.place, places)
        for one in (after - 1, after):
            at = np.clip(one, 0, len(zones.place) - 1)
            inside = np.abs(places - zones.place[at]) < zones.size[at]
            out[inside] = at[inside]
        return out

    def _overlap(self, corner: Rows, places: Floats) -> tuple[Floats, Floats]:
        """(m,) how far along the moves before and after a corner the tool is at places (m,)."""
        zones = self.course.zones
        middle, size = zones.place[corner], zones.size[corner]
        u = np.clip((places - middle + size) / (2.0 * size), 0.0, 1.0)
        return middle - size * (1.0 - u) ** 2, middle + size * u**2

    def _on_move(self, row: Rows, places: Floats, near: Floats) -> SolvedJoints:
        return self._solved(row, *self._poses(row, places), near)

    def _in_corner(self, corner: Rows, places: Floats, near: Floats) -> SolvedJoints:
        zones, moves = self.course.zones, self.moves
        before, after = zones.before[corner], zones.after[corner]
        at_before, at_after = self._overlap(corner, places)
        p0, q0 = self._poses(before, at_before)
        p1, q1 = self._poses(after, at_after)
        p = p0 + p1 - moves.positions[before]
        back = rotations.multiply(q1, rotations.conjugate(moves.quaternions[before]))
        return self._solved(before, p, rotations.multiply(back, q0), near)

    def _joints_in_corner(self, corner: Rows, places: Floats, near: Floats) -> SolvedJoints:
        """Joints in corners, where the motions of the joints are superposed."""
        zones = self.course.zones
        middle = self.moves.joints[zones.before[corner]]
        out, solved = -middle, np.ones(len(places), dtype=bool)
        rows = zones.before[corner], zones.after[corner]
        for row, place in zip(rows, self._overlap(corner, places), strict=True):
            free = self.free[row]
            joints = self._between_joints(row, place)
            some = np.flatnonzero(~free)
            if len(some):
                joints[some], good = self._on_move(row[some], place[some], middle[some])
                solved[some] &= good
            out += joints
        solved &= max_abs(out - near) <= _OTHER_BRANCH
        out[~solved] = near[~solved]
        return out, solved

    def _between_joints(self, row: Rows, places: Floats) -> Floats:
        start, end = self.ends.j0[row], self.moves.joints[row]
        return np.asarray(start + self._part(row, places)[:, None] * (end - start))

    def _part(self, row: Rows, places: Floats) -> Floats:
        scale = self.course.scale[row]
        part = (places - self.begins[row]) / np.where(scale > 0.0, scale, 1.0)
        return np.clip(part, 0.0, 1.0)

    def _poses(self, row: Rows, places: Floats) -> tuple[Floats, Floats]:
        """Poses of the tool on moves (m,) at fractions (m,)."""
        ends, moves = self.ends, self.moves
        starts = ends.p0[row], ends.q0[row]
        lasts = moves.positions[row], moves.quaternions[row]
        ways = ToolPaths(starts, lasts, row, ends.arcs)
        p, q = ways.at(self._part(row, places)[:, None])
        return p[:, 0], q[:, 0]

    def _solved(self, row: Rows, p: Floats, q: Floats, near: Floats) -> SolvedJoints:
        """Joints for poses (m, 3), (m, 4) of the tool on moves (m,), beside those that are near."""
        robot, moves = self.robot, self.moves
        joints, good = np.empty_like(near), ~self.unsolved[row]
        for index in np.unique(moves.mount[row]):
            some = np.flatnonzero(moves.mount[row] == index)
            flange = moves.mounts[index].to_flange(p[some], q[some])
            ways = flange[0][:, None], flange[1][:, None]
            found, excess = joints_along(robot, near[some], self.branches[row[some]], ways)
            joints[some] = found[:, 0]
            good[some] &= excess[:, 0] < CLOSING
        joints = np.where(good[:, None], joints, near)
        joints = near + robot.wound(joints - near)
        if robot.arm.spherical:
            line = np.abs(joints[:, 4]) < IN_LINE
            joints[line, 5] += joints[line, 3] - near[line, 3]
            joints[line, 3] = near[line, 3]
        good &= max_abs(joints - near) <= _OTHER_BRANCH
        return np.where(good[:, None], joints, near), good


_BEND_PARTS: Final = 4
"""Parts in which each half of a bend is examined."""
_LINE_SAFETY: Final = 1.5
"""By how much more than its second difference tells a joint may be off the line between knots."""


@dataclass(frozen=True, slots=True, eq=False)
class MovesWithoutStop:
    """Moves that were timed together. skipped: of them that were not, as nobody knows where they
    start. start: seconds from the start of the procedure, at most.
    """

    pieces: tuple[Segment, ...]
    skipped: int
    start: float
    plan: Plan
    _ends: Sequence[int] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        ends = list(accumulate(len(piece.moves) for piece in self.pieces))
        object.__setattr__(self, "_ends", ends)

    def piece_of(self, row: int) -> tuple[Segment, int]:
        """The statement that a move of the plan belongs to, and which of its rows it is."""
        at = row + self.skipped
        number = bisect_right(self._ends, at)
        if number >= len(self.pieces):
            raise IndexError(row)
        piece = self.pieces[number]
        return piece, at - (self._ends[number] - len(piece.moves))


@dataclass(frozen=True, slots=True, eq=False)
class Stretches:
    """A plan as straight stretches of the joints.

    joints: (n, a). slack: (n - 1, a) how far a joint may be from the line of its stretch. times:
    (n,) seconds from the start of the plan. row: (n - 1,) the move that a stretch belongs to.
    places: (n,) mm along the course. exact: the joints in between; None without a way.
    """

    joints: Floats
    slack: Floats
    times: Floats
    row: Rows
    places: Floats
    exact: CourseJoints | None = None

    def part(self, first: int, last: int) -> Stretches:
        """The stretches from one number up to another one."""
        return Stretches(
            self.joints[first : last + 1],
            self.slack[first:last],
            self.times[first : last + 1],
            self.row[first:last],
            self.places[first : last + 1],
            self.exact,
        )

    def between(self, stretch: Rows, part: Floats) -> tuple[Floats, Truths]:
        """Joints (k, a) at parts (k,) of stretches (k,), and (k,) whether they are exact."""
        first, last = self.joints[stretch], self.joints[stretch + 1]
        near = first + part[:, None] * (last - first)
        if self.exact is None:
            return near, np.zeros(len(near), dtype=bool)
        place = self.places[stretch]
        return self.exact.joints(place + part * (self.places[stretch + 1] - place), near)


def stretches_of(plan: Plan) -> Stretches:
    """The way of a plan, corners and all, cut so finely that its slack is small."""
    course = plan.course
    count, knots = len(course.distance), course.knots.joints
    if not count:
        nothing = np.zeros((0, knots.shape[1]))
        none = np.zeros(0, dtype=np.intp)
        return Stretches(knots[:1], nothing, np.zeros(1), none, np.zeros(1))
    step, gone = _cuts(course.distance, course.room)
    d = course.distance[step]
    joints, _ = CoursePlaces(course, step, gone).of(knots)
    ends = np.append(gone[1:], 0.0)
    ends = np.where(np.append(step[1:] != step[:-1], True), d, ends)
    middle, _ = CoursePlaces(course, step, (gone + ends) / 2.0).of(knots)
    last, _ = CoursePlaces(course, step[-1:], d[-1:]).of(knots)
    joints = np.concatenate([joints, last])
    bend = np.abs(middle - (joints[1:] + joints[:-1]) / 2.0)
    between = _between_knots(plan)[course.step[step]]
    slack = bend + np.where(course.straight[step, None], 0.0, between)
    begins = np.concatenate([[0.0], np.cumsum(course.distance)[:-1]])
    places = np.append(begins[step] + gone, course.distance.sum())
    # Without a closed form joints are too slow to solve wherever a search asks for them.
    exact = CourseJoints(course) if course.robot.arm.named else None
    return Stretches(joints, slack, plan.passing(places), course.row[step], places, exact)


def _cuts(distance: Floats, room: Floats) -> tuple[Rows, Floats]:
    """Steps (s,) with their rooms (s + 1,) → step (n,) and place in it (n,) of each cut."""
    part = np.arange(_BEND_PARTS) / _BEND_PARTS
    behind, before = room[:-1, None] * part, distance[:, None] - room[1:, None] * (1.0 - part)
    between = room[:-1, None]
    places = np.concatenate([behind, between, before], axis=1)
    step = np.repeat(np.arange(len(distance)), places.shape[1])
    gone = np.clip(places, 0.0, distance[:, None]).reshape(-1)
    new = np.append(True, (np.diff(gone) > 1e-9) | (np.diff(step) > 0))
    inside = new & (gone < distance[step] - 1e-9)
    return step[inside], gone[inside]


def _between_knots(plan: Plan) -> Floats:
    """(k, a) how far a joint is from the line between two knots of a line or an arc.

    An eighth of the second difference, which is what a parabola through the knots is off. It means
    nothing in a joint move, whose knots lie on that line, but at unequal distances near a corner.
    """
    knots = plan.course.knots
    step = np.diff(knots.joints, axis=0)
    off = np.zeros_like(step)
    same = np.diff(knots.row) == 0
    second = np.abs(np.diff(step, axis=0)) * same[:, None] * _LINE_SAFETY / 8.0
    off[1:] = second
    off[:-1] = np.maximum(off[:-1], second)
    return off
