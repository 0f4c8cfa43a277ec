"""Signals: how statements use them, and those that open and close hands."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from typing import Final

from assistant.languages.rapid.tables import GRIPPER_SIGNAL, GRIPPER_VALUE
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.program import Signal


def with_used(
    declared: Mapping[str, Signal], used: Iterable[tuple[str, Signal]]
) -> dict[str, Signal]:
    """The declared signals, and each other one as it is used first."""
    found = dict(declared)
    known = {name.lower() for name in declared}
    for name, signal in used:
        if name.lower() not in known:
            known.add(name.lower())
            found[name] = signal
    return found


def uses(statements: Iterable[p.Statement]) -> Iterator[tuple[str, Signal]]:
    """The signals that statements set and wait for, digital as far as one can see."""
    for statement in statements:
        match statement:
            case p.SetSignal(name):
                yield name, Signal("digital", "output")
            case p.WaitSignal(name):
                yield name, Signal("digital", "input")


def gripper(signal: str, value: e.Expression) -> p.Gripper | None:
    """The hand that setting a signal opens or closes, if it is one of a hand."""
    match = _HAND.fullmatch(signal)
    if match is None or not isinstance(value, e.Number) or value.value not in _ACTION:
        return None
    return p.Gripper(_ACTION[int(value.value)], int(match[1]))  # type: ignore[arg-type]


_HAND: Final = re.compile(GRIPPER_SIGNAL.format(hand="([1-9][0-9]?)"), re.IGNORECASE)
_ACTION: Final = {value: action for action, value in GRIPPER_VALUE.items()}
