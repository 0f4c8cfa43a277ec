"""Ports of joints and poses, poses as signals, and the base of blocks that share a connection.

A pose is seven numbers, x, y, z in mm and a unit quaternion (w, x, y, z); blocks of a controller
also take six, as it shows them: X, Y, Z in mm and A, B, C in degrees.
"""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Future
from typing import Any, ClassVar, Final, Generic, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from assistant.base import rotations
from assistant.base.arrays import Floats, number_within
from assistant.base.diagnostics import Refused
from assistant.blocks.connections import Connection
from assistant.blocks.diagrams import Block, Port
from assistant.blocks.rules import BAD_QUATERNION, NO_FIVE_AXIS_ANGLES, TARGET_NOT_FINITE
from assistant.robots.robot import Robot, require_robot

POSE_SIZE: Final = 7
"""Numbers of a pose as a signal: x, y, z in mm and a unit quaternion (w, x, y, z)."""


def joints_port(robot: Robot, name: str = "joints") -> Port:
    """Return a port for joints (a,) of an arm: degrees, and mm of an axis that slides.

    Raises Refused for anything but a Robot.
    """
    require_robot(robot)
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
    return number_within(value, f"`{name}`", least=0.0)


_POSE_MEANS: Final = (
    "X, Y, Z in mm and A, B, C in degrees (A, B of five axes), or x, y, z and w, x, y, z"
)
_STEP_MEANS: Final = "x, y, z in mm and a turn about x, y, z in degrees, or x, y, z and w, x, y, z"
_QUATERNION_TOLERANCE: Final = 1e-3
"""Most deviation of a quaternion from unit length by rounding."""
_MOST_TURN_ERROR: Final = 0.1
"""Most degrees between a turn and the nearest of five axes, and between a tool and the vertical."""
_FRONT_FLAG: Final = 4
"""Bit of the first flag of a posture: the arm reaches forward, not over its back."""


def controller_pose_port(name: str) -> Port:
    """An input for a pose as a controller shows it, or with a quaternion."""
    return Port(name, 6, also=(POSE_SIZE,), means=_POSE_MEANS)


def step_port(name: str) -> Port:
    """An input for a step of the tool, its turn as a vector or as a quaternion."""
    return Port(name, 6, also=(POSE_SIZE,), means=_STEP_MEANS)


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
    if miss > _MOST_TURN_ERROR:
        reason = f"the tool is {miss:.2f} degrees off what they reach there"
    elif (
        not int(posture.split(",")[0]) & _FRONT_FLAG
        and min(abs(ab[1]), 180.0 - abs(ab[1])) > _MOST_TURN_ERROR
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
    if abs(length - 1.0) > _QUATERNION_TOLERANCE:
        raise Refused(BAD_QUATERNION(block=block, length=length))
    return rotations.canonical(pose[3:])


T = TypeVar("T")


class Connected(Block, Generic[T]):
    """A block that has a share of its connection from the beginning of a run to its end."""

    direct: ClassVar[bool] = False

    def __init__(
        self,
        name: str,
        connection: Connection[T],
        inputs: Sequence[Port],
        outputs: Sequence[Port],
        period: float | None,
    ) -> None:
        super().__init__(name, inputs, outputs, period=period)
        self.connection = connection
        self._share: T | None = None

    @property
    def share(self) -> T:
        """Return the connected object; only during a run."""
        assert self._share is not None, "a run has begun"
        return self._share

    def begin(self) -> None:
        self._shown: Future[Any] | None = None
        self._share = self.connection.take()

    def ended(self, motion: Future[Any] | None) -> bool:
        """True if a motion has ended. At the first step after its begin it counts as under way, so
        that the block is busy at one step at least, however quick the motion is.
        """
        shown, self._shown = motion is self._shown, motion
        return motion is not None and shown and motion.done()

    def end(self) -> None:
        if self._share is not None:
            self._share = None
            self.connection.leave()
