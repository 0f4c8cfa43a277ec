"""`M_Timer(1)` … `M_Timer(8)` in trees."""

from __future__ import annotations

from typing import Any

from assistant.languages.melfa_basic.tree import syntax as s


def timer_number(node: Any) -> int | None:
    """The number of the timer that a node is: 0 for one that is worked out, None for none."""
    match node:
        case s.Variable(key="M_TIMER", arguments=(s.Number(value=number),)):
            return int(number) if float(number).is_integer() and number >= 1 else 0
        case s.Variable(key="M_TIMER"):
            return 0
    return None


def timer_variable(word: str, number: int) -> s.Variable:
    return s.Variable(word, "", (s.Number(number),))
