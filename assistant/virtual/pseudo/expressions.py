"""Values of expressions in a pseudo-program, and storage of variables."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Final

import numpy as np

from assistant.program import expressions as e
from assistant.program.geometry import JointTarget, Pose, Target
from assistant.program.motion import configuration_of, configuration_row
from assistant.robots.program_values import SHIFTS
from assistant.virtual.kernel import kernel
from assistant.virtual.pseudo import machine
from assistant.virtual.pseudo.machine import (
    Fault,
    Machine,
    NotRun,
    Place,
    Value,
    kind_of,
    number_of,
    truth_of,
    whole_of,
)

_CLOCK: Final[Mapping[str, str]] = {"date_today": "%Y/%m/%d", "time_of_day": "%H:%M:%S"}
_Called = Callable[[Machine, str, tuple[e.Expression, ...]], Value | None]


def evaluate(m: Machine, node: e.Expression) -> Value:
    match node:
        case e.Number(value):
            return float(value)
        case e.Truth(value) | e.Text(value):
            return value
        case e.TargetValue(target) | e.JointValue(target):
            return target
        case e.PoseValue(pose):
            return pose
        case e.Aggregate(items):
            return [evaluate(m, item) for item in items]
        case e.Name(name):
            return _named(m, name)
        case e.Member() | e.Index():
            return _part(m, node)
        case e.Unary("-", operand):
            return -number_of(evaluate(m, operand))
        case e.Unary(operand=operand):
            return not truth_of(evaluate(m, operand))
        case e.Binary():
            return _binary(m, node)
        case e.Elapsed(timer):
            if timer.lower() not in m.timers:
                raise Fault(f"the timer `{timer}` was never started")
            return m.task.kernel.now - m.timers[timer.lower()]
        case e.Here(tool, frame):
            return here(m, tool, frame)
        case e.Apply(function, arguments):
            return _apply(m, function, arguments)
        case e.Verbatim(language, text):
            raise NotRun(f"`{text}`, which is {language}")


def numeric(m: Machine, node: e.Expression, what: str = "the value") -> float:
    return number_of(evaluate(m, node), what)


def condition(m: Machine, node: e.Expression) -> bool:
    value = evaluate(m, node)
    return value != 0.0 if isinstance(value, float) else truth_of(value)


def place(m: Machine, node: e.Expression) -> Place:
    """Return the storage of a variable or a part of one."""
    match node:
        case e.Name(name):
            found = m.place(name)
            if found is None:
                raise Fault(f"there is no variable `{name}`")
            return found
        case e.Member(value, field):
            return machine.value_component(place(m, value), field.lower())
        case e.Index(value, indices):
            at = tuple(whole_of(evaluate(m, one), "an index") for one in indices)
            return machine.array_element(place(m, value), at, _name(value))
    raise Fault("a value where a variable is wanted")


def _name(node: e.Expression) -> str:
    return node.name if isinstance(node, e.Name) else "the array"


def _named(m: Machine, name: str) -> Value:
    found = m.place(name)
    if found is not None:
        return found.get()
    if m.is_signal(name):
        return m.read(name)
    raise Fault(f"`{name}` is no variable, target or signal")


def _part(m: Machine, node: e.Member | e.Index) -> Value:
    """A component or element, of a variable or of a value that is worked out."""
    root: e.Expression = node
    while isinstance(root, e.Member | e.Index):
        root = root.value
    if isinstance(root, e.Name):
        return place(m, node).get()
    held = machine.Cell(evaluate(m, node.value))
    whole = machine.place_of(held, "the value")
    if isinstance(node, e.Member):
        return machine.value_component(whole, node.field.lower()).get()
    at = tuple(whole_of(evaluate(m, one), "an index") for one in node.indices)
    return machine.array_element(whole, at, "the array").get()


# ----------------------------------------------------------------------------------- operators


def _binary(m: Machine, node: e.Binary) -> Value:
    left = evaluate(m, node.left)
    if node.operator in _TRUTHS:
        other = condition(m, node.right)
        first = left != 0.0 if isinstance(left, float) else truth_of(left)
        return _TRUTHS[node.operator](first, other)
    right = evaluate(m, node.right)
    if node.operator in EQUAL:
        if isinstance(left, bool) != isinstance(right, bool):
            left, right = float(truth_or(left)), float(truth_or(right))
        if type(left) is not type(right):
            raise Fault(f"{kind_of(left)} is compared with {kind_of(right)}")
        return (left == right) is (node.operator == "=")
    if node.operator == "@":
        return _composed(left, right)
    if node.operator == "+" and isinstance(left, str) and isinstance(right, str):
        return left + right
    if isinstance(left, str) and isinstance(right, str) and node.operator in _ORDERS:
        return _ORDERS[node.operator](left, right)
    if isinstance(left, bool) or isinstance(right, bool):
        left, right = float(truth_or(left)), float(truth_or(right))
    if not isinstance(left, float) or not isinstance(right, float):
        raise Fault(f"`{node.operator}` of {kind_of(left)} and {kind_of(right)}")
    if node.operator in _ORDERS:
        return _ORDERS[node.operator](left, right)
    return _number(node.operator, left, right)


def truth_or(value: Value) -> float:
    """A truth as 1 or 0, beside a number."""
    if isinstance(value, bool):
        return float(value)
    return number_of(value)


def _number(sign: str, left: float, right: float) -> float:
    try:
        found = _NUMBERS[sign](left, right)
    except ZeroDivisionError:
        raise Fault("a division by zero") from None
    except (OverflowError, ValueError):
        raise Fault(f"`{sign}` of {left:g} and {right:g}") from None
    if isinstance(found, complex) or not math.isfinite(found):
        raise Fault(f"`{sign}` of {left:g} and {right:g}")
    return found


def _quotient(left: float, right: float) -> float:
    a, b = whole_of(left, "an operand of div"), whole_of(right, "an operand of div")
    # Division in floats is exact for operands below 2^53; a // b rounds down, not towards 0.
    return float(math.trunc(a / b)) if abs(a) < 2**53 and b else float(a // b)


def _remainder(left: float, right: float) -> float:
    """Return a remainder with the sign of the dividend, as assumed for both vendors' languages."""
    a, b = whole_of(left, "an operand of mod"), whole_of(right, "an operand of mod")
    if b == 0:
        raise ZeroDivisionError
    # fmod keeps the sign of the dividend; + 0.0 turns -0.0 into 0.0.
    return math.fmod(a, b) + 0.0


