"""Types by their names: what a program declares beside what every controller knows."""

from __future__ import annotations

import abc
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final

MOST_ALIASES: Final = 8
"""Aliases behind each other that are followed."""


@dataclass(frozen=True, slots=True)
class Type:
    """kind: what it is, in the language's own word. of: what an alias stands for, else empty.

    components: type by name of a record, in order; None if they are not known.
    """

    name: str
    kind: str
    of: str = ""
    components: Mapping[str, str] | None = field(default=None, hash=False)


class NamedTypes(abc.ABC):
    """The types that a part of a program sees, in any case.

    predefined: by lower-case name; what is declared hides them.
    """

    def __init__(self, predefined: Mapping[str, Type]) -> None:
        self.predefined = predefined
        self._bases: dict[str, str | None] = {}

    @abc.abstractmethod
    def declared(self, name: str) -> Type | None:
        """The type that the program declares by a name."""

    @abc.abstractmethod
    def atomic(self, base: str) -> bool:
        """Whether a type surely has no components."""

    def find(self, name: str) -> Type | None:
        return self.declared(name) or self.predefined.get(name.lower())

    def base(self, name: str) -> str | None:
        """The type itself, of an alias what it stands for; None if nothing declares it."""
        low = name.lower()
        if low not in self._bases:
            self._bases[low] = self._base(low)
        return self._bases[low]

    def _base(self, low: str) -> str | None:
        for _ in range(MOST_ALIASES):
            found = self.find(low)
            if found is None or not found.of:
                return None if found is None else low
            low = found.of.lower()
        return None

    def components(self, base: str) -> Mapping[str, str] | None:
        """Components of a record in order, type by name; None if they are not known."""
        found = self.find(base)
        return None if found is None else found.components

    def kind(self, base: str) -> str:
        """What a type is; empty if that is not known."""
        found = self.find(base)
        return "" if found is None else found.kind
