"""Words of a damaged text, read without a parser: what the grammar knows, and what it does not."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from assistant.languages.rapid.reading.scanner import SILENT, scanner

END: Final = "$END"


@dataclass(frozen=True, slots=True)
class Lexeme:
    """type: a terminal of the grammar, END or a row above. first: on its line.

    start, end: offsets in the source; alike for what a repair puts in.
    """

    type: str
    text: str
    start: int
    end: int
    first: bool = False


def lexemes(text: str, start: int, stop: int, further: int) -> list[Lexeme]:
    """All from one offset to another and a few further, END behind the last of the text."""
    found: list[Lexeme] = []
    beyond = 0
    end = start
    for match in scanner().finditer(text, start):
        type = match.lastgroup or "STRANGE"
        if type in SILENT:
            continue
        begin, end = match.span()
        line = text.rfind("\n", 0, begin) + 1
        found.append(Lexeme(type, match[0], begin, end, not text[line:begin].strip()))
        beyond += begin >= stop
        if beyond > further:
            return found
    end = end if found else len(text[:start].rstrip())
    return [*found, Lexeme(END, "", end, end, True)]
