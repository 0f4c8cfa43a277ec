"""Expressions of MELFA-BASIC and what they come to (CR1D 4-151, COSIROP help)."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, Final

from assistant.languages.melfa_basic.tables import vocabulary
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.virtual.melfa import functions, pallets, poses, status
from assistant.virtual.melfa.code import constant
from assistant.virtual.melfa.memory import Index, Place, is_external
from assistant.virtual.melfa.stops import Failed, Unknown
from assistant.virtual.melfa.values import (
    Bare,
    Joints,
    Position,
    Value,
    component,
    joints,
    number,
    position,
    text,
    whole,
)

if TYPE_CHECKING:
    from assistant.virtual.melfa.machine import Machine


def value(m: Machine, node: s.Expression | None) -> Value:
    """What an expression comes to; raises Failed or Unknown."""
    match node:
        case s.Number(value=given):
            return given
        case s.String(value=written):
            return written
        case s.Constant():
            made = constant(node)
            if made is None:
                raise Failed(2800, "a position constant without a value")
            return made
        case s.Variable():
            return variable(m, node)
        case s.Unary(operator=sign, operand=operand):
            return _unary(sign.upper(), value(m, operand))
        case s.Binary(operator=sign, left=left, right=right):
            return binary(m, sign.upper(), value(m, left), value(m, right))
        case s.Pallet(number=number_, point=point):
            which, at = whole(value(m, number_), "the pallet"), whole(value(m, point), "the point")
            return pallets.point(m.pallets.get(which), which, at)
    raise Failed(4220, "an expression that is none")


def values(m: Machine, nodes: tuple[s.Expression | None, ...]) -> tuple[Value | None, ...]:
    """What arguments come to, None for those that are left out."""
    return tuple(None if node is None else value(m, node) for node in nodes)


def integer(m: Machine, node: s.Expression | None, what: str = "the value") -> int:
    return whole(value(m, node), what)


def plain(m: Machine, node: s.Expression | None, what: str = "the value") -> int | float:
    return number(value(m, node), what)


# --------------------------------------------------------------------------------- variables


def variable(m: Machine, node: s.Variable) -> Value:
    """A variable, an element, a status variable, or what a function gives."""
    found = _whole_value(m, node)
    return component(found, node.component) if node.component else found


def _whole_value(m: Machine, node: s.Variable) -> Value:
    key = node.key
    if m.is_result(node):
        return m.result()
    if not m.is_own(key):
        if key in m.world.commands:
            return plugged(m, node)
        if key in m.code.functions:
            return m.called(node)
        if key in m.code.definitions:
            return m.defined(node)
        if key in m.code.signals:
            return io_value(m, m.code.signals[key])
        if node.arguments is not None and vocabulary.function(key) is not None:
            return _applied(m, node, node.arguments)
        if is_status(key):
            index = tuple(value(m, a) for a in node.arguments or ())
            return status.read(m.world, key, index)
    place, index = reference(m, node)
    return place.get(index)


def plugged(m: Machine, node: s.Variable) -> Value:
    """What a plug-in gives for a function or a status variable."""
    found = m.world.given(node.key, values(m, node.arguments or ()))
    if found is None:
        raise Unknown(f"the plug-in {node.name} gives no value")
    return found


def bare(node: s.Expression | None) -> str:
    """The word that an argument is, capitalised; empty where it is none."""
    if isinstance(node, s.Word):
        return node.text.capitalize()
    if isinstance(node, s.Variable) and node.arguments is None and not node.component:
        return node.marked.capitalize()
    return ""


def _applied(m: Machine, node: s.Variable, arguments: tuple[s.Expression | None, ...]) -> Value:
    """What a function of the language gives."""
    known, count = vocabulary.function(node.key), len(arguments)
    if known and not known.least <= count <= (count if known.most is None else known.most):
        raise Failed(3120, f"{node.name} with {count} arguments")
    given = values(m, arguments)
    return functions.call(node.key.removesuffix("$"), given, m.world.arm.robot)


def is_status(key: str) -> bool:
    """Whether a name is the controller's own, and none of its numbered ones, `M_00` or `P_100`."""
    return vocabulary.status(key) is not None and not (is_external(key) and key[2:].isdigit())


def reference(m: Machine, node: s.Variable) -> tuple[Place, Index]:
    """The cell that a variable is, and the element of it."""
    if node.arguments is None:
        return m.memory_of(node.key).place(node.key), ()
    index = tuple(integer(m, a, f"a subscript of {node.name}") for a in node.arguments)
    return m.memory_of(node.key).place(node.key), index


def io_value(m: Machine, definition: s.DefIo) -> int:
    """The inputs that `Def Io` gave a name."""
    first, width, mask = io_of(m, definition)
    return m.world.read(output=False, first=first, width=width) & mask


def io_of(m: Machine, definition: s.DefIo) -> tuple[int, int, int]:
    """First number, bits and mask of a name that `Def Io` gives."""
    width = status.IO_WIDTHS.get(definition.type.upper())
    if width is None:
        raise Failed(4220, f"a signal of type {definition.type}")
    mask = -1 if definition.mask is None else integer(m, definition.mask, "the mask")
    return integer(m, definition.number, "the signal"), width, mask


# --------------------------------------------------------------------------------- operators


