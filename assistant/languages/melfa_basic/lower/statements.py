"""Statements of the pseudo-program as code lines of one unit."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from assistant.languages.melfa_basic import rules
from assistant.languages.melfa_basic import syntax as s
from assistant.languages.melfa_basic.columnar import MOV, MVR, MVS, MoveRows
from assistant.languages.melfa_basic.dialects import Dialect
from assistant.languages.melfa_basic.lower.expressions import Expressions, Unsayable, plain_number
from assistant.languages.melfa_basic.lower.settings import Settings, changes
from assistant.languages.melfa_basic.names import ARC_START, Names
from assistant.languages.melfa_basic.parser import statement as read_statement
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.diagnostics import Diagnostic, Findings
from assistant.program.motion import Blend, Speed
from assistant.program.path import Kind, Path
from assistant.program.program import Procedure, Program

if TYPE_CHECKING:
    from assistant.robots import Robot


class Writer:
    """Writes the procedures of a unit.

    items: code lines without step numbers. paths: first position number and path of each
    `Follow`. used: names that the unit's code refers to. shared: the program's constants
    that a unit needs a copy of. findings: what cannot be said.
    """

    def __init__(
        self,
        program: Program,
        dialect: Dialect,
        names: Names,
        robot: Robot | None,
        unit: str | None,
    ) -> None:
        self.program, self.dialect, self.names, self.unit = program, dialect, names, unit
        self.items: list[s.Item] = []
        self.paths: list[tuple[int, Path]] = []
        self.findings = Findings()
        self.state = Settings()
        self.previous: tuple[str, str, str] | None = None
        """Position variable, tool and frame of the move before, if that is known."""
        self.number = names.position
        self.made = 0
        self.owner: Procedure | None = None
        self.expressions = Expressions(program, dialect, names, robot, self.next_number)
        self.used, self.shared = self._used()

    def _used(self) -> tuple[set[str], list[str]]:
        """Names that the unit refers to: targets, tools and frames; shared constants."""
        if self.unit is None:
            return set(), []
        mine = [q for q in self.program.procedures if q.unit == self.unit]
        words = mentioned(mine)
        n = self.names
        used = {
            table[w]
            for table in (n.targets, n.joints, n.tools, n.frames)
            for w in words
            if w in table
        }
        return used, [v for v in self.program.variables if v.lower() in words]

    # ------------------------------------------------------------------------- findings

    def report(self, finding: Diagnostic) -> None:
        self.findings.append(finding)

    def cannot(self, what: str, cure: str, place: str | None = None) -> None:
        where = place or (f"procedure {self.owner.name}" if self.owner else None)
        self.report(rules.CANNOT_SAY(what=what, cure=cure, place=where))

    @contextmanager
    def saying(self, place: str | None = None) -> Iterator[None]:
        """What cannot be said in here becomes a finding."""
        try:
            yield
        except Unsayable as unsayable:
            if unsayable.cure == "number":
                name = unsayable.what.split("`")[1]
                self.report(rules.NO_NUMBER(name=name, place=place))
            else:
                self.cannot(unsayable.what, unsayable.cure, place)

    # ---------------------------------------------------------------------------- lines

    def add(self, statement: s.Statement) -> None:
        self.items.append(s.Line(statement=statement))

    def label(self, name: str) -> None:
        self.items.append(s.Line(label=name))
        self.forget()

    def forget(self) -> None:
        """Nothing is known any more: another way may lead here."""
        self.state.forget()
        self.previous = None

    def next_number(self) -> int:
        self.number += 1
        return self.number - 1

    def made_label(self, letter: str) -> str:
        self.made += 1
        return f"{letter}{self.made}"

    def procedure(self, procedure: Procedure) -> None:
        """The lines of a procedure's body."""
        self.owner = self.expressions.procedure = procedure
        if procedure.parameters or procedure.result:
            self.cannot(f"parameters or the result of `{procedure.name}`", "use variables instead")
        self.forget()
        self.body(procedure.body)

    def body(self, statements: tuple[p.Statement, ...]) -> None:
        for statement in statements:
            with self.findings.at(statement.span), self.saying():
                STATEMENTS[type(statement)](self, statement)

    # ---------------------------------------------------------------------------- moves

    def setting(self, motion: p.Motion) -> None:
        speed, blend = motion.speed, motion.blend
        if isinstance(speed, e.Name) or isinstance(blend, e.Name):
            raise Unsayable("a speed or blend by name", "declare its value")
        self.settings(speed, blend, motion.tool, motion.frame)

    def settings(self, speed: Speed, blend: Blend, tool: str, frame: str) -> bool:
        """Writes what changes; whether anything did."""
        before = len(self.items)
        for command in changes(self.state, speed, blend, tool, frame, self.names, self.dialect):
            self.add(command)
        return len(self.items) > before

    def move(self, node: p.Move) -> None:
        target = self.destination(node.target)
        self.setting(node.motion)
        self.add(s.Motion("Mov" if node.kind == "joint" else "Mvs", target))
        self.remember(target, node.motion)

    def move_joints(self, node: p.MoveJoints) -> None:
        target = self.expressions.target(node.target)
        self.setting(node.motion)
        self.add(s.Motion("Mov", (target,)))
        self.previous = None

    def destination(self, value: e.Expression) -> tuple[s.Expression, ...]:
        """The arguments of a move; a distance along the tool has a form of its own."""
        match value:
            case e.Apply(function="relative", arguments=(base, x, y, z)) if (
                plain_number(x) == 0 and plain_number(y) == 0
            ):
                return self.expressions.target(base), self.expressions.of(z)
        return (self.expressions.target(value),)

    def remember(self, target: tuple[s.Expression, ...], motion: p.Motion) -> None:
        known = len(target) == 1 and isinstance(target[0], s.Variable)
        plain = known and isinstance(target[0], s.Variable) and target[0].arguments is None
        self.previous = None
        if plain and isinstance(target[0], s.Variable) and "_" not in target[0].name:
            self.previous = target[0].name, motion.tool, motion.frame

    def arc_start(self, tool: str, frame: str) -> s.Variable:
        """The position that an arc starts at; read from the robot if it is not known."""
        if self.previous is not None and self.previous[1:] == (tool, frame):
            return s.Variable(self.previous[0])
        name = self.owner.name if self.owner else "main"
        self.report(rules.ARC_AT_START(name=name, place=f"procedure {name}"))
        start = s.Variable(ARC_START)
        here = s.Variable("P_CURR" if self.dialect.upper else "P_Curr")
        self.add(s.Assign(start, here))
        return start

    def move_circular(self, node: p.MoveCircular) -> None:
        via, target = self.expressions.target(node.via), self.expressions.target(node.target)
        self.setting(node.motion)
        start = self.arc_start(node.motion.tool, node.motion.frame)
        self.add(s.Motion("Mvr", (start, via, target)))
        self.remember((target,), node.motion)

    # ---------------------------------------------------------------------------- paths

    def follow(self, node: p.Follow) -> None:
        path = node.path
        if not len(path):
            raise Unsayable(f"the empty path `{path.name}`", "leave it out")
        first = self.number
        self.number += len(path)
        self.paths.append((first, path))
        for start, stop in segments(path):
            self.segment(path, start, stop, first)
        self.previous = None
        if path.kinds[-1] != Kind.VIA:
            last = len(path) - 1
            tool, frame = path.tools[path.tool[last]], path.frames[path.frame[last]]
            self.previous = f"P{first + last}", tool, frame

    def segment(self, path: Path, start: int, stop: int, first: int) -> None:
        """Rows under the same settings."""
        speed, blend = path.speeds[path.speed[start]], path.blends[path.blend[start]]
        if isinstance(speed, e.Name) or isinstance(blend, e.Name):
            raise Unsayable("a speed or blend by name", "declare its value")
        tool, frame = path.tools[path.tool[start]], path.frames[path.frame[start]]
        self.settings(speed, blend, tool, frame)
        kinds = path.kinds[start:stop]
        if kinds[0] == Kind.VIA:
            known = f"P{first + start - 1}"
            if start == 0 or self.previous != (known, tool, frame):
                begin = self.arc_start(tool, frame)
                ends = (s.Variable(f"P{first + start}"), s.Variable(f"P{first + start + 1}"))
                self.add(s.Motion("Mvr", (begin, *ends)))
                start += 2
                kinds = kinds[2:]
        if start < stop:
            self.items.append(move_rows(kinds, first + start))
        self.previous = f"P{first + stop - 1}", tool, frame

    # -------------------------------------------------------------------------- signals

    def wait(self, node: p.Wait) -> None:
        self.add(s.Command("Dly", (self.expressions.of(node.seconds),)))

    def wait_signal(self, node: p.WaitSignal) -> None:
        if node.timeout is not None:
            raise Unsayable(
                f"a time limit while waiting for `{node.signal}`", "wait without one, or in a loop"
            )
        signal = self.expressions.name(node.signal)
        self.add(s.Command("Wait", (s.Binary("=", signal, self.expressions.of(node.value)),)))

    def wait_until(self, node: p.WaitUntil) -> None:
        if node.timeout is not None:
            raise Unsayable("a time limit while waiting", "wait without one, or in a loop")
        condition = self.expressions.of(node.condition)
        if self.dialect.wide_wait:
            self.add(s.Command("Wait", (condition,)))
            return
        label = self.made_label("W")
        self.items.append(s.Line(label=label))
        self.add(s.If(condition, s.Target(label + "Z"), s.Target(label)))
        self.items.append(s.Line(label=label + "Z"))

    def set_signal(self, node: p.SetSignal) -> None:
        pulse = None if node.pulse is None else self.expressions.of(node.pulse)
        signal = self.expressions.name(node.signal)
        self.add(s.Assign(signal, self.expressions.of(node.value), pulse))

    def gripper(self, node: p.Gripper) -> None:
        if not 1 <= node.hand <= 8:
            raise Unsayable(f"hand {node.hand}", "use hands 1 to 8")
        word = "HOpen" if node.action == "open" else "HClose"
        self.add(s.Command(word, (s.Number(node.hand),)))

    def acceleration(self, node: p.SetAcceleration) -> None:
        values = (node.acceleration, node.deceleration)
        self.add(s.Command("Accel", tuple(self.expressions.of(v) for v in values)))

    def override(self, node: p.SetOverride) -> None:
        self.add(s.Command("Ovrd", (self.expressions.of(node.percent),)))

    # -------------------------------------------------------------------------- control

    def call(self, node: p.Call) -> None:
        if node.arguments:
            raise Unsayable(f"the arguments of `{node.procedure}`", "use variables instead")
        callee = self.program.procedure(node.procedure)
        if callee is None:
            raise Unsayable(f"a call of `{node.procedure}`, which is missing", "add the procedure")
        if callee.unit == self.unit:
            if self.is_first(callee):
                raise Unsayable(
                    f"a call of `{callee.name}` from its own program", "move its body elsewhere"
                )
            label = self.names.procedures[callee.name.lower()]
            self.add(s.Jump("GoSub", s.Target(label)))
        else:
            if callee.unit is None or not self.is_first(callee):
                raise Unsayable(
                    f"a call of `{callee.name}` inside another program",
                    "let it be the first procedure of its unit",
                )
            self.add(s.CallP(s.String(self.names.units[callee.unit])))
        self.forget()

    def is_first(self, procedure: Procedure) -> bool:
        """Whether its unit begins with it."""
        if procedure.unit is None:
            return procedure.name.lower() == (self.program.entry or "").lower()
        return procedure is next(q for q in self.program.procedures if q.unit == procedure.unit)

    def assign(self, node: p.Assign) -> None:
        target = self.expressions.of(node.target)
        if not isinstance(target, s.Variable) or target.name.upper() in ("DEG", "P_CURR", "J_CURR"):
            raise Unsayable("an assignment to an expression", "assign to a variable")
        self.add(s.Assign(target, self.expressions.of(node.value)))
        self.previous = None

    def if_(self, node: p.If) -> None:
        if self.dialect.blocks:
            for i, branch in enumerate(node.branches):
                condition = self.expressions.of(branch.condition)
                self.add(s.If(condition, None) if i == 0 else s.ElseIf(condition))
                self.forget()
                self.body(branch.body)
            if node.otherwise:
                self.add(s.Command("Else"))
                self.forget()
                self.body(node.otherwise)
            self.add(s.Command("EndIf"))
            self.forget()
            return
        label = self.made_label("I")
        for i, branch in enumerate(node.branches, start=1):
            condition = self.expressions.of(branch.condition)
            then, following = f"{label}T{i}", f"{label}N{i}"
            self.add(s.If(condition, s.Target(then), s.Target(following)))
            self.label(then)
            self.body(branch.body)
            self.add(s.Jump("GoTo", s.Target(label + "Z")))
            self.label(following)
        self.body(node.otherwise)
        self.label(label + "Z")

    def while_(self, node: p.While) -> None:
        self.add(s.Command("While", (self.expressions.of(node.condition),)))
        self.forget()
        self.body(node.body)
        self.add(s.Command("WEnd"))
        self.forget()

    def for_(self, node: p.For) -> None:
        short = self.expressions.variable(node.variable)
        if short is None:
            raise Unsayable(f"the loop variable `{node.variable}`", "give it another name")
        variable = s.Variable(short)
        first, last = self.expressions.of(node.first), self.expressions.of(node.last)
        step = None if node.step is None or node.step == p.ONE else self.expressions.of(node.step)
        self.add(s.For(variable, first, last, step))
        self.forget()
        self.body(node.body)
        self.add(s.Next((variable,)))
        self.forget()

    def switch(self, node: p.Switch) -> None:
        self.add(s.Select(self.expressions.of(node.subject)))
        for case in node.cases:
            items = tuple(s.CaseRange(self.expressions.of(v)) for v in case.values)
            self.add(s.Case(items))
            self.forget()
            self.body(case.body)
        if node.otherwise:
            self.add(s.Command("Default"))
            self.forget()
            self.body(node.otherwise)
        self.add(s.Command("End Select"))
        self.forget()

    def stop(self, node: p.Stop) -> None:
        if node.end and self.unit is not None:
            raise Unsayable("an end of everything in a called program", "end in the main program")
        self.add(s.Command("End" if node.end else "Hlt"))
        self.previous = None

    def return_(self, node: p.Return) -> None:
        if node.value is not None:
            raise Unsayable("a result of a procedure", "use a variable instead")
        first = self.owner is not None and self.is_first(self.owner)
        self.add(s.Command("End" if first else "Return"))

    def comment(self, node: p.Comment) -> None:
        self.items.append(s.Line(comment=f"' {node.text}" if node.text else "'"))

    def named_label(self, node: p.Label) -> None:
        self.label(self.place(node.name))

    def goto(self, node: p.Goto) -> None:
        self.add(s.Jump("GoTo", s.Target(self.place(node.label))))

    def place(self, name: str) -> str:
        owner = self.owner.name.lower() if self.owner else ""
        short = self.names.labels.get((owner, name.lower()))
        if short is None:
            raise Unsayable(f"a jump to `{name}`, which is missing", "add the label")
        return short

    def message(self, node: p.Message) -> None:
        raise Unsayable(
            f"the message of {len(node.parts)} parts on the teach pendant", "leave it out"
        )

    def opaque(self, node: p.Opaque) -> None:
        line = opaque_line(node, self.dialect)
        if line is None or line.statement is None:
            raise Unsayable(
                f"the {node.language} statement `{node.text}`", "say it in plain statements"
            )
        self.items.append(line)
        self.forget()


