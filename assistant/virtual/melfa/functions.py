"""Functions of MELFA-BASIC in a table; angles in radian (COSIROP help, list of RT ToolBox)."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Final

from assistant.virtual.melfa import places, texts
from assistant.virtual.melfa.stops import Failed, Unknown, out_of_range
from assistant.virtual.melfa.values import Value, number, whole
from assistant.virtual.melfa.world import World


def call(name: str, arguments: tuple[Value | None, ...], world: World) -> Value:
    """The value of a function; raises Unknown for one that is not simulated.

    name: upper case without `$`. arguments: None for one that is left out.
    """
    if name in NUMBER_FUNCTIONS and None not in arguments:
        return NUMBER_FUNCTIONS[name](
            *(number(a, f"an argument of {name}") for a in _required(arguments))
        )
    if name in texts.TEXT_FUNCTIONS:
        return texts.TEXT_FUNCTIONS[name](*_required(arguments))
    if name in texts.OPTION_FUNCTIONS:
        return texts.OPTION_FUNCTIONS[name](world.options, *_required(arguments))
    if name in places.CONSTRUCTORS:
        return places.CONSTRUCTORS[name](world, *arguments)
    if name in places.POSITION_FUNCTIONS:
        return places.POSITION_FUNCTIONS[name](world, *_required(arguments))
    raise Unknown(f"the function {name}")


def _required(arguments: tuple[Value | None, ...]) -> tuple[Value, ...]:
    if any(a is None for a in arguments):
        raise Failed(3120, "an argument is left out")
    return tuple(a for a in arguments if a is not None)


# ----------------------------------------------------------------------------------- numbers


def _square_root(x: float) -> float:
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


def _arc_tangent(of: Callable[[float], float]) -> Callable[[float], float]:
    def made(x: float) -> float:
        if not -1 <= x <= 1:
            raise out_of_range("the arc of a number beyond 1")
        return of(x)

    return made


NUMBER_FUNCTIONS: Final[Mapping[str, Callable[..., int | float]]] = {
    "ABS": abs,
    "SGN": lambda x: (x > 0) - (x < 0),
    "SQR": _square_root,
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
    "ASIN": _arc_tangent(math.asin),
    "ACOS": _arc_tangent(math.acos),
}
