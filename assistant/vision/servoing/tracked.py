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
from assistant.vision.servoing.estimating import TargetPose, estimate_pose

MOST_RESIDUAL: Final = 2.0
"""Pixels, root mean square, that points may be beside where those of the thing would be."""
AMBIGUOUS_ANGLE: Final = 10.0
"""Degrees between two poses from which on it matters which one is true."""
BETTER_FIT_RATIO: Final = 1.5
BETTER_FIT_PIXELS: Final = 0.15
"""How much worse, and by how many pixels, the second pose must fit for the first to be taken."""


LEAST_NEW_SHARE: Final = 0.2
"""Part of what is seen anew that counts, once so many pictures were seen that their mean is no
better: what stands still is known the better the longer it is seen.
"""


@dataclass(slots=True)
class MeanPose:
    """A pose that hardly changes, as many pictures tell it. pose: None before the first one."""

    pose: Pose | None = None
    seen: int = 0

    def take(self, pose: Pose) -> Pose:
        """The mean with one more."""
        self.seen += 1
        part = max(LEAST_NEW_SHARE, 1.0 / self.seen)
        self.pose = pose if self.pose is None else _interpolated_pose(self.pose, pose, part)
        return self.pose

    def forget(self) -> None:
        self.pose, self.seen = None, 0


@dataclass(slots=True)
class PoseTracker:
    """mean: of the thing in the base, which stands still."""

    mean: MeanPose = field(default_factory=MeanPose)

    def pose_of(
        self,
        cameras: Sequence[Camera],
        pixels: Mapping[str, Floats],
        points: Floats,
        guess: Pose | None = None,
    ) -> TargetPose | str | None:
        """Where it is now; in words why that is doubtful; None if its points do not tell it.

        guess: where it should be, None for where it was.
        """
        found = None
        if (near := guess or self.mean.pose) is not None:
            found = estimate_pose(cameras, pixels, points, near)
        if found is None or not found.residual <= MOST_RESIDUAL:
            found = estimate_pose(cameras, pixels, points)
        if found is None:
            return None
        if not found.residual <= MOST_RESIDUAL:
            self.forget()
            return f"what is seen is {found.residual:.1f} pixels beside what it should be"
        if (angle := _ambiguous_angle(found)) is not None:
            return f"two poses fit what is seen, {angle:.0f} degrees apart"
        return TargetPose(self.mean.take(found.pose), found.residual)

    def forget(self) -> None:
        self.mean.forget()


def _interpolated_pose(one: Pose, other: Pose, part: float) -> Pose:
    first, last = np.array(one.position), np.array(other.position)
    turns = np.array(one.quaternion), np.array(other.quaternion)
    turn = rotations.between(*turns, np.array(part)).reshape(-1)
    return Pose.of(first + part * (last - first), turn)


def pose_difference(now: Pose, goal: Pose) -> tuple[float, float]:
    """Mm and degrees between two poses."""
    away = np.array(now.position) - np.array(goal.position)
    turn = rotations.angle_between(np.array(now.quaternion), np.array(goal.quaternion))
    return float(np.linalg.norm(away)), float(turn)


def _ambiguous_angle(found: TargetPose) -> float | None:
    """Degrees between the two poses that fit, None if it is clear which one is true."""
    if found.other is None:
        return None
    pose, residual = found.other
    if residual > BETTER_FIT_RATIO * found.residual + BETTER_FIT_PIXELS:
        return None
    _, angle = pose_difference(found.pose, pose)
    return angle if angle > AMBIGUOUS_ANGLE else None
