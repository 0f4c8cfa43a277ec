"""Closed-form kinematics of six-axis, five-axis and SCARA arms, in columns.

Six axes: `Rz(J1)·Tr(a1,0,d1)·Ry(J2)·Tr(0,0,a2)·Ry(J3)·Tr(a3,0,d4)·Rz(J4)·Ry(J5)·Rz(J6)·Tr(0,0,d6)`;
at zero the arm stands straight up and the flange is parallel to the base. ABB's zero has the
forearm level, which is J3 = 90 here, with the same senses of all axes.

Five axes (RV-2AJ): there is no J4, so the tool axis always lies in the vertical plane through
axis 1 and two angles state the orientation:

    R = Rz(J1)·Ry(B)·Rz(J6)     B = J2 + J3 + J5     A = J6 + J1·cos B     J1 = atan2(y, x)

B is the tilt of the tool axis from straight up (0 up, 90 forward, 180 down), A the roll of the
hand. For B of 0, 90 and 180 an RV-2AJ shows the same; in between it is the interpolation that its
users compute with.

SCARA: `Rz(J1)·Tx(l1)·Rz(J2)·Tx(l2)·Tz(J3)·Rz(J4)`, J3 in mm; at zero it is stretched along X. The
side of a branch is that of the flange from the line of the first link drawn out beyond axis 2, as
Mitsubishi tells RIGHT (FLG1 4, J2 below 0) from LEFT (FLG1 0). A configuration states left as
`back`, and both sides as down and flipped, so that the other bits of FLG1 stay 0.
"""

from __future__ import annotations

from typing import ClassVar, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from assistant.base import rotations
from assistant.base.arrays import Floats, Rows, Truths
from assistant.base.data_classes import dataclass
from assistant.robots.arms.arm import BOUNDARY, CLOSING, MISS_TOLERANCE, Arm, Link, turn_between


def _zyz(first: Floats, second: Floats, third: Floats) -> Floats:
    """(..., 4) quaternions of Rz(first)·Ry(second)·Rz(third), radians."""
    plus, minus, half = (first + third) / 2.0, (first - third) / 2.0, second / 2.0
    c, s = np.cos(half), np.sin(half)
    return np.stack([c * np.cos(plus), -s * np.sin(minus), s * np.cos(minus), c * np.sin(plus)], -1)


def _axis_z(quaternions: Floats) -> tuple[Floats, Floats, Floats]:
    """The flange's own z axis, (n,) a component."""
    w, x, y, z = quaternions.T
    return 2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)


def _two_links(upper: float, fore: float, distance: Floats) -> tuple[Floats, Floats]:
    """Angles at the elbow and between upper link and line to the wrist, radians, both >= 0.

    Out of reach the arm is stretched or folded towards the wrist.
    """
    cosine = (distance * distance - upper * upper - fore * fore) / (2.0 * upper * fore)
    elbow = np.arccos(np.clip(cosine, -1.0, 1.0))
    return elbow, np.arctan2(fore * np.sin(elbow), upper + fore * np.cos(elbow))


def _reach_excess(upper: float, fore: float, distance: Floats) -> Floats:
    """Return by how many mm a wrist at that distance from axis 2 is too far or too near, else 0."""
    far, near = distance - (upper + fore), abs(upper - fore) - distance
    return np.maximum(np.maximum(far, near), 0.0)


