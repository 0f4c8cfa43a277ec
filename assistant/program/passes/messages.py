"""Messages, for languages whose own take one text: what in them is a value and needs conversion.

A part is a value only if it is known to be no text. Names that other files declare are not known:
in such a language they stand in a message as they are, and so they must be texts.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from typing import Final

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.kinds import KnownTypes, is_value, known_types
from assistant.program.passes.rewording import Rewording
from assistant.program.program import Procedure, Program
from assistant.program.rewriting import map_bodies

VALUE_LENGTH: Final = 10
"""Characters that a value is taken to have."""


def message_parts(x: p.Message, known: KnownTypes) -> tuple[e.Expression, ...]:
    """What a message shows one after the other: values as they are, texts as they are."""
    found: list[e.Expression] = []
    for part in summands(x.parts, lambda one: not is_value(one, known)):
        match part:
            case e.Apply("text", (value,)) if is_value(value, known):
                found.append(value)
            case _:
                found.append(part)
    return tuple(found)


def summands(
    values: Iterable[e.Expression], joins: Callable[[e.Expression], bool]
) -> Iterator[e.Expression]:
    """The values with the operands of each sum that joins instead of it, inner ones too."""
    pending = list(reversed(tuple(values)))
    while pending:
        match pending.pop():
            case e.Binary("+", left, right) as whole if joins(whole):
                pending += [right, left]
            case single:
                yield single


def lines_of_parts(parts: Iterable[e.Expression], longest: int) -> list[list[e.Expression]]:
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


def short_messages(r: Rewording, node: p.Message) -> Iterator[p.Statement]:
    """As many messages as it takes for the characters that one of them may have."""
    shown, most = message_parts(node, r.known) or (e.Text(""),), r.job.can.longest_message
    rows = [list(shown)] if most is None else lines_of_parts(shown, most)
    if len(rows) > 1:
        r.job.changed(
            f"a message of more than {most} characters",
            f"{len(rows)} messages",
            "write a shorter one",
        )
    yield from (p.Message(tuple(row), span=node.span) for row in rows)


def with_values(program: Program) -> Program:
    """A lifted program in which messages show values that need no conversion."""
    if not any(isinstance(x, p.Message) for x in program.statements()):
        return program

    def shown(procedure: Procedure) -> Procedure:
        known = known_types(program, procedure)

        def body(statements: tuple[p.Statement, ...]) -> tuple[p.Statement, ...]:
            return tuple(map(said, statements))

        def said(x: p.Statement) -> p.Statement:
            if isinstance(x, p.Message):
                return replace(x, parts=message_parts(x, known))
            inner: p.Statement = map_bodies(x, body)
            return inner

        return replace(procedure, body=body(procedure.body))

    return replace(program, procedures=tuple(map(shown, program.procedures)))
