"""Where the arm stands, as the controller link tells it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

import numpy as np

from assistant.base.rotations import to_euler
from assistant.program.geometry import Pose

if TYPE_CHECKING:
    from assistant.robots import Robot

AxisValues = list[tuple[str, str]]
"""Name and value of each axis."""
MISSING_AXIS: Final = "****"
"""Of an axis that the arm lacks."""
NEAR_LIMIT: Final = 0.005
"""Degrees or mm from the limit of an axis that is told to be reached."""


def joint_values(robot: Robot, angles: Sequence[float]) -> AxisValues:
    """Degrees of J1 to J6, as JPOSF shows them."""
    own = dict(zip(robot.axes, angles, strict=True))
    names = [f"J{i}" for i in range(1, 7)]
    return [(name, f"{own[name]:.2f}" if name in own else MISSING_AXIS) for name in names]


def pose_values(robot: Robot, angles: Sequence[float], tool: Pose, foot: Pose) -> AxisValues:
    """X, Y, Z in mm, A, B, C in degrees of the tip; an arm of five axes shows no C.

    foot: the frame that positions are counted in, with the robot's base in it.
    """
    positions, quaternions = robot.fk(np.array([angles]))
    tip = foot @ Pose.of(positions[0], quaternions[0]) @ tool
    values = list(tip.position)
    if robot.five_axis:
        from assistant.robots.arms.five_axis import to_ab

        found = to_ab(np.array([tip.position]), np.array([tip.quaternion]))
        values += [float(v) for v in found[0]]
    else:
        values += [float(v) for v in to_euler(np.array(tip.quaternion), "ZYX")[::-1]]
    return [(name, f"{value + 0.0:.2f}") for name, value in zip("XYZABC", values, strict=False)]


def cylinder_values(shown: AxisValues) -> AxisValues:
    """Radius in mm and angle in degrees about the base in the places of X and Y (RPOSF)."""
    x, y = (float(value) for _, value in shown[:2])
    radius, angle = math.hypot(x, y), math.degrees(math.atan2(y, x))
    return [("R", f"{radius:.2f}"), ("T", f"{angle:.2f}"), *shown[2:]]


def posture_flags(robot: Robot, angles: Sequence[float]) -> str:
    from assistant.robots.configurations import to_flags

    one, two = to_flags(robot.configuration(np.array([angles])))[0]
    return f"{one},{two}"


def reached_limits(robot: Robot, angles: Sequence[float]) -> str:
    """Axes at their upper and at their lower limits, two hexadecimal digits each, and a reserve."""
    upper = lower = 0
    for place, angle, (low, high) in zip(robot.places, angles, robot.limits, strict=True):
        upper |= (angle >= float(high) - NEAR_LIMIT) << place
        lower |= (angle <= float(low) + NEAR_LIMIT) << place
    return f"{upper:02X}{lower:02X}0000"
