"""What a random RAPID program has declared: data, parameters and routines."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Final

TYPES: Final = {
    "whole": "num",
    "real": "num",
    "truth": "bool",
    "target": "robtarget",
    "switch": "switch",
}
"""RAPID's type of each kind of data; a `whole` num only ever holds whole numbers."""


@dataclass(frozen=True, slots=True)
class Data:
    """storage: `VAR`, `PERS`, `CONST`, or `LOOP`. size: of an array, -1 where it is open."""

    name: str
    kind: str
    storage: str
    size: int = 0

    @property
    def changes(self) -> bool:
        return self.storage in ("VAR", "PERS")


@dataclass(frozen=True, slots=True)
class Parameter:
    """mode: `VAR`, `PERS`, `INOUT` or empty. size: -1 for an array of any size."""

    name: str
    kind: str
    mode: str
    size: int = 0

    @property
    def text(self) -> str:
        if self.kind == "switch":
            return f"\\switch {self.name}"
        open_ = "{*}" if self.size else ""
        return f"{self.mode} {TYPES[self.kind]} {self.name}{open_}".strip()


@dataclass(frozen=True, slots=True)
class Routine:
    """kind: `PROC` or `FUNC`, which gives a whole number. pure: changes nothing."""

    name: str
    kind: str
    parameters: list[Parameter] = field(default_factory=list)
    pure: bool = False

    @property
    def head(self) -> str:
        type = "num " if self.kind == "FUNC" else ""
        return f"{self.kind} {type}{self.name}({','.join(p.text for p in self.parameters)})"


@dataclass(slots=True)
class Scope:
    """What is known at a place. features: what the program may use."""

    features: frozenset[str]
    data: list[Data] = field(default_factory=list)
    tools: list[str] = field(default_factory=list)
    frames: list[str] = field(default_factory=list)
    tables: int = 0
    """Rows of the table of tools."""

    def has(self, feature: str) -> bool:
        return feature in self.features

    def add(self, datum: Data) -> None:
        """A name that hides another of its kind, or is new."""
        self.data = [d for d in self.data if d.name.lower() != datum.name.lower()] + [datum]

    def inside(self, routine: Routine) -> Scope:
        """What is known in a routine at its begin."""
        found = replace(self, data=list(self.data))
        for one in routine.parameters:
            if one.kind != "switch":
                storage = "PERS" if one.mode == "PERS" else "VAR"
                found.add(Data(one.name, one.kind, storage, one.size))
            else:
                found.add(Data(f"Present({one.name})", "truth", "CONST"))
        return found

    def those(self, fits: Callable[[Data], bool]) -> list[Data]:
        return [datum for datum in self.data if fits(datum)]
