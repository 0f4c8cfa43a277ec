"""Functions of strings, whose characters count from 1."""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping, Sequence
from typing import Final

from assistant.virtual.rapid.ends import UNSURE, Fault, NotSimulated
from assistant.virtual.rapid.given import Given, table_row
from assistant.virtual.rapid.machine import Function
from assistant.virtual.rapid.operators import joined, whole
from assistant.virtual.rapid.precision import Double, single
from assistant.virtual.rapid.values import text_of
from assistant.virtual.rapid.written import read_value


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
    r"""The first character of a set, or with \NotInSet that is in none; else one behind the end."""
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
    """Whether a string stands before another, or is the same; what has no order comes last."""
    one, two, order = (given.text(i) for i in range(3))

    def ranks(text: str) -> list[int]:
        found = (order.find(character) for character in text)
        return [
            len(order) + ord(c) if rank < 0 else rank for c, rank in zip(text, found, strict=True)
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


BYTE_FORMATS: Final[Mapping[str, tuple[int, str]]] = {
    "hex": (16, "02X"),
    "okt": (8, "03o"),
    "bin": (2, "08b"),
}
"""How a byte is written: to what base, and in how many digits (manual, ByteToStr)."""


def _byte_text(given: Given) -> str:
    value = whole(given.number(0), "a byte")
    if not 0 <= value < 256:
        raise Fault(f"{value} as a byte", UNSURE)
    if given.has("char"):
        return chr(value)
    form = next((form for name, (_, form) in BYTE_FORMATS.items() if given.has(name)), "d")
    return f"{value:{form}}"


def _byte_of_text(given: Given) -> float:
    text = given.text(0)
    if given.has("char"):
        if len(text) != 1:
            raise Fault(f"`{text}` as one character", UNSURE)
        return float(ord(text))
    base = next((base for name, (base, _) in BYTE_FORMATS.items() if given.has(name)), 10)
    value = _whole_digits(text, base)
    if value > 255:
        raise Fault(f"`{text}` as a byte", UNSURE)
    return float(value)


def _whole_digits(text: str, base: int) -> int:
    """Of digits alone."""
    try:
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
    if not 1 <= relation <= len(DIGIT_RELATIONS):
        raise Fault(f"the relation {relation}", UNSURE)
    return DIGIT_RELATIONS[relation - 1](_digits_argument(given, 0), _digits_argument(given, 2))


def _calculated_digits(given: Given) -> str:
    one, sign, two = (
        _digits_argument(given, 0),
        whole(given.number(1), "an operation"),
        _digits_argument(given, 2),
    )
    if not 1 <= sign <= len(DIGIT_OPERATIONS):
        raise Fault(f"the operation {sign}", UNSURE)
    if sign > 3 and two == 0:
        raise Fault("division of digits by zero", "ERR_CALC_DIVZERO")
    found = DIGIT_OPERATIONS[sign - 1](one, two)
    if found < 0:
        raise Fault("a negative number of digits", "ERR_CALC_NEG")
    if found > LARGEST_DIGITS:
        raise Fault(f"the number {found} of digits", "ERR_CALC_OVERFLOW")
    return str(found)


def _digits_argument(given: Given, index: int) -> int:
    text = given.text(index)
    if not (text.isascii() and text.isdecimal()):
        raise Fault(f"`{text}` as digits", "ERR_INT_NOTVAL")
    if int(text) > LARGEST_DIGITS:
        raise Fault(f"the number {text} of digits", "ERR_INT_MAXVAL")
    return int(text)


LARGEST_DIGITS: Final = 4294967295
DIGIT_RELATIONS: Final[Sequence[Callable[[int, int], bool]]] = (
    operator.lt,
    operator.le,
    operator.eq,
    operator.ne,
    operator.ge,
    operator.gt,
)
"""LT, LTEQ, EQ, NOTEQ, GTEQ, GT, which count from 1."""
DIGIT_OPERATIONS: Final[Sequence[Callable[[int, int], int]]] = (
    *(operator.add, operator.sub, operator.mul),
    *(operator.floordiv, operator.mod),
)
"""OpAdd, OpSub, OpMult, OpDiv, OpMod, which count from 1."""
CHARACTER_SETS: Final = "hex okt bin char"

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
        table_row("ByteToStr", 1, _byte_text, CHARACTER_SETS),
        table_row("StrToByte", 1, _byte_of_text, CHARACTER_SETS),
        table_row("DecToHex", 1, _to_base(10, "X")),
        table_row("HexToDec", 1, _to_base(16, "d")),
        table_row("StrDigCmp", 3, _compared_digits),
        table_row("StrDigCalc", 3, _calculated_digits),
    )
)
