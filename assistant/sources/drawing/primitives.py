"""Straight pieces, conics and splines: what entities are made of, closed under any transform.

An affine map of a conic given by two conjugate radii is again such a conic, and of a spline
the spline of the moved control points. So nested, mirrored and unevenly scaled inserts need
no cases of their own; only at the end it shows whether a conic is a circle.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from assistant.base.arrays import Floats
from assistant.sources.contours.curves import (
    Arc,
    Curve,
    FreeCurve,
    Line,
    Points,
    cross_product,
    dot_product,
    vector,
)
from assistant.sources.drawing.transforms import direction, point

ROUND_TOLERANCE: Final = 1e-9
"""Relative difference of two conjugate radii, and cosine between them, of a circle."""

FARTHEST_COORDINATE: Final = 1e7
"""mm; a coordinate beyond 10 km is no work piece but a broken file."""

FLATTEST_ARC: Final = 1e-4
"""mm; an arc that leaves its chord by less is a line, where its centre is no place."""

SHORTEST_CURVE: Final = 1e-9
"""mm; what is shorter has no direction."""


class Degenerate(ValueError):
    """A curve without length or without a plane."""


@dataclass(frozen=True, slots=True, eq=False)
class Straight:
    """From start to end, (3,) each."""

    start: Floats
    end: Floats

    def moved(self, matrix: Floats) -> Straight:
        return Straight(point(matrix, self.start), point(matrix, self.end))

    def curve(self, layer: str, handle: str) -> Curve:
        check_coordinates(self.start, self.end)
        if np.linalg.norm(self.end - self.start) <= SHORTEST_CURVE:
            raise Degenerate("without length")
        return Line(vector(self.start), vector(self.end), layer, handle)


@dataclass(frozen=True, slots=True, eq=False)
class Conic:
    """centre + u·cos t + v·sin t for t from 0 to `sweep` radians, a whole ellipse at 2π."""

    centre: Floats
    u: Floats
    v: Floats
    sweep: float

    @staticmethod
    def part(centre: Floats, u: Floats, v: Floats, first: float, sweep: float) -> Conic:
        """The part that begins at parameter `first` (radians)."""
        c, s = math.cos(first), math.sin(first)
        return Conic(centre, c * u + s * v, c * v - s * u, sweep)

    @property
    def whole(self) -> bool:
        return self.sweep == math.tau

    def moved(self, matrix: Floats) -> Conic:
        u, v = direction(matrix, np.stack([self.u, self.v]))
        return Conic(point(matrix, self.centre), u, v, self.sweep)

    def curve(self, layer: str, handle: str) -> Curve:
        radius = max(math.hypot(*vector(self.u)), math.hypot(*vector(self.v)))
        if (
            radius >= FARTHEST_COORDINATE
            and 2.0 * radius * math.sin(self.sweep / 4.0) ** 2 <= FLATTEST_ARC
        ):
            start, end = self._evaluate(np.array([0.0, 1.0]))
            return Straight(start, end).curve(layer, handle)
        check_coordinates(self.centre, self.u, self.v)
        # Plain numbers: a drawing may have thousands of these, of three numbers each.
        centre, u, v = vector(self.centre), vector(self.u), vector(self.v)
        normal = cross_product(u, v)
        sizes = math.hypot(*u), math.hypot(*v)
        flat = math.hypot(*normal) <= ROUND_TOLERANCE * max(sizes) ** 2
        if flat or self.sweep * max(sizes) <= SHORTEST_CURVE:
            raise Degenerate("without length or area")
        even = abs(sizes[0] - sizes[1]) <= ROUND_TOLERANCE * max(sizes)
        if even and abs(dot_product(u, v)) <= ROUND_TOLERANCE * max(sizes) ** 2:
            sweep = 360.0 if self.whole else math.degrees(self.sweep)
            start = (centre[0] + u[0], centre[1] + u[1], centre[2] + u[2])
            return Arc.about(centre, normal, start, sweep, layer, handle)
        return FreeCurve(self._evaluate, self.whole, layer, handle)

    def _evaluate(self, parameters: Floats) -> Points:
        t = (parameters * self.sweep)[:, None]
        return np.asarray(self.centre + np.cos(t) * self.u + np.sin(t) * self.v)


@dataclass(frozen=True, slots=True, eq=False)
class Spline:
    """A rational B-spline.

    knots (n + degree + 1,) ascending, points (n, 3), weights (n,) positive.
    """

    degree: int
    knots: Floats
    points: Floats
    weights: Floats

    def moved(self, matrix: Floats) -> Spline:
        return replace(self, points=point(matrix, self.points))

    def curve(self, layer: str, handle: str) -> Curve:
        check_coordinates(self.points)
        if np.linalg.norm(np.ptp(self.points, axis=0)) <= SHORTEST_CURVE:
            raise Degenerate("without length")
        low, high = self._domain
        inner = np.unique(self.knots[(self.knots > low) & (self.knots < high)])
        breaks = (0.0, *(float(b) for b in (inner - low) / (high - low)), 1.0)
        ends = self._evaluate(np.array([0.0, 1.0]))
        closed = bool(np.linalg.norm(ends[1] - ends[0]) <= SHORTEST_CURVE)
        return FreeCurve(self._evaluate, closed, layer, handle, breaks)

    def continuous(self) -> Iterator[Spline]:
        """The parts between knots at which the curve may jump: those that are there more often
        than its degree. Each part has its own ends.
        """
        p, n = self.degree, len(self.points)
        first = 0
        values, places, counts = np.unique(self.knots, return_index=True, return_counts=True)
        low, high = self._domain
        for value, place, count in zip(values, places.tolist(), counts.tolist(), strict=True):
            if low < value < high and count > p:
                yield self._part(first, place)
                first = place + count - p - 1
        yield self if first == 0 else self._part(first, n)

    def _part(self, first: int, last: int) -> Spline:
        """The part of a spline from one control point up to another."""
        return replace(
            self,
            knots=self.knots[first : last + self.degree + 1],
            points=self.points[first:last],
            weights=self.weights[first:last],
        )

    @property
    def _domain(self) -> tuple[float, float]:
        return float(self.knots[self.degree]), float(self.knots[len(self.points)])

    def _evaluate(self, parameters: Floats) -> Points:
        """De Boor's algorithm in homogeneous coordinates, all parameters at once."""
        p, n, knots = self.degree, len(self.points), self.knots
        low, high = self._domain
        x = np.clip(low + parameters * (high - low), low, high)
        last = int(np.searchsorted(knots, high, side="left")) - 1  # its span holds the end
        span = np.clip(np.searchsorted(knots, x, side="right") - 1, p, min(last, n - 1))
        homogeneous = np.column_stack([self.points * self.weights[:, None], self.weights])
        d = homogeneous[span[:, None] + np.arange(-p, 1)]
        for r in range(1, p + 1):
            for j in range(p, r - 1, -1):
                i = span - p + j
                width = knots[i + p - r + 1] - knots[i]
                share = np.divide(x - knots[i], width, out=np.zeros_like(x), where=width > 0)
                d[:, j] = d[:, j - 1] + share[:, None] * (d[:, j] - d[:, j - 1])
        return np.asarray(d[:, p, :3] / d[:, p, 3:])


Primitive = Straight | Conic | Spline


def check_coordinates(*places: Floats) -> None:
    """Raises ValueError for a coordinate that is not finite, or is no place for a robot."""
    if not (np.abs(np.concatenate(places)) < FARTHEST_COORDINATE).all():  # NaN fails as well
        raise ValueError(f"a coordinate is not finite or beyond {FARTHEST_COORDINATE:g} mm")
