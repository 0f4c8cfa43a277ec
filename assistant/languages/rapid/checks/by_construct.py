"""What names and values mean where they are used: one walk over a module, a table of rules."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Final

from assistant.languages.checks.registry import Found
from assistant.languages.rapid.checks import calls, names_used, values
from assistant.languages.rapid.checks.kinds import Scope
from assistant.languages.rapid.checks.module_view import RuleContext
from assistant.languages.rapid.checks.places import scoped_nodes
from assistant.languages.rapid.tree import syntax as s

ConstructRules = tuple[Callable[[Any, Scope], Found], ...]

RULES_BY_CONSTRUCT: Final[Mapping[type, ConstructRules]] = {
    s.ProcedureCall: (calls.procedure_call,),
    s.FunctionCall: (calls.function_call,),
    s.NameRef: (names_used.name_without_value,),
    s.Connect: (calls.connected_trap,),
    s.Component: (names_used.unknown_component,),
    s.Element: (names_used.index_count, values.index_range),
    s.Assignment: (names_used.assigned_data, names_used.unknown_errors, values.assigned_value),
    s.Data: (names_used.unknown_type, values.initial_value),
    s.ParameterNode: (names_used.unknown_type,),
    s.Routine: (names_used.unknown_type,),
    s.Record: (names_used.unknown_component_types,),
    s.RaiseError: (names_used.unknown_errors,),
    s.Handler: (names_used.unknown_errors,),
    s.Infix: (names_used.unknown_errors, values.operand_types),
    s.IfBranch: (values.condition_type,),
    s.CompactIf: (values.condition_type,),
    s.WhileLoop: (values.condition_type,),
    s.ReturnFrom: (values.returned_value,),
    s.TestOf: (names_used.unknown_errors, values.case_types),
    s.Prefix: (values.negated_operand,),
}
"""One line adds a rule of a construct."""


def uses_by_construct(look: RuleContext) -> Found:
    for node, scope in look.once(scoped_nodes):
        for rule in RULES_BY_CONSTRUCT.get(type(node), ()):
            yield from rule(node, scope)
