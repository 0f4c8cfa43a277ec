"""Joints that bring the seen points of a tool to places, by the kinematics of a robot file.

The map does not use it: ranges for a box are found by it, and a rival of the map.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from assistant.base.arrays import Floats
from assistant.learning.maps.seen_arm import ObservedArm

SLOPE_STEP: Final = 1e-4
"""Degrees (mm) by which slopes of forward kinematics are taken."""
LONGEST_STEP: Final = 20.0
"""Degrees (mm) of one step."""
SOLVER_ROUNDS: Final = 60


def solve_joints(arm: ObservedArm, points: Floats, begin: Floats, ranges: Floats) -> Floats:
    """Joints (m, a) within ranges (a, 2) for points (m, k, 3) mm; Gauss and Newton from (m, a)."""
    joints = np.clip(begin, ranges[:, 0], ranges[:, 1])
    even = np.eye(joints.shape[1])
    for _ in range(SOLVER_ROUNDS):
        off = (points - arm.tool(joints)[0]).reshape(len(points), -1)
        slope = point_slopes(arm, joints)
        square = np.einsum("mri,mrj->mij", slope, slope)
        square += 1e-9 * even * np.trace(square, axis1=1, axis2=2)[:, None, None]
        pull = np.einsum("mri,mr->mi", slope, off)
        step = np.linalg.solve(square, pull[..., None])[..., 0]
        step = np.clip(step, -LONGEST_STEP, LONGEST_STEP)
        joints = np.clip(joints + step, ranges[:, 0], ranges[:, 1])
        if np.abs(step).max() < 1e-9:
            break
    return joints


def point_slopes(arm: ObservedArm, joints: Floats) -> Floats:
    """(m, 3 k, a) mm a degree (mm) of the seen points at joints (m, a)."""
    columns = []
    for axis in range(joints.shape[1]):
        more, less = joints.copy(), joints.copy()
        more[:, axis] += SLOPE_STEP
        less[:, axis] -= SLOPE_STEP
        apart = arm.tool(more)[0] - arm.tool(less)[0]
        columns.append(apart.reshape(len(joints), -1) / (2.0 * SLOPE_STEP))
    return np.stack(columns, axis=-1)
