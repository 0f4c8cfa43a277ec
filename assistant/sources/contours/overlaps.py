"""Lines and arcs that lie in part on others: each stretch is followed once."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from assistant.base.diagnostics import Diagnostic, warning
from assistant.program.geometry import Vector
from assistant.sources.contours.curves import Arc, Curve, Line, Points, points_at_parts, vector
from assistant.sources.contours.flat import chord_counts

FARTHEST: Final = 1e7
"""mm from the origin, as of chains of curves."""
SHORTEST_PART: Final = 1e-4
LEAST_OVERLAP: Final = 2.0
"""Tolerances of a stretch that counts as an overlap: ends that run a little over are no more."""

OVERLAP = warning(
    "CT106",
    "{count} curves on layer {layer!r} lie in part on others, over {length:.2f} mm, which is"
    " followed once only",
    "trim them in the drawing; move one that is meant to be run twice to a layer of its own",
)
MOST_NEIGHBOURS: Final = 64
"""Neighbours of a curve that are looked at, on the mean: crowds of them are no outline."""
OVERLAP_BATCH: Final = 256
"""Curves whose neighbours are looked for at once."""

LineOrArc = Line | Arc
CoveredStretch = tuple[float, float, Vector, Vector]
"""From and to which part of a curve another one covers it, and the points there."""


def without_overlaps(
    curves: Sequence[Curve], tolerance: float
) -> tuple[list[Curve], list[Diagnostic]]:
    """The curves of a layer, of which shorter ones lose what lies within the tolerance on longer
    ones, and a finding about it. A copy of a whole curve stays.
    """
    near = _near_pairs(curves, tolerance)
    if not near:
        return [*curves], []
    covers: dict[int, list[CoveredStretch]] = {}
    lengths = [curve.length for curve in curves]
    for one, two in near:
        if abs(lengths[one] - lengths[two]) <= tolerance and _are_copies(
            curves[one], curves[two], tolerance
        ):
            continue
        longer, shorter = (one, two) if lengths[one] >= lengths[two] else (two, one)
        covers.setdefault(shorter, []).extend(
            _covered_stretches(curves[shorter], curves[longer], tolerance)  # type: ignore[arg-type]
        )
    made: list[Curve] = []
    count, length = 0, 0.0
    for i, curve in enumerate(curves):
        stretches = covers.get(i, [])
        if not stretches:
            made.append(curve)
            continue
        parts = _uncovered_parts(curve, stretches, tolerance)  # type: ignore[arg-type]
        count += 1
        length += lengths[i] - math.fsum(part.length for part in parts)
        made += parts
    if not count:
        return made, []
    return made, [OVERLAP(layer=curves[0].layer, count=count, length=length)]


def _are_copies(one: Curve, two: Curve, tolerance: float) -> bool:
    """True if two curves share both ends."""
    ends = one.start, one.end
    there = max(math.dist(ends[0], two.start), math.dist(ends[1], two.end))
    return min(there, max(math.dist(ends[0], two.end), math.dist(ends[1], two.start))) <= tolerance


def _near_pairs(curves: Sequence[Curve], tolerance: float) -> list[tuple[int, int]]:
    """Pairs of lines, and of arcs of one circle, that may lie on each other."""
    rows = [i for i, curve in enumerate(curves) if _is_measurable(curve)]
    if len(rows) < 2:
        return []
    import shapely

    pieces: list[LineOrArc] = [curves[i] for i in rows]  # type: ignore[misc]
    counts = chord_counts(pieces, 0.5 * tolerance) + 1
    owner = np.repeat(np.arange(len(rows)), counts)
    begins = np.cumsum(counts) - counts
    parts = (np.arange(len(owner)) - begins[owner]) / (counts[owner] - 1)
    points = points_at_parts(pieces, owner, parts)
    axes = np.sort(np.argsort(np.ptp(points, axis=0))[1:])  # seen along the axis of least extent
    lines = shapely.linestrings(points[:, axes], indices=owner)
    tree = shapely.STRtree(lines)
    found, seen = [np.empty((2, 0), dtype=np.intp)], 0
    for first in range(0, len(lines), OVERLAP_BATCH):
        some = lines[first : first + OVERLAP_BATCH]
        near = tree.query(some, predicate="dwithin", distance=tolerance)
        near[0] += first
        found.append(near[:, near[0] < near[1]])
        seen += near.shape[1]
        if seen > MOST_NEIGHBOURS * len(lines):
            break
    one, two = np.concatenate(found, axis=1)
    arcs = np.array([isinstance(curves[i], Arc) for i in rows])
    straight = ~arcs[one] & ~arcs[two]
    ends = np.array([[curves[i].start, curves[i].end] for i in rows])
    straight[straight] = _lie_along(ends[one[straight]], ends[two[straight]], tolerance)
    alike = straight | (arcs[one] & arcs[two])
    pairs = zip(one[alike].tolist(), two[alike].tolist(), strict=True)
    return [(rows[a], rows[b]) for a, b in pairs]


def _is_measurable(curve: Curve) -> bool:
    """True if it is a line or an arc of a believable size."""
    if not isinstance(curve, Line | Arc):
        return False
    size = max(map(abs, (*curve.start, *curve.end)))
    return size < FARTHEST and curve.length > SHORTEST_PART


def _lie_along(one: Points, two: Points, tolerance: float) -> NDArray[np.bool_]:
    """True for the lines (n, 2, 3) that share a stretch within the tolerance with others."""
    way = one[:, 1] - one[:, 0]
    length = np.linalg.norm(way, axis=1)
    along = way / length[:, None]
    arms = two - one[:, :1]
    places = np.einsum("nkc,nc->nk", arms, along)
    low, high = np.sort(np.clip(places, 0.0, length[:, None]), axis=1).T
    share = (np.stack([low, high], axis=1) - places[:, :1]) / np.where(
        np.abs(places[:, 1:] - places[:, :1]) > 1e-12, places[:, 1:] - places[:, :1], 1e-12
    )
    across = arms - places[..., None] * along[:, None]
    off = across[:, :1] + share[..., None] * (across[:, 1:] - across[:, :1])
    beside = np.linalg.norm(off, axis=2).max(axis=1) <= tolerance
    return np.asarray(beside & (high - low > LEAST_OVERLAP * tolerance))


def _covered_stretches(
    piece: LineOrArc, other: LineOrArc, tolerance: float
) -> list[CoveredStretch]:
    """Return the stretches of a piece that lie on another one of its kind."""
    if isinstance(piece, Line):
        way = np.subtract(piece.end, piece.start)
        size = float(way @ way)
        marks = [(float(np.subtract(p, piece.start) @ way) / size, p) for p in _piece_ends(other)]
        (low, first), (high, last) = sorted(marks)
        return _covered_stretch(low, high, first, last, piece, tolerance)
    assert isinstance(other, Arc)
    if not _are_on_one_circle(piece, other, tolerance):
        return []
    if other.closed:
        return [(0.0, 1.0, piece.start, piece.end)]
    forward = float(np.dot(piece.normal, other.normal)) > 0.0
    first, last = _piece_ends(other) if forward else reversed(_piece_ends(other))
    begin, sweep = _degrees_to(piece, first), piece.sweep
    found: list[CoveredStretch] = []
    for low in (begin, begin - 360.0):
        found += _covered_stretch(
            low / sweep, (low + other.sweep) / sweep, first, last, piece, tolerance
        )
    return found


def _covered_stretch(
    low: float, high: float, first: Vector, last: Vector, piece: LineOrArc, tolerance: float
) -> list[CoveredStretch]:
    if low <= 0.0:
        low, first = 0.0, piece.start
    if high >= 1.0:
        high, last = 1.0, piece.end
    if (high - low) * piece.length <= LEAST_OVERLAP * tolerance:
        return []
    return [(low, high, first, last)]


def _piece_ends(piece: LineOrArc) -> tuple[Vector, Vector]:
    return piece.start, piece.end


def _are_on_one_circle(a: Arc, b: Arc, tolerance: float) -> bool:
    apart = math.dist(a.centre, b.centre) + abs(a.radius - b.radius)
    return apart <= tolerance and abs(float(np.dot(a.normal, b.normal))) > 1.0 - 1e-6


def _degrees_to(arc: Arc, point: Vector) -> float:
    """Degrees about the normal from the start of an arc to a point of its circle, below 360."""
    u, v = np.subtract(arc.start, arc.centre), np.subtract(point, arc.centre)
    sine: Any = np.dot(np.cross(u, v), arc.normal)
    return math.degrees(math.atan2(float(sine), float(u @ v))) % 360.0


def _uncovered_parts(
    piece: LineOrArc, stretches: Sequence[CoveredStretch], tolerance: float
) -> list[LineOrArc]:
    """Return the parts of a piece between stretches that are longer than the tolerance."""
    made: list[LineOrArc] = []
    at, point = 0.0, piece.start
    for low, high, first, last in [*sorted(stretches), (1.0, 1.0, piece.end, piece.end)]:
        if (low - at) * piece.length > tolerance:
            made.append(_piece_part(piece, (at, low), (point, first)))
        if high > at:
            at, point = high, last
    return made


def _piece_part(
    piece: LineOrArc, parts: tuple[float, float], ends: tuple[Vector, Vector]
) -> LineOrArc:
    start, end = ends
    if isinstance(piece, Line):
        return replace(piece, start=start, end=end)
    via = vector(piece.at([0.5 * (parts[0] + parts[1])])[0])
    arc = Arc.through(start, via, end, piece.layer, piece.handle)
    return arc or Line(start, end, piece.layer, piece.handle)
