"""Where an outline may lie in a plane, by pairs of its points: a vote, which hidden parts survive.

Two points of a contour with their normals have three numbers that do not change when the contour is
moved: their distance and the angle of each normal to the line between them. A table tells which
pairs of a known outline have about these numbers; every pair that is seen votes for the places that
its first point may be on that outline, and a place with the direction of its normal is a pose
(Drost, Ulrich, Navab and Ilic, Model globally, match locally, 2010, here in two dimensions).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from assistant.base.arrays import Floats, Ints, evenly_spaced
from assistant.vision.recognition.edges import sample_outline
from assistant.vision.recognition.objects import Outline

PAIRED_POINTS: Final = 96
"""Of an outline that pairs are made of."""
VOTING_POINTS: Final = 28
"""Points of a seen contour that vote."""
PARTNER_POINTS: Final = 120
"""Points of a seen contour that they are paired with."""
DISTANCE_STEPS: Final = 24
"""Steps of distances up to the largest of an outline."""
ANGLE_STEPS: Final = 24
"""Steps of a full turn."""
MOST_CANDIDATES: Final = 4
"""Poses of an outline in a contour that are looked at closer."""
CONTOUR_FIT_ROUNDS: Final = 10
LEAST_NEAR_CONTOUR: Final = 0.3
"""Part of an outline that lies near to a contour where a pose that is voted for is worth more."""


@dataclass(frozen=True, slots=True)
class PlanePose:
    """A pose in a plane: a turn in radians about its normal, then a move in mm."""

    turn: float
    x: float
    y: float

    def moved(self, points: Floats) -> Floats:
        """Points (n, 2)."""
        return np.asarray(points @ self.matrix.T + [self.x, self.y])

    @property
    def matrix(self) -> Floats:
        c, s = np.cos(self.turn), np.sin(self.turn)
        return np.array([[c, -s], [s, c]])


@dataclass(frozen=True, slots=True, eq=False)
class Contour:
    """A seen contour: points (n, 2) mm in a plane, normals (n, 2) out of what it is about."""

    points: Floats
    normals: Floats


def sample_contour(rings: tuple[Floats, ...], count: int = PARTNER_POINTS) -> Contour:
    """Points evenly spaced on closed rings (n, 2), material to their left."""
    lengths = [np.linalg.norm(np.roll(r, -1, axis=0) - r, axis=1) for r in rings]
    total = sum(float(one.sum()) for one in lengths)
    points, normals = list[Floats](), list[Floats]()
    for ring, sides in zip(rings, lengths, strict=True):
        ends = np.concatenate([[0.0], np.cumsum(sides)])
        here = max(6, round(count * ends[-1] / total))
        at = np.arange(here) * ends[-1] / here
        closed = np.vstack([ring, ring[:1]])
        reach = ends[-1] / here
        place = _points_along(closed, ends, at)
        ahead = _points_along(closed, ends, at + reach) - _points_along(closed, ends, at - reach)
        ahead /= np.maximum(np.linalg.norm(ahead, axis=1, keepdims=True), 1e-12)
        points.append(place)
        normals.append(np.column_stack([ahead[:, 1], -ahead[:, 0]]))
    return Contour(np.concatenate(points), np.concatenate(normals))


def _points_along(closed: Floats, ends: Floats, at: Floats) -> Floats:
    at = np.mod(at, ends[-1])
    return np.column_stack([np.interp(at, ends, closed[:, 0]), np.interp(at, ends, closed[:, 1])])


@dataclass(frozen=True, slots=True, eq=False)
class PairTable:
    """The table of an outline. firsts: of each cell in turn the first points of its pairs, from
    starts[cell] on, counts[cell] of them.
    """

    contour: Contour
    largest: float
    firsts: Ints
    starts: Ints
    counts: Ints

    @staticmethod
    def of(outline: Outline) -> PairTable:
        perimeter = sum(
            float(np.linalg.norm(np.roll(r, -1, axis=0) - r, axis=1).sum()) for r in outline.rings
        )
        samples = sample_outline(outline, perimeter / PAIRED_POINTS)
        contour = Contour(samples.points[:, :2], samples.normals[:, :2])
        count = len(contour.points)
        gaps = np.linalg.norm(contour.points[:, None] - contour.points[None], axis=2)
        largest = float(gaps.max()) * 1.0001
        first, second = np.nonzero(gaps > 0.04 * largest)
        cells, _ = _table_cells(contour, contour, first, second, largest)
        order = np.argsort(cells, kind="stable")
        counts = np.bincount(cells, minlength=DISTANCE_STEPS * ANGLE_STEPS * ANGLE_STEPS)
        assert count
        starts = np.concatenate([[0], np.cumsum(counts)[:-1]])
        return PairTable(contour, largest, first[order], starts, counts)

    def poses(self, seen: Contour, kept: int = MOST_CANDIDATES) -> list[PlanePose]:
        """Poses that the most pairs of a seen contour vote for, the best first."""
        count = len(seen.points)
        firsts = evenly_spaced(count, VOTING_POINTS)
        one, other = (a.ravel() for a in np.meshgrid(firsts, np.arange(count), indexing="ij"))
        gap = np.linalg.norm(seen.points[one] - seen.points[other], axis=1)
        near = (gap > 0.04 * self.largest) & (gap < self.largest)
        one, other = one[near], other[near]
        if not len(one):
            return []
        cells, inside = _table_cells(seen, seen, one, other, self.largest)
        cells, one = cells[inside], one[inside]
        many = self.counts[cells]
        rows = np.repeat(np.arange(len(cells)), many)
        within = np.arange(len(rows)) - np.repeat(np.cumsum(many) - many, many)
        voted = self.firsts[self.starts[cells][rows] + within]
        model = len(self.contour.points)
        votes = np.bincount(one[rows] * model + voted, minlength=count * model)
        return self._best(seen, votes.reshape(count, model), kept)

    def _best(self, seen: Contour, votes: Ints, kept: int) -> list[PlanePose]:
        """The poses with most votes, those that are nearly the same counted together."""
        flat = votes.ravel()
        most = np.argpartition(flat, -min(12 * kept, len(flat)))[-12 * kept :]
        most = most[np.argsort(flat[most])[::-1]]
        at, on = np.unravel_index(most, votes.shape)
        weight = votes.ravel()[most].astype(np.float64)
        angles = np.arctan2(*seen.normals[at].T[::-1]) - np.arctan2(
            *self.contour.normals[on].T[::-1]
        )
        c, s = np.cos(angles), np.sin(angles)
        p = self.contour.points[on]
        place = seen.points[at] - np.column_stack(
            [c * p[:, 0] - s * p[:, 1], s * p[:, 0] + c * p[:, 1]]
        )
        middle = self.contour.points.mean(axis=0)
        centre = place + np.column_stack(
            [c * middle[0] - s * middle[1], s * middle[0] + c * middle[1]]
        )
        found: list[tuple[float, PlanePose]] = []
        left = weight > 0.0
        while left.any() and len(found) < kept:
            best = int(np.argmax(np.where(left, weight, -1.0)))
            turn = np.abs(np.angle(np.exp(1j * (angles - angles[best]))))
            gap = np.linalg.norm(centre - centre[best], axis=1)
            same = left & (turn < 0.25) & (gap < 0.08 * self.largest)
            total = float(weight[same].sum())
            found.append((total, PlanePose(float(angles[best]), *map(float, place[best]))))
            left &= ~same
        return [pose for _, pose in sorted(found, key=lambda one: -one[0])]

    def settled(self, seen: Contour, pose: PlanePose) -> tuple[PlanePose, float]:
        """A pose brought onto the seen contour, and the part of the outline that lies on it.

        Nearest points whose normals agree, those farther than a shrinking gap left out
        (iterated closest points, trimmed).
        """
        gap, share = 0.1 * self.largest, 0.0
        middle = self.contour.points.mean(axis=0)
        squares = (seen.points**2).sum(axis=1)
        for number in range(CONTOUR_FIT_ROUNDS):
            some = slice(None, None, 1 if number >= CONTOUR_FIT_ROUNDS - 3 else 3)
            points = pose.moved(self.contour.points[some])
            normals = self.contour.normals[some] @ pose.matrix.T
            away = squares - 2.0 * points @ seen.points.T + (points**2).sum(axis=1)[:, None]
            away[normals @ seen.normals.T < 0.8] = np.inf
            near = away.argmin(axis=1)
            good = away[np.arange(len(near)), near] < gap**2
            share = float(good.mean())
            if good.sum() < 8 or (share < LEAST_NEAR_CONTOUR and number == 0):
                return pose, 0.0
            # Distances along the normals of what is seen: points slide along edges freely.
            across = seen.normals[near[good]]
            arm = points[good] - pose.moved(middle[None])[0]
            off = ((points[good] - seen.points[near[good]]) * across).sum(axis=1)
            by_turn = across[:, 1] * arm[:, 0] - across[:, 0] * arm[:, 1]
            rows = np.column_stack([across, by_turn])
            damped = rows.T @ rows + np.diag([1e-6, 1e-6, 1e-6 * self.largest**2]) * len(rows)
            step = -np.linalg.solve(damped, rows.T @ off)
            pose = _turned_pose(pose, middle, step)
            gap = max(gap * 0.75, 0.02 * self.largest)
        return pose, share


def _turned_pose(pose: PlanePose, middle: Floats, step: Floats) -> PlanePose:
    """Turned about where the middle is, and moved."""
    centre = pose.moved(middle[None])[0] + step[:2]
    turned = PlanePose(pose.turn + float(step[2]), 0.0, 0.0)
    x, y = centre - turned.moved(middle[None])[0]
    return PlanePose(turned.turn, float(x), float(y))


def _table_cells(
    one: Contour, other: Contour, first: Ints, second: Ints, largest: float
) -> tuple[Ints, Floats]:
    """Cells of pairs, and which of them lie within the table."""
    line = other.points[second] - one.points[first]
    gap = np.linalg.norm(line, axis=1)
    heading = np.arctan2(line[:, 1], line[:, 0])
    step = (gap / largest * DISTANCE_STEPS).astype(np.int64)
    cells = step
    for normals in (one.normals[first], other.normals[second]):
        angle = np.arctan2(normals[:, 1], normals[:, 0]) - heading
        part = np.mod(np.rint(angle / (2.0 * np.pi) * ANGLE_STEPS), ANGLE_STEPS).astype(np.int64)
        cells = cells * ANGLE_STEPS + part
    return np.where(step < DISTANCE_STEPS, cells, 0), step < DISTANCE_STEPS
