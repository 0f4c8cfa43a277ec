"""Keys of the world in a cell file: what each may hold, see `cell_file`."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any, Final

from assistant.cell.scene import Colour
from assistant.program import settings_tables
from assistant.program.settings_tables import Read, Wrong

READ_SIZE: Final = settings_tables.number("mm", above=0.0)


def _read_sizes(count: int) -> Read:
    def read(value: Any) -> tuple[float, ...]:
        if not isinstance(value, list) or len(value) != count:
            raise Wrong("is no list of lengths", f"write {count} lengths in mm in brackets")
        return tuple(READ_SIZE(one) for one in value)

    return read


def _read_pairs(value: Any) -> tuple[tuple[str, str], ...]:
    if not isinstance(value, list) or not all(isinstance(p, list) and len(p) == 2 for p in value):
        raise Wrong("is no list of pairs", 'write [["table", "arm.base"], …]')
    return tuple((settings_tables.text(one), settings_tables.text(other)) for one, other in value)


def _read_output(value: Any) -> tuple[str, float]:
    if not isinstance(value, dict) or len(value) != 1:
        raise Wrong("is no output with its value", 'write {gripper = 1}, or {"hand 1" = 1}')
    ((name, number),) = value.items()
    return str(name), settings_tables.number("")(number)


def _read_folders(value: Any) -> dict[str, str]:
    if not isinstance(value, dict) or not value:
        raise Wrong("is no table of folders", 'write {NAME = "FOLDER"}')
    return {name: settings_tables.text(folder) for name, folder in value.items()}


def _read_colour(value: Any) -> Colour:
    if not isinstance(value, str) or not re.fullmatch(r"#[0-9a-fA-F]{6}", value):
        raise Wrong("is no colour", 'write "#rrggbb", two digits of 16 each')
    red, green, blue = (int(value[i : i + 2], 16) for i in (1, 3, 5))
    return red, green, blue


PLACE_KEYS: Final[Mapping[str, Read]] = {
    "position": settings_tables.position,
    "quaternion": settings_tables.quaternion,
    "euler_zyx": settings_tables.euler_zyx,
}
WORLD_KEYS: Final[Mapping[str, Read]] = {
    "margin": settings_tables.number("mm", least=0.0),
    "allowed": _read_pairs,
    "drawing": settings_tables.text,
    "frame": settings_tables.text,
    "unit": settings_tables.unit,
}
ROBOT_KEYS: Final[Mapping[str, Read]] = {
    "robot": settings_tables.text,
    "tool": settings_tables.text,
    "packages": _read_folders,
    "links": settings_tables.choice("capsules"),
    "explored": settings_tables.text,
    "unknown": settings_tables.choice("blocked", "free"),
    **PLACE_KEYS,
}
SHAPE_KEYS: Final[Mapping[str, Read]] = {
    "box": _read_sizes(3),
    "sphere": READ_SIZE,
    "cylinder": _read_sizes(2),
    "capsule": _read_sizes(2),
    "mesh": settings_tables.text,
    "convex": settings_tables.text,
    "drawing": settings_tables.text,
}
PART_KEYS: Final[Mapping[str, Read]] = {
    **SHAPE_KEYS,
    **PLACE_KEYS,
    "unit": settings_tables.unit,
    "off": settings_tables.number("mm", least=0.0),
}
PARTS_KEY: Final = "parts"
BODY_KEYS: Final[Mapping[str, Read]] = {
    **PART_KEYS,
    PARTS_KEY: lambda value: value,
    "parent": settings_tables.text,
    "colour": _read_colour,
    "margin": settings_tables.number("mm", least=0.0),
    "locations": lambda value: value,
    "taken": _read_output,
    "released": _read_output,
}
