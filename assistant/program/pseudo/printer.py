"""Prints a program as text: one statement a line, blocks moved in by two blanks."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Final

from assistant.program.diagnostics import Refused
from assistant.program.program import Procedure, Program
from assistant.program.pseudo.declarations import (
    header_text,
    opaque_lines,
    parameter_text,
    section_lines,
    variable_lines,
)
from assistant.program.pseudo.expressions import arguments_text, expression_text
from assistant.program.pseudo.findings import MOST_BLOCKS, TOO_DEEP
from assistant.program.pseudo.rows import row_lines
from assistant.program.pseudo.statements import statement_text
from assistant.program.pseudo.tables import TableWriter
from assistant.program.pseudo.words import comment_text, name_text
from assistant.program.statements import Follow, For, If, Opaque, Statement, Switch, While

INDENT: Final = "  "


@dataclass(frozen=True, slots=True)
class Printed:
    """A program as text, and the side tables that it refers to, by file name."""

    text: str
    tables: Mapping[str, bytes] = field(default_factory=dict)

    def encode(self) -> bytes:
        return self.text.encode("utf-8")


def print_program(program: Program, *, side_tables_above: int | None = None) -> Printed:
    """The text of a program; equal programs give equal texts.

    side_tables_above: paths of more rows than this go to side tables; None keeps every path
    in the text.
    Raises Refused, with the span of the statement, for expressions or blocks of more levels than
    can be read back.
    """
    printer = _Printer(program.name, side_tables_above)
    sections = [[*map(comment_text, program.comments), header_text(program)]]
    sections += [section for section in section_lines(program) if section]
    sections += [list(printer.procedure(procedure)) for procedure in program.procedures]
    text = "\n\n".join("\n".join(section) for section in sections) + "\n"
    return Printed(text, printer.tables.tables)


def block_text(statement: Statement) -> str:
    """The first line of a statement that holds others."""
    return next(_BLOCKS[type(statement)](_Printer("", None), statement))


class _Printer:
    """What is the same all over one program."""

    def __init__(self, program: str, side_tables_above: int | None) -> None:
        self.tables = TableWriter(program)
        self._most_rows = side_tables_above
        self._blocks = 0

    def procedure(self, procedure: Procedure) -> Iterator[str]:
        yield procedure_text(procedure)
        yield from _indented(variable_lines(procedure.variables))
        yield from self._body(procedure.body)
        yield "end"

    def _body(self, body: tuple[Statement, ...]) -> Iterator[str]:
        for statement in body:
            try:
                yield from self._statement(statement)
            except Refused as refused:
                place = statement.span
                raise Refused(
                    *(f if f.span else replace(f, span=place) for f in refused.findings)
                ) from None

    def _statement(self, statement: Statement) -> Iterator[str]:
        line = statement_text(statement)
        if line is not None:
            yield INDENT + line
            return
        self._blocks += 1
        if self._blocks > MOST_BLOCKS:
            cure = "move the inner ones to procedures"
            raise Refused(TOO_DEEP(what="block", cure=cure))
        yield from _indented(_BLOCKS[type(statement)](self, statement))
        self._blocks -= 1

    def _if(self, statement: If) -> Iterator[str]:
        if not statement.branches:
            raise ValueError("an If without a branch")
        for word, branch in zip(_words("if", "elseif"), statement.branches, strict=False):
            yield f"{word} {expression_text(branch.condition)}"
            yield from self._body(branch.body)
        yield from self._otherwise(statement.otherwise)

    def _while(self, statement: While) -> Iterator[str]:
        yield f"while {expression_text(statement.condition)}"
        yield from self._body(statement.body)
        yield "end"

    def _for(self, statement: For) -> Iterator[str]:
        first, last = expression_text(statement.first), expression_text(statement.last)
        step = "1" if statement.step is None else expression_text(statement.step)
        by = "" if step == "1" else f" step {step}"
        to = "towards" if statement.step is None else "to"
        yield f"for {name_text(statement.variable)} from {first} {to} {last}{by}"
        yield from self._body(statement.body)
        yield "end"

    def _switch(self, statement: Switch) -> Iterator[str]:
        yield f"switch {expression_text(statement.subject)}"
        for case in statement.cases:
            yield f"case {arguments_text(case.values)}".rstrip()
            yield from self._body(case.body)
        yield from self._otherwise(statement.otherwise)

    def _otherwise(self, body: tuple[Statement, ...]) -> Iterator[str]:
        if body:
            yield "else"
            yield from self._body(body)
        yield "end"

    def _follow(self, statement: Follow) -> Iterator[str]:
        path = statement.path
        if self._most_rows is not None and len(path) > self._most_rows:
            yield from self.tables.lines(path)
            return
        yield f"follow {name_text(path.name)}"
        yield from _indented(row_lines(path))
        yield "end"

    def _opaque(self, statement: Opaque) -> Iterator[str]:
        yield from opaque_lines(statement.language, statement.text)


_BLOCKS: Final[dict[type, Callable[[_Printer, Any], Iterator[str]]]] = {
    If: _Printer._if,
    While: _Printer._while,
    For: _Printer._for,
    Switch: _Printer._switch,
    Follow: _Printer._follow,
    Opaque: _Printer._opaque,
}


def procedure_text(procedure: Procedure) -> str:
    parameters = ", ".join(map(parameter_text, procedure.parameters))
    parts = [f"procedure {name_text(procedure.name)}" + (f"({parameters})" if parameters else "")]
    parts += [] if procedure.result is None else [f"returns {procedure.result}"]
    parts += [] if procedure.unit is None else [f"unit {name_text(procedure.unit)}"]
    return " ".join(parts + (["local"] if procedure.local else []))


def _words(first: str, others: str) -> Iterator[str]:
    yield first
    while True:
        yield others


def _indented(lines: Iterator[str] | list[str]) -> Iterator[str]:
    for line in lines:
        yield INDENT + line
