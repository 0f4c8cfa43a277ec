"""Positions that are computed: pallets, sums and products of positions, constant shifts.

    Def Plt 1,PS,PA,PB,PD,4,3,2
    Mov (Plt 1,MK)

becomes an array of 12 targets and a move to one of its elements if the corners never change. For
other languages the corners and counts of any other pallet become variables, and each position an
offset from its start that functions of `tables/library.txt` compute.

`(P1+P2)/2` adds and divides X, Y, Z, A, B and C each for itself, and keeps the flags of P1. A
product `P1*P2` moves P1 by P2 in the frame of P1: about z, then about the new y and the new x.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any, Final, Protocol

import numpy as np

from assistant.base import rotations
from assistant.languages.melfa_basic.lift.symbols import (
    VENDOR_ONLY_NAME,
    ComputedPallet,
    Symbols,
    Unliftable,
)
from assistant.languages.melfa_basic.tables.poses import plain_pose, plain_values
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.line_tables import target_of
from assistant.languages.melfa_basic.tree.walk import literal
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.geometry import Pose, Target, points_on_arc
from assistant.program.geometry import grid_points as points_of_grid
from assistant.program.program import ValueType, Variable
from assistant.program.rewriting import records

_MOST_POINTS: Final = 999
"""Elements that an array may have."""
_ZIGZAG, _SAME_WAY, ARC_DIRECTION = 1, 2, 3
"""Directions: every other row runs backwards, or none does; places on an arc."""
FIXED_POSTURE: Final = 10
"""Added to a direction whose places all have the posture of the start (CR1D 4-190)."""
_COMPUTED_POINTS: Final = p.Reason(
    "the points of the pallet are not known beforehand, turn, or stand in no plain grid",
    "give corners of one orientation that the program never sets",
)
_PALLET_WORD: Final = re.compile(r"\bPlt\b", re.IGNORECASE)


def pallets(code: Sequence[s.Entry], symbols: Symbols) -> dict[int, tuple[str, tuple[Target, ...]]]:
    """The array of each pallet that has one definition and corners that stay, by its number."""
    found: dict[int, list[s.DefOther]] = {}
    for item in code:
        if isinstance(item.statement, s.DefOther) and item.statement.kind == "Plt":
            number = symbols.constants.value(item.statement.arguments[0])
            # A computed number may define any of the pallets.
            if not isinstance(number, float):
                return {}
            found.setdefault(round(number), []).append(item.statement)
    made = {}
    for key, definitions in found.items():
        points = _pallet_grid(definitions[0], symbols) if len(definitions) == 1 else None
        if points is not None:
            made[key] = symbols.free(pallet_array_name(key)), points
        elif all(len(one.arguments) == 8 for one in definitions) and not symbols.positions.slides:
            symbols.worked_out[key] = _computed_pallet(key, definitions, symbols)
    return made


def pallet_array_name(number: float) -> str:
    """Return the name of a pallet's array, if nothing else has that name."""
    return f"pallet_{number:g}"


def _pallet_grid(node: s.DefOther, symbols: Symbols) -> tuple[Target, ...] | None:
    """The targets of a pallet in their order; None if they are not known or turn.

    Start S, end of the first row A, end of the first column B, and the corner D across, which
    makes it bilinear; of an arc its start, a place on its way, and its end. Each keeps the
    orientation and the branch of the start.
    """
    if len(node.arguments) != 8:
        return None
    _, start, along, across, diagonal, *counts = node.arguments
    numbers = [symbols.constants.value(count) for count in counts]
    corners = [unchanged_position(point, symbols) for point in (start, along, across)]
    arc = _is_on_arc(node, symbols)
    if diagonal is not None and not arc:
        corners.append(unchanged_position(diagonal, symbols))
    known = [corner for corner in corners if corner is not None]
    if len(known) != len(corners) or not all(isinstance(n, float) for n in numbers):
        return None
    columns, rows, given = (round(n) for n in numbers if isinstance(n, float))
    direction, rows = given % FIXED_POSTURE, 1 if arc else rows
    if (
        given // FIXED_POSTURE > 1
        or direction not in (_ZIGZAG, _SAME_WAY, ARC_DIRECTION)
        or columns < 1
        or rows < 1
    ):
        return None
    if columns * rows > _MOST_POINTS or known[0].flags is None:
        return None
    if any(any(corner.values[6:]) for corner in known):
        return None
    # Only places of one posture have the start's orientation; divided angles are no plain grid.
    if given // FIXED_POSTURE == 0 and not _have_same_angles(known):
        return None
    places = np.array([[float(v or 0) for v in corner.values[:3]] for corner in known])
    points = points_of_grid(places, columns, rows, direction == _ZIGZAG)
    if arc:
        points = points_on_arc(places, columns)
    made = []
    for point in points:
        values = (*(float(v) for v in point), *known[0].values[3:6])
        made.append(target_of(s.Constant(values, known[0].flags), symbols.robot))
    return tuple(made)