def _unary(sign: str, operand: Value) -> Value:
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
    sign = SPELLED.get(sign, sign)
    if isinstance(left, Position | Joints | Bare) or isinstance(right, Position | Joints | Bare):
        return _of_positions(m, sign, left, right)
    if isinstance(left, str) or isinstance(right, str):
        return _of_texts(sign, left, right)
    if sign in RELATIONS:
        result: Value = RELATIONS[sign](number(left), number(right))
        return result
    if sign in BITWISE:
        if isinstance(left, bool) and isinstance(right, bool):
            return bool(BITWISE[sign](left, right))
        return BITWISE[sign](whole(left, "an operand"), whole(right, "an operand"))
    if sign in ARITHMETIC:
        return _kept(ARITHMETIC[sign](number(left), number(right)))
    raise Failed(4220, f"the operator {sign}")


def _divided(left: float, right: float) -> float:
    if right == 0:
        raise Unknown("a division by 0")
    return left / right


EXACT: Final = 1 << 53
"""Whole numbers below it are exact in double precision."""


def _kept(made: int | float) -> int | float:
    """A result in double precision; raises Unknown where that has no number for it."""
    if isinstance(made, int):
        return made if abs(made) < EXACT else float(made)
    if not math.isfinite(made):
        raise Unknown("a number that is not finite")
    return made


def _power(left: float, right: float) -> int | float:
    made: float | complex
    try:
        made = float(left) ** float(right)
    except (OverflowError, ZeroDivisionError):
        raise Unknown(f"{left} to the power of {right}") from None
    if isinstance(made, complex):
        raise Unknown("the power of a negative number to one that is not whole")
    return int(made) if made.is_integer() and abs(made) < EXACT else made


def _quotient(left: float, right: float) -> int:
    r"""`\`: operands are rounded; which way a negative quotient goes is not known."""
    a, b = whole(left), whole(right)
    if b == 0:
        raise Unknown("a division by 0")
    if a % b and (a < 0) != (b < 0):
        raise Unknown("a whole quotient that is negative and leaves a remainder")
    return abs(a) // abs(b) * (1 if (a < 0) == (b < 0) else -1)


def _remainder(left: float, right: float) -> int:
    """`Mod`: operands are rounded; of negative ones the sign is not known."""
    a, b = whole(left), whole(right)
    if b == 0:
        raise Unknown("a remainder of a division by 0")
    if a % b and (a < 0 or b < 0):
        raise Unknown("Mod of negative numbers")
    return abs(a) % abs(b)


def _shifted(left: float, right: float, sign: int) -> int:
    a, b = whole(left), whole(right)
    if a < 0 or b < 0 or a << b >= 1 << 15:
        raise Unknown("a shift beyond fifteen bits")
    return a << b if sign > 0 else a >> b


SPELLED: Final = {"><": "<>", "=<": "<=", "=>": ">="}

RELATIONS: Final[Mapping[str, Callable[[Any, Any], bool]]] = {
    "=": operator.eq, "<>": operator.ne, "<": operator.lt, "<=": operator.le,
    ">": operator.gt, ">=": operator.ge,
}  # fmt: skip
BITWISE: Final[Mapping[str, Callable[[int, int], int]]] = {
    "AND": operator.and_, "OR": operator.or_, "XOR": operator.xor,
}  # fmt: skip
ARITHMETIC: Final[Mapping[str, Callable[[Any, Any], Any]]] = {
    "+": operator.add, "-": operator.sub, "*": operator.mul, "/": _divided,
    "\\": _quotient, "MOD": _remainder, "^": _power,
    "<<": lambda a, b: _shifted(a, b, 1), ">>": lambda a, b: _shifted(a, b, -1),
}  # fmt: skip


def _of_texts(sign: str, left: Value, right: Value) -> Value:
    one, other = text(left, "an operand"), text(right, "an operand")
    if sign == "+":
        return one + other
    if sign in RELATIONS:
        return RELATIONS[sign](one, other)
    raise Failed(4390, f"the operator {sign} between texts")


def _of_positions(m: Machine, sign: str, left: Value, right: Value) -> Value:
    """Sums go element by element, a product is one position in the frame of the other."""
    robot = m.world.arm.robot
    if isinstance(left, Joints) or isinstance(right, Joints):
        if sign in ("*", "/") and isinstance(right, int | float):
            return poses.scaled(joints(left), _factor(sign, right))
        if sign in ("+", "-"):
            return poses.elementwise(joints(left), joints(right), ARITHMETIC[sign])
        raise Failed(4390, f"the operator {sign} between joints")
    if sign in ("*", "/") and isinstance(right, int | float):
        return poses.scaled(position(left), _factor(sign, right))
    if sign in ("+", "-"):
        if isinstance(left, Bare) and isinstance(right, Bare):
            raise Unknown("a sum of two constants without flags")
        return poses.elementwise(position(left), position(right), ARITHMETIC[sign])
    if sign == "*":
        return poses.composed(position(left), position(right), robot)
    if sign == "/":
        return poses.divided(position(left), position(right), robot)
    raise Failed(4390, f"the operator {sign} between positions")


def _factor(sign: str, given: float) -> float:
    return float(given) if sign == "*" else _divided(1.0, given)
