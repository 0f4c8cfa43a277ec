"""Values of a running pseudo-program, and where they are stored."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np

from assistant.base import rotations
from assistant.program.expressions import ANGLES, EXTERNAL
from assistant.program.geometry import JointTarget, Pose, Target
from assistant.program.program import Procedure, ValueType, Variable
from assistant.program.statements import Statement
from assistant.virtual.pseudo.ends import Fault, NotRun

Value = float | bool | str | Target | JointTarget | Pose | list["Value"]
"""Numbers are doubles; arrays and records are lists."""
DEFAULTS: Final[dict[ValueType, Value]] = {
    "number": 0.0,
    "integer": 0.0,
    "truth": False,
    "text": "",
}
"""Of variables that state no first value; positions have none."""


@dataclass(slots=True, eq=False)
class Cell:
    """Where a value is stored. constant: nothing may change it."""

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
    """Of an array; indices from 1."""

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
    """What a variable begins with; arrays without a first value are filled."""
    if initial is not None or not variable.size:
        return DEFAULTS.get(variable.type) if initial is None else copied(initial)
    return _filled_array(variable.size, DEFAULTS.get(variable.type, []))


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