def _is_on_arc(node: s.DefOther, symbols: Symbols) -> bool:
    direction = symbols.constants.value(node.arguments[7])
    return direction in (ARC_DIRECTION, ARC_DIRECTION + FIXED_POSTURE)


def unchanged_position(node: s.Expression | None, symbols: Symbols) -> s.Constant | None:
    """The value of a position that no line changes; other programs change shared ones."""
    if not isinstance(node, s.Variable) or node.arguments is not None or node.component:
        return None
    if node.key[1:2] == "_" or node.key in symbols.constants.assigned:
        return None
    constant = symbols.positions.constant(node.name)
    if constant is None or len(constant.values) < 6 or None in constant.values[:6]:
        return None
    return constant


def _have_same_angles(corners: Sequence[s.Constant]) -> bool:
    """True if all have the angles of the first one."""
    return all(corner.values[3:6] == corners[0].values[3:6] for corner in corners)


# --------------------------------------------------------------------------- worked out

_PALLET_SHIFT: Final = "pallet_shift"
_PALLET_STEP: Final = "pallet_step"
_PALLET_TURN: Final = "pallet_turn"
_PALLET_FAILS: Final = "pallet_fails"
_PALLET_ON_ARC: Final = "pallet_arc"
_PALLET_ARC_SHARE: Final = "pallet_arc_share"
"""Functions of the library."""
ANGLE_DIVIDING: Final = (_PALLET_TURN, _PALLET_ARC_SHARE)
"""Those that divide the angles of the corners."""
_CORNERS: Final = ("start", "first", "second", "opposite")
_COUNTS: Final = ("columns", "rows", "direction")
_LENGTHS: Final = ("x", "y", "z")
_ANGLES: Final = ("about_x", "about_y", "about_z")


class PalletReader(Protocol):
    """Lift of the expressions of a file."""

    m: Symbols

    def plain(self, node: s.Expression) -> e.Expression:
        """Any value."""

    def rounded(self, node: s.Expression) -> e.Expression:
        """One that is whole."""


def _computed_pallet(
    number: int, definitions: Sequence[s.DefOther], symbols: Symbols
) -> ComputedPallet:
    """Properties that all definitions of a pallet share."""
    values = [symbols.constants.value(one.arguments[7]) for one in definitions]
    known = {round(value) if isinstance(value, float) else None for value in values}
    arcs = {value is not None and value % FIXED_POSTURE == ARC_DIRECTION for value in known}
    fourth = {one.arguments[4] is not None for one in definitions}
    direction = next(iter(known)) if len(known) == 1 else None
    turned = any(
        (value is None or value < FIXED_POSTURE)
        and not _has_one_posture(one, arcs == {True}, symbols)
        for one, value in zip(
            definitions, (round(v) if isinstance(v, float) else None for v in values), strict=True
        )
    )
    names = {
        part: symbols.free(f"{pallet_array_name(number)}_{part}") for part in (*_CORNERS, *_COUNTS)
    }
    return ComputedPallet(names, arcs == {True}, True in fourth, turned, direction)


