"""An adapted program as the tree of one of its units."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from assistant.languages.melfa_basic import header as headers
from assistant.languages.melfa_basic import poses
from assistant.languages.melfa_basic import syntax as s
from assistant.languages.melfa_basic.columnar import MoveRows, PositionRows
from assistant.languages.melfa_basic.dialects import DIALECTS, LAST_STEP, Dialect
from assistant.languages.melfa_basic.lift.gathering import gathered
from assistant.languages.melfa_basic.lower.expressions import (
    joint_constant,
    position_constant,
)
from assistant.languages.melfa_basic.lower.statements import Writer
from assistant.languages.melfa_basic.names import Names, naming
from assistant.program.diagnostics import Diagnostic, Refused
from assistant.program.geometry import Tool
from assistant.program.program import Procedure, Program, Variable

if TYPE_CHECKING:
    from assistant.robots import Robot


def build(program: Program, robot: Robot | None, unit: str | None, dialect_name: str) -> s.File:
    """The tree of one unit; raises Refused with findings for what the language cannot say."""
    dialect = DIALECTS[dialect_name]
    unit_of = Unit(program, robot, unit, dialect, naming(program, dialect))
    code = unit_of.code()
    findings = [f for f in unit_of.findings if f.severity == "error"]
    if findings:
        raise Refused(*findings)
    data = list(unit_of.data())
    return s.File(dialect_name, (*gathered(numbered(code, dialect)), *gathered(data)))


def steps(items: list[s.Item]) -> int:
    """Step numbers that the code lines take."""
    return sum(len(i) if isinstance(i, MoveRows) else 1 for i in items)


def numbered(items: list[s.Item], dialect: Dialect) -> Iterator[s.Item]:
    """The lines with step numbers, in smaller steps if the usual ones would not fit."""
    count = steps(items)
    step = max(1, min(dialect.step, LAST_STEP // max(count, 1)))
    at = step
    for item in items:
        if isinstance(item, MoveRows):
            yield replace(item, steps=at + step * np.arange(len(item), dtype=np.int64))
            at += step * len(item)
        elif isinstance(item, s.Line):
            yield replace(item, number=at)
            at += step


class Unit:
    """One program file of a program: its code lines and its variable lines."""

    def __init__(
        self,
        program: Program,
        robot: Robot | None,
        unit: str | None,
        dialect: Dialect,
        names: Names,
    ) -> None:
        self.program, self.robot, self.unit = program, robot, unit
        self.dialect, self.names = dialect, names
        self.writer = Writer(program, dialect, names, robot, unit)

    @property
    def findings(self) -> list[Diagnostic]:
        return self.writer.findings

    def procedures(self) -> tuple[Procedure | None, list[Procedure]]:
        """The procedure that the unit begins with, and those that it calls."""
        mine = [p for p in self.program.procedures if p.unit == self.unit]
        if self.unit is not None:
            return (mine[0], mine[1:]) if mine else (None, [])
        entry = (self.program.entry or "").lower()
        first = next((p for p in mine if p.name.lower() == entry), None)
        return first, [p for p in mine if p is not first]

    def code(self) -> list[s.Item]:
        """The code lines without step numbers."""
        first, others = self.procedures()
        writer = self.writer
        if first is None and not others:
            return self.heading() if self.has_heading() else []
        self.initial_values()
        if first is not None:
            writer.procedure(first)
        writer.add(s.Command("End"))
        for procedure in others:
            writer.label(self.names.procedures[procedure.name.lower()])
            writer.procedure(procedure)
            writer.add(s.Command("Return"))
        return [*self.heading(), *writer.items]

    def has_heading(self) -> bool:
        p = self.program
        return bool(p.targets or p.joint_targets or p.tools or p.frames or p.variables or p.signals)

    def initial_values(self) -> None:
        """Declarations and first values of the variables, in the order of the heading."""
        for owner, name, variable in self.variables():
            short = self.names.variables[owner, name.lower()]
            whole = s.Variable(short, "$" if short.startswith("C") else "")
            writer = self.writer
            if variable.size:
                writer.cannot(f"the array `{name}`", "use single variables")
            if variable.type == "integer":
                writer.add(s.DefNames("Inte", (whole,)))
            if variable.initial is not None:
                with writer.saying(f"variable {name}"):
                    writer.add(s.Assign(whole, writer.expressions.of(variable.initial)))

    def variables(self) -> Iterator[tuple[str, str, Variable]]:
        """Owner (a procedure's name in lower case or empty), name and variable."""
        if self.unit is None:
            for name, variable in self.program.variables.items():
                yield "", name, variable
        else:
            for name in self.writer.shared:
                yield "", name, self.program.variables[name]
        for procedure in self.program.procedures:
            if procedure.unit == self.unit:
                for name, variable in procedure.variables.items():
                    yield procedure.name.lower(), name, variable

    # ------------------------------------------------------------------------- heading

    def heading(self) -> list[s.Item]:
        head, names, program = headers.Header(), self.names, self.program
        first, others = self.procedures()
        head.program, head.robot, head.unit = program.name, program.robot, self.unit
        if self.unit is None:
            head.entry = first.name if first else "-"
            units = dict.fromkeys(p.unit for p in program.procedures if p.unit is not None)
            head.names["unit"] = {names.units[u]: u for u in units}
            head.names["first"] = {
                names.units[u]: next(p.name for p in program.procedures if p.unit == u)
                for u in units
            }
        elif first is not None:
            head.names["first"] = {names.units[self.unit]: first.name}
        for procedure in others:
            head.names["procedure"][names.procedures[procedure.name.lower()]] = procedure.name
        self._name_labels(head)
        for kind, table, given in self._named():
            head.names[kind] = {table[n.lower()]: n for n in given}
        for owner, name, variable in self.variables():
            head.variables[names.variables[owner, name.lower()]] = headers.Declared(
                name, variable.type, variable.storage,
                next((p.name for p in program.procedures if p.name.lower() == owner), ""),
                variable.local, variable.initial is not None,
            )  # fmt: skip
        head.signals = dict(program.signals)
        inline = self.writer.expressions.inline
        head.paths = [(k, k + len(p) - 1, p.name) for k, p in self.writer.paths if len(p)]
        numbers = [f"P{k}" for k, _ in inline.positions] + [f"J{k}" for k, _ in inline.joints]
        head.inline = dict.fromkeys(numbers)
        above = program.comments if self.unit is None else ()
        texts = [*above, *headers.lines(head, self.dialect.name)]
        return [s.Line(comment=_comment(text)) for text in texts]

    def _name_labels(self, head: headers.Header) -> None:
        mine = {p.name.lower() for p in self.program.procedures if p.unit == self.unit}
        for (owner, _), short in self.names.labels.items():
            original = self.names.original_labels[short]
            if owner in mine and short != original:
                head.names["label"][short] = original
        for (owner, _), short in self.names.loops.items():
            if owner in mine:
                head.names["loop"][short] = self.names.original_loops[short]

    def _named(self) -> Iterator[tuple[str, dict[str, str], list[str]]]:
        """Kind, names and members of the declared things that this unit holds."""
        p, n, used = self.program, self.names, self.writer.used
        for kind, table, given in (
            ("target", n.targets, p.targets),
            ("joints", n.joints, p.joint_targets),
            ("tool", n.tools, p.tools),
            ("frame", n.frames, p.frames),
        ):
            members = [m for m in given if self.unit is None or table[m.lower()] in used]
            yield kind, table, members

    # ---------------------------------------------------------------------------- data

    def data(self) -> Iterator[s.Item]:
        """The variable lines: named positions first, then those of the paths."""
        for kind, table, members in self._named():
            for name in members:
                yield s.Data(s.Variable(table[name.lower()]), self._constant(kind, name))
        inline = self.writer.expressions.inline
        for number, target in inline.positions:
            yield s.Data(s.Variable(f"P{number}"), position_constant(target, self.robot))
        for number, joints in inline.joints:
            yield s.Data(s.Variable(f"J{number}"), joint_constant(joints, self.robot))
        for first, path in self.writer.paths:
            yield PositionRows(
                "P",
                first + np.arange(len(path), dtype=np.int64),
                poses.to_values(path.positions, path.quaternions, path.external, self.robot),
                poses.flags_of(path.configurations, self.robot),
            )

    def _constant(self, kind: str, name: str) -> s.Constant:
        program = self.program
        if kind == "target":
            return position_constant(program.targets[name], self.robot)
        if kind == "joints":
            return joint_constant(program.joint_targets[name], self.robot)
        if kind == "tool":
            tool: Tool = program.tools[name]
            return s.Constant(poses.plain_values(tool.tip), (0, 0))
        return s.Constant(poses.plain_values(program.frames[name].pose.inverse()), (0, 0))


def _comment(text: str) -> str:
    return "' " + text if text else "'"
