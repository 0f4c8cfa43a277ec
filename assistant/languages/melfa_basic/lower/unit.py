"""One program file of a program: the procedures and variables that it holds."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from assistant.languages.melfa_basic.lower.names import Names
from assistant.languages.melfa_basic.lower.statements import STATEMENTS
from assistant.languages.melfa_basic.lower.writer import Writer
from assistant.languages.melfa_basic.tables.dialects import Dialect
from assistant.program.diagnostics import Diagnostic
from assistant.program.passes.procedures import has_functions, procedures_of
from assistant.program.program import Parameter, Procedure, Program, Variable

if TYPE_CHECKING:
    from assistant.robots import Robot


class Unit:
    """A file to be, and what writes it."""

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
        self.writer = Writer(program, dialect, names, robot, unit, STATEMENTS)
        self.writer.functions = has_functions(program, unit, dialect.functions)

    @property
    def findings(self) -> list[Diagnostic]:
        return self.writer.findings

    def procedures(self) -> tuple[Procedure | None, list[Procedure]]:
        return procedures_of(self.program, self.unit)

    def variables(self) -> Iterator[tuple[str, str, Variable | Parameter]]:
        """Owner (a procedure's name in lower case or empty), name and variable."""
        if self.unit is None:
            for name, variable in self.program.variables.items():
                yield "", name, variable
        else:
            for name in self.writer.shared:
                yield "", name, self.program.variables[name]
        for procedure in self.program.procedures:
            if procedure.unit == self.unit:
                for parameter in procedure.parameters:
                    yield procedure.name.lower(), parameter.name, parameter
                for name, variable in procedure.variables.items():
                    yield procedure.name.lower(), name, variable
