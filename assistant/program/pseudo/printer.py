"""Printer of the text form: one statement a line, blocks indented by two blanks.

A single part of a program, as a message names it, is printed on one line.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import field, replace
from typing import Any, Final, get_args

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Refused
from assistant.program.expressions import Expression
from assistant.program.geometry import Configuration, Frame, JointTarget, Pose, Target, Tool
from assistant.program.motion import Blend, Path, Speed
from assistant.program.program import Parameter, Procedure, Program, Signal, Variable
from assistant.program.pseudo.declarations import (
    header_text,
    opaque_lines,
    parameter_text,
    section_lines,
    signal_text,
    variable_lines,
    variable_text,
)
from assistant.program.pseudo.expressions import (
    arguments_text,
    blend_text,
    configuration_text,
    expression_text,
    frame_text,
    joints_text,
    pose_text,
    speed_text,
    target_text,
    tool_text,
)
from assistant.program.pseudo.path_rows import TableWriter, row_lines
from assistant.program.pseudo.statements import (
    motion_text,
    move_blend_text,
    move_speed_text,
    statement_text,
    trigger_text,
)
from assistant.program.pseudo.words import (
    MOST_BLOCKS,
    TOO_DEEP,
    comment_text,
    name_text,
    number_text,
)
from assistant.program.statements import (
    Branch,
    Case,
    ComputedBlend,
    ComputedSpeed,
    Follow,
    For,
    If,
    Motion,
    Opaque,
    Statement,
    Switch,
    Trigger,
    While,
)

_INDENT: Final = "  "


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
    """Printer of one program, with the state that all its parts share."""

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
            yield _INDENT + line
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
        yield _INDENT + line


def part_text(part: object) -> str:
    """Any part of a program; of what holds statements its first line."""
    try:
        return _printed_part(part) or _class_in_words(part)
    except (Refused, ValueError):  # what no text can say is named at least
        return _class_in_words(part)


def _printed_part(part: object) -> str:
    match part:
        case None:
            return "nothing"
        case bool():
            return "true" if part else "false"
        case int() | float():
            return number_text(part)
        case str():
            return f"`{part}`"
        case tuple():
            return ", ".join(map(part_text, part)) or "nothing"
        case Mapping():
            return ", ".join(f"{name} {part_text(value)}" for name, value in part.items())
        case Branch():
            return f"if {expression_text(part.condition)}"
        case Case():
            return "case " + ", ".join(map(expression_text, part.values))
        case _ if isinstance(part, get_args(Expression)):
            return f"`{expression_text(part)}`"
        case _ if isinstance(part, get_args(Statement)):
            return f"`{statement_text(part) or block_text(part)}`"
    printer = _PRINTERS.get(type(part))
    return printer(part) if printer else _class_in_words(part)


def _class_in_words(part: object) -> str:
    """`a wait until` of an object of the class `WaitUntil`."""
    words = re.sub(r"(?<!^)(?=[A-Z])", " ", type(part).__name__).lower()
    return f"an {words}" if words[0] in "aeiou" else f"a {words}"


_PRINTERS: Final[dict[type, Callable[[Any], str]]] = {
    Blend: blend_text,
    ComputedBlend: move_blend_text,
    ComputedSpeed: move_speed_text,
    Configuration: configuration_text,
    Frame: frame_text,
    JointTarget: joints_text,
    Motion: motion_text,
    Parameter: parameter_text,
    Path: lambda path: f"the path `{path.name}`",
    Pose: pose_text,
    Procedure: procedure_text,
    Signal: signal_text,
    Speed: speed_text,
    Target: target_text,
    Tool: tool_text,
    Trigger: trigger_text,
    Variable: variable_text,
}
