"""Wide corners, where one move begins while the one before it slows down.

With u from 0 to 1 through the corner, what is left of the move before, z (1 - u)² of its zone z,
and what is done of the move behind, z u², are laid on top of each other. Between lines that is the
parabola that touches both at the borders of the zone; arcs, orientations and the joints of joint
moves overlap in the same way. The corner becomes spans of equal length, each with one knot of the
control polygon: the blossom of the overlap, which has done u0 + u1 - u0 u1 of the one zone and
u0 u1 of the other, for the span from u0 to u1.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from assistant.base import rotations
from assistant.base.arrays import Floats, Rows, Truths, max_abs, norms
from assistant.program.motion import Kind
from assistant.robots.motion.densities import TimeSampling
from assistant.robots.robot import Robot
from assistant.robots.timing.knots import Knots, followed_joints, solved_joints
from assistant.robots.timing.rows import Moves

CornerPoses = tuple[Floats, Floats, Floats]
"""Joints (m, a), positions (m, 3) and quaternions (m, 4) at m places of a way."""


class Corners:
    """c corners.

    step: (s,) rows of the knots that are no standing still. d: (s,) their lengths. at: (c,) the
    step before each corner. zone: (c,) how far it reaches, before and behind.
    """

    def __init__(
        self, moves: Moves, knots: Knots, step: Rows, d: Floats, at: Rows, zone: Floats
    ) -> None:
        self.moves, self.knots, self.step, self.d = moves, knots, step, d
        self.at, self.zone = at, zone
        self.gone = np.concatenate([[0.0], np.cumsum(d)])
        row = knots.row[step]
        self.before, self.behind = row[at], row[at + 1]
        self.first = np.searchsorted(row, self.before)
        self.last = np.searchsorted(row, self.behind, side="right") - 1
        rates = max_abs(knots.joints[step + 1] - knots.joints[step]) / d
        self.swept = zone * (rates[at] + rates[at + 1])
        wanted = np.maximum(2.0 * zone / TimeSampling.APART, self.swept / TimeSampling.TURNED)
        spans = np.maximum(np.ceil(wanted), TimeSampling.SPANS)
        spans = np.minimum(spans, TimeSampling.MOST)
        if spans.sum() > TimeSampling.MOST_KNOTS:
            spans *= TimeSampling.MOST_KNOTS / spans.sum()
        self.spans = spans.astype(np.intp) // 2 * 2 + 1

    def inserted(
        self, robot: Robot, distance: Floats, room: Floats, corner: Rows
    ) -> tuple[Knots, Floats, Floats, Rows]:
        """The knots with those of the corners; with them distances (k,) of the steps, and room and
        corner (k + 1,) of the knots, see `Course`.
        """
        knots, spans = self.knots, self.spans
        each = np.repeat(np.arange(len(spans)), spans)
        count = np.arange(len(each)) - np.repeat(np.cumsum(spans) - spans, spans)
        joints, positions, quaternions = self._blossoms(robot, each, count)
        kept, middle = np.flatnonzero(self._kept()), self.step[self.at] + 1
        order = np.argsort(np.concatenate([kept, middle[each]]), kind="stable")

        def whole(old: NDArray[Any], new: NDArray[Any]) -> NDArray[Any]:
            return np.concatenate([old[kept], new])[order]

        half = self.zone / self.spans
        place = np.concatenate([[0.0], np.cumsum(distance)])
        new = (place[middle] - self.zone)[each] + (2 * count + 1) * half[each]
        distance = np.diff(whole(place, new))
        # Of the step that leads to each knot:
        ahead = np.where(count > spans[each] // 2, self.behind[each], self.before[each])
        row = whole(np.concatenate([[0], knots.row]), ahead)[1:]
        joints, positions = whole(knots.joints, joints), whole(knots.positions, positions)
        quaternions = whole(knots.quaternions, quaternions)
        length = norms(np.diff(positions, axis=0))
        turn = rotations.angle_between(quaternions[:-1], quaternions[1:])
        number = whole(np.arange(len(knots.joints)), np.full(len(each), -2))
        same = np.flatnonzero(np.diff(number) == 1)
        length[same], turn[same] = knots.length[number[same]], knots.turn[number[same]]
        part = np.where(distance > 0.0, 1.0, 0.0)
        return (
            Knots(row, part, joints, positions, quaternions, length, turn, knots.guessed),
            distance,
            whole(room, half[each]),
            whole(corner, self.at[each]),
        )

    def _kept(self) -> Truths:
        """(k + 1,) the knots that no corner replaces, nor comes close to."""
        reach = self.gone[self.at + 1]
        low = np.searchsorted(self.gone, reach - self.zone - self.d[self.at] / 4.0, side="right")
        high = np.searchsorted(self.gone, reach + self.zone + self.d[self.at + 1] / 4.0)
        low, high = np.maximum(low, self.first + 1), np.minimum(high, self.last + 1)
        change = np.zeros(len(self.gone) + 1, np.intp)
        np.add.at(change, low, 1)
        np.add.at(change, high, -1)
        kept = np.ones(len(self.knots.joints), dtype=bool)
        kept[self.step[np.flatnonzero(np.cumsum(change)[: len(self.step)] > 0)]] = False
        return kept

    def _blossoms(self, robot: Robot, each: Rows, count: Rows) -> CornerPoses:
        """The knots of the spans; each: (m,) their corners, count: (m,) which span it is."""
        u0, u1 = count / self.spans[each], (count + 1) / self.spans[each]
        reach, zone = self.gone[self.at + 1][each], self.zone[each]
        before = self._at(reach - zone * (1.0 - u0) * (1.0 - u1), self.first[each], self.at[each])
        behind = self._at(reach + zone * u0 * u1, self.at[each] + 1, self.last[each])
        middle = self.step[self.at[each]] + 1
        knots = self.knots
        joints = before[0] + behind[0] - knots.joints[middle]
        p = before[1] + behind[1] - knots.positions[middle]
        back = rotations.multiply(behind[2], rotations.conjugate(knots.quaternions[middle]))
        q = rotations.multiply(back, before[2])
        kinds, mount = self.moves.kinds, self.moves.mount[self.before[each]]
        free = (kinds[self.before] == Kind.JOINT) | (kinds[self.behind] == Kind.JOINT)
        branch = robot.branch_of(robot.configuration(knots.joints[middle]))
        for index in np.unique(mount):
            tool, here = self.moves.mounts[index], mount == index
            some = np.flatnonzero(here & ~free[each])
            flange = tool.to_flange(p[some], q[some])
            if robot.arm.named:
                found = solved_joints(robot, branch[some], *flange)
            else:
                found = followed_joints(robot, joints[some], np.arange(len(some)), *flange)
            off = robot.wound(found - joints[some])
            good = max_abs(off) <= self.swept[each[some]] / 2.0
            joints[some[good]] += off[good]
            some = np.concatenate([np.flatnonzero(here & free[each]), some[~good]])
            p[some], q[some] = tool.tip(robot, joints[some])
        return joints, p, q

    def _at(self, place: Floats, first: Rows, last: Rows) -> CornerPoses:
        """Between knots, at places (m,) along the way in steps from first (m,) to last (m,)."""
        ordinal = np.clip(np.searchsorted(self.gone, place, side="right") - 1, first, last)
        part = np.clip((place - self.gone[ordinal]) / self.d[ordinal], 0.0, 1.0)
        step, knots = self.step[ordinal], self.knots
        joints, positions = (
            values[step] + part[:, None] * (values[step + 1] - values[step])
            for values in (knots.joints, knots.positions)
        )
        q = rotations.between(knots.quaternions[step], knots.quaternions[step + 1], part)
        return joints, positions, q