@dataclass(frozen=True, slots=True)
class Lengths:
    """Link lengths in mm, all axes at the zero of the common chain (arm straight up).

    d1: floor to axis 2. a1: axis 1 to axis 2, forward. a2: axis 2 to axis 3.
    a3: axis 3 to the axis of the forearm, forward (negative: backward).
    d4: axis 3 to the wrist centre along the forearm. d6: wrist centre to the flange.
    """

    d1: float
    a1: float
    a2: float
    a3: float
    d4: float
    d6: float

    @property
    def reach(self) -> float:
        """Mm from axis 1 to the wrist centre of the stretched arm."""
        return float(self.a1 + self.a2 + np.hypot(self.a3, self.d4))

    def sides(self, joints: Floats) -> tuple[Truths, Truths]:
        """(n,) whether the wrist is behind axis 1, and whether the elbow is bent backwards.

        joints: (n, 3 …) radians of the common chain.
        """
        # By its sine, which is the same for a joint that has turned on by 360 degrees.
        lower = np.sin(self.elbow(joints)) < -np.radians(BOUNDARY)
        return self.wrist(joints) < -CLOSING, lower

    def elbow(self, joints: Floats) -> Floats:
        """(n,) radians from the stretched arm; joints: (n, 3 …) of the common chain."""
        return np.asarray(joints[:, 2] + np.arctan2(self.a3, self.d4))

    def wrist(self, joints: Floats) -> Floats:
        """(n,) mm of the wrist centre in front of axis 1; joints: (n, 3 …) of the common chain."""
        upper, fore = joints[:, 1], joints[:, 1] + joints[:, 2]
        r = self.a1 + self.a2 * np.sin(upper) + self.a3 * np.cos(fore) + self.d4 * np.sin(fore)
        return np.asarray(r)

    def points(self, joints: Floats, flange: Floats) -> Floats:
        """(n, 6, 3) mm: base, axis 2, axis 3, forearm, wrist centre, flange (n, 3)."""
        fore = joints[:, 1] + joints[:, 2]
        c1, s1 = np.cos(joints[:, 0]), np.sin(joints[:, 0])
        zero = np.zeros(len(joints))
        r2, z2 = zero + self.a1, zero + self.d1
        r3, z3 = r2 + self.a2 * np.sin(joints[:, 1]), z2 + self.a2 * np.cos(joints[:, 1])
        r4, z4 = r3 + self.a3 * np.cos(fore), z3 - self.a3 * np.sin(fore)
        r5, z5 = r4 + self.d4 * np.sin(fore), z4 + self.d4 * np.cos(fore)
        arms = [(zero, zero), (r2, z2), (r3, z3), (r4, z4), (r5, z5)]
        points = [np.stack([r * c1, r * s1, z], axis=-1) for r, z in arms]
        return np.stack([*points, flange], axis=1)

    def too_far(self, positions: Floats, quaternions: Floats) -> Truths:
        """(n,) whether the wrist is beyond the stretched arm, by the shorter way round axis 1."""
        wrist = positions - self.d6 * np.stack(_axis_z(quaternions), axis=-1)
        r = np.hypot(wrist[:, 0], wrist[:, 1]) - self.a1
        span = np.hypot(r, wrist[:, 2] - self.d1)
        return np.asarray(span > np.hypot(self.a3, self.d4) + self.a2)


def _wrist_words(shape: NDArray[np.integer]) -> str:
    """Columns (3,) back, down, flip of a vertical arm in words."""
    back, down, flip = (int(v) == 1 for v in shape)
    words = ("back" if back else "front", "elbow down" if down else "elbow up")
    return ", ".join((*words, "flip" if flip else "no flip"))


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
        return _six_axis_fk(self.lengths, joints)

    def ik(
        self, positions: Floats, quaternions: Floats, branches: tuple[int, ...]
    ) -> tuple[Floats, Floats]:
        return _six_axis_ik(self.lengths, positions, quaternions, branches)

    def shape(self, joints: Floats) -> NDArray[np.int8]:
        back, lower = self.lengths.sides(joints)
        flip = joints[:, 4] < -np.radians(BOUNDARY)
        return np.stack([back, lower ^ back, flip], axis=-1).astype(np.int8)

    def branch(self, shape: Rows) -> Rows:
        back = shape[:, 0] == 1
        lower = (shape[:, 1] == 1) ^ back
        return np.asarray(4 * back + 2 * lower + (shape[:, 2] == 1), dtype=np.intp)

    def words(self, shape: NDArray[np.integer]) -> str:
        return _wrist_words(shape)

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


