"""Link lengths of a vertical jointed arm, and what follows from them alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from assistant.base.arrays import Floats, Truths
from assistant.robots.arms.arm import BOUNDARY, CLOSING
from assistant.robots.arms.links import axis_z


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
        wrist = positions - self.d6 * np.stack(axis_z(quaternions), axis=-1)
        r = np.hypot(wrist[:, 0], wrist[:, 1]) - self.a1
        span = np.hypot(r, wrist[:, 2] - self.d1)
        return np.asarray(span > np.hypot(self.a3, self.d4) + self.a2)


def wrist_words(shape: NDArray[np.integer]) -> str:
    """Columns (3,) back, down, flip of a vertical arm in words."""
    back, down, flip = (int(v) == 1 for v in shape)
    words = ("back" if back else "front", "elbow down" if down else "elbow up")
    return ", ".join((*words, "flip" if flip else "no flip"))
