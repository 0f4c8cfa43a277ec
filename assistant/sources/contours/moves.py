"""A contour as moves that controllers make: lines, and arcs of a via point and an end."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray

from assistant.program.geometry import Vector
from assistant.program.motion import Kind
from assistant.sources.contours.chaining import EXACT_MEETING, Contour
from assistant.sources.contours.curves import Arc, FreeCurve, Line, Points, circle_through, cross
from assistant.sources.contours.fitting import fit_curve
from assistant.sources.contours.thinning import (
    merge_short_pieces,
    midpoint,
    piece_with_ends,
    thin_pieces,
)

LEAST_CHORD: Final = 0.1
"""mm that start, via and end of a circular move have to be apart (RAPID MoveC)."""
LEAST_SWEEP: Final = 4.04
"""Degrees of one circular move, whose via and end are seen a quarter of it apart from its start;
RAPID's MoveC asks for 1 degree."""
WIDEST_ARC: Final = 240.0
"""Degrees of one circular move; ABB advises no more, and 360 cannot be said at all."""
FITTING_PART: Final = 0.5
"""Part of the tolerance that fitting a free curve may use."""
FLATTENING_PART: Final = 0.4
"""Part of the tolerance that writing a flat arc as a line may use."""


@dataclass(frozen=True, slots=True)
class Moves:
    """n rows of a path after its start.

    start: (3,). kinds: (n,) uint8. positions: (n, 3). leaving: (n, 3), unit direction in
    which the move of that row begins (for a VIA and its END: each half's). arriving: (n, 3),
    the direction in which it ends. deviation: mm that free curves are off at most, and lines
    whose points were left out. fitted: how many free curves there are. within: all of them are
    known to be in tolerance. dropped: how many points were left out.
    """

    start: Points
    kinds: NDArray[np.uint8]
    positions: Points
    leaving: Points
    arriving: Points
    deviation: float = 0.0
    fitted: int = 0
    within: bool = True
    dropped: int = 0

    def __len__(self) -> int:
        return len(self.positions)


def contour_moves(
    contour: Contour, tolerance: float, *, widest: float = WIDEST_ARC, spent: float = 0.0
) -> Moves:
    """The contour's moves, which begin and end in its own ends and leave no gap.

    tolerance: mm that free curves and flat arcs may be off. widest: degrees of an arc. spent: mm
    that the contour is off already, which `deviation` holds too.
    """
    given = as_pieces(contour, tolerance, spent)
    made: list[Line | Arc] = []
    for piece in given.pieces:
        made += possible_moves(piece, tolerance * FLATTENING_PART, widest)
    made = merge_short_pieces(made, tolerance, closed=contour.closed)
    start = made[0].start if made else contour.start
    found = (given.deviation + spent, given.fitted, given.within, given.dropped)
    return Moves(np.array(start), *move_columns(made), *found)


@dataclass(frozen=True, slots=True)
class ContourPieces:
    """Lines and arcs end to end. deviation, fitted, within, dropped: as of `Moves`."""

    pieces: tuple[Line | Arc, ...]
    deviation: float
    fitted: int
    within: bool
    dropped: int = 0


def as_pieces(contour: Contour, tolerance: float, spent: float = 0.0) -> ContourPieces:
    """A contour as lines and arcs without gaps; none if it cannot be followed in tolerance mm.

    Points of lines that the tolerance does not need are left out. spent: as of `moves`.
    """
    pieces: list[Line | Arc] = []
    drawn: list[bool] = []
    deviation, fitted, within = 0.0, 0, True
    for curve in contour.curves:
        if isinstance(curve, FreeCurve):
            result = fit_curve(curve, tolerance * FITTING_PART)
            pieces += result.pieces
            drawn += [False] * len(result.pieces)
            deviation, fitted = max(deviation, result.deviation), fitted + 1
            within = within and result.within
        else:
            pieces.append(curve)
            drawn.append(True)
    joined = _closed_gaps(pieces, contour.closed)
    sides = [ours for ours, made in zip(drawn, joined, strict=True) for _ in made]
    tight_ones = [piece for made in joined for piece in made]
    tidy = thin_pieces(tight_ones, sides, tolerance, spent, closed=contour.closed)
    return ContourPieces(tidy.pieces, max(deviation, tidy.deviation), fitted, within, tidy.dropped)


def close_gaps(pieces: Sequence[Line | Arc], closed: bool) -> list[Line | Arc]:
    """Every piece begins where the one before it ends, and the last one ends at the start.

    A gap is closed in its middle. Pieces that are left without length are dropped.
    """
    return [piece for made in _closed_gaps(pieces, closed) for piece in made]


