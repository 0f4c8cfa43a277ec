"""Variables of joints and poses, which several models have."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

from assistant.blocks.fmu.variables import StartValue, Variable
from assistant.robots import Robot

POSE_PARTS: Final = ("x", "y", "z", "qw", "qx", "qy", "qz")


def joint_variables(
    robot: Robot,
    name: str,
    description: str,
    starts: Iterable[StartValue] | None = None,
    per: str = "",
) -> list[Variable]:
    """One for each axis, its name for `{}`; per: what its unit is divided by, such as `/s`."""
    known = [None] * len(robot.axes) if starts is None else [float(value) for value in starts]
    units = ["mm" if slides else "deg" for slides in robot.sliding]
    return [
        Variable(name.format(axis), f"{description} of {axis}", start, f"{unit}{per}")
        for axis, start, unit in zip(robot.axes, known, units, strict=True)
    ]


def flag_variables(robot: Robot, name: str, description: str) -> list[Variable]:
    """One that says yes or no for each axis."""
    return [Variable(name.format(axis), description.format(axis)) for axis in robot.axes]


def pose_variables(
    name: str, description: str, starts: Iterable[float] | None = None
) -> list[Variable]:
    """Position in mm and quaternion of a pose, its part for `{}`."""
    known = [None] * len(POSE_PARTS) if starts is None else [float(value) for value in starts]
    return [
        Variable(name.format(part), f"{description}, {part}", start, "" if "q" in part else "mm")
        for part, start in zip(POSE_PARTS, known, strict=True)
    ]
