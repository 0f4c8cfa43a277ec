"""The signals of a controller: what its inputs read, and what its programs set."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Final

Source = Mapping[str, float] | Callable[[str], float]
"""What each signal reads that nothing has set, by name in lower case. A table leaves out 0."""
Listener = Callable[[str, float, float], None]
"""Is told of a signal's name, and of its value before and now."""

NO_SIGNALS: Final[Mapping[str, float]] = {}


@dataclass(slots=True, eq=False)
class Signals:
    """Signals of one direction by their name in lower case, or their number as text.

    source: what those read that nothing has set. watched: those that interrupts listen to.
    """

    source: Source = field(default_factory=dict)
    values: dict[str, float] = field(default_factory=dict)
    listeners: list[Listener] = field(default_factory=list)
    watched: list[str] = field(default_factory=list)

    def read(self, name: str) -> float:
        if name in self.values:
            return self.values[name]
        source = self.source
        return float(source(name) if callable(source) else source.get(name, 0.0))

    def set(self, name: str, value: float) -> None:
        """Gives a signal a value; whoever listens is told if it is another one."""
        before = self.read(name)
        self.values[name] = value
        if before != value:
            for listener in tuple(self.listeners):
                listener(name, before, value)


@dataclass(slots=True, eq=False)
class Board:
    """inputs: set from outside, by a script or by what is connected. outputs: set by programs."""

    inputs: Signals = field(default_factory=Signals)
    outputs: Signals = field(default_factory=Signals)
