"""Poses along linear and circular moves, and the joints that they take.

One geometry for all who look between targets: reach and turns (`on_the_way`), rules
(`checks.extremes`), times (`timing.knots`) and pictures (`report.track`). How closely each of them
looks, and why, stands in `densities`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats, Rows
from assistant.robots.motion.arcs import Arcs
from assistant.robots.motion.run import Mounting
from assistant.robots.robot import Robot

Poses = tuple[Floats, Floats]
"""Positions (..., 3) mm and unit quaternions (..., 4)."""


@dataclass(frozen=True, slots=True, eq=False)
class ToolPaths:
    """k ways of a tool, on which it goes and turns evenly.

    starts, ends: (k, 3), (k, 4). rows: (k,) what they are called in arcs. arcs: those that are
    round; the others are straight.
    """

    starts: Poses
    ends: Poses
    rows: Rows
    arcs: Arcs | None

    def at(self, part: Floats) -> Poses:
        """At parts (k, s) of each way: (k, s, 3), (k, s, 4)."""
        (p0, q0), (p1, q1) = self.starts, self.ends
        p = p0[:, None] + part[..., None] * (p1 - p0)[:, None]
        if self.arcs is not None:
            at, on = self.arcs.among(self.rows)
            p[on] = self.arcs.points(at, part[on])
        return p, rotations.between(q0[:, None], q1[:, None], part)


def flange_along(mounting: Mounting, rows: Rows, tool: Poses) -> Poses:
    """Poses (k, s, 3), (k, s, 4) on the ways to rows (k,) of a run → of the flange."""
    p, q = tool
    each = np.repeat(rows, p.shape[1])
    flat = mounting.to_flange(p.reshape(-1, 3), q.reshape(-1, 4), each)
    return flat[0].reshape(p.shape), flat[1].reshape(q.shape)


def joints_along(robot: Robot, before: Floats | None, branches: Rows, flange: Poses) -> Poses:
    """Joints (k, s, a) deg, whole turns left open, and mm out of reach (k, s), on k ways.

    branches: (k,) that an arm whose branches have names stays in. before: (k, a) deg where the ways
    begin, from which another one is followed; else not needed. flange: (k, s, 3), (k, s, 4).
    """
    p, q = flange
    if not robot.arm.named and before is not None:
        return robot.follow(before, p, q)
    joints, excess = np.empty((*p.shape[:2], len(robot.axes))), np.empty(p.shape[:2])
    for branch in np.unique(branches):
        some = branches == branch
        found, over = robot.solve(p[some].reshape(-1, 3), q[some].reshape(-1, 4), (int(branch),))
        joints[some] = found[:, 0].T.reshape(-1, p.shape[1], len(robot.axes))
        excess[some] = over[0].reshape(-1, p.shape[1])
    return joints, excess
