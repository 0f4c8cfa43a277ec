"""How far an arm is from its singularities."""

from __future__ import annotations

from typing import Final

import numpy as np

from assistant.base.arrays import Floats
from assistant.program.geometry import IDENTITY, Pose
from assistant.robots.robot import Robot

ROWS_AT_ONCE: Final = 16384
"""Rows that are computed at once."""


def jacobian(robot: Robot, joints: Floats, tip: Pose = IDENTITY) -> Floats:
    """(n, a) joints → (n, 6, a): how the tip of a tool moves and turns with each axis.

    Its speed in the base over the reach of the arm, then how it turns; for a radian of an axis, or
    as many mm of one that slides as the arm reaches. tip: in the flange. The geometric Jacobian:
    Siciliano and others, Robotics (2009), 3.1.
    """
    values = robot.chained(joints)
    found = robot.arm.whole_chain.along(values)
    place = found.origins[:, -1] + found.turns @ np.array(tip.position)
    length = robot.reach
    out = np.zeros((len(values), 6, values.shape[1]))
    for i, slides in enumerate(robot.sliding):
        axis = found.axes[:, i]
        if slides:
            out[:, :3, i] = axis
        else:
            out[:, :3, i] = np.cross(axis, place - found.origins[:, i]) / length
            out[:, 3:, i] = axis
    if robot.coupling:  # J2 turns what J3 turns as well
        out[:, :, 1] += robot.coupling * out[:, :, 2]
    return out


def distance_from_singularity(robot: Robot, joints: Floats, tip: Pose = IDENTITY) -> Floats:
    """(n,) how far joints (n, a) are from a singularity: the least singular value of `jacobian`.

    0 in a singularity, where the tip cannot go some way however fast the axes turn. An arm of less
    than six axes is in one where it loses a way that it has elsewhere. NaN of NaN.
    """
    out = np.full(len(joints), np.nan)
    known = np.flatnonzero(np.isfinite(joints).all(axis=1))
    for start in range(0, len(known), ROWS_AT_ONCE):
        rows = known[start : start + ROWS_AT_ONCE]
        matrix = jacobian(robot, joints[rows], tip)
        out[rows] = np.linalg.svd(matrix, compute_uv=False).min(axis=1)
    return out
