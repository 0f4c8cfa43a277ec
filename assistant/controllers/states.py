"""Reports of controllers, in words and units that all of them share."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import field
from datetime import datetime
from pathlib import PurePath
from typing import Literal

from assistant.base.data_classes import dataclass

Mode = Literal["automatic", "manual", ""]


@dataclass(frozen=True, slots=True)
class Identity:
    """robot, controller: types as the maker calls them. serial: number; "" for what is not told."""

    robot: str = ""
    controller: str = ""
    version: str = ""
    serial: str = ""


@dataclass(frozen=True, slots=True)
class Fault:
    """An error, warning or event of a controller: its number with text and what to do about it."""

    number: int
    text: str
    level: Literal["error", "warning", "info"] = "error"
    cure: str = ""
    time: datetime | None = None


@dataclass(frozen=True, slots=True)
class TaskState:
    """A task or slot. program: what is loaded in it, "" for nothing. line: that is next.

    background: whether it runs behind the others, which do not mind when it is changed.
    """

    name: str
    program: str = ""
    line: int | None = None
    running: bool = False
    background: bool = False


@dataclass(frozen=True, slots=True)
class State:
    """motors: whether the servos are on. override: percent. faults: what it stands still for.

    right: whether this session holds the operation right or the mastership.
    """

    mode: Mode = ""
    motors: bool = False
    running: bool = False
    emergency: bool = False
    right: bool = False
    override: int | None = None
    tasks: tuple[TaskState, ...] = ()
    faults: tuple[Fault, ...] = ()


@dataclass(frozen=True, slots=True)
class Position:
    """Position of the arm.

    joints: degrees (mm of a linear axis) of J1, J2, …, None for one that the arm lacks. position:
    mm, quaternion: (w, x, y, z), of the tool in the frame that the controller shows. text: the pose
    in the controller's language.
    """

    joints: tuple[float | None, ...]
    position: tuple[float, float, float]
    quaternion: tuple[float, float, float, float]
    text: str = ""


@dataclass(frozen=True, slots=True)
class Sample:
    """One look at a controller. seconds: since the first. signals: values by name."""

    seconds: float
    state: State
    position: Position
    signals: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Jog:
    """A small motion by hand: of one axis, by some degrees or mm.

    axis: J1 … J8, or X Y Z A B C of the frame. frame: of X … C. speed: percent of the override.
    """

    axis: str
    by: float
    frame: Literal["base", "tool"] = "base"
    speed: float = 10.0


def record(value: object) -> object:
    """Return a report of a controller as plain data for JSON."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {f.name: record(getattr(value, f.name)) for f in dataclasses.fields(value)}
    if isinstance(value, Mapping):
        return {str(key): record(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [record(one) for one in value]
    if isinstance(value, datetime):
        return value.isoformat()
    return str(value) if isinstance(value, PurePath) else value