def _closed_gaps(pieces: Sequence[Line | Arc], closed: bool) -> list[list[Line | Arc]]:
    """What each of the pieces becomes, as of `tight`."""
    if not pieces:
        return []
    joints = [_joint_of(one, two) for one, two in pairwise(pieces)]
    begin = _joint_of(pieces[-1], pieces[0]) if closed else pieces[0].start
    ends = [*joints, begin if closed else pieces[-1].end]
    made: list[list[Line | Arc]] = []
    for piece, end in zip(pieces, ends, strict=True):
        made.append(piece_with_ends(piece, begin, end))
        begin = end
    return made


def _joint_of(one: Line | Arc, two: Line | Arc) -> Vector:
    """Where one piece ends and the next begins."""
    if one.end == two.start or math.dist(one.end, two.start) <= EXACT_MEETING:
        return two.start
    return midpoint(one.end, two.start)


def possible_moves(piece: Line | Arc, flat: float, widest: float) -> list[Line | Arc]:
    """The piece itself, an arc in parts of at most `widest` degrees, or lines for it.

    Flat arcs, and arcs whose points are too near each other or to a line for a controller to
    make out the circle, become chords that are at most `flat` mm off.
    """
    if isinstance(piece, Line):
        return [piece]
    sweep, radius = piece.sweep, piece.radius
    count = max(math.ceil(sweep / widest - 1e-9), 2 if piece.closed else 1)
    part = math.radians(sweep / count)
    nearest = 2.0 * radius * min(math.sin(part / 4.0), math.sin(part / 2.0))
    sagitta = 2.0 * radius * math.sin(part / 4.0) ** 2
    narrow = math.degrees(part) < LEAST_SWEEP or nearest < LEAST_CHORD
    if sagitta > flat and not narrow and _is_distinct(piece, count):
        return _arc_parts(piece, count) if count > 1 else [piece]
    step = 2.0 * math.acos(max(1.0 - flat / radius, -1.0)) if radius > 0 else math.tau
    chords = max(math.ceil(math.radians(sweep) / step - 1e-9), 2 if piece.closed else 1)
    if chords == 1:
        return [Line(piece.start, piece.end, piece.layer, piece.handle)]
    points = [tuple(p) for p in piece.at(np.linspace(0.0, 1.0, chords + 1)).tolist()]
    points[0], points[-1] = piece.start, piece.end
    return [Line(a, b, piece.layer, piece.handle) for a, b in pairwise(points)]


def _is_distinct(arc: Arc, count: int) -> bool:
    """Whether via and end, as they stand, make out the circle."""
    if count > 1:
        return True
    start, via, end = arc.start, arc.via, arc.end
    apart = min(math.dist(start, via), math.dist(via, end), math.dist(end, start))
    return apart >= LEAST_CHORD and circle_through(start, via, end) is not None


def _arc_parts(arc: Arc, count: int) -> list[Line | Arc]:
    points = arc.at(np.linspace(0.0, 1.0, 2 * count + 1)).tolist()
    points[0], points[-1] = arc.start, arc.end
    return [
        replace(
            arc,
            start=tuple(points[2 * i]),
            via=tuple(points[2 * i + 1]),
            end=tuple(points[2 * i + 2]),
            closed=False,
        )
        for i in range(count)
    ]


def move_columns(
    pieces: Sequence[Line | Arc],
) -> tuple[NDArray[np.uint8], Points, Points, Points]:
    """Kinds, positions, and the directions in which each row's move begins and ends."""
    arcs = np.array([isinstance(p, Arc) for p in pieces], dtype=bool)
    rows = np.where(arcs, 2, 1)
    n = int(rows.sum())
    kinds = np.full(n, Kind.LINEAR, dtype=np.uint8)
    positions, leaving, arriving = (np.empty((n, 3)) for _ in range(3))
    if not n:
        return kinds, positions, leaving, arriving
    last = np.cumsum(rows) - 1
    starts = np.array([p.start for p in pieces])
    ends = np.array([p.end for p in pieces])
    chords = _unit_vector(ends - starts)
    positions[last], leaving[last], arriving[last] = ends, chords, chords
    if arcs.any():
        end, via = last[arcs], last[arcs] - 1
        middle, centre, normal = (
            np.array([getattr(p, name) for p in pieces if isinstance(p, Arc)])
            for name in ("via", "centre", "normal")
        )
        kinds[end], kinds[via] = Kind.END, Kind.VIA
        positions[via] = middle
        leaving[via] = _unit_vector(cross(normal, starts[arcs] - centre))
        leaving[end] = arriving[via] = _unit_vector(cross(normal, middle - centre))
        arriving[end] = _unit_vector(cross(normal, ends[arcs] - centre))
    return kinds, positions, leaving, arriving


def _unit_vector(v: Points) -> Points:
    return np.asarray(v / np.linalg.norm(v, axis=1, keepdims=True))
