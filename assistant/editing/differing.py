"""Where two states of a text differ, line by line, and findings that move with their lines."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from difflib import SequenceMatcher
from typing import Final

from assistant.base.diagnostics import Diagnostic

MOST_COMPARED: Final = 400
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
    if max(old, new) - start > MOST_COMPARED:
        return (Hunk(start, old, start, new),)
    matcher = SequenceMatcher(None, before[start:old], after[start:new], autojunk=False)
    return tuple(
        Hunk(start + a, start + b, start + c, start + d)
        for what, a, b, c, d in matcher.get_opcodes()
        if what != "equal"
    )


def _common_lines(most: int, are: Callable[[int, int], bool]) -> int:
    """How many are equal, from 0 on; many are compared at once."""
    low, high = 0, most
    while low < high:
        middle = (low + high + 1) // 2
        low, high = (middle, high) if are(low, middle) else (low, middle - 1)
    return low


class LineMoves:
    """Where lines of one text stand in the next one."""

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
