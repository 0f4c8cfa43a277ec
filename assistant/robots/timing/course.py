"""The course: the way that the arm takes, which leaves that of the moves in their corners.

It is the control polygon of a quadratic spline: at each knot the way is a parabola from `room`
before it to `room` behind it, which touches the polygon at both borders. A small corner is a knot
whose room is its zone; a wide one gets several (`corners`).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from assistant.base import rotations
from assistant.base.arrays import Floats, Rows, Truths, max_abs
from assistant.program.motion import Kind
from assistant.robots.robot import Robot
from assistant.robots.timing.corners import Corners
from assistant.robots.timing.knots import Knots
from assistant.robots.timing.rows import Moves

NO_STEP: Final = 1e-9
"""mm or degrees below which a step is none."""
ON_THE_SPOT: Final = 1e-3
"""mm of way for a degree of turn below which a move is a turn on the spot."""
TURN_OF_ZONE: Final = 0.15
"""Degrees of turn for a mm of a zone, as RAPID's predefined zones have it (z10: 1.5)."""
MOST_PARABOLA_CUT: Final = 0.05
"""mm or degrees that a corner is cut by at most to be one parabola of the joints and the tool."""


@dataclass(frozen=True, slots=True, eq=False)
class Zones:
    """c corners that are cut, in order: the moves before and after each (c,), its place along the
    course and how far it reaches to both sides, mm (c,).
    """

    before: Rows
    after: Rows
    place: Floats
    size: Floats


@dataclass(frozen=True, slots=True, eq=False)
class Course:
    """s steps of knots that are no standing still, and s + 1 knots between them.

    step: (s,) rows of the knots. distance: (s,) along the way, mm (degrees where the tool turns
    on the spot, or the arm moves around it), as if no corner were cut. room: (s + 1,) the same
    before and behind each knot in which the way is bent; 0 for a stop. corner: (s + 1,) whether
    the knot belongs to a corner that is cut. inside: (s,) whether a step lies between knots of
    one corner. loose: (s,) whether it is of a joint move, or lies in the corner of one. axes:
    (a, s) and tool: (3, s) what moves in a step for each mm of it. straight: (s,) whether it is of
    joint moves alone, so that its joints are nowhere else than on the lines between the knots and
    the parabolas of the corners. moves, robot: what the course was made of. scale: (n,) how long
    each of the moves is. zones: its corners.
    """

    knots: Knots
    step: Rows
    distance: Floats
    room: Floats
    corner: Truths
    inside: Truths
    loose: Truths
    axes: Floats
    tool: Floats
    straight: Truths
    moves: Moves
    robot: Robot
    scale: Floats
    zones: Zones

    @property
    def row(self) -> Rows:
        """(s,) the move that a step belongs to."""
        return np.asarray(self.knots.row[self.step])


def course_of(moves: Moves, knots: Knots, robot: Robot) -> Course:
    """The course of moves that are gone through at knots."""
    lengths, turns = (sums_by_move(knots.row, x, len(moves)) for x in (knots.length, knots.turn))
    scale, kind = _scales(knots, lengths, turns)
    distance = knots.part * scale[knots.row]
    going = (distance > NO_STEP) | (knots.part <= 0.0)
    if not going.all():  # Moves to where the tool is have no knots: the way goes on through them.
        knots, distance = _only(knots, going), distance[going]
    step = np.flatnonzero(distance > NO_STEP)
    d, row = distance[step], knots.row[step]
    axes, tool = _rates(knots.joints, step, d), _rates(knots.positions, step, d)
    free = moves.kinds == Kind.JOINT
    beside = free[row]
    beside[:-1] |= free[row[1:]]
    both = free[row]
    both[:-1] &= free[row[1:]]
    room = np.full(len(knots.joints), np.nan)  # of each knot of a corner or a stop
    corner = np.full(len(room), -1)
    at, zone = _zones(moves, row, scale, kind)
    cut = zone > 0.0
    zones = Zones(row[at[cut]], row[at[cut] + 1], np.cumsum(d)[at[cut]], zone[cut])
    scale = sums_by_move(row, d, len(moves))
    if len(step) > 1:
        small = np.minimum(zone, np.minimum(d[at], d[at + 1]) / 2.0)
        for knot in (step[at] + 1, step[at + 1]):
            room[knot], corner[knot] = small, np.where(small > 0.0, at, -1)
        wide = (_corner_cuts(axes, at, zone) > MOST_PARABOLA_CUT) | (
            _corner_cuts(tool, at, zone) > MOST_PARABOLA_CUT
        )
        wide &= step[at + 1] == step[at] + 1  # the tool is the same
        if wide.any():
            corners = Corners(moves, knots, step, d, at[wide], zone[wide])
            knots, distance, room, corner = corners.inserted(robot, distance, room, corner)
            step = np.flatnonzero(distance > NO_STEP)
            d = distance[step]
            axes, tool = _rates(knots.joints, step, d), _rates(knots.positions, step, d)
    knots = replace(knots, quaternions=rotations.unflipped(knots.quaternions))
    first, last = corner[step], corner[step + 1]
    ends = np.append(step, len(room) - 1)
    inside = (first >= 0) & (first == last)
    room = _rooms(room[ends], d)
    loose = free[knots.row[step]]
    loose[inside] |= beside[first[inside]]
    straight = free[knots.row[step]]
    straight[inside] = both[first[inside]]
    cuts = corner[ends] >= 0
    whole = moves, robot, scale, zones
    return Course(knots, step, d, room, cuts, inside, loose, axes, tool, straight, *whole)


