"""Every node of a module with what names mean there."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Final, TypeVar

from assistant.languages.checks.views import by_type
from assistant.languages.rapid.checks.kinds import Scope, Types
from assistant.languages.rapid.checks.module_view import Look
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.walk import inside

N = TypeVar("N", bound=s.Node)

LEAVES: Final = frozenset(
    {s.NumberLiteral, s.StringLiteral, s.BoolLiteral, s.NameRef, s.CommentLine, s.Placeholder}
)
"""Most of a tree: nodes without rules and without anything inside."""


def places(look: Look) -> list[tuple[s.Node, Scope]]:
    """The nodes as they stand in the text, without leaves and rows of runs."""
    return list(_places(look))


def placed(look: Look, kind: type[N]) -> list[tuple[N, Scope]]:
    """Those of one class."""
    return look.once(_by_type).get(kind, [])


def _by_type(look: Look) -> dict[type, list[tuple[Any, Scope]]]:
    return by_type((node, (node, scope)) for node, scope in look.once(places))


def _places(look: Look) -> Iterator[tuple[s.Node, Scope]]:
    pending: list[tuple[Any, Scope]] = [(look.module.items, Scope(look.once(Types)))]
    while pending:
        item, scope = pending.pop()
        if isinstance(item, tuple):
            pending.extend([(one, scope) for one in reversed(item) if type(one) not in LEAVES])
        elif isinstance(item, s.ForLoop):
            pending.append((item.body, scope.inside(item)))
            pending.append(((item.first, item.last, item.step), scope))
        elif isinstance(item, s.Node):
            if isinstance(item, s.Routine):
                scope = Scope(scope.types, item)
            yield item, scope
            for name in inside(type(item)) or ():
                part = getattr(item, name)
                if isinstance(part, tuple) or (
                    isinstance(part, s.Node) and type(part) not in LEAVES
                ):
                    pending.append((part, scope))
