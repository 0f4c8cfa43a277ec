"""Sets of lines, as bits of one number: those of a long program are many, and nearly alike."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Final

ELSEWHERE: Final = -1
"""A line of another program."""


@dataclass(frozen=True, slots=True)
class LineSet:
    """Places of lines, and ELSEWHERE. bits: the last one for ELSEWHERE, the next for line 0."""

    bits: int = 0

    @staticmethod
    def of(places: Iterable[int]) -> LineSet:
        marks = bytearray()
        for place in places:
            byte, bit = divmod(place - ELSEWHERE, 8)
            if byte >= len(marks):
                marks.extend(bytes(byte + 1 - len(marks)))
            marks[byte] |= 1 << bit
        return LineSet(int.from_bytes(marks, "little"))

    def __or__(self, other: LineSet) -> LineSet:
        """Those of both; one of the two if it has them all, so that many lines share one set."""
        bits = self.bits | other.bits
        if bits == self.bits:
            return self
        return other if bits == other.bits else LineSet(bits)

    def __sub__(self, other: LineSet) -> LineSet:
        return LineSet(self.bits & ~other.bits)

    def __bool__(self) -> bool:
        return bool(self.bits)

    def __iter__(self) -> Iterator[int]:
        """In their order."""
        said = bin(self.bits)[:1:-1]
        at = said.find("1")
        while at >= 0:
            yield at + ELSEWHERE
            at = said.find("1", at + 1)


NO_LINES: Final = LineSet()