def _six_axis_fk(lengths: Lengths, joints: Floats) -> tuple[Floats, Floats]:
    """Chain angles (n, 6) in radians → flange positions (n, 3) mm, quaternions (n, 4)."""
    j1, j2, j3, j4, j5, j6 = joints.T
    fore = j2 + j3
    s, c = np.sin(fore), np.cos(fore)
    r = lengths.a1 + lengths.a2 * np.sin(j2) + lengths.a3 * c + lengths.d4 * s
    z = lengths.d1 + lengths.a2 * np.cos(j2) - lengths.a3 * s + lengths.d4 * c
    arm = _zyz(j1, fore, np.zeros_like(j1))
    quaternions = rotations.canonical(rotations.multiply(arm, _zyz(j4, j5, j6)))
    x, y, up = _axis_z(quaternions)
    positions = np.stack(
        [
            r * np.cos(j1) + lengths.d6 * x,
            r * np.sin(j1) + lengths.d6 * y,
            z + lengths.d6 * up,
        ],
        axis=-1,
    )
    return positions, quaternions


def _six_axis_ik(
    lengths: Lengths, positions: Floats, quaternions: Floats, branches: tuple[int, ...]
) -> tuple[Floats, Floats]:
    """Flange poses → chain angles (6, b, n) in radians and what keeps each from closing (b, n) mm.

    branches: which of `SIX_AXIS_BRANCHES`, ascending.

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
        elbow, shoulder = _two_links(lengths.a2, fore_length, span)
        outside = _reach_excess(lengths.a2, fore_length, span)
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


ON_AXIS_1: Final = 1e-6
"""mm; a point nearer to axis 1 has no azimuth and gets 0."""


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
        return _five_axis_fk(self.lengths, joints)

    def ik(
        self, positions: Floats, quaternions: Floats, branches: tuple[int, ...]
    ) -> tuple[Floats, Floats]:
        return _five_axis_ik(self.lengths, positions, quaternions, branches)

    def shape(self, joints: Floats) -> NDArray[np.int8]:
        """Flip is 1, which is FLG1 6 for the front, upper branch."""
        back, lower = self.lengths.sides(joints)
        return np.stack([back, lower ^ back, np.ones_like(back)], axis=-1).astype(np.int8)

    def branch(self, shape: Rows) -> Rows:
        back = shape[:, 0] == 1
        return np.asarray(2 * back + ((shape[:, 1] == 1) ^ back), dtype=np.intp)

    def words(self, shape: NDArray[np.integer]) -> str:
        return _wrist_words(shape)

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

    An orientation that the arm cannot take (see `plane_miss`) gives those of the nearest plane.
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
    return rotations.canonical(_zyz(azimuth, b, a - azimuth * np.cos(b)))


def plane_miss(positions: ArrayLike, quaternions: ArrayLike) -> Floats:
    """(n,) degrees by which the tool axis leaves the plane through axis 1 and the position.

    0 for a vertical tool, which lies in every plane.
    """
    m = _in_arm_plane(_azimuth(positions), quaternions)
    return np.asarray(np.degrees(np.abs(np.arcsin(np.clip(m[:, 1, 2], -1.0, 1.0)))))


def _five_axis_fk(lengths: Lengths, joints: Floats) -> tuple[Floats, Floats]:
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
    return positions, rotations.canonical(_zyz(j1, tilt, j6))


def _five_axis_ik(
    lengths: Lengths, positions: Floats, quaternions: Floats, branches: tuple[int, ...]
) -> tuple[Floats, Floats]:
    """Flange poses → chain angles (5, b, n) in radians and what keeps each from closing (b, n) mm.

    branches: which of the four, ascending; 2·back + lower, lower being a negative angle of
    the elbow. A length of 0 closes; otherwise it is by how far the wrist is out of reach of
    the stretched or folded arm.
    The tool axis is taken into the plane of the arm; `plane_miss` tells by how much.
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
        elbow, shoulder = _two_links(lengths.a2, lengths.d4, np.hypot(r, z))
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
    outside = _reach_excess(lengths.a2, lengths.d4, np.hypot(r, z))
    return joints[:, list(branches)], np.broadcast_to(outside, (len(branches), len(positions)))


def _azimuth(positions: ArrayLike) -> Floats:
    p = np.asarray(positions, dtype=np.float64).reshape(-1, 3)
    on_axis = np.hypot(p[:, 0], p[:, 1]) < ON_AXIS_1
    return np.where(on_axis, 0.0, np.arctan2(p[:, 1], p[:, 0]))


def _arm_plane(positions: Floats, quaternions: Floats) -> Floats:
    """Azimuth of the arm's plane: that of the position, on axis 1 that of the tool axis."""
    x, y, _ = _axis_z(quaternions)
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


