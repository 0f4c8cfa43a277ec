"""Tables of bodies in cell files: their keys, shapes, parts, positions and locations.

`cell_file` documents each key. Camera files and task files state bodies in the same way.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path as FilePath
from typing import Any, Final

from assistant.base.diagnostics import Diagnostic, Refused
from assistant.cell import mesh_files
from assistant.cell.drawing_bodies import Drawn, read_drawing
from assistant.cell.findings import BODY_TWICE, NO_SHAPE, SAME_BODY
from assistant.cell.scene import (
    WORLD,
    Body,
    Box,
    Capsule,
    Colour,
    Cylinder,
    Mesh,
    Part,
    Shape,
    Sphere,
)
from assistant.program import settings_tables
from assistant.program.geometry import Pose, Vector
from assistant.program.settings_tables import Read, Table, Wrong

_READ_SIZE: Final = settings_tables.number("mm", above=0.0)


def _read_sizes(count: int) -> Read:
    def read(value: Any) -> tuple[float, ...]:
        if not isinstance(value, list) or len(value) != count:
            raise Wrong("is no list of lengths", f"write {count} lengths in mm in brackets")
        return tuple(_READ_SIZE(one) for one in value)

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
_SHAPE_KEYS: Final[Mapping[str, Read]] = {
    "box": _read_sizes(3),
    "sphere": _READ_SIZE,
    "cylinder": _read_sizes(2),
    "capsule": _read_sizes(2),
    "mesh": settings_tables.text,
    "convex": settings_tables.text,
    "drawing": settings_tables.text,
}
PART_KEYS: Final[Mapping[str, Read]] = {
    **_SHAPE_KEYS,
    **PLACE_KEYS,
    "unit": settings_tables.unit,
    "off": settings_tables.number("mm", least=0.0),
}
_PARTS_KEY: Final = "parts"
BODY_KEYS: Final[Mapping[str, Read]] = {
    **PART_KEYS,
    _PARTS_KEY: lambda value: value,
    "parent": settings_tables.text,
    "colour": _read_colour,
    "margin": settings_tables.number("mm", least=0.0),
    "locations": lambda value: value,
    "taken": _read_output,
    "released": _read_output,
}


class BodyReader:
    """Reader of the body tables of a cell file.

    folder: folder of the files that the tables name. found: list that receives the findings about
    these files.
    """

    def __init__(self, folder: FilePath, found: list[Diagnostic]) -> None:
        self.folder, self.found = folder, found

    def read(self, top: Table, drawn: Iterable[Body] = ()) -> Iterator[Body]:
        """Those of a file. drawn: those of the drawing of its cell, whose names are taken."""
        seen = {body.name.casefold(): body.name for body in drawn}
        for name, entry in top.table("bodies").named():
            other = seen.get(name.casefold())
            if other is not None:
                rule = BODY_TWICE if other == name else SAME_BODY
                entry.say(rule, name=name, other=other)
            said = entry.read(BODY_KEYS)
            one = self._one(name, entry, said)
            if one is None:
                continue
            own = {k: pose_of(t.read(PLACE_KEYS)) for k, t in entry.table("locations").named()}
            yield replace(
                one,
                pose=pose_of(said),
                parent=said.get("parent", WORLD),
                colour=said.get("colour", one.colour),
                margin=said.get("margin"),
                taken=said.get("taken"),
                released=said.get("released"),
                locations={**one.locations, **own},
                source=str(entry.page.source.path or ""),
            )

    def drawing(self, said: Mapping[str, Any]) -> Drawn | None:
        """The drawing that a table names; None for none, or one that cannot be read."""
        if "drawing" not in said:
            return None
        try:
            found = read_drawing(self.folder / said["drawing"], said.get("unit"))
        except Refused as refused:
            self.found += refused.findings
            return None
        self.found += found.findings
        return found

    def _one(self, name: str, entry: Table, said: Mapping[str, Any]) -> Body | None:
        """A body with its shape, or with its parts."""
        key = self._kind(name, entry, (*_SHAPE_KEYS, _PARTS_KEY), said)
        if key == "drawing":
            drawing = self.drawing(said)
            return None if drawing is None else drawing.as_one(name)
        if key == _PARTS_KEY:
            found = [self._part(*named) for named in entry.table(_PARTS_KEY).named()]
            if said[_PARTS_KEY] == {}:
                entry.say(
                    NO_SHAPE, _PARTS_KEY, name=name, what="no parts", cure="write some, or a shape"
                )
            parts = tuple(part for part in found if part is not None)
            return Body(name, parts) if parts and len(parts) == len(found) else None
        shape = None if key is None else self._shape(name, key, entry, said)
        return None if shape is None else Body(name, (Part(shape),))

    def _part(self, name: str, entry: Table) -> Part | None:
        said = entry.read(PART_KEYS)
        key = self._kind(name, entry, tuple(key for key in _SHAPE_KEYS if key != "drawing"), said)
        shape = None if key is None else self._shape(name, key, entry, said)
        return None if shape is None else Part(shape, pose_of(said))

    def _kind(
        self, name: str, entry: Table, known: Sequence[str], said: Mapping[str, Any]
    ) -> str | None:
        """The key of the one shape of a table; None, and a finding, if there is not one."""
        shapes = [key for key in known if key in said]
        if len(shapes) == 1:
            return shapes[0]
        if shapes or not any(key in entry.content for key in known):  # else told of by its value
            what = "no shape" if not shapes else f"{len(shapes)} shapes"
            entry.say(NO_SHAPE, name=name, what=what, cure=f"write one of {', '.join(known)}")
        return None

    def _shape(self, name: str, key: str, entry: Table, said: Mapping[str, Any]) -> Shape | None:
        value = said[key]
        if "off" in said and key != "mesh":
            cure = "take it out, or make the shape larger"
            entry.say(NO_SHAPE, "off", name=name, what="an `off`, which is of a mesh", cure=cure)
        match key:
            case "box":
                return Box(_three(value))
            case "sphere":
                return Sphere(value)
            case "cylinder":
                return Cylinder(*value)
            case "capsule":
                return Capsule(*value)
        try:
            read = mesh_files.read_hull if key == "convex" else mesh_files.read_mesh
            shape: Shape
            shape, findings = read(self.folder / value, said.get("unit"))
        except Refused as refused:
            self.found += refused.findings
            return None
        self.found += findings
        if isinstance(shape, Mesh) and "off" in said:
            shape = replace(shape, off=shape.off + said["off"])
        return shape


def _three(value: tuple[float, ...]) -> Vector:
    x, y, z = value
    return x, y, z


def pose_of(said: Mapping[str, Any]) -> Pose:
    """Return the pose that the position and rotation keys of a table state."""
    turn = said["quaternion"][0] if "quaternion" in said else None
    return Pose(
        said.get("position", (0.0, 0.0, 0.0)),
        turn or said.get("euler_zyx", Pose().quaternion),
    )
