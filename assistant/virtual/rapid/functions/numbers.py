"""Functions of numbers; angles are degrees."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Final

from assistant.virtual.rapid.ends import Fault
from assistant.virtual.rapid.given import Given, takes
from assistant.virtual.rapid.machine import Function
from assistant.virtual.rapid.operators import whole


def _of(formula: Callable[..., float], count: int) -> Callable[[Given], float]:
    """A formula of numbers; raises Fault where it has no value."""

    def does(given: Given) -> float:
        try:
            return float(formula(*(given.number(i) for i in range(count))))
        except (ValueError, OverflowError, ZeroDivisionError):
            raise Fault("a function outside of what it is defined for") from None

    return does


def _tangent(angle: float) -> float:
    if abs(math.cos(math.radians(angle))) < 1e-12:
        raise ValueError
    return math.tan(math.radians(angle))


def _power(base: float, exponent: float) -> float:
    found = base**exponent
    if isinstance(found, complex):
        raise ValueError  # noqa: TRY004 - a negative base of a broken exponent
    return float(found)


def _rounded(given: Given) -> float:
    """Halves away from zero."""
    value, scale = given.number(0), _scale(given)
    return math.copysign(math.floor(abs(value) * scale + 0.5) / scale, value) + 0.0


def _truncated(given: Given) -> float:
    value, scale = given.number(0), _scale(given)
    return math.trunc(value * scale) / scale + 0.0


def _scale(given: Given) -> float:
    return 10.0 ** whole(given.optional_number("dec") or 0.0, "the number of decimals")


FORMULAS: Final[Mapping[str, tuple[Callable[..., float], int]]] = {
    "Abs": (abs, 1),
    "Sqrt": (math.sqrt, 1),
    "Sin": (lambda angle: math.sin(math.radians(angle)), 1),
    "Cos": (lambda angle: math.cos(math.radians(angle)), 1),
    "Tan": (_tangent, 1),
    "ASin": (lambda value: math.degrees(math.asin(value)), 1),
    "ACos": (lambda value: math.degrees(math.acos(value)), 1),
    "ATan": (lambda value: math.degrees(math.atan(value)), 1),
    "ATan2": (lambda y, x: math.degrees(math.atan2(y, x)), 2),
    "Exp": (math.exp, 1),
    "Pow": (_power, 2),
}

TABLE: Final[Mapping[str, Function]] = dict(
    (
        *(takes(name, count, _of(does, count)) for name, (does, count) in FORMULAS.items()),
        *(
            takes(f"{name}Dnum", count, _of(does, count))
            for name, (does, count) in FORMULAS.items()
        ),
        *(takes(name, 1, _rounded, "dec") for name in ("Round", "RoundDnum")),
        *(takes(name, 1, _truncated, "dec") for name in ("Trunc", "TruncDnum")),
        takes("Max", 2, _of(max, 2)),
        takes("Min", 2, _of(min, 2)),
        takes("NumToDnum", 1, _of(float, 1)),
        takes("DnumToNum", 1, _of(float, 1)),
    )
)
