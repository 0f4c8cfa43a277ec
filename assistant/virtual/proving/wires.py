"""The signals of a cell as wires, which two programs call by names of their own."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final

Wires = tuple[str, ...]
"""Bits of a signal, the lowest first; a signal without numbers is one wire of its own name."""

GROUP_BITS: Final = 16
"""Of a group of signals whose width nothing tells: what a controller's word has."""


@dataclass(frozen=True, slots=True)
class Wiring:
    """What a program reads by a name. named: wires by names in lower case.

    wide: names of wires that hold numbers of more than a bit. Any other name is a wire of its own.
    """

    named: Mapping[str, Wires] = field(default_factory=dict)
    wide: frozenset[str] = frozenset()

    def wires(self, name: str) -> Wires:
        return self.named.get(name, (name,))

    def bits(self, name: str) -> int:
        """How many a number has that a name reads."""
        count = len(self.wires(name))
        return GROUP_BITS if count == 1 and name in self.wide else count

    def value(self, name: str, state: Mapping[str, float]) -> float:
        """What a name reads, of wires of which those at 0 may be missing."""
        wires = self.wires(name)
        if len(wires) == 1:
            return state.get(wires[0], 0.0)
        return float(sum(int(state.get(wire, 0.0)) << at for at, wire in enumerate(wires)))

    def spread(self, name: str, value: float) -> dict[str, float]:
        """What the wires of a name are where it reads a value."""
        wires = self.wires(name)
        if len(wires) == 1:
            return {wires[0]: value}
        return {wire: float(int(value) >> at & 1) for at, wire in enumerate(wires)}
