"""Rules of values: aggregates, initial values, assignments, operands, conditions."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Final

from assistant.base.diagnostics import Rule
from assistant.languages.checks.registry import Found
from assistant.languages.checks.values import Kind, Sizes, Unfit
from assistant.languages.rapid.checks import use_rules as rules
from assistant.languages.rapid.checks.kinds import LOGICAL, OPERATORS, SIGNAL_TYPES, Scope
from assistant.languages.rapid.tables import predefined
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.gather import literal_number

UNFIT_RULES: Final[Mapping[Unfit, Rule]] = {
    Unfit.TYPE: rules.WRONG_VALUE,
    Unfit.ELEMENTS: rules.ELEMENT_COUNT,
    Unfit.COMPONENTS: rules.COMPONENT_COUNT,
}
CONDITION_TYPES: Final = SIGNAL_TYPES | {"bool"}
"""Types of conditions."""


def initial_value(node: s.Data, scope: Scope) -> Found:
    kind = scope.of(node.type)
    if node.value is not None and kind is not None and not predefined.is_handle(kind.type):
        sizes = tuple(_known_extent(size, scope) for size in node.dimensions)
        yield from unfit_value(node.value, kind.type, sizes, scope)


def assigned_value(node: s.Assignment, scope: Scope) -> Found:
    yield from _value_of_kind(node.value, scope.kind(node.target), scope)


def returned_value(node: s.ReturnFrom, scope: Scope) -> Found:
    routine = scope.routine
    if routine is not None and routine.kind == "FUNC" and node.value is not None:
        yield from _value_of_kind(node.value, scope.of(routine.type), scope)


def _value_of_kind(value: s.Expression, kind: Kind | None, scope: Scope) -> Found:
    if kind is not None and kind.dimensions >= 0:
        yield from unfit_value(value, kind.type, (None,) * kind.dimensions, scope)


def unfit_value(value: s.Expression, type: str, sizes: Sizes, scope: Scope) -> Found:
    """What is wrong with a value where one of a type, or an array of it, is wanted."""
    for what, part, fields in scope.unfit(value, type, sizes):
        yield scope.look.finding(UNFIT_RULES[what], part, **fields)


def _known_extent(size: s.Expression, scope: Scope) -> int | None:
    """A dimension that is a literal or a declared constant, None for any other."""
    if isinstance(size, s.NameRef):
        found = scope.find(size.name)
        if found is None or found.kind != "CONST" or scope.doubtful(found):
            return None
        value = found.node.value if isinstance(found.node, s.Data) else None
        return (
            None if value is None or isinstance(value, s.NameRef) else _known_extent(value, scope)
        )
    number = literal_number(size)
    return None if number is None or not math.isfinite(number) else int(number)


def index_range(node: s.Element, scope: Scope) -> Found:
    """Indices that are known and no element has."""
    kind = scope.kind(node.value)
    if not isinstance(node.value, s.NameRef) or kind is None:
        return
    if kind.dimensions != len(node.indices):
        return
    name = node.value.name
    found = scope.find(name)
    array = found.node if found is not None else None
    declared = array.dimensions if isinstance(array, s.Data) else (None,) * kind.dimensions
    for index, dimension in zip(node.indices, declared, strict=True):
        at = None if isinstance(index, s.Whole) else _known_extent(index, scope)
        most = None if dimension is None else _known_extent(dimension, scope)
        if at is not None and (at < 1 or (most is not None and at > most)):
            to = "" if most is None else f" to {most}"
            yield scope.look.finding(rules.INDEX_RANGE, node, index=at, name=name, to=to)


def condition_type(node: s.IfBranch | s.CompactIf | s.WhileLoop, scope: Scope) -> Found:
    if node.condition is not None:
        yield from _truth_value(node.condition, scope)


def _truth_value(value: s.Expression, scope: Scope) -> Found:
    kind = scope.kind(value)
    if kind is not None and kind.type not in CONDITION_TYPES:
        yield scope.look.finding(rules.NO_TRUTH, value, given=kind)


def negated_operand(node: s.Prefix, scope: Scope) -> Found:
    if node.operator == "NOT":
        yield from _truth_value(node.operand, scope)


def operand_types(node: s.Infix, scope: Scope) -> Found:
    if node.operator in LOGICAL:
        yield from _truth_value(node.left, scope)
        yield from _truth_value(node.right, scope)
        return
    one, other = scope.read(node.left), scope.read(node.right)
    if one is not None and other is not None and not OPERATORS.join(node.operator, one, other):
        cure = "turn the other into text with `ValToStr` or `NumToStr`"
        text = node.operator == "+" and "string" in (one.type, other.type)
        yield scope.look.finding(
            rules.OPERANDS,
            node,
            operator=node.operator,
            left=one,
            right=other,
            hint=cure if text else "bring both to one type",
        )


def case_types(node: s.TestOf, scope: Scope) -> Found:
    subject = scope.read(node.subject)
    for value in (value for case in node.cases for value in case.values):
        given = scope.read(value)
        if subject is not None and not OPERATORS.fits(given, subject, read=False):
            yield scope.look.finding(rules.WRONG_VALUE, value, given=given, wanted=subject)
