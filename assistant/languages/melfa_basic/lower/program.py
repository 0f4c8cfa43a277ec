"""An adapted program as the tree of one of its units."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Final, Literal

import numpy as np

from assistant.base.diagnostics import Declared, Refused
from assistant.languages.melfa_basic.lift.files.program import settings_already_set
from assistant.languages.melfa_basic.lower.constants import joint_constant, position_constant
from assistant.languages.melfa_basic.lower.depended import settings_for_vendor_text
from assistant.languages.melfa_basic.lower.heading import heading, named_members
from assistant.languages.melfa_basic.lower.interrupts import write_interrupt_answers
from assistant.languages.melfa_basic.lower.names import mark, naming
from assistant.languages.melfa_basic.lower.statements import STATEMENTS
from assistant.languages.melfa_basic.lower.writer import Writer
from assistant.languages.melfa_basic.tables import poses
from assistant.languages.melfa_basic.tables.dialects import DIALECTS, LAST_STEP
from assistant.languages.melfa_basic.tables.variables import LETTERS, is_of_controller
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.columnar import PositionRows
from assistant.languages.melfa_basic.tree.line_tables import gathered
from assistant.languages.step_numbers import with_ascending_steps
from assistant.program.analysis.motion_use import branches_by_frame
from assistant.program.passes.procedure_forms import notes_and_body
from assistant.program.program import Parameter, Procedure, Program, ValueType, Variable

if TYPE_CHECKING:
    from assistant.robots import Robot

DEFINITION_WORDS: Final[dict[ValueType, str]] = {
    "number": "Float", "truth": "Float", "integer": "Inte", "text": "Char",
    "position": "Pos", "pose": "Pos", "joints": "Jnt",
}  # fmt: skip
"""The word after `Def` for what all Functions of a file share. A truth is of the type of variables
that nothing defines, as parameters are: what is given by reference must be of the same.
"""


def build(
    program: Program,
    robot: Robot | None,
    unit: str | None,
    dialect_name: str,
    products: bool = False,
) -> s.File:
    """The tree of one unit; raises Refused with findings for what the language cannot say.

    products: targets are multiplied by their frames, else `Base` is set.
    """
    dialect = DIALECTS[dialect_name]
    lines = UnitLines(program, dialect, naming(program, dialect, products), robot, unit)
    code = lines.code()
    findings = [f for f in lines.findings if f.severity == "error"]
    if findings:
        raise Refused(*findings)
    return lines.tree(code)


class UnitLines(Writer):
    """The code lines and the variable lines of a unit."""

    write = STATEMENTS

    def code(self) -> list[s.Item]:
        """The code lines without step numbers."""
        first, others = self.procedures()
        if first is None and not others:
            self.definitions()
            self.initial_values()
            return [*heading(self), *self.items] if self.has_heading() else []
        if self.functions:
            self.as_functions(first, others)
        else:
            self.as_subroutines(first, others)
        return [*heading(self), *self.items]

    def tree(self, code: list[s.Item]) -> s.File:
        """The file of its code lines, which it gave before, and its variable lines."""
        data = list(gathered(list(self.data())))
        depended = settings_for_vendor_text(self.program)
        if depended:
            code = self._without_settings_that_hold(code, data, depended)
        steps = gathered(with_ascending_steps(code, self.dialect.step, LAST_STEP))
        return s.File(self.dialect.name, (*steps, *data))

    def _without_settings_that_hold(
        self, code: list[s.Item], data: Sequence[s.Item], depended: frozenset[int]
    ) -> list[s.Item]:
        """The lines without settings that hold already, of those that kept texts depend on.

        Such a text would depend on what is written for a move, and no longer on what it did.
        """
        tree = s.File(self.dialect.name, (*code, *data))
        again = self.settings.intersection(map(id, settings_already_set(tree, depended)))
        return [item for item in code if id(item) not in again]

    def as_subroutines(self, first: Procedure | None, others: list[Procedure]) -> None:
        """The first procedure, and what it calls behind its end."""
        if first is not None and first.parameters:
            self.add(s.FPrm(tuple(self.variable(first, q) for q in first.parameters)))
        self.definitions()
        self.initial_values()
        if first is not None:
            self.enter(first)
            self.body(first.body)
        self.add(s.Command("End"))
        write_interrupt_answers(self)
        for procedure in others:
            self.label(self.names.procedures[procedure.name.lower()])
            self.enter(procedure)
            self.body(procedure.body)
            if procedure.parameters or procedure.result is not None:
                self.cannot(f"parameters or the result of `{procedure.name}`", "use variables")
            self.add(s.Command("Return"))

    def as_functions(self, first: Procedure | None, others: list[Procedure]) -> None:
        """What all of them share, the entry as `Main`, and the others."""
        self.definitions()
        for procedure in [*([first] if first else []), *others]:
            notes, body = notes_and_body(procedure.body)
            self.body(notes)
            self.add(self.head(procedure, procedure is first))
            if procedure is first:
                self.initial_values()
            self.enter(procedure)
            self.body(body)
            if self.answers:
                self.add(s.Command("End"))
                write_interrupt_answers(self)
            self.add(s.Command("FEnd"))

    def head(self, procedure: Procedure, main: bool) -> s.Function:
        name = "Main" if main else self.names.procedures[procedure.name.lower()]
        letter = "V" if procedure.result is None else LETTERS[procedure.result]
        suffix = "$" if procedure.result == "text" else ""
        parameters = []
        for q in procedure.parameters:
            variable = self.variable(procedure, q)
            mode: Literal["ByVal", "ByRef"] = "ByVal" if q.mode == "in" else "ByRef"
            whole = q.dimensions > 0
            parameters.append(s.FunctionParameter(mode, variable.name, variable.suffix, whole))
        return s.Function(letter + suffix, name, "", tuple(parameters))

    def variable(self, procedure: Procedure, parameter: Parameter) -> s.Variable:
        short = self.names.variables[procedure.name.lower(), parameter.name.lower()]
        return _variable_named(short)

    def has_heading(self) -> bool:
        """Whether a file without code says anything."""
        told = self.program
        data = told.targets, told.joint_targets, told.tools, told.frames, told.variables
        return any(map(bool, (*data, told.signals, told.comments)))

    def definitions(self) -> None:
        """What has a type of its own, or is an array, by type in the order of the heading.

        Functions see of the others' variables only those that are defined before them.
        """
        lines: dict[str, list[s.Variable]] = {}
        arrays = []
        for owner, name, variable in self.variables():
            if not isinstance(variable, Variable):
                continue
            whole = _variable_named(self.names.variables[owner, name.lower()])
            if is_of_controller(whole.name):
                continue
            shared = not owner or variable.initial is not None  # which it gets in the first one
            if variable.size:
                extents = tuple(s.Number(n) for n in variable.size)
                arrays.append(s.Dim((replace(whole, arguments=extents),)))
            elif variable.type == "integer" or (self.functions and shared):
                lines.setdefault(DEFINITION_WORDS[variable.type], []).append(whole)
        for word, variables in lines.items():
            for at in range(0, len(variables), MOST_DEFINED):
                self.add(s.DefNames(word, tuple(variables[at : at + MOST_DEFINED])))
        for dim in arrays:
            self.add(dim)

    def initial_values(self) -> None:
        """First values of the variables, in the order of the heading."""
        for owner, name, variable in self.variables():
            if isinstance(variable, Variable) and variable.initial is not None:
                whole = _variable_named(self.names.variables[owner, name.lower()])
                of = next((q for q in self.program.procedures if q.name.lower() == owner), None)
                about = Declared(name, "variables", of.name if of else "", in_full=True)
                with self.findings.at(variable.span), self.saying(about):
                    self.add(s.Assign(whole, self.expressions.of(variable.initial)))

    # ---------------------------------------------------------------------------- data

    def data(self) -> Iterator[s.Item]:
        """The variable lines: named positions first, then those of the paths."""
        for kind, table, members in named_members(self):
            for name in members:
                if table[name.lower()] in self.names.numbers:
                    continue
                yield s.Data(s.Variable(table[name.lower()]), self._constant(kind, name))
        inline = self.expressions.inline
        for number, target in inline.positions:
            yield s.Data(s.Variable(f"P{number}"), position_constant(target, self.robot))
        for number, joints in inline.joints:
            yield s.Data(s.Variable(f"J{number}"), joint_constant(joints, self.robot))
        for first, path in self.paths:
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
            return s.Constant(poses.plain_values(program.tools[name].tip), (0, 0))
        pose = program.frames[name].pose
        if not self.names.products:
            return s.Constant(poses.plain_values(pose.inverse()), (0, 0))
        flags = branches_by_frame(program, partial(poses.flags_of, robot=self.robot))
        first, second = next(iter(flags.get(name.lower(), ())), USUAL_FLAGS)
        return s.Constant(poses.plain_values(pose), (first, second))


USUAL_FLAGS: Final = (7, 0)
"""Flags of most positions: right, above, not flipped."""
MOST_DEFINED: Final = 8
"""Names of one `Def` line."""


def _variable_named(short: str) -> s.Variable:
    return s.Variable(short, mark(short))
