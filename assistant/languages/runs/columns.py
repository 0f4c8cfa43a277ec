"""Runs: rows that are alike, in columns, never a Python object a row."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, fields
from typing import Any, Final, Generic, Self, TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

from assistant.base.arrays import Rows, Truths
from assistant.languages.runs.names import Names

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


Column: TypeAlias = NDArray[Any] | Names | Entries[Any]
_COLUMNS: Final = (np.ndarray, Names, Entries)


@dataclass(frozen=True, slots=True, eq=False)
class Run:
    """n rows. A field is a column or what all rows have in common.

    Texts that they have in common are compared without case. What is left out of comparisons is
    of the run as a whole: parts of it do not have it.
    """

    def _fields(self) -> Iterator[tuple[str, Any]]:
        return ((f.name, getattr(self, f.name)) for f in fields(self) if f.compare)

    def _columns(self) -> Iterator[tuple[str, Column]]:
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
        """What it says as a whole, to be compared and hashed. but: columns that may differ."""
        return tuple(
            x.tobytes() if isinstance(x, np.ndarray) else x
            for name, x in self._fields()
            if name not in but
        )

    def fits(self, other: Run) -> bool:
        """Whether its rows could stand in another run as they are."""
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
