"""From the trees of a program's files to the pseudo-program."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import PurePath
from typing import TYPE_CHECKING, Any, TypeVar, cast

from assistant.languages.melfa_basic import header as headers
from assistant.languages.melfa_basic import poses
from assistant.languages.melfa_basic import syntax as s
from assistant.languages.melfa_basic.columnar import MoveRows
from assistant.languages.melfa_basic.header import Header
from assistant.languages.melfa_basic.lift.expressions import Meanings
from assistant.languages.melfa_basic.lift.positions import Positions, joints_of, target_of
from assistant.languages.melfa_basic.lift.statements import Reader
from assistant.program.expressions import Expression, JointValue, TargetValue
from assistant.program.geometry import Frame, JointTarget, Target, Tool
from assistant.program.program import Procedure, Program, Variable, identifier

if TYPE_CHECKING:
    from assistant.robots import Robot


def lift(trees: Sequence[s.File], robot: Robot | None = None) -> Program:
    """The pseudo-program of a main program and the programs that it calls."""
    units = [_Unit(tree) for tree in trees]
    if not units:
        return Program("empty", entry=None)
    main = next((u for u in units if u.header.unit is None), units[0])
    if robot is None:
        robot = _robot(main.header.robot)
    order = list(main.header.names["unit"].values())
    rest = [u for u in units if u is not main]
    rest.sort(key=lambda u: order.index(u.header.unit) if u.header.unit in order else len(order))
    name = main.header.program or _stem(main.tree) or "program"
    program = Program(
        name, robot=main.header.robot, comments=main.comments, signals=dict(main.header.signals)
    )
    for unit in [main, *rest]:
        program = unit.add_to(program, robot, main)
    return program


def _robot(name: str | None) -> Robot | None:
    if name is None:
        return None
    from assistant import robots

    try:
        return robots.get(name)
    except KeyError:
        return None


def _stem(tree: s.File) -> str | None:
    path = tree.source.path if tree.source else None
    return identifier(PurePath(path).stem) if path and path != "-" else None


class _Unit:
    """One file: what its heading says, its code and its positions."""

    def __init__(self, tree: s.File) -> None:
        self.tree = tree
        self.header, self.comments, self.code = _parts(tree)
        self.positions = Positions(tree)

    def add_to(self, program: Program, robot: Robot | None, main: _Unit) -> Program:
        head, own = self.header, self.header.program is not None
        signals, variables = dict(program.signals), dict(program.variables)
        known = set(variables)
        targets: set[str] = set()
        meanings = Meanings(
            head, self.positions, robot, self.tree.dialect, signals, variables, targets
        )
        local = self._declared(meanings, variables)
        is_main = self is main
        unit = None if is_main else (head.unit or _stem(self.tree) or "unit")
        calls = dict(main.header.names["unit"]), dict(main.header.names["first"])
        reader = Reader(self.code, meanings, own, is_main, calls)
        taken = {q.name for q in program.procedures}
        procedures = []
        for label, body in reader.procedures():
            if label is None:
                first = (
                    (head.entry or "main")
                    if is_main
                    else head.names["first"].get(self._short(main), unit or "unit")
                )
                name = first
                if (head.entry == "-" and is_main) or (not body and not self.has_code()):
                    continue
            else:
                name = head.names["procedure"].get(label) or identifier(label, taken)
            taken.add(name)
            owned = {v: d for (owner, v), d in local.items() if owner.lower() == name.lower()}
            procedures.append(Procedure(name, body, variables=owned, unit=unit))
        if not own:
            for new in set(variables) - known:
                if variables[new].type in ("position", "joints") and new.upper() == "PSTART":
                    del variables[new]
        entry = program.entry
        if is_main:
            entry = procedures[0].name if procedures and head.entry != "-" else None
        return replace(
            program,
            procedures=(*program.procedures, *procedures),
            entry=entry,
            signals=signals,
            variables=variables,
            tools=_with(program.tools, self._tools(reader)),
            frames=_with(program.frames, self._frames(reader)),
            targets=_with(program.targets, self._targets(reader, targets, robot, own)),
            joint_targets=_with(program.joint_targets, self._joints(robot, own)),
        )

    def has_code(self) -> bool:
        return any(not isinstance(i, s.Line) or i.statement or i.label for i in self.code)

    def _short(self, main: _Unit) -> str:
        """The short name that the main program's heading has for this unit."""
        for short, original in self.header.names["first"].items():
            return short if original else ""
        units = main.header.names["unit"].items()
        return next((short for short, unit in units if unit == self.header.unit), "")

    def _declared(
        self, meanings: Meanings, variables: dict[str, Variable]
    ) -> dict[tuple[str, str], Variable]:
        """Variables of the heading, with the first values that the code gives them."""
        local: dict[tuple[str, str], Variable] = {}
        for short, declared in self.header.variables.items():
            initial: Expression | None = None
            if declared.type == "integer":
                self._drop(lambda n, k=short: isinstance(n, s.DefNames) and n.variables[0].key == k)
            if declared.initial:
                found = self._drop(lambda n, k=short: isinstance(n, s.Assign) and n.target.key == k)
                if isinstance(found, s.Assign):
                    initial = value_of(meanings, found)
            made = Variable(
                declared.type,
                initial,
                (),
                cast(Any, declared.storage),
                declared.local,
            )
            if declared.owner:
                local[declared.owner, declared.name] = made
            else:
                variables[declared.name] = made
        return local

    def _drop(self, wanted: object) -> s.Statement | None:
        """Takes the first line away if it is the one that is wanted."""
        if self.code and isinstance(self.code[0], s.Line):
            statement = self.code[0].statement
            if statement is not None and wanted(statement):  # type: ignore[operator]
                del self.code[0]
                return statement
        return None

    # ---------------------------------------------------------------------- positions

    def _tools(self, reader: Reader) -> dict[str, Tool]:
        """Declared and used tools."""
        names = self.header.names["tool"]
        used = {k: k for k in reader.tools if k not in names}
        tools = {}
        for short, name in {**names, **used}.items():
            constant = self.positions.constant(short)
            if constant is not None:
                tools[name] = Tool(poses.plain_pose(constant.values))
        tools.update({name: Tool(pose) for name, pose in reader.tool_values.items()})
        return tools

    def _frames(self, reader: Reader) -> dict[str, Frame]:
        names = self.header.names["frame"]
        used = {k: k for k in reader.frames if k not in names}
        frames = {}
        for short, name in {**names, **used}.items():
            constant = self.positions.constant(short)
            if constant is not None:
                frames[name] = Frame(poses.plain_pose(constant.values).inverse())
        frames.update({name: Frame(pose) for name, pose in reader.frame_values.items()})
        return frames

    def _targets(
        self, reader: Reader, used: set[str], robot: Robot | None, own: bool
    ) -> dict[str, Target]:
        """Named targets; of a foreign file all positions that are part of no path."""
        names = self.header.names["target"]
        if own:
            made: dict[str, Target] = {}
            for short, name in names.items():
                constant = self.positions.constant(short)
                if constant is not None:
                    made[name] = target_of(constant, robot)
            for key in sorted(k for k in used if k[0] != "J"):
                constant = self.positions.constant(key)
                if constant is not None:
                    made[key] = target_of(constant, robot)
            return made
        skip = {k.upper() for k in (*reader.tools, *reader.frames)}
        made = {}
        for written in self.positions.all_names():
            key = written.upper()
            if key[0] == "J" or key in skip or reader.in_path(key):
                continue
            constant = self.positions.constant(written)
            if constant is not None and identifier(written) == written:
                made[written] = target_of(constant, robot)
        return made

    def _joints(self, robot: Robot | None, own: bool) -> dict[str, JointTarget]:
        names = self.header.names["joints"]
        made = {}
        for written, (given, constant) in self.positions.names.items():
            if written[0] != "J" or written in self.header.inline:
                continue
            if own and written not in names:
                continue
            made[names.get(written, given)] = joints_of(constant, robot)
        return made


