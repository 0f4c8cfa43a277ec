"""A robot: its arm, its limits, and where its flange is for which joints."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from assistant.program.diagnostics import Diagnostic
from assistant.program.path import UNSTATED
from assistant.program.program import Program
from assistant.robots import five_axis, six_axis
from assistant.robots.configurations import BACK, DOWN, FLIP, QUADRANTS, TURNING_AXES
from assistant.robots.lengths import Lengths

Floats = NDArray[np.float64]
Truths = NDArray[np.bool_]

CLOSING: Final = 1e-5
"""mm and, for six axes, degrees within which forward kinematics must come back to a pose."""
LIMIT_TOLERANCE: Final = 1e-6
"""degrees by which a joint may pass its limit: rounding, no motion."""
BOUNDARY: Final = 1e-6
"""degrees below a quadrant's first angle that still count to it, for joints that are
meant to be 0 or 90 and come out of arithmetic as a little less."""
QUADRANT_TOLERANCE: Final = 1.0
"""degrees by which a joint may leave the quadrant that a target states: taught positions
are rounded, and near a singularity a rounded position turns the wrist by that much."""
CHUNK: Final = 16384
"""Rows that are computed at once: the columns stay in the processor's cache."""


@dataclass(frozen=True, slots=True, eq=False)
class Robot:
    """A robot of the catalogue.

    axes: names of the a joints, ("J1", …); a five-axis arm has no "J4".
    zero: (a,) deg of the common chain (see `six_axis`) where the maker's angle is 0.
    limits: (a, 2) deg. speeds: (a,) deg/s. home: (a,) deg. tcp_speed: mm/s. payload: kg.
    reach: mm from axis 1 to the wrist centre of the stretched arm.
    counts: what a target's configuration says of axes 1, 4 and 6: `quadrants` (ABB) or
    only whole `turns` (Mitsubishi).
    unconfirmed: fields whose figures no source at hand confirms.
    """

    name: str
    title: str
    maker: str
    controller: str
    languages: tuple[str, ...]
    axes: tuple[str, ...]
    lengths: Lengths
    zero: Floats
    limits: Floats
    speeds: Floats
    home: Floats
    tcp_speed: float
    payload: float
    reach: float
    counts: Literal["quadrants", "turns"]
    source: str
    unconfirmed: tuple[str, ...] = ()

    @property
    def five_axis(self) -> bool:
        """Whether the arm has no axis 4, so that its tool stays in one vertical plane."""
        return "J4" not in self.axes

    @property
    def branches(self) -> int:
        """How many arm branches `ik` gives."""
        return 4 if self.five_axis else six_axis.BRANCHES

    def fk(self, joints: ArrayLike) -> tuple[Floats, Floats]:
        """(n, a) deg → flange in the base: positions (n, 3) mm, quaternions (n, 4)."""
        angles = np.radians(self._joints(joints) + self.zero)
        room = five_axis if self.five_axis else six_axis
        positions, quaternions = room.fk(self.lengths, angles)
        return positions, quaternions

    def ik(self, positions: ArrayLike, quaternions: ArrayLike) -> tuple[Floats, Truths]:
        """Flange poses → joints (n, b, a) deg of every arm branch, valid (n, b).

        Valid: forward kinematics comes back to the pose, and every joint is inside its
        limits. An axis that turns further than once is given nearest to the middle of its
        range; `joints_of` finds the other turns. Joints of an invalid branch are NaN if it
        cannot be reached, else the angles that pass the limits.
        """
        p, q = _poses(positions, quaternions)
        joints = np.empty((len(p), self.branches, len(self.axes)))
        for start in range(0, len(p), CHUNK):
            rows = slice(start, start + CHUNK)
            found, _ = self.solve(p[rows], q[rows])
            for branch in range(self.branches):
                one = np.ascontiguousarray(found[:, branch].T)
                one[~self.closes(one, p[rows], q[rows])] = np.nan
                joints[rows, branch] = one
        return joints, self.inside(joints)

    def solve(
        self, positions: Floats, quaternions: Floats, branches: tuple[int, ...] | None = None
    ) -> tuple[Floats, Floats]:
        """Flange poses → joints (a, b, n) deg, unproven, and excess (b, n) mm of the reach.

        branches: of `branch_of`, which to compute; None for all. Each axis is nearest to
        the middle of its range.
        """
        wanted = tuple(range(self.branches)) if branches is None else branches
        room = five_axis if self.five_axis else six_axis
        angles, excess = room.ik(self.lengths, positions, quaternions, wanted)
        joints = np.degrees(angles, out=angles)
        joints -= self.zero[:, None, None]
        turns = joints - self.limits.mean(axis=1)[:, None, None]
        turns *= 1.0 / 360.0
        np.rint(turns, out=turns)
        turns *= 360.0
        joints -= turns
        return joints, excess

    def closes(self, joints: Floats, positions: Floats, quaternions: Floats) -> Truths:
        """(n,) whether forward kinematics of joints (n, a) gives the poses."""
        p, q = self.fk(joints)
        near = np.linalg.norm(p - positions, axis=1) < CLOSING
        angle = five_axis.MISS_TOLERANCE if self.five_axis else CLOSING
        same = np.abs(np.einsum("ij,ij->i", q, quaternions))
        # 1 - cos(half the angle), whose rounding is far below either tolerance.
        return np.asarray(near & (1.0 - same < 1.0 - np.cos(np.radians(angle) / 2.0) + 1e-14))

    def inside(self, joints: ArrayLike) -> Truths:
        """(..., a) deg → (...,) whether every joint is inside its limits; NaN is not."""
        j = np.asarray(joints, dtype=np.float64)
        low, high = self.limits.T
        return np.asarray(
            ((j >= low - LIMIT_TOLERANCE) & (j <= high + LIMIT_TOLERANCE)).all(axis=-1)
        )

    def configuration(self, joints: ArrayLike) -> NDArray[np.int8]:
        """(n, a) deg → (n, 6) neutral configuration columns (see `Path`).

        A five-axis arm has flip 1 and quadrant 0 for axis 4, which is FLG1 6 for the
        front, upper branch.
        """
        j = self._joints(joints)
        chain = np.radians(j + self.zero)
        upper, fore = chain[:, 1], chain[:, 1] + chain[:, 2]
        arm = self.lengths
        r = arm.a1 + arm.a2 * np.sin(upper) + arm.a3 * np.cos(fore) + arm.d4 * np.sin(fore)
        back = r < -CLOSING
        lower = chain[:, 2] + np.arctan2(arm.a3, arm.d4) < -np.radians(BOUNDARY)
        flip = np.ones(len(j), bool) if self.five_axis else j[:, 4] < -BOUNDARY
        columns = np.zeros((len(j), 6), dtype=np.int8)
        columns[:, BACK], columns[:, DOWN], columns[:, FLIP] = back, lower ^ back, flip
        for column, axis in self.turning():
            columns[:, column] = np.floor((j[:, axis] + BOUNDARY) / 90.0)
            if self.counts == "turns":
                # Turn 0 goes up to 180 and includes it, so 180 is still in quadrant 1.
                half = np.abs(j[:, axis] % 360.0 - 180.0) < BOUNDARY
                columns[half, column] = np.round(j[half, axis] / 90.0) - 1
        return columns

    def joints_of(
        self, positions: ArrayLike, quaternions: ArrayLike, configurations: ArrayLike
    ) -> Floats:
        """Flange poses (n, 3), (n, 4) and configurations (n, 6) → joints (n, a) deg.

        A row is NaN where the pose is out of reach, a joint outside its limits, or the
        quadrants (for `turns`, the turns) are not those that the branch has there. An
        unstated configuration gives the branch nearest to home.
        """
        p, q = _poses(positions, quaternions)
        c = np.asarray(configurations, dtype=np.int64).reshape(-1, 6)
        joints = np.empty((len(p), len(self.axes)))
        for start in range(0, len(p), CHUNK):
            rows = slice(start, start + CHUNK)
            joints[rows] = self._joints_of(p[rows], q[rows], c[rows])
        return joints

    def branch_of(self, configurations: NDArray[np.integer]) -> NDArray[np.intp]:
        """(n, 6) configurations → (n,) index of the branch among those of `ik`."""
        c = configurations.astype(np.intp)
        back = c[:, BACK] == 1
        lower = (c[:, DOWN] == 1) ^ back
        branch = 2 * back + lower
        return np.asarray(branch if self.five_axis else 2 * branch + (c[:, FLIP] == 1))

    def turned(
        self, joints: Floats, configurations: NDArray[np.integer]
    ) -> tuple[Floats, NDArray[np.bool_]]:
        """Joints (n, a) deg, their axes 1, 4 and 6 turned to what configurations (n, 6) say.

        With it (n, 3): whether each lies in the stated quadrant (or turn). Where axes 4
        and 6 are in line only their sum counts, and any quadrant of theirs fits.
        """
        out = joints.copy()
        fits = np.ones((len(joints), 3), dtype=bool)
        for column, axis in self.turning():
            q = configurations[:, column].astype(np.float64)
            if self.counts == "quadrants":
                centre, half = 90.0 * q + 45.0, 45.0
            else:
                # Both ends of turn 0 are the same angle: 180 belongs to it, -180 does not.
                centre, half = 360.0 * np.floor((q + 2.0) / 4.0) + BOUNDARY, 180.0
            out[:, axis] += 360.0 * np.round((centre - out[:, axis]) / 360.0)
            off = np.abs(out[:, axis] - centre) - half
            fits[:, column - QUADRANTS.start] = off <= QUADRANT_TOLERANCE
        if not self.five_axis:
            fits[np.abs(joints[:, 4]) < IN_LINE, 1:] = True
        return out, fits

    def turning(self) -> tuple[tuple[int, int], ...]:
        """(configuration column, joint index) of the axes whose turns a configuration names."""
        return tuple(
            (QUADRANTS.start + i, self.axes.index(f"J{axis}"))
            for i, axis in enumerate(TURNING_AXES)
            if f"J{axis}" in self.axes
        )

    def chain(self, joints: ArrayLike) -> Floats:
        """(n, a) deg → (n, 6, 3) mm: base, axis 2, axis 3, forearm, wrist centre, flange."""
        j = np.radians(self._joints(joints) + self.zero)
        arm, fore = self.lengths, j[:, 1] + j[:, 2]
        c1, s1 = np.cos(j[:, 0]), np.sin(j[:, 0])
        zero = np.zeros(len(j))
        r2, z2 = zero + arm.a1, zero + arm.d1
        r3, z3 = r2 + arm.a2 * np.sin(j[:, 1]), z2 + arm.a2 * np.cos(j[:, 1])
        r4, z4 = r3 + arm.a3 * np.cos(fore), z3 - arm.a3 * np.sin(fore)
        r5, z5 = r4 + arm.d4 * np.sin(fore), z4 + arm.d4 * np.cos(fore)
        arms = [(zero, zero), (r2, z2), (r3, z3), (r4, z4), (r5, z5)]
        points = [np.stack([r * c1, r * s1, z], axis=-1) for r, z in arms]
        return np.stack([*points, self.fk(joints)[0]], axis=1)

    def check(self, program: Program) -> tuple[Diagnostic, ...]:
        """What of a program is out of this robot's reach or limits."""
        from assistant.robots.configure import configure

        _, findings = configure(program, self)
        return findings

    def _joints(self, joints: ArrayLike) -> Floats:
        return np.asarray(joints, dtype=np.float64).reshape(-1, len(self.axes))

    def _joints_of(self, p: Floats, q: Floats, c: NDArray[np.int64]) -> Floats:
        found, _ = self.solve(p, q)
        rows = np.arange(len(p))
        stated = c[:, BACK] != UNSTATED
        branch = np.where(stated, self.branch_of(c), 0)
        if not stated.all():
            open_ = np.moveaxis(found[:, :, ~stated], 0, -1)
            away = np.abs(open_ - self.home).max(axis=-1)
            branch[~stated] = np.where(self.inside(open_), away, np.inf).argmin(axis=0)
        plain = found[:, branch, rows].T
        turned, fits = self.turned(plain, c)
        joints = np.where(stated[:, None], turned, plain)
        good = self.closes(joints, p, q) & self.inside(joints) & (fits.all(axis=1) | ~stated)
        joints[~good] = np.nan
        return joints


IN_LINE: Final = 0.05
"""degrees of axis 5 below which the angles of axes 4 and 6 mean nothing by themselves."""


def _poses(positions: ArrayLike, quaternions: ArrayLike) -> tuple[Floats, Floats]:
    p = np.asarray(positions, dtype=np.float64).reshape(-1, 3)
    q = np.asarray(quaternions, dtype=np.float64).reshape(-1, 4)
    with np.errstate(invalid="ignore", divide="ignore"):
        return p, q / np.linalg.norm(q, axis=1, keepdims=True)
