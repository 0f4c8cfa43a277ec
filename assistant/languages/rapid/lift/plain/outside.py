"""External axes that no target of a program states a place of: there are none in its cell.

Their components are 9E9 to RAPID, and what is assigned to them moves nothing.
"""

from __future__ import annotations

from collections.abc import Sequence, Set
from typing import Any, Final

from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.external_axes import AXES, COMPONENT, used_axes
from assistant.languages.rapid.tree.gather import literal_number

NO_AXIS: Final = s.NumberLiteral("9E9")
NO_AXIS_TEXT: Final = s.StringLiteral("9E+09")
"""The same as ValToStr writes it."""


def unused_axes(modules: Sequence[s.Module]) -> frozenset[str]:
    """Components of external axes that no target which is written out gives a place."""
    return frozenset(AXES) - used_axes(modules)


def is_unused_axis(node: Any, unused: frozenset[str]) -> bool:
    """Whether a component of a target is that of an external axis that there is none of."""
    match node:
        case s.Component(s.Component(_, part), axis):
            return part.lower() == COMPONENT and axis.lower() in unused
    return False


def only_computes(routine: s.Routine | None, divisors: Set[str]) -> bool:
    """Whether a function does nothing but work out a value, in which no error can arise.

    divisors: names in lower case of what is never 0.
    """
    match routine:
        case s.Routine(kind="FUNC", body=(s.ReturnFrom(value=value),), handlers=()):
            return value is not None and _never_fails(value, divisors)
    return False


def _never_fails(value: s.Expression, divisors: Set[str]) -> bool:
    match value:
        case s.Infix("/", left, s.NameRef(name)):
            return name.lower() in divisors and _never_fails(left, divisors)
        case s.Infix("/", left, right):
            return bool(literal_number(right)) and _never_fails(left, divisors)
        case s.Infix("+" | "-" | "*", left, right):
            return _never_fails(left, divisors) and _never_fails(right, divisors)
        case s.Prefix("+" | "-", operand):
            return _never_fails(operand, divisors)
    return isinstance(value, s.NumberLiteral | s.NameRef)
