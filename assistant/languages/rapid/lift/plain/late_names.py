r"""Calls by a text of which the program tells what routine it names, as plain calls.

`%"TOOLS:"+"Close"% n;` and `%MODULES{n}+":Close"% n;` call `Close`, if only one module has that.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

from assistant.base.diagnostics import Diagnostic
from assistant.languages.rapid import rules
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.walk import nodes
from assistant.program.rewriting import rewrite

Remarks = Sequence[tuple[Diagnostic, ...]]


def with_bound_calls(
    modules: Sequence[s.Module], before: Mapping[str, str]
) -> tuple[Sequence[s.Module], Remarks]:
    """The modules with such calls by name, and what is found in each.

    before: the names that texts know routines by which have others now, in lower case.
    """
    if not any(_is_late(node) for node in nodes(tuple(modules))):
        return modules, ((),) * len(modules)
    owners: dict[str, list[tuple[str, s.Routine]]] = {}
    for module in modules:
        for item in module.items:
            if isinstance(item, s.Routine) and item.kind == "PROC":
                low = item.name.lower()
                owners.setdefault(before.get(low, low), []).append((module.name.lower(), item))
    made: list[s.Module] = []
    remarks: list[tuple[Diagnostic, ...]] = []
    for module in modules:
        found: list[Diagnostic] = []
        made.append(rewrite(module, partial(_bound_call, owners, found), ()))
        remarks.append(tuple(found))
    return made, remarks


def _is_late(node: Any) -> bool:
    return isinstance(node, s.ProcedureCall) and isinstance(node.name, s.Infix)


def _bound_call(
    owners: Mapping[str, Sequence[tuple[str, s.Routine]]], found: list[Diagnostic], node: Any
) -> Any:
    if not _is_late(node):
        return node
    start, end = _known_end(node.name)
    before, colon, name = end.rpartition(":")
    if start and not colon:
        return node
    own = [
        routine
        for module, routine in owners.get(name.lower(), ())
        if accepts_call(routine, node) and (start or not colon or before.lower() == module)
    ]
    if len(own) != 1:
        return node
    if start and node.span is not None:
        found.append(rules.NAMED_LATE(name=name, span=node.span))
    return replace(node, name=own[0].name)


def accepts_call(routine: s.Routine, call: s.ProcedureCall) -> bool:
    """Whether a routine may be given what a call gives: any other would be an error."""
    required = sum(not group.optional for group in routine.parameters)
    options = {
        one.name.lower()
        for group in routine.parameters
        if group.optional
        for one in group.alternatives
        if isinstance(one, s.ParameterNode)
    }
    given = [one for one in call.arguments if isinstance(one, s.Positional)]
    named = {one.name.lower() for one in call.arguments if not isinstance(one, s.Positional)}
    return len(given) == required and named <= options


def _known_end(value: Any) -> tuple[bool, str]:
    """Whether something unknown stands in front, and the text that a sum surely ends with."""
    match value:
        case s.StringLiteral(text):
            return False, text
        case s.Infix("+", left, s.StringLiteral(text)):
            unknown, before = _known_end(left)
            return unknown, before + text
    return True, ""
