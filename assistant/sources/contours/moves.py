"""A contour as moves of a controller: lines, and arcs of a via point and an end; in columns.

With it the orientation of the tool along the contour, and the speeds. Positions of speed changes
are mm of path from the start. A move is divided by a point on it, which leaves the path as it is:
an arc becomes two arcs of its circle.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray

from assistant.base import rotations
from assistant.base.arrays import Floats, Rows, Truths
from assistant.base.data_classes import dataclass
from assistant.program.geometry import Vector
from assistant.program.motion import Kind, Speed
from assistant.sources.contours.biarcs import fit_curve
from assistant.sources.contours.chains import EXACT_MEETING, Contour
from assistant.sources.contours.chord_arcs import arcs_of_chords
from assistant.sources.contours.curves import (
    Arc,
    FreeCurve,
    Line,
    Points,
    circle_through,
    cross,
    vector,
)
from assistant.sources.contours.path_tolerance import (
    THINNING_PART,
    merge_short_pieces,
    midpoint,
    piece_with_ends,
    runs_of_kind,
    thin_pieces,
)
from assistant.sources.process import SpeedProfile

_LEAST_CHORD: Final = 0.1
"""mm that start, via and end of a circular move have to be apart (RAPID MoveC)."""
_LEAST_SWEEP: Final = 4.04
"""Degrees of one circular move, whose via and end are seen a quarter of it apart from its start;
RAPID's MoveC asks for 1 degree."""
WIDEST_ARC: Final = 240.0
"""Degrees of one circular move; ABB advises no more, and 360 cannot be expressed."""
_FITTING_PART: Final = 0.5
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
        made += _possible_moves(piece, tolerance * FLATTENING_PART, widest)
    # A divided piece may be too short for a move.
    made = merge_short_pieces(made, tolerance, closed=contour.closed)
    start = made[0].start if made else contour.start
    found = (given.deviation + spent, given.fitted, given.within, given.dropped)
    return Moves(np.array(start), *_move_columns(made), *found)


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
            result = fit_curve(curve, tolerance * _FITTING_PART)
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
    rounded = _arcs_for_chords(tight_ones, sides, tolerance, spent, closed=contour.closed)
    tight_ones, sides = list(rounded.pieces), rounded.drawn
    # Only sides of the drawing are thinned: fitted pieces are as few as the tolerance allows.
    tidy = thin_pieces(tight_ones, sides, tolerance, spent, closed=contour.closed)
    deviation = max(deviation, tidy.deviation, rounded.deviation)
    dropped = tidy.dropped + rounded.dropped
    return ContourPieces(tidy.pieces, deviation, fitted, within, dropped)


@dataclass(frozen=True, slots=True)
class _RoundedPieces:
    """drawn: which of the pieces are sides of the drawing. dropped: corners that are left out."""

    pieces: Sequence[Line | Arc]
    drawn: list[bool]
    dropped: int = 0
    deviation: float = 0.0


def _arcs_for_chords(
    pieces: Sequence[Line | Arc],
    drawn: list[bool],
    tolerance: float,
    spent: float,
    *,
    closed: bool,
) -> _RoundedPieces:
    """Pieces with arcs in the place of sides of the drawing that are chords of these."""
    side = tolerance * _FITTING_PART - spent
    corner = min(tolerance * THINNING_PART, side)

    def movable(arc: Arc) -> bool:
        made = _possible_moves(arc, tolerance * FLATTENING_PART, WIDEST_ARC)
        return isinstance(made[0], Arc)

    sides = [isinstance(one, Line) and ours for one, ours in zip(pieces, drawn, strict=True)]
    runs = runs_of_kind(sides)
    made: list[Line | Arc] = []
    ours: list[bool] = []
    dropped, deviation = 0, 0.0
    for first, last in runs:
        at = first
        if sides[first]:
            points = np.array([pieces[first].start, *(one.end for one in pieces[first:last])])
            around = closed and len(runs) == 1
            for found in arcs_of_chords(points, corner, side, around=around, movable=movable):
                made += pieces[at : first + found.first]
                ours += drawn[at : first + found.first]
                like = pieces[first + found.first]
                made.append(replace(found.arc, layer=like.layer, handle=like.handle))
                ours.append(False)
                at = first + found.last
                dropped += found.last - found.first - 1
                deviation = max(deviation, found.deviation)
        made += pieces[at:last]
        ours += drawn[at:last]
    return _RoundedPieces(made, ours, dropped, deviation)


