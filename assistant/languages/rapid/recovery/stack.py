"""lark's stack of states, moved forward without building anything."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

States = Sequence[int]
Table = Mapping[Any, Mapping[str, tuple[Any, Any]]]


def after(table: Table, end: Any, states: States, terminals: Iterable[str]) -> list[int] | None:
    """The stack when these terminals have been shifted, None where one does not fit."""
    stack = list(states)
    return stack if all(shift(table, end, stack, terminal) for terminal in terminals) else None


def shift(table: Table, end: Any, stack: list[Any], terminal: str) -> bool:
    """Shifts one terminal in place; False, with the stack spoiled, where it does not fit."""
    from lark.parsers.lalr_analysis import Shift

    while True:
        found = table[stack[-1]].get(terminal)
        if found is None:
            return False
        action, target = found
        if action is Shift:
            stack.append(target)
            return True
        size = len(target.expansion)
        if size:
            del stack[-size:]
        stack.append(table[stack[-1]][target.origin.name][1])
        if terminal == "$END" and stack[-1] == end:
            return True
