"""Positions of MELFA-BASIC as poses and back, and what they are calculated with.

R = Rz(C)·Ry(B)·Rx(A); a position is shown as Base · flange · Tool.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Final, TypeVar

import numpy as np

from assistant.base import rotations
from assistant.program.geometry import Pose
from assistant.virtual.melfa.stops import Failed, Unknown
from assistant.virtual.melfa.values import Elements, Joints, Position

if TYPE_CHECKING:
    from assistant.robots import Robot

Both = TypeVar("Both", Position, Joints)

SIX: Final = 6
"""Elements that a pose has; behind them stand the additional axes."""


def pose_of(value: Position, robot: Robot | None = None) -> Pose:
    """The pose of a position; raises Failed where an element of it is not defined.

    robot: of five axes, whose A and B are counted otherwise (see robots.arms.five_axis).
    """
    six = value.values[:6]
    if robot is not None and robot.five_axis:
        from assistant.robots.arms import five_axis

        x, y, z, a, b = _all_numbers(six[:5])
        made = five_axis.from_ab(np.array([[x, y, z]]), np.array([[a, b]]))[0]
        return Pose.of(np.array([x, y, z]), rotations.canonical(made))
    x, y, z, a, b, c = _all_numbers(six)
    return Pose.of(np.array([x, y, z]), rotations.from_euler((c, b, a), "ZYX"))


def position_of(pose: Pose, like: Position | None = None, robot: Robot | None = None) -> Position:
    """A pose as a position with the flags and additional axes of another one."""
    if robot is not None and robot.five_axis:
        from assistant.robots.arms import five_axis

        p, q = np.array([pose.position]), np.array([pose.quaternion])
        angles = (*(float(v) for v in five_axis.to_ab(p, q)[0]), 0.0)
    else:
        found = rotations.to_euler(np.array(pose.quaternion), "ZYX")
        angles = (float(found[2]), float(found[1]), float(found[0]))
    more = like.values[6:] if like is not None else (None, None)
    flags = like.flags if like is not None else (None, None)
    return Position((*pose.position, *angles, *more), flags)


def _all_numbers(values: Elements) -> tuple[float, ...]:
    found = tuple(v for v in values if v is not None)
    if len(found) < len(values):
        raise Failed(2800, "a position with elements that are not defined")
    return found


# ------------------------------------------------------------------------------ arithmetic


def composed(left: Position, right: Position, robot: Robot | None) -> Position:
    """`P1*P2`: the second one in the frame of the first, with its flags."""
    return position_of(_plain_numbers(left, robot) @ _plain_numbers(right, robot), left)


def divided(left: Position, right: Position, robot: Robot | None) -> Position:
    """`P1/P2`: the first one times the inverse of the second."""
    return position_of(_plain_numbers(left, robot) @ _plain_numbers(right, robot).inverse(), left)


def divided_from_left(left: Position, right: Position, robot: Robot | None) -> Position:
    """The first one seen from the second."""
    return position_of(_plain_numbers(right, robot).inverse() @ _plain_numbers(left, robot), left)


def inverse(value: Position, robot: Robot | None) -> Position:
    return position_of(_plain_numbers(value, robot).inverse(), value)


def elementwise(left: Both, right: Both, combine: Callable[[float, float], float]) -> Both:
    """`P1+P2`, `J1-J2`: element by element, with the flags of the left one."""
    values = tuple(
        _element_pair(at, a, b, combine)
        for at, (a, b) in enumerate(zip(left.values, right.values, strict=True))
    )
    return replace(left, values=values)


def scaled(value: Both, factor: float) -> Both:
    """`P1*2`, `J1/3`: every element."""
    return replace(value, values=tuple(None if v is None else v * factor for v in value.values))


def _element_pair(
    at: int, a: float | None, b: float | None, combine: Callable[[float, float], float]
) -> float | None:
    if a is not None and b is not None:
        return combine(a, b)
    if at < SIX:
        if a is None and b is None:
            return None
        raise Unknown("a sum with an element that is not defined")
    return a if b is None else combine(0.0, b)


def _plain_numbers(value: Position, robot: Robot | None) -> Pose:
    """A pose that is calculated with, of an arm of six axes."""
    if robot is not None and robot.five_axis:
        raise Unknown("products of positions of an arm of five axes")
    return pose_of(value)


def same_place(left: Pose | None, right: Pose, tolerance: float = 0.01) -> bool:
    """Whether two poses are at one place, within mm."""
    if left is None:
        return False
    return bool(np.linalg.norm(np.subtract(left.position, right.position)) <= tolerance)


def flange_of(shown: Pose, base: Pose, tool: Pose) -> Pose:
    """Where the flange is in the robot's own base: shown = base · flange · tool."""
    return base.inverse() @ shown @ tool.inverse()


def shown_of(flange: Pose, base: Pose, tool: Pose) -> Pose:
    return base @ flange @ tool
