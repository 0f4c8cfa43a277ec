"""Rules of names that are used: data, types and components that nothing declares."""

from __future__ import annotations

from collections.abc import Iterable

from assistant.languages.checks.registry import Found
from assistant.languages.checks.slips import misspelt
from assistant.languages.rapid.checks import use_rules as rules
from assistant.languages.rapid.checks.kinds import Scope
from assistant.languages.rapid.tables import predefined
from assistant.languages.rapid.tables.words import TYPE_ENDING
from assistant.languages.rapid.tree import syntax as s


def component(node: s.Component, scope: Scope) -> Found:
    yield from data(node.value, scope)
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


def element(node: s.Element, scope: Scope) -> Found:
    yield from data(node.value, scope)
    kind = scope.kind(node.value)
    if kind is not None and kind.dimensions not in (-1, len(node.indices)):
        yield scope.look.finding(
            rules.INDEX_COUNT, node, count=kind.dimensions, given=len(node.indices)
        )


def assigned(node: s.Assignment, scope: Scope) -> Found:
    yield from data(node.target, scope)


def data(node: s.Expression, scope: Scope) -> Found:
    """A name that can be no signal and that no given module declares, at its first use."""
    if not isinstance(node, s.NameRef) or scope.find(node.name) is not None:
        return
    low = node.name.lower()
    if low in predefined.data() or low.startswith("err_") or scope.look.compiled:
        return
    if scope.look.first("data", low):
        yield scope.look.finding(rules.UNKNOWN_DATA, node, name=node.name)


def type_of(node: s.Data | s.ParameterNode | s.Routine, scope: Scope) -> Found:
    yield from _types((node.type,) if node.type else (), node, scope)


def types_of(node: s.Record, scope: Scope) -> Found:
    yield from _types((type for type, _ in node.components), node, scope)


def _types(names: Iterable[str], node: s.Node, scope: Scope) -> Found:
    for name in names:
        if scope.types.base(name) is not None or not scope.look.first("type", name):
            continue
        near = misspelt(name, scope.types.known(), TYPE_ENDING)
        if near:
            yield scope.look.finding(rules.MISSPELT_TYPE, node, name=name, near=near)
        else:
            unsure = scope.look.task.unsure
            yield scope.look.finding(rules.UNKNOWN_TYPE, node, name=name, severity=unsure)
