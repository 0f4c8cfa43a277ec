"""A cell: named bodies, robots among them, and which of them may touch."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Final

from assistant.cell.shapes import Shape
from assistant.program.geometry import IDENTITY, Pose
from assistant.robots.robot import Robot

WORLD: Final = "world"
"""The frame that everything stands in that names no other."""
FLANGE: Final = "flange"
"""What a body hangs on that a robot's flange carries: `ROBOT.flange`, of the only one `flange`."""
MARGIN: Final = 5.0
"""mm under which a distance is a warning, where neither body says another."""
UNKNOWN_SUFFIX: Final = ".unknown"
"""How the body of a robot is called that stands for space of which nothing is known."""
OCCUPIED_SUFFIX: Final = ".occupied"
"""How the body of a robot is called that stands for where contacts were."""
CORE_SUFFIX: Final = ".core"
"""How the thinner body of what moves is called that must keep out of such space."""

Colour = tuple[int, int, int]


@dataclass(frozen=True, slots=True)
class Part:
    """A shape of a body, at a pose in the body's frame."""

    shape: Shape
    pose: Pose = IDENTITY


@dataclass(frozen=True, slots=True)
class Body:
    """A rigid body.

    parent: the frame that its pose is in: `WORLD`, a named frame, another body, a link of a robot
    (`robot.J3`, `robot.flange`). margin: mm that others keep from it, None for the scene's.
    locations: named poses in its frame. source: where it was read, for messages. taken, released:
    the output that makes the tool take it or let it go, with its value; `hand 1` is a hand. shown:
    whether it is a thing, which pictures and files show; space that nobody knows is none.
    """

    name: str
    parts: tuple[Part, ...]
    pose: Pose = IDENTITY
    parent: str = WORLD
    colour: Colour | None = None
    margin: float | None = None
    locations: Mapping[str, Pose] = field(default_factory=dict)
    source: str = ""
    taken: tuple[str, float] | None = None
    released: tuple[str, float] | None = None
    shown: bool = True


@dataclass(frozen=True, slots=True)
class RobotReference:
    """How a cell file names a robot: of the catalogue, or the whole path of its file.

    packages: whole paths of folders by name; capsules: its links by its lengths, see `links`.
    explored: whole path of a chart of the space about it, "" for none; unknown: "free" where only
    what is occupied in it counts.
    """

    robot: str
    packages: Mapping[str, str] = field(default_factory=dict)
    capsules: bool = False
    explored: str = ""
    unknown: str = ""


@dataclass(frozen=True, slots=True)
class PlacedRobot:
    """A robot of the cell: base, its pose in the world; bodies: of links, by what carries them.

    links: bodies whose parent is `base`, `J1` …, `flange`, in the frames of the arm's links.
    named: what a file calls it, None for one of the catalogue.
    """

    name: str
    robot: Robot
    base: Pose = IDENTITY
    links: tuple[Body, ...] = ()
    named: RobotReference | None = None


@dataclass(frozen=True, slots=True)
class Scene:
    """Bodies and robots.

    allowed: pairs of names, in order, that may touch. margin: mm, see `MARGIN`. runs: the robot
    that runs the program, None where its model tells.
    """

    bodies: tuple[Body, ...] = ()
    robots: tuple[PlacedRobot, ...] = ()
    frames: Mapping[str, Pose] = field(default_factory=dict)
    allowed: frozenset[tuple[str, str]] = frozenset()
    margin: float = MARGIN
    runs: str | None = None

    def body(self, name: str) -> Body | None:
        return next((body for body in self.bodies if body.name == name), None)

    def all_bodies(self) -> Iterator[Body]:
        """Those of the cell, then those of its robots."""
        yield from self.bodies
        for placed in self.robots:
            yield from placed.links

    def may_touch(self, one: str, other: str) -> bool:
        return (min(one, other), max(one, other)) in self.allowed