def opaque_line(node: p.Opaque, dialect: Dialect) -> s.Line | None:
    """The line of a vendor statement that this dialect accepts as it stands."""
    from assistant.languages.melfa_basic.dialects import DIALECTS

    origin = DIALECTS.get(node.language)
    if origin is None or origin.level > dialect.level:
        return None
    line = read_statement(node.text)
    return line if line and line.label is None and line.comment is None else None


def segments(path: Path) -> Iterator[tuple[int, int]]:
    """Ranges of rows under the same settings; an arc's two rows are never apart."""
    columns = np.column_stack([path.speed, path.blend, path.tool, path.frame])
    differs = (columns[1:] != columns[:-1]).any(axis=1) & (path.kinds[1:] != Kind.END)
    edges = [0, *(np.flatnonzero(differs) + 1).tolist(), len(path)]
    yield from itertools.pairwise(edges)


_KINDS: Final = np.array([MOV, MVS, -1, MVR], dtype=np.int64)


def move_rows(kinds: Any, first: int) -> MoveRows:
    """The moves through P<first> … of rows of these kinds; an arc's two rows are one move."""
    ends = np.flatnonzero(kinds != Kind.VIA)
    code = _KINDS[kinds[ends]]
    number = first + ends.astype(np.int64)
    arc = code == MVR
    return MoveRows(
        "P",
        np.zeros(len(ends), dtype=np.int64),
        code,
        np.where(arc, number - 2, -1),
        np.where(arc, number - 1, -1),
        number,
    )


