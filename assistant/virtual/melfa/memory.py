"""Variables of a running program: cells by name, arrays, and references to either."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Final

from assistant.virtual.melfa.stops import Failed, Unknown
from assistant.virtual.melfa.values import Kind, Value, converted

Index = tuple[int, ...]

LETTERS: Final[Mapping[str, Kind]] = {"P": "position", "J": "joints"}
SUFFIXES: Final[Mapping[str, Kind]] = {
    "%": "integer", "&": "long", "!": "number", "#": "number", "$": "text",
}  # fmt: skip
DEFINED: Final[Mapping[str, Kind]] = {
    "Inte": "integer", "Long": "long", "Float": "number", "Double": "number", "Char": "text",
    "Pos": "position", "Jnt": "joints",
}  # fmt: skip
"""Type of `Def …`."""


OWN_ARRAY: Final = re.compile(r"[PJMC]_10[0-4]")
OWN_ELEMENTS: Final = 10
"""Arrays that all programs share on every controller, and how many elements each has."""


def kind_by_name(name: str) -> Kind:
    """The type of a name that nothing declares; an external one that begins with C is a text."""
    if name[:2] == "C_":
        return "text"
    return LETTERS.get(name[:1], "number")


def is_external(name: str) -> bool:
    """Whether all programs share it (CR1D 4.3.7)."""
    return name[1:2] == "_"


@dataclass(slots=True)
class Cell:
    """A variable. size: extents of an array, empty for a single value."""

    name: str
    kind: Kind
    size: Index = ()
    values: dict[Index, Value] = field(default_factory=dict)

    def get(self, index: Index = ()) -> Value:
        self._check(index)
        if index not in self.values:
            raise Failed(3700, f"the variable {self._said(index)} has no value")
        return self.values[index]

    def set(self, value: Value, index: Index = ()) -> None:
        self._check(index)
        self.values[index] = converted(value, self.kind, self._said(index))

    def is_set(self, index: Index = ()) -> bool:
        self._check(index)
        return index in self.values

    def copy(self, name: str) -> Cell:
        """For an array that is given by value."""
        return Cell(name, self.kind, self.size, dict(self.values))

    def _check(self, index: Index) -> None:
        if len(index) != len(self.size):
            if not index:
                raise Unknown(f"the array {self.name} without a subscript")
            raise Failed(4370, f"{self._said(index)} is no element of an array")
        if any(not 1 <= i <= n for i, n in zip(index, self.size, strict=True)):
            raise Failed(4370, f"there is no element {self._said(index)}")

    def _said(self, index: Index) -> str:
        return f"{self.name}({','.join(map(str, index))})" if index else self.name


@dataclass(slots=True)
class Element:
    """One element of an array under a name of its own: a reference that a Function takes."""

    cell: Cell
    at: Index

    @property
    def kind(self) -> Kind:
        return self.cell.kind

    def get(self, index: Index = ()) -> Value:
        self._check(index)
        return self.cell.get(self.at)

    def set(self, value: Value, index: Index = ()) -> None:
        self._check(index)
        self.cell.set(value, self.at)

    def is_set(self, index: Index = ()) -> bool:
        self._check(index)
        return self.cell.is_set(self.at)

    def _check(self, index: Index) -> None:
        if index:
            raise Failed(4370, f"{self.cell.name} is no array here")


Storage = Cell | Element


@dataclass(slots=True)
class Scope:
    """Types and extents as the text of a program or of a function declares them."""

    kinds: dict[str, Kind] = field(default_factory=dict)
    sizes: dict[str, Index] = field(default_factory=dict)
    declared: set[str] = field(default_factory=set)
    static: set[str] = field(default_factory=set)

    def cell(self, name: str) -> Cell:
        return Cell(name, self.kinds.get(name, kind_by_name(name)), self.sizes.get(name, ()))


@dataclass(slots=True)
class Memory:
    """Variables by upper-case name, made when they are first met."""

    scope: Scope
    places: dict[str, Storage] = field(default_factory=dict)

    def place(self, name: str) -> Storage:
        found = self.places.get(name)
        if found is None:
            found = self.places[name] = self.scope.cell(name)
        return found

    def __iter__(self) -> Iterator[str]:
        return iter(self.places)
