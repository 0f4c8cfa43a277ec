"""A way through the joints of a robot by OMPL's RRTConnect.

The straight moves come first. Then two trees of straight moves, one from the start and one from all
goals, grow to random places and to each other (Kuffner and LaValle, 2000) until they meet. Every
move is proven by `Space.clear`, so no place between two states is left out. A tool that has to stay
in a cone takes the trees of `leaning`.
"""

from __future__ import annotations

import gc
import time
from dataclasses import dataclass
from types import ModuleType
from typing import Any, Final

import numpy as np

from assistant.base.arrays import Floats
from assistant.base.diagnostics import Refused
from assistant.cell.planning.leaning import ConeMoves, ConeTrees
from assistant.cell.planning.rules import NO_PLANNER
from assistant.cell.planning.space import Space

LONGEST_MOVE: Final = 0.15
"""Of the way from one corner of the limits to the other, the longest move of a tree."""
ENDLESS_AXIS_RANGE: Final = 360.0
"""degrees (mm) about start and goals, to which an axis without an end is held."""


@dataclass(frozen=True, slots=True, eq=False)
class SearchResult:
    """What a search found: rows (n, a) of joints from start to a goal, None if nothing.

    nearest: (a,) what came nearest to a goal of all that can be reached. seconds: it took.
    """

    rows: Floats | None
    nearest: Floats
    seconds: float


def search_path(
    space: Space, start: Floats, goals: Floats, *, seconds: float = 10.0, seed: int = 1
) -> SearchResult:
    """From joints (a,) to one of goals (k, a), which are free, in at most so many seconds.

    seed: of all that is random; one seed gives one way, unless the time ends the search.
    Raises Refused without OMPL, if no straight move is free.
    """
    begun = time.monotonic()
    straight = np.flatnonzero(space.clear(np.repeat(start[None], len(goals), axis=0), goals))
    if len(straight):
        lengths = space.length(start, goals[straight])
        goal = goals[straight[int(np.argmin(lengths))]]
        return SearchResult(np.stack([start, goal]), goal, time.monotonic() - begun)
    trees: _PlannerTrees | ConeTrees
    if space.cone is None:
        trees = _PlannerTrees(space, start, goals)
    else:
        low, high = joint_bounds(space, start, goals)
        trees = ConeTrees(ConeMoves(space, space.cone, low, high), start, goals)
    rows = trees.grow(begun + seconds, seed)
    nearest = rows[-1] if rows is not None else trees.nearest()
    return SearchResult(rows, nearest, time.monotonic() - begun)


def joint_bounds(space: Space, start: Floats, goals: Floats) -> tuple[Floats, Floats]:
    """(a,) the least and the largest joints that are gone through between joints (k, a)."""
    ends = np.vstack([goals, start])
    low, high = space.robot.limits.T
    return (
        np.maximum(low, ends.min(axis=0) - ENDLESS_AXIS_RANGE),
        np.minimum(high, ends.max(axis=0) + ENDLESS_AXIS_RANGE),
    )