def _composed(left: Value, right: Value) -> Value:
    match left, right:
        case Pose(), Pose():
            return left @ right
        case Pose(), Target():
            return Target(left @ right.pose, right.configuration, right.external)
        case Target(), (Pose() | Target()):
            other = right if isinstance(right, Pose) else right.pose
            return Target(left.pose @ other, left.configuration, left.external)
    raise Fault(f"`@` of {kind_of(left)} and {kind_of(right)}")


_TRUTHS: Final[Mapping[str, Callable[[bool, bool], bool]]] = {
    "and": operator.and_,
    "or": operator.or_,
    "xor": operator.xor,
}
EQUAL: Final = ("=", "<>")
_ORDERS: Final[Mapping[str, Callable[..., bool]]] = {
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
}
_NUMBERS: Final[Mapping[str, Callable[[float, float], float]]] = {
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
    "/": operator.truediv,
    "div": _quotient,
    "mod": _remainder,
    "^": operator.pow,
}

# ----------------------------------------------------------------------------------- functions


def _apply(m: Machine, name: str, arguments: tuple[e.Expression, ...]) -> Value:
    key = name.lower()
    own = m.program.procedure(name)
    if own is not None:
        from assistant.virtual.pseudo.statements import call

        result = call(m, own, arguments)
        if result is None:
            raise Fault(f"`{name}` gives nothing back")
        return result
    if key == "here":
        tool, frame = (_name(one) for one in arguments)
        return here(m, tool, frame)
    if key == "elapsed" and len(arguments) == 1:
        return evaluate(m, e.Elapsed(_name(arguments[0])))
    if key == "joints_here":
        return joints_here(m)
    if key == "broken_off" and not arguments:
        return float(m.broken_off)
    if key in _CLOCK and not arguments:
        return format(kernel.date_at(m.task.kernel.now), _CLOCK[key])
    values = [evaluate(m, one) for one in arguments]
    if key in SHIFTS and values:
        return _shifted(key, values[0], [number_of(one) for one in values[1:]])
    if key in _OF_ARM and len(values) == 1:
        return _OF_ARM[key](m, values[0])
    function = _FUNCTIONS.get(key)
    if function is None:
        raise NotRun(f"the function `{name}`")
    try:
        return function(*values)
    except (ValueError, ZeroDivisionError, OverflowError):
        raise Fault(f"`{name}` of {', '.join(map(machine.value_text, values))}") from None
    except TypeError:
        raise Fault(f"`{name}` is given {len(values)} arguments") from None


def here(m: Machine, tool: str, frame: str) -> Target:
    """The present target: of the tool in the frame."""
    stands = m.task.kernel.motion.where()
    flange = m.flange if stands is None else stands[0]
    if flange is None:
        raise NotRun("a position that is read while it is not known where the arm is")
    tip, base = m.tool(tool), m.frame(frame)
    if base.held or not tip.held:
        raise NotRun("a position that is read with a tool that stands in the room")
    return Target(base.pose.inverse() @ flange @ tip.tip)


def _flange_at(m: Machine, value: Value) -> Target:
    """Return the flange pose at joints, in their configuration."""
    if not isinstance(value, JointTarget):
        raise Fault(f"`flange_at` of {kind_of(value)}")
    if m.robot is None:
        raise NotRun("where joints bring the flange without a robot")
    own = np.array([m.robot.own_joints(value.joints)])
    positions, quaternions = m.robot.flange_poses(own)
    configuration = configuration_of(m.robot.configuration(own)[0])
    return Target(Pose.of(positions[0], quaternions[0]), configuration, value.external)


