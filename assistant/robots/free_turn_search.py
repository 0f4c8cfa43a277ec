"""Search the cheapest sequence of tool turns, arm branches and whole turns along a run.

A turn is an angle in degrees about the z axis of the tool, from a direction that is carried along
the run without turning about that axis: a constant turn does not turn the tool, however its targets
were drawn. It is chosen at stations; between them it changes evenly with time.

The search is dynamic programming: the least cost of every state of a station follows from the
station before. Along linear and circular moves the branch stays the same and axes move without a
break; a joint move leads from any state to any other. Where a run returns to a target, all turns
that it can have there are followed in parallel, and only those count that end as they began. The
result is the optimum on the given grid.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import Final

import numpy as np
from numpy.typing import NDArray

from assistant.base import rotations
from assistant.base.arrays import Floats, Ints, Rows, Truths, norms
from assistant.base.data_classes import dataclass
from assistant.program.expressions import Name
from assistant.program.motion import Kind, Speed
from assistant.robots.arms.arm import CLOSING, MISS_TOLERANCE
from assistant.robots.motion.between_targets import MoveSampler
from assistant.robots.motion.interpolation import Arcs, ToolPaths
from assistant.robots.motion.run import Run
from assistant.robots.robot import LIMIT_TOLERANCE, Robot

_MOST_TURN_RATE: Final = 45.0
"""degrees a second that a tool is turned by on its way at most: its tip never waits for that."""
_UNKNOWN_SPEED: Final = 100.0
"""mm/s of moves whose speed only running the program tells, or which is unlimited."""
UPRIGHT: Final = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True, slots=True, eq=False)
class FreeRun:
    """A run whose tool may be turned at some of its n rows.

    free: (n,) at which. positions, references: (n, 3) mm, (n, 4) of the tool in the frame, with the
    turn 0. drawn: (n,) degrees of the turn that the targets were given with. seconds: (n,) that the
    tool takes to a row, 0 of joint moves. tied: (n,) the row before with the same target, or -1.
    fixed: (n,) degrees of a turn that is settled, NaN where it is not. own: (n,) the branch that a
    row states, or -1. arcs: those of the circular moves. same: (n,) whether a row is reached with
    the tool and frame of the row before.
    """

    run: Run
    free: Truths
    positions: Floats
    references: Floats
    drawn: Floats
    seconds: Floats
    tied: Rows
    fixed: Floats
    own: Rows
    arcs: Arcs | None
    same: Truths

    def __len__(self) -> int:
        return len(self.free)

    def turned(self, rows: Rows, turns: Floats) -> Floats:
        """Quaternions (k, 4) of the tool at rows (k,) with turns (k,) in degrees."""
        return np.asarray(
            rotations.multiply(self.references[rows], rotations.about(UPRIGHT, turns))
        )


def free_run_of(
    run: Run, robot: Robot, free: Truths, keys: Rows, own: Rows, fixed: Floats
) -> FreeRun:
    """keys: (n,) numbers of the targets of the rows, -1 for one that no other row has.

    fixed: (n,) degrees from what was drawn that are settled, else NaN.
    """
    look = MoveSampler(run, robot, np.zeros((len(run), len(robot.axes))))
    positions, quaternions = run.targets(slice(0, len(run)))
    quaternions = quaternions / norms(quaternions)[:, None]
    references, drawn = _carried_along(quaternions, look.same)
    tied = np.full(len(run), -1, dtype=np.intp)
    last: dict[int, int] = {}
    for row in np.flatnonzero(keys >= 0).tolist():
        tied[row] = last.get(int(keys[row]), -1)
        last[int(keys[row])] = row
    settled = np.where(np.isnan(fixed), np.where(free, np.nan, 0.0), fixed) + drawn
    return FreeRun(
        run,
        free,
        positions,
        references,
        drawn,
        _move_seconds(run, positions, look.arcs),
        tied,
        settled,
        own,
        look.arcs,
        look.same,
    )


def _carried_along(quaternions: Floats, same: Truths) -> tuple[Floats, Floats]:
    """Quaternions (n, 4) with the z axes of others that do not turn about them, and (n,) degrees
    about z from these to the others. same: (n,) whether a row goes on from the one before.
    """
    n = len(quaternions)
    out = quaternions.copy()
    z = rotations.rotate(quaternions, np.broadcast_to(UPRIGHT, (n, 3)))
    drawn = np.zeros(n)
    tilted = np.zeros(n, dtype=bool)
    tilted[1:] = norms(np.diff(z, axis=0)) > 1e-9
    for row in range(1, n):
        if not same[row]:
            continue
        before = out[row - 1]
        if tilted[row]:
            turn = _least_turn(z[row - 1], z[row])
            if turn is None:  # the tool is turned over: no direction goes on
                continue
            before = rotations.multiply(turn, before)
        out[row] = before
    relative = rotations.multiply(rotations.conjugate(out), quaternions)
    drawn = np.degrees(2.0 * np.arctan2(relative[:, 3], relative[:, 0]))
    # The z axes are those of the targets to the last digit.
    back = rotations.about(np.broadcast_to(UPRIGHT, (n, 3)), -drawn)
    return np.asarray(rotations.multiply(quaternions, back)), (drawn + 180.0) % 360.0 - 180.0


def _least_turn(one: Floats, other: Floats) -> Floats | None:
    """The quaternion of the smallest turn from a unit vector to another; None for opposite ones."""
    w = 1.0 + float(one @ other)
    if w < 1e-9:
        return None
    quaternion = np.concatenate([[w], np.cross(one, other)])
    return np.asarray(quaternion / np.linalg.norm(quaternion))


def _move_seconds(run: Run, positions: Floats, arcs: Arcs | None) -> Floats:
    lengths = np.zeros(len(run))
    lengths[1:] = norms(np.diff(positions, axis=0))
    if arcs is not None:
        lengths[arcs.rows] = arcs.lengths
    speeds = np.array([_tcp(speed) for speed in run.pace.speeds])
    out = lengths / speeds[run.pace.speed]
    out[run.kinds == Kind.JOINT] = 0.0
    return np.asarray(out)


def _tcp(speed: Speed | Name) -> float:
    known = isinstance(speed, Speed) and 0.0 < speed.tcp < np.inf
    return speed.tcp if known and isinstance(speed, Speed) else _UNKNOWN_SPEED


def stations(free_run: FreeRun, step: float) -> Rows:
    """(s,) rows at which a turn is chosen; between them it changes evenly with the time.

    step: degrees from one choice to the next.
    """
    n, kinds = len(free_run), free_run.run.kinds
    must = ~free_run.free | np.isfinite(free_run.fixed) | (kinds == Kind.JOINT) | ~free_run.same
    must[0] = must[-1] = True
    must[:-1] |= (kinds[1:] == Kind.JOINT) | ~free_run.same[1:] | ~free_run.free[1:]
    must[1:] |= ~free_run.free[:-1]
    ties = np.flatnonzero(free_run.tied >= 0)
    must[ties] = must[free_run.tied[ties]] = True
    chosen, since = [], 0.0
    for row in range(n):
        since += float(free_run.seconds[row])
        if must[row] or since * _MOST_TURN_RATE >= step:
            chosen.append(row)
            since = 0.0
    return np.array(chosen, dtype=np.intp)


_SPACING: Final = 15.0
"""Distance in mm between poses on a path that are examined; of closer targets only some are
examined.
"""
_TILT_SPACING: Final = 5.0
"""Tilt in degrees after which the next pose is examined."""
_MOST_PLACES: Final = 24
"""Places on the way from row to row, at most."""
_WIDEST: Final = 90.0
"""degrees by which the tool turns from one station to the next, at most."""
_LEAP: Final = 120.0
"""degrees or mm of an axis from place to place from which on it is no way."""
_NEAR_SINGULARITY: Final = 10.0
"""degrees of axis 5 from straight within which the wrist is near its singularity."""
_SINGULARITY_COST: Final = 5.0
"""Seconds of joint travel that one at the singularity of the wrist is as bad as."""
_TOO_SLOW_COST: Final = 10.0
"""Seconds of joint travel that one is as bad as by which an axis is too slow for the tool."""
_NEAR_LIMIT: Final = 3.0
"""degrees or mm from a limit within which an axis is near it."""
_ROUNDING: Final = 1e-6


@dataclass(frozen=True, slots=True, eq=False)
class Station:
    """A row at which a turn is chosen.

    turns: (k,) degrees to choose from. branches: those of the arm that are examined. joints: (k, b,
    a) each nearest to the middle of its range. possible: (k, b) inside limits and reach.
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
        return self._costed(before, joints, possible, seconds, _LEAP if same else np.inf)

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
            most = min(_MOST_TURN_RATE * float(self.free_run.seconds[rows].sum()), _WIDEST)
            fits = np.abs(apart) <= max(most + _ROUNDING, tolerance)
        count = max(int(fits.sum(axis=1).max()), 1)
        order = np.argsort(np.where(fits, np.abs(apart), np.inf), axis=1, kind="stable")[:, :count]
        chosen = np.take_along_axis(fits, order, axis=1)
        return order, chosen, np.take_along_axis(apart, order, axis=1) + ramp

    def _places(self, rows: Rows) -> tuple[Rows, Floats]:
        """Return the rows (s,), the last included, and parts (s,) of the moves to them that are
        examined.
        """
        if not self.free_run.same[rows].all():  # with another tool, or in another frame
            return rows[-1:], np.ones(1)
        lengths = self._lengths[rows]
        counts = np.clip(np.ceil(lengths / _SPACING), 1, _MOST_PLACES).astype(np.intp)
        row = np.repeat(rows, counts)
        number = np.arange(len(row)) - np.repeat(np.cumsum(counts) - counts, counts) + 1
        each = np.maximum(lengths / _SPACING, self._tilts[rows] / _TILT_SPACING) / counts
        gone = np.floor(np.cumsum(np.repeat(each, counts)) + _ROUNDING)
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
        """joints: (a, s + 1, k, m, b). seconds: (s,) from place to place. leap: see `_LEAP`."""
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
            cost += _TOO_SLOW_COST * np.maximum(steps.max(axis=0) - for_each, 0.0).sum(axis=0)
            if self.bend is not None:
                near = np.clip(1.0 - np.abs(joints[self.bend, 1:]) / _NEAR_SINGULARITY, 0.0, 1.0)
                cost += _SINGULARITY_COST * (near * near * for_each).sum(axis=0)
            still = [axis for axis in range(len(robot.axes)) if axis not in winding]
            room = np.minimum(
                joints[still, 1:] - low[still, None], high[still, None] - joints[still, 1:]
            )
            near = np.clip(1.0 - room.min(axis=0) / _NEAR_LIMIT, 0.0, 1.0)
            cost += (near * near * for_each).sum(axis=0)
        return Step(
            before,
            np.where(possible, cost, np.inf),
            np.moveaxis(np.where(possible, whole, 0.0), 0, -1).astype(np.int64),
            np.moveaxis(np.nan_to_num(under[winding]), 0, -1),
            np.moveaxis(np.nan_to_num(over[winding]), 0, -1),
        )


