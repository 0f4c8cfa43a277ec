"""Expressions in other words that say the same, for languages that lack the first ones."""

from __future__ import annotations

from typing import Any, Final

from assistant.program import expressions as e

OPPOSITE: Final[dict[str, Any]] = {
    "=": "<>", "<>": "=", "<": ">=", ">=": "<", ">": "<=", "<=": ">", "and": "or", "or": "and",
}  # fmt: skip


def without_truth_values(value: e.Expression) -> e.Expression:
    """An expression without truth values and `not`; signs of numbers are part of them.

    For a language whose truths are numbers, and whose `not` works on bits.
    """
    match value:
        case e.Truth(truth):
            return e.Number(int(truth))
        case e.Unary("-", e.Number(number)):
            return e.Number(-number)
        case e.Unary("not", operand):
            return opposite(operand)
    return value


def opposite(value: e.Expression) -> e.Expression:
    """What holds where the value does not."""
    match value:
        case e.Binary("and" | "or" as operator, left, right):
            return e.Binary(OPPOSITE[operator], opposite(left), opposite(right))
        case e.Binary(operator, left, right) if operator in OPPOSITE:
            return e.Binary(OPPOSITE[operator], left, right)
        case e.Number(number):
            return e.Number(int(number == 0))
    return e.Binary("=", value, e.Number(0))


def floor(x: e.Expression) -> e.Expression:
    """The whole number below: one less than the whole part where that is above.

    What is left of a number without its whole part is over -1 and under 1.
    """
    whole = e.Apply("trunc", (x,))
    rest = e.Binary("+", e.Binary("-", x, whole), e.Number(1))
    return e.Binary("-", e.Binary("+", whole, e.Apply("trunc", (rest,))), e.Number(1))


MOST_DECIMALS: Final = 15
"""A float has no more digits than these for sure."""


def fixed_text(value: e.Expression, places: float) -> e.Expression:
    """A number as text with so many decimals at most, and no more than a float has."""
    if places <= 0:
        return e.Apply("text", (e.Apply("round", (value,)),))
    power = e.Number(10 ** int(min(places, MOST_DECIMALS)))
    whole = e.Apply("round", (e.Binary("*", value, power),))
    return e.Apply("text", (e.Binary("/", whole, power),))


def two_at_a_time(x: e.Apply) -> e.Expression:
    """The smallest or largest of two at a time."""
    one, *others = x.arguments
    for other in others:
        one = e.Apply(x.function, (one, other))
    return one


def with_shift_parts(x: e.Apply, parts: int | None = None) -> e.Apply:
    """A moved target with so many parts of what it is moved by, or with none of 0 at the end."""
    given, none = x.arguments, e.Number(0)
    if parts is not None:
        return e.Apply(x.function, given + (none,) * (1 + parts - len(given)))
    while len(given) > 4 and given[-1] in (none, e.Number(0.0)):
        given = given[:-1]
    return e.Apply(x.function, given)