def mentioned(value: Any) -> set[str]:
    """Every name that statements refer to, in lower case."""
    from dataclasses import fields, is_dataclass

    words: set[str] = set()
    open_: list[Any] = [value]
    while open_:
        node = open_.pop()
        match node:
            case str():
                words.add(node.lower())
            case tuple() | list():
                open_.extend(node)
            case Path():
                open_ += [*node.tools, *node.frames]
            case _ if is_dataclass(node):
                open_ += [getattr(node, f.name) for f in fields(node)]
    return words


STATEMENTS: Final[dict[type, Callable[[Writer, Any], None]]] = {
    p.Move: Writer.move,
    p.MoveCircular: Writer.move_circular,
    p.MoveJoints: Writer.move_joints,
    p.Follow: Writer.follow,
    p.Wait: Writer.wait,
    p.WaitSignal: Writer.wait_signal,
    p.WaitUntil: Writer.wait_until,
    p.SetSignal: Writer.set_signal,
    p.Gripper: Writer.gripper,
    p.SetAcceleration: Writer.acceleration,
    p.SetOverride: Writer.override,
    p.Call: Writer.call,
    p.Assign: Writer.assign,
    p.If: Writer.if_,
    p.While: Writer.while_,
    p.For: Writer.for_,
    p.Switch: Writer.switch,
    p.Stop: Writer.stop,
    p.Return: Writer.return_,
    p.Comment: Writer.comment,
    p.Label: Writer.named_label,
    p.Goto: Writer.goto,
    p.Message: Writer.message,
    p.Opaque: Writer.opaque,
}
