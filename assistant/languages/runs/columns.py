"""Runs: neighbouring rows that are alike, in columns, never a Python object a row.

A field of a `Run` is a column or the value that all rows share. `Names` is a column of names made
of a stem and a running number.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from dataclasses import fields
from itertools import groupby
from typing import Any, Final, Generic, Self, TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

from assistant.base.arrays import Ints, Rows, Truths
from assistant.base.columns import Chosen, Decimal, Integer, Piece
from assistant.base.data_classes import dataclass

MOST_DIGITS: Final = 15
"""Digits of a running number; of longer ones the digits stay with the stem."""
# A number without leading zeros, so that stem and number give the name back.
_NUMBER: Final = re.compile(r"(?<![0-9])(?:0|[1-9][0-9]*)\Z", re.ASCII)


def split_name(name: str) -> tuple[bytes, int]:
    """Stem and number of a name as `Names` holds them, -1 for a name that is its stem."""
    number = _NUMBER.search(name)
    if number is None or len(number[0]) > MOST_DIGITS:
        return name.encode("ascii"), -1
    return name[: number.start()].encode("ascii"), int(number[0])


@dataclass(frozen=True, slots=True, eq=False)
class Names:
    """n names, each a stem followed by a number; one with neither represents a missing name.

    stem: (n,) int32 rows of stems. number: (n,) int64, -1 for a name that is its stem.
    """

    stems: tuple[bytes, ...]
    stem: NDArray[np.int32]
    number: Ints

    def __len__(self) -> int:
        return len(self.stem)

    def equal(self, other: Names) -> Truths:
        """(n,) whether each name is that of the other column."""
        if not len(self):
            return np.empty(0, dtype=bool)
        # The stems are few: compare each pair of them once, then look up the pair of each row.
        same = np.array([[a == b for b in other.stems] for a in self.stems], dtype=bool)
        found: Truths = same[self.stem, other.stem] & (self.number == other.number)
        return found

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Names):
            return NotImplemented
        return len(self) == len(other) and bool(self.equal(other).all())

    def __hash__(self) -> int:
        return hash((len(self), self.number[:1].tobytes()))

    def pieces(self) -> list[Piece]:
        """The names as they are printed."""
        stems = Chosen(self.stem, self.stems)
        if (self.number >= 0).all():
            return [stems, Integer(self.number)]
        missing = np.where(self.number < 0, np.nan, self.number)
        return [stems, Decimal(missing, 0, missing=b"")]

    def name(self, row: int) -> str:
        """One name; for the few, never for all."""
        number = int(self.number[row])
        stem = self.stems[int(self.stem[row])].decode("ascii")
        return f"{stem}{number}" if number >= 0 else stem

    def rows(self, rows: slice | Rows | Truths) -> Names:
        return Names(self.stems, self.stem[rows], self.number[rows])

    def spread(self, rows: Rows, count: int) -> Names:
        """So many names: these at their rows, none elsewhere."""
        stem = np.full(count, len(self.stems), dtype=np.int32)
        number = np.full(count, -1, dtype=np.int64)
        stem[rows], number[rows] = self.stem, self.number
        return Names((*self.stems, b""), stem, number)

    @staticmethod
    def of(names: Sequence[str]) -> Names:
        table: dict[bytes, int] = {}
        parts = [split_name(name) for name in names]
        stem = [table.setdefault(text, len(table)) for text, _ in parts]
        numbers = np.array([number for _, number in parts], dtype=np.int64)
        return Names(tuple(table), np.array(stem, dtype=np.int32), numbers)

    @staticmethod
    def numbered(stem: bytes, numbers: Ints) -> Names:
        """One stem followed by each number."""
        return Names((stem,), np.zeros(len(numbers), dtype=np.int32), numbers)

    @staticmethod
    def none(count: int) -> Names:
        """So many rows without a name."""
        number = np.broadcast_to(np.int64(-1), (count,))
        return Names((b"",), np.broadcast_to(np.int32(0), (count,)), number)

    @staticmethod
    def joined(parts: Sequence[Names]) -> Names:
        """Several columns one behind the other."""
        table: dict[bytes, int] = {}
        stems = [np.empty(0, dtype=np.int32)]
        for part in parts:
            rows = np.array([table.setdefault(t, len(table)) for t in part.stems], dtype=np.int32)
            stems.append(rows[part.stem] if len(part) else np.empty(0, dtype=np.int32))
        numbers = [np.empty(0, dtype=np.int64), *(part.number for part in parts)]
        return Names(tuple(table), np.concatenate(stems), np.concatenate(numbers))


class NameIndex:
    """Finds the rows of a column of names, in any case."""

    def __init__(self, names: Names) -> None:
        self._order = np.lexsort((names.number, names.stem))
        self._numbers = names.number[self._order]
        stems = names.stem[self._order]
        # The first sorted row of each stem.
        bounds = np.searchsorted(stems, np.arange(len(names.stems) + 1))
        self._slices: dict[bytes, list[slice]] = {}
        for at, stem in enumerate(names.stems):
            place = slice(int(bounds[at]), int(bounds[at + 1]))
            self._slices.setdefault(stem.lower(), []).append(place)

    def rows(self, names: Names) -> Rows:
        """Return the row of each name, -1 for an unknown one."""
        found = np.full(len(names), -1, dtype=np.intp)
        for at, stem in enumerate(names.stems):
            if stem.lower() not in self._slices:
                continue
            mine = np.flatnonzero(names.stem == at) if len(names.stems) > 1 else slice(None)
            wanted = names.number[mine]
            hits = np.full(len(wanted), -1, dtype=np.intp)
            for place in self._slices[stem.lower()]:
                rows = sorted_rows(self._numbers[place], wanted)
                hits[rows >= 0] = self._order[place.start + rows[rows >= 0]]
            found[mine] = hits
        return found

    def row(self, name: str) -> Rows:
        """Return `rows` of one name."""
        return self.rows(Names.of([name] if name.isascii() else [""]))


def sorted_rows(known: Ints, wanted: Ints) -> Rows:
    """Return the row of each number among sorted ones, -1 for a number that is missing there."""
    if not len(known):
        return np.full(len(wanted), -1, dtype=np.intp)
    # `searchsorted` gives the length for numbers beyond the last one.
    at = np.minimum(np.searchsorted(known, wanted), len(known) - 1)
    return np.where(known[at] == wanted, at, -1)


def rows_of(known: Ints, wanted: Ints) -> Rows:
    """Return the row of each number among others, -1 for a number that is missing there."""
    order = np.argsort(known, kind="stable")
    at = sorted_rows(known[order], wanted)
    return np.where(at >= 0, order[at] if len(order) else -1, -1)


T = TypeVar("T")
R = TypeVar("R", bound="Run")


@dataclass(frozen=True, slots=True, eq=False)
class Entries(Generic[T]):
    """n entries of a table. index: (n,) int32 rows of table."""

    table: tuple[T, ...]
    index: NDArray[np.int32]

    def __len__(self) -> int:
        return len(self.index)

    def __getitem__(self, row: int) -> T:
        return self.table[int(self.index[row])]

    def equal(self, other: Entries[T]) -> Truths:
        """(n,) whether each entry is that of the other column."""
        if not len(self):
            return np.empty(0, dtype=bool)
        same = np.array([[a == b for b in other.table] for a in self.table], dtype=bool)
        return np.asarray(same[self.index, other.index])

    def rows(self, rows: slice | Rows | Truths) -> Entries[T]:
        return Entries(self.table, self.index[rows])

    @staticmethod
    def of(entries: Iterable[T]) -> Entries[T]:
        """One row for each, equal ones once in the table."""
        table: dict[T, int] = {}
        rows = [table.setdefault(entry, len(table)) for entry in entries]
        return Entries(tuple(table), np.array(rows, dtype=np.int32))

    @staticmethod
    def joined(parts: Sequence[Entries[T]]) -> Entries[T]:
        """Several columns one behind the other, with each entry once in the table."""
        table: dict[T, int] = {}
        index = [np.empty(0, dtype=np.int32)]
        for part in parts:
            rows = [table.setdefault(entry, len(table)) for entry in part.table]
            index.append(np.array(rows, dtype=np.int32)[part.index])
        return Entries(tuple(table), np.concatenate(index))


_Column: TypeAlias = NDArray[Any] | Names | Entries[Any]
_COLUMNS: Final = (np.ndarray, Names, Entries)


@dataclass(frozen=True, slots=True, eq=False)
class Run:
    """n rows. A field is a column or what all rows have in common.

    Texts that they have in common are compared without case. What is left out of comparisons is
    of the run as a whole: parts of it do not have it.
    """

    def _fields(self) -> Iterator[tuple[str, Any]]:
        return ((f.name, getattr(self, f.name)) for f in fields(self) if f.compare)

    def _columns(self) -> Iterator[tuple[str, _Column]]:
        return ((name, x) for name, x in self._fields() if isinstance(x, _COLUMNS))

    def __len__(self) -> int:
        return len(next(self._columns())[1])

    def __eq__(self, other: object) -> bool:
        if type(other) is not type(self):
            return NotImplemented
        assert isinstance(other, Run)
        pairs = zip(self._fields(), other._fields(), strict=True)
        return all(_same(one, two) for (_, one), (_, two) in pairs)

    def __hash__(self) -> int:
        _, first = next(self._columns())
        head = first[:1].tobytes() if isinstance(first, np.ndarray) else hash(first)
        return hash((type(self).__name__, len(first), head))

    def said(self, but: Collection[str] = ()) -> tuple[object, ...]:
        """Return the complete content, to compare and hash. but: columns that may differ."""
        return tuple(
            x.tobytes() if isinstance(x, np.ndarray) else x
            for name, x in self._fields()
            if name not in but
        )

    def fits(self, other: Run) -> bool:
        """True if its rows could be in the other run unchanged."""
        if type(self) is not type(other):
            return False
        pairs = zip(self._fields(), other._fields(), strict=True)
        return all(
            np.shape(one)[1:] == np.shape(two)[1:]
            if isinstance(one, np.ndarray)
            else isinstance(one, _COLUMNS) or one == two
            for (_, one), (_, two) in pairs
        )

    def rows(self, rows: slice | Rows | Truths) -> Self:
        """Some of the rows."""
        return type(self)(**{name: _picked(x, rows) for name, x in self._fields()})

    def equal(self, at: Rows, other: Self, but: Collection[str] = ()) -> Truths:
        """(n,) whether row `at` is the row of another run, whatever all rows have in common.

        but: columns that may differ. Where `at` is negative no row is.
        """
        found: Truths = at >= 0
        if not len(self):
            return found
        for name, column in self._columns():
            if name not in but:
                found = found & _equal(_picked(column, at), getattr(other, name))
        return found


def joined_runs(runs: Sequence[R]) -> R:
    """Several runs as one: what all rows have in common is that of the first."""
    first = runs[0]
    if len(runs) == 1:
        return first
    columns = {
        name: _joined_column([getattr(run, name) for run in runs]) if isinstance(x, _COLUMNS) else x
        for name, x in first._fields()
    }
    return type(first)(**columns)


def _same(one: Any, two: Any) -> bool:
    if type(one) is not type(two):
        return False
    if isinstance(one, np.ndarray):
        return np.array_equal(one, two)
    if isinstance(one, _COLUMNS):
        return len(one) == len(two) and bool(_equal(one, two).all())
    return bool(one.upper() == two.upper()) if isinstance(one, str) else bool(one == two)


def _picked(column: Any, rows: slice | Rows | Truths) -> Any:
    if isinstance(column, np.ndarray):
        return column[rows]
    return column.rows(rows) if isinstance(column, Names | Entries) else column


def _equal(one: Any, two: Any) -> Truths:
    if not isinstance(one, np.ndarray):
        found: Truths = one.equal(two)
        return found
    same = np.asarray(one == two).reshape(len(one), -1)
    return np.asarray(same.all(axis=1))


def _joined_column(parts: Sequence[Any]) -> Any:
    first = parts[0]
    return concatenated(parts) if isinstance(first, np.ndarray) else type(first).joined(parts)


class Store:
    """An array (most, width) whose rows are handed out in turn: joining them copies nothing.

    taken: rows handed out; set back for rows that are not wanted after all.
    """

    def __init__(self, most: int, width: int) -> None:
        self._values = np.empty((most, width))
        self.taken = 0

    def take(self, rows: int) -> NDArray[np.float64]:
        self.taken += rows
        return self._values[self.taken - rows : self.taken]


def concatenated(parts: Sequence[NDArray[Any]]) -> NDArray[Any]:
    """Rows one after the other; neighbours in one array stay where they are."""
    parts = [part for part in parts if len(part)] or list(parts[:1])
    first, base = parts[0], parts[0].base
    if (
        not isinstance(base, np.ndarray)
        or base.dtype != first.dtype
        or base.strides != first.strides
        or base.shape[1:] != first.shape[1:]
        or any(part.base is not base or not part.flags.c_contiguous for part in parts)
    ):
        return np.concatenate(parts)
    begins = [part.__array_interface__["data"][0] for part in parts]
    ends = [begin + part.nbytes for begin, part in zip(begins, parts, strict=True)]
    if begins[1:] != ends[:-1]:
        return np.concatenate(parts)
    start = (begins[0] - base.__array_interface__["data"][0]) // base.strides[0]
    return np.asarray(base[start : start + sum(map(len, parts))])


Row = tuple[object, Any]
"""Key and content of an item that may be joined with others.

Items with equal keys are joined; the content is the item's run or that of a single row.
"""


def gather_runs(
    items: Sequence[T],
    rows: Iterable[Row | None],
    run: Callable[[list[Any]], Run],
    node: Callable[[Sequence[T], Any], T],
    fewest: int,
) -> Iterator[T]:
    """The items, neighbours that are alike as one item if they have enough rows.

    rows: of each item, None for one that is joined with none. run: of single rows. node: the item
    of several, with their run. fewest: rows that make a run; what is less comes as it is.
    """
    for _, pairs in groupby(zip(items, rows, strict=True), lambda pair: pair[1] and pair[1][0]):
        stretch = list(pairs)
        said = [row[1] for _, row in stretch if row is not None]
        if len(said) < 2 or sum(len(x) if isinstance(x, Run) else 1 for x in said) < fewest:
            yield from (item for item, _ in stretch)
            continue
        parts: list[Run] = []
        for is_run, alike in groupby(said, lambda one: isinstance(one, Run)):
            these = list(alike)
            parts += these if is_run else [run(these)]
        yield node([item for item, _ in stretch], joined_runs(parts))
