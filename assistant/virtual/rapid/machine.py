"""The state of a run: names, frames, events, the arm and the signals."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Protocol

from assistant.languages.rapid.tree import syntax as s
from assistant.program.diagnostics import Span
from assistant.robots import Robot
from assistant.virtual.events import Event, Waited
from assistant.virtual.rapid.arm import Arm
from assistant.virtual.rapid.ends import Over
from assistant.virtual.rapid.scopes import Frame, Known, Meaning, Unit
from assistant.virtual.rapid.signals import Signals
from assistant.virtual.rapid.types import Types
from assistant.virtual.rapid.values import Value

MOST_CALLS = 40
"""Routines that are inside of one another."""


class Function(Protocol):
    """A function or instruction of every controller; it works its arguments out itself."""

    def __call__(self, machine: Machine, arguments: Sequence[s.Argument]) -> Value | None: ...


@dataclass(frozen=True, slots=True)
class Abilities:
    """Functions and instructions by name in lower case, and how a routine is called."""

    functions: Mapping[str, Function]
    instructions: Mapping[str, Function]
    call: Callable[[Machine, Known, Sequence[s.Argument]], Value | None]


@dataclass(slots=True, eq=False)
class Machine:
    """Everything that a running program can see or change.

    named: what all modules know, by name in lower case. predefined: what every controller
    knows. time: seconds, of stated delays only: motions take none here.
    """

    abilities: Abilities
    types: Types
    signals: Signals
    arm: Arm
    most_steps: int
    robot: Robot | None = None
    named: dict[str, Meaning] = field(default_factory=dict)
    predefined: Mapping[str, Meaning] = field(default_factory=dict)
    frames: list[Frame] = field(default_factory=list)
    events: list[Event] = field(default_factory=list)
    steps: int = 0
    time: float = 0.0
    at: tuple[Unit, Span | None] | None = None

    @property
    def frame(self) -> Frame:
        return self.frames[-1]

    def meaning(self, name: str) -> Meaning | None:
        """What a name stands for here; None if for nothing that is declared."""
        key = name.lower()
        for names in (self.frame.names, self.frame.unit.names, self.named, self.predefined):
            if key in names:
                return names[key]
        return None

    @contextmanager
    def outside(self, unit: Unit) -> Iterator[None]:
        """Meanwhile names mean what they do in a module, outside its routines."""
        self.frames.append(Frame(unit, None))
        try:
            yield
        finally:
            self.frames.pop()

    def step(self, node: s.StatementNode) -> None:
        """Counts a statement that is about to run."""
        self.at = (self.frame.unit, node.span)
        self.steps += 1
        if self.steps > self.most_steps:
            raise Over("steps")

    def wait(self, seconds: float) -> None:
        self.time += seconds
        self.events.append(Waited(seconds))
