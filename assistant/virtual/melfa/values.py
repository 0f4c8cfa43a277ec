"""Values of MELFA-BASIC: numbers, texts, positions and joints, and what types do to them."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Final, Literal

from assistant.virtual.melfa.options import Options
from assistant.virtual.melfa.stops import Failed, Unknown, number_wanted, open_point

Kind = Literal["number", "integer", "long", "text", "position", "joints"]
"""Types of variables. Single and double precision are both kept as double here."""

Elements = tuple[float | None, ...]

COMPONENTS: Final = ("X", "Y", "Z", "A", "B", "C", "L1", "L2")
"""Of a position: mm and degrees as constants have them; None for what is not defined."""
FLAGS: Final = ("FL1", "FL2")
JOINTS: Final = tuple(f"J{axis}" for axis in range(1, 9))

DEFAULT_FLAGS: Final = (7, 0)
"""Flags of a constant that states none (CR1D 4.3.12)."""


@dataclass(frozen=True, slots=True)
class Position:
    """values: eight of COMPONENTS, mm and degrees. flags: FL1 and FL2; None where not known."""

    values: Elements
    flags: tuple[int | None, int | None] = DEFAULT_FLAGS


ORIGIN: Final = Position((0.0,) * 6 + (None,) * 2, (0, 0))
"""No tool, no base."""


@dataclass(frozen=True, slots=True)
class Joints:
    """Eight values, degrees, mm of an axis that slides; None for what is not defined."""

    values: Elements


@dataclass(frozen=True, slots=True)
class Bare:
    """A constant without flags: a position or joints, as that which it meets."""

    values: Elements

    def position(self) -> Position:
        return Position(self.values)

    def joints(self) -> Joints:
        return Joints(self.values)


Value = int | float | bool | str | Position | Joints | Bare
"""A truth is what a comparison gives: 1 or 0 where a number is wanted."""

INTEGER_RANGES: Final = {"integer": 1 << 15, "long": 1 << 31}
"""Bound of whole types: 16 and 32 bits with a sign."""


def eight(values: tuple[float | None, ...]) -> Elements:
    """Eight elements; those that are left out at the end are not defined."""
    if len(values) > 8:
        raise Failed(4220, "a constant of more than eight elements")
    return (*values, *(None,) * (8 - len(values)))


def number(value: Value, what: str = "the value") -> int | float:
    """A value as a number; raises Failed for another type."""
    if isinstance(value, bool):
        return int(value)
    if isinstance(value, int | float):
        return value
    raise number_wanted(what)


def whole(value: Value, what: str = "the value") -> int:
    r"""A number rounded to a whole one, halves away from zero as CInt does (COSIROP: CINT).

    That is what subscripts, the operands of `\` and `Mod`, and whole types do with real numbers.
    """
    given = number(value, what)
    if isinstance(given, int):
        return given
    if not math.isfinite(given):
        raise Unknown(f"{what} is not finite")
    return math.floor(given + 0.5) if given >= 0 else math.ceil(given - 0.5)


def text(value: Value, what: str = "the value") -> str:
    if isinstance(value, str):
        return value
    raise Failed(4390, f"{what} is no text")


def position(value: Value, what: str = "the value") -> Position:
    if isinstance(value, Bare):
        return value.position()
    if isinstance(value, Position):
        return value
    raise Failed(4390, f"{what} is no position")


def joints(value: Value, what: str = "the value") -> Joints:
    if isinstance(value, Bare):
        return value.joints()
    if isinstance(value, Joints):
        return value
    raise Failed(4390, f"{what} is no joint position")


def kind_of(value: Value) -> Kind:
    """The type of a value: `number` for all numbers; of a bare constant, a position's."""
    if isinstance(value, str):
        return "text"
    if isinstance(value, Joints):
        return "joints"
    return "position" if isinstance(value, Position | Bare) else "number"


def holds(value: Value) -> bool:
    """Whether a condition is met: every number but 0 is true (COSIROP: WHILE)."""
    return number(value, "the condition") != 0


def fitted(value: Value, kind: Kind, what: str, options: Options) -> Value:
    """A value that is to go into a variable: a whole one takes no more than its bits."""
    if isinstance(value, str) and len(value) > options.longest_text:
        raise open_point(f"a text of {len(value)} characters", "longest_text")
    if kind not in INTEGER_RANGES or isinstance(value, str) or options.overflow is None:
        return value
    bound, rounded = INTEGER_RANGES[kind], whole(value, what)
    if -bound <= rounded < bound:
        return rounded
    if options.overflow == "error":
        raise Failed(None, f"{rounded} does not fit into {what}")
    return (rounded + bound) % (2 * bound) - bound


def converted(value: Value, kind: Kind, what: str) -> Value:
    """A value as a variable of a type keeps it."""
    match kind:
        case "number":
            return number(value, what)
        case "integer" | "long":
            rounded = whole(value, what)
            if not -INTEGER_RANGES[kind] <= rounded < INTEGER_RANGES[kind]:
                raise open_point(f"{rounded} does not fit into {what}", "overflow")
            return rounded
        case "text":
            return text(value, what)
        case "position":
            return position(value, what)
        case "joints":
            return joints(value, what)


# ---------------------------------------------------------------------------- components

ANGLE_PLACES: Final = 9
"""Decimals of degrees that are kept of an angle set in radian: 60 degrees are 60 again."""


def _degrees(radian: float) -> float:
    return round(math.degrees(radian), ANGLE_PLACES)


def component(value: Value, name: str, options: Options) -> int | float:
    """A component: angles in radian (PRGMDEG 0), lengths in mm, flags whole."""
    if isinstance(value, Joints):
        if name not in JOINTS:
            raise Failed(4220, f"joints have no component {name}")
        element = _defined_element(value.values[JOINTS.index(name)], name)
        return math.radians(element) if _in_radian(name, options) else element
    given = position(value, f"what has a component {name}")
    if name in FLAGS:
        flag = given.flags[FLAGS.index(name)]
        if flag is None:
            raise Unknown(f"the component {name} of a position without flags")
        return flag
    if name not in COMPONENTS:
        raise Failed(4220, f"positions have no component {name}")
    element = _defined_element(given.values[COMPONENTS.index(name)], name)
    return math.radians(element) if _in_radian(name, options) else element


def with_component(value: Value, name: str, new: Value, options: Options) -> Position | Joints:
    """The value with one component set, which is given as `component` gives it."""
    if isinstance(value, Joints):
        if name not in JOINTS:
            raise Failed(4220, f"joints have no component {name}")
        given_joint = float(number(new, name))
        element = _degrees(given_joint) if _in_radian(name, options) else given_joint
        return Joints(_with_element(value.values, JOINTS.index(name), element))
    given = position(value, f"what has a component {name}")
    if name in FLAGS:
        one, two = given.flags
        flag = whole(new, name)
        return replace(given, flags=(flag, two) if name == "FL1" else (one, flag))
    if name not in COMPONENTS:
        raise Failed(4220, f"positions have no component {name}")
    element = float(number(new, name))
    element = _degrees(element) if _in_radian(name, options) else element
    return replace(given, values=_with_element(given.values, COMPONENTS.index(name), element))


def _in_radian(name: str, options: Options) -> bool:
    if name in ADDITIONAL:
        if options.slides is None:
            raise open_point("whether an additional axis turns or slides", "slides")
        return not options.slides and not options.degrees
    return name not in ("X", "Y", "Z") and not options.degrees


ADDITIONAL: Final = ("L1", "L2", "J7", "J8")


def _with_element(values: Elements, at: int, value: float) -> Elements:
    return (*values[:at], value, *values[at + 1 :])


def _defined_element(value: float | None, name: str) -> float:
    if value is None:
        raise Failed(3700, f"the component {name} is not defined")
    return value
