"""Rules of values that are written out: strings, initial values of persistents."""

from __future__ import annotations

from assistant.languages.checks.registry import Found
from assistant.languages.rapid import rules
from assistant.languages.rapid.checks.module_view import Look
from assistant.languages.rapid.tables.words import LONGEST_STRING
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.gather import literal_number


def strings(look: Look) -> Found:
    for node in look.all(s.StringLiteral):
        if len(node.value) > LONGEST_STRING:
            yield look.finding(rules.LONG_STRING, node, length=len(node.value))


def persistents(look: Look) -> Found:
    for node in look.all(s.Data):
        if node.storage == "PERS" and node.value is not None and not literal(node.value):
            yield look.finding(rules.NOT_LITERAL, node, name=node.name)


def literal(value: s.Expression) -> bool:
    if isinstance(value, s.AggregateNode):
        return all(literal(v) for v in value.items)
    return (
        isinstance(value, s.BoolLiteral | s.StringLiteral | s.Placeholder)
        or literal_number(value) is not None
    )
