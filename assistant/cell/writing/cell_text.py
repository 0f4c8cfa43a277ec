"""A scene as the text of a cell file, with its meshes in files beside it, which reads as the same.

Bodies of a drawing or of a mesh file become bodies of their own, in mm. Which links of one arm may
touch is worked out anew by who reads it.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from pathlib import Path as FilePath
from typing import Any, Final

from assistant import robots
from assistant.base.diagnostics import Refused
from assistant.cell.arms import touching_links
from assistant.cell.scene import MARGIN, WORLD, Body, Part, PlacedRobot, Scene
from assistant.cell.shapes import Box, Capsule, Convex, Cylinder, Mesh, Sphere
from assistant.cell.writing.rules import CHART_BODY, UNNAMED_ROBOT, UNWRITABLE_NAME
from assistant.program.geometry import IDENTITY, Pose
from assistant.program.program import IDENTIFIER
from assistant.sources.cell import toml_value

MESH_SUFFIX: Final = ".obj"


def cell_files(scene: Scene, name: str, folder: FilePath) -> dict[str, bytes]:
    """The files of a cell, by their names in a folder: `NAME.toml` first, and one for each mesh.

    Files of robots are named from there, and their charts; what those add is none of the bodies of
    the scene, see `read_scene`. Raises Refused for a robot that is in no file, and for
    names that a cell file cannot hold.
    """
    _check_names(scene)
    files: dict[str, bytes] = {}
    world = list(_world(scene))
    parts = ["\n".join(["[world]", *world])] if world else []
    for frame, pose in scene.frames.items():
        parts.append("\n".join([f"[frames.{frame}]", *_place_keys(pose)]))
    parts += ["\n".join(_robot(placed, folder)) for placed in scene.robots]
    for body in scene.bodies:
        parts.append("\n".join(_body(body, name, files)))
    text = "\n\n".join(parts) + "\n" if parts else ""
    return {f"{name}.toml": text.encode(), **files}


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


def _world(scene: Scene) -> Iterator[str]:
    if scene.margin != MARGIN:
        yield f"margin = {toml_value(scene.margin)}"
    if pairs := _allowed(scene):
        yield f"allowed = {toml_value(pairs)}"


def _robot(placed: PlacedRobot, folder: FilePath) -> Iterator[str]:
    yield f"[robots.{placed.name}]"
    named = placed.named
    if named is None or named.robot in robots.names():
        name = placed.robot.name if named is None else named.robot
        if name not in robots.names() or robots.get(name) is not placed.robot:
            raise Refused(UNNAMED_ROBOT(name=placed.name))
        yield f"robot = {toml_value(name)}"
    else:
        yield f"robot = {toml_value(_from(folder, named.robot))}"
    if named is not None and named.packages:
        pairs = (f"{k} = {toml_value(_from(folder, v))}" for k, v in _keyed(named.packages))
        yield f"packages = {{{', '.join(pairs)}}}"
    if named is not None and named.capsules:
        yield 'links = "capsules"'
    if named is not None and named.explored:
        yield f"explored = {toml_value(_from(folder, named.explored))}"
        if named.unknown:
            yield f"unknown = {toml_value(named.unknown)}"
    yield from _place_keys(placed.base)


def _keyed(table: Mapping[str, str]) -> Iterator[tuple[str, str]]:
    """With keys as TOML has them."""
    for key, value in table.items():
        yield key if IDENTIFIER.fullmatch(key) else toml_value(key), value


def _from(folder: FilePath, path: str) -> str:
    try:
        return FilePath(os.path.relpath(path, folder.absolute())).as_posix()
    except ValueError:  # on another drive
        return FilePath(path).as_posix()


def _place_keys(pose: Pose) -> Iterator[str]:
    if pose.position != IDENTITY.position:
        yield f"position = {toml_value(pose.position)}"
    if pose.quaternion != IDENTITY.quaternion:
        yield f"quaternion = {toml_value(pose.quaternion)}"


def _body(body: Body, name: str, files: dict[str, bytes]) -> Iterator[str]:
    yield f"[bodies.{body.name}]"
    whole = len(body.parts) == 1 and body.parts[0].pose == IDENTITY
    if whole:
        yield from _shape(body.parts[0], f"{name}.{body.name}", files)
    if body.parent != WORLD:
        yield f"parent = {toml_value(body.parent)}"
    yield from _place_keys(body.pose)
    if body.colour is not None:
        yield 'colour = "#{:02x}{:02x}{:02x}"'.format(*body.colour)
    if body.margin is not None:
        yield f"margin = {toml_value(body.margin)}"
    for key, output in (("taken", body.taken), ("released", body.released)):
        if output is not None:
            yield f"{key} = {{{toml_value(output[0])} = {toml_value(output[1])}}}"
    for number, part in enumerate(() if whole else body.parts, 1):
        yield f"\n[bodies.{body.name}.parts.p{number}]"
        yield from _shape(part, f"{name}.{body.name}.p{number}", files)
        yield from _place_keys(part.pose)
    for key, pose in body.locations.items():
        yield f"\n[bodies.{body.name}.locations.{key}]"
        yield from _place_keys(pose)


def _shape(part: Part, file: str, files: dict[str, bytes]) -> Iterator[str]:
    match part.shape:
        case Box(size=size):
            yield f"box = {toml_value(size)}"
        case Sphere(radius=radius):
            yield f"sphere = {toml_value(radius)}"
        case Cylinder(radius=radius, length=length):
            yield f"cylinder = {toml_value((radius, length))}"
        case Capsule(radius=radius, length=length):
            yield f"capsule = {toml_value((radius, length))}"
        case Convex() as hull:
            yield from _mesh("convex", hull.hull, file, files)
        case Mesh() as mesh:
            yield from _mesh("mesh", mesh, file, files)
            if mesh.off:
                yield f"off = {toml_value(mesh.off)}"


def _mesh(key: str, mesh: Mesh, file: str, files: dict[str, bytes]) -> Iterator[str]:
    files[file + MESH_SUFFIX] = _obj(mesh)
    yield f"{key} = {toml_value(file + MESH_SUFFIX)}"
    yield 'unit = "mm"'


def _obj(mesh: Mesh) -> bytes:
    """Wavefront OBJ: a line `v x y z` a corner, `f a b c` a triangle, counted from 1."""
    rows: list[Any] = [f"v {x!r} {y!r} {z!r}" for x, y, z in mesh.points.tolist()]
    rows += [f"f {a} {b} {c}" for a, b, c in (mesh.triangles + 1).tolist()]
    return ("\n".join(rows) + "\n").encode("ascii")