def _has_one_posture(node: s.DefOther, arc: bool, symbols: Symbols) -> bool:
    """True if the corners are known and have the same angles."""
    given = [one for one in node.arguments[1 : 4 if arc else 5] if one is not None]
    corners = [unchanged_position(one, symbols) for one in given]
    known = [one for one in corners if one is not None]
    return len(known) == len(corners) and _have_same_angles(known)


def _defined_variables(
    node: s.DefOther, pallet: ComputedPallet, lift: PalletReader
) -> list[p.Statement]:
    """The variables of a pallet as a definition sets them."""
    names, made = pallet.names, list[p.Statement]()
    corners = dict(zip(_CORNERS, node.arguments[1:5], strict=True))
    if pallet.arc:
        corners["opposite"] = None
    for part, corner in corners.items():
        if corner is None and part == "opposite":
            if pallet.opposite and not pallet.arc:
                _declare_variable(names[part], Variable("position"), lift.m)
                made.append(_opposite_corner(pallet))
            continue
        if corner is None:
            raise Unliftable(_COMPUTED_POINTS)
        value = lift.plain(corner)
        _declare_variable(names[part], Variable("position"), lift.m)
        made.append(p.Assign(e.Name(names[part]), value))
    for part, count in zip(_COUNTS, node.arguments[5:], strict=True):
        if count is None:
            raise Unliftable(_COMPUTED_POINTS)
        _declare_variable(names[part], Variable("integer"), lift.m)
        made.append(p.Assign(e.Name(names[part]), lift.rounded(count)))
    counts = tuple(e.Name(names[part]) for part in _COUNTS)
    # Counts that the program computes are checked as it runs, as the controller does.
    if not all(isinstance(lift.m.constants.value(one), float) for one in node.arguments[5:]):
        failed = e.Binary("=", e.Apply(VENDOR_ONLY_NAME.format(_PALLET_FAILS), counts), e.Number(1))
        made.append(p.If((p.Branch(failed, (p.Stop(end=True),)),)))
    return made


def _opposite_corner(pallet: ComputedPallet) -> p.Assign:
    """The fourth corner of a parallelogram, where other definitions state one."""
    start, first, second, opposite = (e.Name(pallet.names[part]) for part in _CORNERS)

    def beside(field: str) -> e.Expression:
        return e.Binary("-", e.Member(first, field), e.Member(start, field))

    place: e.Expression = e.Apply("offset", (second, *map(beside, _LENGTHS)))
    if pallet.turned:
        angles = (e.Binary("+", e.Member(second, field), beside(field)) for field in _ANGLES)
        place = e.Apply("oriented", (place, *angles))
    return p.Assign(opposite, place)


def _declare_variable(name: str, variable: Variable, symbols: Symbols) -> None:
    symbols.variables.setdefault(name, variable)


def pallet_position(number: int, point: s.Expression, lift: PalletReader) -> e.Expression:
    """A place of a pallet that is worked out, by its number; raises Unliftable."""
    pallet = lift.m.worked_out.get(number)
    if pallet is None or not lift.m.telling:
        raise Unliftable
    at = lift.rounded(point)
    corner = {part: e.Name(pallet.names[part]) for part in _CORNERS}
    counts = [e.Name(pallet.names[part]) for part in _COUNTS]

    ends = tuple(corner[part] for part in _CORNERS[:3])

    def grid_shift(field: str, function: str = _PALLET_SHIFT) -> e.Expression:
        one, two, three = (e.Member(end, field) for end in ends)
        # Without a fourth corner, the pallet is a parallelogram.
        four: e.Expression = e.Binary("-", e.Binary("+", two, three), one)
        if pallet.opposite:
            four = e.Member(corner["opposite"], field)
        if function == _PALLET_SHIFT and pallet.direction is None:
            axis = e.Number(_LENGTHS.index(field))
            return e.Apply(VENDOR_ONLY_NAME.format(_PALLET_STEP), (axis, *ends, four, *counts, at))
        return e.Apply(VENDOR_ONLY_NAME.format(function), (one, two, three, four, *counts, at))

    def arc_shift(axis: int) -> e.Expression:
        return e.Apply(
            VENDOR_ONLY_NAME.format(_PALLET_ON_ARC), (e.Number(axis), *ends, counts[0], at)
        )

    def turned(field: str) -> e.Expression:
        start, end = (e.Member(corner[part], field) for part in ("start", "second"))
        if pallet.arc:
            share = e.Apply(VENDOR_ONLY_NAME.format(_PALLET_ARC_SHARE), (counts[0], counts[2], at))
            return e.Binary("+", start, e.Binary("*", share, e.Binary("-", end, start)))
        return e.Binary("+", start, grid_shift(field, _PALLET_TURN))

    shifts = [
        arc_shift(axis) if pallet.arc else grid_shift(field) for axis, field in enumerate(_LENGTHS)
    ]
    place = e.Apply("offset", (corner["start"], *shifts))
    return e.Apply("oriented", (place, *map(turned, _ANGLES))) if pallet.turned else place


