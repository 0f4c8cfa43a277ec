"""Bands around contours as polygons, which the tool's centre must stay outside.

`contour_band` returns the area within an offset of a contour. `OffsetSource` says for each side of
an offset polygon which piece of the contour, or which joint of two pieces, it came from.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from assistant.base.data_classes import dataclass
from assistant.sources.contours.curves import Arc, Piece, PlanePoints, at_parts, chord_counts

SAME_POINT: Final = 1e-6
"""mm between two points that are one."""

Columns = NDArray[np.float64]
PlanePoint = tuple[float, float]


@dataclass(frozen=True, slots=True)
class OffsetSource:
    """The pieces in columns. Labels: piece i is i, the joint before it count + i; of an open
    contour count is its start and 2 count its end.

    tree: of the pieces, arcs as chords. leaving, arriving: (n, 2), directions at their ends.
    """

    pieces: tuple[Piece, ...]
    closed: bool
    tree: Any
    arcs: NDArray[np.bool_]
    start: Columns
    end: Columns
    leaving: Columns
    arriving: Columns
    centre: Columns
    radius: Columns
    first: Columns
    sweep: Columns
    about: Columns

    @staticmethod
    def of(pieces: Sequence[Piece], off: float, *, closed: bool) -> OffsetSource:
        """off: mm that the tree's chords of an arc are off at most."""
        import shapely

        given = tuple(pieces)
        rows = [(i, piece) for i, piece in enumerate(given) if isinstance(piece, Arc)]
        arcs = np.zeros(len(given), dtype=np.bool_)
        arcs[[i for i, _ in rows]] = True
        start = np.array([piece.start[:2] for piece in given])
        end = np.array([piece.end[:2] for piece in given])
        centre, (radius, sweep, about) = np.zeros_like(start), np.zeros((3, len(given)))
        for i, arc in rows:
            centre[i], radius[i] = arc.centre[:2], arc.radius
            sweep[i], about[i] = math.radians(arc.sweep), math.copysign(1.0, arc.normal[2])
        counts = chord_counts(given, off) + 1
        owner = np.repeat(np.arange(len(given)), counts)
        begins = np.cumsum(counts) - counts
        parts = (np.arange(len(owner)) - begins[owner]) / (counts[owner] - 1)
        lines = shapely.linestrings(at_parts(given, owner, parts), indices=owner)
        arm = start - centre
        directions = [
            _unit_vectors(
                np.where(arcs[:, None], about[:, None] * _turned_left(at - centre), end - start)
            )
            for at in (start, end)
        ]
        return OffsetSource(
            given,
            closed,
            shapely.STRtree(lines),
            arcs,
            start,
            end,
            directions[0],
            directions[1],
            centre,
            radius,
            np.arctan2(arm[:, 1], arm[:, 0]),
            sweep,
            about,
        )

    @property
    def count(self) -> int:
        return len(self.pieces)

    def nearest(self, points: PlanePoints, reach: float) -> tuple[NDArray[np.intp], Columns]:
        """For each point (m, 2) the label of what is nearest, and on which side: over 0 left.

        The tree gives the pieces within `reach` mm of a point, or the nearest one of a point that
        has none; they are compared exactly.
        """
        import shapely

        made = shapely.points(points)
        rows, pieces = self.tree.query(made, predicate="dwithin", distance=reach)
        # Every point needs a label: those without a piece in reach get the nearest one.
        without = np.ones(len(points), dtype=np.bool_)
        without[rows] = False
        if without.any():
            far, nearest = self.tree.query_nearest(made[without])
            rows = np.append(rows, np.flatnonzero(without)[far])
            pieces = np.append(pieces, nearest)
        p, start, end = points[rows], self.start[pieces], self.end[pieces]
        way = end - start
        size = np.maximum((way**2).sum(axis=1), 1e-300)
        share = ((p - start) * way).sum(axis=1) / size
        foot = start + np.clip(share, 0.0, 1.0)[:, None] * way
        distance = np.linalg.norm(p - foot, axis=1)
        # Beyond the ends of a piece the joint there is nearest.
        arc = self.arcs[pieces]
        within, late, far_off = (share > 0.0) & (share < 1.0), share >= 1.0, np.zeros(len(rows))
        if arc.any():
            p, start, end, which = p[arc], start[arc], end[arc], pieces[arc]
            arm = p - self.centre[which]
            far_off[arc] = np.linalg.norm(arm, axis=1)
            turned = np.arctan2(arm[:, 1], arm[:, 0]) - self.first[which]
            within[arc] = turned * self.about[which] % math.tau <= self.sweep[which]
            to_start, to_end = np.linalg.norm(p - start, axis=1), np.linalg.norm(p - end, axis=1)
            distance[arc] = np.where(
                within[arc],
                np.abs(far_off[arc] - self.radius[which]),
                np.minimum(to_start, to_end),
            )
            late[arc] = to_end < to_start
        # By point, then by distance; the first of each point is its nearest piece.
        order = np.lexsort((pieces, distance, rows))
        best = order[np.flatnonzero(np.diff(rows[order], prepend=-1))]
        chosen = pieces[best]
        joint = chosen + late[best]
        if self.closed:
            # The joint after the last piece is the one before the first.
            joint = joint % self.count
        labels = np.where(within[best], chosen, self.count + joint)
        line_side = _plane_cross(way[best], points - self.start[chosen])
        arc_side = (self.radius[chosen] - far_off[best]) * self.about[chosen]
        joint_side = _plane_cross(self._along_joint(joint), points - self._corner(joint))
        sides = np.where(within[best], np.where(arc[best], arc_side, line_side), joint_side)
        return labels.astype(np.intp), sides

    def bare(
        self, ends: PlanePoints, labels: NDArray[np.intp], near: float, step: float
    ) -> PlanePoints:
        """Points (k, 2), at most `step` mm apart, of what no side of a polygon is beside, or `near`
        mm of the contour farther on. ends: (m + 1, 2) of the sides. labels: (m,), theirs.
        """
        lengths = np.where(
            self.arcs, self.radius * self.sweep, np.linalg.norm(self.end - self.start, axis=1)
        )
        begins = np.cumsum(lengths) - lengths
        total = float(lengths.sum())
        beside = labels < self.count
        pieces, joints = labels[beside], labels[~beside] - self.count
        parts = [self._part(pieces, at[beside]) for at in (ends[:-1], ends[1:])]
        marks = np.stack(parts) * lengths[pieces] + begins[pieces]
        at_joints = np.append(begins, total)[joints]
        low = np.concatenate([marks.min(axis=0), at_joints]) - near
        high = np.concatenate([marks.max(axis=0), at_joints]) + near
        # Stretches across the start count on both sides of it.
        if self.closed:
            low = np.concatenate([low, low - total, low + total])
            high = np.concatenate([high, high - total, high + total])
        ranks = np.argsort(low)
        # Running ends: a stretch inside another one must not cut it short.
        low, high = low[ranks], np.maximum.accumulate(high[ranks])
        counts = np.maximum(np.ceil(lengths / step), 1).astype(np.intp)
        rows = np.repeat(np.arange(self.count), counts)
        first = np.cumsum(counts) - counts
        shares = (np.arange(len(rows)) - first[rows]) / counts[rows]
        if not self.closed:
            rows, shares = np.append(rows, self.count - 1), np.append(shares, 1.0)
        wanted = begins[rows] + shares * lengths[rows]
        last = np.searchsorted(low, wanted, "right") - 1
        open_ = (last < 0) | (high[np.maximum(last, 0)] < wanted)
        return at_parts(self.pieces, rows[open_], shares[open_])

    def _part(self, pieces: NDArray[np.intp], points: PlanePoints) -> Columns:
        """The parts (n,), 0 to 1, of pieces (n,) that points (n, 2) are beside."""
        start, end = self.start[pieces], self.end[pieces]
        way = end - start
        size = np.maximum((way**2).sum(axis=1), 1e-300)
        parts = ((points - start) * way).sum(axis=1) / size
        arm = points - self.centre[pieces]
        turned = np.arctan2(arm[:, 1], arm[:, 0]) - self.first[pieces]
        turned = turned * self.about[pieces] % math.tau
        sweep = np.maximum(self.sweep[pieces], 1e-300)
        # What is beyond an arc is nearer to its end, or to its start.
        before = turned - sweep > math.tau - turned
        round_ = np.where(before, 0.0, turned / sweep)
        return np.clip(np.where(self.arcs[pieces], round_, parts), 0.0, 1.0)

    def _corner(self, joint: NDArray[np.intp]) -> Columns:
        last = (joint >= self.count)[..., None]
        return np.where(last, self.end[-1], self.start[np.minimum(joint, self.count - 1)])

    def _along_joint(self, joint: NDArray[np.intp]) -> Columns:
        """The direction of a contour at joints, the mean of both sides."""
        before = ((joint > 0) | self.closed)[..., None]
        after = (joint < self.count)[..., None]
        arriving, leaving = self.arriving[joint - 1], self.leaving[joint % self.count]
        return np.asarray(np.where(before, arriving, 0.0) + np.where(after, leaving, 0.0))

    def runs_back(self, ends: PlanePoints, labels: NDArray[np.intp]) -> bool:
        """True if the longest side between ends (m + 1, 2) runs against the piece or joint next to
        it.
        """
        ways = np.diff(ends, axis=0)
        # Pieces count before joints, whose sides are short.
        sizes = np.linalg.norm(ways, axis=1) * (1.0 + (labels < self.count) * ends.size)
        k = int(sizes.argmax())
        label, middle = int(labels[k]), 0.5 * (ends[k] + ends[k + 1])
        if label >= self.count:
            along = self._along_joint(np.array(label - self.count))
        elif self.arcs[label]:
            along = self.about[label] * _turned_left(middle - self.centre[label])
        else:
            along = self.end[label] - self.start[label]
        return float(ways[k] @ along) < 0.0

    def curve(self, label: int, offset: float, near: PlanePoint) -> OffsetCurve:
        """Return the curve at the offset from a piece or around a joint, past a point."""
        if label >= self.count:
            return OffsetCurve(self.corner(label), None, offset)
        x, y = near
        if self.arcs[label]:
            centre, radius = self._place(self.centre, label), float(self.radius[label])
            far = math.hypot(x - centre[0], y - centre[1])
            sizes = (radius + offset, abs(radius - offset))
            # Inside and outside of the arc are both possible: the point decides.
            return OffsetCurve(centre, None, min(sizes, key=lambda size: abs(size - far)))
        (sx, sy), (ux, uy) = self._place(self.start, label), self._place(self.leaving, label)
        side = offset if ux * (y - sy) - uy * (x - sx) >= 0.0 else -offset
        return OffsetCurve((sx - side * uy, sy + side * ux), (ux, uy), 0.0)

    def corner(self, label: int) -> PlanePoint:
        """Return the position of the joint of a label."""
        joint = label - self.count
        return self._place(self.end, -1) if joint >= self.count else self._place(self.start, joint)

    def mitre(self, label: int, offset: float, near: PlanePoint) -> tuple[PlanePoint, float]:
        """Return the point where the paths along both sides of a joint meet, and mm from there to
        its round.
        """
        joint = label - self.count
        (ax, ay), (bx, by) = self._place(self.arriving, joint - 1), self._place(self.leaving, joint)
        x, y = ay + by, -ax - bx  # to the right of both
        half = math.hypot(x, y) / 2.0  # the cosine of half of the turn
        corner = self._place(self.start, joint)
        # Sharper turns have their meeting point far from the corner.
        if half < 0.5:
            return corner, math.inf
        size = offset / (2.0 * half * half)
        if x * (near[0] - corner[0]) + y * (near[1] - corner[1]) < 0.0:
            size = -size
        return (corner[0] + size * x, corner[1] + size * y), offset * (1.0 / half - 1.0)

    @staticmethod
    def _place(column: Columns, row: int) -> PlanePoint:
        return float(column[row, 0]), float(column[row, 1])


