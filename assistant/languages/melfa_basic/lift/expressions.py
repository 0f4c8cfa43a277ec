"""Expressions of MELFA-BASIC as expressions of the pseudo-program, with their types.

An expression that the pseudo-program cannot express raises Unliftable. The form distinguishes
truths from numbers: comparisons, and logic of nothing but comparisons, are truths. Functions that
only MELFA-BASIC has become calls of procedures of `tables/library.txt`; timers that a file sets to
zero and reads become timers of the pseudo-program, which count seconds instead of milliseconds.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, Final, Protocol, TypeVar

from assistant.languages.melfa_basic.lift.computed_positions import (
    POSE_FIELDS,
    built_joints,
    built_position,
    computed_position,
    constant_pose,
    constant_shift,
    elementwise_position,
    is_inverse,
    pallet_array,
    pallet_position,
    position_product,
    shift_amounts,
)
from assistant.languages.melfa_basic.lift.symbols import (
    CONTROLLER_STATES,
    INITIAL_STATUS,
    LETTER_TYPES,
    SIGNAL_VARIABLES,
    VENDOR_ONLY_NAME,
    Symbols,
    Unliftable,
)
from assistant.languages.melfa_basic.lift.untranslatable_reasons import (
    BUILT_POSITION,
    COMPUTED_SIGNAL,
    SLIDING_AXIS,
)
from assistant.languages.melfa_basic.tables import poses
from assistant.languages.melfa_basic.tables.equivalents import (
    ARM_FUNCTIONS,
    FIRST_HAND_CHECK,
    FUNCTIONS_OF_ANGLES,
    FUNCTIONS_TO_ANGLES,
    HAND_CHECKS,
    LIBRARY_FUNCTIONS,
    OPERATOR_NAMES,
    SAME_UNIT_FUNCTIONS,
    STATUS_FUNCTIONS,
    library,
)
from assistant.languages.melfa_basic.tables.poses import (
    ANGLES,
    JOINTS,
    is_angle,
    is_length,
    is_units,
)
from assistant.languages.melfa_basic.tables.variables import (
    CONNECTION_STATUS,
    FILE_NUMBERS,
    MILLISECONDS,
    MOST_TIMERS,
    OPTIMUM_SPEED,
)
from assistant.languages.melfa_basic.tables.vocabulary import function, status
from assistant.languages.melfa_basic.text import effects, printer
from assistant.languages.melfa_basic.text.header import Header
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.line_tables import target_of
from assistant.languages.melfa_basic.tree.walk import literal, nodes, timer_number
from assistant.languages.vendor_statements import CONTROLLER_STATE, SETTINGS_DIFFER
from assistant.program import expressions as e
from assistant.program.analysis.declared_types import of_operation
from assistant.program.geometry import BASE, FLANGE, Target
from assistant.program.program import ValueType
from assistant.program.rewriting import records
from assistant.program.undeclared_names import name_of_channel, timer_in_seconds

_TRUTHS: Final = (*e.RELATIONS, *e.LOGICAL)
_INTEGER_OPERATORS: Final = ("div", "mod")
"""Operators that round their operands first."""


def operator_name(written: str) -> str:
    return OPERATOR_NAMES.get(written, written)


def is_comparison(node: s.Expression) -> bool:
    """True for a comparison, and for logic of comparisons only."""
    match node:
        case s.Binary(operator=written, left=left, right=right):
            operator = operator_name(written)
            if operator in e.LOGICAL:
                return is_comparison(left) and is_comparison(right)
            return operator in e.RELATIONS
        case s.Unary(operator=sign, operand=operand):
            return sign.upper() == "NOT" and is_comparison(operand)
    return False


def _are_truth_operands(*operands: s.Expression) -> bool:
    """True if logic in a compiled text may be of truths; otherwise it is vendor text, on bits."""
    for node in operands:
        match node:
            case s.Number(value=value) if value not in (0, 1):
                return False
            case s.Unary():
                return False
            case s.Binary(operator=written) if operator_name(written) not in _TRUTHS:
                return False
    return True


class Expressions:
    """Lift the expressions of one file, and determine their types.

    What has no equivalent raises Unliftable.
    """

    def __init__(self, symbols: Symbols) -> None:
        self.m = symbols

    def type_of(self, node: s.Expression | None) -> ValueType:
        match node:
            case s.String():
                return "text"
            case s.Constant(flags=flags):
                # Without flags a constant may be either; fewer than three values can only be
                # joints.
                return "joints" if flags is None and len(node.values) < 3 else "position"
            case s.Pallet():
                return "position"
            case s.Variable(component=component) if component:
                return "integer" if component.startswith("FL") else "number"
            case s.Variable():
                return self.type_of_name(node)
            case s.Unary(operand=operand):
                return self.type_of(operand)
            case s.Binary(operator=operator, left=left, right=right):
                return of_operation(
                    operator_name(operator), self.type_of(left), self.type_of(right)
                )
            case s.Number(value=value):
                return "integer" if float(value).is_integer() else "number"
        return "number"

    def type_of_name(self, node: s.Variable) -> ValueType:
        key = node.key
        if node.arguments is not None and (known := function(key)) is not None:
            # The vocabulary has one type for all numbers; these results are always whole.
            if key in ("CINT", "FIX", "INT", "LEN", "ASC"):
                return "integer"
            return LETTER_TYPES[known.result[0]]
        if (known_status := status(key)) is not None:
            bits = key in SIGNAL_VARIABLES and SIGNAL_VARIABLES[key][0] != "analog"
            return "integer" if bits else LETTER_TYPES[known_status.type]
        if key in self.m.io and not self.m.is_shadowed(key):
            return "integer"  # of inputs, whatever letter their name begins with
        return self.m.type_of_key(key)

    def is_truth(self, node: s.Expression) -> bool:
        """True if the value is 0 or 1 (or a truth), so that bits and truths are the same."""
        match node:
            case s.Binary(operator=written, left=left, right=right):
                operator = operator_name(written)
                if operator in e.LOGICAL:
                    return self.is_truth(left) and self.is_truth(right)
                return operator in e.RELATIONS
            case s.Variable():
                return self.is_bit(node) or self.type_of(node) == "truth" or self.m.own
            case s.Unary():
                return self.m.own or is_comparison(node)
        return self.m.own

    def is_bit(self, node: s.Expression) -> bool:
        if not isinstance(node, s.Variable) or node.component:
            return False
        known = SIGNAL_VARIABLES.get(node.key) if node.arguments else None
        if known is not None:
            return known[0] == "digital"
        return node.key in self.m.io and self.m.io[node.key][0] == 1

    def joins_bits(self, left: s.Expression, right: s.Expression) -> bool:
        """True if logic between two values works on the bits of numbers.

        In a compiled text 0 and 1 may be truths, and so may the result of a function.
        """
        sides = (left, right)
        if any(is_comparison(node) for side in sides for node in nodes(side)):
            return False
        if any(map(self.is_bit, sides)):  # beside a number that was written here it is one too
            others = [side for side in sides if not self.is_bit(side)]
            return self.m.own and any(map(self._is_plain_number, others))
        kinds = [self.type_of(side) for side in sides]
        if not all(kind in ("number", "integer") for kind in kinds):
            return False
        return not self.m.own or not _are_truth_operands(*sides) or any(map(self._is_number, sides))

    def _is_plain_number(self, node: s.Expression) -> bool:
        """True for a plain number variable, and for a value calculated from numbers."""
        match node:
            case s.Number(value=value):
                return value not in (0, 1)
            case s.Variable() | s.Binary():
                return self.type_of(node) in ("number", "integer") and self._is_number(node)
        return False

    def _is_number(self, node: s.Expression) -> bool:
        """True if a value of a number type is certainly a number."""
        match node:
            case s.Number():
                return False
            case s.Variable() if node.key in self.m.routines:
                return self.m.routines[node.key].result not in (None, "truth")
        return True

    # ------------------------------------------------------------------------- any value

    def of(self, node: s.Expression) -> e.Expression:
        """Lift any value; one that the pseudo-program cannot express becomes vendor text."""
        return self._said(self.plain, node)

    def condition(self, node: s.Expression) -> e.Expression:
        """A value that counts as true or false."""
        return self._said(self.truth, node)

    def _said(
        self, read: Callable[[s.Expression], e.Expression], node: s.Expression
    ) -> e.Expression:
        try:
            return read(node)
        except Unliftable as found:
            # Vendor text is no equivalent for other languages, so the attempt as a whole fails.
            if self.m.telling:
                raise
            return self.verbatim(node, found.reason, read)

    def verbatim(
        self,
        node: s.Expression,
        reason: e.Reason | None = None,
        read: Callable[[s.Expression], e.Expression] | None = None,
    ) -> e.Verbatim:
        """The text of an expression. read: what was tried, and is tried for other languages."""
        upper = self.m.dialect.endswith("-4")
        text = printer.expression(node, upper)
        self.m.in_texts |= {part.key for part in nodes(node) if isinstance(part, s.Variable)}
        effect = effects.of_node(node, text)
        told = None if read is None else self.told(lambda: read(node))
        return e.Verbatim(self.m.dialect, text, reason=reason, effect=effect, told=told)

    def told(self, read: Callable[[], T]) -> T | None:
        """Lift the equivalent of vendor text for other languages; None if it has no equivalent."""
        if self.m.own or self.m.telling:
            return None
        self.m.telling = True
        try:
            made = read()
        except Unliftable:
            return None
        finally:
            self.m.telling = False
        # Vendor text deep inside the result makes it useless to other languages as well.
        return made if all(map(_is_translated, records(made))) else None

    def plain(self, node: s.Expression) -> e.Expression:
        match node:
            case s.Number(value=value):
                return e.Number(value)
            case s.String(value=text):
                return e.Text(text)
            case s.Variable():
                return self.variable(node)
            case s.Unary(operator="-", operand=s.Number(value=value)):
                return e.Number(-value)
            case s.Unary(operator="-", operand=operand):
                return e.Unary("-", self.number(operand))
            case s.Unary(operator="+", operand=operand):
                return self.plain(operand)
            case s.Binary(operator=operator, left=left, right=right):
                return self.binary(operator_name(operator), left, right)
            case s.Constant(flags=flags):
                if flags is None:
                    raise Unliftable
                return e.TargetValue(target_of(node, self.m.robot))
            case s.Pallet(number=number, point=point):
                known = self.m.value(number)
                told = self.m.grids or self.m.telling
                if told and isinstance(known, float) and round(known) in self.m.pallets:
                    return e.Index(pallet_array(round(known), self.m), (self.rounded(point),))
                if isinstance(known, float):
                    return pallet_position(round(known), point, self)
        raise Unliftable

    def number(self, node: s.Expression) -> e.Expression:
        """Lift a value that is not a truth, as the operand of a sum."""
        # Comparisons are numbers in MELFA-BASIC, but truths in the pseudo-program, which adds no
        # truths.
        if not self.m.own and isinstance(node, s.Binary):
            if operator_name(node.operator) in e.RELATIONS:
                raise Unliftable
        return self.plain(node)

    def binary(self, operator: str, left: s.Expression, right: s.Expression) -> e.Expression:
        group = self.group(operator, left, right)
        if group is not None:
            return group
        if operator == "/" and self.is_unit(right):
            return self.plain(left)
        kinds = self.type_of(left), self.type_of(right)
        if not _PLACE_TYPES.isdisjoint(kinds) or isinstance(right, s.Constant):
            return self.placed(operator, left, right)
        if operator in ("<<", ">>") or ("joints" in kinds and not self.m.own):
            raise Unliftable
        if operator in e.LOGICAL:
            if self.joins_bits(left, right):
                return e.Apply(f"bit{operator}", (self.rounded(left), self.rounded(right)))
            if not (self.m.own and _are_truth_operands(left, right)):
                raise Unliftable  # logic of truths is no number
        operand = self.rounded if operator in _INTEGER_OPERATORS else self.number
        return timer_in_seconds(operator, operand(left), operand(right), MILLISECONDS)

    def group(self, operator: str, left: s.Expression, right: s.Expression) -> e.Name | None:
        """`M_In8(5) And &H0F`: a group of fewer bits than the variable has."""
        match operator, left, right:
            case "and", s.Variable(arguments=(first,)), s.Number(value=mask) if (
                left.key in SIGNAL_VARIABLES
            ):
                kind, direction, width = SIGNAL_VARIABLES[left.key]
                number, bits = self.m.value(first), int(mask).bit_length()
                plain = mask == (1 << bits) - 1 and 0 < bits < width
                if kind == "group" and plain and isinstance(number, float):
                    return e.Name(self.m.signal_at(kind, direction, bits, round(number)))
        return None

    # ---------------------------------------------------------------------------- truths

    def truth(self, node: s.Expression) -> e.Expression:
        """A condition. Other than truths, MELFA-BASIC's own logic works on bits."""
        match node:
            case s.Binary(
                "=", s.Variable(key="M_MOTRG", arguments=(s.Number() as number,)), s.Number() as on
            ) if self.m.telling:
                return self.triggered(round(number.value), bool(on.value))
            case s.Binary(operator=written, left=left, right=right):
                operator = operator_name(written)
                if operator in e.LOGICAL and self.group(operator, left, right) is None:
                    if operator == "or" and not self.m.own:  # a bit is set where one has one
                        return e.Binary("or", self.nonzero(left), self.nonzero(right))
                    # Logic of numbers joins their bits, and counts as true if any bit is left.
                    if not self.m.own and self.joins_bits(left, right):
                        return e.Binary("<>", self.plain(node), e.Number(0))
                    if not (self.is_truth(left) and self.is_truth(right)):
                        raise Unliftable
                    return e.Binary(operator, self.truth(left), self.truth(right))  # type: ignore[arg-type]
                if operator in e.RELATIONS:
                    return self.binary(operator, left, right)
            case s.Number(value=value) if not self.m.own:
                return e.Truth(value != 0)
            case s.Unary(operator=sign, operand=operand) if sign.upper() == "NOT":
                # `Not` inverts all bits: `Not 1` is -2, which counts as true again.
                if not is_comparison(operand):
                    raise Unliftable  # of bits
                return e.Unary("not", self.truth(operand))
        plain = self.plain(node)
        if self.m.own or self.type_of(node) == "truth":
            return plain
        if self.is_bit(node):
            return e.Binary("=", plain, e.Number(1))
        if self.type_of(node) not in ("number", "integer"):
            raise Unliftable
        return e.Binary("<>", plain, e.Number(0))

    def triggered(self, number: int, wanted: bool) -> e.Expression:
        """True if a Mo trigger is watched and its condition holds."""
        if number not in self.m.mo_triggers:
            raise Unliftable(CONTROLLER_STATE)
        name, condition = self.m.mo_triggers[number]
        watched = e.Binary("=", e.Name(name), e.Number(1))
        holds = e.Binary("and", watched, self.truth(condition))
        return holds if wanted else e.Unary("not", holds)

    def nonzero(self, node: s.Expression) -> e.Expression:
        """Lift the test of a truth or number for any set bit."""
        if self.is_truth(node) or is_comparison(node):
            return self.truth(node)
        if self.type_of(node) not in ("number", "integer"):
            raise Unliftable
        return e.Binary("<>", self.rounded(node), e.Number(0))

    # -------------------------------------------------------------------------- variables

    def variable(self, node: s.Variable) -> e.Expression:
        if node.component:
            return self.component(node)
        key = node.key
        # The name of a `Def Io` reads inputs; only an assignment reaches the outputs.
        if key in self.m.io and not self.m.is_shadowed(key):
            return e.Name(self.m.io_signal(node, "input"))
        inside = self.m.inside
        # In its own body, a function's name without arguments is the variable of its result.
        if inside is not None and key == inside.key and node.arguments is None:
            if inside.result is None:
                raise Unliftable
            return e.Name(inside.result)
        if key in self.m.routines and not self.m.is_shadowed(key):
            return self.applied(node)
        if node.arguments is not None:
            return self.called(node, key)
        if key in _ROBOT_POSITIONS:
            return self.here(key)
        if key in _CLOCK and node.arguments is None:
            return e.Apply(_CLOCK[key])
        if key == "M_NSPD" and self.m.telling:
            return e.number_of(OPTIMUM_SPEED)
        if key == "M_SPD" and self.m.telling:
            return self.speed()
        if key == "P_ZERO" and self.m.telling:
            return self.m.value_of(_ZERO_POSITION, "position")
        return _STATUS_NUMBERS.get(key) or self.m.name(node)

    def speed(self) -> e.Expression:
        """The speed that `Spd` has set last, in mm/s."""
        match self.m.speed:
            case float(value) | int(value):
                return e.number_of(OPTIMUM_SPEED if math.isinf(value) else float(value))
            case str(name):
                return e.Name(name)
        raise Unliftable(SETTINGS_DIFFER)

    def here(self, key: str) -> e.Expression:
        """Lift the robot's present position, under the active tool and base."""
        if key in ("J_CURR", "J_FBC"):
            if key == "J_FBC" and not self.m.telling:
                raise Unliftable(CONTROLLER_STATE)
            return e.Apply("joints_here")
        tool, frame = self.m.placing_told if self.m.telling else self.m.placing
        if not isinstance(tool, str) or not isinstance(frame, str):
            raise Unliftable(SETTINGS_DIFFER)
        return e.Here(tool, frame)

    def applied(self, node: s.Variable) -> e.Expression:
        """A call of a function of the user's own."""
        routine = self.m.routines[node.key]
        given = node.arguments or ()
        if routine.parameters is None or routine.result is None:
            raise Unliftable
        name = self.m.variants.get(node.key, routine.name)
        return e.Apply(name, self.arguments(routine.parameters, given))

    def arguments(self, parameters: Any, given: Any) -> tuple[e.Expression, ...]:
        if len(parameters) != len(given) or any(a is None for a in given):
            raise Unliftable
        if any(self.extents(a) != q.dimensions for q, a in zip(parameters, given, strict=True)):
            raise Unliftable
        made = tuple(self.number(a) for a in given)
        for parameter, value in zip(parameters, made, strict=True):
            if parameter.mode == "inout" and not isinstance(value, e.Name | e.Member | e.Index):
                raise Unliftable
        return made

    def extents(self, node: s.Expression) -> int:
        """Return the number of extents of a value: 0 for all but a complete array."""
        match node:
            case s.Variable(arguments=None, component=""):
                return len(self.m.size_of(node.key))
        return 0

    def component(self, node: s.Variable) -> e.Expression:
        """X, Y, Z in mm, as axes that slide; joints that turn are read in radian."""
        whole = s.Variable(node.name, node.suffix, node.arguments)
        if node.component in ADDITIONAL:
            if not (self.m.own or self.m.telling):
                raise Unliftable(SLIDING_AXIS)
            return e.Member(self.variable(whole), ADDITIONAL[node.component])
        if is_length(node.component, self.m.robot):
            return e.Member(self.variable(whole), node.component.lower())
        if is_angle(node.component, self.m.robot) and not self.m.own:
            return e.Binary("*", self.degrees(node), e.Number(e.DEGREE))
        raise Unliftable

    def called(self, node: s.Variable, key: str) -> e.Expression:
        """An element of an array, a signal, or a function of the language."""
        arguments = node.arguments or ()
        if any(a is None for a in arguments):
            raise Unliftable
        values = [a for a in arguments if a is not None]
        if self.m.size_of(key):
            indices = tuple(self.rounded(v) for v in values)
            whole = self.m.name(s.Variable(node.name, node.suffix))
            return e.Index(whole, indices)
        if key in SIGNAL_VARIABLES and len(values) == 1:
            number = self.m.value(values[0])
            if isinstance(number, float):
                return e.Name(self.m.signal(key, round(number)))
            if self.m.telling:
                return e.Apply(VENDOR_ONLY_NAME.format(key), (self.rounded(values[0]),))
            raise Unliftable(COMPUTED_SIGNAL)
        if key in CONTROLLER_STATES and len(values) == 1:
            return self.m.state(key)
        if key == CONNECTION_STATUS.upper() and len(values) == 1:
            number = self.m.value(values[0])
            if not isinstance(number, float) or round(number) not in FILE_NUMBERS:
                raise Unliftable
            return e.Apply("connected", (e.Text(name_of_channel(round(number))),))
        if (timer := _elapsed_timer(node, self.m.timers)) is not None:
            return e.Binary("*", timer, e.Number(MILLISECONDS))
        if key in _ROBOT_POSITIONS and values == [s.Number(1)]:
            return self.here(key)
        if key in _NAMES_OF_ANGLES and len(values) == 1:
            return e.Apply(_NAMES_OF_ANGLES[key], (self.degrees(values[0]),))
        if key == "DEG" and len(values) == 1:
            return self.degrees(values[0])
        if key == "RAD" or (key in _NAMES_TO_ANGLES and not self.m.own):
            return e.Binary("*", self.degrees(node), e.Number(e.DEGREE))
        if key in ("SETJNT", "SETPOS") and self.m.telling:
            return self.built(key, values)
        if key == "INV" and (pose := constant_pose(node, self.m)) is not None:
            return e.TargetValue(Target(pose))
        bare = self.m.own or (self.m.telling and self.m.placing == (FLANGE, BASE))
        if (
            name := _SAME_UNIT_NAMES.get(key) or (_ARM_NAMES.get(key) if bare else None)
        ) is not None:
            return e.Apply(name, tuple(self.number(v) for v in values))
        if self.m.telling:
            return _library_function(key, values, self)
        raise Unliftable

    def built(self, key: str, given: list[s.Expression]) -> e.Expression:
        """The joints or the position of `SetJnt` and `SetPos`.

        Joints of numbers that are known; further elements of a position may be 0.
        """
        if self.five_axis:
            raise Unliftable(BUILT_POSITION)
        if key == "SETPOS" and all(value == s.Number(0) for value in given[len(JOINTS) :]):
            given = given[: len(JOINTS)]
        made = built_joints(given, self) if key == "SETJNT" else built_position(given, self)
        if made is None and key == "SETPOS" and len(given) == len(JOINTS):
            return computed_position(given, self)
        if made is None or len(given) != len(JOINTS):
            raise Unliftable(BUILT_POSITION)
        constant = s.Constant(made, None if key == "SETJNT" else (None, None))
        return self.m.value_of(constant, "joints" if key == "SETJNT" else "position")

    def rounded(self, node: s.Expression) -> e.Expression:
        """A subscript or another value that is rounded if it is not known to be whole."""
        value = self.number(node)
        if self.m.own or self.type_of(node) == "integer":
            return value
        return e.Apply("round", (value,))

    def is_unit(self, node: s.Expression) -> bool:
        """True for one mm or degree of an additional axis, in a compiled text."""
        match node:
            case s.Variable(component=component) if self.m.own and component in ADDITIONAL:
                whole = self.variable(s.Variable(node.name, node.suffix, node.arguments))
                return isinstance(whole, e.TargetValue) and is_units(whole.target)
        return False

    # ----------------------------------------------------------------------------- angles

    def degrees(self, node: s.Expression) -> e.Expression:
        """The degrees of a value that is an angle in radian."""
        match node:
            case s.Variable(key="RAD", arguments=(inner,)) if inner is not None:
                return self.number(inner)
            case s.Variable(component=component) if is_angle(component, self.m.robot):
                whole = s.Variable(node.name, node.suffix, node.arguments)
                if component not in (*JOINTS, *_ANGLES):
                    raise Unliftable
                return e.Member(self.variable(whole), _ANGLES.get(component, component.lower()))
            case s.Variable(arguments=tuple(given)) if (
                node.key in _NAMES_TO_ANGLES and not node.component
            ):
                values = tuple(self.number(a) for a in given if a is not None)
                return e.Apply(_NAMES_TO_ANGLES[node.key], values)
        if self.m.own:
            return e.Binary("/", self.number(node), e.Number(e.DEGREE))
        match node:
            case s.Number(value=value):
                return e.Number(math.degrees(value) if value else 0)
            case s.Unary(operator="-", operand=operand):
                turned = self.degrees(operand)
                if isinstance(turned, e.Number):
                    return e.Number(-turned.value)
                return e.Unary("-", turned)
            # Each term is converted alone, so that `Rad(10)` in a sum becomes plain 10.
            case s.Binary(operator=("+" | "-") as sign, left=left, right=right):
                return e.Binary(sign, self.degrees(left), self.degrees(right))
            case s.Binary(operator=("*" | "/") as sign, left=left, right=right) if self.is_angle(
                left
            ):
                return e.Binary(sign, self.degrees(left), self.number(right))
        return e.Binary("/", self.number(node), e.Number(e.DEGREE))

    def is_angle(self, node: s.Expression) -> bool:
        """True for a value that MELFA-BASIC gives in radian."""
        if not isinstance(node, s.Variable):
            return False
        if is_angle(node.component, self.m.robot):
            return True
        return node.key == "RAD" or node.key in _NAMES_TO_ANGLES

    # --------------------------------------------------------------------------- positions

    def placed(self, operator: str, left: s.Expression, right: s.Expression) -> e.Expression:
        """A position moved by a constant; a product of positions."""
        if operator == "*" and (is_inverse(left) or is_inverse(right)):
            if (pose := constant_pose(s.Binary("*", left, right), self.m)) is not None:
                return e.TargetValue(Target(pose))
        constant = constant_shift(right, self.m)
        if operator in "+-*" and constant is not None and self.type_of(left) == "position":
            # Angles that are added are not a rotation: other languages get the sum element by
            # element.
            turns = operator != "*" and any(constant.values[3:6])
            if not (turns and self.m.telling):
                given = shift_amounts(operator, constant, self.m)
                name = "relative" if operator == "*" else "offset"
                return e.Apply(name, (self.plain(left), *map(e.Number, given)))
        positions = {self.type_of(left), self.type_of(right)} <= _PLACE_TYPES
        if operator == "*" and positions and self.m.own:
            return e.Binary("@", self.plain(left), self.plain(right))
        if self.m.telling and not self.five_axis:
            if operator == "*" and positions:
                return position_product(self.plain(left), right, self)
            if operator in ("+", "-", "*", "/") and self.type_of(left) == "position":
                return elementwise_position(s.Binary(operator, left, right), self)
        raise Unliftable

    @property
    def five_axis(self) -> bool:
        return self.m.robot is not None and self.m.robot.five_axis


