"""Chains of turning and sliding joints: where their origins, axes and flanges are, in columns."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats
from assistant.program.geometry import IDENTITY, Pose
from assistant.robots.arms.arm import Link

METRE: Final = 1000.0
"""mm."""


@dataclass(frozen=True, slots=True)
class Joint:
    """pose: of the joint at 0, in the frame of the one before, mm. axis: unit vector in its frame.

    low, high: the stretch in which the solver starts, radians or mm.
    """

    pose: Pose
    axis: tuple[float, float, float] = (0.0, 0.0, 1.0)
    sliding: bool = False
    low: float = -np.pi
    high: float = np.pi


@dataclass(frozen=True, slots=True)
class ChainPoses:
    """What n values of a chain of a joints lead to.

    origins: (n, a + 1, 3) mm of the joints and the flange. axes: (n, a, 3) unit vectors.
    frames: (n, a + 1, 3, 3) rotations of the links behind the joints, and of the flange.
    """

    origins: Floats
    axes: Floats
    frames: Floats

    @property
    def turns(self) -> Floats:
        """(n, 3, 3) rotations of the flange."""
        return self.frames[:, -1]


@dataclass(frozen=True)
class Chain:
    """Joints from the base. flange: its pose in the frame of the last joint."""

    joints: tuple[Joint, ...]
    flange: Pose = IDENTITY

    @staticmethod
    def of_links(links: Sequence[Link], ranges: Sequence[tuple[float, float]]) -> Chain:
        """Of links with the ranges of their joints, radians or mm."""
        joints, tail = [], IDENTITY
        for link, (low, high) in zip(links, ranges, strict=True):
            turn = Pose(quaternion=_rotation_about_axis(2, link.theta))
            slide = Pose((0.0, 0.0, link.d))
            # An axis that slides does so behind its turn, one that turns before it.
            before = tail @ turn @ slide if link.sliding else tail @ turn
            joints.append(Joint(before, sliding=link.sliding, low=low, high=high))
            behind = IDENTITY if link.sliding else slide
            tail = behind @ Pose((link.a, 0.0, 0.0), _rotation_about_axis(0, link.alpha))
        return Chain(tuple(joints), tail)

    def along(self, values: Floats) -> ChainPoses:
        """Values (n, a) of the joints, radians or mm."""
        n, count = values.shape
        origins, axes = np.empty((n, count + 1, 3)), np.empty((n, count, 3))
        frames = np.empty((n, count + 1, 3, 3))
        p, turn = np.zeros((n, 3)), np.tile(np.eye(3), (n, 1, 1))
        sines, cosines = np.sin(values), np.cos(values)
        for i, (joint, (rest, across, square)) in enumerate(
            zip(self.joints, self._rotations, strict=True)
        ):
            p = p + turn @ np.array(joint.pose.position)
            turn = turn @ rest
            axes[:, i] = turn @ np.array(joint.axis)
            if joint.sliding:
                p = p + values[:, i, None] * axes[:, i]
            else:
                sine, cosine = sines[:, i, None, None], cosines[:, i, None, None]
                turn = turn @ (np.eye(3) + sine * across + (1.0 - cosine) * square)
            origins[:, i], frames[:, i] = p, turn
        origins[:, -1] = p + turn @ np.array(self.flange.position)
        frames[:, -1] = turn @ rotations.to_matrix(self.flange.quaternion)
        return ChainPoses(origins, axes, frames)

    def elementary(self, zero: Floats | None = None, limits: Floats | None = None) -> Any:
        """The chain as elementary transforms of roboticstoolbox, in metres and radians.

        zero: (a,) of the chain where a joint is 0. limits: (a, 2) of the joints. Raises Refused,
        naming the extra, without roboticstoolbox.
        """
        from assistant.robots.arms.toolbox import toolbox_library

        rtb = toolbox_library("an arm of kind `serial`")
        parts, tail = [], IDENTITY
        for i, joint in enumerate(self.joints):
            onto = Pose(quaternion=rotation_from_z(joint.axis))
            parts.append(rtb.ET.SE3(_in_metres(tail @ joint.pose @ onto)))
            turn = rtb.ET.tz if joint.sliding else rtb.ET.Rz
            if zero is not None and zero[i]:
                parts.append(turn(float(zero[i])))
            parts.append(turn(qlim=None if limits is None else limits[i]))
            tail = onto.inverse()
        return rtb.ETS([*parts, rtb.ET.SE3(_in_metres(tail @ self.flange))])

    @cached_property
    def _rotations(self) -> tuple[tuple[Floats, Floats, Floats], ...]:
        """Of each joint at 0, and the cross product K with its axis and K², by which Rodrigues'
        formula turns: 1 + sin · K + (1 - cos) · K².
        """
        out = []
        for joint in self.joints:
            x, y, z = joint.axis
            across = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
            out.append((rotations.to_matrix(joint.pose.quaternion), across, across @ across))
        return tuple(out)


def pose_matrices(positions: Floats, quaternions: Floats) -> Floats:
    """Poses (n, 3) mm, (n, 4) as matrices (n, 4, 4), in metres."""
    out = np.tile(np.eye(4), (len(positions), 1, 1))
    out[:, :3, :3] = rotations.to_matrix(quaternions)
    out[:, :3, 3] = positions / METRE
    return out


def _in_metres(pose: Pose) -> Floats:
    return np.asarray(pose_matrices(np.array([pose.position]), np.array([pose.quaternion]))[0])


def _rotation_about_axis(axis: int, angle: float) -> tuple[float, float, float, float]:
    """A rotation about X, Y or Z, radians."""
    unit = np.eye(3)[axis]
    w, x, y, z = rotations.canonical(rotations.about(unit, np.degrees(angle))).tolist()
    return (w, x, y, z)


def rotation_from_z(axis: tuple[float, float, float]) -> tuple[float, float, float, float]:
    """A rotation that takes Z to an axis."""
    x, y, z = axis
    if z < -1.0 + 1e-12:
        return (0.0, 1.0, 0.0, 0.0)
    w, a, b, _ = rotations.canonical([1.0 + z, -y, x, 0.0]).tolist()
    return (w, a, b, 0.0)