@dataclass(frozen=True, slots=True)
class OffsetCurve:
    """A line through a point along a unit direction, or without a direction a circle about it."""

    point: PlanePoint
    along: PlanePoint | None
    radius: float

    def nearest(self, p: PlanePoint) -> PlanePoint:
        x, y = p[0] - self.point[0], p[1] - self.point[1]
        if self.along is not None:
            ux, uy = self.along
            part = x * ux + y * uy
            return self.point[0] + part * ux, self.point[1] + part * uy
        size = math.hypot(x, y)
        if size == 0.0:
            return p
        part = self.radius / size
        return self.point[0] + part * x, self.point[1] + part * y

    def meets(self, other: OffsetCurve, near: PlanePoint) -> PlanePoint | None:
        """Return the crossing or touching point that is nearest to a point."""
        if self.along is None and other.along is not None:
            return other.meets(self, near)
        bx, by = other.point[0] - self.point[0], other.point[1] - self.point[1]
        if self.along is not None and other.along is not None:
            (ux, uy), (vx, vy) = self.along, other.along
            sine = ux * vy - uy * vx
            if abs(sine) < 1e-9:
                return None
            part = (bx * vy - by * vx) / sine
            return self.point[0] + part * ux, self.point[1] + part * uy
        if self.along is not None:
            ux, uy = self.along
            foot = self.nearest(other.point)
            rest = other.radius**2 - math.dist(foot, other.point) ** 2
        else:
            apart = math.hypot(bx, by)
            if apart < SAME_POINT:
                return None
            part = (apart**2 + self.radius**2 - other.radius**2) / (2.0 * apart)
            bx, by = bx / apart, by / apart
            foot = (self.point[0] + part * bx, self.point[1] + part * by)
            ux, uy = -by, bx
            rest = self.radius**2 - part**2
        # Touching curves may miss each other by rounding.
        half = math.sqrt(max(rest, 0.0))
        one = (foot[0] + half * ux, foot[1] + half * uy)
        two = (foot[0] - half * ux, foot[1] - half * uy)
        return min((one, two), key=lambda p: (p[0] - near[0]) ** 2 + (p[1] - near[1]) ** 2)


