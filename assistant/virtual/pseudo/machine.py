"""The state of a running pseudo-program: values and their storage, names, calls, timers, arm.

The exceptions are the ways in which a program leaves the statement at hand.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import field, replace
from typing import TYPE_CHECKING, Final, TypeVar

import numpy as np

from assistant.base import rotations
from assistant.base.data_classes import dataclass
from assistant.base.source_text import SourceText
from assistant.program.expressions import ANGLES, EXTERNAL, Name
from assistant.program.geometry import BASE, FLANGE, Frame, JointTarget, Pose, Target, Tool
from assistant.program.motion import FINE, Blend, Speed
from assistant.program.program import Procedure, Program, ValueType, Variable
from assistant.program.statements import Statement, outputs
from assistant.robots import Robot
from assistant.virtual.events import Place as TextPlace
from assistant.virtual.kernel import Task
from assistant.virtual.kernel.task import Level, Shown

if TYPE_CHECKING:
    from assistant.virtual.pseudo.statements import Interrupts


class Fault(Exception):
    """An action that no controller could carry out."""


class NotRun(Exception):
    """A feature that this interpreter does not support; the text names it."""


class Over(Exception):
    """The program is ended for good."""


class Jump(Exception):
    """label: in lower case."""

    def __init__(self, label: str) -> None:
        super().__init__(label)
        self.label = label


class Returned(Exception):
    def __init__(self, value: Value | None = None) -> None:
        super().__init__()
        self.value = value


Value = float | bool | str | Target | JointTarget | Pose | list["Value"]
"""Numbers are doubles; arrays and records are lists."""
_DEFAULTS: Final[dict[ValueType, Value]] = {
    "number": 0.0,
    "integer": 0.0,
    "truth": False,
    "text": "",
}
"""Values of variables that state no first value; positions have none."""


@dataclass(slots=True, eq=False)
class Cell:
    """Storage of a value. constant: True if it must not change."""

    value: Value | None = None
    constant: bool = False


@dataclass(frozen=True, slots=True)
class Place:
    """A variable, or an element or component of one. change: puts a value there."""

    get: Callable[[], Value]
    change: Callable[[Value], None]


@dataclass(slots=True, eq=False)
class Call:
    """A call. names: by name in lower case. at: the statement at hand."""

    procedure: Procedure
    names: dict[str, Cell | Place] = field(default_factory=dict)
    at: Statement | None = None


def place_of(cell: Cell, name: str) -> Place:
    def get() -> Value:
        if cell.value is None:
            raise Fault(f"`{name}` has no value")
        return cell.value

    def change(value: Value) -> None:
        if cell.constant:
            raise Fault(f"the constant `{name}` is set")
        cell.value = copied(value)

    return Place(get, change)


def array_element(array: Place, indices: tuple[int, ...], name: str) -> Place:
    """Return the storage of an array element; indices from 1."""

    # The row is looked up at each use: the array may be
    # replaced while a reference to an element lives.
    def row() -> tuple[list[Value], int]:
        items, last = array.get(), 0
        for depth, index in enumerate(indices):
            if not isinstance(items, list) or not 1 <= index <= len(items):
                said = ", ".join(map(str, indices))
                raise Fault(f"`{name}` has no element ({said})")
            last = index - 1
            if depth < len(indices) - 1:
                items = items[last]
        assert isinstance(items, list)
        return items, last

    def get() -> Value:
        items, at = row()
        found = items[at]
        # An empty list marks an element that was never set, see `first_value`.
        if isinstance(found, list) and not found:
            raise Fault(f"an element of `{name}` has no value")
        return found

    def change(value: Value) -> None:
        items, at = row()
        items[at] = copied(value)

    return Place(get, change)


def value_component(whole: Place, field_: str) -> Place:
    """x, y or z of a position or pose, or a joint."""

    def get() -> Value:
        return _component(whole.get(), field_)

    def change(value: Value) -> None:
        whole.change(_with_component(whole.get(), field_, value))

    return Place(get, change)


AXES: Final = ("x", "y", "z")


def _component(value: Value, name: str) -> float:
    match value:
        case Target(pose=pose) if name in AXES:
            return pose.position[AXES.index(name)]
        case Pose(position=position) if name in AXES:
            return position[AXES.index(name)]
        case Target(pose=pose) | (Pose() as pose) if name in ANGLES:
            return _euler_angles(pose)[name]
        case JointTarget(joints=joints) if (at := _joint_index(name, len(joints))) is not None:
            return joints[at]
        case Target(external=places) | JointTarget(external=places) if name in EXTERNAL:
            place = places[EXTERNAL.index(name)]
            if math.isnan(place):
                raise Fault(f"no place of an external axis is stated: `{name}`")
            return place
    raise NotRun(f"the component `{name}` of {kind_of(value)}")


def _with_component(value: Value, name: str, given: Value) -> Value:
    number = number_of(given)
    match value:
        case Target(pose=pose) if name in AXES:
            return replace(value, pose=_moved_pose(pose, name, number))
        case Pose() if name in AXES:
            return _moved_pose(value, name, number)
        case Target(pose=pose) if name in ANGLES:
            return replace(value, pose=turned_pose(pose, {name: number}))
        case Pose() if name in ANGLES:
            return turned_pose(value, {name: number})
        case JointTarget(joints=joints) if (at := _joint_index(name, len(joints))) is not None:
            return replace(value, joints=(*joints[:at], number, *joints[at + 1 :]))
        case Target(external=places) | JointTarget(external=places) if name in EXTERNAL:
            at = EXTERNAL.index(name)
            return replace(value, external=(*places[:at], number, *places[at + 1 :]))
    raise NotRun(f"the component `{name}` of {kind_of(value)}")


def _moved_pose(pose: Pose, name: str, number: float) -> Pose:
    x, y, z = (number if axis == name else v for axis, v in zip(AXES, pose.position, strict=True))
    return replace(pose, position=(x, y, z))


def _euler_angles(pose: Pose) -> dict[str, float]:
    about_z, about_y, about_x = rotations.to_euler(np.array(pose.quaternion), "ZYX")
    return dict(zip(ANGLES, map(float, (about_x, about_y, about_z)), strict=True))


def turned_pose(pose: Pose, angles: Mapping[str, float]) -> Pose:
    """The pose with other angles for some of those that it has."""
    about_x, about_y, about_z = ({**_euler_angles(pose), **angles}[name] for name in ANGLES)
    turn = rotations.from_euler(np.array([about_z, about_y, about_x]), "ZYX")
    return Pose.of(np.array(pose.position), turn)


def _joint_index(name: str, count: int) -> int | None:
    """The place of `j1`, `j2`, … among the joints."""
    number = name[1:]
    if name[:1] != "j" or not number.isdecimal() or not 1 <= int(number) <= count:
        return None
    return int(number) - 1


def first_value(variable: Variable, initial: Value | None) -> Value | None:
    """Return the first value of a variable; arrays without one are filled."""
    if initial is not None or not variable.size:
        return _DEFAULTS.get(variable.type) if initial is None else copied(initial)
    return _filled_array(variable.size, _DEFAULTS.get(variable.type, []))


def _filled_array(size: tuple[int, ...], value: Value) -> Value:
    if not size:
        return copied(value)
    return [_filled_array(size[1:], value) for _ in range(size[0])]


def copied(value: Value) -> Value:
    return [copied(one) for one in value] if isinstance(value, list) else value


def number_of(value: Value, what: str = "the value") -> float:
    if isinstance(value, bool) or not isinstance(value, float):
        raise Fault(f"{what} is {kind_of(value)}, no number")
    return value


def truth_of(value: Value) -> bool:
    if not isinstance(value, bool):
        raise Fault(f"a condition is {kind_of(value)}, no truth")
    return value


def whole_of(value: Value, what: str = "the value") -> int:
    number = number_of(value, what)
    if not number.is_integer():
        raise Fault(f"{what} is {number:g}, no whole number")
    return int(number)


def kind_of(value: Value) -> str:
    match value:
        case bool():
            return "a truth"
        case float():
            return "a number"
        case str():
            return "a text"
        case Target():
            return "a position"
        case JointTarget():
            return "joints"
        case Pose():
            return "a pose"
    return "an array"


def value_text(value: Value | None) -> str:
    """A value as people read it."""
    match value:
        case None:
            return ""
        case bool():
            return "true" if value else "false"
        case float():
            return f"{value:g}"
        case str():
            return f'"{value}"'
        case Target(pose=pose) | (Pose() as pose):
            position = ", ".join(f"{v:g}" for v in pose.position)
            return f"[{position}] [{', '.join(f'{v:g}' for v in pose.quaternion)}]"
        case JointTarget(joints=joints):
            return f"[{', '.join(f'{v:g}' for v in joints)}]"
    return f"[{', '.join(map(value_text, value))}]"


MOST_CALLS: Final = 40
"""Procedures that are inside of one another."""
T = TypeVar("T")


@dataclass(slots=True, eq=False)
class Machine:
    """All state that a running program can see or change.

    text: source that the program was read from, None if it has none. shared: its variables, targets
    and joint targets by name in lower case. set: signals that it sets. flange, joints: those at the
    end of the latest motion, None while unknown. override, acceleration, deceleration: factors.
    interrupts: set once it runs. broken_off: whether the last move with an `until` was.
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
        # Signals that the program sets are outputs, even if it declares none.
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
        """Return the storage of a variable or constant; None for an unknown name."""
        key = name.lower()
        found = self.call.names.get(key) if self.calls else None
        if found is None:
            found = self.shared.get(key)
        return place_of(found, name) if isinstance(found, Cell) else found

    def is_signal(self, name: str) -> bool:
        key = name.lower()
        return key in self.set or any(key == known.lower() for known in self.program.signals)

    def read(self, name: str) -> float:
        """Return the present value of a signal."""
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
        """Return the present pose of a tool or frame, which a program may change."""
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
                    # The default binds the names of this call:
                    # `call` is another one by the time of asking.
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