def define_pallet(node: s.DefOther, lift: PalletReader) -> list[p.Statement]:
    """`Def Plt`, a comment where the points are known."""
    symbols = lift.m
    if node.kind == "MoTrg" and symbols.telling and symbols.mo_triggers:
        return []  # its condition is asked where the trigger is
    number = symbols.constants.value(node.arguments[0]) if node.kind == "Plt" else None
    if not isinstance(number, float):
        raise Unliftable
    pallet = symbols.worked_out.get(round(number))
    if pallet is not None and symbols.telling:
        return _defined_variables(node, pallet, lift)
    if round(number) not in symbols.pallets or not (symbols.grids or symbols.telling):
        raise Unliftable(_COMPUTED_POINTS)
    array = pallet_array(round(number), symbols)
    return [p.Comment(_pallet_note(array.name, node, symbols))]


def _pallet_note(array: str, node: s.DefOther, symbols: Symbols) -> str:
    """What whoever teaches a corner again must know."""
    corners = [point.name for point in node.arguments[1:5] if isinstance(point, s.Variable)]
    counts = [symbols.constants.value(count) for count in node.arguments[5:7]]
    columns, rows = (f"{count:g}" for count in counts if isinstance(count, float))
    if _is_on_arc(node, symbols):
        corners = corners[:3]
        places = f"{columns} places on the arc of"
    else:
        places = f"{columns} by {rows} places between"
    listed = f"{', '.join(corners[:-1])} and {corners[-1]}"
    return f"{array}: the {places} {listed}; if those move, teach these or translate again"


def pallet_array(number: int, symbols: Symbols) -> e.Name:
    """The array of a pallet, declared where it is first met."""
    name, points = symbols.pallets[number]
    values = e.Aggregate(tuple(e.TargetValue(point) for point in points))
    symbols.variables.setdefault(
        name, Variable("position", values, (len(points),), storage="constant")
    )
    return e.Name(name)


def mentions_pallet(parts: Any) -> bool:
    """True if vendor text needs the definitions of pallets."""
    return any(
        isinstance(part, e.Verbatim | p.Opaque) and _PALLET_WORD.search(part.text) is not None
        for part in records(parts)
    )


_LENGTH_FIELDS: Final = ("x", "y", "z")
POSE_FIELDS: Final = (*_LENGTH_FIELDS, "about_x", "about_y", "about_z")
_ZERO: Final = e.Number(0)


class ElementReader(Protocol):
    """Lift of the expressions of a file."""

    m: Symbols

    def plain(self, node: s.Expression) -> e.Expression:
        """Any value."""

    def number(self, node: s.Expression) -> e.Expression:
        """Lift a value that is not a truth."""

    def degrees(self, node: s.Expression) -> e.Expression:
        """An angle in radian as degrees."""

    def type_of(self, node: s.Expression | None) -> ValueType:
        """Its type."""