_DRAWN_TURN_COST: Final = 1e-4
"""Seconds that a degree away from how a target was drawn has to save at the start of a chain."""
_STATE_PAIRS_AT_ONCE: Final = 4_000_000
"""Pairs of states whose distances are worked out at once."""

TurnState = tuple[int, int, int]
"""Which turn of a station, which branch, and which whole turns."""


@dataclass(frozen=True, slots=True, eq=False)
class TurnProblem:
    """stations: s of them. steps: (s - 1) to each but the first, None for a joint move. drawn: (s,)
    degrees of the turns that the targets have. before: (a,) where the arm is at first, and whether
    the first move goes on from there: `continued`, in one of the branches `same` (b,). ties: pairs
    of stations with one turn, in order and apart. alike: joint moves, by the station that they lead
    to, that keep the turn.
    """

    stations: list[Station]
    steps: list[Step | None]
    drawn: Floats
    before: Floats
    continued: bool
    same: Truths
    ties: tuple[tuple[int, int], ...]
    alike: frozenset[int]


@dataclass(frozen=True, slots=True, eq=False)
class FoundPath:
    """A way. states: of each station. joints: (s, a) with whole turns. cost: seconds."""

    states: list[TurnState]
    joints: Floats
    cost: float


@dataclass(frozen=True, slots=True)
class NoPath:
    """station: the first one that no way leads to."""

    station: int


