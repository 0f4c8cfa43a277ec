"""The turns of a program: which of its targets may be turned, and the program with them turned."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats, Truths
from assistant.base.diagnostics import Declared, Diagnostic, fold, has_errors
from assistant.program.expressions import Apply, Expression, Name, TargetValue, Verbatim
from assistant.program.geometry import Pose, Target, Tool
from assistant.program.motion import UNSTATED, Path
from assistant.program.program import Program
from assistant.program.rewriting import records, rewrite
from assistant.program.statements import Follow, Move, MoveCircular, MoveJoints, Opaque, Travel
from assistant.robots import findings as rules
from assistant.robots.configurations import BACK
from assistant.robots.configuring import solve_program
from assistant.robots.motion.run import Run
from assistant.robots.robot import Robot
from assistant.robots.solved_program import Leg, SolvedProgram, SolvedRun
from assistant.robots.target_lookup import Names
from assistant.robots.turning.choosing import ClearTest, NoTurn, choose_turns
from assistant.robots.turning.stations import UPRIGHT, free_run_of

LEAST_TURN: Final = 1e-9
"""degrees that are no turn."""


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
    keys: list[TargetKey]
    free: Truths


TargetKey = tuple[int, int]
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
        self.away: dict[TargetKey, float] = {}
        self.paths: dict[int, Path] = {}
        self.tools: dict[TargetKey, Tool] = {}
        self.failed: list[Diagnostic] = []

    def go(self) -> None:
        runs = [
            [*self._runs(procedure.name, legs)]
            for procedure in self.source.procedures
            for legs in (self.solution.legs.get(procedure.name, ()),)
        ]
        self._keep_used_elsewhere(runs)
        for each in runs:
            ends: list[tuple[Floats, Floats]] = []
            for rows in each:
                last = self._choose(rows, ends)
                if last is not None:
                    ends.append((rows.run.joints[-1], last))

    def _runs(self, procedure: str, legs: tuple[Leg, ...]) -> Iterator[_TargetRows]:
        """The runs of a procedure in order of text."""
        names = Names(self.source)
        names.enter(next(p for p in self.source.procedures if p.name == procedure))
        gathered: dict[int, tuple[SolvedRun, list[TargetKey]]] = {}
        for leg in legs:
            run = leg.solved_run
            if run is None:
                continue
            _, keys = gathered.setdefault(id(run), (run, []))
            match leg.statement:
                case Follow(path):
                    self.paths[id(path)] = path
                    keys += [(id(path), row) for row in range(len(path))]
                case Move(target=target):
                    keys.append(self._key(target, names))
                case MoveCircular(via=via, target=target):
                    keys += [self._key(via, names), self._key(target, names)]
        for run, keys in gathered.values():
            mounting = run.run.mounting
            free = np.array([tool.free_turn for tool in mounting.tools])[mounting.tool]
            yield _TargetRows(run, keys, free)

    def _key(self, place: Expression, names: Names) -> TargetKey:
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

    def _keep_used_elsewhere(self, runs: list[list[_TargetRows]]) -> None:
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
            for each in runs
            for rows in each
            for key, free in zip(rows.keys, rows.free.tolist(), strict=True)
            if not free
        }
        for each in runs:
            for rows in each:
                rows.free = np.array(
                    [key not in bound and self._open(key) for key in rows.keys], dtype=bool
                )

    def _open(self, key: TargetKey) -> bool:
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
        numbers: dict[TargetKey, int] = {}
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
        found = choose_turns(free_run, robot, self.clear[0] if self.clear else None)
        for clear in self.clear[1:]:
            if isinstance(found, NoTurn) and found.touching:
                found = choose_turns(free_run, robot, clear)
        if isinstance(found, NoTurn):
            rule = rules.NO_TURN_CLEAR if found.touching else rules.NO_TURN
            self.failed.append(rule(about=run.label(found.row), robot=robot.title))
            for key in rows.keys:
                self.away.setdefault(key, 0.0)
            return None
        for key, turn in zip(rows.keys, found.turns.tolist(), strict=True):
            if key in self.away:
                continue
            self.away[key] = turn
            if abs(turn) > LEAST_TURN:
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
            if isinstance(value, Path) and np.abs(columns.get(id(value), 0.0)).max() > LEAST_TURN:
                turn = rotations.about(
                    np.broadcast_to(UPRIGHT, (len(value), 3)), columns[id(value)]
                )
                quaternions = rotations.canonical(rotations.multiply(value.quaternions, turn))
                return replace(value, quaternions=quaternions)
            if isinstance(value, Target) and abs(targets.get(id(value), 0.0)) > LEAST_TURN:
                turn = rotations.canonical(rotations.about(UPRIGHT, targets[id(value)]))
                w, x, y, z = turn.tolist()
                return replace(value, pose=value.pose @ Pose(quaternion=(w, x, y, z)))
            return value

        return rewrite(plain, visit)

    def told(self) -> Iterator[Diagnostic]:
        """What was turned, a finding a tool."""
        for name, tool in self.source.tools.items():
            turns = [abs(self.away[key]) for key, one in self.tools.items() if one is tool]
            if turns:
                about = Declared(name, "tools")
                yield rules.TURNED(about=about, count=len(turns), most=max(turns))


def _finite(run: Run) -> bool:
    """Whether all poses are numbers; where they are not, solving tells so."""
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
    """Whether a turn of its target only turns a place, and what it is worked out from."""
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