def _closed_gaps(pieces: Sequence[Line | Arc], closed: bool) -> list[list[Line | Arc]]:
    """Return the parts that replace each of the pieces, none for one that is left without length.

    Every piece begins where the one before it ends, and the last one ends at the start. A gap is
    closed in its middle.
    """
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
    """Return the point where one piece ends and the next begins."""
    if one.end == two.start or math.dist(one.end, two.start) <= EXACT_MEETING:
        return two.start
    return midpoint(one.end, two.start)


def _possible_moves(piece: Line | Arc, flat: float, widest: float) -> list[Line | Arc]:
    """The piece itself, an arc in parts of at most `widest` degrees, or lines for it.

    Flat arcs, and arcs whose points are too near each other or to a line for a controller to
    make out the circle, become chords that are at most `flat` mm off.
    """
    if isinstance(piece, Line):
        return [piece]
    sweep, radius = piece.sweep, piece.radius
    # A controller cannot make a full circle with one move.
    count = max(math.ceil(sweep / widest - 1e-9), 2 if piece.closed else 1)
    part = math.radians(sweep / count)
    # The shortest chord between start, via and end.
    nearest = 2.0 * radius * min(math.sin(part / 4.0), math.sin(part / 2.0))
    sagitta = 2.0 * radius * math.sin(part / 4.0) ** 2
    narrow = math.degrees(part) < _LEAST_SWEEP or nearest < _LEAST_CHORD
    if sagitta > flat and not narrow and _is_distinct(piece, count):
        return _arc_parts(piece, count) if count > 1 else [piece]
    # Chords that are `flat` off; the clamp is for arcs that are smaller than that.
    step = 2.0 * math.acos(max(1.0 - flat / radius, -1.0)) if radius > 0 else math.tau
    chords = max(math.ceil(math.radians(sweep) / step - 1e-9), 2 if piece.closed else 1)
    if chords == 1:
        return [Line(piece.start, piece.end, piece.layer, piece.handle)]
    points = [tuple(p) for p in piece.at(np.linspace(0.0, 1.0, chords + 1)).tolist()]
    # Computed ends differ by rounding: the neighbours begin at the stated ones.
    points[0], points[-1] = piece.start, piece.end
    return [Line(a, b, piece.layer, piece.handle) for a, b in pairwise(points)]


def _is_distinct(arc: Arc, count: int) -> bool:
    """True if via and end, as they are, determine the circle."""
    if count > 1:
        return True
    start, via, end = arc.start, arc.via, arc.end
    apart = min(math.dist(start, via), math.dist(via, end), math.dist(end, start))
    return apart >= _LEAST_CHORD and circle_through(start, via, end) is not None


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


def _move_columns(
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
    # Lines first; the rows of arcs are replaced below.
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


_SMOOTH_CORNER: Final = 15.0
"""Degrees of a corner up to which the tool turns on while it moves; over it, it stops."""
_LEAST_PROJECTION: Final = 1e-6
"""Length of a projected unit vector below which it has no direction."""


def level_x_axis(direction: Vector) -> Points:
    """The tool's x axis that is as near to the frame's +X as `direction`, its z axis, allows.

    The frame's +Y takes the place of +X where the tool points along X.
    """
    z = np.asarray(direction, dtype=np.float64)
    for axis in (np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0])):
        x = axis - (axis @ z) * z
        length = float(np.linalg.norm(x))
        if length > _LEAST_PROJECTION:
            return np.asarray(x / length)
    raise ValueError(f"{direction} is no direction")


def facing_quaternions(direction: Vector, x: Points) -> Points:
    """Canonical quaternions (n, 4) of tools with z along a direction and x axes (n, 3)."""
    z = np.broadcast_to(np.asarray(direction, dtype=np.float64), x.shape)
    return rotations.from_matrix(np.stack([x, np.cross(z, x), z], axis=-1))


