"""Rules of names that are used: data, types and components that nothing declares."""

from __future__ import annotations

from collections.abc import Iterable

from assistant.base.diagnostics import Severity
from assistant.languages.checks.names import misspelt
from assistant.languages.checks.registry import Found
from assistant.languages.rapid.checks import use_rules as rules
from assistant.languages.rapid.checks.kinds import Scope
from assistant.languages.rapid.checks.module_view import VALUELESS
from assistant.languages.rapid.tables import predefined
from assistant.languages.rapid.tables.words import TYPE_ENDING
from assistant.languages.rapid.tree import syntax as s


def unknown_component(node: s.Component, scope: Scope) -> Found:
    yield from unknown_data(node.value, scope)
    kind = scope.kind(node.value)
    if kind is None or kind.dimensions:
        return
    components = scope.types.components(kind.type)
    if components is None and not scope.types.atomic(kind.type):
        return
    names = list(components or ())
    if node.name.lower() not in {name.lower() for name in names}:
        hint = f"it has {', '.join(names)}" if names else "use the value itself"
        yield scope.look.finding(
            rules.UNKNOWN_COMPONENT, node, type=kind.type, name=node.name, hint=hint
        )


def index_count(node: s.Element, scope: Scope) -> Found:
    yield from unknown_data(node.value, scope)
    kind = scope.kind(node.value)
    if kind is not None and kind.dimensions not in (-1, len(node.indices)):
        yield scope.look.finding(
            rules.INDEX_COUNT, node, count=kind.dimensions, given=len(node.indices)
        )


def assigned_data(node: s.Assignment, scope: Scope) -> Found:
    yield from unknown_data(node.target, scope)


def unknown_data(node: s.Expression, scope: Scope) -> Found:
    """A name that can be no signal and that no given module declares, at its first use."""
    if not isinstance(node, s.NameRef) or scope.find(node.name) is not None:
        return
    low = node.name.lower()
    if low in predefined.data() or scope.look.compiled:
        return
    if scope.look.first("data", low):
        yield scope.look.finding(rules.UNKNOWN_DATA, node, name=node.name)


def name_without_value(node: s.NameRef, scope: Scope) -> Found:
    """The name of a routine, of a type or of a module, where data should stand."""
    found = scope.find(node.name)
    if found is not None:
        if found.kind in VALUELESS and not scope.doubtful(found):
            yield scope.look.finding(
                rules.NAME_WITHOUT_VALUE, node, name=node.name, what=VALUELESS[found.kind]
            )
    elif node.name.lower() not in predefined.data():  # of a module, or a signal that is called so
        yield scope.look.finding(
            rules.NAME_WITHOUT_VALUE,
            node,
            name=node.name,
            what="a module",
            severity=Severity.WARNING,
        )


def unknown_errors(
    node: s.RaiseError | s.Handler | s.Infix | s.TestOf | s.Assignment, scope: Scope
) -> Found:
    """Names of errors: those that are raised, handled, assigned, or compared with a number."""
    named: tuple[s.Expression | None, ...] = ()
    sure = False
    match node:
        case s.RaiseError(value):
            named, sure = (value,), True
        case s.Handler(numbers=numbers):
            named, sure = numbers, True
        case s.Infix(_, left, right):
            named, sure = (left, right), _is_errnum(left, scope) or _is_errnum(right, scope)
        case s.TestOf(subject, cases):
            named = tuple(value for case in cases for value in case.values)
            sure = _is_errnum(subject, scope)
        case s.Assignment(target, value):
            named, sure = (value,), _is_errnum(target, scope)
    for one in named:
        if isinstance(one, s.NameRef) and (sure or one.name.startswith("ERR_")):
            yield from unknown_data(one, scope)


def _is_errnum(value: s.Expression, scope: Scope) -> bool:
    """True for the number of an error; other numbers may be those of signals."""
    if not isinstance(value, s.NameRef):
        return False
    found, standard = scope.find(value.name), predefined.data().get(value.name.lower())
    type = found.type if found is not None else standard.type if standard is not None else ""
    return type.lower() == "errnum"


def unknown_type(node: s.Data | s.ParameterNode | s.Routine, scope: Scope) -> Found:
    yield from _unknown_types((node.type,) if node.type else (), node, scope)


def unknown_component_types(node: s.Record, scope: Scope) -> Found:
    yield from _unknown_types((type for type, _ in node.components), node, scope)


def _unknown_types(names: Iterable[str], node: s.Node, scope: Scope) -> Found:
    for name in names:
        if scope.types.base(name) is not None or not scope.look.first("type", name):
            continue
        near = misspelt(name, scope.types.known(), TYPE_ENDING)
        if near:
            yield scope.look.finding(rules.MISSPELT_TYPE, node, name=name, near=near)
        else:
            unsure = scope.look.task.unsure
            yield scope.look.finding(rules.UNKNOWN_TYPE, node, name=name, severity=unsure)
