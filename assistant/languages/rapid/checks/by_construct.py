"""What names and values mean where they are used: one walk over a module, a table of rules."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any, Final

from assistant.languages.rapid.checks import calls, names_used, values
from assistant.languages.rapid.checks.kinds import Scope, Types
from assistant.languages.rapid.checks.module_view import Look
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.walk import inside
from assistant.program.diagnostics import Diagnostic

Rules = tuple[Callable[[Any, Scope], Iterator[Diagnostic]], ...]

RULES: Final[Mapping[type, Rules]] = {
    s.ProcedureCall: (calls.procedure,),
    s.FunctionCall: (calls.function,),
    s.Connect: (calls.connected,),
    s.Component: (names_used.component,),
    s.Element: (names_used.element, values.indices),
    s.Assignment: (names_used.assigned, values.assignment),
    s.Data: (names_used.type_of, values.initial),
    s.ParameterNode: (names_used.type_of,),
    s.Routine: (names_used.type_of,),
    s.Record: (names_used.types_of,),
    s.MoveRunNode: (names_used.moved,),
    s.Infix: (values.operands,),
    s.IfBranch: (values.condition,),
    s.CompactIf: (values.condition,),
    s.WhileLoop: (values.condition,),
    s.ReturnFrom: (values.returned,),
    s.TestOf: (values.cases,),
    s.Prefix: (values.negated,),
}
"""One line adds a rule of a construct."""

LEAVES: Final = frozenset(
    {s.NumberLiteral, s.StringLiteral, s.BoolLiteral, s.NameRef, s.CommentLine, s.Placeholder}
)
"""Most of a tree: nodes without rules and without anything inside."""


def uses(look: Look) -> Iterator[Diagnostic]:
    for node, scope in _places(look):
        for rule in RULES.get(type(node), ()):
            yield from rule(node, scope)


def _places(look: Look) -> Iterator[tuple[s.Node, Scope]]:
    """Every node with what names mean there, as they stand in the text; no rows of runs."""
    pending: list[tuple[Any, Scope]] = [(look.module.items, Scope(Types(look)))]
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
