"""Search a path through the joints of a robot by OMPL's RRTConnect, and shorten it.

Straight moves are tried first. Then two trees of straight moves, one from the start and one from
all goals, grow to random positions and to each other (Kuffner and LaValle, 2000) until they meet.
`Space.clear` proves every move, so that no position between two states is left out.

For a tool that has to stay in a cone, however narrow, random joints are brought into the cone by
the least turn of the axes, and so is the middle of each move that leaves it, until the complete
path stays inside (Berenson, Srinivasa, Ferguson and Kuffner, 2009).
"""

from __future__ import annotations

import gc
import time
from types import ModuleType
from typing import Any, Final

import numpy as np

from assistant.base.arrays import Floats, Truths, norms
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Refused
from assistant.cell.findings import NO_PLANNER
from assistant.cell.planning.space import Cone, Space

_CONE_INSIDE: Final = 10.0
"""degrees that joints are brought inside the edge of a cone: moves between them bulge outwards."""
_CONE_ROUNDS: Final = 12
"""Rounds of moving joints into the cone."""
_MOST_TURN_A_ROUND: Final = 45.0
"""degrees that the tool is turned in a round."""
_CONE_TOLERANCE: Final = 0.02
"""degrees that joints which were brought into the cone may be off."""
_DIFFERENCE_STEP: Final = 0.01
"""degrees (mm) that joints are moved by to see how the tool turns."""
_WEAKEST_TURN: Final = 1e-2
"""Weakest effect, as a share of the strongest, that a joint may have on the tool's turn to be used
for it.
"""
_MOST_HALVINGS: Final = 7
"""Times that a move is halved until its parts stay in the cone."""
_MOST_DETOUR: Final = 2.5
"""Greatest length, as a multiple of a move, of the two moves that detour by way of its middle in
the cone.
"""
_LONGEST_STEP: Final = 0.15
"""Longest step towards a sample, as a share of the diagonal between the corners of the limits."""


_DRAWN_AT_ONCE: Final = 64
"""Joints that are drawn at random together."""


