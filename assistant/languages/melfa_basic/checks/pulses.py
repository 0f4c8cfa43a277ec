"""Pulses of outputs: how many run at a time."""

from __future__ import annotations

from typing import Final

from assistant.languages.checks.registry import Found
from assistant.languages.melfa_basic.checks import value_rules as rules
from assistant.languages.melfa_basic.checks.file_view import Look
from assistant.languages.melfa_basic.tree import syntax as s

MOST: Final = 4
"""Pulses that run at a time; one more is an error (COSIROP help: DLY)."""


def at_a_time(look: Look) -> Found:
    """More pulses in a row than run beside each other, with nothing between that takes time."""
    count = 0
    for item in look.code:
        statement = item.statement if isinstance(item, s.Line) else None
        if not isinstance(item, s.Line) or item.label is not None:
            count = 0
        if statement is None:
            continue
        if not isinstance(statement, s.Assign):
            count = 0
        elif statement.delay is not None:
            count += 1
            if count == MOST + 1:
                yield look.finding(rules.MANY_PULSES, item, most=MOST)
