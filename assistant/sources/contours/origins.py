"""What the sides of an offset polygon came from: pieces of the contour, and its joints."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from assistant.sources.contours.curves import Arc
from assistant.sources.contours.flat import Piece, Plane, tangent

MOST_COMPARED: Final = 1 << 20
"""Sides times pieces that are looked at at once; bounds memory."""
SAME: Final = 1e-6
"""mm between two points that are one."""

Numbers = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Source:
    """The pieces in columns. Labels: piece i is i, the joint before it count + i; of an open
    contour count is its start and 2 count its end.
    """

    pieces: tuple[Piece, ...]
    closed: bool
    arcs: NDArray[np.bool_]
    start: Numbers
    end: Numbers
    centre: Numbers
    radius: Numbers
    first: Numbers
    sweep: Numbers
    about: Numbers

    @staticmethod
    def of(pieces: Sequence[Piece], *, closed: bool) -> Source:
        given = tuple(pieces)
        arcs = [piece if isinstance(piece, Arc) else None for piece in given]
        start = np.array([piece.start[:2] for piece in given])
        centre = np.array([arc.centre[:2] if arc else (0.0, 0.0) for arc in arcs])
        arm = start - centre
        return Source(
            given,
            closed,
            np.array([arc is not None for arc in arcs]),
            start,
            np.array([piece.end[:2] for piece in given]),
            centre,
            np.array([arc.radius if arc else 0.0 for arc in arcs]),
            np.arctan2(arm[:, 1], arm[:, 0]),
            np.array([math.radians(arc.sweep) if arc else 0.0 for arc in arcs]),
            np.array([math.copysign(1.0, arc.normal[2]) if arc else 0.0 for arc in arcs]),
        )

    @property
    def count(self) -> int:
        return len(self.pieces)

    def nearest(self, points: Plane) -> tuple[NDArray[np.intp], Numbers]:
        """For each point (m, 2) the label of what is nearest, and on which side: over 0 left."""
        together = max(1, MOST_COMPARED // self.count)
        parts = [self._nearest(points[i : i + together]) for i in range(0, len(points), together)]
        labels, sides = zip(*parts, strict=True)
        return np.concatenate(labels), np.concatenate(sides)

    def _nearest(self, points: Plane) -> tuple[NDArray[np.intp], Numbers]:
        p = points[:, None]
        way = self.end - self.start
        size = np.maximum((way**2).sum(axis=1), 1e-300)
        share = ((p - self.start) * way).sum(axis=2) / size
        foot = self.start + np.clip(share, 0.0, 1.0)[..., None] * way
        beside_line = np.linalg.norm(p - foot, axis=2)
        arm = p - self.centre
        far = np.linalg.norm(arm, axis=2)
        turned = (np.arctan2(arm[..., 1], arm[..., 0]) - self.first) * self.about % math.tau
        within = turned <= self.sweep
        to_start = np.linalg.norm(p - self.start, axis=2)
        to_end = np.linalg.norm(p - self.end, axis=2)
        beside_arc = np.where(within, np.abs(far - self.radius), np.minimum(to_start, to_end))
        distance = np.where(self.arcs, beside_arc, beside_line)
        row, chosen = np.arange(len(points)), distance.argmin(axis=1)
        arc = self.arcs[chosen]
        inside = np.where(
            arc, within[row, chosen], (share[row, chosen] > 0.0) & (share[row, chosen] < 1.0)
        )
        late = np.where(arc, to_end[row, chosen] < to_start[row, chosen], share[row, chosen] >= 1.0)
        joint = chosen + late
        if self.closed:
            joint = joint % self.count
        labels = np.where(inside, chosen, self.count + joint)
        line_side = cross_of(way[chosen], points - self.start[chosen])
        arc_side = (self.radius[chosen] - far[row, chosen]) * self.about[chosen]
        sides = np.where(arc, arc_side, line_side)
        for i in np.flatnonzero(~inside).tolist():
            sides[i] = self._side_of_joint(int(joint[i]), points[i])
        return labels.astype(np.intp), sides

    def _side_of_joint(self, joint: int, point: Plane) -> float:
        at_end = joint >= self.count
        corner = self.end[-1] if at_end else self.start[joint]
        return float(cross_of(self._along_joint(joint), point - corner))

    def runs_back(self, ends: Plane, labels: NDArray[np.intp]) -> bool:
        """Whether the longest side between ends (m + 1, 2) runs against what it is beside."""
        ways = np.diff(ends, axis=0)
        sizes = np.linalg.norm(ways, axis=1) * (1.0 + (labels < self.count) * ends.size)
        k = int(sizes.argmax())
        label, middle = int(labels[k]), 0.5 * (ends[k] + ends[k + 1])
        if label >= self.count:
            along = self._along_joint(label - self.count)
        elif self.arcs[label]:
            x, y = (middle - self.centre[label]) * self.about[label]
            along = np.array([-y, x])
        else:
            along = self.end[label] - self.start[label]
        return float(ways[k] @ along) < 0.0

    def _along_joint(self, joint: int) -> Plane:
        """The direction of a contour at a joint, the mean of both sides."""
        along = np.zeros(2)
        if joint or self.closed:
            along = along + tangent(self.pieces[joint - 1], 1.0)
        if joint < self.count:
            along = along + tangent(self.pieces[joint], 0.0)
        return along

    def curve(self, label: int, offset: float, near: Plane) -> Curve:
        """What runs at the offset beside a piece or around a joint, past a point."""
        if label >= self.count:
            joint = label - self.count
            corner = self.end[-1] if joint >= self.count else self.start[joint]
            return Curve(corner, None, offset)
        if self.arcs[label]:
            centre, radius = self.centre[label], float(self.radius[label])
            far = float(np.linalg.norm(near - centre))
            sizes = (radius + offset, abs(radius - offset))
            return Curve(centre, None, min(sizes, key=lambda size: abs(size - far)))
        way = self.end[label] - self.start[label]
        along = way / np.linalg.norm(way)
        across = np.array([-along[1], along[0]])
        side = math.copysign(1.0, float((near - self.start[label]) @ across))
        return Curve(self.start[label] + side * offset * across, along, 0.0)


@dataclass(frozen=True, slots=True)
class Curve:
    """A line through a point along a unit direction, or a circle about it if that is None."""

    point: Plane
    along: Plane | None
    radius: float

    def nearest(self, p: Plane) -> Plane:
        if self.along is not None:
            return np.asarray(self.point + ((p - self.point) @ self.along) * self.along)
        arm = p - self.point
        size = float(np.linalg.norm(arm))
        return np.asarray(self.point + arm * (self.radius / size)) if size > 0.0 else p

    def meets(self, other: Curve, near: Plane) -> Plane | None:
        """Where they cross or touch, the place that is nearest to a point."""
        if self.along is None and other.along is not None:
            return other.meets(self, near)
        if self.along is not None and other.along is not None:
            sine = float(cross_of(self.along, other.along))
            if abs(sine) < 1e-9:
                return None
            part = float(cross_of(other.point - self.point, other.along)) / sine
            return np.asarray(self.point + part * self.along)
        if self.along is not None:
            foot, along = self.nearest(other.point), self.along
            rest = other.radius**2 - float(((foot - other.point) ** 2).sum())
        else:
            between = other.point - self.point
            apart = float(np.linalg.norm(between))
            if apart < SAME:
                return None
            part = (apart**2 + self.radius**2 - other.radius**2) / (2.0 * apart)
            foot = self.point + part * between / apart
            along = np.array([-between[1], between[0]]) / apart
            rest = self.radius**2 - part**2
        half = math.sqrt(max(rest, 0.0))
        both = (foot + half * along, foot - half * along)
        return min(both, key=lambda p: float(((p - near) ** 2).sum()))


def cross_of(a: Plane, b: Plane) -> Any:
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
