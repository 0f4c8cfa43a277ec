"""Questions to a person as waits for inputs, for languages without dialogs.

A key is an input that is on while it is pressed; a number stands at a group of inputs, and is taken
when another one goes on. Each answer begins with what is let go, so that none answers twice.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from functools import reduce
from typing import Final

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.program import Program, Signal
from assistant.program.rewriting import records

KEY: Final = "operator_key_{}"
"""The input of a key, counted from 1."""
NUMBER: Final = "operator_number"
ENTERED: Final = "operator_entered"
"""The input that tells that the number is there."""
PREFIX: Final = "operator_"
BITS: Final = 15
"""Of a number: with one more, controllers may take it for a negative one."""
MOST: Final = 2**BITS - 1


def is_operators(name: str) -> bool:
    """Whether a signal is one that a person answers by."""
    return name.lower().startswith(PREFIX)


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
    none = e.Number(NO_KEY)
    yield p.Assign(answer, none)
    chosen = (
        p.Branch(one, (p.Assign(answer, value),)) for one, value in zip(each, values, strict=True)
    )
    yield p.While(e.Binary("=", answer, none), (pressed, p.If(tuple(chosen))))


NO_KEY: Final = -1
"""What no key stands for."""


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
            kind, bits = ("group", BITS) if number else ("digital", 1)
            found[one.name] = Signal(kind, "input", bits=bits)  # type: ignore[arg-type]
    ordered = {name: found[name] for name in sorted(found)}
    return replace(program, signals={**program.signals, **ordered}) if found else program


def _signal_is(signal: str, value: int) -> e.Expression:
    return e.Binary("=", e.Name(signal), e.Number(value))


def _all_of_parts(operator: e.BinaryOperator, parts: Iterable[e.Expression]) -> e.Expression:
    return reduce(lambda left, right: e.Binary(operator, left, right), parts)
