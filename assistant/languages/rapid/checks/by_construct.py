"""What names and values mean where they are used: one walk over a module, a table of rules."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Final

from assistant.languages.checks.registry import Found
from assistant.languages.rapid.checks import calls, names_used, values
from assistant.languages.rapid.checks.kinds import Scope
from assistant.languages.rapid.checks.module_view import Look
from assistant.languages.rapid.checks.places import places
from assistant.languages.rapid.tree import syntax as s

Rules = tuple[Callable[[Any, Scope], Found], ...]

RULES: Final[Mapping[type, Rules]] = {
    s.ProcedureCall: (calls.procedure,),
    s.FunctionCall: (calls.function,),
    s.NameRef: (names_used.without_value,),
    s.Connect: (calls.connected,),
    s.Component: (names_used.component,),
    s.Element: (names_used.element, values.indices),
    s.Assignment: (names_used.assigned, names_used.errors, values.assignment),
    s.Data: (names_used.type_of, values.initial),
    s.ParameterNode: (names_used.type_of,),
    s.Routine: (names_used.type_of,),
    s.Record: (names_used.types_of,),
    s.RaiseError: (names_used.errors,),
    s.Handler: (names_used.errors,),
    s.Infix: (names_used.errors, values.operands),
    s.IfBranch: (values.condition,),
    s.CompactIf: (values.condition,),
    s.WhileLoop: (values.condition,),
    s.ReturnFrom: (values.returned,),
    s.TestOf: (names_used.errors, values.cases),
    s.Prefix: (values.negated,),
}
"""One line adds a rule of a construct."""


def uses(look: Look) -> Found:
    for node, scope in look.once(places):
        for rule in RULES.get(type(node), ()):
            yield from rule(node, scope)
