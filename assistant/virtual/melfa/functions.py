"""Functions of MELFA-BASIC in a table; angles in radian (COSIROP help, list of RT ToolBox)."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from assistant.virtual.melfa import poses
from assistant.virtual.melfa.stops import Failed, Unknown, out_of_range
from assistant.virtual.melfa.values import (
    Joints,
    Position,
    Value,
    eight,
    joints,
    number,
    position,
    text,
    whole,
)

if TYPE_CHECKING:
    from assistant.robots import Robot


def call(name: str, arguments: tuple[Value | None, ...], robot: Robot | None) -> Value:
    """The value of a function; raises Unknown for one that is not simulated.

    name: upper case without `$`. arguments: None for one that is left out.
    """
    if name in NUMERIC and None not in arguments:
        return NUMERIC[name](*(number(a, f"an argument of {name}") for a in _given(arguments)))
    if name in PLAIN:
        return PLAIN[name](*arguments)
    if name in OF_POSE:
        found: Value = OF_POSE[name](robot, *_given(arguments))
        return found
    raise Unknown(f"the function {name}")


def _given(arguments: tuple[Value | None, ...]) -> tuple[Value, ...]:
    if any(a is None for a in arguments):
        raise Failed(3120, "an argument is left out")
    return tuple(a for a in arguments if a is not None)


# ----------------------------------------------------------------------------------- numbers


def _root(x: float) -> float:
    if x < 0:
        raise out_of_range("the root of a negative number")
    return math.sqrt(x)


def _power_of_e(x: float) -> float:
    if x > LARGEST_POWER:
        raise Unknown(f"e to the power of {x}")
    return math.exp(x)


LARGEST_POWER: Final = 709.0
"""Of e in double precision."""


def _logarithm(of: Callable[[float], float]) -> Callable[[float], float]:
    def made(x: float) -> float:
        if x <= 0:
            raise out_of_range("the logarithm of a number that is not positive")
        return of(x)

    return made


def _arc(of: Callable[[float], float]) -> Callable[[float], float]:
    def made(x: float) -> float:
        if not -1 <= x <= 1:
            raise out_of_range("the arc of a number beyond 1")
        return of(x)

    return made


NUMERIC: Final[Mapping[str, Callable[..., int | float]]] = {
    "ABS": abs,
    "SGN": lambda x: (x > 0) - (x < 0),
    "SQR": _root,
    "EXP": _power_of_e,
    "LN": _logarithm(math.log),
    "LOG": _logarithm(math.log10),
    "FIX": math.trunc,
    "INT": math.floor,
    "CINT": lambda x: whole(x),
    "MAX": max,
    "MIN": min,
    "DEG": math.degrees,
    "RAD": math.radians,
    "SIN": math.sin,
    "COS": math.cos,
    "TAN": math.tan,
    "ATN": math.atan,
    "ATN2": math.atan2,
    "ASIN": _arc(math.asin),
    "ACOS": _arc(math.acos),
}

# ------------------------------------------------------------------------------------- texts


def _shown(value: Value) -> str:
    """A number as Str$ writes it: of whole numbers only, for others the form is not known."""
    given = number(value)
    if given != int(given):
        raise Unknown("how Str$ writes a number that is not whole")
    return str(int(given))


def _part(of: Value, at: Value, count: Value) -> str:
    first, many, whole_text = whole(at), whole(count), text(of)
    if first <= 0 or many <= 0 or first - 1 + many > len(whole_text):
        raise out_of_range("the part of a text")
    return whole_text[first - 1 : first - 1 + many]


def _end(of: Value, count: Value, left: bool) -> str:
    many, whole_text = whole(count), text(of)
    if not 0 <= many <= len(whole_text):
        raise out_of_range("the part of a text")
    return whole_text[:many] if left else whole_text[len(whole_text) - many :]


def _code(of: Value) -> int:
    if not text(of):
        raise out_of_range("the first character of an empty text")
    return ord(text(of)[0])


def _character(code: Value) -> str:
    if not 0 <= whole(code) < 256:
        raise out_of_range(f"the character {whole(code)}")
    return chr(whole(code))


def _found(of: Value, sought: Value) -> int:
    if not text(sought):
        raise out_of_range("an empty text that is looked for")
    return text(of).find(text(sought)) + 1


def _number_in(of: Value) -> int | float:
    given = text(of).strip().upper()
    try:
        for mark, base in (("&H", 16), ("&B", 2)):
            if given.startswith(mark):
                return int(given[2:], base)
        value = float(given)
    except ValueError:
        raise Unknown(f"the number in the text `{text(of)}`") from None
    if not math.isfinite(value):
        raise Unknown(f"the number in the text `{text(of)}`")
    return int(value) if value.is_integer() else value


def _digits(of: Value, base: str, count: Value | None = None) -> str:
    given = whole(of)
    if given < 0:
        raise Unknown("the digits of a negative number")
    made = format(given, base)
    return made if count is None else made[-whole(count) :]


def _built(kind: type, radian: range) -> Callable[..., Value]:
    """Of SetPos and SetJnt: elements of which some are angles in radian."""

    def made(*given: Value | None) -> Value:
        values = []
        for at, value in enumerate(given):
            if at >= 6 and value is not None:
                raise Unknown("whether an additional axis turns or slides")
            plain = None if value is None else number(value)
            values.append(math.degrees(plain) if plain is not None and at in radian else plain)
        made: Value = kind(eight(tuple(values)))
        return made

    return made


PLAIN: Final[Mapping[str, Callable[..., Value]]] = {
    "STR": _shown,
    "MID": _part,
    "LEFT": lambda of, count: _end(of, count, left=True),
    "RIGHT": lambda of, count: _end(of, count, left=False),
    "LEN": lambda of: len(text(of)),
    "ASC": _code,
    "CHR": _character,
    "STRPOS": _found,
    "STRUPR": lambda of: text(of).upper(),
    "STRLWR": lambda of: text(of).lower(),
    "VAL": _number_in,
    "HEX": lambda of, count=None: _digits(of, "X", count),
    "BIN": lambda of: _digits(of, "b"),
    "SETPOS": _built(Position, range(3, 6)),
    "SETJNT": _built(Joints, range(8)),
}

# --------------------------------------------------------------------------------- positions


def _distance(_: Robot | None, one: Value, other: Value) -> float:
    a, b = (poses.pose_of(position(v)).position for v in (one, other))
    return float(np.linalg.norm(np.subtract(a, b)))


def _inverse(robot: Robot | None, value: Value) -> Position:
    return poses.inverse(position(value), robot)


def _known(robot: Robot | None) -> Robot:
    if robot is None:
        raise Unknown("the arm")
    return robot


def _to_position(robot: Robot | None, value: Value) -> Value:
    from assistant.virtual.melfa.arm import Arm

    arm = Arm(_known(robot))
    arm.at_joints(tuple(v for v in joints(value).values if v is not None))
    return arm.shown()


def _to_joints(robot: Robot | None, value: Value) -> Value:
    from assistant.virtual.melfa.arm import Arm

    arm, given = Arm(_known(robot)), position(value)
    arm.at_position(arm.placed(given), given.flags)
    return arm.shown_joints()


LETTERS: Final = (("L", "R"), ("B", "A"), ("F", "N"))
"""Of FL1 for 0 and 1: bits 2, 1 and 0."""


def _letter(_: Robot | None, value: Value, which: Value) -> str:
    one, at = position(value).flags[0], whole(which)
    if one is None or at not in range(3):
        raise Unknown("a structure flag")
    return LETTERS[at][one >> (2 - at) & 1]


def _lettered(_: Robot | None, value: Value, letters: Value) -> Position:
    given = position(value)
    one, two = given.flags
    if one is None:
        raise Unknown("a structure flag")
    for letter in text(letters).upper():
        place = next((i for i, pair in enumerate(LETTERS) if letter in pair), None)
        if place is None:
            raise out_of_range(f"the structure flag {letter}")
        bit = 1 << (2 - place)
        one = one | bit if LETTERS[place].index(letter) else one & ~bit
    return Position(given.values, (one, two))


OF_POSE: Final[Mapping[str, Callable[..., Any]]] = {
    "DIST": _distance,
    "INV": _inverse,
    "JTOP": _to_position,
    "PTOJ": _to_joints,
    "RDFL1": _letter,
    "SETFL1": _lettered,
}
"""Functions that take the arm first, None where it is not known."""
