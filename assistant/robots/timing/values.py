"""Numbers and conditions of a program, as far as its text and the way up to here tell."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Final

from assistant.program.expressions import Binary, Expression, Truth, Unary
from assistant.robots.naming import Names

COMPARISONS: Final[dict[str, Callable[[float, float], bool]]] = {
    "=": lambda a, b: a == b,
    "<>": lambda a, b: a != b,
    "<": lambda a, b: a < b,
    "<=": lambda a, b: a <= b,
    ">": lambda a, b: a > b,
    ">=": lambda a, b: a >= b,
}


def truth(names: Names, expression: Expression) -> bool | None:
    """Whether a condition holds; None if only running the program tells."""
    match expression:
        case Truth(value=value):
            return value
        case Unary(operator="not", operand=operand):
            inner = truth(names, operand)
            return None if inner is None else not inner
        case Binary(operator="and" | "or" as operator, left=left, right=right):
            sides = {truth(names, left), truth(names, right)}
            deciding = operator == "or"
            if deciding in sides:
                return deciding
            return None if None in sides else not deciding
        case Binary(operator=operator, left=left, right=right) if operator in COMPARISONS:
            a, b = names.number(left), names.number(right)
            return None if a is None or b is None else COMPARISONS[operator](a, b)
        case _ if (constant := _constant(names, expression)) is not None:
            return truth(names, constant)
    return None


def _constant(names: Names, expression: Expression) -> Expression | None:
    name = getattr(expression, "name", None)
    value = names.constant(name.lower()) if isinstance(name, str) else None
    return value if isinstance(value, Truth) else None


def rounds(first: float, last: float, step: float | None) -> int:
    """How often a loop from first to last goes round; see `For`."""
    by = step if step is not None else (1.0 if last >= first else -1.0)
    if by == 0.0 or not math.isfinite(first + last + by):
        return 0
    return max(0, math.floor((last - first) / by + 1e-9) + 1)
