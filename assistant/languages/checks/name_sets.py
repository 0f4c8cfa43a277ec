"""Sets of names, thousands of them in columns."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from assistant.base.arrays import Ints, Truths
from assistant.languages.runs.names import Names, split_name


class NameSet:
    """Names in whatever case.

    words: those that were added one by one, all in upper or all in lower case. columns: others.
    beginnings: of names that are put together as a program runs, in the case of the words; whatever
    begins so is in the set. None of them grows any more once the set was asked.
    """

    def __init__(self) -> None:
        self.words: set[str] = set()
        self.columns: list[Names] = []
        self.beginnings: set[str] = set()

    def __contains__(self, name: str) -> bool:
        """The name is in the case of the words."""
        if name in self.words or self._is_begun(name):
            return True
        stem, number = split_name(name) if name.isascii() and self.columns else (b"", 0)
        columns = self._numbers.get(stem.lower(), ())
        return any(bool((numbers == number).any()) for numbers in columns)

    def _is_begun(self, name: str) -> bool:
        return any(name.startswith(begin) for begin in self.beginnings)

    def among(self, names: Names) -> Truths:
        """(n,) which of the names are in the set; beginnings have to be in lower case."""
        found = np.zeros(len(names), dtype=bool)
        for at, stem in enumerate(names.stems):
            known = [np.empty(0, np.int64), *self._numbers.get(stem.lower(), ())]
            mine = names.stem == at
            begun = self._is_begun(stem.lower().decode("ascii"))
            found[mine] = begun or np.isin(names.number[mine], np.concatenate(known))
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


Row = tuple[int, int]
"""A column of names, and a row of it."""


def repeated_rows(columns: Sequence[Names], scopes: Sequence[int] = ()) -> list[tuple[Row, Row]]:
    """Rows whose name, in any case, an earlier row has, with that row, in the order of names.

    scopes: of each column; only rows of one scope are compared.
    """
    lowered = [Names(tuple(t.lower() for t in n.stems), n.stem, n.number) for n in columns]
    names = Names.joined(lowered)
    owner = np.repeat(np.arange(len(columns)), [len(column) for column in columns])
    row = np.concatenate([np.empty(0, np.intp), *(np.arange(len(column)) for column in columns)])
    around = np.array(scopes)[owner] if scopes else np.zeros(len(names), dtype=np.int64)
    order = np.lexsort((names.number, names.stem, around))
    keys = np.stack([names.number[order], names.stem[order], around[order]])
    same = np.flatnonzero((keys[:, 1:] == keys[:, :-1]).all(axis=0))
    places = np.stack([owner, row], axis=1)
    pairs = zip(places[order[same]].tolist(), places[order[same + 1]].tolist(), strict=True)
    return [((one, at), (other, again)) for (one, at), (other, again) in pairs]
