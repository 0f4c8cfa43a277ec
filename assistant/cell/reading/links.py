"""Bodies of the links of a robot as its file draws them: the shapes and meshes of a URDF."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path as FilePath
from typing import Final
from urllib.parse import unquote

from assistant.base.diagnostics import Diagnostic, Refused
from assistant.cell.reading import meshes
from assistant.cell.reading.rules import (
    FIXED_JOINTS,
    NO_MESH_FILE,
    NO_PACKAGE,
    UNDRAWN_LINKS,
    UNUSED_PACKAGE,
)
from assistant.cell.scene import Body, Part
from assistant.cell.shapes import Box, Capsule, Cylinder, Mesh, Shape, Sphere
from assistant.program.geometry import Vector
from assistant.robots.outlines import Outline, Outlines
from assistant.robots.robot import Robot

PACKAGE_SCHEME: Final = "package://"
FILE_SCHEME: Final = "file://"
NO_PACKAGE_NAMES: Final = ("", ".", "..")
"""What is a folder everywhere, and no package."""
URDF_UNIT: Final = "m"
"""Of the meshes of a URDF that state none."""


def drawn_links(
    name: str, robot: Robot, packages: Mapping[str, FilePath]
) -> tuple[tuple[Body, ...], tuple[Diagnostic, ...]]:
    """Bodies `NAME.base`, `NAME.J1` … of a robot whose file draws its links, and what is said.

    packages: folders of those that names of meshes begin with, `package://NAME/…`; for others the
    folders above the robot's file are looked through. Raises Unreadable for a mesh that cannot be
    read, Refused for one that is none or is not found.
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
                mesh, findings = meshes.read_mesh(file, URDF_UNIT, scale=one.scale)
                self.found += findings
                self.read[file, one.scale] = mesh
            except Refused as refused:
                self.wrong += refused.findings
                self.read[file, one.scale] = None
        return self.read[file, one.scale]

    def file(self, one: Outline) -> FilePath | None:
        """Where a mesh is; None, and a finding, if nobody knows."""
        said, folder = one.file, FilePath(self.outlines.folder)
        if said.startswith(FILE_SCHEME):
            return folder / unquote(said[len(FILE_SCHEME) :])
        if not said.startswith(PACKAGE_SCHEME):
            if "://" not in said:
                return folder / said
            if said not in self.missing:
                self.wrong.append(NO_MESH_FILE(link=one.link, file=said))
            self.missing.add(said)
            return None
        package, _, rest = unquote(said[len(PACKAGE_SCHEME) :]).partition("/")
        self.used.add(package)
        found = self.packages.get(package)
        if found is None and package not in NO_PACKAGE_NAMES:
            above = folder.resolve().parents
            found = next((up / package for up in above if (up / package).is_dir()), None)
        if found is None and package not in self.missing:
            self.wrong.append(NO_PACKAGE(package=package, link=one.link))
        self.missing.add(package)
        return None if found is None else found / rest
