"""Bodies of the links of an arm: from its lengths and radii, or from the shapes of its URDF.

By its lengths a link is a capsule along each straight part of its chain: from its axis along the
offset, then along its length. That is rounder than the casting that the maker draws; the shapes
and meshes of a URDF are closer to it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from itertools import pairwise
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Final
from urllib.parse import unquote
from weakref import WeakKeyDictionary

import numpy as np

from assistant.base.arrays import Floats, Rows, Truths, norms
from assistant.base.diagnostics import Diagnostic, Refused
from assistant.cell import mesh_files
from assistant.cell.findings import (
    FIXED_JOINTS,
    NO_MESH_FILE,
    NO_PACKAGE,
    UNDRAWN_LINKS,
    UNUSED_PACKAGE,
)
from assistant.cell.scene import (
    FLANGE,
    Body,
    Box,
    Capsule,
    Cylinder,
    Mesh,
    Part,
    PlacedRobot,
    Scene,
    Shape,
    Sphere,
)
from assistant.program.geometry import IDENTITY, Pose, Vector
from assistant.robots.arms.arm import rotation_from_z
from assistant.robots.robot import Outline, Outlines, Robot

if TYPE_CHECKING:
    from assistant.cell.collision.model import Model


_SHORTEST_LINK: Final = 1.0
"""Shortest link, in mm, that has its own body."""
_SEED: Final = 20
_RANDOM_POSES: Final = 1000
_POSES_AT_ONCE: Final = 50
"""Random poses per batch; after each, pairs that are decided are dropped."""
_ALWAYS_TOUCHING: Final = 0.95
"""Share of random poses in which two links touch that cannot be kept apart: their bodies are
rounder than the links."""


def place_robot(
    name: str, robot: Robot, base: Pose = IDENTITY, links: Iterable[Body] | None = None
) -> PlacedRobot:
    """A robot of a cell with the bodies of its links; by its lengths if none are given."""
    return PlacedRobot(
        name, robot, base, tuple(_link_bodies(name, robot) if links is None else links)
    )


def _link_bodies(name: str, robot: Robot) -> Iterator[Body]:
    """Yield bodies `NAME.base`, `NAME.J1` … of a robot, each carried by the link of its name.

    If axis 1 begins on the floor, the lower half of its column is the base. A horizontal arm has a
    column and a quill, see `_horizontal`.
    """
    chain = robot.arm.whole_chain
    if len(robot.axes) == 4 and robot.sliding.tolist() == [False, False, True, False]:
        yield from _horizontal(name, robot)
        return
    steps = [*(joint.pose.position for joint in chain.joints), chain.flange.position]
    origin, foot = np.zeros(3), np.zeros(3)
    for carrier, step, radius in zip(("base", *robot.axes), steps, robot.radii, strict=True):
        corners = [foot if carrier == "J1" else origin, _up(step), np.array(step)]
        if carrier == "base" and norms(np.array([step]))[0] <= _SHORTEST_LINK:
            corners = [origin, foot := _up(steps[1]) / 2.0]
        parts = tuple(
            capsule_between(start, end, float(radius))
            for start, end in pairwise(corners)
            if norms((end - start)[None])[0] > _SHORTEST_LINK
        )
        if parts:
            yield Body(f"{name}.{carrier}", parts, parent=f"{name}.{carrier}")


def _horizontal(name: str, robot: Robot) -> Iterator[Body]:
    """Yield the bodies of a SCARA: a column on the floor, two links at one height, and the quill.

    The lengths state how far apart the axes are, but not how high the links are: the links are
    assumed to lie just above the highest position of the flange, from which the quill extends
    downwards.
    """
    chain = robot.arm.whole_chain
    base, one, two, _, quill = (float(radius) for radius in robot.radii)
    steps = [np.array(joint.pose.position) for joint in chain.joints]
    low, high = (robot.limits[2] + robot.zero[2]) * float(chain.joints[2].axis[2])
    low, high = min(low, high), max(low, high)
    height = float(steps[0][2] + steps[1][2] + steps[2][2])
    up = max(height + high, height) + max(one, two) - height if height <= _SHORTEST_LINK else 0.0
    parts = {
        "base": (_upright(base, base, height + up - one - base),),
        "J1": (_between(_raised(steps[1] * [0, 0, 1], up), _raised(steps[1], up), one),),
        "J2": (_between(_raised(steps[2] * [0, 0, 1], up), _raised(steps[2], up), two),),
        "J4": (_upright(quill, quill, up - low + quill),),
    }
    for carrier, shapes in parts.items():
        there = tuple(part for part in shapes if part is not None)
        if there:
            yield Body(f"{name}.{carrier}", there, parent=f"{name}.{carrier}")


def _raised(place: Floats, by: float) -> Floats:
    return np.asarray(place + np.array([0.0, 0.0, by]))


def _upright(radius: float, low: float, high: float) -> Part | None:
    return _between(np.array([0.0, 0.0, low]), np.array([0.0, 0.0, high]), radius)


def _between(start: Floats, end: Floats, radius: float) -> Part | None:
    long = float(norms((end - start)[None])[0]) > _SHORTEST_LINK and start[2] <= end[2]
    return capsule_between(start, end, radius) if long else None


def _up(step: Vector) -> Floats:
    """Return the component along the z axis of a step to the next frame, as a step."""
    return np.array([0.0, 0.0, step[2]])


def capsule_between(start: Floats, end: Floats, radius: float) -> Part:
    """A capsule whose half spheres are about two points (3,)."""
    way = end - start
    length = float(norms(way[None])[0])
    x, y, z = (way / length).tolist()
    return Part(
        Capsule(radius, length), Pose.of((start + end) / 2.0, np.array(rotation_from_z((x, y, z))))
    )


_ALONE_NAME: Final = "robot"
"""Name of an arm outside a cell, as the names of its links state it."""
_THIN_TOOL_RADIUS: Final = 1.0
"""mm of the radius of what stands for a tool of which only the tip is known."""
_ARMS_ALONE: Final[WeakKeyDictionary[Robot, dict[tuple[str, Vector] | None, Scene]]] = (
    WeakKeyDictionary()
)
_MOST_SCENES_KEPT: Final = 64
"""Tools of an arm whose scenes are kept."""


def arm_alone(robot: Robot, tool: tuple[str, Pose] | None = None) -> Scene:
    """An arm without a cell, with a tool of a name and a tip, in which only contacts count.

    The tool is a thin rod from the middle of the flange to its tip.
    """
    key = None if tool is None else (tool[0], tool[1].position)
    if key is not None and float(norms(np.array([key[1]]))[0]) <= _SHORTEST_LINK:
        key = None
    made = _ARMS_ALONE.setdefault(robot, {})
    if key not in made:
        arm, bodies = place_robot(_ALONE_NAME, robot), list[Body]()
        if key is not None:
            rod = capsule_between(np.zeros(3), np.array(key[1]), _THIN_TOOL_RADIUS)
            bodies.append(Body(key[0], (rod,), parent=f"{_ALONE_NAME}.{FLANGE}"))
        out = touching_links(replace(arm, links=(*arm.links, *bodies)))
        if len(made) >= _MOST_SCENES_KEPT:
            made.clear()
        made[key] = Scene(tuple(bodies), (arm,), allowed=out, margin=0.0)
    return made[key]


def touching_links(placed: PlacedRobot) -> frozenset[tuple[str, str]]:
    """Return the pairs of an arm's bodies, in order, whose contact has no meaning.

    These are neighbours, bodies that touch when the arm is at home, and those that nearly always
    touch; the same three kinds that MoveIt's setup assistant disables.
    """
    from assistant.cell.collision.model import Model

    model = Model(Scene(robots=(placed,)))
    low, high = np.clip(placed.robot.limits, -360.0, 360.0).T
    rows = np.random.default_rng(_SEED).uniform(low, high, (_RANDOM_POSES, len(low)))
    rows[0] = placed.robot.home
    order = [body.name for body in placed.links]
    names = [item.body.name for item in model.items]
    both = [(names[i], names[k]) for i, k in zip(model.one, model.other, strict=True)]
    pairs = [(min(two), max(two)) for two in both]
    out = {two for two in pairs if abs(order.index(two[0]) - order.index(two[1])) == 1}
    open_ = np.array([pair for pair, two in enumerate(pairs) if two not in out], dtype=np.intp)
    clear = np.zeros(len(pairs), dtype=np.intp)
    for start in range(0, _RANDOM_POSES, _POSES_AT_ONCE):
        some = rows[start : start + _POSES_AT_ONCE]
        row, pair = (x.reshape(-1) for x in np.meshgrid(np.arange(len(some)), open_, indexing="ij"))
        touch = _touching(model, some, row, pair)
        if start == 0:
            out |= {pairs[p] for p in pair[(row == 0) & touch].tolist()}
        clear += np.bincount(pair[~touch], minlength=len(pairs))
        open_ = open_[clear[open_] <= round((1.0 - _ALWAYS_TOUCHING) * _RANDOM_POSES)]
    return frozenset(out | {pairs[p] for p in open_.tolist()})


def _touching(model: Model, rows: Floats, row: Rows, pair: Rows) -> Truths:
    """(k,) whether pairs (k,) touch, each for one of rows (n, j) of joints."""
    near = np.flatnonzero(model.least_of(rows, row, pair) <= 0.0)
    out = np.zeros(len(row), dtype=bool)
    out[near] = model.exact(rows, row[near], pair[near]) <= 0.0
    return out


_PACKAGE_SCHEME: Final = "package://"
_FILE_SCHEME: Final = "file://"
_NO_PACKAGE_NAMES: Final = ("", ".", "..")
"""Folder names that every system has, which are not package names."""
_URDF_UNIT: Final = "m"
"""Unit of the meshes of a URDF that state no unit."""


def drawn_links(
    name: str, robot: Robot, packages: Mapping[str, FilePath]
) -> tuple[tuple[Body, ...], tuple[Diagnostic, ...]]:
    """Return bodies `NAME.base`, `NAME.J1` … of a robot whose file draws its links, with findings.

    packages: folders of the packages in the names of meshes, `package://NAME/…`; other packages are
    searched in the folders above the robot's file. Raises Unreadable for a mesh that cannot be
    read, Refused for a file that is not a mesh or is not found.
    """
    assert robot.outlines is not None
    reader = _Links(robot.outlines, packages)
    bodies = tuple(reader.bodies(name, robot))
    if reader.wrong:
        raise Refused(*reader.wrong)
    for package in sorted(packages.keys() - reader.used):
        reader.found.append(UNUSED_PACKAGE(name=name, package=package))
    there = {body.parent.removeprefix(f"{name}.") for body in bodies}
    bare = [link for link in ("base", *robot.axes) if link not in there]
    if "flange" in there and bare and bare[-1] == robot.axes[-1]:
        bare.pop()  # it moves with the last link
    if bare:
        reader.found.append(UNDRAWN_LINKS(name=name, links=", ".join(bare)))
    if robot.outlines.still:
        joints = ", ".join(f"`{joint}`" for joint in robot.outlines.still)
        reader.found.append(FIXED_JOINTS(name=name, joints=joints))
    return bodies, tuple(reader.found)


class _Links:
    def __init__(self, outlines: Outlines, packages: Mapping[str, FilePath]) -> None:
        self.outlines, self.packages = outlines, packages
        self.wrong: list[Diagnostic] = list(outlines.wrong)
        self.found: list[Diagnostic] = []
        self.used: set[str] = set()
        self.missing: set[str] = set()
        self.read: dict[tuple[FilePath, Vector], Mesh | None] = {}

    def bodies(self, name: str, robot: Robot) -> Iterator[Body]:
        for carrier in ("base", *robot.axes, "flange"):
            shapes = [one for one in self.outlines.shapes if one.carrier == carrier]
            parts = tuple(
                Part(shape, one.pose) for one in shapes if (shape := self.shape(one)) is not None
            )
            if parts:
                yield Body(f"{name}.{carrier}", parts, parent=f"{name}.{carrier}")

    def shape(self, one: Outline) -> Shape | None:
        match one.kind, one.sizes:
            case "box", (x, y, z):
                return Box((x, y, z))
            case "sphere", (radius,):
                return Sphere(radius)
            case "cylinder", (radius, length):
                return Cylinder(radius, length)
            case "capsule", (radius, length):
                return Capsule(radius, length)
        return self.mesh(one)

    def mesh(self, one: Outline) -> Mesh | None:
        file = self.file(one)
        if file is None:
            return None
        if (file, one.scale) not in self.read:
            try:
                mesh, findings = mesh_files.read_mesh(file, _URDF_UNIT, scale=one.scale)
                self.found += findings
                self.read[file, one.scale] = mesh
            except Refused as refused:
                self.wrong += refused.findings
                self.read[file, one.scale] = None
        return self.read[file, one.scale]

    def file(self, one: Outline) -> FilePath | None:
        """Return the path of a mesh; None, and a finding, if it is unknown."""
        said, folder = one.file, FilePath(self.outlines.folder)
        if said.startswith(_FILE_SCHEME):
            return folder / unquote(said[len(_FILE_SCHEME) :])
        if not said.startswith(_PACKAGE_SCHEME):
            if "://" not in said:
                return folder / said
            if said not in self.missing:
                self.wrong.append(NO_MESH_FILE(link=one.link, file=said))
            self.missing.add(said)
            return None
        package, _, rest = unquote(said[len(_PACKAGE_SCHEME) :]).partition("/")
        self.used.add(package)
        found = self.packages.get(package)
        if found is None and package not in _NO_PACKAGE_NAMES:
            above = folder.resolve().parents
            found = next((up / package for up in above if (up / package).is_dir()), None)
        if found is None and package not in self.missing:
            self.wrong.append(NO_PACKAGE(package=package, link=one.link))
        self.missing.add(package)
        return None if found is None else found / rest
