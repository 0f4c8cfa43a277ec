"""The state of a running pseudo-program: names, calls, timers, and the arm."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Final, TypeVar

from assistant.base.source_text import SourceText
from assistant.program.expressions import Name
from assistant.program.geometry import BASE, FLANGE, Frame, Pose, Tool
from assistant.program.motion import FINE, Blend, Speed
from assistant.program.program import Program
from assistant.program.statements import Statement, outputs
from assistant.robots import Robot
from assistant.virtual.events import Place as TextPlace
from assistant.virtual.kernel import Task
from assistant.virtual.kernel.looking import Level, Shown
from assistant.virtual.pseudo.data import Call, Cell, Place, Value, kind_of, place_of, value_text
from assistant.virtual.pseudo.ends import Fault, NotRun

if TYPE_CHECKING:
    from assistant.virtual.pseudo.interrupts import Interrupts

MOST_CALLS: Final = 40
"""Procedures that are inside of one another."""
T = TypeVar("T")


@dataclass(slots=True, eq=False)
class Machine:
    """Everything that a running program can see or change.

    text: that the program was read from, None if there is none. shared: its variables, targets and
    joint targets by name in lower case. set: signals that it sets. flange, joints: where the
    latest motion leads, None while that is not known. override, acceleration, deceleration:
    factors. interrupts: set once it runs. broken_off: whether the last move with an `until` was.
    """

    task: Task
    program: Program
    robot: Robot | None = None
    text: SourceText | None = None
    shared: dict[str, Cell] = field(default_factory=dict)
    calls: list[Call] = field(default_factory=list)
    timers: dict[str, float] = field(default_factory=dict)
    set: frozenset[str] = frozenset()
    flange: Pose | None = None
    joints: tuple[float, ...] | None = None
    override: float = 1.0
    acceleration: float = 1.0
    deceleration: float = 1.0
    interrupts: Interrupts | None = None
    broken_off: bool = False
    tables: _Tables = field(init=False)

    def __post_init__(self) -> None:
        program = self.program
        self.tables = _Tables(
            {FLANGE: Tool()} | _lower_case_keys(program.tools),
            {BASE: Frame()} | _lower_case_keys(program.frames),
            _lower_case_keys(program.speeds),
            _lower_case_keys(program.blends),
        )
        self.set = frozenset(
            one.signal.lower() for part in program.statements() for one in outputs(part)
        )

    @property
    def call(self) -> Call:
        return self.calls[-1]

    def step(self, statement: Statement) -> None:
        """Counts a statement that is about to run."""
        self.call.at = statement
        self.task.step()

    # ------------------------------------------------------------------------------- names

    def place(self, name: str) -> Place | None:
        """Where a variable or constant is stored; None for a name that is none."""
        key = name.lower()
        found = self.call.names.get(key) if self.calls else None
        if found is None:
            found = self.shared.get(key)
        return place_of(found, name) if isinstance(found, Cell) else found

    def is_signal(self, name: str) -> bool:
        key = name.lower()
        return key in self.set or any(key == known.lower() for known in self.program.signals)

    def read(self, name: str) -> float:
        """What a signal is now."""
        key, board = name.lower(), self.task.kernel.board
        declared = next((s for n, s in self.program.signals.items() if n.lower() == key), None)
        out = key in self.set if declared is None else declared.direction == "output"
        return (board.outputs if out else board.inputs).read(key)

    def tool(self, name: str) -> Tool:
        found = _table_entry(self.tables.tools, name, "tool")
        return replace(found, tip=self._mounted(name, found.tip))

    def frame(self, name: str) -> Frame:
        found = _table_entry(self.tables.frames, name, "frame")
        if found.mechanism:
            raise NotRun(f"the frame `{name}`, which a mechanical unit moves")
        pose = self._mounted(name, found.pose)
        return found if pose == found.pose else replace(found, user=pose, object=Pose())

    def _mounted(self, name: str, declared: Pose) -> Pose:
        """What the pose of a tool or frame is now, which a program may change."""
        cell = self.shared.get(name.lower())
        return cell.value if cell is not None and isinstance(cell.value, Pose) else declared

    def speed(self, speed: Speed | Name) -> Speed:
        return (
            _table_entry(self.tables.speeds, speed.name, "speed")
            if isinstance(speed, Name)
            else speed
        )

    def blend(self, blend: Blend | Name) -> Blend:
        if isinstance(blend, Name):
            return (
                FINE
                if blend.name.lower() == "fine"
                else _table_entry(self.tables.blends, blend.name, "blend")
            )
        return blend

    # ----------------------------------------------------------------------------- looking

    def where(self) -> TextPlace | None:
        return self._place(self.calls[-1]) if self.calls else None

    def _place(self, call: Call) -> TextPlace | None:
        if self.text is None or call.at is None or call.at.span is None:
            return None
        return self.text.path or "", self.text.line_column(call.at.span.start)[0]

    def levels(self) -> list[Level]:
        return [
            Level(
                call.procedure.name,
                self._place(call),
                {
                    "Procedure": lambda names=call.names: list(_shown_data(names)),  # type: ignore[misc]
                    "Program": lambda: list(_shown_data(self.shared)),
                },
            )
            for call in reversed(self.calls)
        ]


@dataclass(frozen=True, slots=True)
class _Tables:
    tools: Mapping[str, Tool]
    frames: Mapping[str, Frame]
    speeds: Mapping[str, Speed]
    blends: Mapping[str, Blend]


def _lower_case_keys(table: Mapping[str, T]) -> dict[str, T]:
    return {name.lower(): value for name, value in table.items()}


def _table_entry(table: Mapping[str, T], name: str, what: str) -> T:
    found = table.get(name.lower())
    if found is None:
        raise Fault(f"there is no {what} `{name}`")
    return found


def _shown_data(names: Mapping[str, Cell | Place]) -> Iterator[Shown]:
    for name, cell in names.items():
        value: Value | None
        try:
            value = cell.value if isinstance(cell, Cell) else cell.get()
        except Fault:
            value = None
        yield Shown(
            name, value_text(value), "" if value is None else kind_of(value).partition(" ")[2]
        )
