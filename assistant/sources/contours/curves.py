"""Curves of a drawing: lines, circular arcs, and free curves; mm, with layer and handle.

Every curve runs from `start` to `end` over a parameter from 0 to 1, answers `at(parameters)` with
points, knows its `length`, and can be `reversed()`.

A `Piece` is a line or an arc in the view along the tool: only its x and y count for areas,
directions and chords; z is its height against the tool.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import field, replace
from operator import attrgetter
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from assistant.base.data_classes import dataclass
from assistant.program.geometry import Vector

Points = NDArray[np.float64]
"""Points or vectors, (m, 3) mm."""

Evaluate = Callable[[NDArray[np.float64]], Points]
"""Parameters (m,) from 0 to 1 → points (m, 3) mm."""

_LENGTH_CHORDS: Final = 64
"""Chords a piece of a free curve is measured by; ample for sorting out empty ones."""


_MOST_CHORDS: Final = 20_000
_FEWEST_CHORDS: Final = 16
_MOST_HALVINGS: Final = 20
_CHORD_PARTS: Final = np.array([0.23, 0.52, 0.79])
"""Positions in a chord at which a free curve is sampled: uneven, as many curves repeat."""


@dataclass(frozen=True, slots=True)
class Line:
    """A straight segment."""

    start: Vector
    end: Vector
    layer: str = ""
    handle: str = ""

    @property
    def closed(self) -> bool:
        return False

    @property
    def length(self) -> float:
        return math.dist(self.start, self.end)

    def at(self, parameters: ArrayLike) -> Points:
        t = np.asarray(parameters, dtype=np.float64).reshape(-1, 1)
        return np.asarray((1.0 - t) * np.asarray(self.start) + t * np.asarray(self.end))

    def reversed(self) -> Line:
        return replace(self, start=self.end, end=self.start)


@dataclass(frozen=True, slots=True)
class Arc:
    """A circular arc, counter-clockwise about its unit `normal` through the middle `via`.

    A full circle is closed: start and end are one point and via is opposite.
    """

    start: Vector
    via: Vector
    end: Vector
    centre: Vector
    radius: float
    normal: Vector
    closed: bool = False
    layer: str = ""
    handle: str = ""
    _sweep: float | None = field(default=None, init=False, repr=False, compare=False)

    @staticmethod
    def about(
        centre: ArrayLike,
        normal: ArrayLike,
        start: ArrayLike,
        sweep: float,
        layer: str = "",
        handle: str = "",
    ) -> Arc:
        """From a start point over `sweep` degrees (0 to 360, right-handed) about the normal.

        start is taken as it is, so it has to lie in the plane of the circle. A negative
        sweep turns the normal over; 360 degrees make a closed circle.
        """
        c, s, along = vector(centre), vector(start), vector(normal)
        size = math.copysign(math.hypot(*along), sweep)
        # The sign of the sweep turns the normal over.
        n = (along[0] / size, along[1] / size, along[2] / size)
        arm = _difference(s, c)
        turn = min(abs(sweep), 360.0)
        closed = turn == 360.0
        via = _turned_by(c, n, arm, 0.5 * turn)
        end = s if closed else _turned_by(c, n, arm, turn)
        return Arc(s, via, end, c, math.hypot(*arm), vector(n), closed, layer, handle)

    @staticmethod
    def through(
        start: ArrayLike, via: ArrayLike, end: ArrayLike, layer: str = "", handle: str = ""
    ) -> Arc | None:
        """The arc from start through any point via to end; None for points on one line.

        The result's via is the middle of the arc.
        """
        a, c = vector(start), vector(end)
        circle = circle_through(a, vector(via), c)
        if circle is None:
            return None
        centre, normal = circle
        # The middle as via determines the circle best; the given one may be near an end.
        half = math.radians(0.5 * _sweep_between(centre, normal, a, c))
        arm = _difference(a, centre)
        ahead = cross_product(normal, arm)
        cos, sin = math.cos(half), math.sin(half)
        x, y, z = (m + cos * u + sin * v for m, u, v in zip(centre, arm, ahead, strict=True))
        radius = math.hypot(*arm)
        return Arc(a, (x, y, z), c, centre, radius, normal, False, layer, handle)

    @property
    def sweep(self) -> float:
        """Degrees from start to end about the normal, over 0 to 360."""
        if self.closed:
            return 360.0
        # Twice the way to via: exact where start and end are nearly one point.
        if self._sweep is None:
            half = _sweep_between(self.centre, self.normal, self.start, self.via)
            # The class is frozen; this field is a cache.
            object.__setattr__(self, "_sweep", 2.0 * half)
            return 2.0 * half
        return self._sweep

    @property
    def length(self) -> float:
        return math.radians(self.sweep) * self.radius

    def at(self, parameters: ArrayLike) -> Points:
        t = np.asarray(parameters, dtype=np.float64).reshape(-1)
        centre, normal = np.asarray(self.centre), np.asarray(self.normal)
        return _turned_about(centre, normal, np.asarray(self.start), t * self.sweep)

    def reversed(self) -> Arc:
        x, y, z = self.normal
        return replace(self, start=self.end, end=self.start, normal=(-x, -y, -z))


@dataclass(frozen=True, slots=True)
class FreeCurve:
    """Any other curve: ellipse, spline.

    evaluate: parameters (m,) in [0, 1] to points (m, 3) mm, continuous.
    breaks: parameters, ascending from 0 to 1, between which the curve is smooth; a corner
    always stands at one of them, and a change of polynomial (a spline's knot) may.
    """

    evaluate: Evaluate
    closed: bool = False
    layer: str = ""
    handle: str = ""
    breaks: tuple[float, ...] = (0.0, 1.0)

    @property
    def start(self) -> Vector:
        return vector(self.at([0.0])[0])

    @property
    def end(self) -> Vector:
        return self.start if self.closed else vector(self.at([1.0])[0])

    @property
    def length(self) -> float:
        """Sum of chords, which is a little short of the true length."""
        pieces = [
            np.linspace(a, b, _LENGTH_CHORDS, endpoint=False)
            for a, b in zip(self.breaks, self.breaks[1:], strict=False)
        ]
        points = self.at(np.concatenate([*pieces, [1.0]]))
        return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())

    def at(self, parameters: ArrayLike) -> Points:
        t = np.asarray(parameters, dtype=np.float64).reshape(-1)
        return np.asarray(self.evaluate(t), dtype=np.float64).reshape(-1, 3)

    def reversed(self) -> FreeCurve:
        forward = self.evaluate
        return replace(
            self,
            evaluate=lambda t: forward(1.0 - t),
            breaks=tuple(1.0 - b for b in reversed(self.breaks)),
        )


Curve = Line | Arc | FreeCurve


def sample(curves: Sequence[Curve], parameters: ArrayLike) -> Points:
    """Points at the parameters (m,) of every curve, (n, m, 3); lines and arcs in columns."""
    t = np.asarray(parameters, dtype=np.float64).reshape(-1)
    points = np.empty((len(curves), len(t), 3))
    lines = [i for i, c in enumerate(curves) if isinstance(c, Line)]
    arcs = [(i, c) for i, c in enumerate(curves) if isinstance(c, Arc)]
    if lines:
        starts = np.array([curves[i].start for i in lines])[:, None]
        ends = np.array([curves[i].end for i in lines])[:, None]
        points[lines] = (1.0 - t[:, None]) * starts + t[:, None] * ends
    if arcs:
        start, centre, normal = (
            np.array([getattr(c, name) for _, c in arcs])[:, None]
            for name in ("start", "centre", "normal")
        )
        degrees = arc_sweeps([c for _, c in arcs])[:, None] * t
        points[[i for i, _ in arcs]] = _turned_about(centre, normal, start, degrees)
    for i, curve in enumerate(curves):
        if isinstance(curve, FreeCurve):
            points[i] = curve.at(t)
    return points


def chorded(curve: Curve, off: float, most: int = _MOST_CHORDS) -> Points:
    """Points (m, 3) along a curve whose chords are at most `off` mm off, not many more than
    `most` of them. A free curve is divided until its inner points are that near to their chords.
    """
    if isinstance(curve, Line):
        return np.array([curve.start, curve.end])
    if isinstance(curve, Arc):
        # At least three chords for a circle, however coarse the tolerance is.
        step = 2.0 * math.acos(max(1.0 - off / curve.radius, 0.5)) if curve.radius > 0 else 1.0
        count = min(max(math.ceil(math.radians(curve.sweep) / step), 4), most)
        return curve.at(np.linspace(0.0, 1.0, count + 1))
    breaks = np.asarray(curve.breaks)
    # Each smooth part begins with some chords, so that no wave between two ends is overlooked.
    each = max(2, math.ceil(_FEWEST_CHORDS / (len(breaks) - 1)))
    parts = breaks[:-1, None] + np.diff(breaks)[:, None] * np.arange(each) / each
    marks = np.append(parts.ravel(), breaks[-1])
    for _ in range(_MOST_HALVINGS):
        inner = marks[:-1, None] + np.diff(marks)[:, None] * _CHORD_PARTS
        points, ends = curve.at(inner).reshape(len(inner), -1, 3), curve.at(marks)
        way = np.diff(ends, axis=0)
        size = np.maximum((way**2).sum(axis=1), 1e-300)
        arm = points - ends[:-1, None]
        share = np.clip(np.einsum("kmc,kc->km", arm, way) / size[:, None], 0.0, 1.0)
        away = np.linalg.norm(arm - share[..., None] * way[:, None], axis=2).max(axis=1)
        wide = away > off
        if not wide.any() or len(marks) > most:
            break
        marks = np.sort(np.append(marks, 0.5 * (marks[:-1] + marks[1:])[wide]))
    return curve.at(marks)


def cross(a: Points, b: Points) -> Points:
    """Cross products over the last axis; for few vectors several times as fast as numpy's."""
    ax, ay, az = a[..., 0], a[..., 1], a[..., 2]
    bx, by, bz = b[..., 0], b[..., 1], b[..., 2]
    return np.stack([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx], axis=-1)


def vector(point: ArrayLike) -> Vector:
    """A point as a tuple of three floats, without negative zeros."""
    x, y, z = point if isinstance(point, tuple) else np.asarray(point, dtype=np.float64).tolist()
    return (float(x) + 0.0, float(y) + 0.0, float(z) + 0.0)


def circle_through(a: Vector, b: Vector, c: Vector) -> tuple[Vector, Vector] | None:
    """Centre and unit normal of the circle a → b → c; None if they are on one line.

    Circumcentre from the two edge vectors u, v at a:
    ((|u|² v - |v|² u) × (u × v)) / (2 |u × v|²).
    """
    u, v = _difference(b, a), _difference(c, a)
    w = cross_product(u, v)
    square, uu, vv = dot_product(w, w), dot_product(u, u), dot_product(v, v)
    # Relative to the longer edge: the points are on one line but for rounding.
    if square <= 1e-20 * max(uu, vv) ** 2:
        return None
    x, y, z = cross_product(_difference(_scaled(uu, v), _scaled(vv, u)), w)
    size, length = 0.5 / square, math.sqrt(square)
    centre = (a[0] + size * x, a[1] + size * y, a[2] + size * z)
    return centre, (w[0] / length, w[1] / length, w[2] / length)


def _sweep_between(centre: Vector, normal: Vector, first: Vector, second: Vector) -> float:
    """Degrees from first to second about a unit normal, in [0, 360)."""
    u, v = _difference(first, centre), _difference(second, centre)
    angle = math.degrees(math.atan2(dot_product(cross_product(u, v), normal), dot_product(u, v)))
    # Rounding just below 0 must not give 360.
    return angle if angle >= 0.0 else (angle + 360.0) % 360.0


def _difference(a: Vector, b: Vector) -> Vector:
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def _scaled(size: float, a: Vector) -> Vector:
    return (size * a[0], size * a[1], size * a[2])


def dot_product(a: Vector, b: Vector) -> float:
    """The scalar product, in plain numbers."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross_product(a: Vector, b: Vector) -> Vector:
    """The vector product, in plain numbers; `cross` multiplies columns."""
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


def _turned_about(centre: Points, normal: Points, start: Points, degrees: Points) -> Points:
    """`start` turned about the axis through centre by each of the degrees (..., m): (..., m, 3).

    Rodrigues' formula.
    """
    arm = start - centre
    angle = np.radians(degrees)[..., None]
    along = (arm * normal).sum(axis=-1, keepdims=True) * normal
    across = (arm - along) * np.cos(angle) + cross(normal, arm) * np.sin(angle)
    return np.asarray(centre + along + across)


def _turned_by(centre: Vector, normal: Vector, arm: Vector, degrees: float) -> Vector:
    """`turned` of one point, which is `arm` away from the centre."""
    angle = math.radians(degrees)
    cos, sin = math.cos(angle), math.sin(angle)
    lift = dot_product(arm, normal)
    along = _scaled(lift, normal)
    x, y, z = (
        c + a + (r - a) * cos + s * sin
        for c, a, r, s in zip(centre, along, arm, cross_product(normal, arm), strict=True)
    )
    return (x + 0.0, y + 0.0, z + 0.0)


def points_at_parts(curves: Sequence[Line | Arc], rows: NDArray[np.intp], parts: Points) -> Points:
    """Points (m, 3) at parts (m,) of lines and arcs, each of the curve of its row (m,)."""
    start, end = (np.array(list(map(attrgetter(name), curves))) for name in ("start", "end"))
    share = parts[:, None]
    points = (1.0 - share) * start[rows] + share * end[rows]
    arcs = [curve for curve in curves if isinstance(curve, Arc)]
    if arcs:
        is_arc = np.array([isinstance(curve, Arc) for curve in curves])
        on = is_arc[rows]
        which = (np.cumsum(is_arc) - 1)[rows[on]]
        centre, normal = (
            np.array(list(map(attrgetter(name), arcs))) for name in ("centre", "normal")
        )
        degrees = arc_sweeps(arcs)[which] * parts[on]
        points[on] = _turned_about(centre[which], normal[which], start[rows[on]], degrees)
    return np.asarray(points)


def arc_sweeps(arcs: Sequence[Arc]) -> NDArray[np.float64]:
    """Degrees (n,) from start to end about the normal."""
    return np.array([arc.sweep for arc in arcs])


Piece = Line | Arc
PlanePoints = NDArray[np.float64]
"""(n, 2) mm."""

_HEIGHT_PARTS: Final = np.linspace(0.0, 1.0, 5)
"""Positions in a piece at which its height is sampled."""
CHORD_TOLERANCE: Final = 0.05
"""Part of the tolerance that chords of an arc may be off where polygons stand for contours."""


def height_range(pieces: Sequence[Piece]) -> tuple[float, float]:
    """The lowest and the highest place of the pieces, mm against the tool."""
    rows = np.repeat(np.arange(len(pieces)), len(_HEIGHT_PARTS))
    found = points_at_parts(pieces, rows, np.tile(_HEIGHT_PARTS, len(pieces)))[:, 2]
    return float(found.min()), float(found.max())


def lowered(pieces: Sequence[Piece], by: float) -> tuple[Piece, ...]:
    """The pieces `by` mm further along the tool."""
    return tuple(_lifted(piece, -by) for piece in pieces) if by else tuple(pieces)


def _lifted(piece: Piece, by: float) -> Piece:
    def up(v: Vector) -> Vector:
        return (v[0], v[1], v[2] + by)

    start, end = up(piece.start), up(piece.end)
    if isinstance(piece, Line):
        return replace(piece, start=start, end=end)
    return replace(piece, start=start, end=end, via=up(piece.via), centre=up(piece.centre))


def polyline(pieces: Sequence[Piece], off: float, *, closed: bool) -> PlanePoints:
    """Corners (n, 2) along the pieces, chords at most `off` mm off; the end left out if closed."""
    counts = chord_counts(pieces, off)
    rows = np.repeat(np.arange(len(pieces)), counts)
    first = np.cumsum(counts) - counts
    points = at_parts(pieces, rows, (np.arange(len(rows)) - first[rows]) / counts[rows])
    return points if closed else np.concatenate([points, [pieces[-1].end[:2]]])


def at_parts(
    pieces: Sequence[Piece], rows: NDArray[np.intp], parts: NDArray[np.float64]
) -> PlanePoints:
    """Points (m, 2) at parts (m,) of pieces, which are known by their rows (m,)."""
    return points_at_parts(pieces, rows, parts)[:, :2]


def chord_counts(pieces: Sequence[Piece], off: float) -> NDArray[np.intp]:
    """Return the number of chords that replace each piece, at most `off` mm off."""
    counts = np.ones(len(pieces), dtype=np.intp)
    arcs = [piece for piece in pieces if isinstance(piece, Arc)]
    if arcs:
        round_ = np.array([isinstance(piece, Arc) for piece in pieces])
        step = 2.0 * np.arccos(np.maximum(1.0 - off / np.array([a.radius for a in arcs]), 0.5))
        counts[round_] = np.ceil(np.radians(arc_sweeps(arcs)) / step).astype(np.intp) + 1
    return counts


def signed_area(outline: PlanePoints) -> float:
    """Return the area of a closed polygon by the shoelace formula; below 0 if it runs clockwise."""
    # From the first corner: coordinates far from the origin would lose digits.
    x, y = (outline - outline[0]).T
    return 0.5 * float((x * np.roll(y, -1) - y * np.roll(x, -1)).sum())


def tangent(piece: Piece, part: float) -> tuple[float, float]:
    """The unit direction of a piece at a part of it, 0 to 1."""
    if isinstance(piece, Line):
        x, y = piece.end[0] - piece.start[0], piece.end[1] - piece.start[1]
    else:
        # The stated ends are exact, computed ones are rounded.
        at = {0.0: piece.start, 1.0: piece.end}.get(part) or vector(piece.at([part])[0])
        ax, ay, az = (a - c for a, c in zip(at, piece.centre, strict=True))
        nx, ny, nz = piece.normal
        x, y = ny * az - nz * ay, nz * ax - nx * az
    size = math.hypot(x, y)
    return (x / size, y / size) if size > 0.0 else (0.0, 0.0)


def _cut_at(piece: Piece, part: float) -> tuple[Piece, Piece]:
    """The piece in two, at a part of its length between 0 and 1."""
    return _piece_between_parts(piece, 0.0, part), _piece_between_parts(piece, part, 1.0)


def _piece_between_parts(piece: Piece, first: float, last: float) -> Piece:
    """From one part of a piece to another, its own ends kept as they are."""
    start, via, end = (vector(p) for p in piece.at([first, 0.5 * (first + last), last]))
    start = piece.start if first == 0.0 else start
    end = piece.end if last == 1.0 else end
    if isinstance(piece, Line):
        return replace(piece, start=start, end=end)
    return replace(piece, start=start, via=via, end=end, closed=False)


def started_at(pieces: Sequence[Piece], at: int, part: float) -> tuple[Piece, ...]:
    """A closed contour from a part, 0 to below 1, of one of its pieces on."""
    if part == 0.0:
        return (*pieces[at:], *pieces[:at])
    piece = pieces[at]
    if isinstance(piece, Arc) and piece.closed:
        start = piece.at([part])[0]
        sweep = (360.0, piece.layer, piece.handle)
        return (Arc.about(piece.centre, piece.normal, start, *sweep),)
    before, after = _cut_at(piece, part)
    return (after, *pieces[at + 1 :], *pieces[:at], before)


def places_after_start(
    places: Sequence[tuple[int, float]], pieces: Sequence[Piece], at: int, part: float
) -> tuple[tuple[int, float], ...]:
    """The places (piece, part) in what `started` gives, that of the start first."""
    count, found = len(pieces), [(0, 0.0)]
    for i, other in places:
        if (i, other) == (at, part):
            continue
        if pieces[at].closed:
            found.append((0, (other - part) % 1.0))
        elif i != at:
            found.append(((i - at) % count, other))
        elif other > part:
            found.append((0, (other - part) / (1.0 - part)))
        else:
            # The start's own piece is cut in two: what was before the start is the last piece.
            found.append((count, other / part))
    return tuple(found)


def first_stretch(pieces: Sequence[Piece], length: float) -> tuple[Piece, ...]:
    """The first `length` mm of the pieces, which are longer."""
    made: list[Piece] = []
    for piece in pieces:
        own = piece.length
        if length <= own * (1.0 + 1e-9):
            part = min(length / own, 1.0)
            # A closed piece is cut even at its full length, as its end would be closed again.
            whole = part > 1.0 - 1e-9
            made.append(
                piece if whole and not piece.closed else _piece_between_parts(piece, 0.0, part)
            )
            break
        made.append(piece)
        length -= own
    return tuple(made)


def reversed_pieces(pieces: Sequence[Piece]) -> tuple[Piece, ...]:
    return tuple(piece.reversed() for piece in reversed(pieces))
