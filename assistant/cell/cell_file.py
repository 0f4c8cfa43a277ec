"""Read the scene of a cell file: robots and bodies, in TOML next to tools, frames and signals.

    [world]
    margin = 5                    # mm; a smaller distance is a warning, contact is an error
    drawing = "cell.dxf"          # each inserted block is a body, each layer of the rest is one
    frame = "bench"               # frame of the drawing's world; default: the world
    unit = "in"                   # unit of the drawing; overrides the drawing's own
    allowed = [["table", "arm.base"]]  # pairs that may touch

    [robots.arm]
    robot = "irb1200-7-0.7"       # from the catalogue, or a robot file next to this file
    position = [0, 0, 0]          # of its base in the world; with euler_zyx or quaternion
    tool = "nozzle"               # a body that its flange carries from the start
    explored = "arm.npz"          # chart of explored space, which the robot must not leave; with
    unknown = "free"              # only occupied cells block it; default: "blocked"
    packages = {abb = "../abb"}   # folders of meshes that its URDF names as package://abb/…
    links = "capsules"            # use capsules from its lengths, not the shapes of its URDF

    [bodies.table]
    box = [800, 600, 30]          # edges in mm; or one of
    # sphere = 40                 # radius
    # cylinder = [40, 200]        # radius, length along z
    # capsule = [40, 200]         # radius, length between the centres of its half spheres
    # mesh = "vice.stl"           # triangle file: STL, OBJ, PLY, 3MF, glTF; a closed one is solid
    # convex = "vice.stl"         # the convex hull of such a file
    # drawing = "vice.dxf"        # all bodies of a drawing, and its locations, as one body
    unit = "mm"                   # of a file that states no unit
    off = 0.5                     # largest deviation in mm of a mesh from the object it models
    position = [600, 0, -15]      # of its centre (of a file: its origin) in its parent's frame
    parent = "world"              # a frame of this file, another body, or a link: arm.flange
    colour = "#8090a0"
    margin = 10
    taken = {gripper = 1}         # output that makes the tool take the body if it is then within
    released = {gripper = 0}      # its margin of the tool; {"hand 1" = 1} for a hand: 1 is closed

    [bodies.table.locations.corner]
    position = [-400, -300, 15]   # in the body's frame

    [bodies.gripper.parts.left]   # several shapes instead of one, each with a pose in the
    box = [10, 20, 60]            # body's frame
    position = [0, 30, 30]

Names of links are those of the robot and its axis: `arm.base`, `arm.J2`, `arm.flange`.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path as FilePath
from typing import Any, Final

from assistant import robots
from assistant.base.budgets import SETTINGS_FILE
from assistant.base.diagnostics import Diagnostic, Refused, has_errors
from assistant.base.near_names import near_names
from assistant.base.source_text import SourceText, decode, read_bytes
from assistant.cell import link_bodies
from assistant.cell.body_tables import PLACE_KEYS, ROBOT_KEYS, WORLD_KEYS, BodyReader, pose_of
from assistant.cell.collision.model import Carriers
from assistant.cell.exploration.known_space import mapped
from assistant.cell.exploration.occupancy import load_map
from assistant.cell.findings import (
    CIRCULAR_PARENTS,
    LONELY_TOOL,
    NO_BODY,
    NO_PARENT,
    NO_ROBOT,
    NO_SHAPE,
    NOTHING_UNKNOWN,
    UNUSED_PACKAGE,
)
from assistant.cell.link_bodies import drawn_links
from assistant.cell.scene import MARGIN, Body, PlacedRobot, RobotReference, Scene
from assistant.cell.scene import WORLD as WORLD_FRAME
from assistant.program import settings_tables
from assistant.program.geometry import Frame
from assistant.program.settings_tables import ENCODINGS, Table, read_toml

_MOST_NAMES: Final = 12
"""Largest number of possible parents that a message lists."""


def read_scene(
    path: str | FilePath, *, explored: bool = True
) -> tuple[Scene, tuple[Diagnostic, ...]]:
    """Read the scene of a cell file; return it with its findings.

    explored: False for a scene without the bodies that charts of explored space add. Raises
    Unreadable if the file is not TOML or a mesh file is unreadable, Refused, with every finding, if
    the content has errors.
    """
    source = decode(read_bytes(path, most=SETTINGS_FILE), str(path), ENCODINGS)
    return parse_scene(source, FilePath(path).parent, explored=explored)


def parse_scene(
    source: SourceText, folder: FilePath, *, explored: bool = True
) -> tuple[Scene, tuple[Diagnostic, ...]]:
    """Parse a scene from text, like `read_scene`; folder: folder of the files that the text
    names.
    """
    reader = _CellReader(read_toml(source), folder)
    scene = reader.scene()
    if explored and not has_errors((*reader.top.page.findings, *reader.found)):
        scene = reader.explored(scene)
    found = (*reader.top.page.findings, *reader.found)
    if has_errors(found):
        raise Refused(*found)
    return scene, found


class _CellReader:
    def __init__(self, top: Table, folder: FilePath) -> None:
        self.top, self.folder = top, folder
        self.found: list[Diagnostic] = []
        self.bodies = BodyReader(folder, self.found)
        self.maps: dict[str, Mapping[str, Any]] = {}

    def scene(self) -> Scene:
        world = self.top.table("world").read(WORLD_KEYS)
        drawn = tuple(self.drawn(world))
        bodies = (*drawn, *self.bodies.read(self.top, drawn))
        placed = []
        for name, entry in self.top.table("robots").named():
            one, tool = self.robot(name, entry)
            if one is not None:
                placed.append(one)
                if tool is not None:
                    bodies = tuple(self.carried(bodies, tool, name, entry))
        frames = {name: frame.pose for name, frame in self.frames().items()}
        scene = Scene(bodies, tuple(placed), frames, margin=world.get("margin", MARGIN))
        allowed = {(min(p), max(p)) for p in world.get("allowed", ())}
        for name in sorted({name for pair in allowed for name in pair}):
            if name not in {body.name for body in scene.all_bodies()}:
                self.top.table("world").say(NO_BODY, "allowed", name=settings_tables.shown(name))
        for one in placed:
            allowed |= link_bodies.touching_links(one)
        self.stand(scene, drawn)
        return replace(scene, allowed=frozenset(allowed))

    def stand(self, scene: Scene, drawn: Iterable[Body]) -> None:
        """Report bodies whose parent is missing or is carried by the body, if there is no other
        error.
        """
        if has_errors((*self.top.page.findings, *self.found)):
            return
        carriers = Carriers(scene.robots)
        frames = [*carriers.names, *scene.frames]
        known = ", ".join(f"`{name}`" for name in frames[:_MOST_NAMES])
        there = {*frames, *(body.name for body in scene.bodies)}
        for body in drawn:
            if body.parent not in there:
                at = self.top.table("world")
                said = settings_tables.shown(body.parent)
                at.say(NO_PARENT, "frame", name=body.name, parent=said, known=known)
                return
        for name, entry in self.top.table("bodies").named():
            one = scene.body(name)
            assert one is not None
            said = settings_tables.shown(one.parent)
            if one.parent not in there:
                entry.say(NO_PARENT, "parent", name=name, parent=said, known=known)
            elif _in_itself(scene, one):
                entry.say(CIRCULAR_PARENTS, "parent", name=name, parent=said)
                return

    def explored(self, scene: Scene) -> Scene:
        """With what the charts of its robots leave unknown, or have occupied."""
        for name, said in self.maps.items():
            blocked = said.get("unknown", "blocked") == "blocked"
            try:
                occupancy = load_map(self.folder / said["explored"])
                scene, findings = mapped(scene, occupancy, name, blocked=blocked)
            except Refused as refused:
                self.found += refused.findings
                continue
            self.found += findings
        return scene

    def frames(self) -> dict[str, Frame]:
        """Return the frames of the file that an arm does not hold; errors in them are reported by
        the reader of the rest of the file.
        """
        found = {}
        for name, entry in self.top.table("frames").named():
            quiet = Table(replace(entry.page, findings=[]), entry.path, entry.content)
            said = quiet.read({**PLACE_KEYS, "held": settings_tables.truth})
            if not said.get("held", False):
                found[name] = Frame(pose_of(said))
        return found

    def robot(self, name: str, entry: Table) -> tuple[PlacedRobot | None, str | None]:
        said = entry.read(ROBOT_KEYS)
        if "robot" not in said:
            entry.say(NO_SHAPE, name=name, what="robot", cure='write robot = "…"')
            return None, None
        try:
            robot = self.known_robot(said["robot"], entry)
        except Refused as refused:
            self.found += refused.findings
            return None, None
        try:
            links = self.links(name, robot, said, entry)
        except Refused as refused:
            self.found += refused.findings
            return None, None
        if "explored" in said:
            self.maps[name] = said
        elif "unknown" in said:
            entry.say(NOTHING_UNKNOWN, "unknown", name=name)
        placed = link_bodies.place_robot(name, robot, pose_of(said), links)
        return replace(placed, named=self.named(said)), said.get("tool")

    def named(self, said: Mapping[str, Any]) -> RobotReference:
        """Return the file's reference to a robot, with absolute paths."""
        file = self.folder / said["robot"]
        name = str(file.absolute()) if self.is_file(file) else said["robot"]
        packages = {
            package: str((self.folder / folder).absolute())
            for package, folder in said.get("packages", {}).items()
        }
        chart = str((self.folder / said["explored"]).absolute()) if "explored" in said else ""
        capsules = said.get("links") == "capsules"
        return RobotReference(name, packages, capsules, chart, said.get("unknown", ""))

    def is_file(self, file: FilePath) -> bool:
        # Systems refuse to look for names over 255 characters.
        possible = max(map(len, file.parts), default=0) < 256
        return file.suffix.lower() in (".toml", ".urdf", ".xml") and possible and file.exists()

    def links(
        self, name: str, robot: robots.Robot, said: Mapping[str, Any], entry: Table
    ) -> tuple[Body, ...] | None:
        """The bodies of its links that the file of a robot draws; None for those by its lengths."""
        packages = {key: self.folder / folder for key, folder in said.get("packages", {}).items()}
        if robot.outlines is None or said.get("links") == "capsules":
            for package in packages:
                entry.say(
                    UNUSED_PACKAGE, "packages", name=name, package=settings_tables.shown(package)
                )
            return None
        bodies, found = drawn_links(name, robot, packages)
        self.found += found
        return bodies

    def known_robot(self, name: str, entry: Table) -> robots.Robot:
        file = self.folder / name
        if self.is_file(file):
            return robots.load(file)
        try:
            return robots.get(name)
        except KeyError:
            near = near_names(name, robots.names())
            names = ", ".join(near or robots.names())
            entry.say(NO_ROBOT, "robot", name=settings_tables.shown(name), names=names)
            raise Refused from None

    def carried(
        self, bodies: tuple[Body, ...], tool: str, robot: str, entry: Table
    ) -> Iterator[Body]:
        if tool not in {body.name for body in bodies}:
            entry.say(LONELY_TOOL, "tool", name=settings_tables.shown(tool))
        for body in bodies:
            yield replace(body, parent=f"{robot}.flange") if body.name == tool else body

    def drawn(self, world: Mapping[str, Any]) -> Iterator[Body]:
        """Those of the drawing of the cell."""
        drawing = self.bodies.drawing(world)
        for body in drawing.bodies if drawing else ():
            yield replace(body, parent=world.get("frame", WORLD_FRAME))


def _in_itself(scene: Scene, body: Body) -> bool:
    """True if the chain of parents of the body leads back to the body."""
    seen, at = [body.name], scene.body(body.parent)
    while at is not None and at.name not in seen:
        seen.append(at.name)
        at = scene.body(at.parent)
    return at is not None and at.name == body.name
