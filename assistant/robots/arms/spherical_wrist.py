"""Recognise chains with a spherical wrist as six-axis arms with closed-form kinematics.

The lengths are read off the axes of the chain at zero and verified by forward kinematics. `Placed`
is such an arm with the joint senses, zeros, base and flange of the user's file.
"""

from __future__ import annotations

from functools import cached_property
from typing import ClassVar, Final

import numpy as np
from numpy.typing import NDArray

from assistant.base import rotations
from assistant.base.arrays import Floats, Rows, Truths
from assistant.base.data_classes import dataclass
from assistant.program.geometry import IDENTITY, Pose
from assistant.robots.arms.arm import Arm, Chain, Link
from assistant.robots.arms.closed_form import Lengths, SixAxis
from assistant.robots.arms.serial import Serial


@dataclass(frozen=True)
class Placed(Arm):
    """The closed form of `arm`, whose angles are senses · joints + zeros (radians).

    base: of that arm in the base of the file. flange: the file's in that of the arm. chain: the
    same chain as the file states it.
    """

    arm: SixAxis
    senses: tuple[int, ...]
    zeros: tuple[float, ...]
    base: Pose
    flange: Pose
    chain: Serial
    kind: ClassVar[str] = SixAxis.kind
    spherical: ClassVar[bool] = True
    axes: ClassVar[tuple[str, ...]] = SixAxis.axes
    branches: ClassVar[int] = SixAxis.branches
    compared: ClassVar[tuple[int, ...]] = SixAxis.compared

    @property
    def lengths(self) -> Lengths:
        return self.arm.lengths

    @property
    def reach(self) -> float:
        return self.arm.reach

    def fk(self, joints: Floats) -> tuple[Floats, Floats]:
        p, q = self.arm.fk(self._inner(joints))
        return _moved(self.base, *_taken(p, q, self.flange))

    def ik(
        self, positions: Floats, quaternions: Floats, branches: tuple[int, ...]
    ) -> tuple[Floats, Floats]:
        joints, excess = self.arm.ik(*self._wanted(positions, quaternions), branches)
        zeros, senses = np.array(self.zeros), np.array(self.senses)
        joints -= zeros[:, None, None]
        joints *= senses[:, None, None]
        return joints, excess

    @property
    def rolls(self) -> float:  # type: ignore[override]
        return float(self.senses[3] * self.senses[5])

    def shape(self, joints: Floats) -> NDArray[np.int8]:
        """Limits of a file need not keep elbow and wrist within half a turn, as makers do."""
        inner = self._inner(joints)
        tilt = np.arctan2(self.arm.lengths.a3, self.arm.lengths.d4)
        inner[:, 2] -= 2.0 * np.pi * np.round((inner[:, 2] + tilt) / (2.0 * np.pi))
        inner[:, 4] -= 2.0 * np.pi * np.round(inner[:, 4] / (2.0 * np.pi))
        return self.arm.shape(inner)

    def branch(self, shape: Rows) -> Rows:
        return self.arm.branch(shape)

    def words(self, shape: NDArray[np.integer]) -> str:
        return self.arm.words(shape)

    def points(self, joints: Floats) -> Floats:
        inner = self.arm.points(self._inner(joints))
        placed = rotations.rotate(np.array(self.base.quaternion), inner) + self.base.position
        return np.concatenate([placed, self.fk(joints)[0][:, None]], axis=1)

    def elbow(self, joints: Floats) -> Floats:
        return self.arm.elbow(self._inner(joints))

    def wrist(self, joints: Floats) -> Floats:
        return self.arm.wrist(self._inner(joints))

    def too_far(self, positions: Floats, quaternions: Floats) -> Truths:
        return self.arm.too_far(*self._wanted(positions, quaternions))

    def links(self) -> tuple[Link, ...]:
        return ()

    @cached_property
    def whole_chain(self) -> Chain:
        return self.chain.chain

    def _inner(self, joints: Floats) -> Floats:
        return np.asarray(joints * self._signs + np.array(self.zeros))

    @cached_property
    def _signs(self) -> Floats:
        return np.array(self.senses, dtype=np.float64)

    def _wanted(self, positions: Floats, quaternions: Floats) -> tuple[Floats, Floats]:
        """Poses of the file's flange in its base → of the arm's in its own."""
        inner = _taken(positions, quaternions, self.flange.inverse())
        p, q = _moved(self.base.inverse(), *inner)
        return p, rotations.canonical(q)