def file_timers(code: Sequence[s.Entry], header: Header, own: bool) -> dict[int, str]:
    """Names of the timers, by number, that are set to zero and read in values and conditions.

    Any other use of a timer, such as in an interrupt or another value, keeps all its lines as
    they are. One that a wait with a time limit has made for itself is no timer of the program.
    """
    if own:
        return {int(k): name for k, name in header.names["timer"].items() if k.isdigit()}
    started: set[int] = set()
    other: set[int] = set()
    for at, item in enumerate(code):
        numbers = map(timer_number, nodes(item.statement))
        mentioned = [n for n in numbers if n is not None]
        if not mentioned:
            continue
        if 0 in mentioned:  # any timer
            return {}
        plain = list(_statement_timers(item.statement))
        of_wait = at + 1 < len(code) and _is_waiting_line(code[at + 1])
        started.update(n for n, starts in plain if starts and not of_wait)
        if of_wait or sorted(mentioned) != sorted(n for n, _ in plain):
            other.update(mentioned)
    return {n: f"timer_{n}" for n in sorted(started - other) if n <= MOST_TIMERS}


def _is_waiting_line(line: s.Entry) -> bool:
    return line.label is not None and line.label[:1] == "W" and line.label[1:].isdigit()


def _statement_timers(statement: Any) -> Iterator[tuple[int, bool]]:
    """Timers of a statement where the pseudo-program has them, and whether it starts them."""
    match statement:
        case s.Assign(target=target, value=value, delay=None) if n := timer_number(target):
            if literal(value) == 0:
                yield n, True
        case s.Assign(value=value):
            yield from _timers_read(value)
        case s.If(condition=condition, then=then, otherwise=otherwise):
            yield from _timers_read(condition)
            yield from _statement_timers(then)
            yield from _statement_timers(otherwise)
        case s.ElseIf(condition=value):
            yield from _timers_read(value)
        case s.Command(keyword="While" | "Wait" | "Dly", arguments=(value,)):
            yield from _timers_read(value)


