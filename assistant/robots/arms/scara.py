"""Horizontal arms of four axes (SCARA): kinematics in closed form, in columns.

The chain is `Rz(J1)·Tx(l1)·Rz(J2)·Tx(l2)·Tz(J3)·Rz(J4)`, J3 in mm; at zero the arm is stretched
along X. Its flange only turns about the vertical.

The side of a branch is that of the flange from the line of the first link drawn out beyond axis
2, which is how Mitsubishi tells RIGHT (FLG1 4) from LEFT (FLG1 0): RIGHT has J2 below 0. A
configuration says left as `back`, and right and left both as down and flipped, so that the other
bits of FLG1 stay 0.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from assistant.base.arrays import Floats, Rows, Truths
from assistant.robots.arms.arm import BOUNDARY, MISS_TOLERANCE, Arm, Link, turn_between
from assistant.robots.arms.links import reach_excess, two_links


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
        """Branch 0 is right, 1 left; a tilted pose is taken upright, `miss` tells by how much."""
        x, y, z = positions.T
        span, line = np.hypot(x, y), np.arctan2(y, x)
        yaw = 2.0 * np.arctan2(quaternions[:, 3], quaternions[:, 0])
        elbow, shoulder = two_links(self.l1, self.l2, span)
        joints = np.empty((4, len(branches), len(positions)))
        for at, branch in enumerate(branches):
            sign = 1.0 if branch else -1.0
            j1, j2 = line - sign * shoulder, sign * elbow
            joints[:, at] = j1, j2, z, yaw - j1 - j2
        excess = reach_excess(self.l1, self.l2, span)
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
