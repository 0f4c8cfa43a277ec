"""The speed along a way: as fast as allowed at every step, with accelerations that are bounded.

Along the way the speed v is bounded by what is programmed and by the axes, and at every knot by
the change of direction there, which a parabola of constant acceleration makes over the blend.
With w = v² an acceleration A over a step d allows w to grow by 2 A d: the largest w is a running
minimum, forwards and then backwards, which is exact in columns.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from assistant.program.path import Kind
from assistant.robots.run import Floats
from assistant.robots.timing.drive import Drive
from assistant.robots.timing.knots import Knots
from assistant.robots.timing.rows import Moves

Rows = NDArray[np.intp]

HIGHEST: Final = 1e6
"""Acceleration (mm/s²) that stands for none that binds; keeps sums exact enough."""
STILL: Final = 1e-9
"""mm or degrees below which a step is none."""
ON_THE_SPOT: Final = 1e-3
"""mm of way for a degree of turn below which a move is a turn on the spot."""
TURN_OF_ZONE: Final = 0.15
"""Degrees of turn for a mm of a zone, as RAPID's predefined zones have it (z10: 1.5)."""

ACCELERATION, SPEED, ROTATION, MOST, PERCENT, FIRST_AXIS = range(6)
"""What binds a move; from FIRST_AXIS on the axes."""
WORDS: Final = ("acceleration", "speed", "reorientation", "speed of the robot", "percent")


@dataclass(frozen=True, slots=True, eq=False)
class Profile:
    """The motion along a way, s steps that are no standing still.

    step: (s,) of the knots. distance: (s,) along the way, mm (degrees where the tool turns on
    the spot, or the arm moves around it). speed: (s + 1,) at the knots, peak: (s,) in the steps.
    rise, fall: (s,) accelerations. times: (s + 1,) seconds from the start. binds: (n,) and
    seconds: (n,) of the moves. lengths: (n,) mm, turns: (n,) deg of the moves.
    """

    step: Rows
    distance: Floats
    speed: Floats
    peak: Floats
    rise: Floats
    fall: Floats
    times: Floats
    seconds: Floats
    lengths: Floats
    turns: Floats
    binds: NDArray[np.uint8]


def profile_of(moves: Moves, knots: Knots, drive: Drive) -> Profile:
    """The fastest motion through all knots that starts and ends at rest."""
    n = len(moves)
    swept = np.abs(np.diff(knots.joints, axis=0))
    scale, kind = _scales(knots, swept, n)
    distance = knots.part * scale[knots.row]
    step = np.flatnonzero(distance > STILL)
    way = _Way(moves, knots, drive, step, distance[step], swept[step])
    caps, why = way.caps()
    rise, fall = way.accelerations()
    most = way.corners(scale, kind)
    most[1:-1] = np.minimum(most[1:-1], np.minimum(caps[:-1], caps[1:]) ** 2)
    d = way.distance
    w = _fastest(most, 2.0 * rise * d, 2.0 * fall * d)
    v = np.sqrt(w)
    top = (fall * w[:-1] + rise * w[1:] + 2.0 * rise * fall * d) / (rise + fall)
    peak = np.sqrt(np.maximum(np.minimum(top, caps**2), np.maximum(w[:-1], w[1:])))
    up, down = (peak - v[:-1]) / rise, (peak - v[1:]) / fall
    cruise = d - (peak + v[:-1]) * up / 2.0 - (peak + v[1:]) * down / 2.0
    even = np.maximum(cruise, 0.0) / np.maximum(peak, 1e-300)
    seconds = up + down + even
    row = knots.row[step]
    reached = peak >= 0.999 * caps
    return Profile(
        step,
        d,
        v,
        peak,
        rise,
        fall,
        np.concatenate([[0.0], np.cumsum(seconds)]),
        _sums(row, seconds, n),
        _sums(knots.row, knots.length, n),
        _sums(knots.row, knots.turn, n),
        _binding(row, np.where(reached, even, 0.0), seconds, why, n, len(drive.speeds)),
    )


def _scales(knots: Knots, swept: Floats, n: int) -> tuple[Floats, NDArray[np.uint8]]:
    """(n,) how long each move's way is, and in what: 0 mm, 1 degrees of the tool, 2 of an axis."""
    lengths = _sums(knots.row, knots.length, n)
    turns = _sums(knots.row, knots.turn, n)
    angles = np.zeros(n)
    np.maximum.at(
        angles, knots.row, (swept.max(axis=1) / np.maximum(knots.part, 1e-300)) * (knots.part > 0)
    )
    moved = (lengths > STILL) & (lengths > ON_THE_SPOT * turns)
    turned = ~moved & (turns > STILL) & (turns > ON_THE_SPOT * angles)
    kind = np.where(moved, 0, np.where(turned, 1, 2)).astype(np.uint8)
    return np.where(moved, lengths, np.where(turned, turns, angles)), kind


