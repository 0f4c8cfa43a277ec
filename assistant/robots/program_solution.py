"""Solve a program for a robot: joints and configurations of every move.

Targets and paths that state no configuration get one. The moves of a procedure are taken in the
order of the text: where one surely follows the other they are solved together, so that a linear
move keeps the arm branch that it starts with. A procedure that is called at one place only is
solved where it is called.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from itertools import chain
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from assistant.base.arrays import Floats
from assistant.base.budgets import SOLVING, staged
from assistant.base.diagnostics import Declared, Diagnostic, Goal, NumberedMove, fold
from assistant.program.analysis.uses import called, names_in_vendor_texts
from assistant.program.expressions import Expression, Name
from assistant.program.geometry import BASE, FLANGE, Frame, JointTarget, Target, Tool
from assistant.program.motion import FINE, MAXIMUM_SPEED, UNSTATED, Kind, Path, configuration_of
from assistant.program.program import Procedure, Program, bodies, walk
from assistant.program.rewriting import records, rewrite
from assistant.program.statements import (
    Assign,
    Call,
    Follow,
    If,
    Interrupt,
    Motion,
    Move,
    MoveCircular,
    MoveJoints,
    Moving,
    Statement,
    Travel,
    trait,
)
from assistant.robots import findings as rules
from assistant.robots.configurations import BACK
from assistant.robots.motion.row_reach import NearestPoseCures
from assistant.robots.motion.run import (
    Configurations,
    RunPart,
    SingleMove,
    first_configurations,
    moves_part,
    path_part,
    run_of_parts,
)
from assistant.robots.motion.run_solution import solve_run
from assistant.robots.program_values import Names, Place
from assistant.robots.robot import Robot, require_program, require_robot
from assistant.robots.solved_program import Leg, SolvedProgram, SolvedRun


def configure(program: Program, robot: Robot) -> tuple[Program, tuple[Diagnostic, ...]]:
    """Fills in the configurations that targets and paths leave open; see `solve_program`."""
    solved = solve_program(program, robot)
    return solved.program, solved.findings


@staged(SOLVING, lambda program, *_: program.size() if isinstance(program, Program) else 0)
def solve_program(program: Program, robot: Robot) -> SolvedProgram:
    """Solve every move of a program, and fill in the configurations that it leaves open.

    Findings report targets that are out of reach, outside joint limits, or not as stated; such
    targets stay unchanged. A target that no move names is configured for the program's only tool
    and frame, if that is within reach; with several of them it stays open.
    """
    require_program(program)
    require_robot(robot)
    survey = _ProgramSolver(program, robot)
    for procedure in program.procedures:
        if procedure.name.lower() not in survey.solved_at_call:
            survey.procedure(procedure)
    # Procedures that only call each other, or that lie too deep.
    for procedure in program.procedures:
        survey.procedure(procedure)
    survey.joint_targets()
    survey.rows_outside()
    survey.unused()
    survey.unknown_targets()
    done = survey.done

    def visit(value: Any) -> Any:
        if isinstance(value, Path):
            return survey.paths.get(id(value), value)
        if isinstance(value, Target) and value.configuration is None and id(value) in done:
            return replace(value, configuration=configuration_of(done[id(value)]))
        return value

    configured = rewrite(program, visit)
    legs = {name: tuple(found) for name, found in survey.legs.items()}
    return SolvedProgram(configured, robot, legs, fold([*robot.findings, *survey.findings]))


_UNMOVED: Final = Motion(MAXIMUM_SPEED, FINE)
"""Motion that is assumed for a target that no move names."""
_TRAITS_LEADING_AWAY: Final = ("calls", "jumps", "marks", "kept")
"""Traits of statements behind which nothing tells where the arm is."""
_TRAITS_WITHOUT_JUMPS: Final = ("moves", "waits", "sets", "calls", "holds", "says")
"""Traits of the statements of a procedure that always runs from its first one to its last."""
_DEEPEST_CALL: Final = 20
"""Calls in calls that are followed."""


def _called_at_one_place(program: Program) -> dict[str, Procedure]:
    """Procedures without parameters, by name in lower case, that one call of the program runs, and
    that return at their end only.
    """
    calls = Counter(name for procedure in program.procedures for name in called(procedure))
    answers = {one.call.procedure.lower() for one in records(program) if isinstance(one, Interrupt)}
    entry = (program.entry or "").lower()
    return {
        name: procedure
        for procedure in program.procedures
        for name in [procedure.name.lower()]
        if calls[name] == 1
        and name != entry
        and name not in answers
        and not procedure.parameters
        and all(trait(one) in _TRAITS_WITHOUT_JUMPS for one in walk(procedure.body))
    }


def _leg(statement: Moving, solved_run: SolvedRun, rows: slice) -> Leg:
    run, joints = solved_run.run, solved_run.joints
    start = joints[rows.start - 1] if rows.start else run.before if run.joined else None
    known = start is not None and bool(np.isfinite(start).all())
    return Leg(statement, solved_run, rows, joints[rows], start if known else None)


_MOST_ROWS: Final = 5
"""Rows of joints beyond the limits that are reported one by one."""
_IN_DEGREES: Final = (
    'if these were degrees and not radians, say so: unit="deg" of `from_joints`, columns such as '
    "`j1_deg`; else move the joint targets inside the limits"
)
_UNUSED_AXIS: Final = 9e9
"""Value for an axis of the arm that a target does not state."""


class _Aim(NamedTuple):
    """A move to a place that only running the program tells.

    before: (axes,) joints at the last place before it that is known. move: to that place.
    """

    tool: str
    frame: str
    before: Floats
    move: SingleMove | None = None


class _ProgramSolver:
    """Goes through a program in order of text and solves its moves run by run.

    done: id of a target → its configuration row. paths: id of a path → the configured one.
    aimed: name of a target → the first move to a place that is computed from it as the program
    runs. origins: name of a variable → names that its value comes from. open:
    moves whose targets only running the program tells, each with its label. all_moves: their
    number with all others, without the rows of paths.
    """

    def __init__(self, program: Program, robot: Robot) -> None:
        self.program, self.robot = program, robot
        self.names = Names(program)
        self.declared_joints = set(map(id, program.joint_targets.values()))
        self.findings: list[Diagnostic] = []
        self.outside: list[tuple[Goal, Floats]] = []
        """Joints beyond the limits of moves that no text has a line for."""
        self.cures = NearestPoseCures(robot)
        self.done: dict[int, NDArray[np.int8]] = {}
        self.paths: dict[int, Path] = {}
        self.followed: dict[int, Path] = {}
        self.used: set[tuple[str, str]] = set()
        self.aimed: dict[str, _Aim] = {}
        self.origins: dict[str, set[str]] = {}
        self.open: list[tuple[Statement, Goal]] = []
        self.all_moves = 0
        self.moves: list[SingleMove] = []
        self.last_move: SingleMove | None = None
        self.parts: list[RunPart] = []
        self.before, self.joined = robot.home, False
        self.where, self.count = "", 0
        self.legs: dict[str, list[Leg]] = {one.name: [] for one in program.procedures}
        self.pending: list[tuple[str, Moving, int, int]] = []
        self.rows = self.flushes = self.runs = 0
        self.solved_at_call = _called_at_one_place(program)
        self.begun: set[int] = set()
        """Procedures by their identity."""
        self.calling: list[Procedure] = []

    def procedure(self, procedure: Procedure) -> None:
        """Solve a procedure that nothing calls at a known place, unless that was done already."""
        if id(procedure) in self.begun:
            return
        self.joined, self.last_move = False, None
        self.inside(procedure)
        self.flush()

    def inside(self, procedure: Procedure) -> None:
        """Go through a procedure; moves that came before are solved with its first ones."""
        self.begun.add(id(procedure))
        self.calling.append(procedure)
        self.close_moves()
        where, count = self.where, self.count
        self.where, self.count = procedure.name, 0
        self.names.enter(procedure)
        self.statements(procedure.body)
        self.close_moves()
        self.calling.pop()
        self.where, self.count = where, count
        if self.calling:
            self.names.enter(self.calling[-1])

    def call(self, statement: Call) -> None:
        procedure = self.solved_at_call.get(statement.procedure.lower())
        if (
            procedure is None
            or id(procedure) in self.begun
            or len(self.calling) >= _DEEPEST_CALL
            or statement.arguments
        ):
            self.flush()
            self.joined = False
        else:
            self.inside(procedure)

    def keep_leg(self, leg: Leg) -> None:
        self.legs[self.where].append(leg)

    def body(self, body: tuple[Statement, ...]) -> None:
        self.statements(body)
        self.flush()

    def statements(self, body: tuple[Statement, ...]) -> None:
        for statement in body:
            match statement:
                case Call():
                    self.call(statement)
                case Move():
                    kind = Kind.JOINT if statement.kind == "joint" else Kind.LINEAR
                    self.moving(statement, (kind, statement.target))
                case MoveCircular():
                    via, end = (Kind.VIA, statement.via), (Kind.END, statement.target)
                    self.moving(statement, via, end)
                case MoveJoints():
                    self.flush()
                    before = self.before if self.joined else None
                    joints = self.move_joints(statement)
                    self.keep_leg(
                        self.unsolved(statement)
                        if joints is None
                        else Leg(statement, None, slice(0), joints[None], before)
                    )
                case Follow():
                    self.follow(statement)
                case Travel():
                    self.flush()  # what stands before it does not depend on what comes after
                case Assign(Name(name), value):
                    self.origins[name.lower()] = self.coming_from(value)
                case _ if trait(statement) == "holds":
                    self.nested(statement, bodies(statement))
                case _ if trait(statement) in _TRAITS_LEADING_AWAY:
                    self.flush()
                    self.joined = False

    def nested(self, statement: Statement, inner: tuple[tuple[Statement, ...], ...]) -> None:
        self.flush()
        # A loop's body is entered from its own end as well; a branch only from before.
        before, joined = self.before, self.joined and isinstance(statement, If)
        for each in inner:
            self.before, self.joined = before, joined
            self.body(each)
        self.joined = False

    def moving(self, statement: Move | MoveCircular, *targets: tuple[Kind, Expression]) -> None:
        start, flushes = self.rows, self.flushes
        self.all_moves += 1
        unknown = [
            label
            for kind, target in targets
            if (label := self.move(kind, target, statement.motion)) is not None
        ]
        self.open += [(statement, label) for label in unknown[:1]]
        if self.rows == start + len(targets) and self.flushes == flushes:
            self.pending.append((self.where, statement, start, self.rows))
        else:
            self.keep_leg(self.unsolved(statement))

    def unsolved(self, statement: Moving) -> Leg:
        return Leg(statement, None, slice(0), np.empty((0, len(self.robot.axes))), None)

    def move(self, kind: Kind, target: Expression, motion: Motion) -> Goal | None:
        """Take a target into the run; return its label if only running the program tells it."""
        label = self.label(target)
        tool, frame = self.tool(motion.tool, label), self.frame(motion.frame, label)
        self.used.add((motion.tool, motion.frame))
        place = self.names.place(target)
        if place is None or tool is None or frame is None:
            self.flush()
            aim = _Aim(motion.tool, motion.frame, self.before, self.last_move)
            for name in self.coming_from(target):
                self.aimed.setdefault(name, aim)
            self.joined = False
            return label if place is None and tool is not None and frame is not None else None
        self.last_move = SingleMove(kind, place, tool, frame, motion, label)
        self.moves.append(self.last_move)
        self.rows += 1
        return None

    def label(self, target: Expression) -> Goal:
        """Return the label of the next move in a finding."""
        self.count += 1
        if isinstance(target, Name):
            return Declared(target.name)
        return NumberedMove(self.count, self.where)

    def coming_from(self, value: Expression) -> set[str]:
        """The names in an expression, and those that the variables among them come from."""
        names = {part.name.lower() for part in records(value) if isinstance(part, Name)}
        return names.union(*(self.origins.get(name, ()) for name in names))

    def follow(self, statement: Follow) -> None:
        path = statement.path
        about = Declared(path.name, "paths", in_full=True)
        tools = [self.tool(name, about) for name in path.tools]
        frames = [self.frame(name, about) for name in path.frames]
        self.used.update((tool, frame) for tool in path.tools for frame in path.frames)
        known_tools = [tool for tool in tools if tool is not None]
        known_frames = [frame for frame in frames if frame is not None]
        if not len(path):
            self.pending.append((self.where, statement, self.rows, self.rows))
            return
        if len(known_tools) < len(tools) or len(known_frames) < len(frames):
            self.flush()
            self.joined = False
            self.keep_leg(self.unsolved(statement))
            return
        self.close_moves()
        self.last_move = None
        configurations = self.paths.get(id(path), path).configurations
        self.parts.append(path_part(path, configurations, known_tools, known_frames))
        self.followed[id(path)] = path
        self.pending.append((self.where, statement, self.rows, self.rows + len(path)))
        self.rows += len(path)

    def close_moves(self) -> None:
        """Makes a part of the single moves that have come together."""
        if self.moves:
            self.parts.append(moves_part(self.where, self.moves, self.done))
            self.moves = []

    def flush(self) -> None:
        """Solves the parts that have come together."""
        self.close_moves()
        parts, self.parts = self.parts, []
        pending, self.pending = self.pending, []
        self.rows, self.flushes = 0, self.flushes + 1
        solved_run = self.solved(parts) if parts else None
        for where, moving, first, end in pending:
            self.legs[where].append(
                self.unsolved(moving)
                if solved_run is None or first == end
                else _leg(moving, solved_run, slice(first, end))
            )

    def solved(self, parts: Sequence[RunPart]) -> SolvedRun:
        run = run_of_parts(parts, self.before, self.joined)
        solved = solve_run(run, self.robot, self.cures)
        first = first_configurations(parts, solved.configurations)
        if first is not solved.configurations:
            # What is met twice has one configuration: the first one it got.
            theirs = run.configurations[:, BACK] != UNSTATED
            fixed = replace(run, configurations=first)
            solved = solve_run(fixed, self.robot, self.cures, theirs)
        self.keep(parts, solved.configurations)
        self.findings.extend(solved.findings)
        solved_run = SolvedRun(run, solved.joints, solved.configurations, self.runs)
        self.runs += 1
        last = solved.joints[-1]
        self.joined = bool(np.isfinite(last).all())
        if self.joined:
            self.before = last
        return solved_run

    def keep(self, parts: Sequence[RunPart], configurations: Configurations) -> None:
        """Remembers the configurations of targets and paths."""
        at = 0
        for part in parts:
            rows = configurations[at : at + len(part)]
            at += len(part)
            if part.is_path:
                path = self.followed[part.keys[0]]
                if not np.array_equal(rows, path.configurations):
                    self.paths[id(path)] = replace(path, configurations=rows)
                continue
            for i in np.argsort(~part.exact, kind="stable"):  # computed places come last
                if rows[i, BACK] != UNSTATED:
                    self.done.setdefault(part.keys[i], rows[i])

    def move_joints(self, statement: MoveJoints) -> Floats | None:
        """Return the joints at the end of the move, if the text states them and the arm can reach
        them.
        """
        target = self.names.joints(statement.target)
        label = self.label(statement.target)
        self.tool(statement.motion.tool, label)
        if self.names.frame(statement.motion.frame) is None:
            self.frame(statement.motion.frame, label)
        self.joined, self.last_move = False, None
        self.all_moves += 1
        if target is None:
            self.open.append((statement, label))
            return None
        if _is_of_other_axes(target):
            self.findings.append(rules.NO_JOINTS(about=label, robot=self.robot.title))
            return None
        # A declared one is reported once, by its own name.
        declared = id(target) in self.declared_joints
        joints = self.joints(target, None if declared else label, lineless=statement.span is None)
        if joints is not None:
            self.before, self.joined = joints, True
        return joints

    def joints(
        self, target: JointTarget, label: Goal | None, *, lineless: bool = False
    ) -> Floats | None:
        """The angles of the robot's axes; findings, if it has a label, for what is wrong.

        lineless: it is a row of a table or an array, of which there may be thousands.
        """
        robot = self.robot
        given = np.array(robot.own_joints(target.joints), dtype=np.float64)
        if len(given) != len(robot.axes) or not np.isfinite(given).all():
            if label is not None:
                self.findings.append(
                    rules.JOINT_COUNT(
                        about=label,
                        robot=robot.title,
                        count=len(target.joints),
                        axes=" ".join(robot.axes),
                    )
                )
            return None
        inside = bool(robot.inside(given))
        if label is not None and not inside:
            if lineless:
                self.outside.append((label, given))
            else:
                self.joints_outside(label, given)
        return given if inside else None

    def joints_outside(self, label: Goal, given: Floats) -> None:
        """Report each axis beyond its limits."""
        robot = self.robot
        low, high = robot.limits.T
        for axis in np.flatnonzero((given < low) | (given > high)):
            self.findings.append(
                rules.JOINT_OUTSIDE(
                    about=label,
                    axis=robot.axes[axis],
                    unit=robot.units[axis],
                    value=given[axis],
                    low=low[axis],
                    high=high[axis],
                )
            )

    def rows_outside(self) -> None:
        """Report rows of joints beyond the limits: each of a few, the worst of many."""
        if len(self.outside) <= _MOST_ROWS:
            for label, given in self.outside:
                self.joints_outside(label, given)
            return
        robot, rows = self.robot, np.array([given for _, given in self.outside])
        low, high = robot.limits.T
        beyond = np.maximum(low - rows, rows - high)
        row, axis = np.unravel_index(int(beyond.argmax()), beyond.shape)
        turning = np.array(robot.units) == "degrees"
        meant = np.where(turning, np.radians(rows), rows)
        likely = turning.any() and bool(((low <= meant) & (meant <= high)).all())
        self.findings.append(
            rules.MANY_JOINTS_OUTSIDE(
                about=self.outside[row][0],
                count=len(rows),
                robot=robot.title,
                axis=robot.axes[axis],
                unit=robot.units[axis],
                value=rows[row, axis],
                low=low[axis],
                high=high[axis],
                cure=_IN_DEGREES if likely else rules.JOINT_OUTSIDE.cure,
            )
        )

    def joint_targets(self) -> None:
        lineless = all(one.span is None for one in self.program.statements())
        for name, target in self.program.joint_targets.items():
            if not _is_of_other_axes(target):
                self.joints(target, Declared(name, "joint_targets"), lineless=lineless)

    def unknown_targets(self) -> None:
        """Reports once the moves whose targets only running the program tells."""
        if self.open:
            (first, label), count = self.open[0], len(self.open)
            moves = f"{count} of {self.all_moves} moves lead{'s' if count == 1 else ''}"
            self.findings.append(rules.NOT_KNOWN(about=label, span=first.span, moves=moves))

    def unused(self) -> None:
        """Configures what no move names, in silence: nobody says how it will be used.

        A place that a move goes to as the program runs is reached from where the arm is then, in
        whatever order it goes to such places. One that vendor text names stays open: the tool and
        frame there are not read.
        """
        inside = names_in_vendor_texts(self.program)
        usual = None
        if len(self.used) < 2:
            usual = _Aim(*next(iter(self.used), (FLANGE, BASE)), self.robot.home)
        named = chain(self.program.targets.items(), self.program.variables.items())
        aimed = {
            id(target): self.aimed[name.lower()]
            for name, value in named
            if name.lower() in self.aimed
            for target in records(value)
            if isinstance(target, Target)
        }
        targets: dict[int, Target] = {}

        def visit(value: Any) -> Any:
            if isinstance(value, Target) and value.configuration is None:
                targets.setdefault(id(value), value)
            return value

        rewrite(self.program, visit)
        for name, value in chain(self.program.targets.items(), self.program.variables.items()):
            if name.lower() in inside:
                for one in records(value):
                    targets.pop(id(one), None)
        runs: dict[int, tuple[Floats, list[SingleMove]]] = {}
        for key, target in targets.items():
            aim = aimed.get(key, usual)
            if aim is None or key in self.done:
                continue  # without a tool and a frame, any guess might be a wrong turn
            tool, frame = self.names.tool(aim.tool), self.names.frame(aim.frame)
            if tool is not None and frame is not None:
                _, moves = runs.setdefault(id(aim.before), (aim.before, []))
                if aim.move is not None:
                    moves.append(replace(aim.move, kind=Kind.JOINT))
                label = NumberedMove(len(moves) + 1, "")
                place = Place(target, target.pose)
                moves.append(SingleMove(Kind.JOINT, place, tool, frame, _UNMOVED, label))
        for before, moves in runs.values():
            parts = [moves_part("", moves, self.done)]
            run = run_of_parts(parts, before, joined=False)
            solved = solve_run(run, self.robot, NearestPoseCures(self.robot, 0))
            self.keep(parts, solved.configurations)

    def tool(self, name: str, about: Goal) -> Tool | None:
        tool = self.names.tool(name)
        if tool is None:
            self.findings.append(self._unknown("tool", name, [FLANGE, *self.program.tools], about))
        return tool

    def _unknown(self, kind: str, name: str, there: Sequence[str], about: Goal) -> Diagnostic:
        """A tool or frame that is not declared, or whose declaration only its language reads."""
        kept = (one.effect for one in self.program.declarations)
        if any(effect is not None and name.lower() in effect.writes for effect in kept):
            return rules.VALUELESS_TOOL(about=about, kind=kind, name=name)
        return rules.UNKNOWN_TOOL(about=about, kind=kind, name=name, names=", ".join(there))

    def frame(self, name: str, about: Goal) -> Frame | None:
        frame = self.names.frame(name)
        if frame is None:
            self.findings.append(self._unknown("frame", name, [BASE, *self.program.frames], about))
        elif frame.mechanism:
            self.findings.append(
                rules.MOVED_FRAME(about=about, name=name, mechanism=frame.mechanism)
            )
            return None
        return frame


def _is_of_other_axes(target: JointTarget) -> bool:
    """True if a target states external axes and none of the arm."""
    return bool(target.joints) and all(value >= _UNUSED_AXIS for value in target.joints)
