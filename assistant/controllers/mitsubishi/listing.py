"""The text of a MELFA-BASIC program as a CR controller lists it: steps, then variables.

Works on the lines alone, so that a program is compared with what the controller gives back
even where that writes blanks, case or decimals in its own way.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from decimal import ROUND_HALF_EVEN, Decimal, InvalidOperation
from typing import Final

from assistant.base.source_text import lines_of as split_lines

ENCODING: Final = "latin-1"
"""Bytes are passed through one to one: a controller's code page stays what it is."""

BLANKS: Final = " \t"
"""The only ones: other bytes that Python calls blank are halves of Japanese characters."""
STEP_LINE: Final = re.compile(r"\s*(\d+)(?:[ \t]+(.*))?$", re.DOTALL | re.ASCII)
VARIABLE_LINE: Final = re.compile(
    r"\s*([A-Za-z]\w*[$%&!#]?(?:\([\d, ]*\))?)\s*=\s*(\(.*)$", re.DOTALL | re.ASCII
)
DECIMAL_NUMBER: Final = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[Ee][+-]?\d+)?", re.ASCII)
QUOTED: Final = re.compile(
    r"""("[^"]*"?)|('.*$|\bREM\b.*$)""", re.IGNORECASE | re.DOTALL | re.ASCII
)
DECIMALS: Final = Decimal("0.01")
"""A controller lists positions with two decimals."""


@dataclass(frozen=True, slots=True)
class ProgramLine:
    """A line of a program and its number in the file, counted from 1."""

    number: int
    text: str


def program_lines(data: bytes) -> list[ProgramLine]:
    """The lines that say something; a step number or a variable may lead them."""
    split = enumerate(split_lines(data.decode(ENCODING)), start=1)
    return [ProgramLine(number, text) for number, text in split if text.strip(BLANKS)]


def listed_form(data: bytes) -> bytes:
    """The program in one form: steps in order, variables by name, two decimals, CR LF.

    A step or a variable that stands twice counts as it was said last, as on the controller.
    """
    steps: dict[int, str] = {}
    variables: dict[str, str] = {}
    others: list[str] = []
    for line in program_lines(data):
        if step := STEP_LINE.match(line.text):
            steps[int(step[1])] = statement_form(step[2] or "")
        elif variable := VARIABLE_LINE.match(line.text):
            name = re.sub(r"[ \t]+", "", variable[1]).upper()
            variables[name] = f"{name}={rounded_values(variable[2])}"
        else:
            others.append(statement_form(line.text))
    body = [f"{n} {steps[n]}".rstrip(BLANKS) for n in sorted(steps)]
    body += [variables[name] for name in sorted(variables, key=natural_order)] + others
    return "".join(f"{text}\r\n" for text in body).encode(ENCODING)


def statement_form(statement: str) -> str:
    """A statement in capitals with single blanks, strings and comments as they are."""
    parts, at = [], 0
    for quoted in QUOTED.finditer(statement):
        parts += [_capitals(statement[at : quoted.start()]), quoted[0]]
        at = quoted.end()
    parts.append(_capitals(statement[at:]))
    return "".join(parts).strip(BLANKS)


def rounded_values(text: str) -> str:
    """A bracketed list of numbers with two decimals each; flags in the second stay whole."""
    head, bracket, flags = re.sub(r"[ \t]+", "", text).partition(")")
    return DECIMAL_NUMBER.sub(_rounded, head) + bracket + flags


def _rounded(number: re.Match[str]) -> str:
    try:
        value = Decimal(number[0]).quantize(DECIMALS, ROUND_HALF_EVEN)
    except InvalidOperation:  # more digits than any robot has millimetres
        return number[0]
    return f"{value + 0 if value else Decimal('0.00'):+.2f}"


def _capitals(text: str) -> str:
    return re.sub(r"[ \t]+", " ", text).encode(ENCODING).upper().decode(ENCODING)  # A to Z only


def natural_order(name: str) -> list[str | int]:
    """P2 before P10."""
    return [int(p) if p.isdigit() else p for p in re.split(r"(\d+)", name)]
