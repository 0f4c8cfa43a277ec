"""The cheapest way through the stations of a run: a turn, a branch and whole turns at each.

Dynamic programming: what the best way to every state of a station costs follows from the station
before. Along linear and circular moves the branch stays one and axes go on without a break; a joint
move leads from any state to any other. Where a run comes back to a target, all turns that it
can have there are followed side by side, and only those count that come back to themselves. No
other way through what there is to choose from costs less.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from assistant.base.arrays import Floats, Ints, Rows, Truths
from assistant.robots.robot import LIMIT_TOLERANCE, Robot
from assistant.robots.turning.steps import Station, Step

DRAWN_TURN_COST: Final = 1e-4
"""Seconds that a degree away from how a target was drawn has to save at the start of a chain."""
STATE_PAIRS_AT_ONCE: Final = 4_000_000
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


class Windings:
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
        self.windings = Windings(robot)
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
        return np.asarray(DRAWN_TURN_COST * np.abs(away - 360.0 * np.round(away / 360.0)))

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
        size = max(STATE_PAIRS_AT_ONCE // max(len(sources), 1), 1)
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


def turn_numbers(found: FoundPath) -> Rows:
    """(s,) the turns of a way, as numbers among those of each station."""
    return np.array([state[0] for state in found.states], dtype=np.intp)
