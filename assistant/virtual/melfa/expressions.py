"""Expressions, operators and variables of MELFA-BASIC (CR1D 4-150 and 4-151, COSIROP help)."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Mapping
from functools import cache
from typing import TYPE_CHECKING, Any, Final

from assistant.languages.melfa_basic.tables import vocabulary
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.virtual.melfa import arm_state, functions, positions, status
from assistant.virtual.melfa.code import constant, nodes
from assistant.virtual.melfa.options import Options
from assistant.virtual.melfa.values import (
    Bare,
    Failed,
    Index,
    Joints,
    Position,
    Storage,
    Unknown,
    Value,
    component,
    fitted,
    is_external,
    joints,
    number,
    open_point,
    position,
    text,
    whole,
    with_component,
)

if TYPE_CHECKING:
    from assistant.virtual.melfa.machine import Machine


def unary(sign: str, operand: Value) -> Value:
    if sign == "NOT":
        # A truth turns as a whole, a number bit by bit.
        return not operand if isinstance(operand, bool) else ~whole(operand, "what NOT turns")
    if isinstance(operand, Position):
        return operand if sign == "+" else arm_state.scaled(operand, -1.0)
    if isinstance(operand, Joints):
        return operand if sign == "+" else arm_state.scaled(operand, -1.0)
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
    if sign in _BITWISE:
        if isinstance(left, bool) and isinstance(right, bool):
            return bool(_BITWISE[sign](left, right))
        return _BITWISE[sign](whole(left, "an operand"), whole(right, "an operand"))
    if sign in _ARITHMETIC:
        return _in_range(_ARITHMETIC[sign](number(left), number(right)))
    if sign in _OPTION_OPERATORS:
        return _in_range(_OPTION_OPERATORS[sign](m.world.options, number(left), number(right)))
    raise Failed(4220, f"the operator {sign}")


def _truth(m: Machine, met: bool) -> Value:
    """Return the value of a comparison: with 1, `Not` turns the truth as a whole; -1 has all bits
    on.
    """
    return met if m.world.options.truth == 1 else -int(met)


def _divided(left: float, right: float) -> float:
    if right == 0:
        raise Unknown("a division by 0")
    return left / right


_EXACT_INTEGERS: Final = 1 << 53
"""Whole numbers below it are exact in double precision."""


def _in_range(made: int | float) -> int | float:
    """A result in double precision; raises Unknown where that has no number for it."""
    if isinstance(made, int):
        # The controller has double precision, which larger whole numbers do not fit into.
        return made if abs(made) < _EXACT_INTEGERS else float(made)
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
    return int(made) if made.is_integer() and abs(made) < _EXACT_INTEGERS else made


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
    # Python rounds quotients down; this one goes to 0.
    return abs(a) // abs(b) * (1 if (a < 0) == (b < 0) else -1)


def _remainder(options: Options, left: float, right: float) -> int:
    """`Mod`: operands are rounded; it is what the whole quotient leaves."""
    a, b = whole(left), whole(right)
    if b == 0:
        raise Unknown("a remainder of a division by 0")
    if a % b and (a < 0 or b < 0) and options.quotients is None:
        raise open_point("Mod of negative numbers", "quotients")
    return a - b * _quotient(options, a, b)


_WIDEST_SHIFT: Final = 64


def _shifted(options: Options, left: float, right: float, sign: int) -> int:
    """Shifts are logical: what moves in is 0 (RT ToolBox list); beyond 15 bits by an option."""
    a, b = whole(left), whole(right)
    bits = options.bits
    if not 0 <= b < _WIDEST_SHIFT:
        raise Unknown(f"a shift by {b} bits")
    if bits is None and (a < 0 or a << b >= 1 << 15):
        raise open_point("a shift beyond fifteen bits", "bits")
    if bits is None:
        return a << b if sign > 0 else a >> b
    # Fill with zeros, then take the bits that fit as a number with a sign.
    made = a % (1 << bits) << b if sign > 0 else a % (1 << bits) >> b
    half = 1 << (bits - 1)
    return (made + half) % (2 * half) - half


SPELLINGS: Final = {"><": "<>", "=<": "<=", "=>": ">="}

RELATIONS: Final[Mapping[str, Callable[[Any, Any], bool]]] = {
    "=": operator.eq, "<>": operator.ne, "<": operator.lt, "<=": operator.le,
    ">": operator.gt, ">=": operator.ge,
}  # fmt: skip
_BITWISE: Final[Mapping[str, Callable[[int, int], int]]] = {
    "AND": operator.and_, "OR": operator.or_, "XOR": operator.xor,
}  # fmt: skip
_ARITHMETIC: Final[Mapping[str, Callable[[Any, Any], Any]]] = {
    "+": operator.add, "-": operator.sub, "*": operator.mul, "/": _divided,
}  # fmt: skip
_OPTION_OPERATORS: Final[Mapping[str, Callable[[Options, Any, Any], int | float]]] = {
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
            return arm_state.scaled(joints(left), _scale_factor(sign, right))
        if sign in ("+", "-"):
            return arm_state.elementwise(joints(left), joints(right), _ARITHMETIC[sign])
        raise Failed(4390, f"the operator {sign} between joints")
    if sign in ("*", "/") and isinstance(right, int | float):
        return arm_state.scaled(position(left), _scale_factor(sign, right))
    if sign in ("+", "-"):
        if isinstance(left, Bare) and isinstance(right, Bare):
            raise Unknown("a sum of two constants without flags")
        return arm_state.elementwise(position(left), position(right), _ARITHMETIC[sign])
    if sign == "*":
        return arm_state.composed(position(left), position(right), robot)
    if sign == "/":
        if m.world.options.over == "Inv(P2)*P1":
            return arm_state.divided_from_left(position(left), position(right), robot)
        return arm_state.divided(position(left), position(right), robot)
    raise Failed(4390, f"the operator {sign} between positions")


def _scale_factor(sign: str, given: float) -> float:
    return float(given) if sign == "*" else _divided(1.0, given)


def value(m: Machine, node: s.Expression | None) -> Value:
    """Return the value of an expression; raises Failed or Unknown."""
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
            return unary(sign.upper(), value(m, operand))
        # The mask takes the sign bit away, so no option is needed to know what it means.
        case s.Binary(operator=sign, left=s.Variable() as read, right=s.Number(value=mask)) if (
            sign.upper() == "AND" and 0 <= mask < _SIGN_BIT and (low := _bits(m, read)) is not None
        ):
            return low & whole(mask, "an operand")
        case s.Binary(operator=sign, left=left, right=right):
            return binary(m, sign.upper(), value(m, left), value(m, right))
        case s.Pallet(number=number_, point=point):
            which, at = whole(value(m, number_), "the pallet"), whole(value(m, point), "the point")
            return positions.pallet_point(m.pallets.get(which), which, at)
    raise Failed(4220, "an expression that is none")


_SIGN_BIT: Final = 1 << 15
"""The bit that may be a sign: those below it are the same with and without one."""


def _bits(m: Machine, node: s.Variable) -> int | None:
    """The signals of a group that a node reads, None for anything else."""
    key = node.key
    if node.component or m.is_own(key) or key in m.code.functions or not is_status(key):
        return None
    return status.group_bits(m.world, key, tuple(value(m, a) for a in node.arguments or ()))


def values(m: Machine, given: tuple[s.Expression | None, ...]) -> tuple[Value | None, ...]:
    """Return the values of arguments, None for omitted ones."""
    return tuple(None if node is None else value(m, node) for node in given)


def integer(m: Machine, node: s.Expression | None, what: str = "the value") -> int:
    return whole(value(m, node), what)


def plain(m: Machine, node: s.Expression | None, what: str = "the value") -> int | float:
    return number(value(m, node), what)


# --------------------------------------------------------------------------------- variables


def variable(m: Machine, node: s.Variable) -> Value:
    """A variable, an element, a status variable, or what a function gives."""
    found = _whole_value(m, node)
    if node.component:
        return component(found, node.component, m.world.options)
    return found


def _whole_value(m: Machine, node: s.Variable) -> Value:
    key = node.key
    if m.is_result(node):
        return m.result()
    if not m.is_own(key):
        if key in m.world.commands:
            return _plugin_value(m, node)
        if key in m.code.functions:
            return m.called(node)
        if key in m.code.definitions:
            return m.defined(node)
        if key in m.code.signals:
            return _io_value(m, m.code.signals[key])
        if node.arguments is not None and vocabulary.function(key) is not None:
            return _applied(m, node, node.arguments)
        if is_status(key) and not _is_listed(m, node):
            index = tuple(value(m, a) for a in node.arguments or ())
            return status.read(m.world, key, index)
    place, index = reference(m, node)
    if m.world.options.unset == "zero" and place.kind in NUMBER_KINDS and not place.is_set(index):
        return 0
    if m.world.options.shared == "zero" and is_external(key) and not place.is_set(index):
        if place.kind in (*NUMBER_KINDS, "text"):
            return "" if place.kind == "text" else 0
    return place.get(index)


def _is_listed(m: Machine, node: s.Variable) -> bool:
    """True for the safe point (parameter JSAFE) where a position list holds it."""
    if node.key != "P_SAFE" or node.arguments is not None:
        return False
    place, index = reference(m, node)
    return place.is_set(index)


def store(m: Machine, node: s.Variable, given: Value) -> None:
    """Gives a variable, or a component of one, a value."""
    if node.key in m.code.constants and not m.is_own(node.key):
        raise Failed(3210, f"{node.name} is a constant")
    place, index = reference(m, node)
    if node.component:
        given = with_component(place.get(index), node.component, given, m.world.options)
    place.set(fitted(given, place.kind, node.name, m.world.options), index)


def _plugin_value(m: Machine, node: s.Variable) -> Value:
    """Return the value that a plug-in gives for a function or a status variable."""
    found = m.world.given(node.key, values(m, node.arguments or ()))
    if found is None:
        raise Unknown(f"the plug-in {node.name} gives no value")
    return found


def bare(node: s.Expression | None) -> str:
    """Return the bare word of an argument, capitalised; empty if it is not a word."""
    if isinstance(node, s.Word):
        return node.text.capitalize()
    if isinstance(node, s.Variable) and node.arguments is None and not node.component:
        return node.marked.capitalize()
    return ""


def _applied(m: Machine, node: s.Variable, arguments: tuple[s.Expression | None, ...]) -> Value:
    """Return the value of a function of the language."""
    known, count = vocabulary.function(node.key), len(arguments)
    if known and not known.least <= count <= (count if known.most is None else known.most):
        raise Failed(3120, f"{node.name} with {count} arguments")
    if count > 1 and not m.world.options.nested and any(map(_calls, arguments)):
        raise Failed(None, f"a function with an argument among those of {node.name}")
    if node.key == "CALARC":
        return _arc(m, arguments)
    given = values(m, arguments)
    return functions.call(node.key.removesuffix("$"), given, m.world)


def _calls(node: s.Expression | None) -> bool:
    """True if an expression contains a function with an argument."""
    return any(
        isinstance(part, s.Variable) and part.arguments and vocabulary.function(part.key)
        for part in nodes(node)
    )


def _arc(m: Machine, arguments: tuple[s.Expression | None, ...]) -> int:
    """CalArc, which gives most of what it finds back in its arguments."""
    one, via, other = (value(m, node) for node in arguments[:3])
    done, radius, angle, length, centre = positions.arc_data(one, via, other)
    found: tuple[Value, ...] = (radius, angle, length, centre)
    for node, made in zip(arguments[3:], found, strict=True):
        if not isinstance(node, s.Variable):
            raise Failed(3810, "a result of CalArc goes to what is no variable")
        store(m, node, made)
    return done


@cache
def is_status(key: str) -> bool:
    """True if a name is a status variable of the controller, and not a numbered one, `M_00` or
    `P_100`.
    """
    return vocabulary.status(key) is not None and not (is_external(key) and key[2:].isdigit())


def reference(m: Machine, node: s.Variable) -> tuple[Storage, Index]:
    """The cell that a variable is, and the element of it."""
    if node.arguments is None:
        return m.memory_of(node.key).place(node.key), ()
    index = tuple(integer(m, a, f"a subscript of {node.name}") for a in node.arguments)
    return m.memory_of(node.key).place(node.key), index


def _io_value(m: Machine, definition: s.DefIo) -> int:
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


NUMBER_KINDS: Final = ("number", "integer", "long")
"""Types of variables that a number goes into."""
