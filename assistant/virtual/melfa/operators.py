"""Operators of MELFA-BASIC between values (CR1D 4-150 and 4-151)."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, Final

from assistant.virtual.melfa import poses
from assistant.virtual.melfa.options import Options
from assistant.virtual.melfa.stops import Failed, Unknown, open_point
from assistant.virtual.melfa.values import (
    Bare,
    Joints,
    Position,
    Value,
    joints,
    number,
    position,
    text,
    whole,
)

if TYPE_CHECKING:
    from assistant.virtual.melfa.machine import Machine


def unary(sign: str, operand: Value) -> Value:
    if sign == "NOT":
        return not operand if isinstance(operand, bool) else ~whole(operand, "what NOT turns")
    if isinstance(operand, Position):
        return operand if sign == "+" else poses.scaled(operand, -1.0)
    if isinstance(operand, Joints):
        return operand if sign == "+" else poses.scaled(operand, -1.0)
    given = number(operand, "what has a sign")
    return given if sign == "+" else -given


def binary(m: Machine, sign: str, left: Value, right: Value) -> Value:
    """Two values and an operator between them."""
    sign = SPELLINGS.get(sign, sign)
    if isinstance(left, Position | Joints | Bare) or isinstance(right, Position | Joints | Bare):
        return _of_positions(m, sign, left, right)
    if isinstance(left, str) or isinstance(right, str):
        return _of_texts(m, sign, left, right)
    if sign in RELATIONS:
        return _truth(m, RELATIONS[sign](number(left), number(right)))
    if sign in BITWISE:
        if isinstance(left, bool) and isinstance(right, bool):
            return bool(BITWISE[sign](left, right))
        return BITWISE[sign](whole(left, "an operand"), whole(right, "an operand"))
    if sign in ARITHMETIC:
        return _in_range(ARITHMETIC[sign](number(left), number(right)))
    if sign in OPTION_OPERATORS:
        return _in_range(OPTION_OPERATORS[sign](m.world.options, number(left), number(right)))
    raise Failed(4220, f"the operator {sign}")


def _truth(m: Machine, met: bool) -> Value:
    """What a comparison gives: 1 is a truth that `Not` turns as a whole, -1 has all bits on."""
    return met if m.world.options.truth == 1 else -int(met)


def _divided(left: float, right: float) -> float:
    if right == 0:
        raise Unknown("a division by 0")
    return left / right


EXACT_INTEGERS: Final = 1 << 53
"""Whole numbers below it are exact in double precision."""


def _in_range(made: int | float) -> int | float:
    """A result in double precision; raises Unknown where that has no number for it."""
    if isinstance(made, int):
        return made if abs(made) < EXACT_INTEGERS else float(made)
    if not math.isfinite(made):
        raise Unknown("a number that is not finite")
    return made


def _power(options: Options, left: float, right: float) -> int | float:
    if options.power == "rounded":
        left, right = whole(left), whole(right)
    made: float | complex
    try:
        made = float(left) ** float(right)
    except (OverflowError, ZeroDivisionError):
        raise Unknown(f"{left} to the power of {right}") from None
    if isinstance(made, complex):
        raise Unknown("the power of a negative number to one that is not whole")
    return int(made) if made.is_integer() and abs(made) < EXACT_INTEGERS else made


def _quotient(options: Options, left: float, right: float) -> int:
    r"""`\\`: operands are rounded; which way a negative quotient goes is an option."""
    a, b = whole(left), whole(right)
    if b == 0:
        raise Unknown("a division by 0")
    if a % b and (a < 0) != (b < 0):
        if options.quotients is None:
            raise open_point(
                "a whole quotient that is negative and leaves a remainder", "quotients"
            )
        if options.quotients == "floor":
            return a // b
    return abs(a) // abs(b) * (1 if (a < 0) == (b < 0) else -1)


def _remainder(options: Options, left: float, right: float) -> int:
    """`Mod`: operands are rounded; it is what the whole quotient leaves."""
    a, b = whole(left), whole(right)
    if b == 0:
        raise Unknown("a remainder of a division by 0")
    if a % b and (a < 0 or b < 0) and options.quotients is None:
        raise open_point("Mod of negative numbers", "quotients")
    return a - b * _quotient(options, a, b)


WIDEST_SHIFT: Final = 64


def _shifted(options: Options, left: float, right: float, sign: int) -> int:
    """Shifts are logical: what moves in is 0 (RT ToolBox list); beyond 15 bits by an option."""
    a, b = whole(left), whole(right)
    bits = options.bits
    if not 0 <= b < WIDEST_SHIFT:
        raise Unknown(f"a shift by {b} bits")
    if bits is None and (a < 0 or a << b >= 1 << 15):
        raise open_point("a shift beyond fifteen bits", "bits")
    if bits is None:
        return a << b if sign > 0 else a >> b
    made = a % (1 << bits) << b if sign > 0 else a % (1 << bits) >> b
    half = 1 << (bits - 1)
    return (made + half) % (2 * half) - half


SPELLINGS: Final = {"><": "<>", "=<": "<=", "=>": ">="}

RELATIONS: Final[Mapping[str, Callable[[Any, Any], bool]]] = {
    "=": operator.eq, "<>": operator.ne, "<": operator.lt, "<=": operator.le,
    ">": operator.gt, ">=": operator.ge,
}  # fmt: skip
BITWISE: Final[Mapping[str, Callable[[int, int], int]]] = {
    "AND": operator.and_, "OR": operator.or_, "XOR": operator.xor,
}  # fmt: skip
ARITHMETIC: Final[Mapping[str, Callable[[Any, Any], Any]]] = {
    "+": operator.add, "-": operator.sub, "*": operator.mul, "/": _divided,
}  # fmt: skip
OPTION_OPERATORS: Final[Mapping[str, Callable[[Options, Any, Any], int | float]]] = {
    "\\": _quotient,
    "MOD": _remainder,
    "^": _power,
    "<<": lambda options, a, b: _shifted(options, a, b, 1),
    ">>": lambda options, a, b: _shifted(options, a, b, -1),
}
"""Operators of which the manuals leave something open."""


def _of_texts(m: Machine, sign: str, left: Value, right: Value) -> Value:
    one, other = text(left, "an operand"), text(right, "an operand")
    if sign == "+":
        return one + other
    if sign in RELATIONS:
        return _truth(m, RELATIONS[sign](one, other))
    raise Failed(4390, f"the operator {sign} between texts")


def _of_positions(m: Machine, sign: str, left: Value, right: Value) -> Value:
    """Sums go element by element, a product is one position in the frame of the other."""
    robot = m.world.arm.robot
    if isinstance(left, Joints) or isinstance(right, Joints):
        if sign in ("*", "/") and isinstance(right, int | float):
            return poses.scaled(joints(left), _scale_factor(sign, right))
        if sign in ("+", "-"):
            return poses.elementwise(joints(left), joints(right), ARITHMETIC[sign])
        raise Failed(4390, f"the operator {sign} between joints")
    if sign in ("*", "/") and isinstance(right, int | float):
        return poses.scaled(position(left), _scale_factor(sign, right))
    if sign in ("+", "-"):
        if isinstance(left, Bare) and isinstance(right, Bare):
            raise Unknown("a sum of two constants without flags")
        return poses.elementwise(position(left), position(right), ARITHMETIC[sign])
    if sign == "*":
        return poses.composed(position(left), position(right), robot)
    if sign == "/":
        if m.world.options.over == "Inv(P2)*P1":
            return poses.divided_from_left(position(left), position(right), robot)
        return poses.divided(position(left), position(right), robot)
    raise Failed(4390, f"the operator {sign} between positions")


def _scale_factor(sign: str, given: float) -> float:
    return float(given) if sign == "*" else _divided(1.0, given)
