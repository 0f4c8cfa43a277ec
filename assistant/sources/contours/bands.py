"""The band around a contour, as polygons: the tool's centre must stay outside."""

from __future__ import annotations

import math
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from assistant.sources.contours.flat import PlanePoints
from assistant.sources.contours.origins import OffsetSource, plane_cross

MOST_CHUNK_SIDES: Final = 12
"""Most sides whose band is one polygon: bands of many that overlap take long."""
UNION_GROUP: Final = 16
"""Polygons that are united at once."""
LEAST_BAND_TURN: Final = math.radians(4.0)
"""Least turn between two sides of one polygon: GEOS leaves out the rounds of smaller turns."""
LEAST_CORNER_DEPTH: Final = 0.012
"""Least distance, in offsets, of the corner of two such sides from the line past it."""
POLYGON_OVERLAP: Final = 0.25
"""Overlap of neighbouring polygons, as a part of their tolerance."""
SLIGHT_TURN: Final = 1e-9
"""Radians of a turn that leaves no gap."""
SHARP_TURN: Final = math.radians(150.0)
"""Turn at a joint, or gap of an almost full circle, above which it gets a complete round."""


def contour_band(source: OffsetSource, offset: float, off: float, side: int = 0) -> Any:
    """Return the area within `offset` mm of a contour; its rounds are at most `off` mm off.

    The point of the contour nearest to a place in it is square to a line or an arc, or a joint with
    the place between its two normals. So each place is in the band of a piece, or in the wedge
    outside a joint. side: of a closed contour, 1 for the left: the other side is not complete.
    """
    import shapely

    step = math.acos(max(1.0 - off / offset, 0.5))
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
    while owner.size and owner[-1] >= UNION_GROUP:
        owner = np.unique(owner // UNION_GROUP, return_inverse=True)[1]
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
    full = source.sweep > math.tau - SHARP_TURN
    plain = before & source.arcs & met & ~full & ~np.roll(full, 1)
    plain &= np.abs(_joint_turns(source)) < SHARP_TURN
    plain[0] &= source.closed
    return np.asarray(plain)


def _joint_turns(source: OffsetSource) -> NDArray[np.float64]:
    """Turn (n,) in radians, positive to the left, from the piece before to each."""
    one, two = np.roll(source.arriving, 1, axis=0), source.leaving
    return np.asarray(np.arctan2(plane_cross(one, two), (one * two).sum(axis=1)))


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
    """Regions outside joints, between the normals of both sides; `side` as of `bands`."""
    turns = _joint_turns(source)
    rows = np.flatnonzero(wedged & (np.abs(turns) > SLIGHT_TURN) & (side * turns <= 0.0))
    turn, arriving = turns[rows], np.roll(source.arriving, 1, axis=0)[rows]
    out = -np.sign(turn)
    pad = np.copysign(POLYGON_OVERLAP * off / offset, turn)
    first = np.arctan2(arriving[:, 0] * out, -arriving[:, 1] * out) - pad
    turn = turn + 2.0 * pad
    chords = np.ceil(np.abs(turn) / (2.0 * step)).astype(np.intp)
    owner, places = _rows_and_numbers(chords + 2)
    share = np.where(places == 0, 0.5, (places - 1) / chords[owner])
    size = np.where(places == 0, -POLYGON_OVERLAP * off, offset)
    points = source.start[rows][owner] + _polar_points(first[owner] + share * turn[owner], size)
    return _polygons_of_points(points, owner)


def _sectors(source: OffsetSource, offset: float, off: float) -> list[Any]:
    """Regions within the offset of arcs, without the rounds of their ends."""
    import shapely

    rows = np.flatnonzero(source.arcs)
    whole = np.array([source.pieces[i].closed for i in rows.tolist()], dtype=np.bool_)
    radius, sweep, centre = source.radius[rows], source.sweep[rows], source.centre[rows]
    more = np.where(whole, 0.0, np.minimum(POLYGON_OVERLAP * off / radius, POLYGON_OVERLAP))
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
    plain &= (turns > LEAST_BAND_TURN) & (np.abs(sine) / across > LEAST_CORNER_DEPTH * offset)
    plain &= np.minimum(size[:-1], size[1:]) > LEAST_CORNER_DEPTH * offset
    plain[MOST_CHUNK_SIDES - 1 :: MOST_CHUNK_SIDES] = False
    chunk = np.concatenate([[0], np.cumsum(~plain)])
    first = np.diff(chunk, prepend=-1) > 0
    # Each line gives its end, and the first of a polyline its start before that.
    places = np.arange(len(rows)) + np.cumsum(first)
    points = np.empty((len(rows) + int(first.sum()), 2))
    owner = np.empty(len(points), dtype=np.intp)
    points[places], owner[places] = end, chunk
    points[places[first] - 1], owner[places[first] - 1] = start[first], chunk[first]
    return shapely.linestrings(points, indices=owner)