class _ConeMoves:
    """The cone of a space, and what is brought into it. low, high: (a,) of joints."""

    def __init__(self, space: Space, cone: Cone, low: Floats, high: Floats) -> None:
        self.space, self.cone, self.low, self.high = space, cone, low, high
        self.inner = max(cone.angle - _CONE_INSIDE, 0.0)
        self.direction = np.array(cone.direction) / np.linalg.norm(cone.direction)

    def brought(self, rows: Floats) -> tuple[Floats, Truths]:
        """Joints (n, a) brought into the cone and the limits; (n,) whether that was possible."""
        out = np.clip(rows, self.low, self.high)
        good = np.zeros(len(out), dtype=bool)
        some = np.arange(len(out))
        for _ in range(_CONE_ROUNDS):
            axes = self._axes(out[some])
            along = axes[:, 0] @ self.direction
            across = norms(np.cross(axes[:, 0], self.direction))
            off = np.degrees(np.arctan2(across, along)) - self.inner
            good[some] = off <= _CONE_TOLERANCE
            axes, off, some = (
                axes[off > _CONE_TOLERANCE],
                off[off > _CONE_TOLERANCE],
                some[off > _CONE_TOLERANCE],
            )
            if not len(some):
                break
            out[some] = np.clip(out[some] + self._back(axes, off), self.low, self.high)
        return out, good

    def _axes(self, rows: Floats) -> Floats:
        """(n, a + 1, 3) the axis of the tool at joints (n, a), and with each of them moved."""
        n, a = rows.shape
        near = rows[:, None] + _DIFFERENCE_STEP * np.vstack([np.zeros(a), np.eye(a)])
        return self.cone.axes(self.space.tip(near.reshape(-1, a))[1]).reshape(n, a + 1, 3)

    def _back(self, axes: Floats, angles: Floats) -> Floats:
        """(n, a) the least motion, by the time it takes, that turns the tool towards the cone."""
        axis = axes[:, 0]
        to = self.direction - (axis @ self.direction)[:, None] * axis
        flat = norms(to) < 1e-6  # upside down: any way round
        to[flat] = np.cross(axis[flat], np.eye(3)[np.abs(axis[flat]).argmin(axis=1)])
        to *= (np.radians(np.minimum(angles, _MOST_TURN_A_ROUND)) / np.maximum(norms(to), 1e-9))[
            :, None
        ]
        rates = (
            (axes[:, 1:] - axis[:, None]).transpose(0, 2, 1)
            / _DIFFERENCE_STEP
            * self.space.robot.speeds
        )
        motion = np.linalg.pinv(rates, rcond=_WEAKEST_TURN) @ to[..., None]
        return np.asarray(motion[..., 0] * self.space.robot.speeds)

    def chain(self, start: Floats, end: Floats) -> Floats:
        """(k, a) joints by which straight moves in the cone lead from joints (a,) to others.

        The start first. Where that cannot be, it ends before.
        """
        rows, proven = np.stack([start, end]), np.zeros(1, dtype=bool)
        for _ in range(_MOST_HALVINGS):
            proven[~proven] = self.space.upright(rows[:-1][~proven], rows[1:][~proven])
            open_ = np.flatnonzero(~proven)
            if not len(open_):
                return rows
            one, other = rows[open_], rows[open_ + 1]
            middle, good = self.brought((one + other) / 2.0)
            both = self.space.length(one, middle) + self.space.length(middle, other)
            good &= both <= _MOST_DETOUR * self.space.length(one, other)
            if not good.all():
                bad = int(np.argmin(good))
                rows, proven = rows[: open_[bad] + 1], proven[: open_[bad]]
                open_, middle = open_[:bad], middle[:bad]
            rows = np.insert(rows, open_ + 1, middle, axis=0)
            proven = np.insert(proven, open_, False)
            if len(rows) < 2:
                return rows
        proven[~proven] = self.space.upright(rows[:-1][~proven], rows[1:][~proven])
        return rows if proven.all() else rows[: int(np.argmin(proven)) + 1]

    def clear_chain(self, start: Floats, end: Floats) -> Floats:
        """Return the chain of `chain` up to the first move that a body blocks."""
        rows = self.chain(start, end)
        free = self.space.clear(rows[:-1], rows[1:])
        return rows if free.all() else rows[: int(np.argmin(free)) + 1]


class _ConeTree:
    """Joints (a,) with, for each, the number of the one before it; -1 for a root."""

    def __init__(self) -> None:
        self.rows: list[Floats] = []
        self.before: list[int] = []

    def add(self, row: Floats, before: int) -> int:
        self.rows.append(row)
        self.before.append(before)
        return len(self.rows) - 1

    def back(self, number: int) -> list[Floats]:
        """From a place to its root."""
        out = []
        while number >= 0:
            out.append(self.rows[number])
            number = self.before[number]
        return out


