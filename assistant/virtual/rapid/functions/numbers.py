"""Functions of numbers; angles are degrees."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Final

from assistant.virtual.rapid.ends import UNSURE, Fault
from assistant.virtual.rapid.given import Given, table_row
from assistant.virtual.rapid.machine import Function
from assistant.virtual.rapid.operators import whole
from assistant.virtual.rapid.precision import LARGEST, Double, single

NumberFunction = Callable[[float], float]
"""Makes a num or a dnum of a number."""


def _number_function(
    formula: Callable[..., float], count: int, of: NumberFunction = single
) -> Callable[[Given], float]:
    """A formula of numbers; raises Fault where it has no value."""

    def does(given: Given) -> float:
        try:
            return of(float(formula(*(of(given.number(i)) for i in range(count)))))
        except (ValueError, OverflowError, ZeroDivisionError):
            raise Fault("a function outside of what it is defined for", UNSURE) from None

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


def _shortened(
    shorten: Callable[[float, float], float], of: NumberFunction = single
) -> Callable[[Given], float]:
    def does(given: Given) -> float:
        return of(shorten(of(given.number(0)), _decimal_scale(given)))

    return does


def _rounded(value: float, scale: float) -> float:
    """Halves away from zero."""
    return math.copysign(math.floor(abs(value) * scale + 0.5) / scale, value) + 0.0


def _truncated(value: float, scale: float) -> float:
    return math.trunc(value * scale) / scale + 0.0


def _to_num(given: Given) -> float:
    r"""DnumToNum; with \Integer the value is to be a whole number that a num is sure to hold."""
    value = given.number(0)
    if abs(value) > LARGEST:
        raise Fault(f"the dnum {value:g} as a num", "ERR_NUM_LIMIT")
    if given.has("integer"):
        if not -WHOLE_RANGE < value <= WHOLE_RANGE:
            raise Fault(f"the dnum {value:.15g} as a whole num", "ERR_ARGVALERR")
        if not value.is_integer():
            raise Fault(f"the dnum {value:.15g} as a whole number", UNSURE)
    return single(value)


WHOLE_RANGE: Final = 8388608
"""The whole numbers of a num are exact from -8388607 to this (reference, 2.1)."""


def _decimal_scale(given: Given) -> float:
    return 10.0 ** whole(given.optional_number("dec") or 0.0, "the number of decimals")


NUMBER_FORMULAS: Final[Mapping[str, tuple[Callable[..., float], int]]] = {
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

NUMBER_FUNCTIONS: Final[Mapping[str, Function]] = dict(
    (
        *(
            table_row(name, count, _number_function(does, count))
            for name, (does, count) in NUMBER_FORMULAS.items()
        ),
        *(
            table_row(f"{name}Dnum", count, _number_function(does, count, Double))
            for name, (does, count) in NUMBER_FORMULAS.items()
        ),
        table_row("Round", 1, _shortened(_rounded), "dec"),
        table_row("RoundDnum", 1, _shortened(_rounded, Double), "dec"),
        table_row("Trunc", 1, _shortened(_truncated), "dec"),
        table_row("TruncDnum", 1, _shortened(_truncated, Double), "dec"),
        table_row("Max", 2, _number_function(max, 2)),
        table_row("Min", 2, _number_function(min, 2)),
        table_row("NumToDnum", 1, lambda given: Double(single(given.number(0)))),
        table_row("DnumToNum", 1, _to_num, "integer"),
    )
)