def degrees_turned(quaternions: Points, direction: Vector) -> float:
    """Degrees about a direction that tools (n, 4) turn from the first to the last, in all.

    From row to row they turn the shorter way; to the right about the direction counts up.
    """
    x = level_x_axis(direction)
    y = np.cross(np.asarray(direction, dtype=np.float64), x)
    axes = rotations.rotate(quaternions, np.broadcast_to([1.0, 0.0, 0.0], (len(quaternions), 3)))
    # Unwrapped, so that turns of more than half a circle in all are counted.
    angles = np.unwrap(np.arctan2(axes @ y, axes @ x))
    return float(np.degrees(angles[-1] - angles[0]))


def x_axes_along(moves: Moves, direction: Vector) -> tuple[Points, Points, Rows]:
    """X axes that follow the contour: at its start (3,), at the rows, and where to turn.

    The rows' axes are (m, 3) for the rows that the third result, (m,), lists: a row that
    comes twice is a corner, at which the tool stops and then turns. At a smooth joint the
    axis is the mean of both sides. Where the contour runs along the tool, the last axis
    before it holds on.
    """
    n = len(moves)
    z = np.asarray(direction, dtype=np.float64)
    arriving, leaving = (_projected_units(v, z) for v in (moves.arriving, moves.leaving))
    # NaN where the contour runs along the tool: the last axis before is held.
    both = np.stack([leaving, arriving], axis=1).reshape(-1, 3)  # in order of the way
    both = _filled_forward(both, level_x_axis(direction))
    leaving, arriving = both[0::2], both[1::2]
    after = np.concatenate([leaving[1:], arriving[-1:]])
    # The arc tangent is exact for small turns, where an arc cosine is not.
    turn = np.degrees(
        np.arctan2(
            np.linalg.norm(np.cross(arriving, after), axis=1), (arriving * after).sum(axis=1)
        )
    )
    corner = (turn > _SMOOTH_CORNER) & (moves.kinds != Kind.VIA)
    mean = _unit_normals(np.where(corner[:, None], arriving, arriving + after))
    rows = np.repeat(np.arange(n), np.where(corner, 2, 1))
    second = np.flatnonzero(rows[1:] == rows[:-1]) + 1
    axes = mean[rows]
    # The second row of a corner has the axis of what follows.
    axes[second] = after[rows[second]]
    return leaving[0], axes, rows


def _projected_units(v: Points, z: Points) -> Points:
    """Unit vectors of v (n, 3) seen along z; NaN where v runs along it."""
    flat = v - (v @ z)[:, None] * z
    size = np.linalg.norm(flat, axis=1, keepdims=True)
    known = size > _LEAST_PROJECTION
    return np.asarray(np.where(known, flat / np.where(known, size, 1.0), np.nan))


def _filled_forward(v: Points, otherwise: Points) -> Points:
    """Rows of NaN filled with the row before; the first ones with the first known, if any."""
    known = np.flatnonzero(~np.isnan(v[:, 0]))
    if not known.size:
        return np.broadcast_to(otherwise, v.shape)
    place = np.searchsorted(known, np.arange(len(v)), "right") - 1
    return np.asarray(v[known[np.maximum(place, 0)]])


def _unit_normals(v: Points) -> Points:
    return np.asarray(v / np.linalg.norm(v, axis=1, keepdims=True))


_SHORTEST_SPEED_PART: Final = 0.5
"""mm of a part of a move; a place that is nearer to the end of one is that end."""
_SMALLEST_DIVIDED_RADIUS: Final = 1.0
"""mm of radius of an arc that is divided."""
_CLOSED_DISTANCE: Final = 1e-6
"""mm between the ends of a contour that is closed."""
_STRAIGHT_ARC: Final = 1e-10
"""Largest product of two chords of an arc and the sine of their turn, in squares of the longer
chord, of three points on a line."""

_LineOrArc = Line | Arc


@dataclass(frozen=True, slots=True)
class MovesWithSpeeds:
    """rows: the moves. speeds: of each row, rows of `table`. divided: rows that end where a move
    was divided. corners: how many of them are gone round at the speed of corners.
    """

    rows: Moves
    speeds: NDArray[np.int32]
    table: tuple[Speed | None, ...]
    divided: Truths
    corners: int = 0