def _timers_read(value: Any) -> Iterator[tuple[int, bool]]:
    for node in nodes(value):
        if number := timer_number(node):
            yield number, False


def _elapsed_timer(node: s.Expression, timers: Mapping[int, str]) -> e.Elapsed | None:
    """The timer that a node reads."""
    name = timers.get(timer_number(node) or 0)
    return None if name is None else e.Elapsed(name)


def seconds_of(milliseconds: float) -> e.Number:
    return e.number_of(milliseconds / MILLISECONDS)


class _ArgumentReader(Protocol):
    """Lift of the expressions of a file."""

    m: Symbols

    def plain(self, node: s.Expression) -> e.Expression:
        """Any value."""

    def number(self, node: s.Expression) -> e.Expression:
        """Lift a value that is not a truth."""

    def rounded(self, node: s.Expression) -> e.Expression:
        """One that is whole."""

    def type_of(self, node: s.Expression | None) -> ValueType:
        """Its type."""


def _library_function(
    key: str, given: Sequence[s.Expression], lift: _ArgumentReader
) -> e.Expression:
    """Lift a call of a function: to plain words, an input, or mostly a procedure of the library.

    key: in upper case. Raises Unliftable if the function has no equivalent.
    """
    match key, given:
        case "LEFT", (whole, s.Number(count) as number) if count >= 1:
            return e.Apply("part", (lift.plain(whole), e.Number(1), lift.rounded(number)))
        # The text is named twice in the result, so it has to be a variable that reads the same
        # twice.
        case "RIGHT", (s.Variable(arguments=None) as whole, s.Number(count)) if count >= 1:
            text, last = lift.plain(whole), round(count)
            first = e.Binary("-", e.Apply("length", (text,)), e.Number(last - 1))
            return e.Apply("part", (text, first, e.Number(last)))
        case "M_HNDCQ", (hand,) if isinstance(known := lift.m.value(hand), float):
            if 1 <= round(known) <= HAND_CHECKS:
                return e.Name(lift.m.signal("M_IN", FIRST_HAND_CHECK - 1 + round(known)))
        case "ZONE", (_, _, _):
            elements = (
                e.Member(_position_with_elements(one, lift), field)
                for one in given
                for field in POSE_FIELDS
            )
            return e.Apply(VENDOR_ONLY_NAME.format("in_box"), tuple(elements))
    name = LIBRARY_FUNCTIONS.get(key, {}).get(len(given))
    if name is None:
        raise Unliftable
    kinds = [one.type for one in library()[name].parameters]
    if any(
        (kind == "position") != (lift.type_of(value) == "position")
        for kind, value in zip(kinds, given, strict=True)
    ):
        raise Unliftable
    values = (
        lift.rounded(value) if kind == "integer" else lift.number(value)
        for kind, value in zip(kinds, given, strict=True)
    )
    return e.Apply(VENDOR_ONLY_NAME.format(name), tuple(values))