def _moved(base: Pose, positions: Floats, quaternions: Floats) -> tuple[Floats, Floats]:
    turned = rotations.rotate(np.array(base.quaternion), positions)
    q = rotations.multiply(np.array(base.quaternion), quaternions)
    return turned + np.array(base.position), rotations.canonical(q)


def _taken(positions: Floats, quaternions: Floats, part: Pose) -> tuple[Floats, Floats]:
    """Poses with a part in their own frame."""
    p = positions + rotations.rotate(quaternions, part.position)
    return p, rotations.multiply(quaternions, part.quaternion)


_AXES_MEET: Final = 1e-6
"""mm between the axes of a wrist, and what a cosine may be off."""
_QUATERNION_ROUNDING: Final = 1e-12
"""Rounding of the components of a quaternion; smaller values result from arithmetic."""
_KINEMATICS_AGREE: Final = 1e-9
"""By which forward kinematics of both may differ: in part of the reach, and radians."""
_TRIAL_JOINTS: Final = 50


def recognise_six_axis(chain: Serial) -> Placed | None:
    """The chain in closed form, None if it is no arm of six axes with a spherical wrist."""
    if len(chain.joints) != len(SixAxis.axes) or chain.sliding.any():
        return None
    found = [_read_arm(chain, side) for side in (1, -1)]
    arms = [arm for arm in found if arm is not None and _agree(arm, chain)]
    # Of the two ways to look at axis 2 the one that has axis 1 where the file has it.
    return min(arms, key=lambda arm: abs(_wrapped_radians(arm.zeros[0])), default=None)


@dataclass(frozen=True, slots=True)
class _Plane:
    """The plane of the arm at zero. forward, side, up: unit vectors of the arm's base."""

    origin: Floats
    forward: Floats
    side: Floats
    up: Floats

    def of(self, vector: Floats) -> tuple[float, float]:
        return float(vector @ self.forward), float(vector @ self.up)


def _read_arm(chain: Serial, side: int) -> Placed | None:
    """side: whether axis 2 counts to the side that its own direction names."""
    origins, axes, flange = chain.at_zero()
    one, two, three, four, five, six = axes
    wrist = _meeting(origins[3:], axes[3:])
    across = [
        one @ two,
        three @ four,
        four @ five,
        five @ six,
        np.linalg.norm(np.cross(two, three)),
    ]
    if wrist is None or np.abs(across).max() > _AXES_MEET:
        return None
    up = one if one[2] > -_AXES_MEET else -one
    normal = two * side
    plane = _Plane(_foot(origins[0], up), np.cross(normal, up), normal, up)
    if abs((wrist - plane.origin) @ normal) > _AXES_MEET:
        return None
    a1, d1 = plane.of(origins[1] - plane.origin)
    r3, z3 = plane.of(origins[2] - origins[1])
    rw, zw = plane.of(wrist - origins[2])
    r4, z4 = plane.of(four)
    sense = 1 if r4 * rw + z4 * zw > 0.0 else -1
    upper, fore = float(np.arctan2(r3, z3)), float(np.arctan2(sense * r4, sense * z4))
    d4 = rw * np.sin(fore) + zw * np.cos(fore)
    a3 = rw * np.cos(fore) - zw * np.sin(fore)
    a2 = float(np.hypot(r3, z3))
    if min(a2, d4) < _AXES_MEET:
        return None
    along = plane.forward * np.sin(fore) + up * np.cos(fore)
    ahead = plane.forward * np.cos(fore) - up * np.sin(fore)
    bend = 1 if five @ normal >= -_AXES_MEET else -1
    roll = float(np.arctan2(-bend * (five @ ahead), bend * (five @ normal)))
    hand = 1 if six @ along > 0.0 else -1
    d6 = float((flange.position - wrist) @ six) * hand
    # The closed form has axes 4 and 6 in line at 0 of axis 5, and both turn the same way.
    if np.linalg.norm(np.cross(six, along)) > _AXES_MEET or hand != sense:
        return None
    arm = SixAxis(Lengths(d1, a1, a2, float(a3), float(d4), d6))
    turn = _between(plane)
    base = Pose.of(plane.origin, turn)
    ways = (one @ up, two @ normal, three @ normal, sense, bend, hand)
    senses = tuple(1 if way > 0.0 else -1 for way in ways)
    zeros = (0.0, upper, fore - upper, roll, 0.0, 0.0)
    return _flanged(_turned_to_base(arm, senses, zeros, base, chain), flange)