def _joints_at(m: Machine, value: Value) -> JointTarget:
    """The joints that bring the flange to a target, in its configuration."""
    if not isinstance(value, Target):
        raise Fault(f"`joints_at` of {kind_of(value)}")
    if m.robot is None:
        raise NotRun("joints of a target without a robot")
    stated = np.array([configuration_row(value.configuration)], dtype=np.int8)
    place = np.array([value.pose.position]), np.array([value.pose.quaternion])
    found = m.robot.joints_of(*place, stated)[0]
    if bool(np.isnan(found).any()):
        raise Fault("a target that the robot does not reach")
    return JointTarget(tuple(map(float, found)), value.external)


_OF_ARM: Final[Mapping[str, Callable[[Machine, Value], Value]]] = {
    "flange_at": _flange_at, "joints_at": _joints_at,
}  # fmt: skip
"""Functions that need the robot's arm."""


def joints_here(m: Machine) -> JointTarget:
    stands = m.task.kernel.motion.where()
    joints = m.joints if stands is None else stands[1]
    if joints is None:
        raise NotRun("joints that are read while they are not known")
    return JointTarget(joints)


def _shifted(name: str, target: Value, numbers: list[float]) -> Value:
    if not isinstance(target, Target):
        raise Fault(f"`{name}` of {kind_of(target)}")
    shift = SHIFTS[name](*numbers)
    if shift is None:
        raise NotRun(f"`{name}` with turns about several axes, whose order languages disagree on")
    if name == "offset":
        (x, y, z), (a, b, c) = target.pose.position, shift.position
        pose = Pose((x + a, y + b, z + c), target.pose.quaternion)
    else:
        pose = target.pose @ shift
    return Target(pose, target.configuration, target.external)


def _one(function: Callable[[float], float]) -> Callable[..., Value]:
    return lambda value: float(function(number_of(value)))


def _bits(function: Callable[[int, int], int]) -> Callable[..., Value]:
    return lambda a, b: float(function(whole_of(a, "bits"), whole_of(b, "bits")))


def _rounded(value: Value, places: Value = 0.0) -> Value:
    """Return a rounded number, halves away from zero, as assumed for both vendors' languages."""
    number, scale = number_of(value), 10.0 ** whole_of(places)
    return math.copysign(math.floor(abs(number) * scale + 0.5), number) / scale


def _distance(a: Value, b: Value) -> Value:
    ends = [one.pose if isinstance(one, Target) else one for one in (a, b)]
    first, second = (one for one in ends if isinstance(one, Pose))
    return math.dist(first.position, second.position)


def _oriented(value: Value, *angles: Value) -> Value:
    if not isinstance(value, Target):
        raise Fault(f"`oriented` of {kind_of(value)}")
    given = dict(zip(e.ANGLES, map(number_of, angles), strict=True))
    return replace(value, pose=machine.turned_pose(value.pose, given))


def _inverse(value: Value) -> Value:
    if isinstance(value, Target):
        return Target(value.pose.inverse())
    if isinstance(value, Pose):
        return value.inverse()
    raise Fault(f"the inverse of {kind_of(value)}")


def _fixed(value: Value, places: Value) -> Value:
    return f"{number_of(value):.{whole_of(places)}f}"


def _text(value: Value) -> Value:
    return value if isinstance(value, str) else machine.value_text(value)


def _words(value: Value) -> str:
    if not isinstance(value, str):
        raise Fault(f"{kind_of(value)} where a text is wanted")
    return value


def _part_of(text: Value, start: Value, count: Value) -> Value:
    at = whole_of(start)
    return _words(text)[at - 1 : at - 1 + whole_of(count)]


def _code(text: Value) -> Value:
    (byte,) = _words(text)[:1].encode("latin-1")
    return float(byte)


_FUNCTIONS: Final[Mapping[str, Callable[..., Value]]] = {
    "abs": _one(abs),
    "sqrt": _one(math.sqrt),
    "sin": _one(lambda v: math.sin(math.radians(v))),
    "cos": _one(lambda v: math.cos(math.radians(v))),
    "tan": _one(lambda v: math.tan(math.radians(v))),
    "asin": _one(lambda v: math.degrees(math.asin(v))),
    "acos": _one(lambda v: math.degrees(math.acos(v))),
    "atan": _one(lambda v: math.degrees(math.atan(v))),
    "atan2": lambda y, x: math.degrees(math.atan2(number_of(y), number_of(x))),
    "exp": _one(math.exp),
    "ln": _one(math.log),
    "round": _rounded,
    "trunc": _one(math.trunc),
    "floor": _one(math.floor),
    "min": lambda *values: min(map(number_of, values)),
    "max": lambda *values: max(map(number_of, values)),
    "bitand": _bits(operator.and_),
    "bitor": _bits(operator.or_),
    "bitxor": _bits(operator.xor),
    "text": _text,
    "fixed": _fixed,
    "length": lambda value: float(len(_words(value))),
    "part": _part_of,
    "code": _code,
    "character": lambda value: bytes((whole_of(value),)).decode("latin-1"),
    "distance": _distance,
    "oriented": _oriented,
    "inverse": _inverse,
}
"""Those of `program.expressions.FUNCTIONS` that only compute."""
