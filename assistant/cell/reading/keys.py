"""Keys of the world in a cell file: what each may hold, see `cell_file`."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any, Final

from assistant.cell.scene import Colour
from assistant.sources.process import values
from assistant.sources.process.values import Read, Wrong

SIZE: Final = values.number("mm", above=0.0)


def _sizes(count: int) -> Read:
    def read(value: Any) -> tuple[float, ...]:
        if not isinstance(value, list) or len(value) != count:
            raise Wrong("is no list of lengths", f"write {count} lengths in mm in brackets")
        return tuple(SIZE(one) for one in value)

    return read


def _pairs(value: Any) -> tuple[tuple[str, str], ...]:
    if not isinstance(value, list) or not all(isinstance(p, list) and len(p) == 2 for p in value):
        raise Wrong("is no list of pairs", 'write [["table", "arm.base"], …]')
    return tuple((values.text(one), values.text(other)) for one, other in value)


def _output(value: Any) -> tuple[str, float]:
    if not isinstance(value, dict) or len(value) != 1:
        raise Wrong("is no output with its value", 'write {gripper = 1}, or {"hand 1" = 1}')
    ((name, number),) = value.items()
    return str(name), values.number("")(number)


def _folders(value: Any) -> dict[str, str]:
    if not isinstance(value, dict) or not value:
        raise Wrong("is no table of folders", 'write {NAME = "FOLDER"}')
    return {name: values.text(folder) for name, folder in value.items()}


def _colour(value: Any) -> Colour:
    if not isinstance(value, str) or not re.fullmatch(r"#[0-9a-fA-F]{6}", value):
        raise Wrong("is no colour", 'write "#rrggbb", two digits of 16 each')
    red, green, blue = (int(value[i : i + 2], 16) for i in (1, 3, 5))
    return red, green, blue


PLACE: Final[Mapping[str, Read]] = {
    "position": values.position,
    "quaternion": values.quaternion,
    "euler_zyx": values.euler_zyx,
}
WORLD: Final[Mapping[str, Read]] = {
    "margin": values.number("mm", least=0.0),
    "allowed": _pairs,
    "drawing": values.text,
    "frame": values.text,
    "unit": values.unit,
}
ROBOT: Final[Mapping[str, Read]] = {
    "robot": values.text,
    "tool": values.text,
    "packages": _folders,
    "links": values.choice("capsules"),
    "explored": values.text,
    "unknown": values.choice("blocked", "free"),
    **PLACE,
}
SHAPES: Final[Mapping[str, Read]] = {
    "box": _sizes(3),
    "sphere": SIZE,
    "cylinder": _sizes(2),
    "capsule": _sizes(2),
    "mesh": values.text,
    "convex": values.text,
    "drawing": values.text,
}
PART: Final[Mapping[str, Read]] = {
    **SHAPES,
    **PLACE,
    "unit": values.unit,
    "off": values.number("mm", least=0.0),
}
PARTS: Final = "parts"
BODY: Final[Mapping[str, Read]] = {
    **PART,
    PARTS: lambda value: value,
    "parent": values.text,
    "colour": _colour,
    "margin": values.number("mm", least=0.0),
    "locations": lambda value: value,
    "taken": _output,
    "released": _output,
}