def with_speeds(
    rows: Moves, pace: SpeedProfile, places: Sequence[float] = (), flat: float = 0.0
) -> MovesWithSpeeds:
    """Moves with their speeds, None for the layer's own.

    places: mm from the start at which moves are divided beside that. flat: mm that a part of an
    arc may be off when it is written as a line.
    """
    n = len(rows)
    if pace.even and not places:
        return MovesWithSpeeds(rows, np.zeros(n, np.int32), (None,), np.zeros(n, np.bool_))
    pieces = _pieces_of_moves(rows)
    ends = np.cumsum([0.0, *(piece.length for piece in pieces)])
    spans, corners = _speed_spans(rows, pieces, ends, pace)
    cuts = [*places, *(place for low, high, _ in spans for place in (low, high))]
    made: list[_LineOrArc] = []
    joints: list[bool] = []
    speeds: list[Speed | None] = []
    for piece, (low, high) in zip(pieces, pairwise(ends.tolist()), strict=True):
        parts = _divided_piece(piece, low, high, cuts, flat)
        at = low
        for i, part in enumerate(parts):
            middle = at + part.length / 2.0
            at += part.length
            made.append(part)
            joints.append(i < len(parts) - 1)
            speeds.append(_slowest_at(spans, middle))
    table = tuple(dict.fromkeys(speeds))
    count = [2 if isinstance(part, Arc) else 1 for part in made]
    of = np.repeat([table.index(speed) for speed in speeds], count).astype(np.int32)
    kinds, positions, leaving, arriving = _move_columns(made)
    divided = np.repeat(joints, count) & (kinds != Kind.VIA)
    moved = replace(rows, kinds=kinds, positions=positions, leaving=leaving, arriving=arriving)
    return MovesWithSpeeds(moved, of, table, divided, corners)


def _pieces_of_moves(rows: Moves) -> list[_LineOrArc]:
    """The lines and arcs that rows are; an arc through points on one line is two lines."""
    pieces: list[_LineOrArc] = []
    here = vector(rows.start)
    places = [vector(p) for p in rows.positions]
    for i, (place, kind) in enumerate(zip(places, rows.kinds.tolist(), strict=True)):
        if kind == Kind.VIA:
            continue
        arc = Arc.through(here, places[i - 1], place) if kind == Kind.END else None
        if arc is not None:
            pieces.append(arc)
        elif kind == Kind.END:
            pieces += [Line(here, places[i - 1]), Line(places[i - 1], place)]
        else:
            pieces.append(Line(here, place))
        here = place
    return pieces


def move_lengths(start: Points, positions: Points, kinds: NDArray[np.uint8]) -> Floats:
    """Length (n,) of each row in mm; that of an arc is at its END.

    An arc turns by twice the turn between its chords (the inscribed angle). Without a turn its
    length is that of the chords.
    """
    places = np.vstack([start, positions])
    steps = np.linalg.norm(np.diff(places, axis=0), axis=1)
    end = np.flatnonzero(kinds == Kind.END)
    one, two = places[end] - places[end - 1], places[end + 1] - places[end]
    sine, cosine = np.linalg.norm(cross(one, two), axis=1), (one * two).sum(axis=1)
    half, chord = np.arctan2(sine, cosine), np.linalg.norm(one + two, axis=1)
    longest = np.maximum(steps[end - 1], steps[end])
    # Points on a line have no circle: their arc is the way through its three points.
    bent = sine > _STRAIGHT_ARC * longest**2
    around = chord * half / np.sin(np.where(bent, half, 1.0))
    steps[end] = np.where(bent, around, steps[end - 1] + steps[end])
    # The row of the via leads nowhere: the move ends at the END.
    steps[end - 1] = 0.0
    return np.asarray(steps)


