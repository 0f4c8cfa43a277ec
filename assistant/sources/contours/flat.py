"""Lines and arcs as they are seen along the tool: x and y of the view count, z is against it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from assistant.program.geometry import Vector
from assistant.sources.contours.curves import Arc, Line, arc_sweeps, points_at_parts, vector

Piece = Line | Arc
PlanePoints = NDArray[np.float64]
"""(n, 2) mm."""

HEIGHT_PARTS: Final = np.linspace(0.0, 1.0, 5)
"""Parts of a piece at which its height is looked at."""
CHORD_TOLERANCE: Final = 0.05
"""Part of the tolerance that chords of an arc may be off where polygons stand for contours."""


def height_range(pieces: Sequence[Piece]) -> tuple[float, float]:
    """The lowest and the highest place of the pieces, mm against the tool."""
    rows = np.repeat(np.arange(len(pieces)), len(HEIGHT_PARTS))
    found = points_at_parts(pieces, rows, np.tile(HEIGHT_PARTS, len(pieces)))[:, 2]
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
    """`chords` of each of the pieces."""
    counts = np.ones(len(pieces), dtype=np.intp)
    arcs = [piece for piece in pieces if isinstance(piece, Arc)]
    if arcs:
        round_ = np.array([isinstance(piece, Arc) for piece in pieces])
        step = 2.0 * np.arccos(np.maximum(1.0 - off / np.array([a.radius for a in arcs]), 0.5))
        counts[round_] = np.ceil(np.radians(arc_sweeps(arcs)) / step).astype(np.intp) + 1
    return counts


def chord_count(piece: Piece, off: float) -> int:
    """How many chords stand for a piece, at most `off` mm off."""
    if isinstance(piece, Line):
        return 1
    step = 2.0 * math.acos(max(1.0 - off / piece.radius, 0.5))
    return math.ceil(math.radians(piece.sweep) / step) + 1


def signed_area(outline: PlanePoints) -> float:
    """Of a closed polygon by the shoelace formula; below 0 if it runs clockwise."""
    x, y = (outline - outline[0]).T
    return 0.5 * float((x * np.roll(y, -1) - y * np.roll(x, -1)).sum())


def tangent(piece: Piece, part: float) -> tuple[float, float]:
    """The unit direction of a piece at a part of it, 0 to 1."""
    if isinstance(piece, Line):
        x, y = piece.end[0] - piece.start[0], piece.end[1] - piece.start[1]
    else:
        at = {0.0: piece.start, 1.0: piece.end}.get(part) or vector(piece.at([part])[0])
        ax, ay, az = (a - c for a, c in zip(at, piece.centre, strict=True))
        nx, ny, nz = piece.normal
        x, y = ny * az - nz * ay, nz * ax - nx * az
    size = math.hypot(x, y)
    return (x / size, y / size) if size > 0.0 else (0.0, 0.0)


def cut_at(piece: Piece, part: float) -> tuple[Piece, Piece]:
    """The piece in two, at a part of its length between 0 and 1."""
    return piece_between_parts(piece, 0.0, part), piece_between_parts(piece, part, 1.0)


def piece_between_parts(piece: Piece, first: float, last: float) -> Piece:
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
    before, after = cut_at(piece, part)
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
            found.append((count, other / part))
    return tuple(found)


def first_stretch(pieces: Sequence[Piece], length: float) -> tuple[Piece, ...]:
    """The first `length` mm of the pieces, which are longer."""
    made: list[Piece] = []
    for piece in pieces:
        own = piece.length
        if length <= own * (1.0 + 1e-9):
            part = min(length / own, 1.0)
            whole = part > 1.0 - 1e-9
            made.append(
                piece if whole and not piece.closed else piece_between_parts(piece, 0.0, part)
            )
            break
        made.append(piece)
        length -= own
    return tuple(made)


def reversed_pieces(pieces: Sequence[Piece]) -> tuple[Piece, ...]:
    return tuple(piece.reversed() for piece in reversed(pieces))