class _ConeTrees:
    """Two trees of moves in a cone, from joints (a,) and from goals (k, a)."""

    def __init__(self, leaning: _ConeMoves, start: Floats, goals: Floats) -> None:
        self.leaning, self.space = leaning, leaning.space
        self.here, self.there = _ConeTree(), _ConeTree()
        self.goals = goals
        for tree, roots in ((self.here, start[None]), (self.there, goals)):
            for root in roots:
                number = tree.add(root, -1)
                inside, good = leaning.brought(root[None])
                moved = float(np.abs(inside[0] - root).max()) > 0.0
                if moved and good[0] and self.space.clear(root[None], inside)[0]:
                    tree.add(inside[0], number)

    def grow(self, end: float, seed: int) -> Floats | None:
        """(n, a) joints from the start to a goal, None if the trees did not meet in time.

        end: of the time, by `time.monotonic`. seed: of what is random.
        """
        draw = np.random.default_rng(seed)
        low, high = self.leaning.low, self.leaning.high
        reach = _LONGEST_STEP * float(self.space.length(low, high))
        for goal in range(len(self.there.rows)):
            if time.monotonic() > end:
                return None
            if (met := self._extended(self.here, 0, self.there.rows[goal])) is not None:
                return self._whole(met, goal)
        one, other = self.here, self.there
        drawn: list[Floats] = []
        while time.monotonic() < end:
            if not drawn:
                some, good = self.leaning.brought(
                    draw.uniform(low, high, (_DRAWN_AT_ONCE, len(low)))
                )
                drawn = list(some[good])
                continue
            wanted = drawn.pop()
            near = self._nearest(one, wanted)
            way = wanted - one.rows[near]
            part = min(1.0, reach / max(float(self.space.length(0.0 * way, way)), 1e-9))
            to, good = self.leaning.brought((one.rows[near] + part * way)[None])
            count = len(one.rows)
            if good[0]:
                self._extended(one, near, to[0])
            if len(one.rows) > count:
                new = len(one.rows) - 1
                met = self._extended(other, self._nearest(other, one.rows[new]), one.rows[new])
                if met is not None:
                    return self._whole(new, met) if one is self.here else self._whole(met, new)
            one, other = other, one
        return None

    def _extended(self, tree: _ConeTree, number: int, to: Floats) -> int | None:
        """Goes from a place of a tree towards joints (a,); the place there if they are reached."""
        rows = self.leaning.clear_chain(tree.rows[number], to)
        for row in rows[1:]:
            number = tree.add(row, number)
        return number if np.array_equal(rows[-1], to) else None

    def _nearest(self, tree: _ConeTree, row: Floats) -> int:
        return int(np.argmin(self.space.length(np.array(tree.rows), row)))

    def _whole(self, here: int, there: int) -> Floats:
        """The way through a place that both trees have, under its numbers in them."""
        return np.array([*self.here.back(here)[::-1], *self.there.back(there)[1:]])

    def nearest(self) -> Floats:
        """Return the joints nearest to a goal among all that moves reach from the start."""
        rows = np.array(self.here.rows)
        return np.asarray(rows[int(np.argmin(self.space.length(rows[:, None], self.goals).min(1)))])


_LONGEST_MOVE: Final = 0.15
"""Longest move of a tree, as a share of the diagonal between the corners of the limits."""
_ENDLESS_AXIS_RANGE: Final = 360.0
"""degrees (mm) about start and goals, to which an axis without an end is held."""


