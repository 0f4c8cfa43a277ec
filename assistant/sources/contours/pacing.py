"""Where along a contour the speed changes: moves are divided there, and each has its speed.

Places are mm of the way from the start. A move is divided by a point on it, which changes nothing
of the way: an arc becomes two arcs of its circle.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray

from assistant.base.arrays import Floats, Truths
from assistant.program.motion import Kind, Speed
from assistant.sources.contours.curves import Arc, Line, Points, cross, vector
from assistant.sources.contours.moves import Moves, move_columns, possible_moves
from assistant.sources.process.ways import SpeedProfile

SHORTEST_SPEED_PART: Final = 0.5
"""mm of a part of a move; a place that is nearer to the end of one is that end."""
SMALLEST_DIVIDED_RADIUS: Final = 1.0
"""mm of radius of an arc that is divided."""
CLOSED_DISTANCE: Final = 1e-6
"""mm between the ends of a contour that is closed."""
STRAIGHT_ARC: Final = 1e-10
"""Largest product of two chords of an arc and the sine of their turn, in squares of the longer
chord, of three points on a line."""

LineOrArc = Line | Arc


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
    pieces = pieces_of_moves(rows)
    ends = np.cumsum([0.0, *(piece.length for piece in pieces)])
    spans, corners = _speed_spans(rows, pieces, ends, pace)
    cuts = [*places, *(place for low, high, _ in spans for place in (low, high))]
    made: list[LineOrArc] = []
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
    kinds, positions, leaving, arriving = move_columns(made)
    divided = np.repeat(joints, count) & (kinds != Kind.VIA)
    moved = replace(rows, kinds=kinds, positions=positions, leaving=leaving, arriving=arriving)
    return MovesWithSpeeds(moved, of, table, divided, corners)


def pieces_of_moves(rows: Moves) -> list[LineOrArc]:
    """The lines and arcs that rows are; an arc through points on one line is two lines."""
    pieces: list[LineOrArc] = []
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
    bent = sine > STRAIGHT_ARC * longest**2
    around = chord * half / np.sin(np.where(bent, half, 1.0))
    steps[end] = np.where(bent, around, steps[end - 1] + steps[end])
    steps[end - 1] = 0.0
    return np.asarray(steps)


def _speed_spans(
    rows: Moves, pieces: Sequence[LineOrArc], ends: Floats, pace: SpeedProfile
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
    """What of a stretch lies on the way; of a closed contour what reaches over its start too."""
    yield max(low, 0.0), min(high, total)
    if _is_closed(rows):
        if low < 0.0:
            yield max(total + low, 0.0), total
        if high > total:
            yield 0.0, min(high - total, total)


def _is_closed(rows: Moves) -> bool:
    return bool(np.linalg.norm(rows.positions[-1] - rows.start) < CLOSED_DISTANCE)


def _corner_spans(
    rows: Moves, pieces: Sequence[LineOrArc], ends: Floats, pace: SpeedProfile
) -> Iterator[tuple[float, float]]:
    """Where corners begin and end; one at the start of a closed contour does at 0."""
    if not pieces:
        return
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
        small = isinstance(piece, Arc) and piece.radius <= pace.radius * (1.0 + 1e-9)
        if small and isinstance(piece, Arc) and piece.sweep >= pace.angle - 1e-6:
            yield float(ends[i]), float(ends[i + 1])


def _slowest_at(spans: Sequence[tuple[float, float, Speed]], place: float) -> Speed | None:
    there = [speed for low, high, speed in spans if low <= place <= high]
    return min(there, key=lambda speed: speed.tcp, default=None)


def _divided_piece(
    piece: LineOrArc, low: float, high: float, cuts: Sequence[float], flat: float
) -> list[LineOrArc]:
    """The parts of a piece between places that are inside it."""
    if isinstance(piece, Arc) and piece.radius < SMALLEST_DIVIDED_RADIUS:
        return [piece]
    inside = [low]
    for place in sorted(cuts):
        if inside[-1] + SHORTEST_SPEED_PART <= place <= high - SHORTEST_SPEED_PART:
            inside.append(place)
    if len(inside) == 1:
        return [piece]
    parts = [(place - low) / (high - low) for place in (*inside, high)]
    if isinstance(piece, Line):
        points = [piece.start, *map(vector, piece.at(parts[1:-1])), piece.end]
        return [replace(piece, start=a, end=b) for a, b in pairwise(points)]
    middles = [(a + b) / 2.0 for a, b in pairwise(parts)]
    points = [piece.start, *map(vector, piece.at(parts[1:-1])), piece.end]
    vias = [vector(p) for p in piece.at(middles)]
    arcs = [
        replace(piece, start=a, via=via, end=b, closed=False)
        for (a, b), via in zip(pairwise(points), vias, strict=True)
    ]
    return [part for arc in arcs for part in possible_moves(arc, flat, 360.0)]