T = TypeVar("T")


def _with(known: dict[str, T], more: dict[str, T]) -> dict[str, T]:
    """Both; what the programs before have stays."""
    return known | {name: value for name, value in more.items() if name not in known}


def value_of(meanings: Meanings, node: s.Assign) -> Expression:
    """The value of an assignment; constants mean what the variable's letter says."""
    value = node.value
    if isinstance(value, s.Constant):
        if node.target.key[0] == "J":
            return JointValue(joints_of(value, meanings.robot))
        return TargetValue(target_of(value, meanings.robot))
    return meanings.of(value)


def _parts(tree: s.File) -> tuple[Header, tuple[str, ...], list[s.Line | MoveRows]]:
    """The heading, the comments above it, and the code."""
    code = [i for i in tree.items if isinstance(i, s.Line | MoveRows)]
    texts: list[str] = []
    for item in code:
        if not isinstance(item, s.Line) or item.statement or item.label or not item.comment:
            break
        texts.append(comment_text(item.comment))
    start = next((i for i, t in enumerate(texts) if re.match(headers.MARK + "melfa", t)), None)
    if start is not None and headers.END in texts[start:]:
        end = texts.index(headers.END, start)
        head = headers.read(texts[start + 1 : end])
        return head, tuple(texts[:start]), code[end + 1 :]
    return Header(), tuple(texts), code[len(texts) :]


def comment_text(comment: str) -> str:
    """A comment without its mark and outer blanks."""
    if comment.startswith("'"):
        return comment[1:].strip()
    return comment[3:].strip()