def elementwise_position(node: s.Binary, lift: ElementReader) -> e.Expression:
    """A sum of positions, or a multiple of one; raises Unliftable for anything else."""
    if _has_sliding_axis(lift.m):
        raise Unliftable
    # The constant is stored as an orientation, which must give back the same angles.
    if (fixed := _constant_sum(node, lift.m)) is not None and _reads_back(fixed[0]):
        values, flags = fixed
        return lift.m.value_of(s.Constant(values, flags), "position")
    base = _leftmost_position(node, lift)
    elements = [_position_element(node, at, lift) for at in range(len(POSE_FIELDS))]
    moved = [_element_difference(elements[at], _pose_member(base, at)) for at in range(3)]
    place = base if moved == [_ZERO] * 3 else e.Apply("offset", (base, *moved))
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
    # The product turns about z first, `relative` about x: each turn is a separate shift.
    moved = e.Apply("relative", (left, x, y, z, _ZERO, _ZERO, c))
    tilted = e.Apply("relative", (moved, _ZERO, _ZERO, _ZERO, _ZERO, b))
    return e.Apply("relative", (tilted, _ZERO, _ZERO, _ZERO, a))


_ConstantSum = tuple[tuple[float, ...], tuple[int | None, int | None]]
"""Elements of a position and its flags."""


def _constant_sum(node: s.Expression, symbols: Symbols) -> _ConstantSum | None:
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
    # At B = 90 degrees A and C turn about one axis, and only their sum can be read back.
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
    if other == _ZERO:
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
    return _ZERO if value == start else e.Binary("-", value, start)


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


def constant_shift(node: s.Expression, symbols: Symbols) -> s.Constant | None:
    """The constant that a position is moved by, also by the name of one that never changes."""
    if isinstance(node, s.Constant):
        return node
    if isinstance(node, s.Variable) and node.arguments is None and not node.component:
        if not symbols.own and node.key not in symbols.constants.assigned:
            return symbols.positions.constant(node.key)
    if (
        isinstance(node, s.Variable)
        and node.key == "INV"
        and (pose := constant_pose(node, symbols))
    ):
        return s.Constant(plain_values(pose))
    return None


def constant_pose(node: s.Expression | None, symbols: Symbols) -> Pose | None:
    """Return the pose of a constant, or of an inverse or product of constants; None if it is
    unknown.
    """
    if symbols.own or (symbols.robot is not None and symbols.robot.five_axis):
        return None
    match node:
        case s.Variable(key="INV", arguments=(inner,), component=""):
            pose = constant_pose(inner, symbols)
            return None if pose is None else pose.inverse()
        case s.Binary(operator="*", left=left, right=right):
            one, two = constant_pose(left, symbols), constant_pose(right, symbols)
            return None if one is None or two is None else one @ two
        case None:
            return None
    constant = constant_shift(node, symbols)
    if constant is None or any(constant.values[6:]) or None in constant.values:
        return None
    return plain_pose(constant.values)


def shift_amounts(operator: str, constant: s.Constant, symbols: Symbols) -> list[float]:
    """Return the shift: mm along x, y, z, and degrees about x, the new y, the new z if it turns at
    all.

    operator: `+`, `-` or `*`. Raises Unliftable for a shift that the pseudo-program cannot express.
    """
    values = [0.0 if v is None else float(v) for v in constant.values]
    values += [0.0] * (6 - len(values))
    five_axis = symbols.robot is not None and symbols.robot.five_axis
    if any(values[6:]) or (five_axis and any(values[3:]) and not symbols.own):
        raise Unliftable
    if operator == "-":
        # Adding 0.0 makes 0.0 of -0.0.
        values = [-v + 0.0 for v in values]
    turned = values[3:6]
    if operator != "*" and any(turned):
        raise Unliftable
    if sum(v != 0.0 for v in turned) > 1:  # turned about x, then the new y, then the new z
        whole = rotations.from_euler(np.array(turned[::-1]), "ZYX")
        # Rounding takes away the noise of the conversion.
        values[3:6] = [round(float(v), 9) + 0.0 for v in rotations.to_euler(whole, "XYZ")]
    used = values[:6] if any(turned) else values[:3]
    while len(used) > 3 and used[-1] == 0.0:
        used.pop()
    return used


def is_inverse(node: s.Expression) -> bool:
    return isinstance(node, s.Variable) and node.key == "INV"
