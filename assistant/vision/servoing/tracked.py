"""The pose of a thing from picture to picture, and whether it may be believed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats
from assistant.program.geometry import Pose
from assistant.vision.cameras.camera import Camera
from assistant.vision.servoing.estimating import Estimate, estimated

MOST_RESIDUAL: Final = 2.0
"""Pixels, root mean square, that points may be beside where those of the thing would be."""
APART: Final = 10.0
"""Degrees between two poses from which on it matters which one is true."""
RATIO: Final = 1.5
FLOOR: Final = 0.15
"""How much worse, and by how many pixels, the second pose must fit for the first to be taken."""


MEMORY: Final = 0.2
"""Part of what is seen anew that counts, once so many pictures were seen that their mean is no
better: what stands still is known the better the longer it is seen.
"""


@dataclass(slots=True)
class Mean:
    """A pose that hardly changes, as many pictures tell it. pose: None before the first one."""

    pose: Pose | None = None
    seen: int = 0

    def take(self, pose: Pose) -> Pose:
        """The mean with one more."""
        self.seen += 1
        part = max(MEMORY, 1.0 / self.seen)
        self.pose = pose if self.pose is None else _between(self.pose, pose, part)
        return self.pose

    def forget(self) -> None:
        self.pose, self.seen = None, 0


@dataclass(slots=True)
class Tracked:
    """mean: of the thing in the base, which stands still."""

    mean: Mean = field(default_factory=Mean)

    def pose_of(
        self,
        cameras: Sequence[Camera],
        pixels: Mapping[str, Floats],
        points: Floats,
        guess: Pose | None = None,
    ) -> Estimate | str | None:
        """Where it is now; in words why that is doubtful; None if its points do not tell it.

        guess: where it should be, None for where it was.
        """
        found = None
        if (near := guess or self.mean.pose) is not None:
            found = estimated(cameras, pixels, points, near)
        if found is None or not found.residual <= MOST_RESIDUAL:
            found = estimated(cameras, pixels, points)
        if found is None:
            return None
        if not found.residual <= MOST_RESIDUAL:
            self.forget()
            return f"what is seen is {found.residual:.1f} pixels beside what it should be"
        if (angle := _in_doubt(found)) is not None:
            return f"two poses fit what is seen, {angle:.0f} degrees apart"
        return Estimate(self.mean.take(found.pose), found.residual)

    def forget(self) -> None:
        self.mean.forget()


def _between(one: Pose, other: Pose, part: float) -> Pose:
    first, last = np.array(one.position), np.array(other.position)
    turns = np.array(one.quaternion), np.array(other.quaternion)
    turn = rotations.between(*turns, np.array(part)).reshape(-1)
    return Pose.of(first + part * (last - first), turn)


def left(now: Pose, goal: Pose) -> tuple[float, float]:
    """Mm and degrees between two poses."""
    away = np.array(now.position) - np.array(goal.position)
    turn = rotations.angle_between(np.array(now.quaternion), np.array(goal.quaternion))
    return float(np.linalg.norm(away)), float(turn)


def _in_doubt(found: Estimate) -> float | None:
    """Degrees between the two poses that fit, None if it is clear which one is true."""
    if found.other is None:
        return None
    pose, residual = found.other
    if residual > RATIO * found.residual + FLOOR:
        return None
    _, angle = left(found.pose, pose)
    return angle if angle > APART else None
