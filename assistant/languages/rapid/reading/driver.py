"""A sound text of RAPID by lark's tables. A damaged one is left to `recovery`."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Any, Final

from assistant.languages.lalr import END, Tables
from assistant.languages.rapid.reading.grammar import grammar
from assistant.languages.rapid.recovery.lexemes import scanner

if TYPE_CHECKING:
    from assistant.languages.rapid.reading.nodes import Nodes

IGNORED: Final = frozenset({"BLANK", "COMMENT"})


def drive(text: str, start: str, nodes: Nodes) -> tuple[Any, int] | None:
    """What `nodes` made of a whole text and the most values that stood on the stack.

    None where a word does not fit.
    """
    tables = _tables(start)
    table = tables.rows
    states, values, begins, ends = [tables.first], list[Any](), list[int](), list[int]()
    deepest = 0
    for match in scanner().finditer(text):
        type = match.lastgroup
        if type in IGNORED or (type == "NOTE" and type not in table[states[-1]]):
            continue
        while True:
            action = table[states[-1]].get(type)
            if action is None:
                return None
            if isinstance(action, int):
                break
            action.reduce(table, states, values, begins, ends, nodes)
        states.append(action)
        values.append(match[0])
        begins.append(match.start())
        ends.append(match.end())
        if len(states) > deepest:
            deepest = len(states)
    while states[-1] != tables.last or len(values) != 1:
        action = table[states[-1]].get(END)
        if action is None:
            return None
        action.reduce(table, states, values, begins, ends, nodes)
    return values[0], deepest


@cache
def _tables(start: str) -> Tables:
    return Tables.of(grammar(), start)
