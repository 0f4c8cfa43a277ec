"""Declared names, in any case: scopes, sets in columns, repetitions and misspellings.

`Symbols` holds the declarations of one scope. `NameSet` holds thousands of names as columns of
stems and numbers.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from itertools import chain
from typing import Final, Generic, TypeVar

import numpy as np

from assistant.base.arrays import Ints, Truths
from assistant.base.data_classes import dataclass
from assistant.languages.runs.columns import Names, split_name

N = TypeVar("N")


@dataclass(frozen=True, slots=True)
class Declaration(Generic[N]):
    """One declared name.

    kind: in the language's own word. type: as written, empty if it has none. local: only its own
    module sees it. node: None for a row of a table. module: the one that contains it.
    """

    name: str
    kind: str
    type: str = ""
    local: bool = False
    node: N | None = None
    module: N | None = None


class Symbols(Generic[N]):
    """The names of one level, in any case."""

    def __init__(self) -> None:
        self._names: dict[str, list[Declaration[N]]] = {}
        self._rows: dict[bytes, list[tuple[Ints, Declaration[N]]]] = {}

    def add(self, declared: Declaration[N]) -> None:
        self._names.setdefault(declared.name.lower(), []).append(declared)

    def add_rows(self, names: Names, declared: Declaration[N]) -> None:
        """Rows of a table. declared: what each of them is, whatever its name."""
        for at, stem in enumerate(names.stems):
            numbers = names.number[names.stem == at]
            self._rows.setdefault(stem.lower(), []).append((numbers, declared))

    def __iter__(self) -> Iterator[Declaration[N]]:
        """Iterate over all declarations except rows."""
        return chain.from_iterable(self._names.values())

    @property
    def names(self) -> Iterable[str]:
        """In lower case, without those of rows."""
        return self._names.keys()

    def all(self, name: str) -> Sequence[Declaration[N]]:
        """Return all declarations of a name except rows."""
        return self._names.get(name.lower(), ())

    def row(self, name: str) -> Declaration[N] | None:
        """The row that declares a name."""
        # Columns of names hold ASCII only.
        stem, number = split_name(name) if name.isascii() and self._rows else (b"", 0)
        for numbers, declared in self._rows.get(stem.lower(), ()):
            if (numbers == number).any():
                return replace(declared, name=name)
        return None

    def find(self, name: str) -> Declaration[N] | None:
        """Return the first declaration of a name; None if it is not declared."""
        found = self.all(name)
        return found[0] if found else self.row(name)


def find_declaration(name: str, levels: Iterable[Symbols[N]]) -> Declaration[N] | None:
    """Return the declaration of a name in the visible levels, the innermost first."""
    return next((found for level in levels if (found := level.find(name)) is not None), None)


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
    # Sorted by scope and name, repeated names are neighbours; the sort keeps the order of rows.
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


K = TypeVar("K", bound=Hashable)
T = TypeVar("T")


def repeated(things: Iterable[T], key: Callable[[T], Hashable | None]) -> Iterator[T]:
    """The things whose key an earlier one has; those without a key are like no other."""
    seen: set[Hashable] = set()
    for thing in things:
        of = key(thing)
        if of is not None and of in seen:
            yield thing
        seen.add(of)


def firsts(things: Iterable[T], key: Callable[[T], Hashable]) -> Iterator[T]:
    """The first thing of each key."""
    seen: set[Hashable] = set()
    for thing in things:
        of = key(thing)
        if of not in seen:
            seen.add(of)
            yield thing


@dataclass(frozen=True, slots=True)
class Keyed(Generic[K, T]):
    """The first thing of each key. unsure: there are things whose key is not known."""

    first: Mapping[K, T]
    unsure: bool

    @staticmethod
    def of(pairs: Iterable[tuple[K | None, T]]) -> Keyed[K, T]:
        """pairs: None for a key that is not known."""
        listed = list(pairs)
        # Backwards, so that the first of each key stays.
        known = {key: thing for key, thing in reversed(listed) if key is not None}
        return Keyed(known, any(key is None for key, _ in listed))

    def without(self, others: Keyed[K, T]) -> Iterator[tuple[K, T]]:
        """Those that certainly have no counterpart among others."""
        # A key that is not known may be that of any of them.
        if not others.unsure:
            yield from ((k, thing) for k, thing in self.first.items() if k not in others.first)


_SHORTEST_COMPARED: Final = 4
"""Least number of characters of a name that is compared with others for a typing mistake."""
_LONG_NAME: Final = 8
"""Characters of a name in which two slips may happen."""


def misspelt(name: str, known: Iterable[str], ending: str = "") -> str:
    """Return the known name that differs from this one by one or two typing mistakes; empty if none
    does.

    A different digit does not count as a mistake: `p10` is not a misspelt `p20`. Neither does the
    ending, in lower case, that many names have in common: `caldata` may well exist next to
    `capdata`.
    """
    low = name.lower()
    if ending and low.endswith(ending):
        stems = [one[: -len(ending)] for one in known if one.lower().endswith(ending)]
        stem = misspelt(low.removesuffix(ending), stems, ending)
        return stem + ending if stem else ""
    most = 2 if len(low) >= _LONG_NAME else 1
    if len(low) < _SHORTEST_COMPARED:
        return ""
    letters = set(low)
    near = (
        (typing_distance(low, other.lower(), most), other)
        for other in known
        # One slip changes the length by one and the set of letters by two at most.
        if abs(len(other) - len(low)) <= most
        and len(letters.symmetric_difference(other.lower())) <= 2 * most
        and digits(other) == digits(low)
    )
    return min((found for found in near if found[0] <= most), default=(0, ""))[1]


def digits(name: str) -> str:
    return "".join(c for c in name if c.isdigit())


def typing_distance(one: str, other: str, most: int) -> int:
    """Letters to add, leave out, change or swap with the next; `most + 1` for any more."""
    before: list[int] = []
    row = list(range(len(other) + 1))
    for i, a in enumerate(one, 1):
        before, last, row = row, before, [i]
        for j, b in enumerate(other, 1):
            cost = min(before[j] + 1, row[j - 1] + 1, before[j - 1] + (a != b))
            if i > 1 and j > 1 and a == other[j - 2] and one[i - 2] == b:
                cost = min(cost, last[j - 2] + 1)
            row.append(cost)
        # No later row has a smaller distance than the least of this one.
        if min(row) > most:
            return most + 1
    return row[-1]
