"""Outputs that moves set on their way: what sets up their data, and moves that take these."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from typing import Final

from assistant.languages.rapid.lower.expressions import not_expressible
from assistant.languages.rapid.tables.triggers import (
    FURTHER_TRIGGERS,
    LONGEST_TRIGGER_TIME,
    MOST_TRIGGERS,
    TRIGG_EQUIP,
    TRIGG_IO,
    TRIGGER_MEASURES,
    TRIGGER_MOVES,
    TRIGGER_OUTPUTS,
)
from assistant.languages.rapid.tree import syntax as s
from assistant.program import expressions as e
from assistant.program import statements as p

_TRIGGER_MOVES: Final = {move.plain: move for move in TRIGGER_MOVES.values()}
_MEASURE_OPTIONS: Final = {measure: option for option, measure in TRIGGER_MEASURES.items()}
_OUTPUT_OPTIONS: Final[Mapping[str, str]] = {
    kind: option for option, kind in TRIGGER_OUTPUTS.items()
}
_SPELLED_OPTIONS: Final = {
    "start": "Start",
    "time": "Time",
    "dop": "DOp",
    "gop": "GOp",
    "aop": "AOp",
}


def with_triggers(
    move: s.ProcedureCall,
    triggers: tuple[p.Trigger, ...],
    names: Mapping[p.Trigger, str],
    set_up: Callable[[p.Trigger, s.NameRef], s.ProcedureCall],
) -> Iterator[s.ProcedureCall]:
    """A plain move, as one that sets outputs; in front of it what sets up their data.

    names: of the variables. set_up: see `set_up`.
    """
    for what, cure in _untranslatable_triggers(str(move.name), triggers):
        raise not_expressible(what, cure)
    kind = _TRIGGER_MOVES[str(move.name)]
    variables = [s.NameRef(names[trigger]) for trigger in triggers]
    yield from map(set_up, triggers, variables)
    first, *others = variables
    more = (
        s.Option(name.upper(), one) for name, one in zip(FURTHER_TRIGGERS, others, strict=False)
    )
    before, after = move.arguments[: kind.place], move.arguments[kind.place :]
    taking: tuple[s.Argument, ...] = (*before, s.Positional(first), *more, *after)
    yield replace(move, name=kind.word, arguments=taking)


def trigger_set_up(
    x: p.Trigger,
    variable: s.NameRef,
    signal: s.NameRef,
    kind: str,
    lower: Callable[[e.Expression], s.Expression],
) -> s.ProcedureCall:
    """What sets up the data of one output; kind: of the signal."""
    measure = _MEASURE_OPTIONS[x.measure]
    arguments: list[s.Argument] = [s.Positional(variable), s.Positional(lower(x.amount))]
    if measure:
        arguments.append(s.Option(_SPELLED_OPTIONS[measure]))
    if x.ahead is not None:
        arguments.append(s.Positional(lower(x.ahead)))
    arguments += (
        s.Option(_SPELLED_OPTIONS[_OUTPUT_OPTIONS[kind]], signal),
        s.Positional(lower(x.value)),
    )
    return s.ProcedureCall((TRIGG_IO if x.ahead is None else TRIGG_EQUIP).word, tuple(arguments))


def _untranslatable_triggers(
    word: str, triggers: tuple[p.Trigger, ...]
) -> Iterator[tuple[str, str]]:
    """What RAPID has no instruction for, and what to do instead."""
    if word not in _TRIGGER_MOVES:
        yield (
            f"outputs on the way of a {word}",
            "move to a target, or set them before or after the move",
        )
    if len(triggers) > MOST_TRIGGERS:
        yield (
            f"more than {MOST_TRIGGERS} outputs on the way of one move",
            "divide the move, or set some before or after it",
        )
    for one in triggers:
        yield from _untranslatable_trigger(one)


def _untranslatable_trigger(x: p.Trigger) -> Iterator[tuple[str, str]]:
    name = f"`{x.signal}`"
    if x.pulse is not None:
        cure = "set it there, and set it back at another place of the way"
        yield f"a pulse of {name} on the way of a move", cure
    if x.measure == "share":
        cure = "give the place in mm, from the start or before the end"
        yield f"that {name} is set when a share of a way of unknown length is done", cure
    if x.measure == "time":
        if x.ahead is not None:
            cure = "give the sum of both times"
            yield f"a delay of what {name} sets beside a time before the end", cure
        if isinstance(x.amount, e.Number) and x.amount.value > LONGEST_TRIGGER_TIME:
            cure = "give a distance, or a shorter time"
            yield f"that {name} is set more than {LONGEST_TRIGGER_TIME:g} s before the end", cure
