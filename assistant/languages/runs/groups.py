"""Groups of numbers in brackets, read from rows of text and printed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import accumulate
from typing import Final, NamedTuple

import numpy as np

from assistant.base.arrays import Floats
from assistant.base.columns import Chosen, Decimal, Offsets, Piece, Slots, rows_text
from assistant.languages.runs.reading import Marks, all_rows_equal

MOST_DECIMALS: Final = 1e6
"""Smaller values have nine exact decimals in a double."""


@dataclass(frozen=True, slots=True)
class Groups:
    """Groups of numbers with commas between them.

    sizes: numbers of each group. opening, between, closing: what stands around and between groups.
    known: spellings of one number that many rows hold.
    """

    sizes: tuple[int, ...]
    opening: bytes
    between: bytes
    closing: bytes
    known: tuple[tuple[bytes, float], ...] = ()

    def read(
        self, text: Slots, marks: Marks, first: int, begins: Offsets, behind: bytes, values: Floats
    ) -> Offsets:
        """Puts the numbers of rows into values (n, width); gives the mark behind each, (n,).

        first: marks of a row before the groups, which begin at `begins`. behind: what follows.
        """
        wanted, parts = _group_layout(self, behind, marks.which)
        tables = (marks.offsets, marks.signs, marks.points)
        count = first + len(wanted)
        offsets, signs, points = (marks.table(column, count)[:, first:] for column in tables)
        expected = np.frombuffer(wanted, dtype=np.uint8)
        sound = (signs == expected).all() and text.holds(self.opening, begins).all()
        start = begins + len(self.opening)
        for part in parts:
            stops = offsets[:, part.marks].copy()
            stops[:, -1] -= part.before
            sound = sound and (len(part.after) == 1 or text.holds(part.after, stops[:, -1]).all())
            if not sound:
                raise ValueError("brackets or commas are out of place")
            rows = slice(1 if all_rows_equal(text, start, stops[:, -1]) else len(stops))
            starts = np.column_stack([start[rows], stops[rows, :-1] + 1])
            pointed = np.minimum(points[rows, part.marks], stops[rows])
            values[:, part.columns] = text.decimals(starts, stops[rows], pointed, self.known)
            start = stops[:, -1] + len(part.after)
        if not np.isfinite(values).all():
            raise ValueError("a number is too large")
        return np.asarray(offsets[:, -1])

    def pieces(self, columns: Sequence[Sequence[Piece]]) -> list[Piece]:
        """The numbers as they are printed. columns: pieces of each column of them."""
        firsts = set(accumulate(self.sizes))
        pieces: list[Piece] = [self.opening]
        for at, column in enumerate(columns):
            between = self.between if at in firsts else b"," if at else b""
            pieces += [between, *column]
        return [*pieces, self.closing]


class _Group(NamedTuple):
    """One group. columns: of its numbers. marks: those that end each of them. after: what stands
    behind it, and before: how much of that stands before the first mark in it.
    """

    columns: slice
    marks: slice
    after: bytes
    before: int


@cache
def _group_layout(groups: Groups, behind: bytes, which: bytes) -> tuple[bytes, tuple[_Group, ...]]:
    """The marks of groups, and what stands behind them, and their parts."""
    wanted, parts, column = b"", list[_Group](), 0
    for at, size in enumerate(groups.sizes, 1):
        after = groups.between if at < len(groups.sizes) else groups.closing + behind
        inside = bytes(letter for letter in after if letter in which)
        columns, marks = (slice(start, start + size) for start in (column, len(wanted)))
        parts.append(_Group(columns, marks, after, after.index(inside[:1])))
        wanted += b"," * (size - 1) + inside
        column += size
    return wanted, tuple(parts)


@dataclass(frozen=True, slots=True)
class FewestDecimals:
    """Prints a column in the fewest decimals that give it back; odd values as Python writes them.

    places: decimals, ascending. spelled: how some values are written.
    """

    places: tuple[int, ...]
    spelled: Mapping[float, bytes]

    def pieces(self, values: Floats) -> list[Piece]:
        """A column (n,) of numbers."""
        if len(values) > 1 and (values == values[0]).all():
            return [rows_text(self.pieces(values[:1]), 1)]
        large = np.abs(values) >= MOST_DECIMALS
        for places in self.places:
            if not large.any() and (np.round(values, places) == values).all():
                return [Decimal(values, places, strip=True)]
        most = self.places[-1]
        odd = large | (np.round(values, most) != values)
        different, index = np.unique(values[odd], return_inverse=True)
        texts = [self.spelled.get(v) or repr(v).encode("ascii") for v in different.tolist()]
        chosen = np.zeros(len(values), dtype=np.int64)
        chosen[odd] = index + 1
        pieces: list[Piece] = [Chosen(chosen, (b"", *texts))]
        if not odd.all():
            plain = np.where(odd, np.nan, values)
            pieces.append(Decimal(plain, most, strip=True, missing=b""))
        return pieces


def decimals_needed(values: Floats, least: int, most: int) -> int:
    """The fewest decimals in a range that print every value without loss, else the most."""
    known = values[~np.isnan(values)]
    for places in range(least, most):
        if np.array_equal(np.round(known, places), known):
            return places
    return most
