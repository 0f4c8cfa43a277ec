"""What the operators of RAPID do with values."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Mapping
from typing import Any, Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats
from assistant.virtual.rapid.ends import UNSURE, Fault
from assistant.virtual.rapid.poses import orient, pos, quaternion_of, truth, vector_of
from assistant.virtual.rapid.precision import LARGEST, paired, single
from assistant.virtual.rapid.values import Record, Value, equal, kind_of

LONGEST_TEXT: Final = 80


def infix(sign: str, left: Value, right: Value) -> Value:
    """The value of two operands; raises Fault where a controller stops or refuses them."""
    if isinstance(left, float) and isinstance(right, float) and sign in NUMBER_OPERATORS:
        one, two, kind = paired(left, right)
        found = NUMBER_OPERATORS[sign](one, two)
        if found is True or found is False:
            return found
        if -LARGEST <= found <= LARGEST:
            return single(found) if kind is float else kind(found)
        return kind(_finite(found, kind))
    if sign in TRUTH_OPERATORS:
        return TRUTH_OPERATORS[sign](truth(left), truth(right))
    if sign in ("=", "<>"):
        try:
            return equal(left, right) is (sign == "=")
        except ValueError as error:
            raise Fault(str(error)) from None
    if sign == "+" and isinstance(left, str) and isinstance(right, str):
        return joined(left + right)
    vector = _vector_result(sign, left, right)
    if vector is None:
        raise Fault(f"`{sign}` cannot join {kind_of(left)} and {kind_of(right)}")
    return vector


def prefix(sign: str, value: Value) -> Value:
    if sign == "NOT":
        return not truth(value)
    factor = -1.0 if sign == "-" else 1.0
    if isinstance(value, float):
        return type(value)(factor * value)
    if isinstance(value, Record) and value.type == "pos":
        x, y, z = vector_of(value)
        return pos((factor * x, factor * y, factor * z))
    raise Fault(f"`{sign}` cannot stand before {kind_of(value)}")


def joined(text: str) -> str:
    """A text that was put together; raises Fault where it is too long for a string."""
    if len(text) > LONGEST_TEXT:
        raise Fault(f"a string of {len(text)} characters", "ERR_STRTOOLNG")
    return text


def whole(value: float, what: str) -> int:
    if not value.is_integer():
        raise Fault(f"{what} is {value:g}, no whole number", UNSURE)
    return int(value)


def _divide(left: float, right: float) -> float:
    if right == 0.0:
        raise Fault("division by zero", "ERR_DIVZERO")
    return left / right


def _quotient(left: float, right: float) -> float:
    """-14 DIV 4 is -3: towards zero, as the table of operations of the kernel manual has it."""
    a, b = whole(left, "an operand of DIV"), whole(right, "an operand of DIV")
    return float(math.trunc(_divide(a, b)))


def _remainder(left: float, right: float) -> float:
    """-14 MOD 4 is -2: with the sign of what is divided."""
    a, b = whole(left, "an operand of MOD"), whole(right, "an operand of MOD")
    if b == 0:
        raise Fault("division by zero", "ERR_DIVZERO")
    return math.fmod(a, b) + 0.0


def _vector_result(sign: str, left: Value, right: Value) -> Value | None:
    """Operators of pos and orient; None for what there is not."""
    if _is_record(left, "pos") and _is_record(right, "pos") and sign in ("+", "-", "*"):
        return _pos_result(VECTOR_OPERATORS[sign](vector_of(left), vector_of(right)))
    if _is_record(left, "pos") and _are_numbers(right) and sign in ("*", "/"):
        factor = _float(right) if sign == "*" else _divide(1.0, _float(right))
        return _pos_result(np.multiply(vector_of(left), factor))
    if _are_numbers(left) and _is_record(right, "pos") and sign == "*":
        return _pos_result(np.multiply(vector_of(right), _float(left)))
    if _is_record(left, "orient") and _is_record(right, "orient") and sign == "*":
        q = rotations.canonical(rotations.multiply(quaternion_of(left), quaternion_of(right)))
        w, x, y, z = (float(part) for part in q)
        return orient((w, x, y, z))
    return None


def _pos_result(values: Floats) -> Record:
    x, y, z = (float(part) for part in values)
    return pos((x, y, z))


def _is_record(value: Value, type: str) -> bool:
    return isinstance(value, Record) and value.type == type


def _are_numbers(*values: Value) -> bool:
    return all(isinstance(value, float) for value in values)


def _float(value: Value) -> float:
    assert isinstance(value, float)
    return value


def _finite(value: float, kind: type[float]) -> float:
    if math.isnan(value) or (kind is float and abs(value) > LARGEST and not math.isinf(value)):
        raise Fault(f"the number {value:g}, which is too large", "ERR_NUM_LIMIT")
    return value


TRUTH_OPERATORS: Final[Mapping[str, Callable[[bool, bool], bool]]] = {
    "AND": operator.and_,
    "OR": operator.or_,
    "XOR": operator.xor,
}
"""Both sides are worked out: that the second may be left out is not documented."""
NUMBER_OPERATORS: Final[Mapping[str, Callable[[float, float], Any]]] = {
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
    "/": _divide,
    "DIV": _quotient,
    "MOD": _remainder,
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
    "=": operator.eq,
    "<>": operator.ne,
}
"""Of two numbers, a number or a truth."""
VECTOR_OPERATORS: Final[Mapping[str, Callable[..., Floats]]] = {
    "+": np.add,
    "-": np.subtract,
    "*": np.cross,
}
