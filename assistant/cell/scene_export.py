"""Write a scene for other programs: as a cell file with its meshes, or as binary glTF 2.0.

A written cell file reads back as the same scene. Bodies of a drawing or of a mesh file become
separate bodies, in mm; the reader works out anew which links of one arm may touch.

The glTF is one file with a node for each robot, link and body, by its name. glTF is metres with y
upwards; the node `cell` turns and scales all below it, whose poses are mm with z upwards as in the
cell. Bodies of a link hang on its node, so that a viewer can move the arm. Source: Khronos, glTF
2.0 specification, 4.4 and chapters 3.6, 3.7.
"""

from __future__ import annotations

import json
import os
import struct
from collections.abc import Mapping
from dataclasses import field
from pathlib import Path as FilePath
from typing import Any, Final

import numpy as np

from assistant import robots
from assistant.base import rotations
from assistant.base.arrays import Floats
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Refused
from assistant.base.toml_edits import toml_item, toml_text
from assistant.cell.collision.model import Carriers, carrier_of
from assistant.cell.findings import CHART_BODY, UNNAMED_ROBOT, UNWRITABLE_NAME
from assistant.cell.link_bodies import touching_links
from assistant.cell.scene import (
    FLANGE,
    MARGIN,
    WORLD,
    Body,
    Box,
    Capsule,
    Colour,
    Convex,
    Cylinder,
    Mesh,
    Part,
    PlacedRobot,
    Scene,
    Sphere,
    surface,
)
from assistant.program.geometry import IDENTITY, Pose
from assistant.program.program import IDENTIFIER

_MESH_SUFFIX: Final = ".obj"


def cell_files(scene: Scene, name: str, folder: FilePath) -> dict[str, bytes]:
    """Return the files of a cell, by their names in a folder: `NAME.toml` first, and one for each
    mesh.

    Files of robots and their charts are named relative to that folder; the bodies that charts add
    are not among the bodies of the scene, see `read_scene`. Raises Refused for a robot that is in
    no file, and for names that a cell file cannot hold.
    """
    _check_names(scene)
    files: dict[str, bytes] = {}
    content = {
        "world": _world(scene) or None,
        "frames": {name: _place_keys(pose) for name, pose in scene.frames.items()} or None,
        "robots": {placed.name: _robot(placed, folder) for placed in scene.robots} or None,
        "bodies": {body.name: _body(body, name, files) for body in scene.bodies} or None,
    }
    return {f"{name}.toml": toml_text(content).encode(), **files}


def _check_names(scene: Scene) -> None:
    """Raises Refused for names and bodies that a cell file cannot hold."""
    names = [*scene.frames, *(placed.name for placed in scene.robots)]
    for body in scene.bodies:
        names += [body.name, *body.locations]
    wrong = [name for name in dict.fromkeys(names) if not IDENTIFIER.fullmatch(name)]
    if wrong:
        raise Refused(*(UNWRITABLE_NAME(name=name) for name in wrong))
    for body in scene.bodies:
        if any(getattr(part.shape, "within", None) is not None for part in body.parts):
            raise Refused(CHART_BODY(name=body.name))


def _allowed(scene: Scene) -> list[tuple[str, str]]:
    """Pairs that may touch, without those that are worked out anew."""
    known: set[tuple[str, str]] = set()
    for placed in scene.robots:
        known |= touching_links(placed)
    return sorted(scene.allowed - known)


def _world(scene: Scene) -> dict[str, Any]:
    world: dict[str, Any] = {}
    if scene.margin != MARGIN:
        world["margin"] = scene.margin
    if pairs := _allowed(scene):
        world["allowed"] = pairs
    return world


def _robot(placed: PlacedRobot, folder: FilePath) -> dict[str, Any]:
    named = placed.named
    if named is None or named.robot in robots.names():
        name = placed.robot.name if named is None else named.robot
        if name not in robots.names() or robots.get(name) is not placed.robot:
            raise Refused(UNNAMED_ROBOT(name=placed.name))
    else:
        name = _from(folder, named.robot)
    table: dict[str, Any] = {"robot": name}
    if named is not None and named.packages:
        packages = {key: _from(folder, path) for key, path in named.packages.items()}
        table["packages"] = toml_item(packages)
    if named is not None and named.capsules:
        table["links"] = "capsules"
    if named is not None and named.explored:
        table["explored"] = _from(folder, named.explored)
        table["unknown"] = named.unknown or None
    return table | _place_keys(placed.base)


