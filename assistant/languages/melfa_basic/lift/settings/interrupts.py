"""Interrupts: what they call, where they are switched on, and where off."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final

from assistant.languages.melfa_basic.lift.structure.blocks import Code
from assistant.languages.melfa_basic.lift.structure.regions import target_name
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.blocks import statement_of
from assistant.languages.melfa_basic.tree.walk import literal, statements_in
from assistant.languages.settings.flow import Interrupt

_ALL_INTERRUPTS: Final = 0
"""The number by which `Act` switches all."""

_InterruptKey = tuple[type, float | None]
"""The statement that defines an interrupt, and its number: None if that is worked out."""


@dataclass(slots=True)
class _InterruptLines:
    """By interrupt, the places of what it calls, and of lines that switch it on and off."""

    called: dict[_InterruptKey, set[int]] = field(default_factory=dict)
    on: dict[_InterruptKey, set[int]] = field(default_factory=dict)
    off: dict[_InterruptKey, set[int]] = field(default_factory=dict)


def calls_on_interrupt(statement: s.Statement) -> bool:
    """Whether it is an interrupt that calls: `GoTo` leaves what the program was doing."""
    return isinstance(statement, s.OnCom) or (
        isinstance(statement, s.DefAct) and statement.keyword == "GoSub"
    )


def interrupts_of(
    code: Code, entries: Mapping[str, int], answers: Mapping[str, int]
) -> list[Interrupt]:
    """Those that call. entries: where the lines below each label begin, upper case. answers:
    procedures by the labels by which interrupts alone lead there.
    """
    found = _InterruptLines()
    places_of = {entries[label]: number for label, number in answers.items() if label in entries}
    for at, item in enumerate(code):
        whole = statement_of(item)
        for statement in statements_in(whole):
            _note_interrupt(statement, at, statement is whole, entries, answers, found)
    made = []
    for (kind, number), called in found.called.items():
        on = {None, _ALL_INTERRUPTS, number} if number is not None else None
        places = [
            at
            for (switched, n), ats in found.on.items()
            if switched is kind and (on is None or n in on)
            for at in ats
        ]
        off = found.off.get((kind, _ALL_INTERRUPTS), set()) | found.off.get((kind, number), set())
        answer = places_of.get(next(iter(called))) if len(called) == 1 else None
        made.append(Interrupt(frozenset(called), frozenset(places), frozenset(off), answer))
    return made


def _note_interrupt(
    statement: s.Statement,
    at: int,
    certain: bool,
    entries: Mapping[str, int],
    answers: Mapping[str, int],
    found: _InterruptLines,
) -> None:
    """certain: it runs whenever its line does."""
    match statement:
        case s.DefAct(number, target=target) | s.OnCom(number, target):
            label = target_name(target)
            place = entries.get(label)
            if (calls_on_interrupt(statement) or label in answers) and place is not None:
                key = type(statement), _interrupt_number(number)
                found.called.setdefault(key, set()).add(place)
        case s.Command("Act", (s.Binary("=", number, s.Number(0)),)) if literal(number) is not None:
            if certain:
                found.off.setdefault((s.DefAct, literal(number)), set()).add(at)
        case s.Command("Act", arguments):
            given = arguments[0] if arguments else None
            number = given.left if isinstance(given, s.Binary) else None
            found.on.setdefault((s.DefAct, literal(number)), set()).add(at)
        case s.Com(line, state):
            key = s.OnCom, _interrupt_number(line)
            if state == "On":
                found.on.setdefault(key, set()).add(at)
            elif certain and key[1] is not None:
                found.off.setdefault(key, set()).add(at)


def _interrupt_number(node: s.Expression | None) -> float | None:
    """That of an interrupt; a line that is not named is the first."""
    return 1 if node is None else literal(node)
