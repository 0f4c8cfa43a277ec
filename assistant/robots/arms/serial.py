"""Arms of any chain of turning and sliding joints, without a closed form.

Forward kinematics is in columns. Inverse kinematics is roboticstoolbox's numerical solver, started
from the joints of a fixed set that are near the pose, so that the same pose always gives the same
joints.

No maker names the branches of such an arm. Three signs distinguish its solutions: whether the wrist
is in front of or behind axis 1, to which side the elbow is bent, and to which side the wrist. If an
arm has more solutions than these signs distinguish, one of each is found, next to the solution
before it in a column of poses.
"""

from __future__ import annotations

import enum
from collections.abc import Sequence
from functools import cached_property
from typing import Any, ClassVar, Final

import numpy as np
from numpy.typing import NDArray

from assistant.base import rotations
from assistant.base.arrays import Floats, Ints, Rows, Truths
from assistant.base.data_classes import dataclass
from assistant.program.geometry import IDENTITY, Pose
from assistant.robots.arms.arm import (
    CLOSING,
    METRE,
    Arm,
    Chain,
    ChainPoses,
    Joint,
    Link,
    pose_matrices,
    turn_between,
)

_SIGNS: Final = 3
STARTS: Final = (16384, 5)
"""Random joints out of which the starts for a pose are taken, and how many for each branch."""
STEPS: Final = 40
"""Steps of the solver from one start."""
_RESIDUAL: Final = 1e-21
"""Half the square of what is left over in metres and radians when the solver ends."""
PARALLEL: Final = 1e-9
FAR: Final = np.radians(10.0)
"""From one pose of a column to the next, radians or mm."""
_SAME: Final = 1e-6
"""Between joints that are one solution, radians or mm."""


class _Rank(enum.IntEnum):
    """Rank of joints as a solution: inside the limits, outside them, not closing, or missing."""

    INSIDE = 0
    OUTSIDE = 1
    OPEN = 2
    NONE = 3


