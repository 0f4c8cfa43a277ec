"""Expressions of MELFA-BASIC as the pseudo-program says them."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, Final, TypeVar

from assistant.languages.melfa_basic.lift.values.constants import INITIAL_STATUS
from assistant.languages.melfa_basic.lift.values.elementwise import (
    built_joints,
    built_position,
    computed_position,
    elementwise_position,
    position_product,
)
from assistant.languages.melfa_basic.lift.values.moved_targets import (
    constant_pose,
    constant_shift,
    is_inverse,
    shift_amounts,
)
from assistant.languages.melfa_basic.lift.values.operators import (
    INTEGER_OPERATORS,
    are_truth_operands,
    is_comparison,
    operator_name,
)
from assistant.languages.melfa_basic.lift.values.pallets import pallet_array, pallet_position
from assistant.languages.melfa_basic.lift.values.reasons import (
    BUILT_POSITION,
    COMPUTED_SIGNAL,
    SLIDING_AXIS,
)
from assistant.languages.melfa_basic.lift.values.supplied import library_function
from assistant.languages.melfa_basic.lift.values.symbols import (
    CONTROLLER_STATES,
    SIGNAL_VARIABLES,
    VENDOR_ONLY_NAME,
    Unliftable,
)
from assistant.languages.melfa_basic.lift.values.timers import elapsed_timer
from assistant.languages.melfa_basic.lift.values.types import Types
from assistant.languages.melfa_basic.tables import poses
from assistant.languages.melfa_basic.tables.channels import CONNECTION_STATUS, FILE_NUMBERS
from assistant.languages.melfa_basic.tables.functions import (
    ARM_FUNCTIONS,
    FUNCTIONS_OF_ANGLES,
    FUNCTIONS_TO_ANGLES,
    SAME_UNIT_FUNCTIONS,
    STATUS_FUNCTIONS,
)
from assistant.languages.melfa_basic.tables.poses import (
    ANGLES,
    JOINTS,
    is_angle,
    is_length,
    is_units,
)
from assistant.languages.melfa_basic.tables.vocabulary.timers import MILLISECONDS
from assistant.languages.melfa_basic.tables.words import OPTIMUM_SPEED
from assistant.languages.melfa_basic.text import effects, printer
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.positions import target_of
from assistant.languages.melfa_basic.tree.walk import nodes
from assistant.languages.vendor_statements import CONTROLLER_STATE, SETTINGS_DIFFER
from assistant.program import expressions as e
from assistant.program.geometry import BASE, FLANGE, Target
from assistant.program.rewriting import records
from assistant.program.undeclared_names import name_of_channel, timer_in_seconds

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
"""Types of what stands somewhere, of which a product is one that stands in another."""
_ANGLES: Final = {melfa: name for name, melfa in ANGLES.items()}
ADDITIONAL: Final = {melfa: name for name, written in poses.ADDITIONAL.items() for melfa in written}
_STATUS_NUMBERS: Final = {
    "M_ON": e.Number(1),
    "M_OFF": e.Number(0),
    "M_PI": e.Number(math.pi),
    **{key: e.Number(round(value)) for key, value in INITIAL_STATUS.items()},
}
"""What status variables that never change are."""
ZERO_POSITION: Final = s.Constant((0.0,) * 6, (0, 0))
"""Value of `P_Zero`."""
_ROBOT_POSITIONS: Final = ("P_CURR", "P_FBC", "J_CURR", "J_FBC")
"""Status variables of where the robot stands, as commanded or as measured."""
DEGREE: Final = math.pi / 180.0


class Expressions(Types):
    """Lifts the expressions of one file; what it has no words for raises Unliftable."""

    # ------------------------------------------------------------------------- any value

    def of(self, node: s.Expression) -> e.Expression:
        """Any value; what the pseudo-program cannot say stays as its text."""
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
        """What other languages are told of what stays as its text; None if that is nothing."""
        if self.m.own or self.m.telling:
            return None
        self.m.telling = True
        try:
            made = read()
        except Unliftable:
            return None
        finally:
            self.m.telling = False
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
        """A value that is no truth, as the operand of a sum."""
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
            if not (self.m.own and are_truth_operands(left, right)):
                raise Unliftable  # logic of truths is no number
        operand = self.rounded if operator in INTEGER_OPERATORS else self.number
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
        """Whether a bit of a truth or number is set."""
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
        if key in self.m.io and not self.m.is_shadowed(key):
            return e.Name(self.m.io_signal(node, "input"))
        inside = self.m.inside
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
            return self.m.value_of(ZERO_POSITION, "position")
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
        """Where the robot stands, seen with the tool and base that hold."""
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
        """How many extents a value has: none but that of a whole array."""
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
            return e.Binary("*", self.degrees(node), e.Number(DEGREE))
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
        if (timer := elapsed_timer(node, self.m.timers)) is not None:
            return e.Binary("*", timer, e.Number(MILLISECONDS))
        if key in _ROBOT_POSITIONS and values == [s.Number(1)]:
            return self.here(key)
        if key in _NAMES_OF_ANGLES and len(values) == 1:
            return e.Apply(_NAMES_OF_ANGLES[key], (self.degrees(values[0]),))
        if key == "DEG" and len(values) == 1:
            return self.degrees(values[0])
        if (key in _NAMES_TO_ANGLES or key == "RAD") and not self.m.own:
            return e.Binary("*", self.degrees(node), e.Number(DEGREE))
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
            return library_function(key, values, self)
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
        """Whether it is one mm or degree of an additional axis, in a text that was written here."""
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
            raise Unliftable
        match node:
            case s.Number(value=value):
                return e.Number(math.degrees(value) if value else 0)
            case s.Unary(operator="-", operand=operand):
                turned = self.degrees(operand)
                if isinstance(turned, e.Number):
                    return e.Number(-turned.value)
                return e.Unary("-", turned)
            case s.Binary(operator=("+" | "-") as sign, left=left, right=right):
                return e.Binary(sign, self.degrees(left), self.degrees(right))
            case s.Binary(operator=("*" | "/") as sign, left=left, right=right) if self.is_angle(
                left
            ):
                return e.Binary(sign, self.degrees(left), self.number(right))
        return e.Binary("/", self.number(node), e.Number(DEGREE))

    def is_angle(self, node: s.Expression) -> bool:
        """Whether it is of the kind that comes in radian."""
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


def _is_translated(record: Any) -> bool:
    """Whether a record keeps no text, and calls nothing of the user's: its name may yet change."""
    match record:
        case e.Apply(function):
            return function in e.FUNCTIONS or function.startswith(VENDOR_ONLY_NAME.format(""))
    return not isinstance(record, e.Verbatim)
