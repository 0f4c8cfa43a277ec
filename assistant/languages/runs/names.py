"""Names made of a stem and a running number, in columns."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from assistant.base.arrays import Ints, Rows, Truths
from assistant.base.columns import Chosen, Decimal, Integer, Piece

MOST_DIGITS: Final = 15
"""Digits of a running number; of longer ones the digits stay with the stem."""
_NUMBER: Final = re.compile(r"(?<![0-9])(?:0|[1-9][0-9]*)\Z", re.ASCII)


def split_name(name: str) -> tuple[bytes, int]:
    """Stem and number of a name as `Names` holds them, -1 for a name that is its stem."""
    number = _NUMBER.search(name)
    if number is None or len(number[0]) > MOST_DIGITS:
        return name.encode("ascii"), -1
    return name[: number.start()].encode("ascii"), int(number[0])


@dataclass(frozen=True, slots=True, eq=False)
class Names:
    """n names, each a stem and a number behind it; one of neither stands for no name.

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
        bounds = np.searchsorted(stems, np.arange(len(names.stems) + 1))
        self._slices: dict[bytes, list[slice]] = {}
        for at, stem in enumerate(names.stems):
            place = slice(int(bounds[at]), int(bounds[at + 1]))
            self._slices.setdefault(stem.lower(), []).append(place)

    def rows(self, names: Names) -> Rows:
        """The row of each name, -1 if it is none."""
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
        """As `rows` of one name."""
        return self.rows(Names.of([name] if name.isascii() else [""]))


def sorted_rows(known: Ints, wanted: Ints) -> Rows:
    """Where each number stands among sorted ones, -1 for one that does not."""
    if not len(known):
        return np.full(len(wanted), -1, dtype=np.intp)
    at = np.minimum(np.searchsorted(known, wanted), len(known) - 1)
    return np.where(known[at] == wanted, at, -1)


def rows_of(known: Ints, wanted: Ints) -> Rows:
    """Where each number stands among others, -1 for one that does not."""
    order = np.argsort(known, kind="stable")
    at = sorted_rows(known[order], wanted)
    return np.where(at >= 0, order[at] if len(order) else -1, -1)
