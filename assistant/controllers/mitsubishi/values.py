"""Values as MELFA-BASIC writes them: what may be sent, and whether two are the same."""

from __future__ import annotations

import re
import time
from collections.abc import Callable
from typing import Final, TypeVar

from assistant.base.diagnostics import Refused
from assistant.controllers import rules

T = TypeVar("T")
SETTLING: Final = 1.0
"""Seconds for an assignment of EXEC to be carried out."""
SETTLING_POLL: Final = 0.02
NUMBER_PATTERN: Final = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[Ee][+-]?\d+)?"
LITERAL: Final = re.compile(
    rf"{NUMBER_PATTERN}|[+-]?&[HhBb][0-9A-Fa-f]+"
    r'|"[^"\x00-\x1f\x7f]*"'
    r"|\([-+0-9.,Ee ]*\)(?:\([-+0-9,&HhA-Fa-f ]*\))?",
    re.ASCII,
)
"""A number, a text, or a position or joints: what a value may be, and no expression."""
VARIABLE_NAME: Final = re.compile(
    r"[A-Za-z]\w{0,39}[$%&!#]?(?:\(\d{1,4}(?:, ?\d{1,4}){0,2}\))?", re.ASCII
)
PRINTABLE: Final = re.compile(r"[^\x00-\x1f\x7f;]*")
SHOWN_ROUNDING: Final = 0.00501
"""Half of the last of two decimals, which is what a controller shows of positions."""
RELATIVE_ROUNDING: Final = 1e-5
"""Part of a number that it may be off where more digits of it are shown."""
TWO_DECIMALS: Final = re.compile(r"[+-]?\d*\.\d\d")


def bad_value(value: object, what: str, reason: str, form: str) -> Refused:
    """Something that was asked for cannot be; it is shown without control characters."""
    shown = str(value) if str(value).isprintable() else ascii(value)
    return Refused(rules.BAD_VALUE(place=what, value=shown, what=what, reason=reason, form=form))


def checked_variable(name: str) -> str:
    """The name of a variable or of an element; raises Refused."""
    if VARIABLE_NAME.fullmatch(name):
        return name.upper().replace(" ", "")
    raise bad_value(name, "a variable", "it is no name of the language", "`M1`, `P_00` or `M1(2)`")


def checked_value(value: str) -> str:
    """A value that is no expression; raises Refused."""
    if LITERAL.fullmatch(value.strip(" ")):
        return value.strip(" ")
    raise bad_value(
        value,
        "a value",
        "it is no number, text or position",
        '`2.5`, `"text"` or `(x,y,z,a,b,c)(f1,f2)`',
    )


def checked_text(text: str, what: str, form: str) -> str:
    """Printable text without `;`, which would end an argument; raises Refused."""
    if PRINTABLE.fullmatch(text):
        return text
    reason = "it holds a control character or a semicolon"
    raise bad_value(text, what, reason, form)


def same_value(one: str, two: str) -> bool:
    """Whether two values are the same, numbers within what a controller shows of them."""
    if '"' in one or '"' in two:
        return _inside(one) == _inside(two)
    left, right = _parts(one), _parts(two)
    return len(left) == len(right) and all(map(_near, left, right))


def _inside(text: str) -> str:
    """A text without its quotation marks, which not all controllers show."""
    return text.strip(" ").removeprefix('"').removesuffix('"')


def _parts(text: str) -> list[str]:
    return [part.strip(" ()") for part in re.split(r",|\)\s*\(", text.strip())]


def _near(one: str, two: str) -> bool:
    if re.fullmatch(NUMBER_PATTERN, one) and re.fullmatch(NUMBER_PATTERN, two):
        rounded = any(map(TWO_DECIMALS.fullmatch, (one, two)))
        most = RELATIVE_ROUNDING * max(abs(float(one)), abs(float(two)))
        return abs(float(one) - float(two)) <= (max(SHOWN_ROUNDING, most) if rounded else most)
    return one.upper() == two.upper()


def read_until_settled(read: Callable[[], T], good: Callable[[T], bool]) -> T:
    """What is read once it is as it should be, or in the end.

    EXEC is answered when a statement is accepted; what it does comes a moment later.
    """
    end = time.monotonic() + SETTLING
    while not good(now := read()) and time.monotonic() < end:
        time.sleep(SETTLING_POLL)
    return now
