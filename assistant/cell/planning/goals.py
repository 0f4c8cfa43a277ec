"""All ways to hold an arm at a pose: its branches, and the whole turns of its axes."""

from __future__ import annotations

from itertools import product
from typing import Final

import numpy as np

from assistant.base.arrays import Floats
from assistant.program.geometry import IDENTITY, Pose
from assistant.robots.robot import Robot

MOST_GOALS: Final = 64
"""Ways that are tried, of those nearest to where the arm comes from."""
SAME_JOINTS: Final = 1e-3
"""degrees (mm) by which two ways differ at least."""


def goal_joints(robot: Robot, pose: Pose, near: Floats, tool: Pose = IDENTITY) -> Floats:
    """(k, a) joints that hold the tip of a tool at a pose, inside the limits, the nearest first.

    pose: in the base of the robot. near: (a,) joints where the arm comes from. tool: the tip in
    the flange. A turn of an axis that its limits allow is a way of its own.
    """
    flange = pose @ tool.inverse()
    joints, valid = robot.ik([flange.position], [flange.quaternion])
    found: list[Floats] = []
    for row in joints[0][valid[0]]:
        found += _with_whole_turns(robot, row)
    some = np.array(found).reshape(-1, len(robot.axes))
    order = np.argsort(np.linalg.norm((some - near) / robot.speeds, axis=1), kind="stable")
    out: list[Floats] = []
    for row in some[order]:
        if all(np.abs(row - other).max() > SAME_JOINTS for other in out):
            out.append(row)
    return np.array(out[:MOST_GOALS]).reshape(-1, len(robot.axes))


def _with_whole_turns(robot: Robot, row: Floats) -> list[Floats]:
    """A row of joints with every whole turn of its axes that is inside the limits."""
    low, high = robot.limits.T
    turns = []
    for axis in range(len(row)):
        if robot.sliding[axis] or axis not in robot.winding():
            turns.append([0.0])
            continue
        # Axes without an end are turned once at most.
        least = max(-1.0, np.ceil((low[axis] - row[axis]) / 360.0 - 1e-9))
        most = min(1.0, np.floor((high[axis] - row[axis]) / 360.0 + 1e-9))
        turns.append([360.0 * k for k in np.arange(least, most + 0.5)])
    rows = [row + np.array(turn) for turn in product(*turns)]
    return [one for one in rows if bool(robot.inside(one))]