class _PlannerTrees:
    """The planner of OMPL, whose states are joints in seconds of their axes (`Space.weights`)."""

    def __init__(self, space: Space, start: Floats, goals: Floats) -> None:
        self.space, self.start, self.goals = space, start, goals
        self.low, self.high = joint_bounds(space, start, goals)
        self.moves: list[tuple[Floats, Floats]] = []

    def grow(self, end: float, seed: int) -> Floats | None:
        base, geometric, util = planner_library()
        util.setLogLevel(util.LogLevel.LOG_NONE)  # its console output is no part of ours
        util.RNG.setSeed(seed)
        weights = self.space.weights
        room = base.RealVectorStateSpace(len(weights))
        bounds = base.RealVectorBounds(len(weights))
        for axis, (low, high) in enumerate(
            zip(self.low * weights, self.high * weights, strict=True)
        ):
            bounds.setLow(axis, float(low) - BOUND_MARGIN)
            bounds.setHigh(axis, float(high) + BOUND_MARGIN)
        room.setBounds(bounds)
        info = base.SpaceInformation(room)
        # Both hold the other: kept here, that they are let go of before the interpreter ends.
        info.setMotionValidator(validator := _validator(base, info, self._clear))
        info.setStateValidityChecker(self._free)
        info.setup()
        problem = base.ProblemDefinition(info)
        problem.addStartState(self._state(info, self.start))
        states = base.GoalStates(info)
        for goal in self.goals:
            states.addState(self._state(info, goal))
        problem.setGoal(states)
        planner = geometric.RRTConnect(info)
        planner.setRange(LONGEST_MOVE * float(np.linalg.norm((self.high - self.low) * weights)))
        planner.setProblemDefinition(problem)
        planner.setup()
        planner.solve(base.PlannerTerminationCondition(lambda: time.monotonic() > end))
        rows = None
        if problem.hasExactSolution():
            found = problem.getSolutionPath().getStates()
            rows = np.array([self._joints(state) for state in found])
            rows[0] = self.start
            rows[-1] = self.goals[np.abs(self.goals - rows[-1]).max(axis=1).argmin()]
        del planner, problem, states, info, validator
        gc.collect()
        return rows

    def nearest(self) -> Floats:
        """Of all that moves lead to from the start, what is nearest to a goal."""
        after: dict[bytes, list[Floats]] = {}
        for one, other in self.moves:
            after.setdefault(one.tobytes(), []).append(other)
            after.setdefault(other.tobytes(), []).append(one)
        known, left, best = {self.start.tobytes()}, [self.start], self.start
        while left:
            place = left.pop()
            if self._apart(place) < self._apart(best):
                best = place
            for other in after.get(place.tobytes(), ()):
                if other.tobytes() not in known:
                    known.add(other.tobytes())
                    left.append(other)
        return best

    def _apart(self, row: Floats) -> float:
        return float(self.space.length(row, self.goals).min())

    def _state(self, info: Any, row: Floats) -> Any:
        state = info.allocState()
        for axis, value in enumerate((row * self.space.weights).tolist()):
            state[axis] = value
        return state

    def _joints(self, state: Any) -> Floats:
        values = np.array([state[axis] for axis in range(len(self.start))]) / self.space.weights
        # Start and goals to the last bit, and nothing outside the limits by rounding.
        return np.asarray(np.clip(np.round(values, STATE_DIGITS), self.low, self.high)) + 0.0

    def _free(self, state: Any) -> bool:
        return bool(self.space.free(self._joints(state)[None])[0])

    def _clear(self, one: Any, other: Any) -> bool:
        start, end = self._joints(one), self._joints(other)
        clear = bool(self.space.clear(start[None], end[None])[0])
        if clear:
            self.moves.append((start, end))
        return clear


BOUND_MARGIN: Final = 1e-9
"""seconds by which the bounds are wider than the limits: start and goal may lie on them."""
STATE_DIGITS: Final = 6
"""Of joints in degrees and mm."""


def planner_library() -> tuple[Any, Any, Any]:
    """OMPL's modules of spaces, of planners and of itself; raises Refused without it."""
    try:
        import ompl.base  # type: ignore[import-untyped]
        import ompl.geometric  # type: ignore[import-untyped]
        import ompl.util  # type: ignore[import-untyped]
    except ImportError:
        raise Refused(NO_PLANNER(), exit_status=2) from None
    found: tuple[ModuleType, ...] = (ompl.base, ompl.geometric, ompl.util)
    return found[0], found[1], found[2]


def _validator(base: Any, info: Any, clear: Any) -> Any:
    class Moves(base.MotionValidator):  # type: ignore[misc]
        """What asks us about a whole move."""

        def checkMotion(self, one: Any, other: Any, *_: Any) -> bool:  # noqa: N802 - OMPL's
            return bool(clear(one, other))

    return Moves(info)