def _from(folder: FilePath, path: str) -> str:
    try:
        return FilePath(os.path.relpath(path, folder.absolute())).as_posix()
    except ValueError:  # on another drive
        return FilePath(path).as_posix()


def _place_keys(pose: Pose) -> dict[str, Any]:
    return {
        "position": pose.position if pose.position != IDENTITY.position else None,
        "quaternion": pose.quaternion if pose.quaternion != IDENTITY.quaternion else None,
    }


def _body(body: Body, name: str, files: dict[str, bytes]) -> dict[str, Any]:
    table: dict[str, Any] = {}
    whole = len(body.parts) == 1 and body.parts[0].pose == IDENTITY
    if whole:
        table |= _shape(body.parts[0], f"{name}.{body.name}", files)
    table |= {"parent": body.parent if body.parent != WORLD else None, **_place_keys(body.pose)}
    if body.colour is not None:
        table["colour"] = "#{:02x}{:02x}{:02x}".format(*body.colour)
    table["margin"] = body.margin
    for key, output in (("taken", body.taken), ("released", body.released)):
        table[key] = None if output is None else toml_item(dict([output]))
    if not whole:
        table["parts"] = {
            f"p{number}": _shape(part, f"{name}.{body.name}.p{number}", files)
            | _place_keys(part.pose)
            for number, part in enumerate(body.parts, 1)
        } or None
    table["locations"] = {key: _place_keys(pose) for key, pose in body.locations.items()} or None
    return table


def _shape(part: Part, file: str, files: dict[str, bytes]) -> dict[str, Any]:
    match part.shape:
        case Box(size=size):
            return {"box": size}
        case Sphere(radius=radius):
            return {"sphere": radius}
        case Cylinder(radius=radius, length=length):
            return {"cylinder": (radius, length)}
        case Capsule(radius=radius, length=length):
            return {"capsule": (radius, length)}
        case Convex() as hull:
            return _mesh("convex", hull.hull, file, files)
        case Mesh() as mesh:
            return _mesh("mesh", mesh, file, files) | {"off": mesh.off or None}
    return {}


def _mesh(key: str, mesh: Mesh, file: str, files: dict[str, bytes]) -> dict[str, Any]:
    files[file + _MESH_SUFFIX] = _obj(mesh)
    return {key: file + _MESH_SUFFIX, "unit": "mm"}


def _obj(mesh: Mesh) -> bytes:
    """Wavefront OBJ: a line `v x y z` a corner, `f a b c` a triangle, counted from 1."""
    rows: list[Any] = [f"v {x!r} {y!r} {z!r}" for x, y, z in mesh.points.tolist()]
    rows += [f"f {a} {b} {c}" for a, b, c in (mesh.triangles + 1).tolist()]
    return ("\n".join(rows) + "\n").encode("ascii")


_GREY: Final[Colour] = (160, 165, 170)
_ORANGE: Final[Colour] = (230, 120, 40)
"""Colour of links that name no colour."""
_GLTF_FLOAT, _GLTF_UNSIGNED = 5126, 5125
_Z_TO_Y: Final = (-(0.5**0.5), 0.0, 0.0, 0.5**0.5)
"""A quarter turn about x that leads z to y, as glTF has it (x, y, z, w)."""


def gltf(scene: Scene, joints: Mapping[str, Floats] | None = None) -> bytes:
    """The bytes of a `.glb`. joints: (a,) degrees or mm of robots by name, the others at home.

    Raises Refused for a body whose parent the scene has not.
    """
    given = joints or {}
    carriers = Carriers(scene.robots)
    row = [np.asarray(given.get(p.name, p.robot.home), dtype=np.float64) for p in scene.robots]
    origins, turns = carriers.at(np.concatenate([np.zeros(0), *row])[None])
    file = _GltfFile()
    nodes = {0: file.node("cell", rotation=_Z_TO_Y, scale=[0.001] * 3)}
    for placed, first in zip(scene.robots, carriers.first, strict=True):
        names, before = ("base", *placed.robot.axes, FLANGE), IDENTITY
        for i, name in enumerate(names):
            local = pose = _node_pose(origins[0, first + i], turns[0, first + i])
            if i:
                local = before.inverse() @ pose
            parent, before = nodes[first + i - 1 if i else 0], pose
            title = placed.name if i == 0 else f"{placed.name} {name}"
            nodes[first + i] = file.posed(title, local, parent)
    links = {id(link) for placed in scene.robots for link in placed.links}
    for body in scene.all_bodies():
        if not body.shown:
            continue
        carrier, pose = carrier_of(scene, body, carriers)
        _add_body(file, body, pose, nodes[carrier], _ORANGE if id(body) in links else _GREY)
    return file.bytes()


