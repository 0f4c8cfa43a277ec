"""Every node of a module with what names mean there."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Final, TypeVar

from assistant.languages.checks.file_views import by_type
from assistant.languages.rapid.checks.kinds import Scope, Types
from assistant.languages.rapid.checks.module_view import RuleContext
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.walk import inside

N = TypeVar("N", bound=s.Node)

LEAF_NODES: Final = frozenset(
    {s.NumberLiteral, s.StringLiteral, s.BoolLiteral, s.NameRef, s.CommentLine, s.Placeholder}
)
"""Most of a tree: nodes without anything inside, and without rules but for few names."""


def scoped_nodes(look: RuleContext) -> list[tuple[s.Node, Scope]]:
    """The nodes as they stand in the text, without rows of runs, and without leaves.

    Names of routines, types and modules are no leaves: where data stands they are wrong.
    """
    return list(_walk_scopes(look))


def scoped_nodes_of(look: RuleContext, kind: type[N]) -> list[tuple[N, Scope]]:
    """Those of one class."""
    return look.once(_scoped_by_type).get(kind, [])


def _scoped_by_type(look: RuleContext) -> dict[type, list[tuple[Any, Scope]]]:
    return by_type((node, (node, scope)) for node, scope in look.once(scoped_nodes))


def _walk_scopes(look: RuleContext) -> Iterator[tuple[s.Node, Scope]]:
    odd = look.task.valueless

    def is_leaf(node: Any) -> bool:
        return type(node) in LEAF_NODES and not (
            isinstance(node, s.NameRef) and node.name.lower() in odd
        )

    pending: list[tuple[Any, Scope]] = [(look.module.items, Scope(look.once(Types)))]
    while pending:
        item, scope = pending.pop()
        if isinstance(item, tuple):
            pending.extend([(one, scope) for one in reversed(item) if not is_leaf(one)])
        elif isinstance(item, s.ForLoop):
            pending.append((item.body, scope.inside(item)))
            pending.append(((item.first, item.last, item.step), scope))
        elif isinstance(item, s.Node):
            if isinstance(item, s.Routine):
                scope = Scope(scope.types, item)
            yield item, scope
            for name in inside(type(item)) or ():
                part = getattr(item, name)
                if isinstance(part, tuple) or (isinstance(part, s.Node) and not is_leaf(part)):
                    pending.append((part, scope))
