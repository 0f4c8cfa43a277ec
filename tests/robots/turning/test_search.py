"""The search through turns, branches and whole turns, against trying every way there is."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from assistant import robots
from assistant.base.arrays import Floats
from assistant.robots import Robot
from assistant.robots.free_turn_search import (
    FoundPath,
    NoPath,
    Station,
    Step,
    TurnProblem,
    TurnSearch,
)

ARM = robots.get("rv-2aj")
BRANCHES = (0, 1)
WHOLE = (-1, 0, 1)
"""Whole turns of J6, whose limits are 200 degrees to either side; J1 has none."""


def drawn(seed: int, kinds: str, ties: tuple[tuple[int, int], ...]) -> TurnProblem:
    """Stations of three turns each, with a step for each letter: `l` linear, `j` by the joints."""
    rng = np.random.default_rng(seed)
    stations, steps = [], list[Step | None]()
    for row in range(len(kinds) + 1):
        joints = rng.uniform(-60.0, 60.0, (3, 2, 5))
        joints[..., 4] = rng.uniform(-180.0, 180.0, (3, 2))
        possible = rng.random((3, 2)) < 0.85
        stations.append(Station(row, np.array([0.0, 120.0, 240.0]), BRANCHES, joints, possible))
    for kind in kinds:
        if kind == "j":
            steps.append(None)
            continue
        before = np.array([rng.permutation(3) for _ in range(3)])
        seconds = rng.uniform(0.1, 2.0, (3, 3, 2))
        seconds[rng.random((3, 3, 2)) < 0.15] = np.inf
        windings = np.zeros((3, 3, 2, 2), dtype=np.int64)
        windings[..., 1] = rng.choice([-1, 0, 1], (3, 3, 2), p=[0.15, 0.7, 0.15])
        above = np.zeros((3, 3, 2, 2))
        above[..., 1] = rng.choice([0.0, 30.0], (3, 3, 2))
        steps.append(Step(before, seconds, windings, -above, above))
    before_it = np.array(ARM.home, dtype=np.float64)
    same, apart = np.ones(ARM.branches, dtype=bool), np.zeros(len(stations))
    alike = frozenset[int]()
    return TurnProblem(stations, steps, apart, before_it, False, same, ties, alike)


def cheapest(problem: TurnProblem, robot: Robot) -> float:
    """Seconds of the cheapest way, all of them tried; infinite if there is none."""
    low, high = robot.limits[4]

    def least(states: list[tuple[int, int, int]], last: Floats) -> float:
        """Seconds of the cheapest way on from some states."""
        at = len(states)
        if at == len(problem.stations):
            return 0.0
        best = np.inf
        station, step = problem.stations[at], problem.steps[at - 1] if at else None
        for turn, branch, whole in product(range(3), BRANCHES, WHOLE):
            tied = [one for one, other in problem.ties if other == at]
            joints = station.joints[turn, branch].copy()
            joints[4] += 360.0 * whole
            if any(states[one][0] != turn for one in tied) or not station.possible[turn, branch]:
                continue
            if not low <= joints[4] <= high:
                continue
            if step is None:
                away = abs((station.turns[turn] + 180.0) % 360.0 - 180.0)
                cost = float(np.linalg.norm((joints - last) / robot.speeds)) + 1e-4 * away
            else:
                cost = gone(step, states[-1], (turn, branch, whole), joints[4], (low, high))
            if np.isfinite(cost):
                best = min(best, cost + least([*states, (turn, branch, whole)], joints))
        return best

    return least([], problem.before)


def gone(
    step: Step,
    one: tuple[int, int, int],
    other: tuple[int, int, int],
    angle: float,
    limits: tuple[float, float],
) -> float:
    """Seconds of one linear step from state to state."""
    turn, branch, whole = other
    came = [m for m in range(3) if step.before[turn, m] == one[0]]
    if not came or branch != one[1]:
        return float(np.inf)
    (m,) = came
    if whole != one[2] + step.windings[turn, m, branch, 1]:
        return float(np.inf)
    if angle + step.above[turn, m, branch, 1] > limits[1]:
        return float(np.inf)
    if angle + step.below[turn, m, branch, 1] < limits[0]:
        return float(np.inf)
    return float(step.seconds[turn, m, branch])


@pytest.mark.parametrize(
    ("kinds", "ties"),
    [("ll", ()), ("jl", ()), ("ljl", ()), ("jj", ()), ("lll", ((0, 3),)), ("jll", ((1, 3),))],
)
def test_no_other_way_costs_less(kinds: str, ties: tuple[tuple[int, int], ...]) -> None:
    found = 0
    for seed in range(8 if len(kinds) < 3 else 3):
        problem = drawn(seed, kinds, ties)
        expected = cheapest(problem, ARM)
        way = TurnSearch(problem, ARM).best({})
        if isinstance(way, NoPath):
            assert not np.isfinite(expected)
            continue
        assert way.cost == pytest.approx(expected, abs=1e-9)
        assert all(way.states[one][0] == way.states[other][0] for one, other in ties)
        found += 1
    assert found


def test_what_is_barred_is_not_gone() -> None:
    problem = drawn(3, "ll", ())
    search = TurnSearch(problem, ARM)
    way = search.best({})
    assert isinstance(way, FoundPath)
    turn, branch, _ = way.states[1]
    other = search.best({1: {(turn, -1, branch)}})
    assert isinstance(other, FoundPath)
    assert other.states[1][:2] != (turn, branch)
    assert other.cost > way.cost