BarredSteps = Mapping[int, set[tuple[int, int, int]]]
"""Steps, by the station that they lead to, with what may not be gone: (turn there, which turn
before it, branch). Below 0 in the middle: a state of the station itself."""


class _Windings:
    """Whole turns of the axes that may turn further than once, each combination with a number."""

    def __init__(self, robot: Robot) -> None:
        self.robot, self.axes = robot, list(robot.winding())
        limits = robot.limits[self.axes]
        middle = limits.mean(axis=1)
        self.least = np.ceil((limits[:, 0] - middle - 180.0) / 360.0).astype(np.int64)
        most = np.floor((limits[:, 1] - middle + 180.0) / 360.0).astype(np.int64)
        self.sizes = most - self.least + 1
        grids = np.indices(self.sizes).reshape(len(self.axes), -1)
        self.turns: Ints = grids.T + self.least  # (w, x)
        self.strides: Ints = np.array(
            [int(np.prod(self.sizes[i + 1 :])) for i in range(len(self.axes))], dtype=np.int64
        )

    def __len__(self) -> int:
        return len(self.turns)

    def joints(self, joints: Floats) -> Floats:
        """(…, a) → (…, w, a)."""
        out = np.repeat(joints[..., None, :], len(self), axis=-2)
        out[..., self.axes] += 360.0 * self.turns
        return out

    def inside(self, joints: Floats, below: Floats | None, above: Floats | None) -> Truths:
        """(…, w) whether the axes, at joints (…, a) less and more so much (…, x), are in limits."""
        low, high = self.robot.limits[self.axes].T
        plain = joints[..., None, self.axes] + 360.0 * self.turns
        least = plain if below is None else plain + below[..., None, :]
        most = plain if above is None else plain + above[..., None, :]
        within = (least >= low - LIMIT_TOLERANCE) & (most <= high + LIMIT_TOLERANCE)
        return np.asarray(within.all(axis=-1))