def _only(knots: Knots, going: Truths) -> Knots:
    """Those at the ends of some steps (k,)."""
    kept = np.append(True, going)
    poses = knots.joints[kept], knots.positions[kept], knots.quaternions[kept]
    steps = knots.length[going], knots.turn[going]
    return Knots(knots.row[going], knots.part[going], *poses, *steps, knots.guessed)


def _scales(knots: Knots, lengths: Floats, turns: Floats) -> tuple[Floats, NDArray[np.uint8]]:
    """(n,) how long each move's way is, and in what: 0 mm, 1 degrees of the tool, 2 of an axis."""
    angles = np.zeros(len(lengths))
    swept = max_abs(np.diff(knots.joints, axis=0))
    np.maximum.at(angles, knots.row, swept / np.maximum(knots.part, 1e-300) * (knots.part > 0))
    moved = (lengths > NO_STEP) & (lengths > ON_THE_SPOT * turns)
    turned = ~moved & (turns > NO_STEP) & (turns > ON_THE_SPOT * angles)
    kind = np.where(moved, 0, np.where(turned, 1, 2)).astype(np.uint8)
    return np.where(moved, lengths, np.where(turned, turns, angles)), kind


def _zones(moves: Moves, row: Rows, scale: Floats, kind: NDArray[np.uint8]) -> tuple[Rows, Floats]:
    """(c,) steps behind which a corner or a stop is, and how far it reaches: 0 for a stop.

    row: (s,) the moves of the steps. A corner takes half of either move at most.
    """
    at = np.flatnonzero(row[:-1] != row[1:])
    i, j = row[at], row[at + 1]
    stops = np.concatenate([[0], np.cumsum(moves.entry <= 0.0)])
    entry = np.where(kind[i] == 0, moves.entry[i], TURN_OF_ZONE * moves.entry[i])
    leaving = np.where(kind[j] == 0, moves.leaving[i], TURN_OF_ZONE * moves.leaving[i])
    zone = np.minimum(np.minimum(entry, scale[i] / 2.0), np.minimum(leaving, scale[j] / 2.0))
    zone[(stops[j] > stops[i]) | (kind[i] != kind[j])] = 0.0
    through = (moves.kinds[i] == Kind.VIA) & (moves.kinds[j] == Kind.END)
    return at[~through], zone[~through]


def _corner_cuts(rates: Floats, at: Rows, zone: Floats) -> Floats:
    """(c,) how far from corners behind steps one parabola goes past; 0 where it cannot be far."""
    cut = np.zeros(len(at))
    far = np.flatnonzero(zone * np.abs(rates).max() > 2.0 * MOST_PARABOLA_CUT)
    bend = np.abs(rates[:, at[far] + 1] - rates[:, at[far]]).max(axis=0)
    cut[far] = bend * zone[far] / 4.0
    return cut


def _rooms(room: Floats, d: Floats) -> Floats:
    """(s + 1,) of all knots, from those of corners and stops, NaN for others; the ends are stops.

    Between other steps it is half of the shorter, or what the corner beside them leaves.
    """
    room[0] = room[-1] = 0.0
    smooth = np.isnan(room)
    left = np.where(smooth[:-1], d / 2.0, d - np.nan_to_num(room[:-1]))
    right = np.where(smooth[1:], d / 2.0, d - np.nan_to_num(room[1:]))
    inner = np.minimum(left[:-1], right[1:])
    room[1:-1] = np.where(smooth[1:-1], inner, room[1:-1])
    return room


def _rates(values: Floats, step: Rows, d: Floats) -> Floats:
    """(c, s) change of values (k + 1, c) of knots in each step, for each mm of it."""
    change = np.diff(values, axis=0)
    if len(step) < len(change):
        change = change[step]
    return np.divide(change.T, d, order="C")


def sums_by_move(row: Rows, values: Floats, n: int) -> Floats:
    """(n,) of values (s,) of the moves that they belong to."""
    return np.asarray(np.bincount(row, values, n), dtype=np.float64)
