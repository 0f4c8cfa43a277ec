"""Messages: RAPID's take one string, so that a value needs ValToStr and a text must not have it.

A part is a value only if it is known to be no text. Names that other modules declare are not
known: in RAPID they stand in a message as they are, and so they must be strings.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Final

from assistant.languages.rapid.tables.words import COMPONENTS
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.program import Procedure, Program, walk
from assistant.program.rewriting import map_bodies

Kinds = Mapping[str, str]
"""Lower-case names of values and functions: `text`, or anything else for other values."""

_TEXTS: Final = ("text", "fixed", "part")
"""The type, and functions that give one."""
_LITERALS: Final = (e.Number, e.Truth, e.TargetValue, e.JointValue, e.PoseValue)


def kinds(program: Program, procedure: Procedure) -> Kinds:
    """What is known of the names that a procedure sees."""
    known: dict[str, str] = {}
    known |= {q.name.lower(): q.result for q in program.procedures if q.result is not None}
    for table, kind in (
        (program.targets, "position"),
        (program.joint_targets, "joints"),
        (program.signals, "number"),
    ):
        known |= {n.lower(): kind for n in table}
    for variables in (program.variables, procedure.variables):
        known |= {n.lower(): v.type for n, v in variables.items()}
    known |= {q.name.lower(): q.type for q in procedure.parameters}
    for statement in walk(procedure.body):
        if isinstance(statement, p.For):
            known.setdefault(statement.variable.lower(), "number")
    return known


def is_value(x: e.Expression, known: Kinds) -> bool:
    """Whether an expression surely is no text."""
    match x:
        case e.Name(name):
            return known.get(name.lower(), "text") not in _TEXTS
        case e.Index(value):
            return is_value(value, known)
        case e.Member(_, field):
            return field in COMPONENTS
        case e.Unary() | e.Elapsed() | e.Here():
            return True
        case e.Binary("+", left, right):
            return is_value(left, known) and is_value(right, known)
        case e.Binary():
            return True
        case e.Apply(function):
            return (function in e.FUNCTIONS and function not in _TEXTS) or known.get(
                function.lower(), "text"
            ) not in _TEXTS
    return isinstance(x, _LITERALS)


def parts(x: p.Message, known: Kinds) -> tuple[e.Expression, ...]:
    """What a message shows one after the other: values as they are, texts as they are."""
    found: list[e.Expression] = []
    pending = list(reversed(x.parts))
    while pending:
        part = pending.pop()
        if isinstance(part, e.Binary) and part.operator == "+" and not is_value(part, known):
            pending += [part.right, part.left]
        elif (
            isinstance(part, e.Apply)
            and part.function == "text"
            and len(part.arguments) == 1
            and is_value(part.arguments[0], known)
        ):
            found.append(part.arguments[0])
        else:
            found.append(part)
    return tuple(found)


def lines(parts: Iterable[e.Expression], longest: int) -> list[list[e.Expression]]:
    """The parts of as many messages as it takes if none may have more characters than that."""
    rows: list[list[e.Expression]] = [[]]
    room = longest
    for part in parts:
        pieces: list[e.Expression] = [part]
        if isinstance(part, e.Text):
            text = part.value
            cut = [e.Text(text[i : i + longest]) for i in range(0, len(text), longest)]
            pieces = [*cut] or [part]
        for piece in pieces:
            length = len(piece.value) if isinstance(piece, e.Text) else VALUE_LENGTH
            if rows[-1] and length > room:
                rows.append([])
                room = longest
            rows[-1].append(piece)
            room -= length
    return rows


VALUE_LENGTH: Final = 10
"""Characters that a value is taken to have."""


def with_values(program: Program) -> Program:
    """A program lifted from RAPID, in which messages show values that need no conversion."""
    if not any(isinstance(x, p.Message) for x in program.statements()):
        return program

    def shown(procedure: Procedure) -> Procedure:
        known = kinds(program, procedure)

        def body(statements: tuple[p.Statement, ...]) -> tuple[p.Statement, ...]:
            return tuple(map(said, statements))

        def said(x: p.Statement) -> p.Statement:
            if isinstance(x, p.Message):
                return replace(x, parts=parts(x, known))
            inner: p.Statement = map_bodies(x, body)
            return inner

        return replace(procedure, body=body(procedure.body))

    return replace(program, procedures=tuple(map(shown, program.procedures)))
