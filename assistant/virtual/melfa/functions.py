"""Functions of MELFA-BASIC on numbers and texts, in tables (COSIROP help, CR1D, RT ToolBox).

Angles are radian. Functions of texts give parts of them, their codes, and numbers as text.
"""

from __future__ import annotations

import math
import re
import struct
from collections.abc import Callable, Mapping
from typing import Final

from assistant.virtual.melfa import positions
from assistant.virtual.melfa.options import Options
from assistant.virtual.melfa.values import (
    Failed,
    Unknown,
    Value,
    number,
    open_point,
    out_of_range,
    text,
    whole,
)
from assistant.virtual.melfa.world import World

_CHARACTER_CODES: Final = "latin-1"
"""A character is one byte here: what it shows is up to the controller's code page."""

# ------------------------------------------------------------------------------------- parts


def _middle_text(of: Value, at: Value, count: Value) -> str:
    first, many, whole_text = whole(at), whole(count), text(of)
    if first <= 0 or many <= 0 or first - 1 + many > len(whole_text):
        raise out_of_range("the part of a text")
    return whole_text[first - 1 : first - 1 + many]


def _text_end(of: Value, count: Value, left: bool) -> str:
    many, whole_text = whole(count), text(of)
    if not 0 <= many <= len(whole_text):
        raise out_of_range("the part of a text")
    return whole_text[:many] if left else whole_text[len(whole_text) - many :]


def _find_text(of: Value, sought: Value) -> int:
    if not text(sought):
        raise out_of_range("an empty text that is looked for")
    return text(of).find(text(sought)) + 1


# ------------------------------------------------------------------------------------- codes


def _text_bytes(of: Value) -> bytes:
    try:
        return text(of).encode(_CHARACTER_CODES)
    except UnicodeEncodeError:
        raise Unknown(f"the codes of the characters of `{text(of)}`") from None


def _character_code(of: Value) -> int:
    if not text(of):
        raise out_of_range("the first character of an empty text")
    return _text_bytes(of)[0]


def _character(code: Value) -> str:
    if not 0 <= whole(code) < 256:
        raise out_of_range(f"the character {whole(code)}")
    return chr(whole(code))


def _code_sum(of: Value, first: Value, last: Value) -> int:
    """CkSum: the codes from one character to another, or to the end, in eight bits."""
    codes, start, end = _text_bytes(of), whole(first), whole(last)
    if not 1 <= start <= len(codes):
        raise out_of_range(f"the character {start} of a text of {len(codes)}")
    if end < start:
        raise Unknown("a sum of characters that ends before it begins")
    return sum(codes[start - 1 : end]) % 256


def _reversed_text(of: Value) -> str:
    """Mirror$: all bits of the text in the other order, so that "BJ" becomes "RB"."""
    codes = _text_bytes(of)
    bits = "".join(f"{code:08b}" for code in codes)[::-1]
    return bytes(int(bits[i : i + 8], 2) for i in range(0, len(bits), 8)).decode(_CHARACTER_CODES)


def _packed_number(form: str) -> Callable[[Value], str]:
    """Mki$, Mks$, Mkd$: the bytes of a number, the lowest first as `Cvi` has them."""

    def made(given: Value) -> str:
        value = number(given)
        if form == _WHOLE_CODE:
            return (whole(value) & 0xFFFF).to_bytes(2, "little").decode(_CHARACTER_CODES)
        try:
            return struct.pack(form, value).decode(_CHARACTER_CODES)
        except OverflowError:
            raise Unknown(f"{value} in single precision") from None

    return made


def _unpacked_number(form: str) -> Callable[[Value], int | float]:
    """Cvi, Cvs, Cvd: Cvi("10ABC") is &H3031, the first character the lowest byte (COSIROP)."""
    size = struct.calcsize(form)

    def made(of: Value) -> int | float:
        codes = _text_bytes(of)[:size]
        if len(codes) < size:
            raise out_of_range(f"a text of fewer than {size} characters")
        (value,) = struct.unpack(form, codes)
        if not math.isfinite(value):
            raise Unknown("a number that is not finite")
        return int(value) if form == _WHOLE_CODE else float(value)

    return made


_WHOLE_CODE: Final = "<h"
_SINGLE_CODE: Final = "<f"
_DOUBLE_CODE: Final = "<d"

# ----------------------------------------------------------------------------------- numbers


