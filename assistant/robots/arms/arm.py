"""The interface of every kind of arm, and the chain of joints that it consists of.

Columns of joints lead to columns of poses. Angles are radians here, and mm for an axis that
slides: chain values, which are the maker's own with `Robot.zero` added.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from functools import cached_property
from typing import Any, ClassVar, Final

import numpy as np
from numpy.typing import NDArray

from assistant.base import rotations
from assistant.base.arrays import Floats, Rows, Truths
from assistant.base.data_classes import dataclass
from assistant.program.geometry import IDENTITY, Pose

CLOSING: Final = 1e-5
"""mm and degrees within which forward kinematics must come back to a pose."""
MISS_TOLERANCE: Final = 0.01
"""degrees; an orientation so little off what an arm of less than six axes can take counts as
its own. It is what a position printed with two decimals turns the plane of an arm by at short
reach."""
BOUNDARY: Final = 1e-6
"""degrees below a quadrant's first angle that still count to it, for joints that are
meant to be 0 or 90 and come out of arithmetic as a little less."""


@dataclass(frozen=True, slots=True)
class Link:
    """A row of standard Denavit-Hartenberg parameters, `Rz(theta)·Tz(d)·Tx(a)·Rx(alpha)`.

    a, d: mm. alpha, theta: radians. The joint is added to theta, to d if it slides.
    """

    a: float = 0.0
    d: float = 0.0
    alpha: float = 0.0
    theta: float = 0.0
    sliding: bool = False


class Arm(ABC):
    """A kind of arm with its lengths.

    kind: as a robot file names it. axes: names of the a joints. sliding: (a,) which of them
    move along their axis, in mm. branches: how many `ik` tells apart. reach: mm from axis 1 to
    the wrist of the stretched arm. angle: degrees within which a pose must be met.
    flags: the bits of Mitsubishi's FLG1 that say something of such an arm.
    spherical: whether axes 4, 5 and 6 meet, so that the wrist has its one singularity.
    rolls: 1 where axes 4 and 6 in line turn the flange to the same side, -1 where they do not.
    named: whether makers have names for its branches, so that a configuration says one.
    compared: joints by which two branches differ, one that means nothing in line left out.
    """

    kind: ClassVar[str]
    angle: ClassVar[float] = CLOSING
    flags: ClassVar[int] = 7
    spherical: ClassVar[bool] = False
    rolls: float = 1.0
    named: ClassVar[bool] = True

    @property
    @abstractmethod
    def axes(self) -> tuple[str, ...]: ...

    @property
    @abstractmethod
    def branches(self) -> int: ...

    @property
    @abstractmethod
    def compared(self) -> tuple[int, ...]: ...

    @property
    def sliding(self) -> Truths:
        return np.zeros(len(self.axes), dtype=bool)

    @property
    @abstractmethod
    def reach(self) -> float: ...

    @abstractmethod
    def fk(self, joints: Floats) -> tuple[Floats, Floats]:
        """Chain values (n, a) → flange positions (n, 3) mm, quaternions (n, 4)."""

    @abstractmethod
    def ik(
        self, positions: Floats, quaternions: Floats, branches: tuple[int, ...]
    ) -> tuple[Floats, Floats]:
        """Flange poses → chain values (a, b, n) and what keeps each from closing (b, n) mm.

        branches: which, ascending. A length of 0 closes.
        """

    @abstractmethod
    def shape(self, joints: Floats) -> NDArray[np.int8]:
        """(n, 3) columns back, down and flip of a configuration (see `Path`)."""

    @abstractmethod
    def branch(self, shape: Rows) -> Rows:
        """(n, 3) columns back, down, flip → (n,) index of the branch among those of `ik`."""

    @abstractmethod
    def words(self, shape: NDArray[np.integer]) -> str:
        """Describe the columns (3,) back, down, flip in the words for such an arm."""

    @abstractmethod
    def points(self, joints: Floats) -> Floats:
        """(n, k, 3) mm: base, the ends of the links in order, flange."""

    def elbow(self, joints: Floats) -> Floats | None:  # noqa: ARG002 - of some
        """(n,) radians by which the elbow is bent; None for an arm without one."""
        return None

    def wrist(self, joints: Floats) -> Floats | None:  # noqa: ARG002 - of some
        """Return the (n,) mm of the wrist centre in front of axis 1, negative on the other side;
        None for an arm without one.
        """
        return None

    @abstractmethod
    def links(self) -> tuple[Link, ...]:
        """The same chain by the standard parameters of Denavit and Hartenberg."""

    @cached_property
    def whole_chain(self) -> Chain:
        """The same as joints from the base, for the frames of its links."""
        links = self.links()
        return Chain.of_links(links, [(-np.pi, np.pi)] * len(links))

    def miss(self, joints: Floats, quaternions: Floats) -> Floats:  # noqa: ARG002 - of some
        """(n,) degrees that the arm cannot turn its flange by to quaternions (n, 4).

        joints: (n, a) chain values of any branch of `ik` for the pose.
        """
        return np.zeros(len(quaternions))

    @abstractmethod
    def too_far(self, positions: Floats, quaternions: Floats) -> Truths:
        """(n,) of poses out of reach, whether they are beyond it and not too near."""


def turn_between(left: Floats, right: Floats) -> Floats:
    """(n,) degrees between quaternions (n, 4)."""
    same = np.abs(np.einsum("ij,ij->i", left, right))
    return np.asarray(2.0 * np.degrees(np.arccos(np.clip(same, 0.0, 1.0))))


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
    """Poses along a chain of a joints for n sets of joint values.

    origins: (n, a + 1, 3) mm of the joints and the flange. axes: (n, a, 3) unit vectors. frames:
    (n, a + 1, 3, 3) rotations of the links after the joints, and of the flange.
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
        """Build a chain from links with the ranges of their joints, radians or mm."""
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

    def jacobian(self, values: Floats, tip: Floats) -> Floats:
        """Values (n, a) of the joints → (n, 6, a): mm and radians for a radian, or a mm of sliding.

        How a point tip (3,) mm of the flange moves along x, y, z, and how it turns about them. The
        geometric Jacobian: Siciliano and others, Robotics (2009), 3.1.
        """
        found = self.along(values)
        place = found.origins[:, -1] + found.turns @ tip
        out = np.zeros((len(values), 6, values.shape[1]))
        for i, joint in enumerate(self.joints):
            axis = found.axes[:, i]
            if joint.sliding:
                out[:, :3, i] = axis
            else:
                out[:, :3, i] = np.cross(axis, place - found.origins[:, i])
                out[:, 3:, i] = axis
        return out

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
        """Rotation of each joint at 0, the cross product K with its axis, and K², for Rodrigues'
        formula: 1 + sin · K + (1 - cos) · K².
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