def _plane_cross(a: PlanePoints, b: PlanePoints) -> Any:
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def _turned_left(v: PlanePoints) -> PlanePoints:
    """Vectors turned to the left by a quarter."""
    return np.stack([-v[..., 1], v[..., 0]], axis=-1)


def _unit_vectors(v: PlanePoints) -> PlanePoints:
    return np.asarray(v / np.maximum(np.linalg.norm(v, axis=-1, keepdims=True), 1e-300))


_MOST_CHUNK_SIDES: Final = 12
"""Most sides whose band is one polygon: bands of many that overlap take long."""
_UNION_GROUP: Final = 16
"""Polygons that are united at once."""
_LEAST_BAND_TURN: Final = math.radians(4.0)
"""Least turn between two sides of one polygon: GEOS leaves out the rounds of smaller turns."""
_LEAST_CORNER_DEPTH: Final = 0.012
"""Least distance, in offsets, of the corner of two such sides from the line past it."""
_POLYGON_OVERLAP: Final = 0.25
"""Overlap of neighbouring polygons, as a part of their tolerance."""
_SLIGHT_TURN: Final = 1e-9
"""Radians of a turn that leaves no gap."""
_SHARP_TURN: Final = math.radians(150.0)
"""Turn at a joint, or gap of an almost full circle, above which it gets a complete round."""


