"""What it costs to go from one station of a run to the next, with every turn in every branch."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats, Ints, Rows, Truths, norms
from assistant.robots.arms.arm import CLOSING, MISS_TOLERANCE
from assistant.robots.motion.along import ToolPaths
from assistant.robots.robot import LIMIT_TOLERANCE, Robot
from assistant.robots.turning.stations import MOST_TURN_RATE, UPRIGHT, FreeRun

SPACING: Final = 15.0
"""mm between places on the way that are looked at; targets that are nearer are not all."""
TILT_SPACING: Final = 5.0
"""degrees of tilt after which the next place is looked at."""
MOST_PLACES: Final = 24
"""Places on the way from row to row, at most."""
WIDEST: Final = 90.0
"""degrees by which the tool turns from one station to the next, at most."""
LEAP: Final = 120.0
"""degrees or mm of an axis from place to place from which on it is no way."""
NEAR_SINGULARITY: Final = 10.0
"""degrees of axis 5 from straight within which the wrist is near its singularity."""
SINGULARITY_COST: Final = 5.0
"""Seconds of joint travel that one at the singularity of the wrist is as bad as."""
TOO_SLOW_COST: Final = 10.0
"""Seconds of joint travel that one is as bad as by which an axis is too slow for the tool."""
NEAR_LIMIT: Final = 3.0
"""degrees or mm from a limit within which an axis is near it."""
ROUNDING: Final = 1e-6


@dataclass(frozen=True, slots=True, eq=False)
class Station:
    """A row at which a turn is chosen.

    turns: (k,) degrees to choose from. branches: those of the arm that are looked at. joints:
    (k, b, a) each nearest to the middle of its range. possible: (k, b) inside limits and reach.
    """

    row: int
    turns: Floats
    branches: tuple[int, ...]
    joints: Floats
    possible: Truths


@dataclass(frozen=True, slots=True, eq=False)
class Step:
    """The ways from one station to the next, along which no branch is changed.

    before: (k, m) of each turn the turns before it from which it may be come to, the same one
    again where there are fewer. seconds: (k, m, b) what it costs, infinite where it cannot be.
    windings: (k, m, b, x) whole turns by which each axis that winds is on after it. below, above:
    (k, m, b, x) degrees by which that goes under and over its end, at most and at least 0.
    """

    before: Rows
    seconds: Floats
    windings: Ints
    below: Floats
    above: Floats


class StationBuilder:
    """Works out stations and steps of a run."""

    def __init__(self, free_run: FreeRun, robot: Robot) -> None:
        self.free_run, self.robot = free_run, robot
        self.winding = list(robot.winding())
        self.bend = robot.axes.index("J5") if robot.arm.spherical else None

    def station(self, row: int, turns: Floats, branches: tuple[int, ...]) -> Station:
        rows = np.full(len(turns), row)
        p = np.repeat(self.free_run.positions[row : row + 1], len(turns), axis=0)
        joints, possible = self._solved(p, self.free_run.turned(rows, turns), rows, branches)
        low, high = self.robot.limits.T
        out = (joints < low - LIMIT_TOLERANCE) | (joints > high + LIMIT_TOLERANCE)
        out[..., self.winding] = False
        possible = possible & ~out.any(axis=-1)
        own = int(self.free_run.own[row])
        if own >= 0:
            possible = possible & (np.array(branches) == own)
        return Station(row, turns, branches, joints, possible)

    def step(self, one: Station, other: Station, ramp: float, tolerance: float) -> Step:
        """From a station to the next one by linear and circular moves.

        ramp: degrees by which the same choice is on after it. tolerance: degrees by which a turn
        that is settled may be off what there is to choose from.
        """
        rows = np.arange(one.row + 1, other.row + 1)
        same = bool(self.free_run.same[rows].all())
        before, fits, change = self._pairs(one, other, ramp, tolerance, rows, same)
        k, m = before.shape
        places = self._places(rows)
        share = self._shares(rows, *places)
        seconds = np.diff(share, prepend=0.0) * float(self.free_run.seconds[rows].sum())
        joints = np.empty((len(self.robot.axes), len(share) + 1, k, m, len(one.branches)))
        joints[:, 0] = np.moveaxis(one.joints[before], -1, 0)
        joints[:, -1] = np.moveaxis(other.joints, -1, 0)[:, :, None]
        possible = fits[..., None] & one.possible[before] & other.possible[:, None]
        if len(share) > 1:
            ends = one.turns[before], change
            joints[:, 1:-1], reached = self._between(rows, ends, places, one.branches)
            possible &= reached.all(axis=0)
        return self._costed(before, joints, possible, seconds, LEAP if same else np.inf)

    def along(
        self, one: Station, other: Station, turns: tuple[int, int], branch: int, change: float
    ) -> Floats:
        """(s, a) joints on the way between stations, both included, as the arm goes there.

        turns: which of each station. branch: which of its branches. change: degrees from turn to
        turn.
        """
        rows = np.arange(one.row + 1, other.row + 1)
        places = self._places(rows)
        parts = [one.joints[turns[0], branch][None], other.joints[turns[1], branch][None]]
        if len(places[0]) > 1:
            ends = np.array([[one.turns[turns[0]]]]), np.array([[change]])
            between, _ = self._between(rows, ends, places, (one.branches[branch],))
            parts.insert(1, between[:, :, 0, 0, 0].T)
        joints = np.concatenate(parts)
        steps = np.diff(joints, axis=0)
        steps[:, self.winding] -= 360.0 * np.round(steps[:, self.winding] / 360.0)
        return np.asarray(joints[0] + np.concatenate([0.0 * joints[:1], np.cumsum(steps, axis=0)]))

    def row_turns(self, one: Station, other: Station, ends: tuple[float, float]) -> Floats:
        """Degrees of the turns at the rows behind one station up to the next."""
        rows = np.arange(one.row + 1, other.row + 1)
        share = self._shares(rows, rows, np.ones(len(rows)))
        return np.asarray(ends[0] + ends[1] * share)

    # ------------------------------------------------------------------------------ parts

    def _pairs(
        self, one: Station, other: Station, ramp: float, tolerance: float, rows: Rows, same: bool
    ) -> tuple[Rows, Truths, Floats]:
        """(k, m) turns before each turn, whether that may be, and degrees from the one to it."""
        apart = other.turns[:, None] - one.turns[None] - ramp
        apart -= 360.0 * np.round(apart / 360.0)
        settled = bool(np.isfinite(self.free_run.fixed[[one.row, other.row]]).all())
        if not same or settled:
            fits = np.ones(apart.shape, dtype=bool)
        elif self.free_run.tied[other.row] == one.row:
            fits = np.abs(apart) < 1e-3
        else:
            most = min(MOST_TURN_RATE * float(self.free_run.seconds[rows].sum()), WIDEST)
            fits = np.abs(apart) <= max(most + ROUNDING, tolerance)
        count = max(int(fits.sum(axis=1).max()), 1)
        order = np.argsort(np.where(fits, np.abs(apart), np.inf), axis=1, kind="stable")[:, :count]
        chosen = np.take_along_axis(fits, order, axis=1)
        return order, chosen, np.take_along_axis(apart, order, axis=1) + ramp

    def _places(self, rows: Rows) -> tuple[Rows, Floats]:
        """Rows (s,), the last included, and parts (s,) of the moves to them that are looked at."""
        if not self.free_run.same[rows].all():  # with another tool, or in another frame
            return rows[-1:], np.ones(1)
        lengths = self._lengths[rows]
        counts = np.clip(np.ceil(lengths / SPACING), 1, MOST_PLACES).astype(np.intp)
        row = np.repeat(rows, counts)
        number = np.arange(len(row)) - np.repeat(np.cumsum(counts) - counts, counts) + 1
        each = np.maximum(lengths / SPACING, self._tilts[rows] / TILT_SPACING) / counts
        gone = np.floor(np.cumsum(np.repeat(each, counts)) + ROUNDING)
        kept = np.diff(gone, prepend=0.0) > 0.0
        kept[-1] = True
        return row[kept], (number / np.repeat(counts, counts))[kept]

    @cached_property
    def _tilts(self) -> Floats:
        """(n,) degrees by which the tool is tilted on the moves."""
        free_run, out = self.free_run, np.zeros(len(self.free_run))
        z = rotations.rotate(free_run.references, np.broadcast_to(UPRIGHT, (len(free_run), 3)))
        out[1:] = np.degrees(2.0 * np.arcsin(np.clip(norms(np.diff(z, axis=0)) / 2.0, 0.0, 1.0)))
        return out

    @cached_property
    def _lengths(self) -> Floats:
        """(n,) mm of the moves."""
        free_run = self.free_run
        out = np.zeros(len(free_run))
        out[1:] = np.linalg.norm(np.diff(free_run.positions, axis=0), axis=1)
        if free_run.arcs is not None:
            out[free_run.arcs.rows] = free_run.arcs.lengths
        return out

    def _shares(self, rows: Rows, row: Rows, part: Floats) -> Floats:
        """(s,) shares of the time from station to station at parts of the moves to rows."""
        seconds = self.free_run.seconds[rows]
        total = float(seconds.sum())
        if not total > 0.0:
            seconds, total = np.ones(len(rows)), float(len(rows))
        ends = np.cumsum(seconds)
        at = row - rows[0]
        out = (ends[at] - (1.0 - part) * seconds[at]) / total
        out[-1] = 1.0
        return np.asarray(out)

    def _between(
        self,
        rows: Rows,
        ends: tuple[Floats, Floats],
        places: tuple[Rows, Floats],
        branches: tuple[int, ...],
    ) -> tuple[Floats, Truths]:
        """Joints (a, s - 1, k, m, b) at all places but the last, and whether they are there.

        ends: (k, m) turns at the station before, and degrees from it to the other.
        """
        free_run, row, part = self.free_run, places[0][:-1], places[1][:-1]
        first, change = (each.ravel() for each in ends)
        shares = np.concatenate([[0.0], self._shares(rows, rows, np.ones(len(rows)))])
        at = row - rows[0]
        sides: list[Floats] = []
        for rows_there, share in ((row - 1, shares[at]), (row, shares[at + 1])):
            turns = first + share[:, None] * change  # (s, p)
            each = np.repeat(rows_there, len(first))
            sides.append(free_run.turned(each, turns.ravel()))
        ways = ToolPaths(
            (free_run.positions[row - 1], free_run.references[row - 1]),
            (free_run.positions[row], free_run.references[row]),
            row,
            free_run.arcs,
        )
        p, _ = ways.at(part[:, None])
        positions = np.repeat(p[:, 0], len(first), axis=0)
        turned = rotations.between(sides[0], sides[1], np.repeat(part, len(first)))
        joints, possible = self._solved(positions, turned, np.repeat(row, len(first)), branches)
        shape = len(row), *ends[0].shape, len(branches)
        return np.moveaxis(joints, -1, 0).reshape(-1, *shape), possible.reshape(shape)

    def _solved(
        self, positions: Floats, quaternions: Floats, rows: Rows, branches: tuple[int, ...]
    ) -> tuple[Floats, Truths]:
        """Joints (p, b, a) of the tool at poses of rows (p,), and whether they reach it."""
        robot = self.robot
        p, q = self.free_run.run.mounting.to_flange(positions, quaternions, rows)
        found, excess = robot.solve(p, q, branches)
        reached = (excess < CLOSING / 2.0) & np.isfinite(found).all(axis=0)
        if not robot.arm.spherical:
            joints = np.nan_to_num(found[:, 0].T)
            reached &= robot.arm.miss(robot.chained(joints), q) <= MISS_TOLERANCE
        return np.ascontiguousarray(found.transpose(2, 1, 0)), np.ascontiguousarray(reached.T)

    def _costed(
        self, before: Rows, joints: Floats, possible: Truths, seconds: Floats, leap: float
    ) -> Step:
        """joints: (a, s + 1, k, m, b). seconds: (s,) from place to place. leap: see `LEAP`."""
        robot, winding = self.robot, self.winding
        low, high = (limit[:, None, None, None] for limit in robot.limits.T)
        for_each = seconds[:, None, None, None]
        with np.errstate(invalid="ignore"):
            steps = np.diff(joints, axis=1)
            for axis in winding:
                steps[axis] -= 360.0 * np.round(steps[axis] / 360.0)
            possible = possible & (np.abs(steps).max(axis=(0, 1)) < leap)
            away = np.cumsum(steps[:, ::-1], axis=1)  # back from the end
            under = np.minimum(-away.max(axis=1), 0.0)
            over = np.maximum(-away.min(axis=1), 0.0)
            end = joints[:, -1]
            outside = (end + under < low - LIMIT_TOLERANCE) | (end + over > high + LIMIT_TOLERANCE)
            outside[winding] = False
            possible &= ~outside.any(axis=0)
            whole = np.round((away[:, -1] - end + joints[:, 0])[winding] / 360.0)
            steps /= robot.speeds[:, None, None, None, None]
            np.abs(steps, out=steps)
            cost = np.sqrt(np.square(steps).sum(axis=0)).sum(axis=0)
            cost += TOO_SLOW_COST * np.maximum(steps.max(axis=0) - for_each, 0.0).sum(axis=0)
            if self.bend is not None:
                near = np.clip(1.0 - np.abs(joints[self.bend, 1:]) / NEAR_SINGULARITY, 0.0, 1.0)
                cost += SINGULARITY_COST * (near * near * for_each).sum(axis=0)
            still = [axis for axis in range(len(robot.axes)) if axis not in winding]
            room = np.minimum(
                joints[still, 1:] - low[still, None], high[still, None] - joints[still, 1:]
            )
            near = np.clip(1.0 - room.min(axis=0) / NEAR_LIMIT, 0.0, 1.0)
            cost += (near * near * for_each).sum(axis=0)
        return Step(
            before,
            np.where(possible, cost, np.inf),
            np.moveaxis(np.where(possible, whole, 0.0), 0, -1).astype(np.int64),
            np.moveaxis(np.nan_to_num(under[winding]), 0, -1),
            np.moveaxis(np.nan_to_num(over[winding]), 0, -1),
        )
