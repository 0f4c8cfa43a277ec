"""The state of a task that runs: names, frames, the arm, the signals and the interrupts.

Kernel manual, Interrupts: an interrupt is answered when the next statement is entered, and at any
time during a wait or a motion. Interrupts that occur while they are disabled are queued and raised
in their order; they always are disabled while a trap routine runs. Interrupts that are asleep are
lost.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence, Set
from contextlib import contextmanager
from dataclasses import field
from pathlib import Path
from typing import Final, Protocol

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Span
from assistant.languages.rapid.tree import syntax as s
from assistant.program.geometry import IDENTITY, Pose
from assistant.robots import Robot
from assistant.virtual.events import Moved, OnWay, Switched
from assistant.virtual.kernel.kernel import Timer
from assistant.virtual.kernel.task import Task
from assistant.virtual.rapid.control_flow import Fault, NotSimulated
from assistant.virtual.rapid.controller import Controller, Loaded
from assistant.virtual.rapid.records import pose_of, truth
from assistant.virtual.rapid.scopes import Frame, Known, Meaning, Types, Unit
from assistant.virtual.rapid.values import Record, Value
from assistant.virtual.triggers import ordered_triggers


@dataclass(slots=True)
class Arm:
    """State of the arm. flange: its pose in the robot's base; joints: degrees; each None while
    unknown.

    tool, frame: records of the latest motion, None before the first. configuration, external: those
    of the latest target. displacement: that of all targets, by PDispSet. offsets: those of the
    additional axes, by EOffsSet. override, most: percent and mm/s, by VelSet. acceleration:
    percent, by AccSet. watches_joints, watches_lines: whether motions keep to the configurations of
    their targets, by ConfJ and ConfL.
    """

    flange: Pose | None = None
    joints: tuple[float, ...] | None = None
    tool: Record | None = None
    frame: Record | None = None
    configuration: Record | None = None
    external: Record | None = None
    displacement: Pose = IDENTITY
    offsets: tuple[float, ...] = (0.0,) * 6
    override: float = 100.0
    most: float = float("inf")
    acceleration: float = 100.0
    watches_joints: bool = True
    watches_lines: bool = True

    def flange_at(self, target: Pose, tool: Record, frame: Record) -> Pose:
        """The flange where a tool reaches a target of a work object."""
        tip, held = _tool_frame(tool)
        place = _object_frame(frame, held) @ self.displacement
        # A tool in the room: the target is on the work object that the arm carries.
        if held:
            return place @ target @ tip.inverse()
        return tip @ (place @ target).inverse()

    def reading(self, tool: Record, frame: Record, flange: Pose | None = None) -> Pose:
        """The tool in a work object. flange: in the base, None for where the arm stands."""
        flange = flange or self.flange
        if flange is None:
            raise NotSimulated("a position that is read while it is not known where the arm is")
        tip, held = _tool_frame(tool)
        place = _object_frame(frame, held) @ self.displacement
        if held:
            return place.inverse() @ flange @ tip
        return (flange @ place).inverse() @ tip


def work_object(frame: Record, tool: Record) -> Pose:
    """Return a work object in the base if it is fixed there, else on the flange."""
    return _object_frame(frame, _tool_frame(tool)[1])


def is_carried(tool: Record) -> Pose:
    """The tool on the flange; none where the robot carries the work piece to it."""
    tip, held = _tool_frame(tool)
    return tip if held else IDENTITY


def _tool_frame(tool: Record) -> tuple[Pose, bool]:
    return pose_of(tool.parts["tframe"]), truth(tool.parts["robhold"])


def _object_frame(frame: Record, held: bool) -> Pose:
    """User and object frame in one: in the base, or on the flange beside a tool in the room."""
    if truth(frame.parts["robhold"]) is held:
        raise Fault("either the tool or the work object is held by the robot, not both or neither")
    if not truth(frame.parts["ufprog"]) or frame.parts["ufmec"] != "":
        raise NotSimulated("a work object that a mechanical unit moves")
    return pose_of(frame.parts["uframe"]) @ pose_of(frame.parts["oframe"])


@dataclass(slots=True)
class Signals:
    """Signals of a program. outputs: names, in lower case, of the signals that programs set; the
    others are inputs.

    known: names of signals of either direction; other names without a meaning in the program are
    not signals.
    """

    task: Task
    outputs: Set[str]
    known: Set[str]
    later: dict[str, Timer] = field(default_factory=dict)

    def knows(self, name: str) -> bool:
        inputs = self.task.kernel.board.inputs
        source = inputs.source
        # A callable source answers for any name.
        return callable(source) or name in self.known or name in source or name in inputs.values

    def read(self, name: str) -> float:
        board = self.task.kernel.board
        return (board.outputs if name in self.outputs else board.inputs).read(name)

    def set(
        self, name: str, value: float, at: OnWay | None = None, after: float | None = None
    ) -> None:
        """at, after: see `Switched`."""
        self.task.switch(name, value, at, after)

    def set_later(self, name: str, value: float, seconds: float) -> None:
        """While the program goes on; instead of what still is to become of the signal."""
        if name in self.later:
            self.later[name].cancelled = True
        # The place of the statement now: the program is elsewhere when the change happens.
        kernel, task, place = self.task.kernel, self.task, self.task.where()

        def change() -> None:
            kernel.tell(task, Switched(name, value), place)
            kernel.board.outputs.set(name, value)

        self.later[name] = kernel.at(kernel.now + seconds, change)


_MOST_QUEUED: Final = 100
"""Interrupts that are defined at one time, of a task (RAPID overview, Interrupts)."""

Cancel = Callable[[], None]


@dataclass(slots=True, eq=False)
class Interrupt:
    """cancel: ends its order, None before it has one. single: it occurs once, safe: and is not
    deactivated on its own. asleep: deactivated. gone: deleted.
    """

    number: int
    trap: Known
    cancel: Cancel | None = None
    single: bool = False
    safe: bool = False
    asleep: bool = False
    gone: bool = False


@dataclass(slots=True, eq=False)
class Interrupts:
    """table: by number. run: runs the trap routine of one."""

    task: Task
    run: Callable[[Interrupt], None] = lambda _: None
    table: dict[int, Interrupt] = field(default_factory=dict)
    disabled: bool = False
    count: int = 0

    def connect(self, number: int, trap: Known) -> int:
        """A new interrupt for a variable with a number: the number that it is given."""
        if number in self.table:
            raise Fault("an interrupt that has a trap routine is connected", "ERR_ALRDYCNT")
        if len(self.table) >= _MOST_QUEUED:
            raise Fault(f"more than {_MOST_QUEUED} interrupts", "ERR_INOMAX")
        self.count += 1
        self.table[self.count] = Interrupt(self.count, trap)
        return self.count

    def order(
        self,
        number: int,
        begin: Callable[[Callable[[], None]], Cancel],
        single: bool = False,
        safe: bool = False,
    ) -> None:
        """begin: has a function called whenever the interrupt occurs, and tells how to end it."""
        interrupt = self.known(number)
        if interrupt.cancel is not None:
            raise Fault("an interrupt is ordered twice, without an IDelete in between")
        interrupt.single, interrupt.safe = single or safe, safe
        interrupt.cancel = begin(lambda: self.occur(interrupt))

    def occur(self, interrupt: Interrupt) -> None:
        # Interrupts that cause each other would otherwise run without end in no time.
        self.task.kernel.spend()
        if interrupt.gone or interrupt.asleep:
            return
        # Before it is posted: it must not occur again while it waits for the trap routine.
        if interrupt.single and interrupt.cancel is not None:
            interrupt.cancel()
        # It may be deleted while it is in the queue.
        self.task.post(lambda: None if interrupt.gone else self.run(interrupt))

    def known(self, number: int) -> Interrupt:
        if number not in self.table:
            raise Fault("an interrupt that no trap routine is connected to", "ERR_UNKINO")
        return self.table[number]

    def delete(self, number: int) -> None:
        """Also of one that there is not: programs delete before they connect."""
        interrupt = self.table.pop(number, None)
        if interrupt is not None:
            interrupt.gone = True
            if interrupt.cancel is not None:
                interrupt.cancel()

    def sleep(self, number: int, asleep: bool) -> None:
        interrupt = self.known(number)
        if asleep and interrupt.safe:
            raise Fault("a safe interrupt is deactivated", "ERR_INOISSAFE")
        interrupt.asleep = asleep

    def disable(self, disabled: bool) -> None:
        """All of the task, whoever occurs is queued."""
        # IDisable twice needs only one IEnable.
        if disabled is not self.disabled:
            self.task.closed += 1 if disabled else -1
            self.disabled = disabled


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
        """Return the meaning of a name here; None if it is not declared."""
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
        # A copy: a listener may end itself.
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