def _turned_to_base(
    arm: SixAxis, senses: tuple[int, ...], zeros: tuple[float, ...], base: Pose, chain: Serial
) -> Placed:
    """With the base's axes those of the file where only a turn about axis 1 is between them."""
    w, x, y, z = base.quaternion
    if abs(x) < _QUATERNION_ROUNDING and abs(y) < _QUATERNION_ROUNDING:
        zeros = (2.0 * float(np.arctan2(z, w)), *zeros[1:])
        base = Pose(base.position)
    return Placed(arm, senses, zeros, base, IDENTITY, chain)


def _flanged(arm: Placed, flange: Pose) -> Placed:
    """With the flange of the file; a mere turn about axis 6 is one of its zero."""
    zero = np.zeros((1, len(arm.senses)))
    p, q = arm.fk(zero)
    rest = Pose.of(p[0], q[0]).inverse() @ flange
    w, x, y, z = rest.quaternion
    if (
        max(abs(x), abs(y)) < _QUATERNION_ROUNDING
        and np.abs(rest.position).max() < 1000.0 * _QUATERNION_ROUNDING
    ):
        last = 2.0 * float(np.arctan2(z, w))
        return Placed(arm.arm, arm.senses, (*arm.zeros[:5], last), arm.base, IDENTITY, arm.chain)
    return Placed(arm.arm, arm.senses, arm.zeros, arm.base, rest, arm.chain)


def _agree(arm: Placed, chain: Serial) -> bool:
    joints = np.random.default_rng(0).uniform(-np.pi, np.pi, (_TRIAL_JOINTS, len(chain.joints)))
    (p, q), (there, turned) = arm.fk(joints), chain.fk(joints)
    near = np.abs(p - there).max() < _KINEMATICS_AGREE * max(chain.reach, 1.0)
    return bool(near and _close(q, turned))


def _close(left: Floats, right: Floats) -> bool:
    """True if quaternions are the same within `_KINEMATICS_AGREE`, regardless of sign."""
    same = np.where(np.einsum("ij,ij->i", left, right)[:, None] < 0.0, -right, right)
    return bool(np.abs(left - same).max() < _KINEMATICS_AGREE)


def _meeting(origins: Floats, axes: Floats) -> Floats | None:
    """Return the point where three axes meet, None if they do not."""
    # Least squares of the distances: (1 - z zᵀ) (x - o) = 0 for each axis.
    across = np.eye(3) - axes[:, :, None] * axes[:, None, :]
    total = across.sum(axis=0)
    if np.linalg.cond(total) > 1.0 / _AXES_MEET:
        return None
    point = np.linalg.solve(total, np.einsum("kij,kj->i", across, origins))
    off = np.einsum("kij,kj->ki", across, point - origins)
    return point if np.abs(off).max() < _AXES_MEET else None


def _foot(origin: Floats, up: Floats) -> Floats:
    """The point of axis 1 that is nearest to the origin of the file's base."""
    return np.asarray(origin - (origin @ up) * up)


def _between(plane: _Plane) -> Floats:
    matrix = np.stack([plane.forward, plane.side, plane.up], axis=1)
    return np.asarray(rotations.from_matrix(matrix[None])[0])


def _wrapped_radians(angle: float) -> float:
    return float(angle - 2.0 * np.pi * np.round(angle / (2.0 * np.pi)))
