"""Routines that run while an error is handled."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, Final

from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.walk import nodes

ERRNO: Final = "errno"
"""The variable in lower case that holds the number of the error."""


def of_handlers(modules: Sequence[s.Module]) -> frozenset[str]:
    """Names in lower case of the routines that handlers call, and that these call."""
    routines = [one for module in modules for one in module.items if isinstance(one, s.Routine)]
    calls: dict[str, set[str]] = {}
    pending: list[str] = []
    for one in routines:
        calls.setdefault(one.name.lower(), set()).update(called_in(one.body))
        pending += called_in(one.handlers)
    found: set[str] = set()
    while pending:
        name = pending.pop()
        if name in calls and name not in found:
            found.add(name)
            pending += calls[name]
    return frozenset(found)


def called_in(value: Any) -> Iterator[str]:
    """Names in lower case of the routines that nodes call."""
    for node in nodes(value):
        if isinstance(node, s.FunctionCall | s.ProcedureCall) and isinstance(node.name, str):
            yield node.name.lower()
