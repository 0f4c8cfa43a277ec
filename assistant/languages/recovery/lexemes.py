"""Words of a damaged text, read without a parser: what a grammar knows, and what it does not."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Set
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
        for word in self.words(text, start):
            found.append(word)
            beyond += word.type != END and word.start >= stop
            if beyond > further:
                break
        return found

    def words(self, text: str, start: int) -> Iterator[Lexeme]:
        """All from an offset on, END behind the last: read as far as they are asked for."""
        end = -1
        for match in self.pattern.finditer(text, start):
            type = match.lastgroup or STRANGE
            if type in self.silent:
                continue
            begin, end = match.span()
            yield Lexeme(type, match[0], begin, end, _begins_line(text, begin))
        end = _code_end(text, start) if end < 0 else end
        yield Lexeme(END, "", end, end, True)


@dataclass(frozen=True, slots=True)
class Holes:
    """Terminals that stand for what is not there. texts: what each is written as."""

    texts: Mapping[str, str]

    def put(self, types: Iterable[str], at: int) -> tuple[Lexeme, ...]:
        """Words of no width at an offset."""
        return tuple(Lexeme(type, self.texts.get(type, ""), at, at) for type in types)


def _begins_line(text: str, at: int) -> bool:
    """Whether only blanks stand before an offset on its line."""
    while at and text[at - 1] != "\n":
        if not text[at - 1].isspace():
            return False
        at -= 1
    return True


def _code_end(text: str, at: int) -> int:
    """Where the last word before an offset ends."""
    while at and text[at - 1].isspace():
        at -= 1
    return at
