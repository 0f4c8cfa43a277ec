"""Lines of a text: positions as editors count them, and differences between two states.

A `Place` is a line and a column from 0, columns in UTF-16 units, as browsers and language servers
count; `Lines` converts between places and offsets. `hunks` compares two states line by line, and
`moved_findings` puts findings at the lines that theirs have become.
"""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from difflib import SequenceMatcher
from itertools import accumulate, repeat
from operator import add
from typing import Final

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Span

LINE_END: Final = re.compile(r"\r\n|\n|\r")
"""Line ends of the protocol of language servers (3.17, "Text Documents")."""
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
        """True if no character has two units."""

    def __len__(self) -> int:
        return len(self.lines)

    def line(self, number: int) -> str:
        """A line without its line end."""
        return self.lines[number]

    def length(self, number: int) -> int:
        """Characters of a line without its line end."""
        return len(self.lines[number])

    def place(self, offset: int) -> Place:
        """Return the place of a character offset; the end of the text for a larger offset."""
        offset = min(max(offset, 0), len(self.text))
        line = bisect_right(self.starts, offset) - 1
        start = self.starts[line]
        column = offset - start
        if not self.narrow:
            column += len(_WIDE.findall(self.text, start, offset))
        return Place(line, column)

    def offset(self, place: Place) -> int:
        """Return the character offset of a place; a column after the end of its line gives that
        end.

        A place inside a character of two units gives the start of that character.
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


_MOST_COMPARED: Final = 400
"""Lines that are compared with each other; what differs in more counts as one change."""


@dataclass(frozen=True, slots=True)
class Hunk:
    """Lines that differ: `first` up to `last` of the one text, `new_first` up to `new_last`."""

    first: int
    last: int
    new_first: int
    new_last: int


def hunks(before: Sequence[str], after: Sequence[str]) -> tuple[Hunk, ...]:
    """In the order of the lines; `last` and `new_last` are one behind."""
    most = min(len(before), len(after))
    start = _common_lines(most, lambda a, b: before[a:b] == after[a:b])
    old, new = len(before), len(after)
    end = _common_lines(
        most - start, lambda a, b: before[old - b : old - a] == after[new - b : new - a]
    )
    old, new = old - end, new - end
    if start == old and start == new:
        return ()
    if max(old, new) - start > _MOST_COMPARED:
        return (Hunk(start, old, start, new),)
    matcher = SequenceMatcher(None, before[start:old], after[start:new], autojunk=False)
    return tuple(
        Hunk(start + a, start + b, start + c, start + d)
        for what, a, b, c, d in matcher.get_opcodes()
        if what != "equal"
    )


def _common_lines(most: int, are: Callable[[int, int], bool]) -> int:
    """Return the number of equal lines from 0 on; compares many at once."""
    low, high = 0, most
    while low < high:
        middle = (low + high + 1) // 2
        low, high = (middle, high) if are(low, middle) else (low, middle - 1)
    return low


class LineMoves:
    """Positions of the lines of one text in the next one."""

    def __init__(self, differing: Sequence[Hunk]) -> None:
        self._hunks = differing

    def line(self, number: int) -> int | None:
        """The new number of a line, None if it was changed; both from 0."""
        shift = 0
        for hunk in self._hunks:
            if number < hunk.first:
                break
            if number < hunk.last:
                return None
            shift = hunk.new_last - hunk.last
        return number + shift

    def back(self, number: int) -> int | None:
        """The old number of a line that was not changed."""
        shift = 0
        for hunk in self._hunks:
            if number < hunk.new_first:
                break
            if number < hunk.new_last:
                return None
            shift = hunk.last - hunk.new_last
        return number + shift


def reverted_lines(
    before: Sequence[str], after: Sequence[str], differing: Iterable[Hunk]
) -> tuple[str, ...]:
    """The lines after a change with some of the hunks as they were before."""
    lines = list(after)
    for hunk in sorted(differing, key=lambda one: -one.new_first):
        lines[hunk.new_first : hunk.new_last] = before[hunk.first : hunk.last]
    return tuple(lines)


def moved_findings(findings: Iterable[Diagnostic], moves: LineMoves) -> Iterator[Diagnostic]:
    """Findings at the lines where they stand now; those of changed lines are left out."""
    for finding in findings:
        if finding.line is None:
            yield finding
            continue
        line = moves.line(finding.line - 1)
        if line is None:
            continue
        by = line + 1 - finding.line
        if not by:
            yield finding
            continue
        end = None if finding.end_line is None else finding.end_line + by
        yield replace(finding, line=line + 1, end_line=end)
