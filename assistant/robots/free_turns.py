"""Choose turns of tools about their own axis where a program leaves them free.

The turns of a run are chosen on a coarse grid of all turns first, then on a finer one around the
result. The program gets the turned targets, and no turn is free afterwards.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any, Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats, Rows, Truths
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Declared, Diagnostic, fold, has_errors
from assistant.program.expressions import Apply, Expression, Name, TargetValue, Verbatim
from assistant.program.geometry import Pose, Target, Tool
from assistant.program.motion import UNSTATED, Kind, Path
from assistant.program.program import Program
from assistant.program.rewriting import records, rewrite
from assistant.program.statements import Follow, Move, MoveCircular, MoveJoints, Opaque, Travel
from assistant.robots import findings as rules
from assistant.robots.configurations import BACK
from assistant.robots.free_turn_search import (
    UPRIGHT,
    FoundPath,
    FreeRun,
    NoPath,
    Station,
    StationBuilder,
    Step,
    TurnProblem,
    TurnSearch,
    free_run_of,
    stations,
)
from assistant.robots.motion.branch_choice import branches_at
from assistant.robots.motion.run import Run, continued
from assistant.robots.program_solution import solve_program
from assistant.robots.program_values import Names
from assistant.robots.robot import Robot
from assistant.robots.solved_program import SolvedProgram, SolvedRun

_COARSE_STEP: Final = 10.0
"""degrees between the turns that are tried first."""
_CLOSE_STEP: Final = 2.5
"""degrees between those that are tried about what was found."""
_FINE_STEP: Final = 5.0
"""degrees between those that are tried where the coarse ones lead nowhere."""
_STEPS_EACH_SIDE: Final = 4
"""So many of them to either side."""
_FEW_STATIONS: Final = 400
"""Stations up to which these are tried."""
_FEW_STATIONS_TOUCHING: Final = 50
"""The same where something is in the way."""
_FEW_JUMPS: Final = 20
"""Joint moves up to which they are."""
_MOST_TRIES: Final = 60
"""Largest number of paths that are searched until one is free of contact."""

_StationLeg = tuple[int, tuple[int, int], tuple[int, int]]
"""A station, with turn and branch of the station before and of this one."""
ClearTest = Callable[[Floats, Floats], Truths]
"""Test whether the straight joint moves of the arm from (n, a) to (n, a) are free of contact,
(n,).
"""


@dataclass(frozen=True, slots=True, eq=False)
class _ChosenTurns:
    """turns: (n,) degrees from how the targets were drawn. last: (a,) joints at the end."""

    turns: Floats
    last: Floats


@dataclass(frozen=True, slots=True)
class _NoTurn:
    """row: up to which no turn leads. touching: whether only because something is in the way."""

    row: int
    touching: bool = False


def _choose_turns(
    free_run: FreeRun, robot: Robot, clear: ClearTest | None = None
) -> _ChosenTurns | _NoTurn:
    """Turns with which a run is within reach and limits, keeps its branch, touches nothing and
    takes the axes the shortest way.

    clear: None without a cell.
    """
    looker = StationBuilder(free_run, robot)
    found = _search_grid(_Grid(looker, _COARSE_STEP), clear)
    if isinstance(found, _NoTurn) and _few(free_run, found):
        found = _search_grid(_Grid(looker, _FINE_STEP), clear)
    if isinstance(found, _NoTurn):
        return found
    closer = _search_grid(_Grid(looker, _CLOSE_STEP, found), clear)
    return found.chosen() if isinstance(closer, _NoTurn) else closer.chosen()


def _few(free_run: FreeRun, found: _NoTurn) -> bool:
    jumps = int(np.count_nonzero(free_run.run.kinds == Kind.JOINT))
    most = _FEW_STATIONS_TOUCHING if found.touching else _FEW_STATIONS
    return len(stations(free_run, _COARSE_STEP)) <= most and jumps <= _FEW_JUMPS


class _Grid:
    """A run with turns to choose from: all, `step` degrees apart, or those about a way."""

    def __init__(self, looker: StationBuilder, step: float, about: _GridPath | None = None) -> None:
        self.looker, self.free_run, self.step, self.about = looker, looker.free_run, step, about
        self.rows: Rows = (
            stations(self.free_run, _COARSE_STEP) if about is None else about.grid.rows
        )
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
                turns = about.turns[at] + step * np.arange(-_STEPS_EACH_SIDE, _STEPS_EACH_SIDE + 1)
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

    def chosen(self) -> _ChosenTurns:
        free_run, grid = self.grid.free_run, self.grid
        out = np.empty(len(free_run))
        out[grid.rows] = self.turns
        for at, (one, other) in enumerate(pairwise(grid.stations)):
            if grid.steps[at] is not None and other.row > one.row + 1:
                turns = grid.looker.row_turns(one, other, self.changes(at))
                out[one.row + 1 : other.row] = turns[:-1]
        away = out - free_run.drawn
        return _ChosenTurns(away - 360.0 * np.round(away / 360.0), self.found.joints[-1])

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


def _search_grid(grid: _Grid, clear: ClearTest | None) -> _GridPath | _NoTurn:
    """The cheapest way through a grid that touches nothing."""
    if not all(grid.reached):
        return _NoTurn(int(grid.rows[grid.reached.index(False)]))
    problem = grid.problem()
    search = TurnSearch(problem, grid.looker.robot)
    barred: dict[int, set[tuple[int, int, int]]] = {}
    known: dict[_StationLeg, bool] = {}
    for _ in range(_MOST_TRIES):
        found = search.best(barred)
        if isinstance(found, NoPath):
            return _NoTurn(int(grid.rows[found.station]), touching=bool(barred))
        way = _GridPath.of(grid, found)
        bad = [] if clear is None else _touching(way, clear, known)
        if not bad:
            untied = grid.untied(way.turns)
            return way if not untied else _with_first_turns(way, untied, clear)
        assert clear is not None
        for at in bad:
            _bar(way, at, clear, barred.setdefault(at, set()))
    return _NoTurn(int(grid.rows[bad[0]]), touching=True)


def _touching(way: _GridPath, clear: ClearTest, known: dict[_StationLeg, bool]) -> list[int]:
    """Stations on whose way something is touched. known: of legs whether they are clear."""
    states = way.found.states
    legs: list[_StationLeg] = [(0, states[0][:2], states[0][:2])]
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
) -> _GridPath | _NoTurn:
    """Search the path again so that repeated targets keep the turn that was first found for
    them.
    """
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


_LEAST_TURN: Final = 1e-9
"""Least turn in degrees that counts as a turn."""


def without_free_turns(program: Program) -> Program:
    """The program with the turns as they are."""
    if not any(tool.free_turn for tool in program.tools.values()):
        return program
    tools = {name: replace(tool, free_turn=False) for name, tool in program.tools.items()}
    return replace(program, tools=tools)


def with_chosen_turns(
    program: Program, robot: Robot, clear: Sequence[ClearTest] = ()
) -> tuple[Program, tuple[Diagnostic, ...]]:
    """A program with the turns of its tools chosen where they are free; none is free afterwards.

    clear: tell, where there is a cell, which moves keep away from things, the most wary one first;
    the next is asked where there is no way by the one before. What states the branch of the arm
    keeps its turn, and so does what is used for more than moves with such a tool.
    """
    plain = without_free_turns(program)
    if plain is program:
        return program, ()
    if not robot.arm.named:
        return plain, (rules.NOT_TURNED(robot=robot.title),)
    turning = _Turning(program, robot, clear)
    turning.go()
    out = turning.program(plain)
    if out is not plain and has_errors(solve_program(_by_joint_moves(out), robot).findings):
        if not has_errors(turning.solution.findings):
            return plain, (*turning.failed, rules.TURN_KEPT())
    return out, fold([*turning.failed, *turning.told()])


@dataclass(slots=True)
class _TargetRows:
    """The rows of a run. keys: of each the target, or path and row of it. free: see `FreeRun`."""

    run: SolvedRun
    keys: list[_TargetKey]
    free: Truths


_TargetKey = tuple[int, int]
"""Number of a target and -1, or of a path and a row of it."""


class _Turning:
    """Chooses the turns of a program, run by run.

    away: of a target or row of a path the degrees by which it is turned, once it is settled.
    """

    def __init__(self, program: Program, robot: Robot, clear: Sequence[ClearTest]) -> None:
        self.source, self.robot, self.clear = _by_joint_moves(program), robot, clear
        self.solution: SolvedProgram = solve_program(self.source, robot)
        self.kept = _kept_targets(program)
        self.uses: Counter[int] = Counter()
        self.away: dict[_TargetKey, float] = {}
        self.paths: dict[int, Path] = {}
        self.tools: dict[_TargetKey, Tool] = {}
        self.failed: list[Diagnostic] = []

    def go(self) -> None:
        runs = self._runs()
        self._keep_used_elsewhere(runs)
        ends: list[tuple[Floats, Floats]] = []
        for rows in runs:
            last = self._choose(rows, ends)
            if last is not None:
                ends.append((rows.run.joints[-1], last))

    def _runs(self) -> list[_TargetRows]:
        """The runs of the program in the order in which they were solved."""
        keys: dict[int, dict[int, list[_TargetKey]]] = {}
        for procedure in self.source.procedures:
            names = Names(self.source)
            names.enter(procedure)
            for leg in self.solution.legs.get(procedure.name, ()):
                if leg.solved_run is None:
                    continue
                match leg.statement:
                    case Follow(path):
                        self.paths[id(path)] = path
                        found = [(id(path), row) for row in range(len(path))]
                    case Move(target=target):
                        found = [self._key(target, names)]
                    case MoveCircular(via=via, target=target):
                        found = [self._key(via, names), self._key(target, names)]
                    case _:
                        continue
                keys.setdefault(id(leg.solved_run), {})[leg.rows.start] = found
        runs = []
        for run in self.solution.solved_runs:
            # A run goes on through the procedures that it calls.
            ordered = [key for _, found in sorted(keys[id(run)].items()) for key in found]
            mounting = run.run.mounting
            free = np.array([tool.free_turn for tool in mounting.tools])[mounting.tool]
            runs.append(_TargetRows(run, ordered, free))
        return runs

    def _key(self, place: Expression, names: Names) -> _TargetKey:
        """The target of a move; one that may not be turned is kept from it."""
        found = names.place(place)
        assert found is not None  # it is in a run
        target = found.target
        plain, base = _turns_alone(place, names)
        named = isinstance(base, Name) and names.shared_targets.get(base.name.lower()) is target
        if not plain or target.configuration is not None:
            self.kept.add(id(target))
        elif not (named and isinstance(base, Name) and base.name.lower() not in names.own):
            if not isinstance(base, TargetValue):
                self.kept.add(id(target))
        self.uses[id(target)] += 1
        return id(target), -1

    def _keep_used_elsewhere(self, runs: list[_TargetRows]) -> None:
        """Keeps from turning what other statements name, and what a tool goes to that is not free,
        with all rows of a path that is gone along so.
        """
        named = Counter(
            part.name.lower() for part in records(self.source) if isinstance(part, Name)
        )
        for name, target in self.source.targets.items():
            if named[name.lower()] != self.uses[id(target)]:
                self.kept.add(id(target))
        bound = {
            key
            for rows in runs
            for key, free in zip(rows.keys, rows.free.tolist(), strict=True)
            if not free
        }
        for rows in runs:
            rows.free = np.array(
                [key not in bound and self._open(key) for key in rows.keys], dtype=bool
            )

    def _open(self, key: _TargetKey) -> bool:
        number, row = key
        if row < 0:
            return number not in self.kept
        return bool(self.paths[number].configurations[row, BACK] == UNSTATED)

    # ---------------------------------------------------------------------------- choosing

    def _choose(self, rows: _TargetRows, ends: Sequence[tuple[Floats, Floats]]) -> Floats | None:
        """Settles the turns of a run; where the arm is after it, if that was found.

        ends: where the arm was after the runs before it, and where it is now.
        """
        run, robot = rows.run.run, self.robot
        if not rows.free.any() or not _finite(run):
            return None
        if run.joined:
            now = [new for old, new in ends if np.array_equal(old, run.before)]
            run = replace(run, before=now[-1] if now else run.before)
        numbers: dict[_TargetKey, int] = {}
        again = Counter(rows.keys)
        keys = np.array(
            [numbers.setdefault(k, len(numbers)) if again[k] > 1 else -1 for k in rows.keys],
            dtype=np.intp,
        )
        fixed = np.array([self.away.get(key, np.nan) for key in rows.keys])
        stated = np.asarray(run.configurations[:, BACK] != UNSTATED)
        own = np.where(stated, robot.branch_of(run.configurations), -1)
        free_run = free_run_of(run, robot, rows.free, keys, own, fixed)
        tool = self._tool(rows)
        found = _choose_turns(free_run, robot, self.clear[0] if self.clear else None)
        for clear in self.clear[1:]:
            if isinstance(found, _NoTurn) and found.touching:
                found = _choose_turns(free_run, robot, clear)
        if isinstance(found, _NoTurn):
            rule = rules.NO_TURN_CLEAR if found.touching else rules.NO_TURN
            self.failed.append(rule(about=run.label(found.row), robot=robot.title))
            for key in rows.keys:
                self.away.setdefault(key, 0.0)
            return None
        for key, turn in zip(rows.keys, found.turns.tolist(), strict=True):
            if key in self.away:
                continue
            self.away[key] = turn
            if abs(turn) > _LEAST_TURN:
                self.tools[key] = tool
        return found.last

    def _tool(self, rows: _TargetRows) -> Tool:
        mounting = rows.run.run.mounting
        return mounting.tools[int(mounting.tool[int(rows.free.argmax())])]

    # ---------------------------------------------------------------------------- applying

    def program(self, plain: Program) -> Program:
        """The program with the turns that were chosen."""
        targets = {key: turn for (key, row), turn in self.away.items() if row < 0}
        columns: dict[int, Floats] = {}
        for (number, row), turn in self.away.items():
            if row >= 0:
                length = len(self.paths[number])
                columns.setdefault(number, np.zeros(length))[row] = turn

        def visit(value: Any) -> Any:
            if isinstance(value, Path) and np.abs(columns.get(id(value), 0.0)).max() > _LEAST_TURN:
                turn = rotations.about(
                    np.broadcast_to(UPRIGHT, (len(value), 3)), columns[id(value)]
                )
                quaternions = rotations.canonical(rotations.multiply(value.quaternions, turn))
                return replace(value, quaternions=quaternions)
            if isinstance(value, Target) and abs(targets.get(id(value), 0.0)) > _LEAST_TURN:
                turn = rotations.canonical(rotations.about(UPRIGHT, targets[id(value)]))
                w, x, y, z = turn.tolist()
                return replace(value, pose=value.pose @ Pose(quaternion=(w, x, y, z)))
            return value

        return rewrite(plain, visit)

    def told(self) -> Iterator[Diagnostic]:
        """Yield a finding for each tool whose targets were turned."""
        for name, tool in self.source.tools.items():
            turns = [abs(self.away[key]) for key, one in self.tools.items() if one is tool]
            if turns:
                about = Declared(name, "tools")
                yield rules.TURNED(about=about, count=len(turns), most=max(turns))


def _finite(run: Run) -> bool:
    """True if all poses are finite; solving reports those that are not."""
    p, q = run.flange(slice(0, len(run)))
    return bool(np.isfinite(p).all() and np.isfinite(q).all())


def _by_joint_moves(program: Program) -> Program:
    """The program with joint moves in place of the ways that are planned later."""
    names = Names(program)

    def visit(value: Any) -> Any:
        if isinstance(value, Travel):
            if names.joints(value.target) is None:
                return Move("joint", value.target, value.motion, span=value.span)
            return MoveJoints(value.target, value.motion, span=value.span)
        return value

    return rewrite(program, visit)


def _turns_alone(place: Expression, names: Names) -> tuple[bool, Expression]:
    """Return whether a turn of its target only turns a target expression, and the expression that
    it is computed from.
    """
    plain = True
    while isinstance(place, Apply) and place.arguments:
        first, *rest = place.arguments
        if place.function == "relative":
            numbers = [names.number(one) for one in rest] + [0.0] * 6
            plain &= not any(numbers[i] for i in (0, 1, 3, 4))
        place = first
    return plain, place


def _kept_targets(program: Program) -> set[int]:
    """Targets that texts name which stay in their vendor's words."""
    said = {
        word.lower()
        for part in records(program)
        if isinstance(part, Opaque | Verbatim)
        for word in re.findall(r"\w+", part.text)
    }
    return {id(target) for name, target in program.targets.items() if name.lower() in said}
