"""A scene as binary glTF 2.0: one file, a node a robot, a link and a body, by its name.

glTF is metres with y upwards; the node `cell` turns and scales all under it, whose poses are mm
with z upwards as in the cell. Bodies of a link hang on its node, so that an arm can be moved in
what shows the file. Source: Khronos, glTF 2.0 specification, 4.4 and chapters 3.6, 3.7.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats
from assistant.cell.collision.carriers import Carriers, carrier_of
from assistant.cell.scene import FLANGE, Body, Colour, Scene
from assistant.cell.surfaces import surface
from assistant.program.geometry import IDENTITY, Pose

GREY: Final[Colour] = (160, 165, 170)
ORANGE: Final[Colour] = (230, 120, 40)
"""Of links that name no colour."""
GLTF_FLOAT, GLTF_UNSIGNED = 5126, 5125
Z_TO_Y: Final = (-(0.5**0.5), 0.0, 0.0, 0.5**0.5)
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
    nodes = {0: file.node("cell", rotation=Z_TO_Y, scale=[0.001] * 3)}
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
        _add_body(file, body, pose, nodes[carrier], ORANGE if id(body) in links else GREY)
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
        where = self.accessor(single, GLTF_FLOAT, "VEC3", len(points), min=low, max=high)
        corners = triangles.astype("<u4").reshape(-1)
        indices = self.accessor(corners, GLTF_UNSIGNED, "SCALAR", len(corners))
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
