"""A text with a mark in place of each run of alike lines that is read otherwise."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import accumulate
from typing import Protocol, TypeVar


class TextSpan(Protocol):
    """Lines of a text. start, end: offsets."""

    @property
    def start(self) -> int: ...
    @property
    def end(self) -> int: ...


R = TypeVar("R", bound=TextSpan)


@dataclass(frozen=True, slots=True)
class RunInTheWay:
    """A run that the text before it wants the first row of."""

    number: int


@dataclass(frozen=True, slots=True)
class Shortened:
    """What a grammar reads, and the way from its offsets to those of the source and back.

    begins, shifts: offsets in the short text from which on its places are so much farther on in
    the source.
    """

    text: str
    runs: Sequence[TextSpan]
    begins: list[int]
    shifts: list[int]

    @staticmethod
    def of(text: str, runs: Sequence[R], marks: Callable[[R], tuple[str, str]]) -> Shortened:
        """marks: characters around the number of a run, which the text does not have."""
        pieces, at = [], 0
        lengths, removed = [], []
        for number, run in enumerate(runs):
            opening, closing = marks(run)
            mark = f"{opening}{number}{closing}\n"
            pieces += [text[at : run.start], mark]
            lengths.append(run.start - at + len(mark))
            removed.append(run.end - run.start - len(mark))
            at = run.end
        pieces.append(text[at:])
        begins = list(accumulate(lengths, initial=0))
        return Shortened("".join(pieces), runs, begins, list(accumulate(removed, initial=0)))

    def offset(self, short: int) -> int:
        """Offset in the source."""
        return short + self.shifts[bisect_right(self.begins, short) - 1]

    def back(self, offset: int) -> int:
        """Offset in the short text; of its mark for one in a run."""
        row = bisect_right(self.runs, offset, key=lambda run: run.start) - 1
        if row < 0:
            return offset
        run = self.runs[row]
        if offset < run.end:
            return run.start - self.shifts[row]
        return offset - self.shifts[row + 1]

    def run_around(self, text: str, offset: int) -> int | None:
        """Number of the run that an offset of the source lies inside of, behind its first word."""
        row = bisect_right(self.runs, offset, key=lambda run: run.start) - 1
        if row < 0 or offset >= self.runs[row].end:
            return None
        return row if text[self.runs[row].start : offset].strip() else None


def number_of(mark: str) -> int:
    """The number of the run that a mark stands for."""
    return int(mark[1:-1])