def _position_with_elements(node: s.Expression, lift: _ArgumentReader) -> e.Expression:
    """A position whose elements can be named."""
    made = lift.plain(node)
    if lift.type_of(node) != "position" or not isinstance(made, e.Name | e.Index | e.Here):
        raise Unliftable
    return made


T = TypeVar("T")

# PLAIN, OF_ANGLE and TO_ANGLE are read backwards here: one row adds a function both ways.
_SAME_UNIT_NAMES: Final = {melfa.upper(): name for name, melfa in SAME_UNIT_FUNCTIONS.items()}
_NAMES_OF_ANGLES: Final = {melfa.upper(): name for name, melfa in FUNCTIONS_OF_ANGLES.items()}
_ARM_NAMES: Final = {melfa.upper(): name for name, melfa in ARM_FUNCTIONS.items()}
_NAMES_TO_ANGLES: Final = {melfa.upper(): name for name, melfa in FUNCTIONS_TO_ANGLES.items()}
_CLOCK: Final = {
    melfa.upper(): name for name, melfa in STATUS_FUNCTIONS.items() if melfa != "J_Curr"
}
_PLACE_TYPES: Final = frozenset(("position", "pose"))
"""Types of located values; the product of two places the second in the first."""
_ANGLES: Final = {melfa: name for name, melfa in ANGLES.items()}
ADDITIONAL: Final = {melfa: name for name, written in poses.ADDITIONAL.items() for melfa in written}
_STATUS_NUMBERS: Final = {
    "M_ON": e.Number(1),
    "M_OFF": e.Number(0),
    "M_PI": e.Number(math.pi),
    **{key: e.Number(round(value)) for key, value in INITIAL_STATUS.items()},
}
"""Values of status variables that never change."""
_ZERO_POSITION: Final = s.Constant((0.0,) * 6, (0, 0))
"""Value of `P_Zero`."""
_ROBOT_POSITIONS: Final = ("P_CURR", "P_FBC", "J_CURR", "J_FBC")
"""Status variables of where the robot stands, as commanded or as measured."""


def _is_translated(record: Any) -> bool:
    """True if a record holds no vendor text and calls no function of the user: its name may still
    change.
    """
    match record:
        case e.Apply(function):
            return function in e.FUNCTIONS or function.startswith(VENDOR_ONLY_NAME.format(""))
    return not isinstance(record, e.Verbatim)
