"""Messages to operators and questions that they answer.

A part of a message is a value only if it is known to be no text. Names that other files declare are
not known: in a language whose messages take one text they stay as they are, and so must be texts.

For languages without dialogs a question waits for inputs. A key is an input that is on while it is
pressed; a number is at a group of inputs, and is taken when another one goes on. Each answer begins
with the release, so that none answers twice.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from functools import reduce
from typing import TYPE_CHECKING, Final

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.declared_types import KnownTypes, is_value, known_types
from assistant.program.program import Procedure, Program, Signal
from assistant.program.rewriting import map_bodies, records

if TYPE_CHECKING:
    from assistant.program.passes.legalisation import Rewording

_VALUE_LENGTH: Final = 10
"""Assumed number of characters of a value."""


def message_parts(x: p.Message, known: KnownTypes) -> tuple[e.Expression, ...]:
    """Return the parts of a message in display order: values as they are, texts as they are."""
    found: list[e.Expression] = []
    for part in _summands(x.parts, lambda one: not is_value(one, known)):
        match part:
            case e.Apply("text", (value,)) if is_value(value, known):
                found.append(value)
            case _:
                found.append(part)
    return tuple(found)


def _summands(
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
            length = len(piece.value) if isinstance(piece, e.Text) else _VALUE_LENGTH
            if rows[-1] and length > room:
                rows.append([])
                room = longest
            rows[-1].append(piece)
            room -= length
    return rows


def short_messages(r: Rewording, node: p.Message) -> Iterator[p.Statement]:
    """Yield as many messages as the limit of characters per message requires."""
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


KEY: Final = "operator_key_{}"
"""The input of a key, counted from 1."""
NUMBER: Final = "operator_number"
ENTERED: Final = "operator_entered"
"""The input that tells that the number is there."""
_PREFIX: Final = "operator_"
_BITS: Final = 15
"""Bits of a number: with one more, controllers may read it as a negative one."""


def is_operators(name: str) -> bool:
    """True if a signal is one for an operator's answer."""
    return name.lower().startswith(_PREFIX)


def asked_for_key(
    answer: e.Expression | None,
    keys: Sequence[int],
    values: Sequence[e.Expression],
    counts: Sequence[e.Expression | None] = (),
) -> Iterator[p.Statement]:
    """Waits until one of some keys is pressed, the first of which gives the answer its value.

    answer: None if nobody asks which. values: of the keys, in their order. counts: conditions under
    which each of them counts, None for one that always does; none at all if all of them do.
    """
    names = [KEY.format(key) for key in keys]
    each = [_signal_is(name, 1) for name in names]
    free = [_signal_is(name, 0) for name in names]
    for at, one in enumerate(counts):
        if one is not None:
            each[at] = e.Binary("and", each[at], one)
            free[at] = e.Unary("not", each[at])
    yield p.WaitUntil(_all_of_parts("and", free))
    pressed = p.WaitUntil(_all_of_parts("or", each))
    if answer is None or len(keys) == 1:
        yield pressed
        yield from () if answer is None else (p.Assign(answer, values[0]),)
        return
    # whoever lets a key go before it is looked at has to press again
    none = e.Number(_NO_KEY)
    yield p.Assign(answer, none)
    chosen = (
        p.Branch(one, (p.Assign(answer, value),)) for one, value in zip(each, values, strict=True)
    )
    yield p.While(e.Binary("=", answer, none), (pressed, p.If(tuple(chosen))))


_NO_KEY: Final = -1
"""Value that no key has."""


def asked_for_number(
    answer: e.Expression, least: e.Expression | None = None, most: e.Expression | None = None
) -> Iterator[p.Statement]:
    """Waits until a number is entered, and again while it is not from the least to the most."""
    taken = (
        p.WaitUntil(_signal_is(ENTERED, 0)),
        p.WaitUntil(_signal_is(ENTERED, 1)),
        p.Assign(answer, e.Name(NUMBER)),
    )
    yield from taken
    wrong: list[e.Expression] = []
    wrong += [] if least is None else [e.Binary("<", answer, least)]
    wrong += [] if most is None else [e.Binary(">", answer, most)]
    if wrong:
        yield p.While(_all_of_parts("or", wrong), taken)


def with_answers(program: Program) -> Program:
    """The program with the signals that its questions are answered by."""
    known = {name.lower() for name in program.signals}
    found: dict[str, Signal] = {}
    for one in records(program.procedures):
        if isinstance(one, e.Name) and is_operators(one.name) and one.name not in known:
            number = one.name == NUMBER
            kind, bits = ("group", _BITS) if number else ("digital", 1)
            found[one.name] = Signal(kind, "input", bits=bits)  # type: ignore[arg-type]
    ordered = {name: found[name] for name in sorted(found)}
    return replace(program, signals={**program.signals, **ordered}) if found else program


def _signal_is(signal: str, value: int) -> e.Expression:
    return e.Binary("=", e.Name(signal), e.Number(value))


def _all_of_parts(operator: e.BinaryOperator, parts: Iterable[e.Expression]) -> e.Expression:
    return reduce(lambda left, right: e.Binary(operator, left, right), parts)
