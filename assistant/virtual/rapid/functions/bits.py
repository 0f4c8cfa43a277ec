"""Functions of the bits of whole numbers: a byte has 8, a dnum 52; bits count from 1."""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping
from typing import Final

from assistant.virtual.rapid.ends import UNSURE, Fault
from assistant.virtual.rapid.given import Given, table_row
from assistant.virtual.rapid.machine import Function
from assistant.virtual.rapid.operators import whole

BYTE_BITS, DNUM_BITS = 8, 52


def _bit_operation(given: Given, index: int, most: int) -> int:
    value = whole(given.number(index), "what the bits are taken of")
    if not 0 <= value < 1 << most:
        raise Fault(f"{value} has no {most} bits", UNSURE)
    return value


def _bit_mask(most: int, join: Callable[[int, int], int]) -> Callable[[Given], float]:
    return lambda given: float(join(_bit_operation(given, 0, most), _bit_operation(given, 1, most)))


def _inverted_bits(most: int) -> Callable[[Given], float]:
    return lambda given: float(~_bit_operation(given, 0, most) & ((1 << most) - 1))


def _shifted_bits(most: int, sign: int) -> Callable[[Given], float]:
    def does(given: Given) -> float:
        bits = _bit_operation(given, 0, most)
        steps = whole(given.number(1), "the steps of a shift")
        return float((bits << steps if sign > 0 else bits >> steps) & ((1 << most) - 1))

    return does


def _checked_bit(most: int) -> Callable[[Given], bool]:
    def does(given: Given) -> bool:
        place = whole(given.number(1), "the place of a bit")
        if not 1 <= place <= most:
            raise Fault(f"there is no bit {place} among {most}", UNSURE)
        return bool(_bit_operation(given, 0, most) >> (place - 1) & 1)

    return does


BIT_FUNCTIONS: Final[Mapping[str, Function]] = dict(
    row
    for ending, most in (("", BYTE_BITS), ("Dnum", DNUM_BITS))
    for row in (
        table_row(f"BitAnd{ending}", 2, _bit_mask(most, operator.and_)),
        table_row(f"BitOr{ending}", 2, _bit_mask(most, operator.or_)),
        table_row(f"BitXOr{ending}", 2, _bit_mask(most, operator.xor)),
        table_row(f"BitNeg{ending}", 1, _inverted_bits(most)),
        table_row(f"BitLSh{ending}", 2, _shifted_bits(most, 1)),
        table_row(f"BitRSh{ending}", 2, _shifted_bits(most, -1)),
        table_row(f"BitCheck{ending}", 2, _checked_bit(most)),
    )
)
