"""Offset contours: the path of a tool's centre whose edge follows them.

The space that the tool's centre must not enter is the union of bands, one around each line and arc
of the contour, as wide as the offset on either side; shapely (GEOS) unites them, so that islands,
necks and collapsing are correct. The borders of that union are polygons. Each of their sides is
then mapped back to its origin: next to a line it is a line, next to an arc an arc about the same
centre, around a corner an arc about the corner; and these meet where they cross each other, in
closed form. So arcs stay arcs, and nothing of the polygons is left in the result.

`ClearRoom` measures how near a tool path runs to the contours that it must not cut into.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import field, replace
from itertools import groupby, pairwise
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from assistant.base.data_classes import dataclass
from assistant.program.geometry import Vector
from assistant.sources.contours.curves import (
    CHORD_TOLERANCE,
    Arc,
    Line,
    Piece,
    PlanePoints,
    Points,
    polyline,
    reversed_pieces,
    signed_area,
    tangent,
)
from assistant.sources.contours.offset_bands import (
    SAME_POINT,
    OffsetCurve,
    OffsetSource,
    PlanePoint,
    contour_band,
)
from assistant.sources.contours.path_tolerance import shortest_piece

_LEAST_CORNER_TURN: Final = math.radians(15.0)
"""Least turn of a corner."""
_BAND_TOLERANCE: Final = 0.15
"""Part of the tolerance that the polygons of bands may be off: they only tell what meets what."""
_PIECE_QUARTERS: Final = np.array([0.0, 0.25, 0.5, 0.75, 1.0])
_COVERED_OFFSETS: Final = 0.75
"""Offsets along a contour from what a way is beside to places that the tool comes to."""
_MITRE_PART: Final = 0.1
"""Part of the tolerance that the way around a corner may be off the arc about it as a point."""


@dataclass(frozen=True, slots=True)
class OffsetRing:
    """One way beside a contour, or the contour itself.

    pieces: end to end, seen against the tool. closed: they come back. encloses: what stays lies
    within it, so the tool is outside. corners: (piece, part) beside the corners of the contour.
    left: what is cut away lies to the left. starts: (piece, part) where it may start. bare: points
    (k, 2) of the contour that it may not come near to.
    """

    pieces: tuple[Piece, ...]
    closed: bool
    encloses: bool
    corners: tuple[tuple[int, float], ...] = ()
    left: bool = False
    starts: tuple[tuple[int, float], ...] = ()
    bare: PlanePoints | None = field(default=None, compare=False)

    @property
    def length(self) -> float:
        return math.fsum(piece.length for piece in self.pieces)

    def from_near(self, point: Vector) -> OffsetRing:
        """The same closed way from the joint that is nearest to a point."""
        count = len(self.pieces)
        first = min(range(count), key=lambda i: math.dist(self.pieces[i].start, point))
        pieces = (*self.pieces[first:], *self.pieces[:first])
        places = sorted(((i - first) % count, part) for i, part in self.corners)
        return replace(self, pieces=pieces, corners=tuple(places))

    def back(self) -> OffsetRing:
        """The same way, followed the other way round."""
        count = len(self.pieces)
        turned = (
            ((count - i) % count, 0.0) if part == 0.0 else (count - 1 - i, 1.0 - part)
            for i, part in self.corners
        )
        pieces, places = reversed_pieces(self.pieces), tuple(sorted(turned))
        return replace(self, pieces=pieces, corners=places, left=not self.left)


def _contour_polygon(pieces: Sequence[Piece], tolerance: float) -> Any:
    """Return the area inside a closed contour, as a polygon of shapely."""
    import shapely

    return shapely.Polygon(polyline(pieces, tolerance * CHORD_TOLERANCE, closed=True))


def crosses_itself(pieces: Sequence[Piece], tolerance: float) -> bool:
    """True if a closed contour encloses nothing, or touches itself."""
    import shapely

    outline = polyline(pieces, tolerance * CHORD_TOLERANCE, closed=True)
    return len(outline) < 3 or not shapely.Polygon(outline).is_valid


def corner_joints(pieces: Sequence[Piece], *, closed: bool) -> tuple[tuple[int, float], ...]:
    """The joints at which the pieces turn."""
    joints = range(0 if closed else 1, len(pieces))
    return tuple(
        (i, 0.0)
        for i in joints
        if abs(_turn_between(pieces[i - 1], pieces[i])) > _LEAST_CORNER_TURN
    )


def offset_closed(
    pieces: Sequence[Piece], offset: float, tolerance: float, *, outside: bool
) -> list[OffsetRing]:
    """The ways `offset` mm outside or inside a closed contour, the longest first; none if it is
    too narrow for any. tolerance: mm, of which parts are what the way may be off.
    """
    import shapely

    # An offset below the tolerance allows less.
    limit = min(tolerance, offset)
    off = limit * _BAND_TOLERANCE
    source = OffsetSource.of(pieces, off, closed=True)
    outline = polyline(pieces, off, closed=True)
    # The left of an anticlockwise contour is inside.
    band = contour_band(source, offset, off, 1 if (signed_area(outline) < 0.0) == outside else -1)
    whole = shapely.Polygon(outline)
    left = shapely.union(whole, band) if outside else shapely.difference(whole, band)
    found = []
    for part in getattr(left, "geoms", [left]):
        borders = [part.exterior, *part.interiors] if part.geom_type == "Polygon" else []
        for k, border in enumerate(borders):
            encloses = outside and k == 0
            ring, bare = _ring_of_border(
                shapely.get_coordinates(border)[:-1], source, offset, limit
            )
            if ring:
                # The middle of an arc around a corner stands for the corner.
                turned = [(i, 0.5) for i, (_, corner) in enumerate(ring) if corner]
                made = tuple(piece for piece, _ in ring)
                sharp = {*turned, *corner_joints(made, closed=True)}
                found.append(OffsetRing(made, True, encloses, tuple(sorted(sharp)), bare=bare))
    return sorted(found, key=lambda ring: -ring.length)


def offset_open(
    pieces: Sequence[Piece], offset: float, tolerance: float, *, left: bool
) -> list[OffsetRing]:
    """The ways `offset` mm to the left or right of an open contour, as they follow it."""
    import shapely

    limit = min(tolerance, offset)
    off = limit * _BAND_TOLERANCE
    source = OffsetSource.of(pieces, off, closed=False)
    band = contour_band(source, offset, off)
    found: list[tuple[int, OffsetRing]] = []
    for part in getattr(band, "geoms", [band]):
        for border in [part.exterior, *part.interiors]:
            points = shapely.get_coordinates(border)[:-1]
            labels, sides = source.nearest(_side_middles(points), offset + 2.0 * off)
            wanted = (sides > 0.0) == left
            # The band of an open contour has two sides: only the wanted one is the path.
            wanted &= (labels != source.count) & (labels != 2 * source.count)  # caps at its ends
            for rows in _wanted_stretches(wanted):
                ends = points[np.append(rows, (rows[-1] + 1) % len(points))]
                chosen = labels[rows]
                # The border runs around the band: on one of its sides against the contour.
                if source.runs_back(ends, chosen):
                    ends, chosen = ends[::-1], chosen[::-1]
                way = _pieces_of_sides(ends, chosen, source, offset, limit, closed=False)
                made = tuple(piece for piece, _ in way)
                if made and _total_length(made) > offset * 1e-3:
                    sharp = tuple((i, 0.5) for i, (_, corner) in enumerate(way) if corner)
                    bare = source.bare(ends, chosen, _COVERED_OFFSETS * offset, offset)
                    sharp = (*sharp, *corner_joints(made, closed=False))
                    ring = OffsetRing(made, False, False, sharp, bare=bare)
                    # Paths are put in the order of the contour by where they begin.
                    found.append((int(chosen[0]) % source.count, ring))
    return [ring for _, ring in sorted(found, key=lambda one: one[0])]


def _total_length(pieces: Sequence[Piece]) -> float:
    return math.fsum(piece.length for piece in pieces)


def _turn_between(one: Piece, other: Piece) -> float:
    """Radians to the left from the end of a piece to the start of the next."""
    (ax, ay), (bx, by) = tangent(one, 1.0), tangent(other, 0.0)
    return math.atan2(ax * by - ay * bx, ax * bx + ay * by)


def _side_middles(points: PlanePoints) -> PlanePoints:
    """Return the midpoints of the sides of a closed polygon."""
    return np.asarray(0.5 * (points + np.roll(points, -1, axis=0)))


def _wanted_stretches(wanted: NDArray[np.bool_]) -> Iterator[NDArray[np.intp]]:
    """Rows of a circle that follow each other and are wanted."""
    n = len(wanted)
    if wanted.all():
        yield np.arange(n)
    elif wanted.any():
        # From a row that is not wanted, so that no stretch is cut in two.
        first = int(np.flatnonzero(~wanted)[0])
        rows = (np.arange(n) + first) % n
        for is_wanted, group in groupby(rows.tolist(), key=lambda row: bool(wanted[row])):
            if is_wanted:
                yield np.array(list(group), dtype=np.intp)


def _ring_of_border(
    points: PlanePoints, source: OffsetSource, offset: float, limit: float
) -> tuple[list[tuple[Piece, bool]], PlanePoints]:
    """A border of a union as lines and arcs, each with whether it goes around a corner, and
    points of the contour that it is not beside.
    """
    keep = np.linalg.norm(np.roll(points, -1, axis=0) - points, axis=1) > SAME_POINT
    points = points[keep]
    # Nothing is left of the border but rounding.
    if len(points) < 3 or abs(signed_area(points)) < SAME_POINT:
        return [], points[:0]
    labels, _ = source.nearest(_side_middles(points), offset + 2.0 * _BAND_TOLERANCE * limit)
    # The polygon starts where the label changes, so that no run is cut in two.
    changes = np.flatnonzero(labels != np.roll(labels, 1))
    if changes.size:
        first = -int(changes[0])
        points, labels = np.roll(points, first, axis=0), np.roll(labels, first)
    ends = np.concatenate([points, points[:1]])
    made = _pieces_of_sides(ends, labels, source, offset, limit, closed=True)
    return made, source.bare(ends, labels, _COVERED_OFFSETS * offset, offset)


@dataclass(slots=True)
class _SideRun:
    """Sides of a polygon with one label that follow each other, and the curve that they stand for.

    begin, end: its corners. length: mm. turn: radians about the centre of a circle. mitre: where
    the neighbours meet if this one, around a corner, is no more than a point.
    """

    label: int
    curve: OffsetCurve
    begin: PlanePoint
    end: PlanePoint
    length: float
    turn: float = 0.0
    mitre: PlanePoint | None = None

    def with_next(self, other: _SideRun) -> _SideRun:
        """One run of two with the same label, over what lay between them."""
        turn = self.turn + other.turn
        return replace(self, end=other.end, length=self.length + other.length, turn=turn)

    def piece(self, start: PlanePoint, end: PlanePoint) -> Piece | None:
        """Return the piece from one point to another; None if it would run backwards."""
        curve = self.curve
        dx, dy = end[0] - start[0], end[1] - start[1]
        if curve.along is not None:
            # The neighbours cut this run off: the joints have passed each other.
            back = dx * (self.end[0] - self.begin[0]) + dy * (self.end[1] - self.begin[1]) <= 0.0
            return None if back else Line((*start, 0.0), (*end, 0.0))
        x, y = curve.point
        first, last = (math.atan2(p[1] - y, p[0] - x) for p in (start, end))
        # A sweep of more than half a circle needs the polygon's own turn.
        sweep = self.turn + _wrapped_angle(last - first - self.turn)
        if (
            sweep * self.turn <= 0.0
            or math.hypot(dx, dy) <= SAME_POINT < curve.radius * math.tau - SAME_POINT
        ):
            return None
        half = first + 0.5 * sweep
        via = (x + curve.radius * math.cos(half), y + curve.radius * math.sin(half), 0.0)
        ends = (*start, 0.0), (*end, 0.0)
        off = max(abs(math.hypot(p[0] - x, p[1] - y) - curve.radius) for p in (start, end))
        # Ends off the circle, as after a joint in the middle: the arc is put through them.
        if off > SAME_POINT and (arc := Arc.through(ends[0], via, ends[1])) is not None:
            return arc
        normal = (0.0, 0.0, math.copysign(1.0, sweep))
        return Arc(ends[0], via, ends[1], (x, y, 0.0), curve.radius, normal)


def _pieces_of_sides(
    ends: PlanePoints,
    labels: NDArray[np.intp],
    source: OffsetSource,
    offset: float,
    limit: float,
    *,
    closed: bool,
) -> list[tuple[Piece, bool]]:
    """Lines and arcs for the sides of a polygon, of which those that follow each other with one
    label are one piece, each with whether it goes around a corner. ends: (m + 1, 2). labels:
    (m,). limit: mm that a joint may be away from the polygon's.
    """
    runs = _side_runs(ends, labels, source, offset)
    # One label all around is a circle.
    if len(runs) == 1 and closed:
        curve, turn = runs[0].curve, math.copysign(360.0, signed_area(ends[:-1]))
        around = (*curve.point, 0.0), (0.0, 0.0, 1.0), (*curve.nearest(runs[0].begin), 0.0)
        return [(Arc.about(*around, turn), False)]
    runs, dropped = _long_runs(runs, source, offset, limit, closed=closed)
    pairs = list(zip(runs, [*runs[1:], runs[0]], dropped, strict=True))
    joints = [_joint_of_runs(one, two, between, limit) for one, two, between in pairs]
    if not closed:
        joints[-1] = runs[-1].curve.nearest(runs[-1].end)
    begins = [joints[-1] if closed else runs[0].curve.nearest(runs[0].begin), *joints[:-1]]
    found: list[tuple[PlanePoint, PlanePoint, Piece | None]] = []
    for k, run in enumerate(runs):
        found.append((begins[k], joints[k], run.piece(begins[k], joints[k])))
        if found[k][2] is None:  # its neighbours cut it off
            # Both neighbours meet in the middle of what is left.
            half = _midpoint(begins[k], joints[k])
            begins[k] = joints[k] = half
            if closed or k:
                joints[k - 1] = half
            if closed or k + 1 < len(runs):
                begins[(k + 1) % len(runs)] = half
    made: list[tuple[Piece, bool]] = []
    for run, start, end, (*ends_then, piece) in zip(runs, begins, joints, found, strict=True):
        if math.dist(start, end) > SAME_POINT:
            if ends_then != [start, end]:
                piece = run.piece(start, end)
            made.append((piece or Line((*start, 0.0), (*end, 0.0)), run.label >= source.count))
    return made


def _side_runs(
    ends: PlanePoints, labels: NDArray[np.intp], source: OffsetSource, offset: float
) -> list[_SideRun]:
    """Sides with one label that follow each other."""
    sums = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(ends, axis=0), axis=1))])
    bounds = np.concatenate([[0], np.flatnonzero(labels[1:] != labels[:-1]) + 1, [len(labels)]])
    first, last = sums[bounds[:-1]], sums[bounds[1:]]
    marks = first[:, None] + (last - first)[:, None] * _PIECE_QUARTERS
    points = np.stack([np.interp(marks, sums, ends[:, i]) for i in (0, 1)], axis=-1).tolist()
    lengths = (last - first).tolist()
    runs: list[_SideRun] = []
    for label, length, places in zip(labels[bounds[:-1]].tolist(), lengths, points, strict=True):
        begin, *_, end = ((x, y) for x, y in places)
        curve = source.curve(label, offset, (places[2][0], places[2][1]))
        turn = 0.0
        if curve.along is None:
            x, y = curve.point
            angles = [math.atan2(py - y, px - x) for px, py in places]
            turn = math.fsum(_wrapped_angle(b - a) for a, b in pairwise(angles))
        runs.append(_SideRun(label, curve, begin, end, length, turn))
    return runs


def _long_runs(
    runs: list[_SideRun], source: OffsetSource, offset: float, limit: float, *, closed: bool
) -> tuple[list[_SideRun], list[list[_SideRun]]]:
    """Runs that are long enough to be a move, and after each what is left out before the next.

    A small turn becomes a point. Of what is left out in a row no more goes than is short.
    """
    last, least, left = len(runs) - 1, shortest_piece(limit), 0.0
    kept: list[bool] = []
    for k, run in enumerate(runs):
        stays = not closed and k in (0, last)
        if not stays and run.label >= source.count:
            # A small round between its own neighbours becomes the point at which their paths meet.
            joint = run.label - source.count
            beside = {runs[k - 1].label, runs[(k + 1) % len(runs)].label}
            if beside == {(joint - 1) % source.count, joint}:
                place, off = source.mitre(run.label, offset, run.begin)
                if off <= _MITRE_PART * limit:
                    run.mitre = place
        small = run.mitre is not None or (not stays and left + run.length < least)
        left = left + run.length if small and run.mitre is None else 0.0
        kept.append(not small)
    # One piece alone cannot be joined: the runs stay as they are.
    if sum(kept) < 2:
        return runs, [[] for _ in runs]
    first = kept.index(True)
    found: list[_SideRun] = []
    dropped: list[list[_SideRun]] = []
    for k in range(first, first + len(runs)):
        run = runs[k % len(runs)]
        if not kept[k % len(runs)]:
            dropped[-1].append(run)
        elif found and found[-1].label == run.label:
            found[-1], dropped[-1] = found[-1].with_next(run), []
        else:
            found.append(run)
            dropped.append([])
    # The ring begins inside this run.
    if closed and len(found) > 2 and found[0].label == found[-1].label:
        found[0], dropped = found[-1].with_next(found[0]), dropped[:-1]
        found.pop()
    return found, dropped


def _joint_of_runs(
    one: _SideRun, two: _SideRun, between: Sequence[_SideRun], limit: float
) -> PlanePoint:
    """Return the point where a run continues in the next one. between: runs that are left out
    there.
    """
    if len(between) == 1 and between[0].mitre is not None:
        return between[0].mitre
    near = _midpoint(one.end, two.begin)
    meet = one.curve.meets(two.curve, near)
    # A crossing far from the polygon's joint belongs to another part of the curves.
    reach = limit + math.fsum(run.length for run in between)
    if meet is not None and math.dist(meet, near) <= reach:
        return meet
    return _midpoint(one.curve.nearest(near), two.curve.nearest(near))


def _midpoint(a: PlanePoint, b: PlanePoint) -> PlanePoint:
    return (a[0] + b[0]) / 2.0, (a[1] + b[1]) / 2.0


def _wrapped_angle(angle: float) -> float:
    """The same angle between -pi and pi."""
    return (angle + math.pi) % math.tau - math.pi


_LEAST_DISTANCE_PART: Final = 0.5
"""Part of an offset that a way has to keep away at least, however large the tolerance is."""


@dataclass(frozen=True, slots=True)
class ClearRoom:
    """contours: their lines by what they are known by; tree: of the same lines."""

    keys: tuple[tuple[int, int], ...]
    tree: Any
    tolerance: float

    @staticmethod
    def of(
        contours: Sequence[tuple[tuple[int, int], Sequence[Piece], bool]], tolerance: float
    ) -> ClearRoom:
        """Contours by their keys, as (key, pieces, whether closed)."""
        import shapely

        lines = []
        for _, pieces, closed in contours:
            points = polyline(pieces, tolerance * CHORD_TOLERANCE, closed=closed)
            lines.append(
                shapely.LineString(np.concatenate([points, points[:1]] if closed else [points]))
            )
        return ClearRoom(tuple(key for key, *_ in contours), shapely.STRtree(lines), tolerance)

    def nearest(self, points: Points) -> Iterator[tuple[Points, tuple[int, int], float]]:
        """For each point (m, 3) the contour that is nearest to it, and the mm between them."""
        import shapely

        if self.keys and len(points):
            made = shapely.points(points[:, :2])
            rows = self.tree.nearest(made)
            far = shapely.distance(made, self.tree.geometries[rows])
            for point, row, apart in zip(points, rows.tolist(), far.tolist(), strict=True):
                yield point, self.keys[row], apart

    def too_near(self, ring: OffsetRing, offset: float) -> float | None:
        """The mm that a way beside a contour comes near to any; None if that is enough."""
        line = self._line(ring.pieces)
        away = self._away(offset)
        rows = self.tree.query(line, predicate="dwithin", distance=away)
        apart = [line.distance(self.tree.geometries[row]) for row in rows.tolist()]
        return min(apart) if apart else None

    def beside(
        self, key: tuple[int, int], own: OffsetRing, offset: float
    ) -> Callable[[Sequence[Piece]], bool]:
        """Return a test whether pieces that lead onto a contour or off it have room. own: as it was
        drawn.
        """
        if offset > 0.0:
            away = self._away(offset)
            return lambda pieces: (
                not len(self.tree.query(self._line(pieces), predicate="dwithin", distance=away))
            )
        kept = self._kept(own)
        number = self.keys.index(key)

        def free(pieces: Sequence[Piece]) -> bool:
            line = self._line(pieces)
            rows = self.tree.query(line, predicate="dwithin", distance=self.tolerance)
            return set(rows.tolist()) <= {number} and kept(line)

        return free

    def away(self, offset: float) -> Callable[[Vector], bool]:
        """True if a point is clearly farther from all contours than the offset."""
        import shapely

        far = offset + 2.0 * self.tolerance
        return lambda point: (
            not len(self.tree.query(shapely.Point(point[:2]), predicate="dwithin", distance=far))
        )

    def _kept(self, own: OffsetRing) -> Callable[[Any], bool]:
        """Return a test whether a line that begins or ends on a contour stays on the side of the
        tool.
        """
        import shapely

        if own.closed:
            around = _contour_polygon(own.pieces, self.tolerance)
            if own.encloses:
                inner = around.buffer(-self.tolerance)
                return lambda line: not line.intersects(inner)
            outer = around.buffer(self.tolerance)
            return lambda line: bool(line.within(outer))
        drawn = self._line(own.pieces)
        ends = shapely.MultiPoint([own.pieces[0].start[:2], own.pieces[-1].end[:2]])
        away = drawn.difference(ends.buffer(2.0 * self.tolerance))
        return lambda line: not line.intersects(away)

    def _away(self, offset: float) -> float:
        return max(offset - self.tolerance, _LEAST_DISTANCE_PART * offset)

    def _line(self, pieces: Sequence[Piece]) -> Any:
        import shapely

        return shapely.LineString(polyline(pieces, self.tolerance * CHORD_TOLERANCE, closed=False))
