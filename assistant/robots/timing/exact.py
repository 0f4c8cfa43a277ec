"""The joints of the arm anywhere on a course, solved there instead of taken between knots.

In a corner what is left of the move before and what is done of the move after are laid on top of
each other, as `corners` states it: of lines and arcs the poses of the tool, of joint moves the
joints.
"""

from __future__ import annotations

from functools import cached_property
from typing import Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats, Rows, Truths, max_abs
from assistant.program.motion import Kind
from assistant.robots.arms.arm import CLOSING
from assistant.robots.motion.along import ToolPaths, joints_along
from assistant.robots.robot import IN_LINE
from assistant.robots.timing.course import Course
from assistant.robots.timing.knots import MoveEnds

OTHER_BRANCH: Final = 20.0
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
        solved &= max_abs(out - near) <= OTHER_BRANCH
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
        good &= max_abs(joints - near) <= OTHER_BRANCH
        return np.where(good[:, None], joints, near), good
