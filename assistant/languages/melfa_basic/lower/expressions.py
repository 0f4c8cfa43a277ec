"""Expressions of the pseudo-program as MELFA-BASIC says them."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

import numpy as np

from assistant.languages.melfa_basic import poses
from assistant.languages.melfa_basic import syntax as s
from assistant.languages.melfa_basic.dialects import Dialect
from assistant.languages.melfa_basic.names import Names
from assistant.program import expressions as e
from assistant.program.geometry import JointTarget, Target
from assistant.program.path import configuration_row
from assistant.program.program import Procedure, Program, Signal

if TYPE_CHECKING:
    from assistant.robots import Robot


class Unsayable(Exception):
    """MELFA-BASIC has no words for it."""

    def __init__(self, what: str, cure: str) -> None:
        super().__init__(what)
        self.what, self.cure = what, cure


PLAIN: Final = {
    "abs": "Abs", "sqrt": "Sqr", "exp": "Exp", "ln": "Ln", "round": "CInt", "trunc": "Fix",
    "floor": "Int", "min": "Min", "max": "Max", "length": "Len", "distance": "Dist",
    "inverse": "Inv", "text": "Str",
}  # fmt: skip
"""Functions that take and give the same units."""
OF_ANGLE: Final = {"sin": "Sin", "cos": "Cos", "tan": "Tan"}
TO_ANGLE: Final = {"atan": "Atn", "atan2": "Atn2", "asin": "ASin", "acos": "ACos"}

OPERATORS: Final = {"div": "\\", "mod": "MOD", "and": "AND", "or": "OR", "xor": "XOR", "@": "*"}
RELATIONS: Final = ("=", "<>", "<", "<=", ">", ">=")


@dataclass(slots=True)
class Inline:
    """Positions and joints that stand for a value of an expression."""

    positions: list[tuple[int, Target]] = field(default_factory=list)
    joints: list[tuple[int, JointTarget]] = field(default_factory=list)


@dataclass(slots=True)
class Expressions:
    """Lowers the expressions of one unit; raises Unsayable.

    next_number: gives a position or joint variable of its own for a value.
    """

    program: Program
    dialect: Dialect
    names: Names
    robot: Robot | None
    next_number: Callable[[], int]
    procedure: Procedure | None = None
    inline: Inline = field(default_factory=Inline)

    def word(self, text: str) -> str:
        return text.upper() if self.dialect.upper else text

    def call(self, function: str, *arguments: s.Expression) -> s.Variable:
        suffix = "$" if function == "Str" else ""
        return s.Variable(self.word(function), suffix, arguments)

    def of(self, value: e.Expression) -> s.Expression:
        """Any expression but a target."""
        match value:
            case e.Number(value=number):
                return numeric(number)
            case e.Truth(value=truth):
                return s.Number(int(truth))
            case e.Text(value=text):
                return self.text(text)
            case e.Name(name=name):
                return self.name(name)
            case e.TargetValue() | e.JointValue() | e.PoseValue():
                return self.constant(value)
            case e.Member(value=inner, field=component):
                return self.member(inner, component)
            case e.Unary(operator="-", operand=operand):
                return s.Unary("-", self.of(operand))
            case e.Unary(operand=operand):  # any value that is not zero counts as true
                return s.Binary("=", self.of(operand), s.Number(0))
            case e.Binary(operator=operator, left=left, right=right):
                return s.Binary(OPERATORS.get(operator, operator), self.of(left), self.of(right))
            case e.Apply(function=function, arguments=arguments):
                return self.apply(function.lower(), arguments)
            case e.Verbatim(language=language, text=text):
                return self.verbatim(language, text)
        raise Unsayable(
            f"an expression of kind {type(value).__name__}", "write it with single values"
        )

    def text(self, text: str) -> s.String:
        if '"' in text or not text.isprintable() or len(text) > 100:
            raise Unsayable("a text with quotes, line ends or over 100 characters", "shorten it")
        return s.String(text)

    def verbatim(self, language: str, text: str) -> s.Expression:
        from assistant.languages.melfa_basic.parser import statement

        line = statement("M0=" + text) if language.startswith("melfa-basic-") else None
        if line is None or line.comment or not isinstance(line.statement, s.Assign):
            raise Unsayable(f"the {language} expression `{text}`", "write it in plain words")
        return line.statement.value

    def apply(self, function: str, arguments: tuple[e.Expression, ...]) -> s.Expression:
        if function in ("offset", "relative"):
            return self.moved(function, arguments)
        if function == "here" and not arguments:
            return s.Variable(self.word("P_Curr"))
        if function == "joints_here" and not arguments:
            return s.Variable(self.word("J_Curr"))
        values = tuple(self.of(a) for a in arguments)
        if function in PLAIN:
            return self.call(PLAIN[function], *values)
        if function in OF_ANGLE and len(values) == 1:
            return self.call(OF_ANGLE[function], self.call("Rad", *values))
        if function in TO_ANGLE and (self.dialect.inverse_sines or function.startswith("atan")):
            return self.call("Deg", self.call(TO_ANGLE[function], *values))
        raise Unsayable(f"the function `{function}` here", "compute the value another way")

    # --------------------------------------------------------------------------- names

    def name(self, name: str) -> s.Variable:
        short = self.variable(name)
        if short is not None:
            return s.Variable(short, "$" if short.startswith("C") else "")
        key = name.lower()
        for table in (self.names.targets, self.names.joints):
            if key in table:
                return s.Variable(table[key])
        signal = next((v for k, v in self.program.signals.items() if k.lower() == key), None)
        if signal is not None:
            return self.signal(name, signal)
        raise Unsayable(f"`{name}`, which is not declared", "declare it or correct the name")

    def variable(self, name: str) -> str | None:
        owner = self.procedure.name.lower() if self.procedure else ""
        key = name.lower()
        return (
            self.names.variables.get((owner, key))
            or self.names.loops.get((owner, key))
            or self.names.variables.get(("", key))
        )

    def signal(self, name: str, signal: Signal) -> s.Variable:
        """The status variable of a signal; raises Unsayable without a number."""
        if signal.number is None:
            raise Unsayable(f"the signal `{name}` without a number", "number")
        out = signal.direction == "output"
        if signal.kind == "digital":
            word = "M_Out" if out else "M_In"
        elif signal.kind == "group" and signal.bits in self.dialect.groups:
            word = self.dialect.groups[signal.bits][out]
        else:
            widths = ", ".join(str(w) for w in self.dialect.groups)
            raise Unsayable(
                f"the {signal.kind} signal `{name}` of {signal.bits} bits",
                f"use single bits or groups of {widths} bits",
            )
        return s.Variable(self.word(word), "", (s.Number(signal.number),))

    def member(self, inner: e.Expression, component: str) -> s.Expression:
        base = self.of(inner)
        name = component.upper()
        if not isinstance(base, s.Variable) or base.component:
            raise Unsayable("a component of an expression", "assign the expression first")
        whole = s.Variable(base.name, base.suffix, base.arguments, name)
        if name in ("X", "Y", "Z"):
            return whole
        if len(name) == 2 and name[0] == "J" and name[1] in "123456":
            return self.call("Deg", whole)
        raise Unsayable(f"the component `{component}`", "use x, y, z or j1 to j6")

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
        numbers = [plain_number(a) for a in arguments[1:]]
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
            return s.Constant(poses.plain_values(value.pose), (0, 0))
        if isinstance(value, e.JointValue):
            return joint_constant(value.target, self.robot)
        return position_constant(value.target, self.robot)


def numeric(value: float) -> s.Expression:
    """A number with its sign in front; raises Unsayable for what is not finite."""
    if not math.isfinite(value) or abs(value) > 1e30:
        raise Unsayable("a number that is not finite", "correct the number")
    number = s.Number(int(value) if float(value).is_integer() and abs(value) < 1e15 else value)
    if value < 0 or math.copysign(1.0, value) < 0:
        return s.Unary("-", s.Number(abs(number.value))) if value else s.Number(0)
    return number


def plain_number(value: e.Expression) -> float | None:
    """The number of a literal, with or without a sign."""
    match value:
        case e.Number(value=number):
            return float(number)
        case e.Unary(operator="-", operand=e.Number(value=number)):
            return -float(number)
    return None


def position_constant(target: Target, robot: Robot | None) -> s.Constant:
    """A target as `(x,y,z,a,b,c)(fl1,fl2)`."""
    row = np.array([configuration_row(target.configuration)], dtype=np.int8)
    flags = poses.flags_of(row, robot)[0]
    values = poses.to_values(
        np.array([target.pose.position]),
        np.array([target.pose.quaternion]),
        np.array([target.external]),
        robot,
    )[0]
    return s.Constant(tuple(float(v) for v in values), (int(flags[0]), int(flags[1])))


def joint_constant(target: JointTarget, robot: Robot | None) -> s.Constant:
    """A joint target as `(j1, …, j6)`; an arm of five axes keeps the place of J4, as 0."""
    joints = list(target.joints)
    if robot is not None and robot.five_axis and len(joints) == 5:
        joints.insert(3, 0.0)
    joints += [v for v in target.external[:2] if v == v]
    return s.Constant(tuple(round(0.0 if v != v else v, poses.PLACES) + 0.0 for v in joints))
