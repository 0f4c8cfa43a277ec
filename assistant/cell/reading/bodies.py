"""The bodies of a cell file: their shapes, or their parts, their places and their locations."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path as FilePath
from typing import Any

from assistant.base.diagnostics import Diagnostic, Refused
from assistant.cell.reading import meshes
from assistant.cell.reading.drawings import Drawn, read_drawing
from assistant.cell.reading.drawings.rules import BODY_TWICE
from assistant.cell.reading.keys import BODY_KEYS, PART_KEYS, PARTS_KEY, PLACE_KEYS, SHAPE_KEYS
from assistant.cell.rules import NO_SHAPE, SAME_BODY
from assistant.cell.scene import WORLD, Body, Part
from assistant.cell.shapes import Box, Capsule, Cylinder, Mesh, Shape, Sphere
from assistant.program.geometry import Pose, Vector
from assistant.program.settings_tables import Table


class BodyReader:
    """Reads them.

    folder: of the files that they name. found: takes what is to be said of these files.
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
        key = self._kind(name, entry, (*SHAPE_KEYS, PARTS_KEY), said)
        if key == "drawing":
            drawing = self.drawing(said)
            return None if drawing is None else drawing.as_one(name)
        if key == PARTS_KEY:
            found = [self._part(*named) for named in entry.table(PARTS_KEY).named()]
            if said[PARTS_KEY] == {}:
                entry.say(
                    NO_SHAPE, PARTS_KEY, name=name, what="no parts", cure="write some, or a shape"
                )
            parts = tuple(part for part in found if part is not None)
            return Body(name, parts) if parts and len(parts) == len(found) else None
        shape = None if key is None else self._shape(name, key, entry, said)
        return None if shape is None else Body(name, (Part(shape),))

    def _part(self, name: str, entry: Table) -> Part | None:
        said = entry.read(PART_KEYS)
        key = self._kind(name, entry, tuple(key for key in SHAPE_KEYS if key != "drawing"), said)
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
            read = meshes.read_hull if key == "convex" else meshes.read_mesh
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
    """What the keys of a place say."""
    turn = said["quaternion"][0] if "quaternion" in said else None
    return Pose(
        said.get("position", (0.0, 0.0, 0.0)),
        turn or said.get("euler_zyx", Pose().quaternion),
    )
