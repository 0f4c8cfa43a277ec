"""Inputs as they were given, outputs as the program sets them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from assistant.virtual.events import Event, OnWay, Switched

Inputs = Mapping[str, float] | Callable[[str], float]
"""What each input reads, by name in lower case. A table leaves out those that are 0."""


@dataclass(slots=True)
class Signals:
    """outputs: names, in lower case, of the signals that the program sets; the others are inputs.

    known: names of signals, whichever; what else has no meaning in the program is none of them.
    """

    inputs: Inputs
    outputs: frozenset[str]
    known: frozenset[str]
    events: list[Event]
    state: dict[str, float] = field(default_factory=dict)

    def knows(self, name: str) -> bool:
        return callable(self.inputs) or name in self.known or name in self.inputs

    def read(self, name: str) -> float:
        if name in self.outputs:
            return self.state.get(name, 0.0)
        if callable(self.inputs):
            return float(self.inputs(name))
        return float(self.inputs.get(name, 0.0))

    def set(self, name: str, value: float, at: OnWay | None = None) -> None:
        """at: see `Switched`."""
        self.state[name] = value
        self.events.append(Switched(name, value, at))
