"""Contours beside contours: where the centre of a tool runs whose edge follows them.

What the tool's centre must not come into is the union of bands, one around each line and arc of
the contour, as wide as the offset on either side; the library of plane geometry (shapely, which
is GEOS) unites them, so that islands, necks and collapsing come out as they are. The borders of
that union are polygons. Each of their sides is then given back to what made it: beside a line it
is a line, beside an arc an arc about the same centre, around a corner an arc about the corner;
and these meet where they cross each other, in closed form. So arcs stay arcs, and nothing of the
polygons is left in the result.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import groupby, pairwise
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from assistant.program.geometry import Vector
from assistant.sources.contours.curves import Arc, Line
from assistant.sources.contours.flat import (
    SAMPLED,
    Piece,
    Plane,
    area,
    chords,
    polyline,
    reversed_,
    tangent,
)
from assistant.sources.contours.origins import SAME, Source

LEAST_TURN: Final = math.radians(15.0)
"""Of a corner."""


@dataclass(frozen=True, slots=True)
class Ring:
    """One way beside a contour, or the contour itself.

    pieces: end to end, seen against the tool. closed: they come back. encloses: what stays lies
    within it, so the tool is outside. corners: (piece, part) beside the corners of the contour.
    left: what is cut away lies to the left. starts: (piece, part) where it may start.
    """

    pieces: tuple[Piece, ...]
    closed: bool
    encloses: bool
    corners: tuple[tuple[int, float], ...] = ()
    left: bool = False
    starts: tuple[tuple[int, float], ...] = ()

    @property
    def length(self) -> float:
        return math.fsum(piece.length for piece in self.pieces)

    def from_near(self, point: Vector) -> Ring:
        """The same closed way from the joint that is nearest to a point."""
        count = len(self.pieces)
        first = min(range(count), key=lambda i: math.dist(self.pieces[i].start, point))
        pieces = (*self.pieces[first:], *self.pieces[:first])
        places = sorted(((i - first) % count, part) for i, part in self.corners)
        return replace(self, pieces=pieces, corners=tuple(places))

    def back(self) -> Ring:
        """The same way, followed the other way round."""
        count = len(self.pieces)
        turned = (
            ((count - i) % count, 0.0) if part == 0.0 else (count - 1 - i, 1.0 - part)
            for i, part in self.corners
        )
        pieces, places = reversed_(self.pieces), tuple(sorted(turned))
        return replace(self, pieces=pieces, corners=places, left=not self.left)


def polygon(pieces: Sequence[Piece], tolerance: float) -> Any:
    """What a closed contour is around, as shapely knows it."""
    import shapely

    return shapely.Polygon(polyline(pieces, tolerance * SAMPLED, closed=True))


def crosses_itself(pieces: Sequence[Piece], tolerance: float) -> bool:
    """Whether a closed contour is around nothing, or touches itself."""
    outline = polyline(pieces, tolerance * SAMPLED, closed=True)
    return len(outline) < 3 or not polygon(pieces, tolerance).is_valid


def corners(pieces: Sequence[Piece], *, closed: bool) -> tuple[tuple[int, float], ...]:
    """The joints at which the pieces turn."""
    joints = range(0 if closed else 1, len(pieces))
    return tuple((i, 0.0) for i in joints if abs(_turn(pieces[i - 1], pieces[i])) > LEAST_TURN)


def beside(
    pieces: Sequence[Piece], offset: float, tolerance: float, *, outside: bool
) -> list[Ring]:
    """The ways `offset` mm outside or inside a closed contour, the longest first; none if it is
    too narrow for any. tolerance: mm that the polygons on the way may be off, twenty times over.
    """
    import shapely

    off = min(tolerance, offset) * SAMPLED
    band = shapely.unary_union([_band(piece, offset, off) for piece in pieces])
    whole = shapely.Polygon(polyline(pieces, off, closed=True))
    left = shapely.union(whole, band) if outside else shapely.difference(whole, band)
    source = Source.of(pieces, closed=True)
    found = []
    for part in getattr(left, "geoms", [left]):
        borders = [part.exterior, *part.interiors] if part.geom_type == "Polygon" else []
        for k, border in enumerate(borders):
            encloses = outside and k == 0
            ring = _ring(np.asarray(border.coords)[:-1, :2], source, offset, off)
            if ring:
                turned = [(i, 0.5) for i, (_, corner) in enumerate(ring) if corner]
                made = tuple(piece for piece, _ in ring)
                sharp = {*turned, *corners(made, closed=True)}
                found.append(Ring(made, True, encloses, tuple(sorted(sharp))))
    return sorted(found, key=lambda ring: -ring.length)


def beside_open(
    pieces: Sequence[Piece], offset: float, tolerance: float, *, left: bool
) -> list[Ring]:
    """The ways `offset` mm to the left or right of an open contour, as they follow it."""
    import shapely

    off = min(tolerance, offset) * SAMPLED
    band = shapely.unary_union([_band(piece, offset, off) for piece in pieces])
    source = Source.of(pieces, closed=False)
    found: list[tuple[int, Ring]] = []
    for part in getattr(band, "geoms", [band]):
        for border in [part.exterior, *part.interiors]:
            points = np.asarray(border.coords)[:-1, :2]
            labels, sides = source.nearest(_middles(points))
            wanted = (sides > 0.0) == left
            wanted &= (labels != source.count) & (labels != 2 * source.count)  # caps at its ends
            for rows in _stretches(wanted):
                ends = points[np.append(rows, (rows[-1] + 1) % len(points))]
                chosen = labels[rows]
                if source.runs_back(ends, chosen):
                    ends, chosen = ends[::-1], chosen[::-1]
                way = _joined(ends, chosen, source, offset, off, closed=False)
                made = tuple(piece for piece, _ in way)
                if made and _length(made) > offset * 1e-3:
                    sharp = tuple((i, 0.5) for i, (_, corner) in enumerate(way) if corner)
                    ring = Ring(made, False, False, (*sharp, *corners(made, closed=False)))
                    found.append((int(chosen[0]) % source.count, ring))
    return [ring for _, ring in sorted(found, key=lambda one: one[0])]


def _length(pieces: Sequence[Piece]) -> float:
    return math.fsum(piece.length for piece in pieces)


def _turn(one: Piece, other: Piece) -> float:
    """Radians to the left from the end of a piece to the start of the next."""
    (ax, ay), (bx, by) = tangent(one, 1.0).tolist(), tangent(other, 0.0).tolist()
    return math.atan2(ax * by - ay * bx, ax * bx + ay * by)


def _band(piece: Piece, offset: float, off: float) -> Any:
    """Everything within the offset of a piece; its rounds at most `off` mm off."""
    import shapely

    step = math.acos(max(1.0 - off / offset, 0.5))
    rounds = max(math.ceil(math.pi / 4.0 / step), 2)
    if isinstance(piece, Line):
        return shapely.LineString([piece.start[:2], piece.end[:2]]).buffer(offset, rounds)
    count = max(chords(piece, off), math.ceil(math.radians(piece.sweep) / (2.0 * step)), 8)
    centre = np.asarray(piece.centre[:2])
    arms = (piece.at(np.linspace(0.0, 1.0, count + 1))[:, :2] - centre) / piece.radius
    outer, inner = piece.radius + offset, max(piece.radius - offset, 0.0)
    if piece.closed:
        holes = [centre + inner * arms] if inner > off else []
        return shapely.Polygon(centre + outer * arms, holes)
    within = centre + inner * arms[::-1] if inner > 0.0 else centre[None]
    sector = shapely.Polygon(np.concatenate([centre + outer * arms, within]))
    ends = [shapely.Point(p[:2]).buffer(offset, rounds) for p in (piece.start, piece.end)]
    return shapely.unary_union([sector.buffer(0.0), *ends])


def _middles(points: Plane) -> Plane:
    """Of the sides of a closed polygon."""
    return np.asarray(0.5 * (points + np.roll(points, -1, axis=0)))


def _stretches(wanted: NDArray[np.bool_]) -> Iterator[NDArray[np.intp]]:
    """Rows of a circle that follow each other and are wanted."""
    n = len(wanted)
    if wanted.all():
        yield np.arange(n)
    elif wanted.any():
        first = int(np.flatnonzero(~wanted)[0])
        rows = (np.arange(n) + first) % n
        for is_wanted, group in groupby(rows.tolist(), key=lambda row: bool(wanted[row])):
            if is_wanted:
                yield np.array(list(group), dtype=np.intp)


def _ring(points: Plane, source: Source, offset: float, off: float) -> list[tuple[Piece, bool]]:
    """A border of a union as lines and arcs, each with whether it goes around a corner."""
    keep = np.linalg.norm(np.roll(points, -1, axis=0) - points, axis=1) > SAME
    points = points[keep]
    if len(points) < 3 or abs(area(points)) < SAME:
        return []
    labels, _ = source.nearest(_middles(points))
    changes = np.flatnonzero(labels != np.roll(labels, 1))
    if changes.size:
        first = -int(changes[0])
        points, labels = np.roll(points, first, axis=0), np.roll(labels, first)
    ends = np.concatenate([points, points[:1]])
    return _joined(ends, labels, source, offset, off, closed=True)


def _joined(
    ends: Plane,
    labels: NDArray[np.intp],
    source: Source,
    offset: float,
    off: float,
    *,
    closed: bool,
) -> list[tuple[Piece, bool]]:
    """Lines and arcs for the sides of a polygon, of which those that follow each other with one
    label are one piece. ends: (m + 1, 2). labels: (m,).
    """
    bounds = [0, *(np.flatnonzero(labels[1:] != labels[:-1]) + 1).tolist(), len(labels)]
    runs = list(pairwise(bounds))
    middles = [_half_way(ends[a : b + 1]) for a, b in runs]
    curves = [
        source.curve(int(labels[a]), offset, m) for (a, _), m in zip(runs, middles, strict=True)
    ]
    if len(runs) == 1 and closed:
        curve = curves[0]
        turn = math.copysign(360.0, area(ends[:-1]))
        centre, start = (*curve.point, 0.0), (*curve.nearest(ends[0]), 0.0)
        return [(Arc.about(centre, (0.0, 0.0, 1.0), start, turn), False)]
    meets: list[Plane] = []
    for k, (a, _) in enumerate(runs):
        if k == 0 and not closed:
            meets.append(curves[0].nearest(ends[0]))
            continue
        meet = curves[k - 1].meets(curves[k], ends[a])
        near = meet is not None and float(np.linalg.norm(meet - ends[a])) <= 20.0 * off
        meets.append(meet if meet is not None and near else curves[k].nearest(ends[a]))
    meets.append(meets[0] if closed else curves[-1].nearest(ends[-1]))
    made: list[tuple[Piece, bool]] = []
    for k, curve in enumerate(curves):
        start, end = _point(meets[k]), _point(meets[k + 1])
        if math.dist(start, end) <= SAME:
            continue
        arc = None
        if curve.along is None:
            arc = Arc.through(start, _point(curve.nearest(middles[k])), end)
        corner = int(labels[runs[k][0]]) >= source.count
        made.append((arc or Line(start, end), corner))
    return made


def _half_way(points: Plane) -> Plane:
    """The point half the length along a polyline."""
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    sums = np.concatenate([[0.0], np.cumsum(steps)])
    return np.array([np.interp(0.5 * sums[-1], sums, points[:, i]) for i in (0, 1)])


def _point(p: Plane) -> Vector:
    return (float(p[0]), float(p[1]), 0.0)