def _number_text(options: Options, value: Value) -> str:
    """A number as Str$ writes it; of those that are not whole the form is an option."""
    given = number(value)
    if given == int(given) and abs(given) < _LONG_CODE:
        return str(int(given))
    if options.digits is None:
        raise open_point("how Str$ writes a number that is not whole", "digits")
    return f"{given:.{options.digits}g}"


_LONG_CODE: Final = 1 << 31
"""From here on a number is no whole one of 32 bits."""


def _number_in_text(of: Value) -> int | float:
    given = text(of).strip().upper()
    if _BASED.fullmatch(given):
        return int(given[2:], _BASES[given[1]])
    value = float(given) if _DECIMAL.fullmatch(given) else math.nan
    if not math.isfinite(value):
        raise Unknown(f"the number in the text `{text(of)}`")
    return int(value) if value.is_integer() else value


_BASED: Final = re.compile(r"&H[0-9A-F]+|&B[01]+")
_BASES: Final = {"H": 16, "B": 2}
_DECIMAL: Final = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)(E[+-]?\d+)?", re.ASCII)


def _based_digits(options: Options, of: Value, base: str, count: Value | None = None) -> str:
    """Hex$, Bin$; of a negative number the last four hexadecimal digits are sure."""
    given, wanted = whole(of), None if count is None else whole(count)
    if given < 0:
        bits = options.bits
        # The last four digits are the same in 16 and in 32 bits.
        if bits is None and base == "X" and wanted is not None and wanted <= _SURE_DIGITS:
            bits = 16
        if bits is None:
            raise open_point("the digits of a negative number", "bits")
        given &= (1 << bits) - 1
    made = format(given, base)
    if wanted is None:
        return made
    if not 1 <= wanted <= len(made):
        raise Unknown(f"{wanted} digits of the {len(made)} of a number")
    return made[-wanted:]


_SURE_DIGITS: Final = 4

_TEXT_FUNCTIONS: Final[Mapping[str, Callable[..., Value]]] = {
    "MID": _middle_text,
    "LEFT": lambda of, count: _text_end(of, count, left=True),
    "RIGHT": lambda of, count: _text_end(of, count, left=False),
    "LEN": lambda of: len(text(of)),
    "ASC": _character_code,
    "CHR": _character,
    "STRPOS": _find_text,
    "STRUPR": lambda of: text(of).upper(),
    "STRLWR": lambda of: text(of).lower(),
    "VAL": _number_in_text,
    "CKSUM": _code_sum,
    "MIRROR": _reversed_text,
    "MKI": _packed_number(_WHOLE_CODE),
    "MKS": _packed_number(_SINGLE_CODE),
    "MKD": _packed_number(_DOUBLE_CODE),
    "CVI": _unpacked_number(_WHOLE_CODE),
    "CVS": _unpacked_number(_SINGLE_CODE),
    "CVD": _unpacked_number(_DOUBLE_CODE),
}

_OPTION_FUNCTIONS: Final[Mapping[str, Callable[..., Value]]] = {
    "STR": _number_text,
    "HEX": lambda options, of, count=None: _based_digits(options, of, "X", count),
    "BIN": lambda options, of: _based_digits(options, of, "b"),
}
"""Functions that take the options first."""


def call(name: str, arguments: tuple[Value | None, ...], world: World) -> Value:
    """The value of a function; raises Unknown for one that is not simulated.

    name: upper case without `$`. arguments: None for one that is left out.
    """
    if name in _NUMBER_FUNCTIONS and None not in arguments:
        return _NUMBER_FUNCTIONS[name](
            *(number(a, f"an argument of {name}") for a in _required(arguments))
        )
    if name in _TEXT_FUNCTIONS:
        return _TEXT_FUNCTIONS[name](*_required(arguments))
    if name in _OPTION_FUNCTIONS:
        return _OPTION_FUNCTIONS[name](world.options, *_required(arguments))
    if name in positions.CONSTRUCTORS:
        return positions.CONSTRUCTORS[name](world, *arguments)
    if name in positions.POSITION_FUNCTIONS:
        return positions.POSITION_FUNCTIONS[name](world, *_required(arguments))
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
    if x > _LARGEST_POWER:
        raise Unknown(f"e to the power of {x}")
    return math.exp(x)


_LARGEST_POWER: Final = 709.0
"""Largest power of e in double precision."""


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


_NUMBER_FUNCTIONS: Final[Mapping[str, Callable[..., int | float]]] = {
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
