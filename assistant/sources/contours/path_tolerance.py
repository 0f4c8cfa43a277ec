"""Simplification and corner rounding of paths within the tolerance of a process.

CAD systems write curves as hundreds of sides, round coordinates and repeat points. Each side is a
move, and a corner between sides that are shorter than its rounding is a stop. So points are left
out if the polyline without them is off by less than a part of the tolerance, and what is shorter
than twice that becomes one point.

`rounding_radii` rounds the corners of paths that state no blend: no stop at a target, and the path
is kept within the tolerance.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import groupby, pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray

from assistant.base.arrays import Floats, Truths
from assistant.base.data_classes import dataclass
from assistant.program.geometry import Vector
from assistant.program.motion import Kind
from assistant.sources.contours.curves import Arc, Line, Points, vector

THINNING_PART: Final = 0.2
"""Part of the tolerance that leaving out points may use."""
_SECOND_THINNING_PART: Final = 0.3
"""The same of a way beside a contour, with what the contour itself has used."""
_SHORT_SIDE: Final = 20.0
"""Tolerances that a side is long at most for its ends to be left out: longer ones were drawn."""
_LARGE_SWEEP: Final = 180.0
"""Degrees of an arc over which moving an end by a little moves its centre by much."""
_LEAST_MOVE: Final = 2e-4
"""mm of a move: twice the last decimal that is printed."""

Piece = Line | Arc


@dataclass(frozen=True, slots=True)
class ThinnedPieces:
    """pieces: end to end. dropped: points that are left out. deviation: mm that they are off."""

    pieces: tuple[Piece, ...]
    dropped: int = 0
    deviation: float = 0.0


def shortest_piece(tolerance: float) -> float:
    """Length in mm up to which a piece is one point."""
    return max(2.0 * THINNING_PART * tolerance, _LEAST_MOVE)


def thin_pieces(
    pieces: Sequence[Piece],
    drawn: Sequence[bool],
    tolerance: float,
    spent: float = 0.0,
    *,
    closed: bool,
) -> ThinnedPieces:
    """Pieces with fewer sides, each point of the given ones within a part of the tolerance.

    pieces: end to end. drawn: which of them are sides of a drawing. spent: mm that they are off
    already. Ends of an open contour, and joints with other pieces, stay where they are.
    """
    # A path beside a contour is off already: both must stay within a common part.
    allowed = min(THINNING_PART * tolerance, _SECOND_THINNING_PART * tolerance - spent)
    if not pieces:
        return ThinnedPieces(())
    made: list[Piece] = []
    most, dropped = 0.0, 0
    sides = [isinstance(p, Line) and ours for p, ours in zip(pieces, drawn, strict=True)]
    runs = runs_of_kind(sides)
    # A closed contour of sides alone has no joint that must stay.
    around = closed and len(runs) == 1
    spare = _spare_starts(pieces, allowed, tolerance)
    for first, last in runs:
        if not (sides[first] and spare[first + 1 : last].any() and allowed > 0.0):
            made += pieces[first:last]
            continue
        points = np.array([pieces[first].start, *(piece.end for piece in pieces[first:last])])
        kept, off = needed_points(points, allowed, _SHORT_SIDE * tolerance, around=around)
        if kept.all():
            made += pieces[first:last]
            continue
        most, dropped = max(most, off), dropped + int((~kept).sum())
        rows = np.flatnonzero(kept).tolist()
        for a, b in pairwise(rows):
            given = pieces[first + a]
            end = pieces[first + b - 1].end
            made.append(given if b == a + 1 else replace(given, end=end))
    joined = merge_short_pieces(made, tolerance, closed=closed)
    return ThinnedPieces(tuple(joined), dropped + len(made) - len(joined), most)


def runs_of_kind(sides: Sequence[bool]) -> list[tuple[int, int]]:
    """First and one after the last of pieces of one kind that follow each other."""
    bounds = [i for i in range(1, len(sides)) if sides[i] != sides[i - 1]]
    return list(pairwise([0, *bounds, len(sides)])) if sides else []


def needed_points(
    points: Points, allowed: float, short: float, *, around: bool = False
) -> tuple[Truths, float]:
    """Which points (n, 3) of a polyline stay, and how far off the others are at most.

    Douglas and Peucker, all intervals of a round at once. It starts from the points that have to
    stay: those between sides longer than `short` mm, and those more than `allowed` mm off the line
    between their neighbours. around: the last point is the first.
    """
    n = len(points)
    kept = np.ones(n, dtype=np.bool_)
    kept[1:-1] = ~_spare_alone(points, allowed, short)
    # Both ends are one point: a third one keeps the ring from collapsing.
    if around and n > 3:
        far = np.linalg.norm(points - points[0], axis=1)
        kept[int(far.argmax())] = True
    most = 0.0
    while True:
        ends = np.flatnonzero(kept)
        inner = np.flatnonzero(~kept)
        if not inner.size:
            break
        place = np.searchsorted(ends, inner) - 1
        off = _segment_distances(points[inner], points[ends[place]], points[ends[place + 1]])
        firsts = np.flatnonzero(np.diff(place, prepend=-1))
        worst = np.maximum.reduceat(off, firsts)
        counts = np.diff(np.append(firsts, len(inner)))
        # All intervals that are off are split at once, each at its farthest point.
        split = np.repeat(worst > allowed, counts)
        if not split.any():
            most = float(worst.max())
            break
        farthest = np.flatnonzero(split & (off == np.repeat(worst, counts)))
        # Equally far points of an interval would split it more than once.
        _, one_each = np.unique(place[farthest], return_index=True)
        kept[inner[farthest[one_each]]] = True
    return kept, most


def _spare_starts(pieces: Sequence[Piece], allowed: float, tolerance: float) -> Truths:
    """Which starts (n,) of pieces may be left out if both pieces are sides."""
    points = np.array([*(piece.start for piece in pieces), pieces[-1].end])
    return np.append(
        np.zeros(1, dtype=np.bool_), _spare_alone(points, allowed, _SHORT_SIDE * tolerance)
    )


def _spare_alone(points: Points, allowed: float, most: float) -> Truths:
    """Which inner points (n - 2,) of a polyline (n, 3) may each be left out."""
    short = np.linalg.norm(np.diff(points, axis=0), axis=1) < most
    near = _segment_distances(points[1:-1], points[:-2], points[2:]) <= allowed
    return np.asarray((short[:-1] | short[1:]) & near)


def _segment_distances(points: Points, start: Points, end: Points) -> Floats:
    """Distances (n,) of points from segments, each from its own."""
    way = end - start
    size = np.maximum((way**2).sum(axis=1), 1e-300)
    share = np.clip(((points - start) * way).sum(axis=1) / size, 0.0, 1.0)
    return np.asarray(np.linalg.norm(points - start - share[:, None] * way, axis=1))


def merge_short_pieces(pieces: Sequence[Piece], tolerance: float, *, closed: bool) -> list[Piece]:
    """Pieces without those that are too short to be a move: their neighbours meet instead.

    A stretch of short pieces becomes one point, its middle, or lines that are long enough. The
    ends of an open contour stay; a closed one starts at the same piece.
    """
    lengths = [piece.length for piece in pieces]
    least = shortest_piece(tolerance)
    if max(lengths, default=0.0) < least:
        least = _LEAST_MOVE  # the whole contour is as small
    small = [length < least for length in lengths]
    if not any(small):
        return list(pieces)
    # A closed contour begins at a piece that stays, so that no stretch of short ones is cut.
    first = small.index(False) if closed and not all(small) else 0
    carriers: list[Piece] = []
    ends: list[Vector] = []
    turned = [*pieces[first:], *pieces[:first]]
    wanted = 0  # the carrier that the contour starts with
    at = 0
    for is_small, group in groupby([*small[first:], *small[:first]]):
        count = len(list(group))
        stretch, at = turned[at : at + count], at + count
        if len(pieces) - first in range(at - count, at):
            wanted = len(carriers) + (0 if is_small else len(pieces) - first - (at - count))
        if not is_small:
            carriers += stretch
            ends += (piece.end for piece in stretch)
        elif math.fsum(piece.length for piece in stretch) < least:
            begin, end = stretch[0].start, stretch[-1].end
            if carriers:
                # At an open end the last point stays, elsewhere both neighbours meet in the middle.
                open_end = at == len(turned) and not closed
                ends[-1] = end if open_end else midpoint(begin, end)
        else:
            chords = _long_chords(stretch, least)
            carriers += chords
            ends += (piece.end for piece in chords)
    if not carriers:
        start, end = pieces[0].start, pieces[-1].end
        alone = Line(start, end, pieces[0].layer, pieces[0].handle)
        return [alone] if not closed and alone.length >= _LEAST_MOVE else []
    begin = ends[-1] if closed else pieces[0].start
    made: list[list[Piece]] = []
    for carrier, end in zip(carriers, ends, strict=True):
        made.append(piece_with_ends(carrier, begin, end))
        begin = end
    wanted %= len(made)
    return [piece for moved in (*made[wanted:], *made[:wanted]) for piece in moved]


def _long_chords(stretch: Sequence[Piece], least: float) -> list[Piece]:
    """Lines of at least a length through short pieces, to the end of the last."""
    points = [stretch[0].start]
    for piece in stretch:
        if math.dist(points[-1], piece.end) >= least:
            points.append(piece.end)
    if len(points) == 1:
        return []
    # The last chord takes what is left over.
    points[-1] = stretch[-1].end
    like = stretch[0]
    return [Line(a, b, like.layer, like.handle) for a, b in pairwise(points)]


def piece_with_ends(piece: Piece, start: Vector, end: Vector) -> list[Piece]:
    """The piece with its ends moved a little; none if it is left without length.

    The middle of an arc moves by the mean of its ends, so that it keeps its form.
    """
    if piece.closed or (piece.start == start and piece.end == end):
        return [piece]
    if isinstance(piece, Arc):
        if start == end:
            # Both ends have become one point.
            return _circle_of_arc(piece, start)
        if piece.sweep > _LARGE_SWEEP:
            one, half, two = (vector(p) for p in piece.at([0.25, 0.5, 0.75]))
            return [
                *piece_with_ends(replace(piece, via=one, end=half), start, half),
                *piece_with_ends(replace(piece, start=half, via=two), half, end),
            ]
        (x, y, z), one, two = piece.via, piece.start, piece.end
        via = (
            x + 0.5 * (start[0] - one[0] + end[0] - two[0]),
            y + 0.5 * (start[1] - one[1] + end[1] - two[1]),
            z + 0.5 * (start[2] - one[2] + end[2] - two[2]),
        )
        moved = Arc.through(start, via, end, piece.layer, piece.handle)
        if moved is not None:
            return [moved]
    return [] if start == end else [Line(start, end, piece.layer, piece.handle)]


def _circle_of_arc(arc: Arc, start: Vector) -> list[Piece]:
    """The circle of an arc whose ends are one point; nothing if it was short."""
    if arc.sweep <= _LARGE_SWEEP:
        return []
    arm, normal = np.subtract(start, arc.centre), np.asarray(arc.normal)
    arm = arm - (arm @ normal) * normal
    begin = np.asarray(arc.centre) + arm * (arc.radius / float(np.linalg.norm(arm)))
    return [Arc.about(arc.centre, arc.normal, begin, 360.0, arc.layer, arc.handle)]


def midpoint(a: Vector, b: Vector) -> Vector:
    return ((a[0] + b[0]) / 2.0, (a[1] + b[1]) / 2.0, (a[2] + b[2]) / 2.0)


ROUNDING_RADII: Final = np.array([0.01, 0.02, 0.05, 0.1, 0.3, 1.0, 5.0, 10.0, 20.0, 50.0])
"""mm; a few for all rows, as each is a declaration. Controllers have many of them built in."""


def rounding_radii(
    positions: Floats, kinds: NDArray[np.uint8], whole: Truths, tolerance: float
) -> Floats:
    """Return (n,) the largest radius in mm of each corner, one of `ROUNDING_RADII` or 0 for a stop.

    positions: (n, 3) mm. kinds: (n,). whole: (n - 1,), whether rows i and i + 1 are in one frame
    with one tool. The rounded path lies between the corner and the chord between the points where
    it leaves and returns, which is r·sin(turn / 2) off the corner: that stays within the tolerance.
    So does half of r²/R where an arc of radius R runs into the corner. No corner takes more than
    half of the distance to a neighbour. Joint moves count as lines. The first and the last row, and
    those without a path on a side, are stops.
    """
    n = len(positions)
    found = np.zeros(n)
    if n < 3:
        return found
    step = np.diff(positions, axis=0)
    way = np.sqrt(np.einsum("ij,ij->i", step, step))
    inner = np.where(whole, way, 0.0)
    # Rows in one place have no direction.
    leaving = arriving = step / np.where(way > 0.0, way, 1.0)[:, None]
    bend = np.full(n - 1, np.inf)
    via = np.flatnonzero(kinds[:-1] == Kind.VIA)
    via = via[via > 0]
    if via.size:
        # The arc leaves its start and reaches its end along its tangents, not along the chords.
        leaving, arriving = leaving.copy(), arriving.copy()
        start, middle, end = (positions[via + k] for k in (-1, 0, 1))
        leaving[via - 1], bend[via - 1] = _arc_tangents(start, middle, end)
        back, bend[via] = _arc_tangents(end, middle, start)
        arriving[via] = -back
    cosine = np.einsum("ij,ij->i", arriving[:-1], leaving[1:])
    half = np.sqrt(np.clip((1.0 - cosine) / 2.0, 0.0, 1.0))  # sin(turn / 2)
    with np.errstate(divide="ignore"):
        most = np.minimum(tolerance / half, np.minimum(inner[:-1], inner[1:]) / 2.0)
    most = np.minimum(most, np.sqrt(2.0 * tolerance * np.minimum(bend[:-1], bend[1:])))
    # A size that fits but for rounding counts.
    place = np.searchsorted(ROUNDING_RADII, most * (1.0 + 1e-9), "right")
    found[1:-1] = np.where(place > 0, ROUNDING_RADII[np.maximum(place - 1, 0)], 0.0)
    found[kinds == Kind.VIA] = 0.0  # a point on the way, no corner
    return found


def _arc_tangents(start: Floats, via: Floats, end: Floats) -> tuple[Floats, Floats]:
    """Unit directions (m, 3) in which arcs leave their start, and their radii (m,).

    An inversion about the start makes a line of the circle, which runs along the tangent. Floats
    on one line are an arc without bend; two that coincide have no direction.
    """
    to_via, to_end = via - start, end - start
    with np.errstate(divide="ignore", invalid="ignore"):
        # Points that coincide give NaN, which becomes no direction.
        one = to_via / (to_via**2).sum(axis=1, keepdims=True)
        two = to_end / (to_end**2).sum(axis=1, keepdims=True)
        size = np.linalg.norm(one - two, axis=1, keepdims=True)
        direction = np.nan_to_num((one - two) / size)
        sides = np.linalg.norm(np.stack([to_via, to_end, end - via]), axis=2).prod(axis=0)
        area = np.linalg.norm(np.cross(to_via, to_end), axis=1)
        radius = np.where(area > 0.0, sides / (2.0 * area), np.inf)
    return direction, radius