def contour_band(source: OffsetSource, offset: float, off: float, side: int = 0) -> Any:
    """Return the area within `offset` mm of a contour; its rounds are at most `off` mm off.

    The point of the contour nearest to a place in it is square to a line or an arc, or a joint with
    the place between its two normals. So each place is in the band of a piece, or in the wedge
    outside a joint. side: of a closed contour, 1 for the left: the other side is not complete.
    """
    import shapely

    # Half of the turn of a chord that is `off` mm inside its circle.
    step = math.acos(max(1.0 - off / offset, 0.5))
    # GEOS counts the segments of a quarter circle.
    rounds = max(math.ceil(math.pi / 4.0 / step), 2)
    found = shapely.buffer(_line_chunks(source, offset), offset, quad_segs=rounds).tolist()
    if source.arcs.any():
        wedged = _wedged_joints(source)
        ends = shapely.points(_bare_ends(source, wedged))
        found += shapely.buffer(ends, offset, quad_segs=rounds).tolist()
        found += _wedges(source, wedged, offset, off, step, side)
        found += _sectors(source, offset, off)
    return _union_area(shapely.get_parts(found))


def _union_area(parts: NDArray[Any]) -> Any:
    """The area of polygons (n,), of which neighbours are united first: a sweep over many that
    overlap takes long.
    """
    import shapely

    owner = np.arange(len(parts))
    while owner.size and owner[-1] >= _UNION_GROUP:
        owner = np.unique(owner // _UNION_GROUP, return_inverse=True)[1]
        groups = shapely.multipolygons(parts, indices=owner)
        # A buffer of 0 unites polygons in one sweep; `union_all` does it in pairs.
        parts, owner = shapely.get_parts(shapely.buffer(groups, 0.0), return_index=True)
    return shapely.buffer(shapely.multipolygons(parts), 0.0)


def _wedged_joints(source: OffsetSource) -> NDArray[np.bool_]:
    """Joints (n,) of two arcs that a wedge closes: not those of ends that do not meet, hairpins,
    and circles that almost return to their start. A line has a round at both ends.
    """
    before = np.roll(source.arcs, 1)
    met = (np.roll(source.end, 1, axis=0) == source.start).all(axis=1)
    full = source.sweep > math.tau - _SHARP_TURN
    plain = before & source.arcs & met & ~full & ~np.roll(full, 1)
    plain &= np.abs(_joint_turns(source)) < _SHARP_TURN
    plain[0] &= source.closed
    return np.asarray(plain)


def _joint_turns(source: OffsetSource) -> NDArray[np.float64]:
    """Turn (n,) in radians, positive to the left, from the piece before to each."""
    one, two = np.roll(source.arriving, 1, axis=0), source.leaving
    return np.asarray(np.arctan2(_plane_cross(one, two), (one * two).sum(axis=1)))


def _bare_ends(source: OffsetSource, wedged: NDArray[np.bool_]) -> PlanePoints:
    """Ends (k, 2) of arcs without a wedge."""
    starts = source.start[source.arcs & ~wedged]
    return np.concatenate([starts, source.end[source.arcs & ~np.roll(wedged, -1)]])


def _wedges(
    source: OffsetSource,
    wedged: NDArray[np.bool_],
    offset: float,
    off: float,
    step: float,
    side: int,
) -> list[Any]:
    """Regions outside joints, between the normals of both sides; `side` as of `contour_band`."""
    turns = _joint_turns(source)
    # Only the outer side of a joint has a gap between the two bands.
    rows = np.flatnonzero(wedged & (np.abs(turns) > _SLIGHT_TURN) & (side * turns <= 0.0))
    turn, arriving = turns[rows], np.roll(source.arriving, 1, axis=0)[rows]
    out = -np.sign(turn)
    # Padded: polygons that only touch would leave slits between them.
    pad = np.copysign(_POLYGON_OVERLAP * off / offset, turn)
    first = np.arctan2(arriving[:, 0] * out, -arriving[:, 1] * out) - pad
    turn = turn + 2.0 * pad
    chords = np.ceil(np.abs(turn) / (2.0 * step)).astype(np.intp)
    owner, places = _rows_and_numbers(chords + 2)
    share = np.where(places == 0, 0.5, (places - 1) / chords[owner])
    size = np.where(places == 0, -_POLYGON_OVERLAP * off, offset)
    points = source.start[rows][owner] + _polar_points(first[owner] + share * turn[owner], size)
    return _polygons_of_points(points, owner)


def _sectors(source: OffsetSource, offset: float, off: float) -> list[Any]:
    """Regions within the offset of arcs, without the rounds of their ends."""
    import shapely

    rows = np.flatnonzero(source.arcs)
    whole = np.array([source.pieces[i].closed for i in rows.tolist()], dtype=np.bool_)
    radius, sweep, centre = source.radius[rows], source.sweep[rows], source.centre[rows]
    # A full circle has no ends that could overlap.
    more = np.where(whole, 0.0, np.minimum(_POLYGON_OVERLAP * off / radius, _POLYGON_OVERLAP))
    more = np.minimum(more, np.maximum(math.tau - sweep, 0.0) / 4.0)
    step = 2.0 * np.arccos(np.maximum(1.0 - off / (radius + offset), 0.5))
    chords = np.maximum(np.ceil((sweep + 2.0 * more) / step).astype(np.intp), 2)
    inner = np.maximum(radius - offset, 0.0)
    owner, places = _rows_and_numbers(chords + 1 + np.where(inner > 0.0, chords + 1, 1))
    outer = places <= chords[owner]
    share = np.where(outer, places, 2 * chords[owner] + 1 - places) / chords[owner]
    angles = share * (sweep + 2.0 * more)[owner] - more[owner]
    angles = source.first[rows][owner] + source.about[rows][owner] * angles
    size = np.where(outer, radius[owner] + offset, inner[owner])
    points = centre[owner] + _polar_points(angles, size)
    parts = ~whole[owner]
    found = _polygons_of_points(points[parts], owner[parts])
    for i in np.flatnonzero(whole).tolist():
        rim, hole = (points[(owner == i) & on] for on in (outer, ~outer))
        found.append(shapely.Polygon(rim, [hole] if radius[i] - offset > off else []))
    valid = shapely.is_valid(found)
    return [one if fine else one.buffer(0.0) for one, fine in zip(found, valid, strict=True)]


def _rows_and_numbers(sizes: NDArray[np.intp]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Row (m,) of each point and its number in the row, for rows of so many points (n,)."""
    owner = np.repeat(np.arange(len(sizes)), sizes)
    return owner, np.arange(len(owner)) - (np.cumsum(sizes) - sizes)[owner]


def _polar_points(angles: NDArray[np.float64], size: NDArray[np.float64]) -> PlanePoints:
    return np.asarray(size[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1))


def _polygons_of_points(points: PlanePoints, owner: NDArray[np.intp]) -> list[Any]:
    """A polygon of the points (n, 2) of each owner (n,), in their order."""
    import shapely

    if not owner.size:
        return []
    indices = np.cumsum(np.diff(owner, prepend=owner[0]) > 0)
    return [*shapely.polygons(shapely.linearrings(points, indices=indices))]


def _line_chunks(source: OffsetSource, offset: float) -> Any:
    """The lines of a contour as polylines of a few sides, whose bands GEOS makes exactly.

    GEOS leaves corners that are almost on the line between their neighbours out of the band of a
    polyline: no polyline gets such a corner.
    """
    import shapely

    rows = np.flatnonzero(~source.arcs)
    if not rows.size:
        return np.empty(0, dtype=object)
    start, end = source.start[rows], source.end[rows]
    way = end - start
    size = np.maximum(np.linalg.norm(way, axis=1), 1e-300)
    one, two = way[:-1], way[1:]
    sine = one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0]
    turns = np.arctan2(np.abs(sine), (one * two).sum(axis=1))
    across = np.maximum(np.linalg.norm(one + two, axis=1), 1e-300)
    plain = (np.diff(rows) == 1) & (start[1:] == end[:-1]).all(axis=1)
    plain &= (turns > _LEAST_BAND_TURN) & (np.abs(sine) / across > _LEAST_CORNER_DEPTH * offset)
    plain &= np.minimum(size[:-1], size[1:]) > _LEAST_CORNER_DEPTH * offset
    plain[_MOST_CHUNK_SIDES - 1 :: _MOST_CHUNK_SIDES] = False
    chunk = np.concatenate([[0], np.cumsum(~plain)])
    first = np.diff(chunk, prepend=-1) > 0
    # Each line gives its end, and the first of a polyline its start before that.
    places = np.arange(len(rows)) + np.cumsum(first)
    points = np.empty((len(rows) + int(first.sum()), 2))
    owner = np.empty(len(points), dtype=np.intp)
    points[places], owner[places] = end, chunk
    points[places[first] - 1], owner[places[first] - 1] = start[first], chunk[first]
    return shapely.linestrings(points, indices=owner)
