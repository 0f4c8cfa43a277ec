"""Names that a program declares, one level for each part of it that has names of its own."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import chain
from typing import Generic, TypeVar

from assistant.base.arrays import Ints
from assistant.languages.runs.names import Names, split_name

N = TypeVar("N")


@dataclass(frozen=True, slots=True)
class Declaration(Generic[N]):
    """One declared name.

    kind: what it is, in the language's own word. type: as written, empty where there is none.
    local: only its own module sees it. node: None for a row of a table. module: that it stands in.
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
        """Every declaration that is no row."""
        return chain.from_iterable(self._names.values())

    @property
    def names(self) -> Iterable[str]:
        """In lower case, without those of rows."""
        return self._names.keys()

    def all(self, name: str) -> Sequence[Declaration[N]]:
        """Every declaration of a name that is no row."""
        return self._names.get(name.lower(), ())

    def row(self, name: str) -> Declaration[N] | None:
        """The row that declares a name."""
        stem, number = split_name(name) if name.isascii() and self._rows else (b"", 0)
        for numbers, declared in self._rows.get(stem.lower(), ()):
            if (numbers == number).any():
                return replace(declared, name=name)
        return None

    def find(self, name: str) -> Declaration[N] | None:
        """The first declaration of a name, None if there is none."""
        found = self.all(name)
        return found[0] if found else self.row(name)


def find_declaration(name: str, levels: Iterable[Symbols[N]]) -> Declaration[N] | None:
    """What a name means where some levels are seen, the innermost first."""
    return next((found for level in levels if (found := level.find(name)) is not None), None)
