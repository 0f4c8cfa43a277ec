"""Positions that are worked out element by element, and products of positions, for other languages.

`(P1+P2)/2` adds and divides X, Y, Z, A, B and C each by itself, and keeps the flags of P1. A
product `P1*P2` moves P1 by P2 as its tool is turned: about z, then about the new y and the new x.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, Protocol

from assistant.languages.melfa_basic.lift.values.pallets import unchanged_position
from assistant.languages.melfa_basic.lift.values.symbols import Symbols, Unliftable
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.walk import literal
from assistant.program import expressions as e
from assistant.program.program import ValueType

LENGTH_FIELDS: Final = ("x", "y", "z")
POSE_FIELDS: Final = (*LENGTH_FIELDS, "about_x", "about_y", "about_z")
ZERO: Final = e.Number(0)


class ElementReader(Protocol):
    """Lift of the expressions of a file."""

    m: Symbols

    def plain(self, node: s.Expression) -> e.Expression:
        """Any value."""

    def number(self, node: s.Expression) -> e.Expression:
        """One that is no truth."""

    def degrees(self, node: s.Expression) -> e.Expression:
        """An angle in radian as degrees."""

    def type_of(self, node: s.Expression | None) -> ValueType:
        """Its type."""


def elementwise_position(node: s.Binary, lift: ElementReader) -> e.Expression:
    """A sum of positions, or a multiple of one; raises Unliftable for anything else."""
    if _has_sliding_axis(lift.m):
        raise Unliftable
    if (fixed := _constant_sum(node, lift.m)) is not None and _reads_back(fixed[0]):
        values, flags = fixed
        return lift.m.value_of(s.Constant(values, flags), "position")
    base = _leftmost_position(node, lift)
    elements = [_position_element(node, at, lift) for at in range(len(POSE_FIELDS))]
    moved = [_element_difference(elements[at], _pose_member(base, at)) for at in range(3)]
    place = base if moved == [ZERO] * 3 else e.Apply("offset", (base, *moved))
    turned = elements[3:]
    if turned == [_pose_member(base, at) for at in range(3, 6)]:
        return place
    return e.Apply("oriented", (place, *turned))


def position_product(left: e.Expression, right: s.Expression, lift: ElementReader) -> e.Expression:
    """A position moved by another one that the program works out."""
    by = lift.plain(right)
    if not isinstance(by, e.Name | e.Index) or _has_sliding_axis(lift.m):
        raise Unliftable
    x, y, z, a, b, c = (_pose_member(by, at) for at in range(6))
    moved = e.Apply("relative", (left, x, y, z, ZERO, ZERO, c))
    tilted = e.Apply("relative", (moved, ZERO, ZERO, ZERO, ZERO, b))
    return e.Apply("relative", (tilted, ZERO, ZERO, ZERO, a))


ConstantSum = tuple[tuple[float, ...], tuple[int | None, int | None]]
"""Elements of a position and its flags."""


def _constant_sum(node: s.Expression, symbols: Symbols) -> ConstantSum | None:
    """Value of a sum of positions that no line changes."""
    match node:
        case s.Binary(("+" | "-") as sign, left, right):
            one, two = _constant_sum(left, symbols), _constant_sum(right, symbols)
            if one is None or two is None:
                return None
            way = 1.0 if sign == "+" else -1.0
            return tuple(a + way * b for a, b in zip(one[0], two[0], strict=True)), one[1]
        case s.Binary(("*" | "/") as sign, left, right) if (by := literal(right)) is not None:
            inner = _constant_sum(left, symbols)
            if inner is None or by == 0.0:
                return None
            return tuple(v * by if sign == "*" else v / by for v in inner[0]), inner[1]
    constant = node if isinstance(node, s.Constant) else unchanged_position(node, symbols)
    if constant is None or None in constant.values[:6]:
        return None
    values = [v or 0.0 for v in constant.values[:6]]
    return (*values, *[0.0] * (6 - len(values))), constant.flags or (None, None)


def _reads_back(values: tuple[float, ...]) -> bool:
    """True if the angles of an orientation read back as they were written."""
    a, b, c = values[3:6]
    return abs(a) <= 180.0 and abs(b) < 90.0 and abs(c) <= 180.0


def _leftmost_position(node: s.Expression, lift: ElementReader) -> e.Expression:
    """The position whose flags a sum has: its left one."""
    while isinstance(node, s.Binary) and node.operator in ("+", "-", "*", "/"):
        node = node.left
    made = lift.plain(node)
    if not isinstance(made, e.Name | e.Index):
        raise Unliftable
    return made


def _position_element(node: s.Expression, at: int, lift: ElementReader) -> e.Expression:
    """One element of a position that is worked out, in mm or degrees."""
    match node:
        case s.Binary(("+" | "-") as sign, left, right):
            return _element_sum(
                sign, _position_element(left, at, lift), _position_element(right, at, lift)
            )
        case s.Binary(("*" | "/") as sign, left, right) if _is_factor(right, lift):
            return e.Binary(sign, _position_element(left, at, lift), lift.number(right))
        case s.Binary():
            raise Unliftable  # of positions, as `P1/P2`
        case s.Constant(values=values):
            value = values[at] if at < len(values) else 0.0
            if value is None or any(values[6:]):
                raise Unliftable
            return e.number_of(value)
    made = lift.plain(node)
    if not isinstance(made, e.Name | e.Index):
        raise Unliftable
    return _pose_member(made, at)


def _element_sum(sign: str, one: e.Expression, other: e.Expression) -> e.Expression:
    if other == ZERO:
        return one
    if isinstance(other, e.Number) and other.value < 0:
        return _element_sum("-" if sign == "+" else "+", one, e.Number(-other.value))
    return e.Binary(sign, one, other)  # type: ignore[arg-type]


def _is_factor(node: s.Expression, lift: ElementReader) -> bool:
    known = literal(node)
    if known is not None:
        return True
    return not isinstance(node, s.Constant) and lift.type_of(node) in ("number", "integer")


def _element_difference(value: e.Expression, start: e.Expression) -> e.Expression:
    """Largest difference between two values."""
    match value:
        case e.Binary("+", one, rest) if one == start:
            return rest
        case e.Binary("-", one, e.Number(rest)) if one == start:
            return e.Number(-rest)
        case e.Binary("-", one, rest) if one == start:
            return e.Unary("-", rest)
    return ZERO if value == start else e.Binary("-", value, start)


def _pose_member(place: e.Expression, at: int) -> e.Expression:
    return e.Member(place, POSE_FIELDS[at])


def _has_sliding_axis(symbols: Symbols) -> bool:
    """True if positions of the file have additional axes, which would count as well."""
    return symbols.positions.slides or symbols.own


# ---------------------------------------------------------------------------- built of numbers


def built_joints(given: Sequence[s.Expression], lift: ElementReader) -> tuple[float, ...] | None:
    """The elements of `SetJnt` in degrees, None where the program works one out."""
    found = [lift.degrees(value) for value in given]
    plain = [e.plain_number(value) for value in found]
    known = tuple(value for value in plain if value is not None)
    return known if len(known) == len(plain) else None


def computed_position(given: Sequence[s.Expression], lift: ElementReader) -> e.Expression:
    """The position of `SetPos`, of six numbers that the program works out."""
    if _has_sliding_axis(lift.m) or len(given) != len(POSE_FIELDS):
        raise Unliftable
    places = [lift.number(value) for value in given[:3]]
    turned = built_joints(given[3:], lift)
    known = turned is not None and _reads_back((0.0, 0.0, 0.0, *turned))
    angles = turned if turned is not None and known else (0.0, 0.0, 0.0)
    start = lift.m.value_of(s.Constant((0.0, 0.0, 0.0, *angles), (None, None)), "position")
    place = e.Apply("offset", (start, *places))
    if known:
        return place
    return e.Apply("oriented", (place, *(lift.degrees(value) for value in given[3:])))


def built_position(given: Sequence[s.Expression], lift: ElementReader) -> tuple[float, ...] | None:
    """The same of `SetPos`, of which the first three are mm."""
    first = [e.plain_number(lift.number(value)) for value in given[:3]]
    known = tuple(value for value in first if value is not None)
    turned = built_joints(given[3:], lift)
    return None if turned is None or len(known) != 3 else (*known, *turned)
