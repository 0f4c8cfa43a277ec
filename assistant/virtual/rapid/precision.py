"""How exact numbers are: a num has single precision, a dnum double (reference, 2.1).

Wherever a program reads it, a num is a plain float that single precision can hold. What is only
written, and not stored yet, is as exact as the data that it meets.
"""

from __future__ import annotations

import struct
from typing import Final

LARGEST: Final = 3.40282347e38
"""Of a num (manual, errnum, ERR_NUM_LIMIT)."""


class Double(float):
    """A dnum."""

    __slots__ = ()


class Exact(float):
    """A number of literals alone."""

    __slots__ = ()


_SINGLE: Final = struct.Struct("f")
_pack, _unpack = _SINGLE.pack, _SINGLE.unpack


def single(value: float) -> float:
    """The num next to a number; infinite beyond the largest."""
    try:
        found: float = _unpack(_pack(value))[0]
    except OverflowError:
        return float("inf") if value > 0 else float("-inf")
    return found


def paired(left: float, right: float) -> tuple[float, float, type[float]]:
    """Two operands as exact as they are together, and what their result is."""
    one, two = type(left), type(right)
    if one is two:
        return left, right, one
    if one is Double or two is Double:
        return left, right, Double
    return single(left), single(right), float


def as_kind(value: float, kind: type[float]) -> float:
    """A result of what `paired` says it is."""
    return single(value) if kind is float else kind(value)


def digits(value: float) -> int:
    """Significant digits that ValToStr writes (manual, ValToStr)."""
    return 6 if type(value) is float else 15
