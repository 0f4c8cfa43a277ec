"""Rules of calls: whether there is such a routine, and whether its arguments fit."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

from assistant.languages.checks.names import misspelt
from assistant.languages.checks.registry import Found
from assistant.languages.rapid.checks import names_used
from assistant.languages.rapid.checks import use_rules as rules
from assistant.languages.rapid.checks.arguments import argument_misfits, call_of, signature_of
from assistant.languages.rapid.checks.kinds import Scope
from assistant.languages.rapid.checks.motions import (
    MOVE_WORDS,
    PREDEFINED_SETTINGS,
    nearest_predefined,
    unknown_setting,
)
from assistant.languages.rapid.checks.values import unfit_value
from assistant.languages.rapid.tables import predefined, signatures
from assistant.languages.rapid.tables.signatures import signature
from assistant.languages.rapid.tables.words import TYPE_ENDING
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.walk import root
from assistant.languages.signatures import Parameter, Signature

ROUTINE_KINDS: Final = ("PROC", "FUNC")
_SIGNAL_VALUE_TYPES: Final = frozenset({"num", "dnum", "bool"})
"""Types of values that may be the state of a signal."""


def procedure_call(node: s.ProcedureCall, scope: Scope) -> Found:
    if isinstance(node.name, str):
        yield from _routine_call(node, node.name, "PROC", scope)


def function_call(node: s.FunctionCall, scope: Scope) -> Found:
    yield from _routine_call(node, node.name, "FUNC", scope)


def connected_trap(node: s.Connect, scope: Scope) -> Found:
    yield from names_used.unknown_data(node.interrupt, scope)
    if scope.find(node.trap) is None and scope.look.first("routine", node.trap):
        severity = scope.look.task.unsure
        yield scope.look.finding(rules.UNKNOWN_ROUTINE, node, name=node.trap, severity=severity)


def _routine_call(
    node: s.ProcedureCall | s.FunctionCall, name: str, kind: str, scope: Scope
) -> Found:
    found = scope.find(name)
    if found is None:
        routine = signature(name)
        if routine is None:
            yield from _unknown_routine(node, name, kind, scope)
            return
    elif scope.doubtful(found):
        return
    elif found.kind in ROUTINE_KINDS and isinstance(found.node, s.Routine):
        routine = signature_of(found.node)
    else:
        what = STORAGE_TEXTS.get(found.kind, f"a {found.kind}")
        yield scope.look.finding(rules.NOT_A_ROUTINE, node, name=name, what=what)
        return
    if routine.kind != kind:
        rule = rules.FUNCTION_ALONE if kind == "PROC" else rules.NO_FUNCTION
        yield scope.look.finding(rule, node, name=routine.name)
        return
    call = call_of(node, routine)
    yield from argument_misfits(node, call, scope)
    for value, parameters in call.bound():
        yield from _argument_value(value, parameters, routine, scope)


def _unknown_routine(
    node: s.ProcedureCall | s.FunctionCall, name: str, kind: str, scope: Scope
) -> Found:
    if not scope.look.first("routine", name):
        return
    own = [one.name for one in scope.look.task.shared if one.kind == kind]
    # An option may have routines that are not listed: none of those is taken for a slip.
    rows = signatures.rows().items()
    standard = [n for n, (line, option) in rows if line.startswith(kind) and not option]
    near = misspelt(name, [*own, *standard], TYPE_ENDING)
    meant = _routine_signature(near, scope) if near else None
    if meant is not None and _fits_routine(node, meant, scope):
        yield scope.look.finding(rules.MISSPELT_ROUTINE, node, name=name, near=meant.name)
    else:
        severity = scope.look.task.unsure
        yield scope.look.finding(rules.UNKNOWN_ROUTINE, node, name=name, severity=severity)


def _routine_signature(name: str, scope: Scope) -> Signature | None:
    found = scope.find(name)
    if found is None:
        return signature(name)
    return signature_of(found.node) if isinstance(found.node, s.Routine) else None


def _fits_routine(node: s.ProcedureCall | s.FunctionCall, routine: Signature, scope: Scope) -> bool:
    """Whether the arguments of a call fit another routine: else that one is hardly meant."""
    call = call_of(node, routine)
    return not any(argument_misfits(node, call, scope)) and all(
        scope.suiting(value, parameters) for value, parameters in call.bound()
    )


def _argument_value(
    value: s.Expression, parameters: Sequence[Parameter], routine: Signature, scope: Scope
) -> Found:
    if isinstance(value, s.Placeholder) or any(one.mode == "REF" for one in parameters):
        return
    if isinstance(value, s.NameRef) and scope.find(value.name) is None:
        type = parameters[0].type
        if type in PREDEFINED_SETTINGS and nearest_predefined(
            value.name, PREDEFINED_SETTINGS[type][0]
        ):
            if routine.name.lower() not in MOVE_WORDS:  # else the rule of moves has said it
                yield from unknown_setting(scope.look, value, value.name, type)
        elif all(_is_data(one, scope) for one in parameters):
            yield from names_used.unknown_data(value, scope)
    if isinstance(value, s.AggregateNode) and not any(one.mode for one in parameters):
        base = scope.types.base(parameters[0].type)
        if len(parameters) == 1 and base and not parameters[0].dimensions:
            yield from unfit_value(value, base, (), scope)
        return
    fit = scope.suiting(value, parameters)
    if not fit:
        yield scope.look.finding(
            rules.WRONG_ARGUMENT,
            value,
            routine=routine.name,
            parameter=parameters[0].name,
            given=scope.kind(value),
            wanted=" or ".join(str(scope.wanted(one)) for one in parameters),
        )
    elif all(one.mode for one in fit):
        yield from _changed_argument(value, fit[0], routine, scope)


def _is_data(parameter: Parameter, scope: Scope) -> bool:
    """Whether a name that stands for a parameter is data for sure, not a signal or a unit."""
    base = scope.types.base(parameter.type) or ""
    return not scope.types.device(base) and (
        bool(parameter.mode) or base not in _SIGNAL_VALUE_TYPES
    )


def _changed_argument(
    value: s.Expression, parameter: Parameter, routine: Signature, scope: Scope
) -> Found:
    """What is handed over to be changed must be data that can be."""
    data = root(value)
    storage = _storage_of(data, scope) if data is not None else "value"
    moved = routine.name.lower() in MOVE_WORDS and parameter.type in ("tooldata", "wobjdata")
    if parameter.mode == "PERS" and storage in ("VAR", "CONST", "IN", "FOR"):
        rule = None if moved and storage in ("VAR", "CONST") else rules.NO_PERSISTENT
    elif parameter.mode == "VAR" and storage == "PERS":
        rule = rules.NO_VARIABLE
    else:
        rule = rules.NO_REFERENCE if storage in ("value", "CONST", "FOR") else None
    if rule is not None:
        what = (
            f"`{data.name}`, which is {STORAGE_TEXTS[storage]}" if data is not None else VALUE_TEXT
        )
        words: dict[str, Any] = {"parameter": parameter.name, "mode": parameter.mode, "what": what}
        yield scope.look.finding(rule, value, routine=routine.name, **words)


VALUE_TEXT: Final = "a value that is calculated or written out"
STORAGE_TEXTS: Final = {
    "VAR": "a VAR",
    "CONST": "a CONST",
    "PERS": "a PERS",
    "IN": "a parameter that holds a copy",
    "INOUT": "a parameter",
    "FOR": "the variable of a loop",
}


def _storage_of(data: s.NameRef, scope: Scope) -> str:
    found = scope.find(data.name)
    if found is not None:
        return "" if scope.doubtful(found) else found.kind
    standard = predefined.data().get(data.name.lower())
    return standard.storage if standard else ""
