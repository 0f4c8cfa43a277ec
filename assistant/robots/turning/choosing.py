"""The turns of a run: first on a coarse grid of all turns, then closer about what was found."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Final

import numpy as np

from assistant.base.arrays import Floats, Rows, Truths
from assistant.program.motion import Kind
from assistant.robots.branches.choice import branches_at
from assistant.robots.motion.run import continued
from assistant.robots.robot import Robot
from assistant.robots.turning.search import FoundPath, NoPath, TurnProblem, TurnSearch
from assistant.robots.turning.stations import FreeRun, stations
from assistant.robots.turning.steps import Station, StationBuilder, Step

COARSE_STEP: Final = 10.0
"""degrees between the turns that are tried first."""
CLOSE_STEP: Final = 2.5
"""degrees between those that are tried about what was found."""
FINE_STEP: Final = 5.0
"""degrees between those that are tried where the coarse ones lead nowhere."""
STEPS_EACH_SIDE: Final = 4
"""So many of them to either side."""
FEW_STATIONS: Final = 400
"""Stations up to which these are tried."""
FEW_STATIONS_TOUCHING: Final = 50
"""The same where something is in the way."""
FEW_JUMPS: Final = 20
"""Joint moves up to which they are."""
MOST_TRIES: Final = 60
"""Ways that are looked for until one touches nothing."""

StationLeg = tuple[int, tuple[int, int], tuple[int, int]]
"""A station, and turn and branch of the one before and of its own."""
ClearTest = Callable[[Floats, Floats], Truths]
"""Whether the straight moves of the arm from joints (n, a) to (n, a) touch nothing, (n,)."""


@dataclass(frozen=True, slots=True, eq=False)
class ChosenTurns:
    """turns: (n,) degrees from how the targets were drawn. last: (a,) joints at the end."""

    turns: Floats
    last: Floats


@dataclass(frozen=True, slots=True)
class NoTurn:
    """row: up to which no turn leads. touching: whether only because something is in the way."""

    row: int
    touching: bool = False


def choose_turns(
    free_run: FreeRun, robot: Robot, clear: ClearTest | None = None
) -> ChosenTurns | NoTurn:
    """Turns with which a run is within reach and limits, keeps its branch, touches nothing and
    takes the axes the shortest way.

    clear: None without a cell.
    """
    looker = StationBuilder(free_run, robot)
    found = _search_grid(_Grid(looker, COARSE_STEP), clear)
    if isinstance(found, NoTurn) and _few(free_run, found):
        found = _search_grid(_Grid(looker, FINE_STEP), clear)
    if isinstance(found, NoTurn):
        return found
    closer = _search_grid(_Grid(looker, CLOSE_STEP, found), clear)
    return found.chosen() if isinstance(closer, NoTurn) else closer.chosen()


def _few(free_run: FreeRun, found: NoTurn) -> bool:
    jumps = int(np.count_nonzero(free_run.run.kinds == Kind.JOINT))
    most = FEW_STATIONS_TOUCHING if found.touching else FEW_STATIONS
    return len(stations(free_run, COARSE_STEP)) <= most and jumps <= FEW_JUMPS


class _Grid:
    """A run with turns to choose from: all, `step` degrees apart, or those about a way."""

    def __init__(self, looker: StationBuilder, step: float, about: _GridPath | None = None) -> None:
        self.looker, self.free_run, self.step, self.about = looker, looker.free_run, step, about
        self.rows: Rows = stations(self.free_run, COARSE_STEP) if about is None else about.grid.rows
        self.ramp = self._ramp()
        robot = looker.robot
        every = tuple(range(robot.branches))
        self.stations: list[Station] = []
        for at, row in enumerate(self.rows.tolist()):
            settled = float(self.free_run.fixed[row])
            if np.isfinite(settled):
                turns = np.array([settled])
            elif about is None:
                turns = np.arange(0.0, 360.0, step) + self.ramp[at]
            else:
                turns = about.turns[at] + step * np.arange(-STEPS_EACH_SIDE, STEPS_EACH_SIDE + 1)
            branches = every if about is None else (about.branches[at],)
            self.stations.append(looker.station(row, turns, branches))
        self.reached = [bool(one.possible.any()) for one in self.stations]
        self.steps = [self._step(at) for at in range(1, len(self.rows)) if all(self.reached)]

    def _step(self, at: int) -> Step | None:
        one, other = self.stations[at - 1], self.stations[at]
        if self.free_run.run.kinds[other.row] == Kind.JOINT:
            return None
        ramp = float(self.ramp[at] - self.ramp[at - 1])
        settled = np.isfinite(self.free_run.fixed[[one.row, other.row]]).any()
        return self.looker.step(one, other, ramp, self.step / 2.0 + 1e-6 if settled else 0.0)

    def _ramp(self) -> Floats:
        """(s,) degrees by which the turns to choose from are on, so that what comes back to a
        target finds the turn again that it has there.
        """
        free_run, rows = self.free_run, self.rows
        out = np.zeros(len(rows))
        for one, other in self._ties():
            drawn = free_run.drawn[rows[other]] - free_run.drawn[rows[one]]
            off = out[one] + drawn - out[other]
            off -= 360.0 * np.round(off / 360.0)
            if abs(off) < 1e-9:
                continue
            seconds = np.cumsum(free_run.seconds[rows[one] : rows[other] + 1])
            whole = float(seconds[-1] - seconds[0])
            at = rows[one : other + 1] - rows[one]
            part = (seconds[at] - seconds[0]) / whole if whole > 0.0 else at / at[-1]
            out[one : other + 1] += off * part
            out[other + 1 :] += off
        return out

    def _ties(self) -> list[tuple[int, int]]:
        number = {row: at for at, row in enumerate(self.rows.tolist())}
        tied = self.free_run.tied
        return [
            (number[int(tied[row])], at)
            for at, row in enumerate(self.rows.tolist())
            if tied[row] >= 0 and not np.isfinite(self.free_run.fixed[row])
        ]

    def problem(self) -> TurnProblem:
        run, robot = self.free_run.run, self.looker.robot
        ties, end = [], 0
        for one, other in sorted(self._ties()):
            if other > one + 1 and one >= end:
                ties.append((one, other))
                end = other
        alike = frozenset(other for one, other in self._ties() if other == one + 1)
        same = branches_at(run.before, robot)
        drawn = self.free_run.drawn[self.rows]
        goes_on = continued(run)
        return TurnProblem(
            self.stations, self.steps, drawn, run.before, goes_on, same, tuple(ties), alike
        )

    def untied(self, turns: Floats) -> list[tuple[int, int]]:
        """Stations that have one target but not one turn."""
        out = []
        for one, other in self._ties():
            drawn = self.free_run.drawn[self.rows[other]] - self.free_run.drawn[self.rows[one]]
            off = turns[other] - turns[one] - drawn
            if abs(off - 360.0 * np.round(off / 360.0)) > 1e-3:
                out.append((one, other))
        return out


@dataclass(frozen=True, slots=True, eq=False)
class _GridPath:
    """A way through a grid. turns: (s,) degrees. branches: (s,)."""

    grid: _Grid
    found: FoundPath
    turns: Floats
    branches: list[int]

    @staticmethod
    def of(grid: _Grid, found: FoundPath) -> _GridPath:
        pairs = list(zip(grid.stations, found.states, strict=True))
        turns = np.array([one.turns[state[0]] for one, state in pairs])
        return _GridPath(grid, found, turns, [one.branches[state[1]] for one, state in pairs])

    def changes(self, at: int) -> tuple[float, float]:
        """The turn at a station, and the degrees from it to the next one."""
        ramp = float(self.grid.ramp[at + 1] - self.grid.ramp[at])
        change = float(self.turns[at + 1] - self.turns[at]) - ramp
        return float(self.turns[at]), change - 360.0 * round(change / 360.0) + ramp

    def chosen(self) -> ChosenTurns:
        free_run, grid = self.grid.free_run, self.grid
        out = np.empty(len(free_run))
        out[grid.rows] = self.turns
        for at, (one, other) in enumerate(pairwise(grid.stations)):
            if grid.steps[at] is not None and other.row > one.row + 1:
                turns = grid.looker.row_turns(one, other, self.changes(at))
                out[one.row + 1 : other.row] = turns[:-1]
        away = out - free_run.drawn
        return ChosenTurns(away - 360.0 * np.round(away / 360.0), self.found.joints[-1])

    def joints_to(self, at: int) -> Floats:
        """(s, a) joints on the way to a station, the one before included; alone its own where only
        a joint move leads there, whose way is that of its ends: the check looks at it.
        """
        grid = self.grid
        if not at or grid.steps[at - 1] is None:
            return self.found.joints[at : at + 1]
        one, other = grid.stations[at - 1 : at + 1]
        (before, branch, _), (turn, _, _) = self.found.states[at - 1 : at + 1]
        _, change = self.changes(at - 1)
        return grid.looker.along(one, other, (before, turn), branch, change)


def _search_grid(grid: _Grid, clear: ClearTest | None) -> _GridPath | NoTurn:
    """The cheapest way through a grid that touches nothing."""
    if not all(grid.reached):
        return NoTurn(int(grid.rows[grid.reached.index(False)]))
    problem = grid.problem()
    search = TurnSearch(problem, grid.looker.robot)
    barred: dict[int, set[tuple[int, int, int]]] = {}
    known: dict[StationLeg, bool] = {}
    for _ in range(MOST_TRIES):
        found = search.best(barred)
        if isinstance(found, NoPath):
            return NoTurn(int(grid.rows[found.station]), touching=bool(barred))
        way = _GridPath.of(grid, found)
        bad = [] if clear is None else _touching(way, clear, known)
        if not bad:
            untied = grid.untied(way.turns)
            return way if not untied else _with_first_turns(way, untied, clear)
        assert clear is not None
        for at in bad:
            _bar(way, at, clear, barred.setdefault(at, set()))
    return NoTurn(int(grid.rows[bad[0]]), touching=True)


def _touching(way: _GridPath, clear: ClearTest, known: dict[StationLeg, bool]) -> list[int]:
    """Stations on whose way something is touched. known: of legs whether they are clear."""
    states = way.found.states
    legs: list[StationLeg] = [(0, states[0][:2], states[0][:2])]
    legs += [(i + 1, one[:2], other[:2]) for i, (one, other) in enumerate(pairwise(states))]
    new = [leg for leg in legs if leg not in known]
    ways = [way.joints_to(at) for at, _, _ in new]
    known.update(zip(new, _all_clear(ways, clear), strict=True))
    return [leg[0] for leg in legs if not known[leg]]


def _all_clear(ways: list[Floats], clear: ClearTest) -> list[bool]:
    """Which of some ways (s, a) touch nothing."""
    if not ways:
        return []
    starts = np.concatenate([joints[:-1] if len(joints) > 1 else joints for joints in ways])
    ends = np.concatenate([joints[1:] if len(joints) > 1 else joints for joints in ways])
    of = np.repeat(np.arange(len(ways)), [max(len(joints) - 1, 1) for joints in ways])
    touched = set(of[~clear(starts, ends)].tolist())
    return [number not in touched for number in range(len(ways))]


def _bar(way: _GridPath, at: int, clear: ClearTest, barred: set[tuple[int, int, int]]) -> None:
    """Rules out what touches something at a station, or else on the ways to it, in one branch."""
    grid, station = way.grid, way.grid.stations[at]
    turn, branch, _ = way.found.states[at]
    joints = station.joints[:, branch]
    known = np.flatnonzero(station.possible[:, branch])
    for bad in known[~clear(joints[known], joints[known])].tolist():
        barred.add((bad, -1, branch))
    if (turn, -1, branch) in barred:
        return
    step = grid.steps[at - 1] if at else None
    if step is None:
        barred.add((turn, -1, branch))
        return
    one = grid.stations[at - 1]
    before = way.found.states[at - 1][0]
    m = int(np.flatnonzero(step.before[turn] == before)[0])
    barred.add((turn, m, branch))
    # As likely are the ways from other turns, and those of all turns with the same change.
    ramp = float(grid.ramp[at] - grid.ramp[at - 1])
    changes = station.turns[:, None] - one.turns[step.before] - ramp
    changes += ramp - 360.0 * np.round(changes / 360.0)
    like = np.abs(changes - changes[turn, m]) < 1e-6
    like[turn] = True
    like &= np.isfinite(step.seconds[:, :, branch])
    pairs = [(int(k), int(j)) for k, j in np.argwhere(like)]
    ways = [
        grid.looker.along(one, station, (int(step.before[k, j]), k), branch, float(changes[k, j]))
        for k, j in pairs
    ]
    for pair, free in zip(pairs, _all_clear(ways, clear), strict=True):
        if not free:
            barred.add((*pair, branch))


def _with_first_turns(
    way: _GridPath, untied: list[tuple[int, int]], clear: ClearTest | None
) -> _GridPath | NoTurn:
    """The way when targets that are come back to have the turn that they were first found with."""
    grid, free_run = way.grid, way.grid.free_run
    fixed = free_run.fixed.copy()
    for one, _ in untied:
        row, first = int(grid.rows[one]), way.turns[one] - free_run.drawn[grid.rows[one]]
        if np.isfinite(fixed[row]):
            first = fixed[row] - free_run.drawn[row]
        alike = _with_target(free_run, row)
        fixed[alike] = np.where(np.isnan(fixed[alike]), first + free_run.drawn[alike], fixed[alike])
    looker = StationBuilder(replace(free_run, fixed=fixed), grid.looker.robot)
    return _search_grid(_Grid(looker, grid.step, grid.about), clear)


def _with_target(free_run: FreeRun, row: int) -> Rows:
    """The rows that have the target of one."""
    first = np.arange(len(free_run))
    for at in np.flatnonzero(free_run.tied >= 0).tolist():
        first[at] = first[free_run.tied[at]]
    return np.flatnonzero(first == first[row])
