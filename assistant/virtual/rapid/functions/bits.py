"""Functions of the bits of whole numbers: a byte has 8, a dnum 52; bits count from 1."""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping
from typing import Final

from assistant.virtual.rapid.ends import UNSURE, Fault
from assistant.virtual.rapid.given import Given, takes
from assistant.virtual.rapid.machine import Function
from assistant.virtual.rapid.operators import whole

BYTE, DNUM = 8, 52


def _bits(given: Given, index: int, most: int) -> int:
    value = whole(given.number(index), "what the bits are taken of")
    if not 0 <= value < 1 << most:
        raise Fault(f"{value} has no {most} bits", UNSURE)
    return value


def _joined(most: int, join: Callable[[int, int], int]) -> Callable[[Given], float]:
    return lambda given: float(join(_bits(given, 0, most), _bits(given, 1, most)))


def _inverted(most: int) -> Callable[[Given], float]:
    return lambda given: float(~_bits(given, 0, most) & ((1 << most) - 1))


def _shifted(most: int, sign: int) -> Callable[[Given], float]:
    def does(given: Given) -> float:
        bits = _bits(given, 0, most)
        steps = whole(given.number(1), "the steps of a shift")
        return float((bits << steps if sign > 0 else bits >> steps) & ((1 << most) - 1))

    return does


def _checked(most: int) -> Callable[[Given], bool]:
    def does(given: Given) -> bool:
        place = whole(given.number(1), "the place of a bit")
        if not 1 <= place <= most:
            raise Fault(f"there is no bit {place} among {most}", UNSURE)
        return bool(_bits(given, 0, most) >> (place - 1) & 1)

    return does


TABLE: Final[Mapping[str, Function]] = dict(
    row
    for ending, most in (("", BYTE), ("Dnum", DNUM))
    for row in (
        takes(f"BitAnd{ending}", 2, _joined(most, operator.and_)),
        takes(f"BitOr{ending}", 2, _joined(most, operator.or_)),
        takes(f"BitXOr{ending}", 2, _joined(most, operator.xor)),
        takes(f"BitNeg{ending}", 1, _inverted(most)),
        takes(f"BitLSh{ending}", 2, _shifted(most, 1)),
        takes(f"BitRSh{ending}", 2, _shifted(most, -1)),
        takes(f"BitCheck{ending}", 2, _checked(most)),
    )
)
