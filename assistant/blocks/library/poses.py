"""Poses that blocks take in two forms: six numbers, as a controller shows them, and seven."""

from __future__ import annotations

from typing import Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats
from assistant.base.diagnostics import Refused
from assistant.blocks.diagrams.block import Port
from assistant.blocks.rules import BAD_QUATERNION, NO_FIVE_AXIS_ANGLES, TARGET_NOT_FINITE
from assistant.robots.robot import Robot

POSE_SIZE: Final = 7
"""x, y, z in mm and a unit quaternion w, x, y, z."""
POSE_MEANS: Final = (
    "X, Y, Z in mm and A, B, C in degrees (A, B of five axes), or x, y, z and w, x, y, z"
)
STEP_MEANS: Final = "x, y, z in mm and a turn about x, y, z in degrees, or x, y, z and w, x, y, z"
QUATERNION_TOLERANCE: Final = 1e-3
"""Most deviation of a quaternion from unit length by rounding."""
MOST_TURN_ERROR: Final = 0.1
"""Most degrees between a turn and the nearest of five axes, and between a tool and the vertical."""
FRONT_FLAG: Final = 4
"""Bit of the first flag of a posture: the arm reaches forward, not over its back."""


def controller_pose_port(name: str) -> Port:
    """An input for a pose as a controller shows it, or with a quaternion."""
    return Port(name, 6, also=(POSE_SIZE,), means=POSE_MEANS)


def step_port(name: str) -> Port:
    """An input for a step of the tool, its turn as a vector or as a quaternion."""
    return Port(name, 6, also=(POSE_SIZE,), means=STEP_MEANS)


def controller_pose(block: str, robot: Robot, pose: Floats, posture: str) -> Floats:
    """Return X, Y, Z, A, B, C (6,) of a pose (6,) or (7,); raises Refused, naming the block.

    R = Rz(C)·Ry(B)·Rx(A); an arm of five axes has A and B only (`robots.arms.closed_form`).
    posture: of the arm, as its controller writes it after a pose.
    """
    if len(pose) != POSE_SIZE:
        return pose
    turn = _unit_quaternion(block, pose)
    if not robot.five_axis:
        return np.concatenate([pose[:3], rotations.to_euler(turn)[::-1]])
    from assistant.robots.arms import closed_form

    place, turns = pose[None, :3], turn[None]
    ab = closed_form.to_ab(place, turns)[0]
    miss = float(closed_form.plane_miss(place, turns)[0])
    reason = ""
    if miss > MOST_TURN_ERROR:
        reason = f"the tool is {miss:.2f} degrees off what they reach there"
    elif (
        not int(posture.split(",")[0]) & FRONT_FLAG
        and min(abs(ab[1]), 180.0 - abs(ab[1])) > MOST_TURN_ERROR
    ):
        reason = "the arm reaches over its back with a tool that is not vertical"
    if reason:
        raise Refused(NO_FIVE_AXIS_ANGLES(block=block, robot=robot.name, reason=reason))
    return np.concatenate([pose[:3], ab, [0.0]])


def tool_step(block: str, by: Floats) -> Floats:
    """Return a step (6,), its turn as a vector in degrees, from (6,) or (7,); raises Refused."""
    if len(by) != POSE_SIZE:
        return by
    turn = rotations.turns(np.array([1.0, 0.0, 0.0, 0.0]), _unit_quaternion(block, by))
    return np.concatenate([by[:3], np.degrees(turn)])


def _unit_quaternion(block: str, pose: Floats) -> Floats:
    """Return the unit quaternion of a pose (7,); raises Refused."""
    if not np.isfinite(pose).all():
        raise Refused(TARGET_NOT_FINITE(block=block))
    length = float(np.linalg.norm(pose[3:]))
    if abs(length - 1.0) > QUATERNION_TOLERANCE:
        raise Refused(BAD_QUATERNION(block=block, length=length))
    return rotations.canonical(pose[3:])
