"""A sound text of RAPID by lark's tables. A damaged one is left to `recovery`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from assistant.languages.lalr import END
from assistant.languages.rapid.reading.grammar import tables
from assistant.languages.rapid.reading.scanner import scanner

if TYPE_CHECKING:
    from assistant.languages.rapid.reading.nodes import Nodes

IGNORED: Final = frozenset({"BLANK", "COMMENT"})


def drive(text: str, start: str, nodes: Nodes) -> tuple[Any, int] | None:
    """What `nodes` made of a whole text and the most values that stood on the stack.

    None where a word does not fit.
    """
    found = tables(start)
    rows = found.rows
    states, values, begins, ends = [found.first], list[Any](), list[int](), list[int]()
    deepest = 0
    for match in scanner().finditer(text):
        type = match.lastgroup
        if type in IGNORED or (type == "NOTE" and type not in rows[states[-1]]):
            continue
        state = found.settle(type, states, values, begins, ends, nodes)
        if state is None:
            return None
        states.append(state)
        values.append(match[0])
        begins.append(match.start())
        ends.append(match.end())
        if len(states) > deepest:
            deepest = len(states)
    if found.settle(END, states, values, begins, ends, nodes) is None:
        return None
    return values[0], deepest
