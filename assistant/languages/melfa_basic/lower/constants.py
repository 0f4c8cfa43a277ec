"""Targets and joint targets as constants of MELFA-BASIC."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from assistant.languages.melfa_basic.tables import poses
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.program.geometry import JointTarget, Target
from assistant.program.motion import configuration_row

if TYPE_CHECKING:
    from assistant.robots import Robot


def position_constant(
    target: Target, robot: Robot | None, places: int = poses.PLACES
) -> s.Constant:
    """A target as `(x,y,z,a,b,c)(fl1,fl2)`, with so many decimals."""
    row = np.array([configuration_row(target.configuration)], dtype=np.int8)
    flags = poses.flags_of(row, robot)[0]
    values = poses.to_values(
        np.array([target.pose.position]),
        np.array([target.pose.quaternion]),
        np.array([target.external]),
        robot,
        places,
    )[0]
    return s.Constant(tuple(float(v) for v in values), (int(flags[0]), int(flags[1])))


def joint_constant(target: JointTarget, robot: Robot | None) -> s.Constant:
    """A joint target as `(j1, …, j6)`; an arm of five axes keeps the place of J4, as 0, and one of
    four those of J5 and J6 if an external axis follows.
    """
    joints, more = list(target.joints), [v for v in target.external[:2] if v == v]
    if robot is not None and len(joints) == len(robot.axes) < 6:
        row = [0.0] * (6 if more else 1 + max(robot.places))
        for place, value in zip(robot.places, joints, strict=True):
            row[place] = value
        joints = row
    joints += more
    return s.Constant(tuple(round(0.0 if v != v else v, poses.PLACES) + 0.0 for v in joints))
