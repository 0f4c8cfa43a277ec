"""An arm of six axes whose joints, base and flange are counted as a file of the user's does it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from assistant.base import rotations
from assistant.base.arrays import Floats, Rows, Truths
from assistant.program.geometry import Pose
from assistant.robots.arms.arm import Arm, Link
from assistant.robots.arms.chain import Chain
from assistant.robots.arms.lengths import Lengths
from assistant.robots.arms.serial import Serial
from assistant.robots.arms.six_axis import SixAxis


@dataclass(frozen=True)
class Placed(Arm):
    """The closed form of `arm`, whose angles are senses · joints + zeros (radians).

    base: of that arm in the base of the file. flange: the file's in that of the arm.
    chain: the same as the file says it.
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
