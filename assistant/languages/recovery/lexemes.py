"""Words of a damaged text, read without a parser: what a grammar knows, and what it does not."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Set
from dataclasses import dataclass
from typing import Final, NamedTuple

from assistant.languages.lalr import END

STRANGE: Final = "STRANGE"
"""The type of what no terminal begins with."""


class Lexeme(NamedTuple):
    """type: a terminal of the grammar, END, or one of what is no terminal. first: on its line.

    start, end: offsets in the source; alike for what a repair puts in.
    """

    type: str
    text: str
    start: int
    end: int
    first: bool = False


class Stop(NamedTuple):
    """A word that does not fit.

    word: its type is END behind the last one. start: rule of the grammar.
    """

    word: Lexeme
    start: str


@dataclass(frozen=True, slots=True)
class Scanner:
    """Finds words by one regular expression, a group a type. silent: types between words."""

    pattern: re.Pattern[str]
    silent: Set[str]

    def lexemes(self, text: str, start: int, stop: int, further: int) -> list[Lexeme]:
        """All from one offset to another and a few further, END behind the last of the text."""
        found: list[Lexeme] = []
        beyond = 0
        end = start
        for match in self.pattern.finditer(text, start):
            type = match.lastgroup or STRANGE
            if type in self.silent:
                continue
            begin, end = match.span()
            line = text.rfind("\n", 0, begin) + 1
            found.append(Lexeme(type, match[0], begin, end, not text[line:begin].strip()))
            beyond += begin >= stop
            if beyond > further:
                return found
        end = end if found else len(text[:start].rstrip())
        return [*found, Lexeme(END, "", end, end, True)]


@dataclass(frozen=True, slots=True)
class Holes:
    """Terminals that stand for what is not there. texts: what each is written as."""

    texts: Mapping[str, str]

    def put(self, types: Iterable[str], at: int) -> tuple[Lexeme, ...]:
        """Words of no width at an offset."""
        return tuple(Lexeme(type, self.texts.get(type, ""), at, at) for type in types)