@dataclass(frozen=True, slots=True, eq=False)
class SearchResult:
    """Result of a search: rows (n, a) of joints from start to a goal, None if no path was found.

    nearest: (a,) the reachable joints that are nearest to a goal. seconds: duration of the search.
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
    trees: _PlannerTrees | _ConeTrees
    if space.cone is None:
        trees = _PlannerTrees(space, start, goals)
    else:
        low, high = _joint_bounds(space, start, goals)
        trees = _ConeTrees(_ConeMoves(space, space.cone, low, high), start, goals)
    rows = trees.grow(begun + seconds, seed)
    nearest = rows[-1] if rows is not None else trees.nearest()
    return SearchResult(rows, nearest, time.monotonic() - begun)


def _joint_bounds(space: Space, start: Floats, goals: Floats) -> tuple[Floats, Floats]:
    """Return the least and the largest joints (a,) that a path between joints (k, a) may use."""
    ends = np.vstack([goals, start])
    low, high = space.robot.limits.T
    return (
        np.maximum(low, ends.min(axis=0) - _ENDLESS_AXIS_RANGE),
        np.minimum(high, ends.max(axis=0) + _ENDLESS_AXIS_RANGE),
    )


class _PlannerTrees:
    """The planner of OMPL, whose states are joints in seconds of their axes (`Space.weights`)."""

    def __init__(self, space: Space, start: Floats, goals: Floats) -> None:
        self.space, self.start, self.goals = space, start, goals
        self.low, self.high = _joint_bounds(space, start, goals)
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
            bounds.setLow(axis, float(low) - _BOUND_MARGIN)
            bounds.setHigh(axis, float(high) + _BOUND_MARGIN)
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
        planner.setRange(_LONGEST_MOVE * float(np.linalg.norm((self.high - self.low) * weights)))
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
        """Return the joints nearest to a goal among all that moves reach from the start."""
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
        return np.asarray(np.clip(np.round(values, _STATE_DIGITS), self.low, self.high)) + 0.0

    def _free(self, state: Any) -> bool:
        return bool(self.space.free(self._joints(state)[None])[0])

    def _clear(self, one: Any, other: Any) -> bool:
        start, end = self._joints(one), self._joints(other)
        clear = bool(self.space.clear(start[None], end[None])[0])
        if clear:
            self.moves.append((start, end))
        return clear


_BOUND_MARGIN: Final = 1e-9
"""seconds by which the bounds are wider than the limits: start and goal may lie on them."""
_STATE_DIGITS: Final = 6
"""Decimals of joints in degrees and mm."""


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
        """Validator by which OMPL asks whether a complete move is clear."""

        def checkMotion(self, one: Any, other: Any, *_: Any) -> bool:  # noqa: N802 - OMPL's
            return bool(clear(one, other))

    return Moves(info)


_SHORTCUT_ROUNDS: Final = 30
"""Rounds of random shortcuts."""
_SHORTCUTS_AT_ONCE: Final = 8
"""Shortcuts that are tried together."""
_CORNER_ROOM: Final = 4.0
"""mm beyond the margins that are left in a shortcut for its corners to be rounded in."""
_NO_LENGTH: Final = 1e-12
"""Duration in seconds below which a path has no length."""
_PROGRAM_DIGITS: Final = 2
"""Decimals of joints in degrees and mm between start and goal: every language can express them."""
_LEAST_SAVING: Final = 1e-3
"""Least saving of a shortcut, as a share of the length of a path."""


def shorten_path(
    space: Space,
    rows: Floats,
    goals: Floats | None = None,
    *,
    rounds: int = _SHORTCUT_ROUNDS,
    seed: int = 1,
) -> Floats:
    """A way through joints (n, a) without what can be left out, and with corners cut.

    Between two places of the way that are drawn at random the straight move is taken if it is
    free (Geraerts and Overmars, 2007), in each round the one that saves most. In a cone where none
    is, moves that are brought into it are tried. goals: (k, a) joints at which the way may end as
    well, such as other turns of an axis.
    """
    cone = space.cone
    leaning = None if cone is None else _ConeMoves(space, cone, *space.robot.limits.T)
    rows = _without_corners(space, _to_nearer_goal(space, rows, goals))
    draw = np.random.default_rng(seed)
    for _ in range(rounds):
        if len(rows) < 3:
            break
        shorter = _shortcut(space, leaning, rows, draw)
        rows = rows if shorter is None else shorter
        straighter = _straightened(space, rows, draw)
        rows = rows if straighter is None else straighter
    rows = _without_corners(space, _to_nearer_goal(space, rows, goals))
    return _in_few_digits(space, rows)


def _in_few_digits(space: Space, rows: Floats) -> Floats:
    """The way with places that a program can state, if it is as free with them."""
    low, high = space.robot.limits.T
    stated = rows.copy()
    stated[1:-1] = np.clip(np.round(rows[1:-1], _PROGRAM_DIGITS), low, high) + 0.0
    return stated if space.clear(stated[:-1], stated[1:]).all() else rows


def _to_nearer_goal(space: Space, rows: Floats, goals: Floats | None) -> Floats:
    """The way (n, a) with its end at another of goals (k, a), if that is shorter."""
    if goals is None or len(goals) < 2:
        return rows
    for change in (_with_turn_spread, _straight_to):
        shorter = change(space, rows, goals)
        rows = rows if shorter is None else shorter
    return rows


def _with_turn_spread(space: Space, rows: Floats, goals: Floats) -> Floats | None:
    """The way with what another goal differs by spread over all of it: a turn less of an axis."""
    lengths = space.length(rows[:-1], rows[1:])
    gone = np.concatenate([[0.0], np.cumsum(lengths)])
    part = gone / max(gone[-1], _NO_LENGTH)
    ways = rows + part[:, None] * (goals - rows[-1])[:, None]
    ways[:, -1] = goals
    saved = gone[-1] - space.length(ways[:, :-1], ways[:, 1:]).sum(axis=1)
    for goal in np.argsort(-saved, kind="stable")[:_SHORTCUTS_AT_ONCE]:
        way = ways[goal]
        if saved[goal] <= _LEAST_SAVING * gone[-1]:
            break
        if space.robot.inside(way).all() and space.clear(way[:-1], way[1:], _CORNER_ROOM).all():
            return np.asarray(way)
    return None


def _straight_to(space: Space, rows: Floats, goals: Floats) -> Floats | None:
    """The way that goes straight to another goal from one of its places."""
    left = np.cumsum(space.length(rows[:-1], rows[1:])[::-1])[::-1]
    saved = left[:, None] - space.length(rows[:-1, None], goals)
    place, goal = np.divmod(
        np.argsort(-saved, axis=None, kind="stable")[:_SHORTCUTS_AT_ONCE], len(goals)
    )
    some = saved[place, goal] > _LEAST_SAVING * left[0]
    place, goal = place[some], goal[some]
    free = np.flatnonzero(space.clear(rows[place], goals[goal], _CORNER_ROOM))
    if not len(free):
        return None
    best = int(free[0])
    return np.concatenate([rows[: place[best] + 1], goals[goal[best]][None]])


def _straightened(space: Space, rows: Floats, draw: np.random.Generator) -> Floats | None:
    """The way with an axis that goes straight between two of its places while others go as before.

    Axes turn back and forth on the way of a tree; a shortcut of all of them may not be free.
    """
    first, last = np.sort(draw.choice(len(rows), 2, replace=False))
    axis = int(draw.integers(rows.shape[1]))
    if last - first < 2:
        return None
    old = rows[first : last + 1]
    gone = np.concatenate([[0.0], np.cumsum(space.length(old[:-1], old[1:]))])
    new = old.copy()
    new[:, axis] = old[0, axis] + gone / max(gone[-1], _NO_LENGTH) * (old[-1, axis] - old[0, axis])
    length = space.length(new[:-1], new[1:]).sum()
    whole = space.length(rows[:-1], rows[1:]).sum()
    if (
        gone[-1] - length <= _LEAST_SAVING * whole
        or not space.clear(new[:-1], new[1:], _CORNER_ROOM).all()
    ):
        return None
    return np.concatenate([rows[:first], new, rows[last + 1 :]])


def _without_corners(space: Space, rows: Floats) -> Floats:
    """From each place on straight to the last one that can be reached so."""
    kept, at = [0], 0
    while at < len(rows) - 1:
        later = np.arange(at + 1, len(rows))
        clear = space.clear(np.repeat(rows[at][None], len(later), axis=0), rows[later])
        clear[0] = True  # of the way itself
        at = int(later[np.flatnonzero(clear)[-1]])
        kept.append(at)
    return rows[kept]


def _shortcut(
    space: Space, leaning: _ConeMoves | None, rows: Floats, draw: np.random.Generator
) -> Floats | None:
    """The way with the best of some shortcuts, None if none is free."""
    lengths = space.length(rows[:-1], rows[1:])
    gone = np.concatenate([[0.0], np.cumsum(lengths)])
    places = np.sort(draw.uniform(0.0, gone[-1], (_SHORTCUTS_AT_ONCE, 2)), axis=1)
    legs = np.clip(np.searchsorted(gone, places, side="right") - 1, 0, len(lengths) - 1)
    part = (places - gone[legs]) / np.where(lengths[legs] > 0.0, lengths[legs], 1.0)
    ends = rows[legs] + part[..., None] * (rows[legs + 1] - rows[legs])
    saved = places[:, 1] - places[:, 0] - space.length(ends[:, 0], ends[:, 1])
    some = np.flatnonzero((legs[:, 0] < legs[:, 1]) & (saved > _LEAST_SAVING * gone[-1]))
    free = some[space.clear(ends[some, 0], ends[some, 1], _CORNER_ROOM)]
    if len(free):
        best = int(free[int(np.argmax(saved[free]))])
        between = ends[best]
    elif leaning is not None and len(some):  # no straight move stays in the cone: several may
        best = int(some[int(np.argmax(saved[some]))])
        between = leaning.clear_chain(*ends[best])
        length = float(space.length(between[:-1], between[1:]).sum())
        apart = float(places[best, 1] - places[best, 0])
        if (
            not np.array_equal(between[-1], ends[best, 1])
            or apart - length <= _LEAST_SAVING * gone[-1]
        ):
            return None
    else:
        return None
    first, last = legs[best]
    return np.concatenate([rows[: first + 1], between, rows[last + 1 :]])