@dataclass(frozen=True, slots=True)
class Scara(Arm):
    """An arm of four axes. l1, l2: mm from axis 1 to 2 and from axis 2 to 3 and 4."""

    l1: float
    l2: float
    kind: ClassVar[str] = "scara"
    angle: ClassVar[float] = MISS_TOLERANCE
    flags: ClassVar[int] = 4
    axes: ClassVar[tuple[str, ...]] = ("J1", "J2", "J3", "J4")
    branches: ClassVar[int] = 2
    compared: ClassVar[tuple[int, ...]] = (0, 1, 3)

    @property
    def sliding(self) -> Truths:
        return np.array([False, False, True, False])

    @property
    def reach(self) -> float:
        return self.l1 + self.l2

    def fk(self, joints: Floats) -> tuple[Floats, Floats]:
        j1, j2, j3, j4 = joints.T
        both, half = j1 + j2, (j1 + j2 + j4) / 2.0
        x = self.l1 * np.cos(j1) + self.l2 * np.cos(both)
        y = self.l1 * np.sin(j1) + self.l2 * np.sin(both)
        nothing = np.zeros_like(half)
        quaternions = np.stack([np.cos(half), nothing, nothing, np.sin(half)], axis=-1)
        quaternions[quaternions[:, 0] < 0.0] *= -1.0
        return np.stack([x, y, j3], axis=-1), quaternions

    def ik(
        self, positions: Floats, quaternions: Floats, branches: tuple[int, ...]
    ) -> tuple[Floats, Floats]:
        """Branch 0 is right, 1 left; a tilted pose is taken upright, `plane_miss` tells by how
        much.
        """
        x, y, z = positions.T
        span, line = np.hypot(x, y), np.arctan2(y, x)
        yaw = 2.0 * np.arctan2(quaternions[:, 3], quaternions[:, 0])
        elbow, shoulder = _two_links(self.l1, self.l2, span)
        joints = np.empty((4, len(branches), len(positions)))
        for at, branch in enumerate(branches):
            sign = 1.0 if branch else -1.0
            j1, j2 = line - sign * shoulder, sign * elbow
            joints[:, at] = j1, j2, z, yaw - j1 - j2
        excess = _reach_excess(self.l1, self.l2, span)
        return joints, np.broadcast_to(excess, (len(branches), len(positions)))

    def shape(self, joints: Floats) -> NDArray[np.int8]:
        """In line the arm counts as right."""
        turn = joints[:, 1] - 2.0 * np.pi * np.round(joints[:, 1] / (2.0 * np.pi))
        left = turn > np.radians(BOUNDARY)
        return np.stack([left, np.ones_like(left), np.ones_like(left)], axis=-1).astype(np.int8)

    def branch(self, shape: Rows) -> Rows:
        return np.asarray(shape[:, 0] == 1, dtype=np.intp)

    def words(self, shape: NDArray[np.integer]) -> str:
        return "left" if int(shape[0]) == 1 else "right"

    def points(self, joints: Floats) -> Floats:
        """(n, 5, 3): base, axis 1, axis 2 and axis 3 in the flange's highest plane, flange.

        The links are drawn level with the base, the height of the column being no part of
        the chain.
        """
        flange, _ = self.fk(joints)
        zero = np.zeros(len(joints))
        elbow = np.stack(
            [self.l1 * np.cos(joints[:, 0]), self.l1 * np.sin(joints[:, 0]), zero], axis=-1
        )
        end = np.stack([flange[:, 0], flange[:, 1], zero], axis=-1)
        return np.stack([np.zeros_like(elbow), elbow, end, flange], axis=1)

    def elbow(self, joints: Floats) -> Floats:
        return np.asarray(joints[:, 1])

    def miss(self, joints: Floats, quaternions: Floats) -> Floats:
        return turn_between(self.fk(joints)[1], quaternions)

    def too_far(self, positions: Floats, quaternions: Floats) -> Truths:  # noqa: ARG002
        return np.asarray(np.hypot(positions[:, 0], positions[:, 1]) > self.reach)

    def links(self) -> tuple[Link, ...]:
        return (Link(a=self.l1), Link(a=self.l2), Link(sliding=True), Link())