def _add_body(file: _GltfFile, body: Body, pose: Pose, parent: int, usual: Colour) -> None:
    """A node of a body; under it one of each part, its locations as nodes without a mesh."""
    node = file.posed(body.name, pose, parent)
    colour = body.colour or usual
    for part in body.parts:
        seen = surface(part.shape)
        own = file.posed(f"{body.name} part", part.pose, node)
        file.nodes[own]["mesh"] = file.mesh(body.name, seen.points, seen.triangles, colour)
    for name, at in body.locations.items():
        file.posed(f"{body.name} {name}", at, node)


def _node_pose(origin: Floats, turn: Floats) -> Pose:
    return Pose.of(origin, rotations.from_matrix(turn))


@dataclass(slots=True)
class _GltfFile:
    nodes: list[dict[str, Any]] = field(default_factory=list)
    meshes: list[dict[str, Any]] = field(default_factory=list)
    materials: dict[Colour, int] = field(default_factory=dict)
    accessors: list[dict[str, Any]] = field(default_factory=list)
    views: list[dict[str, Any]] = field(default_factory=list)
    data: bytearray = field(default_factory=bytearray)

    def node(self, name: str, **fields: Any) -> int:
        self.nodes.append({"name": name, **fields})
        return len(self.nodes) - 1

    def posed(self, name: str, pose: Pose, parent: int) -> int:
        w, x, y, z = pose.quaternion
        place = {} if pose == IDENTITY else {
            "translation": list(pose.position), "rotation": [x, y, z, w]
        }  # fmt: skip
        number = self.node(name, **place)
        self.nodes[parent].setdefault("children", []).append(number)
        return number

    def mesh(self, name: str, points: Floats, triangles: Any, colour: Colour) -> int:
        material = self.materials.setdefault(colour, len(self.materials))
        single = points.astype("<f4")
        low, high = single.min(axis=0).tolist(), single.max(axis=0).tolist()
        where = self.accessor(single, _GLTF_FLOAT, "VEC3", len(points), min=low, max=high)
        corners = triangles.astype("<u4").reshape(-1)
        indices = self.accessor(corners, _GLTF_UNSIGNED, "SCALAR", len(corners))
        piece = {"attributes": {"POSITION": where}, "indices": indices, "material": material}
        self.meshes.append({"name": name, "primitives": [piece]})
        return len(self.meshes) - 1

    def accessor(self, values: Any, of: int, kind: str, count: int, **more: Any) -> int:
        raw = np.ascontiguousarray(values).tobytes()
        self.views.append({"buffer": 0, "byteOffset": len(self.data), "byteLength": len(raw)})
        self.data += raw
        view = len(self.views) - 1
        entry = {"bufferView": view, "componentType": of, "count": count, "type": kind, **more}
        self.accessors.append(entry)
        return len(self.accessors) - 1

    def bytes(self) -> bytes:
        """Header, then JSON and data, each padded to four bytes."""
        said: dict[str, Any] = {
            "asset": {"version": "2.0", "generator": "robot-assistant"},
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": self.nodes,
        }
        if self.meshes:
            said |= {
                "meshes": self.meshes,
                "materials": [_material(colour) for colour in self.materials],
                "accessors": self.accessors,
                "bufferViews": self.views,
                "buffers": [{"byteLength": len(self.data)}],
            }
        text = json.dumps(said, separators=(",", ":"), allow_nan=False).encode("ascii")
        text += b" " * (-len(text) % 4)
        chunks = struct.pack("<I4s", len(text), b"JSON") + text
        if self.data:
            chunks += struct.pack("<I4s", len(self.data), b"BIN\0") + bytes(self.data)
        return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def _material(colour: Colour) -> dict[str, Any]:
    """GlTF's factors are linear light; those of a colour are sRGB (IEC 61966-2-1)."""
    light = [v / 3294.6 if v <= 10 else ((v / 255.0 + 0.055) / 1.055) ** 2.4 for v in colour]
    surface = {"baseColorFactor": [*light, 1.0], "metallicFactor": 0.1, "roughnessFactor": 0.7}
    return {"name": "#{:02x}{:02x}{:02x}".format(*colour), "pbrMetallicRoughness": surface}
