"""Ports that many blocks have, and poses as signals."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from assistant.base import rotations
from assistant.base.arrays import Floats
from assistant.blocks.diagrams.block import Port
from assistant.robots.robot import Robot

POSE_SIZE: Final = 7
"""Numbers of a pose as a signal: x, y, z in mm and a unit quaternion (w, x, y, z)."""


def joints_port(robot: Robot, name: str = "joints") -> Port:
    """The a joints of an arm, degrees, of an axis that slides mm."""
    return Port(name, len(robot.axes), "deg" if not robot.sliding.any() else "")


def pose_port(name: str = "pose") -> Port:
    return Port(name, POSE_SIZE, "mm")


def pose_signal(positions: ArrayLike, quaternions: ArrayLike) -> Floats:
    """(…, 3) mm and (…, 4) → (…, 7)."""
    return np.concatenate([np.asarray(positions), np.asarray(quaternions)], axis=-1)


def pose_parts(pose: Floats) -> tuple[Floats, Floats]:
    """(7,) → position (1, 3) mm and unit quaternion (1, 4); raises ValueError for no turn."""
    position, turn = pose[:3].reshape(1, 3), pose[3:].reshape(1, 4)
    if not np.isfinite(pose).all() or not np.abs(turn).max() > 0.0:
        raise ValueError("a pose is x, y, z and a quaternion that is not 0")
    return position, rotations.canonical(turn)


def check_not_negative(name: str, value: float) -> float:
    """A bound that holds: NaN compares with nothing, and would let all through."""
    if not value >= 0.0:
        raise ValueError(f"`{name}` is 0 or more, not {value}")
    return value
