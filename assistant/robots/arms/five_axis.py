"""Arms of five axes (RV-2AJ): closed-form kinematics and the A, B coding of orientation.

The chain is `Rz(J1)·Tr(0,0,d1)·Ry(J2)·Tr(0,0,a2)·Ry(J3)·Tr(0,0,d4)·Ry(J5)·Rz(J6)·Tr(0,0,d6)`;
there is no axis 4, so the tool axis always lies in the vertical plane through axis 1 and
two angles say the orientation:

    R = Rz(J1)·Ry(B)·Rz(J6)     B = J2 + J3 + J5     A = J6 + J1·cos B     J1 = atan2(y, x)

B is the tilt of the tool axis from straight up (0 up, 90 forward, 180 down), A the roll of
the hand. For B of 0, 90 and 180 that is what an RV-2AJ shows; in between it is the
interpolation that its users compute with.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from assistant.base import rotations
from assistant.base.arrays import Floats, Rows, Truths
from assistant.robots.arms.arm import MISS_TOLERANCE, Arm, Link, turn_between
from assistant.robots.arms.lengths import Lengths, wrist_words
from assistant.robots.arms.links import axis_z, reach_excess, two_links, zyz

ON_AXIS_1: Final = 1e-6
"""mm; a point nearer to axis 1 has no azimuth of its own and gets 0."""


@dataclass(frozen=True, slots=True)
class FiveAxis(Arm):
    """An arm of five axes; a1 and a3 are 0."""

    lengths: Lengths
    kind: ClassVar[str] = "five-axis"
    angle: ClassVar[float] = MISS_TOLERANCE
    flags: ClassVar[int] = 6
    axes: ClassVar[tuple[str, ...]] = ("J1", "J2", "J3", "J5", "J6")
    branches: ClassVar[int] = 4
    compared: ClassVar[tuple[int, ...]] = (0, 1, 2, 3)

    @property
    def reach(self) -> float:
        return self.lengths.reach

    def fk(self, joints: Floats) -> tuple[Floats, Floats]:
        return five_axis_fk(self.lengths, joints)

    def ik(
        self, positions: Floats, quaternions: Floats, branches: tuple[int, ...]
    ) -> tuple[Floats, Floats]:
        return five_axis_ik(self.lengths, positions, quaternions, branches)

    def shape(self, joints: Floats) -> NDArray[np.int8]:
        """Flip is 1, which is FLG1 6 for the front, upper branch."""
        back, lower = self.lengths.sides(joints)
        return np.stack([back, lower ^ back, np.ones_like(back)], axis=-1).astype(np.int8)

    def branch(self, shape: Rows) -> Rows:
        back = shape[:, 0] == 1
        return np.asarray(2 * back + ((shape[:, 1] == 1) ^ back), dtype=np.intp)

    def words(self, shape: NDArray[np.integer]) -> str:
        return wrist_words(shape)

    def points(self, joints: Floats) -> Floats:
        return self.lengths.points(joints, self.fk(joints)[0])

    def elbow(self, joints: Floats) -> Floats:
        return self.lengths.elbow(joints)

    def wrist(self, joints: Floats) -> Floats:
        return self.lengths.wrist(joints)

    def miss(self, joints: Floats, quaternions: Floats) -> Floats:
        return turn_between(self.fk(joints)[1], quaternions)

    def too_far(self, positions: Floats, quaternions: Floats) -> Truths:
        return self.lengths.too_far(positions, quaternions)

    def links(self) -> tuple[Link, ...]:
        arm, quarter = self.lengths, np.pi / 2.0
        return (
            Link(d=arm.d1, alpha=-quarter),
            Link(a=arm.a2, theta=-quarter),
            Link(a=arm.d4),
            Link(alpha=quarter, theta=quarter),
            Link(d=arm.d6),
        )


def to_ab(positions: ArrayLike, quaternions: ArrayLike) -> Floats:
    """(n, 3) mm and (n, 4) → (n, 2) A and B in degrees, both in (-180, 180].

    An orientation that the arm cannot take (see `miss`) gives those of the nearest plane.
    """
    azimuth = _azimuth(positions)
    m = _in_arm_plane(azimuth, quaternions)
    b = np.arctan2(m[:, 0, 2], m[:, 2, 2])
    roll = np.arctan2(m[:, 1, 0], m[:, 1, 1])
    a = roll + azimuth * np.cos(b)
    return _wrapped_degrees(np.degrees(np.stack([a, b], axis=-1)))


def from_ab(positions: ArrayLike, ab: ArrayLike) -> Floats:
    """(n, 3) mm and (n, 2) A and B in degrees → (n, 4) canonical quaternions."""
    azimuth = _azimuth(positions)
    a, b = np.radians(np.asarray(ab, dtype=np.float64).reshape(-1, 2)).T
    return rotations.canonical(zyz(azimuth, b, a - azimuth * np.cos(b)))


def plane_miss(positions: ArrayLike, quaternions: ArrayLike) -> Floats:
    """(n,) degrees by which the tool axis leaves the plane through axis 1 and the position.

    0 for a vertical tool, which lies in every plane.
    """
    m = _in_arm_plane(_azimuth(positions), quaternions)
    return np.asarray(np.degrees(np.abs(np.arcsin(np.clip(m[:, 1, 2], -1.0, 1.0)))))


def five_axis_fk(lengths: Lengths, joints: Floats) -> tuple[Floats, Floats]:
    """Chain angles (n, 5) in radians → flange positions (n, 3) mm, quaternions (n, 4)."""
    j1, j2, j3, j5, j6 = joints.T
    upper, fore, tilt = j2, j2 + j3, j2 + j3 + j5
    r = lengths.a2 * np.sin(upper) + lengths.d4 * np.sin(fore) + lengths.d6 * np.sin(tilt)
    z = (
        lengths.d1
        + lengths.a2 * np.cos(upper)
        + lengths.d4 * np.cos(fore)
        + lengths.d6 * np.cos(tilt)
    )
    positions = np.stack([r * np.cos(j1), r * np.sin(j1), z], axis=-1)
    return positions, rotations.canonical(zyz(j1, tilt, j6))


def five_axis_ik(
    lengths: Lengths, positions: Floats, quaternions: Floats, branches: tuple[int, ...]
) -> tuple[Floats, Floats]:
    """Flange poses → chain angles (5, b, n) in radians and what keeps each from closing (b, n) mm.

    branches: which of the four, ascending; 2·back + lower, lower being a negative angle of
    the elbow. A length of 0 closes; otherwise it is by how far the wrist is out of reach of
    the stretched or folded arm.
    The tool axis is taken into the plane of the arm; `miss` tells by how much.
    """
    azimuth = _arm_plane(positions, quaternions)
    m = _in_arm_plane(azimuth, quaternions)
    tilt, roll = np.arctan2(m[:, 0, 2], m[:, 2, 2]), np.arctan2(m[:, 1, 0], m[:, 1, 1])
    r = np.hypot(positions[:, 0], positions[:, 1]) - lengths.d6 * np.sin(tilt)
    z = positions[:, 2] - lengths.d1 - lengths.d6 * np.cos(tilt)
    joints = np.empty((5, 4, len(positions)))
    # Whether the plane is entered with J1 or with J1 + 180, what is behind axis 1 is
    # the wrist: the tool may reach across the axis.
    for turned in (0, 1):
        sign = 1.0 - 2.0 * turned
        line = np.arctan2(sign * r, z)
        elbow, shoulder = two_links(lengths.a2, lengths.d4, np.hypot(r, z))
        behind = (r < 0.0) ^ bool(turned)
        for lower in (0, 1):
            bend = -1.0 if lower else 1.0
            j2 = line - bend * shoulder
            j3 = bend * elbow
            j1 = azimuth + np.pi * turned
            j6 = roll + np.pi * turned
            found = np.stack([j1, j2, j3, sign * tilt - j2 - j3, j6])
            joints[:, 2 + lower, behind] = found[:, behind]
            joints[:, lower, ~behind] = found[:, ~behind]
    outside = reach_excess(lengths.a2, lengths.d4, np.hypot(r, z))
    return joints[:, list(branches)], np.broadcast_to(outside, (len(branches), len(positions)))


def _azimuth(positions: ArrayLike) -> Floats:
    p = np.asarray(positions, dtype=np.float64).reshape(-1, 3)
    on_axis = np.hypot(p[:, 0], p[:, 1]) < ON_AXIS_1
    return np.where(on_axis, 0.0, np.arctan2(p[:, 1], p[:, 0]))


def _arm_plane(positions: Floats, quaternions: Floats) -> Floats:
    """Azimuth of the arm's plane: that of the position, on axis 1 that of the tool axis."""
    x, y, _ = axis_z(quaternions)
    upright = np.hypot(x, y) < 1e-9
    on_axis = np.hypot(positions[:, 0], positions[:, 1]) < ON_AXIS_1
    return np.where(on_axis & ~upright, np.arctan2(y, x), _azimuth(positions))


def _in_arm_plane(azimuth: Floats, quaternions: ArrayLike) -> Floats:
    """(n, 3, 3) rotations seen from the plane of the arm."""
    q = np.asarray(quaternions, dtype=np.float64).reshape(-1, 4)
    back = rotations.about((0.0, 0.0, 1.0) * np.ones((len(q), 1)), np.degrees(-azimuth))
    return rotations.to_matrix(rotations.multiply(back, q))


def _wrapped_degrees(degrees: Floats) -> Floats:
    """Into (-180, 180]; what is within 1e-9 of -180 is 180, whatever its rounding."""
    turned = degrees - 360.0 * np.round(degrees / 360.0)
    return np.minimum(np.where(turned <= -180.0 + 1e-9, turned + 360.0, turned), 180.0) + 0.0