class TurnSearch:
    """Looks for the cheapest way through a problem."""

    def __init__(self, problem: TurnProblem, robot: Robot) -> None:
        self.problem, self.robot = problem, robot
        self.windings = _Windings(robot)
        self.possible = [
            one.possible[..., None] & self.windings.inside(one.joints, None, None)
            for one in problem.stations
        ]
        self.pins = {one: other for one, other in problem.ties if self._follows(one, other)}

    def _follows(self, one: int, other: int) -> bool:
        return all(step is not None for step in self.problem.steps[one:other])

    def best(self, barred: BarredSteps) -> FoundPath | NoPath:
        count = len(self.problem.stations)
        costs = self._first(barred)
        back: dict[int, NDArray[np.int64]] = {}
        entered: dict[int, Floats] = {}
        at = 0
        while at < count - 1:
            if not np.isfinite(costs).any():
                return NoPath(at)
            end = self.pins.get(at)
            if end is None:
                costs, back[at + 1] = self._onwards(at + 1, costs[None], barred)
                costs, at = costs[0], at + 1
                continue
            entered[at] = costs
            turns = len(costs)
            wide = np.full((turns, *costs.shape), np.inf)
            wide[np.arange(turns), np.arange(turns)] = costs
            for station in range(at + 1, end + 1):
                wide, _ = self._onwards(station, wide, barred, pointers=False)
                if not np.isfinite(wide).any():
                    return NoPath(station)
            costs, at = wide[np.arange(turns), np.arange(turns)], end
        if not np.isfinite(costs).any():
            return NoPath(count - 1)
        return self._traced(costs, back, entered, barred)

    # ----------------------------------------------------------------------------- forwards

    def _first(self, barred: BarredSteps) -> Floats:
        problem, one = self.problem, self.problem.stations[0]
        joints = self.windings.joints(one.joints)
        way = joints - problem.before
        costs = np.sqrt(np.square(way / self.robot.speeds).sum(axis=-1))
        costs += self._away(0)[:, None, None]
        costs = np.where(self.possible[0], costs, np.inf)
        if problem.continued:
            branch = problem.same[list(one.branches)]
            costs[:, ~branch] = np.inf
            costs[(np.abs(way) > 180.0).any(axis=-1)] = np.inf
        return self._without(0, costs, barred)

    def _away(self, station: int) -> Floats:
        """(k,) seconds that turns cost for being others than what was drawn."""
        away = self.problem.stations[station].turns - self.problem.drawn[station]
        return np.asarray(_DRAWN_TURN_COST * np.abs(away - 360.0 * np.round(away / 360.0)))

    def _without(self, station: int, costs: Floats, barred: BarredSteps) -> Floats:
        for turn, before, branch in barred.get(station, ()):
            if before < 0:
                costs[..., turn, branch, :] = np.inf
        return costs

    def _onwards(
        self, station: int, costs: Floats, barred: BarredSteps, pointers: bool = True
    ) -> tuple[Floats, NDArray[np.int64]]:
        """Costs (p, k, b, w) of a station → those of the next one, with what each comes from: the
        place of the turn before it, or after a joint move the number of the whole state. p: turns
        at the start that are followed side by side.
        """
        step = self.problem.steps[station - 1]
        if step is None:
            new, back = self._jumped(station, costs[0])
            return self._without(station, new[None], barred), back
        ways = self._ways(station, step, costs, barred)
        back = ways[0].argmin(axis=1) if pointers else np.empty(0, np.int64)
        new = np.where(self.possible[station], ways.min(axis=2), np.inf)
        return self._without(station, new, barred), back

    def _ways(self, station: int, step: Step, costs: Floats, barred: BarredSteps) -> Floats:
        """(p, k, m, b, w) seconds to each state by way of each turn before it."""
        cost = step.seconds
        banned = [one for one in barred.get(station, ()) if one[1] >= 0]
        if banned:
            cost = cost.copy()
            for turn, before, branch in banned:
                cost[turn, before, branch] = np.inf
        ways = costs[:, step.before]
        wound = np.argwhere(step.windings.any(axis=-1))
        for turn, m, branch in wound:
            digits = self.windings.turns - self.windings.least - step.windings[turn, m, branch]
            there = ((digits >= 0) & (digits < self.windings.sizes)).all(axis=1)
            source = np.where(there, digits @ self.windings.strides, 0)
            taken = costs[:, step.before[turn, m], branch][:, source]
            ways[:, turn, m, branch] = np.where(there, taken, np.inf)
        ways += cost[..., None]
        joints = self.problem.stations[station].joints[:, None]
        within = self.windings.inside(joints, step.below, step.above)
        return np.asarray(np.where(within, ways, np.inf))

    def _jumped(self, station: int, costs: Floats) -> tuple[Floats, NDArray[np.int64]]:
        """After a joint move from any state (k, b, w) to any other."""
        one, other = self.problem.stations[station - 1], self.problem.stations[station]
        speeds = self.robot.speeds
        before = self.windings.joints(one.joints).reshape(-1, len(speeds)) / speeds
        after = self.windings.joints(other.joints).reshape(-1, len(speeds)) / speeds
        flat = costs.ravel()
        sources = np.flatnonzero(np.isfinite(flat))
        best = sources[flat[sources].argmin()]
        alike = station in self.problem.alike
        if not alike:  # what comes over the best one as cheaply leads nowhere cheaper
            way = np.sqrt(np.square(before[sources] - before[best]).sum(axis=1))
            sources = sources[(flat[sources] < flat[best] + way) | (sources == best)]
        goals = np.flatnonzero(self.possible[station])
        new, back = np.full(len(after), np.inf), np.zeros(len(after), dtype=np.int64)
        size = max(_STATE_PAIRS_AT_ONCE // max(len(sources), 1), 1)
        per_before, per_after = (costs[0].size, self.possible[station][0].size)
        for start in range(0, len(goals), size):
            some = goals[start : start + size]
            square = np.square(before[sources]).sum(axis=1)[:, None]
            square = square + np.square(after[some]).sum(axis=1)
            square -= 2.0 * before[sources] @ after[some].T
            ways = flat[sources][:, None] + np.sqrt(np.maximum(square, 0.0))
            if alike:
                ways[(sources // per_before)[:, None] != some // per_after] = np.inf
            new[some], back[some] = ways.min(axis=0), sources[ways.argmin(axis=0)]
        shape = self.possible[station].shape
        new = new.reshape(shape) + self._away(station)[:, None, None]
        return new, back.reshape(shape)

    # ---------------------------------------------------------------------------- backwards

    def _traced(
        self,
        costs: Floats,
        back: dict[int, NDArray[np.int64]],
        entered: dict[int, Floats],
        barred: BarredSteps,
    ) -> FoundPath:
        cost = float(costs.min())
        state = _state(int(costs.argmin()), costs.shape)
        station = len(self.problem.stations) - 1
        states = [state]
        starts = {end: start for start, end in self.pins.items()}
        while station > 0:
            start = starts.get(station)
            if start is not None and start in entered:
                alone = np.full_like(entered[start], np.inf)
                alone[state[0]] = entered[start][state[0]]
                pointers, inner = {}, alone[None]
                for at in range(start + 1, station + 1):
                    inner, pointers[at] = self._onwards(at, inner, barred)
                for at in range(station, start, -1):
                    state = self._came(at, state, pointers[at])
                    states.append(state)
                station = start
                continue
            state = self._came(station, state, back[station])
            states.append(state)
            station -= 1
        states.reverse()
        joints = np.array(
            [
                self._joints(one, state)
                for one, state in zip(self.problem.stations, states, strict=True)
            ]
        )
        return FoundPath(states, joints, cost)

    def _joints(self, station: Station, state: TurnState) -> Floats:
        out = station.joints[state[0], state[1]].copy()
        out[self.windings.axes] += 360.0 * self.windings.turns[state[2]]
        return np.asarray(out)

    def _came(self, station: int, state: TurnState, back: NDArray[np.int64]) -> TurnState:
        turn, branch, wound = state
        step = self.problem.steps[station - 1]
        if step is None:
            return _state(int(back[state]), self.possible[station - 1].shape)
        m = int(back[turn, branch, wound])
        digits = self.windings.turns[wound] - self.windings.least
        digits = digits - step.windings[turn, m, branch]
        return int(step.before[turn, m]), branch, int(digits @ self.windings.strides)


def _state(number: int, shape: tuple[int, ...]) -> TurnState:
    turn, branch, wound = np.unravel_index(number, shape)
    return int(turn), int(branch), int(wound)
