"""Functions of numbers, bits and strings.

Angles are degrees. A byte has 8 bits, a dnum 52; bits and the characters of a string count from 1.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Mapping, Sequence
from typing import Final

from assistant.virtual.rapid.call_arguments import Given, table_row
from assistant.virtual.rapid.control_flow import UNSURE, Fault, NotSimulated
from assistant.virtual.rapid.expressions import joined, whole
from assistant.virtual.rapid.machine import Function
from assistant.virtual.rapid.value_text import read_value
from assistant.virtual.rapid.values import LARGEST, Double, single, text_of

_NumberFunction = Callable[[float], float]
"""Makes a num or a dnum of a number."""


def _number_function(
    formula: Callable[..., float], count: int, of: _NumberFunction = single
) -> Callable[[Given], float]:
    """A formula of numbers; raises Fault where it has no value."""

    def does(given: Given) -> float:
        try:
            return of(float(formula(*(of(given.number(i)) for i in range(count)))))
        except (ValueError, OverflowError, ZeroDivisionError):
            raise Fault("a function outside of what it is defined for", UNSURE) from None

    return does


def _tangent(angle: float) -> float:
    # cos(90 degrees) is 6e-17 in floats: the tangent would be a large number instead of an error.
    if abs(math.cos(math.radians(angle))) < 1e-12:
        raise ValueError
    return math.tan(math.radians(angle))


def _power(base: float, exponent: float) -> float:
    # Python makes a complex number of a negative base and a broken exponent.
    found = base**exponent
    if isinstance(found, complex):
        raise ValueError  # noqa: TRY004 - a negative base of a broken exponent
    return float(found)


def _shortened(
    shorten: Callable[[float, float], float], of: _NumberFunction = single
) -> Callable[[Given], float]:
    def does(given: Given) -> float:
        return of(shorten(of(given.number(0)), _decimal_scale(given)))

    return does


def _rounded(value: float, scale: float) -> float:
    """Halves away from zero."""
    # Python's round() takes halves to even numbers. + 0.0 turns -0.0 into 0.0.
    return math.copysign(math.floor(abs(value) * scale + 0.5) / scale, value) + 0.0


def _truncated(value: float, scale: float) -> float:
    return math.trunc(value * scale) / scale + 0.0


def _to_num(given: Given) -> float:
    r"""DnumToNum; with \Integer the value is to be a whole number that a num is sure to hold."""
    value = given.number(0)
    if abs(value) > LARGEST:
        raise Fault(f"the dnum {value:g} as a num", "ERR_NUM_LIMIT")
    if given.has("integer"):
        if not -_WHOLE_RANGE < value <= _WHOLE_RANGE:
            raise Fault(f"the dnum {value:.15g} as a whole num", "ERR_ARGVALERR")
        if not value.is_integer():
            raise Fault(f"the dnum {value:.15g} as a whole number", UNSURE)
    return single(value)


_WHOLE_RANGE: Final = 8388608
"""The whole numbers of a num are exact from -8388607 to this (reference, 2.1)."""


def _decimal_scale(given: Given) -> float:
    return 10.0 ** whole(given.optional_number("dec") or 0.0, "the number of decimals")


_NUMBER_FORMULAS: Final[Mapping[str, tuple[Callable[..., float], int]]] = {
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
            for name, (does, count) in _NUMBER_FORMULAS.items()
        ),
        *(
            table_row(f"{name}Dnum", count, _number_function(does, count, Double))
            for name, (does, count) in _NUMBER_FORMULAS.items()
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


_BYTE_BITS, _DNUM_BITS = 8, 52


def _bit_operation(given: Given, index: int, most: int) -> int:
    value = whole(given.number(index), "what the bits are taken of")
    if not 0 <= value < 1 << most:
        raise Fault(f"{value} has no {most} bits", UNSURE)
    return value


def _bit_mask(most: int, join: Callable[[int, int], int]) -> Callable[[Given], float]:
    return lambda given: float(join(_bit_operation(given, 0, most), _bit_operation(given, 1, most)))


def _inverted_bits(most: int) -> Callable[[Given], float]:
    # Python's ~ of a whole number is negative; the mask keeps its bits.
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
    for ending, most in (("", _BYTE_BITS), ("Dnum", _DNUM_BITS))
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


def _text_position(given: Given, text: str) -> int:
    """From 0, of a character that is there."""
    place = whole(given.number(1), "the place of a character")
    if not 1 <= place <= len(text):
        raise Fault(f"there is no character {place} among {len(text)}", "ERR_OUTOFBND")
    return place - 1


def _text_part(given: Given) -> str:
    text = given.text(0)
    start = _text_position(given, text)
    length = whole(given.number(2), "a length")
    if not 0 <= length <= len(text) - start:
        message = f"{length} characters from the {start + 1}. of {len(text)}"
        raise Fault(message, "ERR_OUTOFBND")
    return text[start : start + length]


def _find_text(given: Given) -> float:
    r"""Return the position of the first character of a set, or with \NotInSet of one outside it;
    else one after the end.
    """
    text, chosen = given.text(0), given.text(2)
    start, wanted = _text_position(given, text), not given.has("notinset")
    hits = (i for i in range(start, len(text)) if (text[i] in chosen) is wanted)
    return float(next(hits, len(text)) + 1)


def _match_text(given: Given) -> float:
    text, pattern = given.text(0), given.text(2)
    if not pattern:
        raise NotSimulated("StrMatch of an empty pattern")
    found = text.find(pattern, _text_position(given, text))
    return float((len(text) if found < 0 else found) + 1)


def _is_member(given: Given) -> bool:
    text = given.text(0)
    return text[_text_position(given, text)] in given.text(2)


def _mapped_text(given: Given) -> str:
    text, before, after = given.text(0), given.text(1), given.text(2)
    if len(before) != len(after):
        raise Fault("StrMap between sets of other sizes", UNSURE)
    return text.translate(str.maketrans(before, after))


def _text_order(given: Given) -> bool:
    """True if a string precedes another, or is the same; characters without an order come last."""
    one, two, order = (given.text(i) for i in range(3))

    def ranks(text: str) -> list[int]:
        found = (order.find(character) for character in text)
        return [
            # Characters without an order come after all others, in the order of their codes.
            len(order) + ord(c) if rank < 0 else rank
            for c, rank in zip(text, found, strict=True)
        ]

    return ranks(one) <= ranks(two)


def _number_as_text(of: Callable[[float], float]) -> Callable[[Given], str]:
    """NumToStr and DnumToStr."""

    def does(given: Given) -> str:
        decimals = whole(given.number(1), "the number of decimals")
        if decimals < 0:
            raise Fault(f"{decimals} decimals", "ERR_NEGARG")
        form = "E" if given.has("exp") else "f"
        return joined(f"{of(given.number(0)):.{decimals}{form}}")

    return does


def _value_as_text(given: Given) -> str:
    try:
        return joined(text_of(given.value(0)))
    except ValueError as error:
        raise Fault(str(error)) from None


def _text_as_value(given: Given) -> bool:
    """StrToVal: whether a string is a value of the data that it is put into."""
    place = given.place(1)
    value = read_value(given.text(0), place.shape, given.machine.types)
    if value is None:
        return False
    place.set(value)
    return True


_BYTE_FORMATS: Final[Mapping[str, tuple[int, str]]] = {
    "hex": (16, "02X"),
    "okt": (8, "03o"),
    "bin": (2, "08b"),
}
"""Formats of a byte: its base, and its number of digits (manual, ByteToStr)."""


def _byte_text(given: Given) -> str:
    value = whole(given.number(0), "a byte")
    if not 0 <= value < 256:
        raise Fault(f"{value} as a byte", UNSURE)
    if given.has("char"):
        return chr(value)
    form = next((form for name, (_, form) in _BYTE_FORMATS.items() if given.has(name)), "d")
    return f"{value:{form}}"


def _byte_of_text(given: Given) -> float:
    text = given.text(0)
    if given.has("char"):
        if len(text) != 1:
            raise Fault(f"`{text}` as one character", UNSURE)
        return float(ord(text))
    base = next((base for name, (base, _) in _BYTE_FORMATS.items() if given.has(name)), 10)
    value = _whole_digits(text, base)
    if value > 255:
        raise Fault(f"`{text}` as a byte", UNSURE)
    return float(value)


def _whole_digits(text: str, base: int) -> int:
    """Return the integer of a text with digits alone."""
    try:
        # int() also takes signs, underscores and blanks, which are no digits to a controller.
        return int(text if text.isalnum() else "x", base)
    except ValueError:
        raise Fault(f"`{text}` as a number to the base {base}", UNSURE) from None


def _to_base(base: int, form: str) -> Callable[[Given], str]:
    """DecToHex and HexToDec, of numbers up to 7FFFFFFFFFFFFFFF."""

    def does(given: Given) -> str:
        value = _whole_digits(given.text(0), base)
        if value >= 1 << 63:
            raise Fault(f"the number {value}", UNSURE)
        return f"{value:{form}}"

    return does


def _compared_digits(given: Given) -> bool:
    """StrDigCmp: numbers of digits alone, up to 4294967295."""
    relation = whole(given.number(1), "a relation")
    if not 1 <= relation <= len(_DIGIT_RELATIONS):
        raise Fault(f"the relation {relation}", UNSURE)
    return _DIGIT_RELATIONS[relation - 1](_digits_argument(given, 0), _digits_argument(given, 2))


def _calculated_digits(given: Given) -> str:
    one, sign, two = (
        _digits_argument(given, 0),
        whole(given.number(1), "an operation"),
        _digits_argument(given, 2),
    )
    if not 1 <= sign <= len(_DIGIT_OPERATIONS):
        raise Fault(f"the operation {sign}", UNSURE)
    # 4 and 5 are OpDiv and OpMod.
    if sign > 3 and two == 0:
        raise Fault("division of digits by zero", "ERR_CALC_DIVZERO")
    found = _DIGIT_OPERATIONS[sign - 1](one, two)
    if found < 0:
        raise Fault("a negative number of digits", "ERR_CALC_NEG")
    if found > _LARGEST_DIGITS:
        raise Fault(f"the number {found} of digits", "ERR_CALC_OVERFLOW")
    return str(found)


def _digits_argument(given: Given, index: int) -> int:
    text = given.text(index)
    # isdecimal() alone accepts digits of other scripts.
    if not (text.isascii() and text.isdecimal()):
        raise Fault(f"`{text}` as digits", "ERR_INT_NOTVAL")
    if int(text) > _LARGEST_DIGITS:
        raise Fault(f"the number {text} of digits", "ERR_INT_MAXVAL")
    return int(text)


_LARGEST_DIGITS: Final = 4294967295
_DIGIT_RELATIONS: Final[Sequence[Callable[[int, int], bool]]] = (
    operator.lt,
    operator.le,
    operator.eq,
    operator.ne,
    operator.ge,
    operator.gt,
)
"""LT, LTEQ, EQ, NOTEQ, GTEQ, GT, which count from 1."""
_DIGIT_OPERATIONS: Final[Sequence[Callable[[int, int], int]]] = (
    *(operator.add, operator.sub, operator.mul),
    *(operator.floordiv, operator.mod),
)
"""OpAdd, OpSub, OpMult, OpDiv, OpMod, which count from 1."""
_CHARACTER_SETS: Final = "hex okt bin char"

STRING_FUNCTIONS: Final[Mapping[str, Function]] = dict(
    (
        table_row("StrLen", 1, lambda given: float(len(given.text(0)))),
        table_row("StrPart", 3, _text_part),
        table_row("StrFind", 3, _find_text, "notinset"),
        table_row("StrMatch", 3, _match_text),
        table_row("StrMemb", 3, _is_member),
        table_row("StrMap", 3, _mapped_text),
        table_row("StrOrder", 3, _text_order),
        table_row("StrToVal", 2, _text_as_value),
        table_row("NumToStr", 2, _number_as_text(single), "exp"),
        table_row("DnumToStr", 2, _number_as_text(Double), "exp"),
        table_row("ValToStr", 1, _value_as_text),
        table_row("ByteToStr", 1, _byte_text, _CHARACTER_SETS),
        table_row("StrToByte", 1, _byte_of_text, _CHARACTER_SETS),
        table_row("DecToHex", 1, _to_base(10, "X")),
        table_row("HexToDec", 1, _to_base(16, "d")),
        table_row("StrDigCmp", 3, _compared_digits),
        table_row("StrDigCalc", 3, _calculated_digits),
    )
)