@dataclass(frozen=True)
class Serial(Arm):
    """A chain of joints from the base. flange: its pose in the frame of the last joint."""

    joints: tuple[Joint, ...]
    flange: Pose = IDENTITY
    kind: ClassVar[str] = "serial"
    named: ClassVar[bool] = False

    @staticmethod
    def of_links(links: Sequence[Link], ranges: Sequence[tuple[float, float]]) -> Serial:
        """A chain of links with the ranges of their joints, radians or mm."""
        chain = Chain.of_links(links, ranges)
        return Serial(chain.joints, chain.flange)

    @property
    def axes(self) -> tuple[str, ...]:
        return tuple(f"J{number}" for number in range(1, len(self.joints) + 1))

    @property
    def branches(self) -> int:
        return 2**_SIGNS

    @property
    def compared(self) -> tuple[int, ...]:
        return tuple(range(len(self.joints)))

    @property
    def sliding(self) -> Truths:
        return np.array([joint.sliding for joint in self.joints])

    @cached_property
    def reach(self) -> float:
        """The sum of the lengths from axis 1 to the flange, no less than the arm reaches."""
        slides = sum(max(abs(j.low), abs(j.high)) for j in self.joints if j.sliding)
        poses = [*(joint.pose for joint in self.joints[1:]), self.flange]
        return float(sum(np.linalg.norm(pose.position) for pose in poses) + slides)

    def fk(self, joints: Floats) -> tuple[Floats, Floats]:
        found = self.chain.along(joints)
        return found.origins[:, -1], rotations.from_matrix(found.turns)

    def at_zero(self) -> tuple[Floats, Floats, Pose]:
        """Origins (a, 3) mm and axes (a, 3) of the joints and the pose of the flange, all at 0."""
        found = self.chain.along(np.zeros((1, len(self.joints))))
        flange = Pose.of(found.origins[0, -1], rotations.from_matrix(found.turns)[0])
        return found.origins[0, :-1], found.axes[0], flange

    def points(self, joints: Floats) -> Floats:
        """Base, the origins of the joints, flange."""
        origins = self.chain.along(joints).origins
        return np.concatenate([np.zeros_like(origins[:, :1]), origins], axis=1)

    @cached_property
    def chain(self) -> Chain:
        return Chain(self.joints, self.flange)

    @cached_property
    def whole_chain(self) -> Chain:
        return self.chain

    def ik(
        self, positions: Floats, quaternions: Floats, branches: tuple[int, ...]
    ) -> tuple[Floats, Floats]:
        """Return the joints per branch; without a solution, the closest approach and its distance
        in mm or, if more, degrees.

        All branches are solved, even if only some are requested: a search for one may find another.
        """
        key = (positions.tobytes(), quaternions.tobytes())
        if self._last.get("key") != key:
            self._last.update(key=key, found=self._all(positions, quaternions))
        joints, excess = self._last["found"]
        some = list(branches)
        return joints[:, some], excess[some]

    @cached_property
    def _last(self) -> dict[str, Any]:
        """Cache of the last column and its solution, as the same column is requested several
        times.
        """
        return {}

    def _all(self, positions: Floats, quaternions: Floats) -> tuple[Floats, Floats]:
        n, poses = len(positions), pose_matrices(positions, quaternions)
        best = np.tile(self._middle, (self.branches, n, 1))
        rank = np.full((self.branches, n), _Rank.NONE, dtype=np.int64)
        for branch in range(self.branches):
            for start in np.moveaxis(self._starts(positions, quaternions, branch), 1, 0):
                rows = np.flatnonzero(rank[branch] > _Rank.INSIDE)
                found = self._solved(poses[rows], start[rows])
                mine, fits = self._ranked(found, positions[rows], quaternions[rows])
                mine = np.where(fits == _Rank.OPEN, branch, mine)
                better = fits < rank[mine, rows]
                mine, rows = mine[better], rows[better]
                best[mine, rows], rank[mine, rows] = found[better], fits[better]
        for branch in range(self.branches):
            self._join(best[branch], rank[branch], poses, positions, quaternions, branch)
        off = [_off(self.chain.along(joints), positions, quaternions) for joints in best]
        return np.moveaxis(best, 2, 0), np.stack(off)

    def follow(
        self, joints: Floats, positions: Floats, quaternions: Floats
    ) -> tuple[Floats, Floats]:
        """Joints (m, a) taken along poses (m, s, 3) and (m, s, 4) → (m, s, a) and excess (m, s)."""
        m, s, _ = positions.shape
        p, q = positions.reshape(-1, 3), quaternions.reshape(-1, 4)
        poses = pose_matrices(p, q).reshape(m, s, 4, 4)
        out = np.empty((m, s, len(self.joints)))
        here = joints
        for k in range(s):
            out[:, k] = here = self._solved(poses[:, k], here)
        return out, _off(self.chain.along(out.reshape(m * s, -1)), p, q).reshape(m, s)

    def shape(self, joints: Floats) -> NDArray[np.int8]:
        return self._shape(self.chain.along(joints))

    def branch(self, shape: Rows) -> Rows:
        return np.asarray((shape == 1) @ np.array([4, 2, 1]), dtype=np.intp)

    def words(self, shape: NDArray[np.integer]) -> str:
        return f"branch {int(self.branch(shape[None].astype(np.intp))[0]) + 1} of {self.branches}"

    def too_far(self, positions: Floats, quaternions: Floats) -> Truths:  # noqa: ARG002
        first = np.array(self.joints[0].pose.position)
        return np.asarray(np.linalg.norm(positions - first, axis=1) > self.reach)

    def links(self) -> tuple[Link, ...]:
        """None: its axes lie as they lie."""
        return ()

    @cached_property
    def _turning(self) -> tuple[int, ...]:
        return tuple(i for i, joint in enumerate(self.joints) if not joint.sliding)

    @cached_property
    def _bend(self) -> tuple[int, int | None]:
        """Return the elbow: the first of two axes that are parallel and follow each other, or else
        the second axis that turns, and the joint after them if it is parallel too.
        """
        _, axes, _ = self.at_zero()

        def parallel(i: int) -> bool:
            both = i in self._turning and i + 1 in self._turning
            return both and bool(np.linalg.norm(np.cross(axes[i], axes[i + 1])) < PARALLEL)

        first = next((i for i in range(len(axes) - 1) if parallel(i)), self._turning[1])
        third = first + 2 < len(axes) and parallel(first) and parallel(first + 1)
        return first, first + 2 if third else None

    def _shape(self, found: ChainPoses) -> NDArray[np.int8]:
        return np.asarray(self._signs(found.origins, found.axes) < -PARALLEL, dtype=np.int8)

    def _signs(self, origins: Floats, axes: Floats) -> Floats:
        """(n, SIGNS) numbers, each of which changes its sign where two branches meet."""
        out = np.zeros((len(origins), _SIGNS))
        turning = self._turning
        if len(turning) < _SIGNS:
            return out
        *_, c, b, a = turning
        out[:, 2] = _dot(np.cross(axes[:, c], axes[:, b]), axes[:, a])
        elbow, third = self._bend
        if third is not None:
            behind = origins[:, third]
        elif turning[-1] == elbow + 1:
            behind = origins[:, -1]
        else:
            behind = _nearest_point(origins[:, b], axes[:, b], origins[:, a], axes[:, a])
        upper, fore = origins[:, elbow + 1] - origins[:, elbow], behind - origins[:, elbow + 1]
        out[:, 1] = _dot(np.cross(upper, fore), axes[:, elbow]) / METRE**2
        first = turning[0]
        if elbow > first:
            wrist = _nearest_point(origins[:, b], axes[:, b], origins[:, a], axes[:, a])
            forward = np.cross(axes[:, elbow], axes[:, first])
            out[:, 0] = _dot(wrist - origins[:, first], forward) / METRE
        return out

    @cached_property
    def _library(self) -> tuple[Floats, Floats, Rows]:
        """Joints (m, a) inside the limits, what `_place` says of them, and their branches."""
        low = np.array([joint.low for joint in self.joints])
        high = np.array([joint.high for joint in self.joints])
        joints = np.random.default_rng(0).uniform(low, high, (STARTS[0], len(low)))
        found = self.chain.along(joints)
        branches = self.branch(self._shape(found).astype(np.intp))
        return joints, self._place(found.origins[:, -1], found.turns), branches

    def _place(self, positions: Floats, turns: Floats) -> Floats:
        """(n, 12) whose distances say how far poses (n, 3), (n, 3, 3) are apart."""
        return np.hstack([positions / max(self.reach, 1.0), 0.25 * turns.reshape(-1, 9)])

    def _starts(self, positions: Floats, quaternions: Floats, branch: int) -> Floats:
        """(n, k, a) joints of a branch whose poses are near to some."""
        joints, places, branches = self._library
        mine = np.flatnonzero(branches == branch)
        if not len(mine):
            return np.empty((len(positions), 0, len(self.joints)))
        many = min(STARTS[1], len(mine))
        theirs = places[mine]
        square = (theirs**2).sum(axis=1)
        out = np.empty((len(positions), many, len(self.joints)))
        for start in range(0, len(positions), 1024):
            rows = slice(start, start + 1024)
            turns = rotations.to_matrix(quaternions[rows])
            away = square - 2.0 * self._place(positions[rows], turns) @ theirs.T
            near = np.argpartition(away, many - 1, axis=1)[:, :many]
            order = np.take_along_axis(away, near, axis=1).argsort(axis=1)
            out[rows] = joints[mine[np.take_along_axis(near, order, axis=1)]]
        return out

    def _join(
        self,
        best: Floats,
        rank: Ints,
        poses: Floats,
        positions: Floats,
        quaternions: Floats,
        branch: int,
    ) -> None:
        """Looks beside the solutions of the rows before, then of those behind, where a row of a
        column has none, and where it is far from the one before: a branch may have several.
        """
        n = len(best)
        forward = [(row, row - 1) for row in range(1, n)]
        backward = [(row, row + 1) for row in range(n - 2, -1, -1)]
        for row, beside in forward + backward:
            has = rank[row] <= _Rank.OUTSIDE
            if rank[beside] > _Rank.OUTSIDE or (has and beside > row):
                continue
            if has and np.abs(self._wound(best[row] - best[beside])).max() < FAR:
                continue
            one = slice(row, row + 1)
            found = self._solved(poses[one], best[beside : beside + 1])
            if np.abs(self._wound(found[0] - best[row])).max() < _SAME:
                continue
            mine, fits = self._ranked(found, positions[one], quaternions[one])
            if mine[0] == branch and fits[0] <= min(rank[row], _Rank.OUTSIDE):
                best[row], rank[row] = found[0], fits[0]

    def _ranked(self, joints: Floats, positions: Floats, quaternions: Floats) -> tuple[Rows, Ints]:
        """(n,) branches of joints (n, a), and how good they are."""
        found = self.chain.along(joints)
        closes = _off(found, positions, quaternions) == 0.0
        spread = np.array([joint.high - joint.low for joint in self.joints])
        inside = (np.abs(self._wound(joints - self._middle)) <= spread / 2.0 + 1e-9).all(axis=1)
        ranks = np.where(closes, np.where(inside, _Rank.INSIDE, _Rank.OUTSIDE), _Rank.OPEN)
        return self.branch(self._shape(found).astype(np.intp)), ranks.astype(np.int64)

    def _wound(self, joints: Floats) -> Floats:
        """Differences (..., a) of joints, whole turns taken out."""
        turns = 2.0 * np.pi * np.round(joints / (2.0 * np.pi))
        return np.asarray(joints - np.where(self.sliding, 0.0, turns))

    @cached_property
    def _middle(self) -> Floats:
        return np.array([(joint.low + joint.high) / 2.0 for joint in self.joints])

    @cached_property
    def _transforms(self) -> Any:
        return self.chain.elementary()

    def _solved(self, poses: Floats, starts: Floats) -> Floats:
        """Solve poses (n, 4, 4) in metres numerically from starts (n, a).

        An axis that turns stays within half a turn of its start.
        """
        scale = np.where(self.sliding, 1.0 / METRE, 1.0)
        solve, found = self._transforms.ik_LM, np.empty_like(starts)
        for row, (pose, start) in enumerate(zip(poses, starts * scale, strict=True)):
            found[row] = solve(
                pose, q0=start, ilimit=STEPS, slimit=1, tol=_RESIDUAL, joint_limits=False
            ).q
        found = np.where(np.isfinite(found), found / scale, starts)
        return starts + self._wound(found - starts)


def _off(found: ChainPoses, positions: Floats, quaternions: Floats) -> Floats:
    """(n,) 0 where joints lead to the poses, else mm or, if more, degrees."""
    off = np.linalg.norm(found.origins[:, -1] - positions, axis=1)
    off = np.maximum(off, turn_between(rotations.from_matrix(found.turns), quaternions))
    return np.asarray(np.where(off < CLOSING / 2.0, 0.0, off))


def _dot(left: Floats, right: Floats) -> Floats:
    return np.asarray(np.einsum("ij,ij->i", left, right))


def _nearest_point(origin: Floats, axis: Floats, other: Floats, direction: Floats) -> Floats:
    """(n, 3) the points of lines that come nearest to other lines; any of parallel ones."""
    normal = np.cross(axis, direction)
    square = _dot(normal, normal)
    way = _dot(np.cross(other - origin, direction), normal) / np.where(square > 0.0, square, 1.0)
    return np.asarray(origin + np.where(square > PARALLEL, way, 0.0)[:, None] * axis)
