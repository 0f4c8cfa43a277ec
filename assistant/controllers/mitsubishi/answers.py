"""Answers of the controller link: `QoK…`, or `QeR` with an error number (BFP-A4288).

A lower-case third letter is the same answer of a controller in an error state.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Final

ENCODING: Final = "latin-1"
ANSWER_FORM: Final = re.compile(r"Q(OK|ER)([^\r\n]*)", re.IGNORECASE)
ERROR_ANSWER: Final = re.compile(r"(\d{4})((?:;\d+)*)\s*")

BARE_ANSWER: Final = re.compile(r"[; ]*")
"""Of a command that only says that it was accepted."""


@dataclass(frozen=True, slots=True)
class Answer:
    """An answer: its text, or the error number and the places (line, character) behind it.

    alarmed: the controller is in an error state.
    """

    text: str = ""
    number: int | None = None
    places: tuple[int, ...] = ()
    alarmed: bool = False

    @property
    def ok(self) -> bool:
        return self.number is None


def parse_answer(raw: str) -> Answer | None:
    """The answer that a text is, None if it is none."""
    found = ANSWER_FORM.fullmatch(raw)
    if found is None:
        return None
    kind, text = found[1], found[2]
    alarmed = kind[1].islower()
    if kind.upper() == "OK":
        return Answer(text, alarmed=alarmed)
    error = ERROR_ANSWER.fullmatch(text)
    if error is None:
        return None
    places = tuple(int(p) for p in error[2].split(";") if p)
    return Answer(text, int(error[1]), places, alarmed)
