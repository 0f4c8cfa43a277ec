"""Text of runs: rows read into columns, and columns of numbers printed.

Blanks are removed from a stretch of rows, so that every row has its marks in the same order; names
and numbers are fetched from between the marks for all rows at once. What does not fit exactly
raises ValueError and is left in the text for the grammar, so that both readers always agree.
Numbers are printed in the fewest decimals that give them back.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cache
from itertools import accumulate, pairwise
from typing import Any, Final, Generic, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from assistant.base.arrays import Floats, Rows, Truths
from assistant.base.columns import WORD, Chosen, Decimal, Offsets, Piece, Slots, rows_text
from assistant.base.data_classes import dataclass
from assistant.languages.runs.columns import MOST_DIGITS, Entries, Names, Run, Store, joined_runs

R = TypeVar("R")
C = TypeVar("C", bound=Run)
E = TypeVar("E")

MOST: Final = 8192
"""Rows read at a time, so that their text and numbers fit the processor's cache."""

_ZERO, _NINE, _POINT, _BLANK = b"09. "


@dataclass(frozen=True, slots=True)
class Found(Generic[R]):
    """A run in a text: its offsets and its node."""

    start: int
    end: int
    node: R

    def moved(self, by: int) -> Found[R]:
        return Found(self.start + by, self.end + by, self.node)