def _speed_spans(
    rows: Moves, pieces: Sequence[_LineOrArc], ends: Floats, pace: SpeedProfile
) -> tuple[list[tuple[float, float, Speed]], int]:
    """From where to where, in mm, which speed holds at most; and how many corners there are."""
    total = float(ends[-1])
    spans: list[tuple[float, float, Speed]] = []
    if pace.start is not None:
        spans.append((0.0, min(pace.start_length, total), pace.start))
    if pace.end is not None:
        spans.append((max(total - pace.end_length, 0.0), total, pace.end))
    corners = 0
    if (slow := pace.corner) is not None:
        for low, high in _corner_spans(rows, pieces, ends, pace):
            corners += 1
            around = _spans_on_path(low - pace.length, high + pace.length, total, rows)
            spans += ((first, last, slow) for first, last in around)
    return spans, corners


def _spans_on_path(
    low: float, high: float, total: float, rows: Moves
) -> Iterator[tuple[float, float]]:
    """Yield the parts of a stretch that are on the path; on a closed contour also the part across
    its start.
    """
    yield max(low, 0.0), min(high, total)
    if _is_closed(rows):
        if low < 0.0:
            yield max(total + low, 0.0), total
        if high > total:
            yield 0.0, min(high - total, total)


def _is_closed(rows: Moves) -> bool:
    return bool(np.linalg.norm(rows.positions[-1] - rows.start) < _CLOSED_DISTANCE)


def _corner_spans(
    rows: Moves, pieces: Sequence[_LineOrArc], ends: Floats, pace: SpeedProfile
) -> Iterator[tuple[float, float]]:
    """Yield the spans of corners; a corner at the start of a closed contour is at 0."""
    if not pieces:
        return
    # A corner of exactly the stated angle counts, whatever rounding does.
    angle = math.cos(math.radians(pace.angle)) + 1e-9
    last = rows.kinds != Kind.VIA
    first = np.concatenate([[True], last[:-1]])
    leaving, arriving = rows.leaving[first], rows.arriving[last]
    for i, turn in enumerate((arriving[:-1] * leaving[1:]).sum(axis=1).tolist(), start=1):
        if turn <= angle:
            yield float(ends[i]), float(ends[i])
    if _is_closed(rows) and float(arriving[-1] @ leaving[0]) <= angle:
        yield 0.0, 0.0
    for i, piece in enumerate(pieces):
        # Also arcs that are small enough to be a corner.
        small = isinstance(piece, Arc) and piece.radius <= pace.radius * (1.0 + 1e-9)
        if small and isinstance(piece, Arc) and piece.sweep >= pace.angle - 1e-6:
            yield float(ends[i]), float(ends[i + 1])


def _slowest_at(spans: Sequence[tuple[float, float, Speed]], place: float) -> Speed | None:
    there = [speed for low, high, speed in spans if low <= place <= high]
    return min(there, key=lambda speed: speed.tcp, default=None)


def _divided_piece(
    piece: _LineOrArc, low: float, high: float, cuts: Sequence[float], flat: float
) -> list[_LineOrArc]:
    """The parts of a piece between places that are inside it."""
    # A small arc cannot be divided: its parts would be too short for a circle.
    if isinstance(piece, Arc) and piece.radius < _SMALLEST_DIVIDED_RADIUS:
        return [piece]
    inside = [low]
    for place in sorted(cuts):
        if inside[-1] + _SHORTEST_SPEED_PART <= place <= high - _SHORTEST_SPEED_PART:
            inside.append(place)
    if len(inside) == 1:
        return [piece]
    parts = [(place - low) / (high - low) for place in (*inside, high)]
    if isinstance(piece, Line):
        points = [piece.start, *map(vector, piece.at(parts[1:-1])), piece.end]
        return [replace(piece, start=a, end=b) for a, b in pairwise(points)]
    middles = [(a + b) / 2.0 for a, b in pairwise(parts)]
    points = [piece.start, *map(vector, piece.at(parts[1:-1])), piece.end]
    # A via belongs to each part, at its own middle.
    vias = [vector(p) for p in piece.at(middles)]
    arcs = [
        replace(piece, start=a, via=via, end=b, closed=False)
        for (a, b), via in zip(pairwise(points), vias, strict=True)
    ]
    return [part for arc in arcs for part in _possible_moves(arc, flat, 360.0)]
