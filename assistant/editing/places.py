"""Places in a text as editors count them: lines and columns from 0, columns in UTF-16 units."""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import accumulate, repeat
from operator import add
from typing import Final

from assistant.base.diagnostics import Span

LINE_END: Final = re.compile(r"\r\n|\n|\r")
"""What ends a line for the protocol of language servers (3.17, "Text Documents")."""
_KEPT_END: Final = re.compile(rf"({LINE_END.pattern})")
_WIDE: Final = re.compile(r"[\U00010000-\U0010ffff]")


@dataclass(frozen=True, slots=True, order=True)
class Place:
    """line: from 0. column: from 0, in units of UTF-16, as browsers and editors count."""

    line: int
    column: int


@dataclass(frozen=True, slots=True, order=True)
class Range:
    """From a place to just before another one."""

    start: Place
    end: Place


class Lines:
    """The lines of a text, and its places both ways."""

    def __init__(self, text: str) -> None:
        self.text = text
        self.lines, behind = _split(text)
        """Each without its line end."""
        ends: Iterable[int] = accumulate(map(add, map(len, self.lines), behind))
        self.starts = [0, *ends][: len(self.lines)]
        """Offset at which each line begins."""
        self.narrow = text.isascii() or _WIDE.search(text) is None
        """Whether no character has two units."""

    def __len__(self) -> int:
        return len(self.lines)

    def line(self, number: int) -> str:
        """A line without its line end."""
        return self.lines[number]

    def length(self, number: int) -> int:
        """Characters of a line without its line end."""
        return len(self.lines[number])

    def place(self, offset: int) -> Place:
        """The place of a character offset; the end of the text for what lies behind it."""
        offset = min(max(offset, 0), len(self.text))
        line = bisect_right(self.starts, offset) - 1
        start = self.starts[line]
        column = offset - start
        if not self.narrow:
            column += len(_WIDE.findall(self.text, start, offset))
        return Place(line, column)

    def offset(self, place: Place) -> int:
        """The character offset of a place; one behind the end of its line is that end.

        A place inside of a character of two units is that character's begin.
        """
        if place.line < 0:
            return 0
        if place.line >= len(self.starts):
            return len(self.text)
        start = self.starts[place.line]
        end = start + len(self.lines[place.line])
        if self.narrow:
            return min(start + max(place.column, 0), end)
        units, at = 0, start
        while at < end:
            units += 2 if self.text[at] > "\uffff" else 1
            if units > place.column:
                break
            at += 1
        return at

    def range(self, span: Span) -> Range:
        return Range(self.place(span.start), self.place(span.end))

    def span(self, range: Range) -> Span:
        """Its character offsets; the smaller one first."""
        one, two = self.offset(range.start), self.offset(range.end)
        return Span(min(one, two), max(one, two))


def _split(text: str) -> tuple[list[str], Iterable[int]]:
    """The lines, and how many characters end each; nearly every text has one kind of line end."""
    feeds, returns = text.count("\n"), text.count("\r")
    if not returns:
        return text.split("\n"), repeat(1)
    if feeds == returns == text.count("\r\n"):
        return text.split("\r\n"), repeat(2)
    parts = _KEPT_END.split(text)
    return parts[::2], [*map(len, parts[1::2]), 0]