class _Way:
    """s steps of a way: bounds of the speed and accelerations along it."""

    def __init__(
        self, moves: Moves, knots: Knots, drive: Drive, step: Rows, distance: Floats, swept: Floats
    ) -> None:
        self.moves, self.knots, self.drive, self.step = moves, knots, drive, step
        self.distance, self.swept = distance, swept
        self.row = knots.row[step]
        self.free = moves.kinds[self.row] == Kind.JOINT
        self.length, self.turn = knots.length[step], knots.turn[step]

    def caps(self) -> tuple[Floats, NDArray[np.uint8]]:
        """(s,) the highest speed, and what makes it so."""
        moves, drive, row, d = self.moves, self.drive, self.row, self.distance
        override = moves.override[row]
        percent = np.where(self.free, moves.percent[row], np.nan)
        stated = np.isfinite(percent)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            tcp = np.where(stated, np.inf, moves.tcp[row] * override * d / self.length)
            turn = np.where(stated, np.inf, moves.rotation[row] * override * d / self.turn)
            most = np.where(self.free, np.inf, drive.tcp_speed * d / self.length)
            axes = drive.speeds[:, None] * d / self.swept.T
        tcp, turn, most, axes = (np.where(np.isnan(x), np.inf, x) for x in (tcp, turn, most, axes))
        share = np.where(stated, percent / 100.0 * override, np.inf)
        joint = axes.argmin(axis=0)
        least = axes[joint, np.arange(len(d))]
        ways = np.stack([tcp, turn, most, least * share, least])
        if self.free.any():
            # Every axis turns at one pace: the slowest step holds for the whole move.
            starts = np.flatnonzero(np.concatenate([[True], np.diff(row) != 0]))
            lowest = np.minimum.reduceat(ways, starts, axis=1)
            worst = np.repeat(lowest, np.diff(np.append(starts, len(row))), axis=1)
            ways = np.where(self.free, worst, ways)
        why = ways.argmin(axis=0)
        caps = np.maximum(ways[why, np.arange(len(d))], 1e-6)
        return caps, np.where(why == 4, FIRST_AXIS + joint, why + SPEED).astype(np.uint8)

    def accelerations(self) -> tuple[Floats, Floats]:
        """(s,) to more and to less speed."""
        with np.errstate(divide="ignore", over="ignore"):
            axes = (self.drive.accelerations / self.swept).min(axis=1) * self.distance
            tcp = np.where(self.free, np.inf, self.drive.tcp_acceleration / self.length)
        most = np.minimum(axes, tcp * self.distance)
        rise, fall = self.moves.acceleration[self.row], self.moves.deceleration[self.row]
        return np.clip(most * rise, 1e-6, HIGHEST), np.clip(most * fall, 1e-6, HIGHEST)

    def corners(self, scale: Floats, kind: NDArray[np.uint8]) -> Floats:
        """(s + 1,) the highest speed, squared, at the knots; 0 at both ends."""
        most = np.zeros(len(self.step) + 1)
        if len(self.step) < 2:
            return most
        before, after = self.row[:-1], self.row[1:]
        room = self._room(before, after, scale, kind)
        joints = np.diff(self.knots.joints, axis=0)[self.step] / self.distance[:, None]
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            bound = (self.drive.accelerations / np.abs(np.diff(joints, axis=0))).min(axis=1)
            if np.isfinite(self.drive.tcp_acceleration):
                way = np.diff(self.knots.positions, axis=0)[self.step] / self.distance[:, None]
                bent = np.linalg.norm(np.diff(way, axis=0), axis=1)
                bent[self.free[:-1] | self.free[1:]] = 0.0
                bound = np.minimum(bound, self.drive.tcp_acceleration / bent)
        factor = np.minimum(self.moves.acceleration[before], self.moves.deceleration[before])
        inside = np.where(room > 0.0, 2.0 * room * bound * factor, 0.0)
        most[1:-1] = np.minimum(inside, 1e12)
        return most

    def _room(self, before: Rows, after: Rows, scale: Floats, kind: NDArray[np.uint8]) -> Floats:
        """(s - 1,) how far before and after each inner knot its corner is made; 0 for a stop."""
        d, moves = self.distance, self.moves
        room = np.minimum(d[:-1], d[1:]) / 2.0
        corner = np.flatnonzero(before != after)
        i, j = before[corner], after[corner]
        stops = np.concatenate([[0], np.cumsum(moves.entry <= 0.0)])
        through = (moves.kinds[i] == Kind.VIA) & (moves.kinds[j] == Kind.END)
        entry = np.where(kind[i] == 0, moves.entry[i], TURN_OF_ZONE * moves.entry[i])
        leaving = np.where(kind[j] == 0, moves.leaving[i], TURN_OF_ZONE * moves.leaving[i])
        zone = np.minimum(np.minimum(entry, scale[i] / 2.0), np.minimum(leaving, scale[j] / 2.0))
        zone[(stops[j] > stops[i]) | (kind[i] != kind[j])] = 0.0
        room[corner] = np.where(through, room[corner], zone)
        return room


def _fastest(most: Floats, rises: Floats, falls: Floats) -> Floats:
    """(s + 1,) the largest w below `most` that grows by `rises` and shrinks by `falls` a step."""
    up = np.concatenate([[0.0], np.cumsum(rises)])
    w = np.minimum(np.minimum.accumulate(most - up) + up, most)
    down = np.concatenate([[0.0], np.cumsum(falls[::-1])])
    w = np.minimum(np.minimum.accumulate(w[::-1] - down) + down, w[::-1])[::-1]
    return np.asarray(np.maximum(w, 0.0))


def _sums(row: Rows, values: Floats, n: int) -> Floats:
    return np.asarray(np.bincount(row, values, n), dtype=np.float64)


def _binding(
    row: Rows, even: Floats, seconds: Floats, why: NDArray[np.uint8], n: int, axes: int
) -> NDArray[np.uint8]:
    """(n,) what the most time of each move is spent at."""
    width = FIRST_AXIS + axes
    spent = np.bincount(row * width + why, even, n * width)
    spent += np.bincount(row * width, seconds - even, n * width)
    return np.asarray(spent.reshape(n, width).argmax(axis=1).astype(np.uint8))
