"""The state of a run: names, frames, events, the arm and the signals."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol

from assistant.base.diagnostics import Span
from assistant.languages.rapid.tree import syntax as s
from assistant.program.geometry import Pose
from assistant.robots import Robot
from assistant.virtual.events import Moved, Switched
from assistant.virtual.kernel.task import Task
from assistant.virtual.on_way import ordered_triggers
from assistant.virtual.rapid.arm import Arm
from assistant.virtual.rapid.controller import Controller
from assistant.virtual.rapid.interrupts import Interrupts
from assistant.virtual.rapid.loading import Loaded
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

    task: what it runs in. named: what all modules know, by name in lower case. predefined: what
    every controller knows. modules: by name in lower case. loaded: by Load, by file. controller:
    what its tasks share. at: the statement at hand. row: the line of it, from 0, in a run of moves.
    on_way: what is set on the way of the next motion. moves: whether the task has a robot, None
    where nothing states it. hangs_on: what the condition at hand hangs on that no statement
    changes, `time` or `outside`. at_end: runs when the task ends,
    however it does.
    """

    task: Task
    abilities: Abilities
    types: Types
    signals: Signals
    arm: Arm
    robot: Robot | None = None
    named: dict[str, Meaning] = field(default_factory=dict)
    predefined: Mapping[str, Meaning] = field(default_factory=dict)
    modules: dict[str, Unit] = field(default_factory=dict)
    loaded: dict[Path, Loaded] = field(default_factory=dict)
    controller: Controller = field(default_factory=Controller)
    frames: list[Frame] = field(default_factory=list)
    at: tuple[Unit, Span | None] | None = None
    row: int = 0
    on_way: Sequence[Switched] = ()
    moves: bool | None = True
    hangs_on: set[str] = field(default_factory=set)
    at_end: list[Callable[[], None]] = field(default_factory=list)
    interrupts: Interrupts = field(init=False)

    def __post_init__(self) -> None:
        self.interrupts = Interrupts(self.task)

    @property
    def frame(self) -> Frame:
        return self.frames[-1]

    def meaning(self, name: str) -> Meaning | None:
        """What a name stands for here; None if for nothing that is declared."""
        key, frame = name.lower(), self.frames[-1]
        for names in (frame.names, frame.unit.names, self.named, self.predefined):
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

    def step(self, node: s.StatementNode, row: int = 0) -> None:
        """Counts a statement that is about to run."""
        self.at, self.row = (self.frame.unit, node.span), row
        self.look()
        self.task.step()

    def look(self) -> None:
        """Lets those see it who watch shared data, if that has changed."""
        for look in tuple(self.controller.looks):
            look()

    def took(self, node: s.StatementNode, way: int) -> None:
        """Tells who listens which way a statement goes on, counted from 0."""
        listener = self.task.kernel.branch
        if listener is not None and node.span is not None:
            source = self.frame.unit.source
            listener((source and source.path) or "", node.span.start, way)

    def go(self, moved: Moved, before: Pose | None) -> None:
        """Commands a motion. before: the flange where it begins, None if that is not known."""
        self.task.kernel.motion.go(self.task, moved, ordered_triggers(moved, before, self.on_way))
        self.task.interrupted()

    def settle(self) -> None:
        """The robot goes to the very target of the motion before, and the program waits there."""
        self.task.kernel.motion.settle(self.task)

    def place(self) -> tuple[str, int] | None:
        """The file and the line of the statement at hand."""
        found = place_of(self.at)
        return found and (found[0], found[1] + self.row)


def place_of(at: tuple[Unit, Span | None] | None) -> tuple[str, int] | None:
    """The file and the line of a statement, None where it has none."""
    if at is None:
        return None
    unit, span = at
    if unit.source is None or span is None:
        return None
    return unit.source.path or "", unit.source.line_column(span.start)[0]
