"""Arms of six axes with a spherical wrist: kinematics in closed form, in columns.

The chain is `Rz(J1)·Tr(a1,0,d1)·Ry(J2)·Tr(0,0,a2)·Ry(J3)·Tr(a3,0,d4)·Rz(J4)·Ry(J5)·Rz(J6)·
Tr(0,0,d6)`; at zero the arm stands straight up and the flange is parallel to the base. ABB's
zero has the forearm level, which is J3 = 90 here, with the same senses of all axes.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Final

import numpy as np
from numpy.typing import NDArray

from assistant.base import rotations
from assistant.base.arrays import Floats, Rows, Truths
from assistant.robots.arms.arm import BOUNDARY, Arm, Link
from assistant.robots.arms.lengths import Lengths, wrist_words
from assistant.robots.arms.links import axis_z, reach_excess, two_links, zyz

SIX_AXIS_BRANCHES: Final = 8
"""Branch 4·back + 2·lower + flip; lower: the forearm is bent backwards from the upper arm."""
WRIST_IN_LINE: Final = 1e-8
"""Sine of axis 5 below which arithmetic gives axes 4 and 6 more error each than it gives axis 5."""


@dataclass(frozen=True, slots=True)
class SixAxis(Arm):
    """An arm of six axes, the last three of which meet in the wrist centre."""

    lengths: Lengths
    kind: ClassVar[str] = "six-axis"
    spherical: ClassVar[bool] = True
    axes: ClassVar[tuple[str, ...]] = ("J1", "J2", "J3", "J4", "J5", "J6")
    branches: ClassVar[int] = SIX_AXIS_BRANCHES
    # Axis 5 instead of 4 and 6, which mean nothing by themselves where it is 0.
    compared: ClassVar[tuple[int, ...]] = (0, 1, 2, 4)

    @property
    def reach(self) -> float:
        return self.lengths.reach

    def fk(self, joints: Floats) -> tuple[Floats, Floats]:
        return six_axis_fk(self.lengths, joints)

    def ik(
        self, positions: Floats, quaternions: Floats, branches: tuple[int, ...]
    ) -> tuple[Floats, Floats]:
        return six_axis_ik(self.lengths, positions, quaternions, branches)

    def shape(self, joints: Floats) -> NDArray[np.int8]:
        back, lower = self.lengths.sides(joints)
        flip = joints[:, 4] < -np.radians(BOUNDARY)
        return np.stack([back, lower ^ back, flip], axis=-1).astype(np.int8)

    def branch(self, shape: Rows) -> Rows:
        back = shape[:, 0] == 1
        lower = (shape[:, 1] == 1) ^ back
        return np.asarray(4 * back + 2 * lower + (shape[:, 2] == 1), dtype=np.intp)

    def words(self, shape: NDArray[np.integer]) -> str:
        return wrist_words(shape)

    def points(self, joints: Floats) -> Floats:
        return self.lengths.points(joints, self.fk(joints)[0])

    def elbow(self, joints: Floats) -> Floats:
        return self.lengths.elbow(joints)

    def wrist(self, joints: Floats) -> Floats:
        return self.lengths.wrist(joints)

    def too_far(self, positions: Floats, quaternions: Floats) -> Truths:
        return self.lengths.too_far(positions, quaternions)

    def links(self) -> tuple[Link, ...]:
        arm, quarter = self.lengths, np.pi / 2.0
        return (
            Link(a=arm.a1, d=arm.d1, alpha=-quarter),
            Link(a=arm.a2, theta=-quarter),
            Link(a=arm.a3, alpha=quarter, theta=quarter),
            Link(d=arm.d4, alpha=-quarter),
            Link(alpha=quarter),
            Link(d=arm.d6),
        )


def six_axis_fk(lengths: Lengths, joints: Floats) -> tuple[Floats, Floats]:
    """Chain angles (n, 6) in radians → flange positions (n, 3) mm, quaternions (n, 4)."""
    j1, j2, j3, j4, j5, j6 = joints.T
    fore = j2 + j3
    s, c = np.sin(fore), np.cos(fore)
    r = lengths.a1 + lengths.a2 * np.sin(j2) + lengths.a3 * c + lengths.d4 * s
    z = lengths.d1 + lengths.a2 * np.cos(j2) - lengths.a3 * s + lengths.d4 * c
    arm = zyz(j1, fore, np.zeros_like(j1))
    quaternions = rotations.canonical(rotations.multiply(arm, zyz(j4, j5, j6)))
    x, y, up = axis_z(quaternions)
    positions = np.stack(
        [
            r * np.cos(j1) + lengths.d6 * x,
            r * np.sin(j1) + lengths.d6 * y,
            z + lengths.d6 * up,
        ],
        axis=-1,
    )
    return positions, quaternions


def six_axis_ik(
    lengths: Lengths, positions: Floats, quaternions: Floats, branches: tuple[int, ...]
) -> tuple[Floats, Floats]:
    """Flange poses → chain angles (6, b, n) in radians and what keeps each from closing (b, n) mm.

    branches: which of `BRANCHES`, ascending.

    A length of 0 closes; otherwise it is by how far the wrist centre is out of reach of the
    stretched or folded arm, whose angles then point at it. Where axes 4 and 6 are in line
    axis 4 is 0, and axis 1 is 0 for a wrist centre on it.
    """
    w, qx, qy, qz = quaternions.T
    # Columns of the rotation matrix: ax the flange's x axis, ay its y axis, az its z axis.
    ax = (1 - 2 * (qy * qy + qz * qz), 2 * (qx * qy + w * qz), 2 * (qx * qz - w * qy))
    ay = (2 * (qx * qy - w * qz), 1 - 2 * (qx * qx + qz * qz), 2 * (qy * qz + w * qx))
    az = (2 * (qx * qz + w * qy), 2 * (qy * qz - w * qx), 1 - 2 * (qx * qx + qy * qy))
    x, y, z = (positions[:, i] - lengths.d6 * az[i] for i in range(3))
    z = z - lengths.d1
    distance = np.hypot(x, y)
    on_axis = distance < 1e-9
    first = np.where(on_axis, 0.0, np.arctan2(y, x))
    c1, s1 = np.cos(first), np.sin(first)
    fore_length = float(np.hypot(lengths.a3, lengths.d4))
    tilt = float(np.arctan2(lengths.a3, lengths.d4))

    joints = np.empty((6, len(branches), len(positions)))
    excess = np.empty((len(branches), len(positions)))
    for back in sorted({branch // 4 for branch in branches}):
        sign = -1.0 if back else 1.0
        r = sign * distance - lengths.a1
        span = np.hypot(r, z)
        line = np.arctan2(r, z)
        elbow, shoulder = two_links(lengths.a2, fore_length, span)
        outside = reach_excess(lengths.a2, fore_length, span)
        # The flange's axes in the plane of the arm: u forward, v sideways.
        plane = [
            (sign * (c1 * a[0] + s1 * a[1]), sign * (c1 * a[1] - s1 * a[0]), a[2])
            for a in (ax, ay, az)
        ]
        for lower in sorted({branch // 2 % 2 for branch in branches if branch // 4 == back}):
            bend = -1.0 if lower else 1.0
            branch = 4 * back + 2 * lower
            j2 = line - bend * shoulder
            j3 = bend * elbow - tilt
            s, c = np.sin(j2 + j3), np.cos(j2 + j3)
            (xu, xv, xz), (yu, _, yz), (zu, zv, zz) = plane
            across = zu * c - zz * s
            along = zu * s + zz * c
            sine = np.hypot(across, zv)
            in_line = sine < WRIST_IN_LINE
            j4 = np.where(in_line, 0.0, np.arctan2(zv, across))
            j5 = np.arctan2(sine, along)
            turn = np.arctan2(yu * s + yz * c, -(xu * s + xz * c))
            # In line, the whole wrist is one turn about the forearm.
            straight = np.arctan2(xv, np.sign(along) * (xu * c - xz * s))
            j6 = np.where(in_line, straight, turn)
            half_turn = np.pi * ~in_line
            for flip in (0, 1):
                if branch + flip not in branches:
                    continue
                at = branches.index(branch + flip)
                excess[at] = outside
                joints[0, at], joints[1, at], joints[2, at] = first + np.pi * back, j2, j3
                joints[3, at] = j4 + half_turn if flip else j4
                joints[4, at] = -j5 if flip else j5
                joints[5, at] = j6 + half_turn if flip else j6
    return joints, excess
