"""Expressions, constants and channel numbers of MELFA-BASIC; raises Unsayable for what it lacks.

Positions are `(x,y,z,a,b,c)(fl1,fl2)` in mm and degrees, joints `(j1, …, j6)`. The same operators
work on truths and on bits of numbers, so logic is written where all operands are truths: 0, 1 or a
digital signal.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import field
from typing import TYPE_CHECKING, Final

import numpy as np

from assistant.base.data_classes import dataclass
from assistant.languages.melfa_basic.lower.names import Names, mark
from assistant.languages.melfa_basic.reading.line import expression
from assistant.languages.melfa_basic.tables import equivalents, poses, vocabulary
from assistant.languages.melfa_basic.tables.dialects import DIALECTS, Dialect
from assistant.languages.melfa_basic.tables.variables import (
    CONNECTION_STATUS,
    FILE_NUMBERS,
    MILLISECONDS,
    MOST_TIMERS,
    TIMER_WORD,
)
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.walk import timer_variable
from assistant.program import expressions as e
from assistant.program.analysis.declared_types import COMPONENTS, known_types
from assistant.program.geometry import JointTarget, Target
from assistant.program.motion import configuration_row
from assistant.program.program import Procedure, Program, Signal

if TYPE_CHECKING:
    from assistant.robots import Robot


def is_truth(value: e.Expression, signals: Mapping[str, Signal]) -> bool:
    """True if a value is written like a truth: 0, 1 or a digital signal.

    signals: by lower-case name.
    """
    match value:
        case e.Number(number):
            return number in (0, 1)
        case e.Name(name):
            known = signals.get(name.lower())
            return known is not None and known.kind == "digital"
    return False


def position_constant(
    target: Target, robot: Robot | None, places: int = poses.PLACES
) -> s.Constant:
    """A target as `(x,y,z,a,b,c)(fl1,fl2)`, with so many decimals."""
    row = np.array([configuration_row(target.configuration)], dtype=np.int8)
    flags = poses.flags_of(row, robot)[0]
    values = poses.to_values(
        np.array([target.pose.position]),
        np.array([target.pose.quaternion]),
        np.array([target.external]),
        robot,
        places,
    )[0]
    return s.Constant(tuple(float(v) for v in values), (int(flags[0]), int(flags[1])))


def joint_constant(target: JointTarget, robot: Robot | None) -> s.Constant:
    """A joint target as `(j1, …, j6)`; an arm of five axes keeps the place of J4, as 0, and one of
    four those of J5 and J6 if an external axis follows.
    """
    # NaN marks an axis that is not there.
    joints, more = list(target.joints), [v for v in target.external[:2] if v == v]
    if robot is not None and len(joints) == len(robot.axes) < 6:
        row = [0.0] * (6 if more else 1 + max(robot.places))
        for place, value in zip(robot.places, joints, strict=True):
            row[place] = value
        joints = row
    joints += more
    # Adding 0.0 makes 0.0 of -0.0.
    return s.Constant(tuple(round(0.0 if v != v else v, poses.PLACES) + 0.0 for v in joints))


class Unsayable(Exception):
    """MELFA-BASIC has no words for it."""

    def __init__(self, what: str, cure: str = "") -> None:
        super().__init__(what)
        self.what, self.cure = what, cure


class NoNumber(Unsayable):
    """A signal that is known by name only; `what` is the name."""


class Undeclared(Unsayable):
    """A name that stands for nothing; `what` is the name."""


def channel_number(names: Names, channel: str) -> int:
    """The number of the file that a channel is; raises Unsayable for one too many."""
    found = names.channels.get(channel.lower())
    if found is None:
        raise Unsayable(f"the channel `{channel}` beside {len(FILE_NUMBERS)} others", "use fewer")
    return found


def asked_channel(names: Names, function: str, arguments: tuple[e.Expression, ...]) -> int | None:
    """The number of the file whose connection a function asks for, None for another function.

    Raises Unsayable where a text of a channel stands inside an expression.
    """
    if function in e.TAKING:
        raise Unsayable("a text of a channel inside an expression", "assign it to a variable")
    match function, arguments:
        case "connected", (e.Text(channel),):
            return channel_number(names, channel)
    return None


_FARTHEST_NUMBER: Final = 1e6
"""mm or degrees: a larger number says elsewhere that an axis is not there."""
_LONGEST_TEXT: Final = 127
"""Characters of a text."""


@dataclass(slots=True)
class InlineConstants:
    """Positions and joints that stand for a value of an expression."""

    positions: list[tuple[int, Target]] = field(default_factory=list)
    joints: list[tuple[int, JointTarget]] = field(default_factory=list)
    units: int = 0
    """Number of `poses.UNITS` among them, 0 for none."""


@dataclass(slots=True)
class Expressions:
    """Lowers the expressions of one unit; raises Unsayable.

    next_number: returns the number of a separate position or joint variable for a value.
    """

    program: Program
    dialect: Dialect
    names: Names
    robot: Robot | None
    next_number: Callable[[], int]
    procedure: Procedure | None = None
    inline: InlineConstants = field(default_factory=InlineConstants)
    signals: dict[str, Signal] = field(init=False)
    """By lower-case name."""

    def __post_init__(self) -> None:
        self.signals = {name.lower(): signal for name, signal in self.program.signals.items()}

    def word(self, text: str) -> str:
        return text.upper() if self.dialect.upper else text

    def call(self, function: str, *arguments: s.Expression) -> s.Variable:
        suffix = "$" if function in equivalents.TEXT_FUNCTIONS else ""
        return s.Variable(self.word(function), suffix, arguments)

    def argument(self, value: e.Expression) -> s.Expression:
        """Lower an argument of a procedure; a position gets a variable."""
        if isinstance(value, e.TargetValue | e.JointValue):
            return self.target(value)
        return self.of(value)

    def place(self, value: e.Expression) -> s.Variable:
        """Lower the target of an assignment."""
        if isinstance(value, e.Member):
            return self.component(value.value, value.field)
        place = self.of(value) if isinstance(value, e.Name | e.Index) else None
        if not isinstance(place, s.Variable):
            raise Unsayable("an assignment to an expression", "assign to a variable")
        return place

    def of(self, value: e.Expression) -> s.Expression:
        """Any expression but a target."""
        match value:
            case e.Number(value=number):
                return signed_number(number)
            case e.Truth(value=truth):
                return s.Number(int(truth))
            case e.Text(value=text):
                return self.text(text)
            case e.Name(name=name):
                return self.name(name)
            case e.TargetValue() | e.JointValue() | e.PoseValue():
                return self.constant(value)
            # The controller keeps mm or radian by the kind of the axis; one unit of it gives mm or
            # degrees.
            case e.Member(field=component) if component.lower() in poses.ADDITIONAL:
                place = self.component(value.value, component)
                return s.Binary("/", place, self.unit(component))
            case e.Member(value=inner, field=component):
                whole = self.component(inner, component)
                angle = poses.is_angle(whole.component, self.robot)
                return self.call("Deg", whole) if angle else whole
            case e.Index(value=inner, indices=indices):
                return self.element(inner, indices)
            case e.Unary(operator="-", operand=operand):
                return s.Unary("-", self.of(operand))
            case e.Unary(operand=operand):  # any value that is not zero counts as true
                return s.Binary("=", self.of(operand), s.Number(0))
            case e.Here():  # the tool and frame that hold are those that it names, see Writer
                return s.Variable(self.word("P_Curr"))
            case e.Elapsed(timer=timer):
                return s.Binary("/", self.timer(timer), s.Number(MILLISECONDS))
            case e.Binary("*", e.Elapsed(timer), e.Number(1000)):
                return self.timer(timer)
            # `M_Timer` counts milliseconds: the number is converted where that is exact.
            case e.Binary(operator, e.Elapsed(timer), e.Number(seconds)) if (
                operator in e.RELATIONS and (limit := _milliseconds(seconds)) is not None
            ):
                return s.Binary(operator, self.timer(timer), s.Number(limit))
            case e.Binary(operator, e.Number(seconds), e.Elapsed(timer)) if (
                operator in e.RELATIONS and (limit := _milliseconds(seconds)) is not None
            ):
                return s.Binary(operator, s.Number(limit), self.timer(timer))
            case e.Binary("*", degrees, e.Number(e.DEGREE)):
                return self.call("Rad", self.of(degrees))
            case e.Binary("/", radian, e.Number(e.DEGREE)):
                return self.call("Deg", self.of(radian))
            case e.Binary("@", e.PoseValue(), _) | e.Binary("@", _, e.PoseValue()):
                raise Unsayable("a pose in numbers in a product", "give a variable that value")
            case e.Binary(operator=operator, left=left, right=right):
                sides = self.of(left), self.of(right)
                if operator in e.RELATIONS and any(map(_is_position, sides)):
                    raise Unsayable("a comparison of positions", "compare their components")
                return s.Binary(equivalents.OPERATOR_WORDS[operator], *sides)
            case e.Apply("inverse", (e.Name(name),)) if (base := self.base(name)) is not None:
                return base
            case e.Apply(function=function, arguments=arguments):
                return self.apply(function.lower(), arguments)
            case e.Verbatim():
                return self.verbatim(value)
        raise Unsayable(
            f"an expression of kind {type(value).__name__}", "write it with single values"
        )

    def timer(self, name: str) -> s.Variable:
        """Its milliseconds."""
        number = self.names.timers.get(name.lower())
        if number is None:
            raise Unsayable(f"more than {MOST_TIMERS} timers", "use fewer of them")
        return timer_variable(self.word(TIMER_WORD), number)

    def text(self, text: str) -> s.String:
        if '"' in text or not text.isprintable() or len(text) > _LONGEST_TEXT:
            raise Unsayable(f"a text of over {_LONGEST_TEXT} characters", "shorten it")
        return s.String(text)

    def verbatim(self, value: e.Verbatim) -> s.Expression:
        node = expression(value.text) if value.language in DIALECTS else None
        if node is None:
            what = f"the {value.language} expression `{value.text}`"
            cure = "write it in plain words"
            if value.reason is not None:
                what, cure = f"{what}: {value.reason.why}", value.reason.cure
            raise Unsayable(what, cure)
        return node

    def apply(self, function: str, arguments: tuple[e.Expression, ...]) -> s.Expression:
        if function in ("offset", "relative"):
            return self.moved(function, arguments)
        if function in equivalents.STATUS_FUNCTIONS and not arguments:
            return s.Variable(self.word(equivalents.STATUS_FUNCTIONS[function]))
        if (number := asked_channel(self.names, function, arguments)) is not None:
            return s.Variable(self.word(CONNECTION_STATUS), "", (s.Number(number),))
        callee = self.program.procedure(function)
        if callee is not None and function not in e.FUNCTIONS:
            return self.own(callee, arguments)
        values = tuple(self.of(a) for a in arguments)
        if function in equivalents.BIT_FUNCTIONS and len(values) == 2:
            # Logic of truths alone would be read back as truths, not as bits.
            if all(is_truth(argument, self.signals) for argument in arguments):
                raise Unsayable(f"`{function}` of truths alone", "join them with and, or, xor")
            return s.Binary(equivalents.BIT_FUNCTIONS[function], *values)
        if function in equivalents.SAME_UNIT_FUNCTIONS:
            return self.call(equivalents.SAME_UNIT_FUNCTIONS[function], *values)
        if function in equivalents.ARM_FUNCTIONS and len(values) == 1:  # without a tool, see Writer
            return self.call(equivalents.ARM_FUNCTIONS[function], *values)
        if function in equivalents.FUNCTIONS_OF_ANGLES and len(values) == 1:
            return self.call(equivalents.FUNCTIONS_OF_ANGLES[function], self.call("Rad", *values))
        if (
            word := vocabulary.function(equivalents.FUNCTIONS_TO_ANGLES.get(function, ""))
        ) is not None:
            if self.dialect.level in word.dialects:
                return self.call("Deg", self.call(word.name, *values))
        raise Unsayable(f"the function `{function}` here", "compute the value another way")

    def own(self, callee: Procedure, arguments: tuple[e.Expression, ...]) -> s.Expression:
        """A call of a function of the program, which only MELFA-BASIC VI has."""
        if not self.dialect.functions or callee.result is None:
            raise Unsayable(f"`{callee.name}` inside an expression", "call it before")
        values = tuple(self.argument(a) for a in arguments)
        suffix = "$" if callee.result == "text" else ""
        return s.Variable(self.names.procedures[callee.name.lower()], suffix, values)

    # --------------------------------------------------------------------------- names

    def name(self, name: str) -> s.Expression:
        short = self.variable(name)
        if short is not None:
            return s.Variable(short, mark(short))
        key = name.lower()
        for table in (self.names.targets, self.names.joints):
            if key in table:
                return s.Variable(table[key])
        if key in self.signals:
            return self.signal(name, self.signals[key])
        if key in self.names.tools and self.names.tools[key] not in self.names.numbers:
            return s.Variable(self.names.tools[key])
        if (base := self.base(name)) is not None:
            return self.call("Inv", base)
        raise Undeclared(name)

    def base(self, name: str) -> s.Variable | None:
        """Return the argument of `Base` for a frame, which is its inverse; None for any other
        name.
        """
        known = None if self.names.products else self.names.frames.get(name.lower())
        counted = known in self.names.numbers
        return None if known is None or counted or self.variable(name) else s.Variable(known)

    def element(self, inner: e.Expression, indices: tuple[e.Expression, ...]) -> s.Variable:
        whole = self.of(inner)
        if not isinstance(whole, s.Variable) or whole.component or whole.arguments is not None:
            raise Unsayable("an element of an expression", "assign the expression first")
        return s.Variable(whole.name, whole.suffix, tuple(self.of(i) for i in indices))

    def variable(self, name: str) -> str | None:
        return self.names.variable(self.procedure.name if self.procedure else "", name)

    def signal(self, name: str, signal: Signal) -> s.Expression:
        """The value of a signal; raises NoNumber without a number."""
        variable, mask = self.register(name, signal)
        return variable if mask is None else s.Binary("AND", variable, s.Number(mask, 16))

    def output(self, name: str, value: s.Expression) -> tuple[s.Variable, s.Expression]:
        """What to assign to, and what: the bits beside a group of an odd width stay."""
        signal = self.signals.get(name.lower())
        if signal is None:
            raise Undeclared(name)
        variable, mask = self.register(name, signal)
        if signal.kind == "analog":
            _whole_in_register(name, value)
        if mask is None:
            return variable, value
        width = next(w for w in self.dialect.groups if w >= signal.bits)
        others = s.Binary("AND", variable, s.Number((1 << width) - 1 - mask, 16))
        # A number is known to fit into the group; any other value may have bits beyond it.
        own = value if isinstance(value, s.Number) else s.Binary("AND", value, s.Number(mask, 16))
        return variable, s.Binary("OR", others, own)

    def register(self, name: str, signal: Signal) -> tuple[s.Variable, int | None]:
        """The status variable of a signal, and the bits of it that are the signal if not all."""
        if signal.number is None:
            raise NoNumber(name)
        out = signal.direction == "output"
        mask = None
        if signal.kind == "digital":
            word = "M_Out" if out else "M_In"
        elif signal.kind == "analog":
            if signal.number < equivalents.FIRST_ANALOG_REGISTER:
                raise Unsayable(
                    f"the analog signal `{name}` with the number {signal.number}",
                    f"give the number of its register, {equivalents.FIRST_ANALOG_REGISTER} or more",
                )
            word = equivalents.ANALOG_REGISTERS[out]
        else:
            width = next((w for w in self.dialect.groups if w >= signal.bits), None)
            if width is None:
                raise Unsayable(
                    f"the group signal `{name}` of {signal.bits} bits",
                    f"use groups of at most {max(self.dialect.groups)} bits",
                )
            word = self.dialect.groups[width][out]
            mask = None if width == signal.bits else (1 << signal.bits) - 1
        return s.Variable(self.word(word), "", (s.Number(signal.number),)), mask

    def component(self, inner: e.Expression, component: str) -> s.Variable:
        """A component as the controller keeps it: joints in radians."""
        base = self.of(inner)
        name = poses.ANGLES.get(component.lower(), component.upper())
        if name in poses.ANGLES.values() and not poses.is_angle(name, self.robot):
            raise Unsayable("an angle of a position of an arm of five axes", "state it as a whole")
        if not isinstance(base, s.Variable) or base.component:
            raise Unsayable("a component of an expression", "assign the expression first")
        if component.lower() in poses.ADDITIONAL:
            joints = self.type_of(inner) == "joints"
            name = poses.ADDITIONAL[component.lower()][joints]
            return s.Variable(base.name, base.suffix, base.arguments, name)
        if component.lower() not in COMPONENTS or component.lower() in e.EXTERNAL:
            raise Unsayable(f"the component `{component}`", "use x, y, z, angles or j1 to j6")
        return s.Variable(base.name, base.suffix, base.arguments, name)

    def type_of(self, value: e.Expression) -> str | None:
        """Return the type of a variable, or of an element of one, in the program."""
        if isinstance(value, e.Index):
            return self.type_of(value.value)
        if not isinstance(value, e.Name):
            return None
        procedure = self.procedure or Procedure("", ())
        return known_types(self.program, procedure).get(value.name.lower())

    def unit(self, component: str) -> s.Variable:
        """One mm or degree of an additional axis, as the controller keeps it."""
        # The controller converts the stored 1 as it converts each value of that axis.
        if not self.inline.units:
            self.inline.units = self.next_number()
            self.inline.positions.append((self.inline.units, poses.UNITS))
        return s.Variable(f"P{self.inline.units}", "", None, poses.ADDITIONAL[component.lower()][0])

    def additional(self, value: e.Expression, component: str) -> s.Expression:
        """The place of an additional axis as the controller keeps it."""
        match value:
            case e.Member(inner, name) if name.lower() in poses.ADDITIONAL:
                return self.component(inner, name)
            case e.Number(number) if abs(number) >= _FARTHEST_NUMBER:
                raise Unsayable("that an axis is not there", "state a place of it")
        return s.Binary("*", self.of(value), self.unit(component))

    def angle(self, value: e.Expression) -> s.Expression:
        """Degrees as the controller keeps them, in radian."""
        # A copied angle stays in radian, without the rounding of two conversions.
        if isinstance(value, e.Member):
            whole = self.component(value.value, value.field)
            if poses.is_angle(whole.component, self.robot):
                return whole
        return self.call("Rad", self.of(value))

    # -------------------------------------------------------------------------- targets

    def target(self, value: e.Expression) -> s.Expression:
        """A position to move to: a variable, or one moved by an offset."""
        if isinstance(value, e.TargetValue):
            number = self.next_number()
            self.inline.positions.append((number, value.target))
            return s.Variable(f"P{number}")
        if isinstance(value, e.JointValue):
            number = self.next_number()
            self.inline.joints.append((number, value.target))
            return s.Variable(f"J{number}")
        if isinstance(value, e.PoseValue | e.Number | e.Truth | e.Text | e.Aggregate):
            raise Unsayable(f"a move to a {type(value).__name__}", "move to a target")
        return self.of(value)

    def moved(self, function: str, arguments: tuple[e.Expression, ...]) -> s.Expression:
        """`P+(x,y,z,0,0,0)` in the frame, `P*(x,y,z,a,b,c)` in the tool."""
        numbers = [e.plain_number(a) for a in arguments[1:]]
        shift = [n for n in numbers if n is not None]
        if len(shift) != len(numbers) or len(shift) < 3 or len(shift) > 6:
            raise Unsayable(
                f"`{function}` by values that are computed", "offset by constant numbers"
            )
        shift += [0.0] * (6 - len(shift))
        if sum(v != 0.0 for v in shift[3:]) > 1 or (function == "offset" and any(shift[3:])):
            raise Unsayable("an offset about several axes at once", "turn about one axis at a time")
        base = self.target(arguments[0])
        sign = "+" if function == "offset" else "*"
        return s.Binary(sign, base, s.Constant(tuple(shift)))

    def constant(self, value: e.TargetValue | e.JointValue | e.PoseValue) -> s.Constant:
        """A position or joint constant, as it stands right of `=`."""
        if isinstance(value, e.PoseValue):
            made = s.Constant(poses.plain_values(value.pose), (0, 0))
        elif isinstance(value, e.JointValue):
            made = joint_constant(value.target, self.robot)
        else:
            made = position_constant(value.target, self.robot, poses.FINE_PLACES)
        _need_finite(*(number for number in made.values if number is not None))
        return made


def _is_position(value: s.Expression) -> bool:
    """True for a complete position or joint variable; `P_Curr` is one too."""
    match value:
        case s.Variable(component="", arguments=None):
            return value.name[:1].upper() in ("P", "J")
    return isinstance(value, s.Constant)


def signed_number(value: float) -> s.Expression:
    """A number with its sign in front; raises Unsayable for what is not finite."""
    _need_finite(value)
    # A whole number of that size may not be exact, so its float is written.
    number = s.Number(int(value) if float(value).is_integer() and abs(value) < 1e15 else value)
    # The sign of -0.0 is dropped.
    if value < 0 or math.copysign(1.0, value) < 0:
        return s.Unary("-", s.Number(abs(number.value))) if value else s.Number(0)
    return number


def _need_finite(*values: float) -> None:
    if not all(abs(value) <= 1e30 for value in values):  # nor is a NaN
        raise Unsayable("a number that is not finite", "correct the number")


def _milliseconds(seconds: float) -> float | int | None:
    """Those of a number of seconds, if dividing them gives the same number back."""
    # Rounding takes away the noise of the product; the check then keeps only exact values.
    value = round(seconds * MILLISECONDS, 6)
    if not 0 <= value < 1e12 or value / MILLISECONDS != seconds:
        return None
    return int(value) if float(value).is_integer() else value


def _whole_in_register(name: str, value: s.Expression) -> None:
    """Registers of a field bus hold whole numbers: what they make of others is not documented."""
    number = value.operand if isinstance(value, s.Unary) else value
    if isinstance(number, s.Number) and not float(number.value).is_integer():
        raise Unsayable(
            f"the value {number.value:g} of the analog signal `{name}`, whose register holds whole"
            " numbers",
            "state it as the field bus counts it",
        )
