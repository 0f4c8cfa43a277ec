"""Sets of names, thousands of them in columns."""

from __future__ import annotations

from collections.abc import Sequence, Sized
from functools import cached_property

import numpy as np

from assistant.languages.runs.names import Names, split
from assistant.program.arrays import Ints, Rows, Truths


class NameSet:
    """Names in whatever case.

    words: those that were added one by one, all in upper or all in lower case. columns: others.
    Neither grows any more once the set was asked.
    """

    def __init__(self) -> None:
        self.words: set[str] = set()
        self.columns: list[Names] = []

    def __contains__(self, name: str) -> bool:
        if name in self.words:
            return True
        stem, number = split(name) if name.isascii() and self.columns else (b"", 0)
        columns = self._numbers.get(stem.lower(), ())
        return any(bool((numbers == number).any()) for numbers in columns)

    def among(self, names: Names) -> Truths:
        """(n,) which of the names are in the set."""
        found = np.zeros(len(names), dtype=bool)
        for at, stem in enumerate(names.stems):
            known = [np.empty(0, np.int64), *self._numbers.get(stem.lower(), ())]
            mine = names.stem == at
            found[mine] = np.isin(names.number[mine], np.concatenate(known))
        return found

    @cached_property
    def _numbers(self) -> dict[bytes, list[Ints]]:
        """Numbers of all names by their stems."""
        words = Names.of([word for word in self.words if word.isascii()])
        found: dict[bytes, list[Ints]] = {}
        for column in (words, *self.columns):
            for at, stem in enumerate(column.stems):
                numbers = column.number[column.stem == at]
                found.setdefault(stem.lower(), []).append(numbers)
        return found


def places(columns: Sequence[Sized]) -> tuple[Rows, Rows]:
    """Of each row of columns one behind the other: its column, and the row in that."""
    owner = np.repeat(np.arange(len(columns)), [len(column) for column in columns])
    rows = [np.empty(0, np.intp), *(np.arange(len(column)) for column in columns)]
    return owner, np.concatenate(rows)


def repeats(names: Names, scopes: Ints | None = None) -> tuple[Rows, Rows]:
    """Rows with the name of the row before them, in the order of names: (before, row).

    names: with stems of one case. scopes: (n,) of each row; only rows of one scope are compared.
    """
    around = np.zeros(len(names), dtype=np.int64) if scopes is None else scopes
    order = np.lexsort((names.number, names.stem, around))
    keys = np.stack([names.number[order], names.stem[order], around[order]])
    same = np.flatnonzero((keys[:, 1:] == keys[:, :-1]).all(axis=0))
    return order[same], order[same + 1]