def stretches(
    text: str, start: int, end: int, fewest: int, store: Store, read: Callable[[bytes], R]
) -> Iterator[Found[R]]:
    """The runs of a stretch of rows, a line each; where one is damaged it is halved around it."""
    stretch = text[start:end]
    if stretch.count("\n") + (not stretch.endswith("\n")) < fewest:
        return
    before = store.taken
    try:
        node = read(stretch.encode("ascii"))
    except ValueError:
        # Rows handed out for the attempt are free again.
        store.taken = before
        middle = text.find("\n", start + (end - start) // 2, end - 1) + 1
        if middle > start:
            yield from stretches(text, start, middle, fewest, store, read)
            yield from stretches(text, middle, end, fewest, store, read)
        return
    yield Found(start, end, node)


def line_spans(data: bytes, end: bytes, *, ended: bool) -> Rows:
    """(n, 2) offsets of the rows of a stretch, without the blanks around them.

    end: the byte that ends each row, which no row has elsewhere. ended: True if it belongs to them.
    """
    text = np.frombuffer(data, dtype=np.uint8)
    ends = np.flatnonzero(text == end[0])
    starts = np.concatenate([[0], ends[:-1] + 1])
    # Blanks in front of all rows at once, a column of characters each turn.
    while (blank := text[starts] <= _BLANK).any():
        starts += blank
    while not ended and (blank := text[ends - 1] <= _BLANK).any():
        ends -= blank
    return np.stack([starts, ends + ended], axis=1)


def in_parts(data: bytes, read: Callable[[bytes], C]) -> C:
    """The run of many lines, each part of which fits the processor's cache."""
    ends = np.flatnonzero(np.frombuffer(data, dtype=np.uint8) == ord("\n")) + 1
    bounds = [0, *ends[MOST - 1 : -1 : MOST].tolist(), len(data)]
    return joined_runs([read(data[start:end]) for start, end in pairwise(bounds)])


class Marks:
    """The marks of rows without blanks, with the decimal point before each where there is one.

    which: what is a mark. signs, offsets, points: (marks,); a mark without a point has its own
    offset. first: (n,) the first mark of each row. rows, stops: (n,) where rows begin, and the mark
    that ends each.
    """

    def __init__(self, text: Slots, marks: bytes, end: bytes) -> None:
        letters = text.bytes
        self.which = marks + end
        found = letters == _POINT
        for mark in self.which:
            found |= letters == mark
        at = np.flatnonzero(found)
        signs = letters[at]
        mark_at = np.flatnonzero(signs != _POINT)
        before = mark_at - 1  # of the very first mark the last one, which is no point
        pointed = signs.take(before) == _POINT
        # Each point has to be the one before a mark.
        if np.count_nonzero(pointed) + len(mark_at) != len(at):
            raise ValueError("a number has two points")
        self.signs, self.offsets = signs.take(mark_at), at.take(mark_at)
        self.points = np.where(pointed, at.take(before), self.offsets)
        ends = np.flatnonzero(self.signs == end[0])
        self.stops = self.offsets[ends]
        self.first = np.concatenate([[0], ends[:-1] + 1])
        self.rows = np.concatenate([[WORD], self.stops[:-1] + 1])

    def table(self, column: NDArray[Any], count: int) -> NDArray[Any]:
        """The first `count` marks of each row; ValueError if one has less."""
        n = len(self.rows)
        if len(column) == n * count:
            return column.reshape(n, count)
        if self.first[-1] + count > len(column):
            raise ValueError("a row is too short")
        return np.asarray(column[self.first[:, None] + np.arange(count)])


def _all_rows_equal(text: Slots, starts: Offsets, ends: Offsets) -> bool:
    """True if all rows have the same bytes; then one row is read for all."""
    first = text.bytes[starts[0] : ends[0]].tobytes()
    return bool((ends - starts == len(first)).all() and text.holds(first, starts).all())


def after_digits(letters: NDArray[np.uint8], starts: Offsets) -> Offsets:
    """The offset behind the digits that stand at each start."""
    other = np.flatnonzero((letters < _ZERO) | (letters > _NINE))
    return np.asarray(other[np.searchsorted(other, starts)])


# Words


@dataclass(frozen=True, slots=True)
class NameWords:
    """Valid names. longest: characters. reserved: words in lower case that are not names."""

    longest: int
    reserved: frozenset[str]

    def names(self, text: Slots, starts: Offsets, ends: Offsets) -> Names:
        """Splits names into stems and numbers; ValueError if one cannot be a name."""
        if not len(starts):
            return Names((), np.empty(0, dtype=np.int32), np.empty(0, dtype=np.int64))
        lengths = ends - starts
        if int(lengths.max()) > self.longest:
            raise ValueError("a name is too long")
        alone = numbered_names(text, starts, ends)
        return self._different(text, starts, lengths) if alone is None else alone

    def _different(self, text: Slots, starts: Offsets, lengths: Offsets) -> Names:
        fields = text.fields(starts, lengths)
        n, width = len(fields), fields.dtype.itemsize
        letters = fields.view(np.uint8).reshape(n, width)
        filled = letters != 0
        digit = (letters >= _ZERO) & (letters <= _NINE)
        # Digits up to the end of each name: from the right, as long as there is nothing else.
        tail = np.logical_and.accumulate((digit | ~filled)[:, ::-1], axis=1)[:, ::-1] & filled
        count = tail.sum(axis=1)
        # leading zeros, and more digits than an integer holds, stay with the stem
        lead = letters[np.arange(n), np.minimum(lengths - count, width - 1)]
        plain: Truths = (count > 0) & (count <= MOST_DIGITS) & ((lead != _ZERO) | (count == 1))
        number, _ = text.whole(starts + lengths, np.where(plain, count, 0))
        stems = np.where(tail & plain[:, None], 0, letters).astype(np.uint8).view(f"S{width}")
        index, table = _distinct(stems[:, 0])
        words = np.array([stem.decode("ascii").lower() in self.reserved for stem in table])
        if (words[index] & ~plain).any():
            raise ValueError("a name is a reserved word")
        return Names(tuple(table), index, np.where(plain, number, -1))


def numbered_names(text: Slots, starts: Offsets, ends: Offsets) -> Names | None:
    """Names of one stem, with a number each; None for others."""
    stem = text.bytes[starts[0] : ends[0]].tobytes().rstrip(b"0123456789")
    count = ends - starts - len(stem)
    if not (count.min() >= 1 and count.max() <= MOST_DIGITS and text.holds(stem, starts).all()):
        return None
    number, good = text.whole(ends, count)
    leading = (text.bytes[ends - count] == _ZERO) & (count > 1)
    if leading.any() or not good.all():
        return None
    return Names.numbered(stem, number)


def entries(
    text: Slots, starts: Offsets, ends: Offsets, longest: int, read: Callable[[bytes], E]
) -> Entries[E]:
    """Read the text of each row between two offsets, each different text once.

    longest: bytes of one; ValueError if a different one has more.
    """
    if _all_rows_equal(text, starts, ends):
        only = read(text.bytes[starts[0] : ends[0]].tobytes())
        return Entries((only,), np.zeros(len(starts), dtype=np.int32))
    lengths = ends - starts
    if int(lengths.max()) > longest:
        raise ValueError("a row is too long")
    index, different = _distinct(text.fields(starts, lengths))
    once = Entries.of(map(read, different))
    return Entries(once.table, once.index[index])


def _distinct(values: NDArray[np.bytes_]) -> tuple[NDArray[np.int32], list[bytes]]:
    """Index of each value in the list of different ones, in order of first appearance."""
    # Equal neighbours count once, which leaves few values to sort.
    change = np.concatenate([[True], values[1:] != values[:-1]])
    firsts = values[change]
    table, first, inverse = np.unique(firsts, return_index=True, return_inverse=True)
    # `unique` sorts by value; the table keeps the order of appearance.
    order = np.argsort(first)
    rank = np.empty(len(table), dtype=np.int32)
    rank[order] = np.arange(len(table), dtype=np.int32)
    index = rank[inverse][np.cumsum(change) - 1]
    return index, [bytes(v) for v in table[order]]


_MOST_DECIMALS: Final = 1e6
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
        """Read the numbers of rows into values (n, width); return the mark after each row, (n,).

        first: marks of a row before the groups, which begin at `begins`. behind: text that follows.
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
            rows = slice(1 if _all_rows_equal(text, start, stops[:, -1]) else len(stops))
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
    """One group of numbers.

    columns: of its numbers. marks: those that end each of them. after: text after it, and before:
    length of that text before the first mark in it.
    """

    columns: slice
    marks: slice
    after: bytes
    before: int


@cache
def _group_layout(groups: Groups, behind: bytes, which: bytes) -> tuple[bytes, tuple[_Group, ...]]:
    """Return the marks of the groups and of the text after them, and the groups' parts."""
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
        # A column of one value is printed once.
        if len(values) > 1 and (values == values[0]).all():
            return [rows_text(self.pieces(values[:1]), 1)]
        large = np.abs(values) >= _MOST_DECIMALS
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
