"""A cell: bodies, robots, their shapes and surfaces, and the pairs that may touch.

Each shape is in its own frame, in mm. A cylinder and a capsule stand on the z axis of their frame;
all shapes but a mesh have their middle in its origin. Surfaces are triangles for display.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import field
from functools import cached_property
from typing import Final

import numpy as np

from assistant.base.arrays import Floats, Ints, Truths, norms
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Refused
from assistant.cell.findings import NO_SIZE
from assistant.program.geometry import IDENTITY, Pose, Vector
from assistant.robots.robot import Robot


@dataclass(frozen=True, slots=True)
class Box:
    """size: its three edges."""

    size: Vector

    def __post_init__(self) -> None:
        _check_sizes("box", self.size)


@dataclass(frozen=True, slots=True)
class Sphere:
    radius: float

    def __post_init__(self) -> None:
        _check_sizes("sphere", (self.radius,))


@dataclass(frozen=True, slots=True)
class Cylinder:
    radius: float
    length: float

    def __post_init__(self) -> None:
        _check_sizes("cylinder", (self.radius, self.length))


@dataclass(frozen=True, slots=True)
class Capsule:
    """length: between the middles of its two half spheres."""

    radius: float
    length: float

    def __post_init__(self) -> None:
        _check_sizes("capsule", (self.radius, self.length))


@dataclass(frozen=True, eq=False)
class Convex:
    """The convex hull of points (n, 3), at least four that lie in no plane."""

    points: Floats

    def __post_init__(self) -> None:
        _check_corners("hull", self.points)

    @cached_property
    def hull(self) -> Mesh:
        """Its surface, with the corners only; raises Refused for points in one plane."""
        from scipy.spatial import ConvexHull, QhullError  # type: ignore[import-untyped]

        try:
            found = ConvexHull(self.points)
        except QhullError:
            raise Refused(NO_SIZE(what="hull", reason="its points lie in one plane")) from None
        corners = np.unique(found.simplices)
        places = np.full(len(self.points), -1)
        places[corners] = np.arange(len(corners))
        triangles = places[found.simplices]
        points = self.points[corners]
        # Qhull leaves open which way around a triangle goes: outwards is by its plane.
        across = np.cross(
            points[triangles[:, 1]] - points[triangles[:, 0]],
            points[triangles[:, 2]] - points[triangles[:, 0]],
        )
        inward = np.einsum("ij,ij->i", across, found.equations[:, :3]) < 0.0
        triangles[inward] = triangles[inward][:, ::-1]
        return Mesh(points, triangles)


@dataclass(frozen=True, eq=False)
class Mesh:
    """Triangles (m, 3) of rows of points (n, 3), counter-clockwise as seen from outside.

    solid: whether it is closed, so that what is inside it is in contact. off: mm that it may be
    away from what it stands for, as it was simplified; it counts as thicker by that. within: which
    of points (k, 3) are inside, where something tells it faster than the triangles do.
    """

    points: Floats
    triangles: Ints
    solid: bool = True
    off: float = 0.0
    within: Callable[[Floats], Truths] | None = None

    def __post_init__(self) -> None:
        _check_corners("mesh", self.points)
        rows = self.triangles
        if rows.ndim != 2 or rows.shape[1] != 3 or not len(rows):
            raise Refused(NO_SIZE(what="mesh", reason="its triangles are no rows of three"))
        if rows.min() < 0 or rows.max() >= len(self.points):
            raise Refused(NO_SIZE(what="mesh", reason="a triangle has a corner that is not there"))
        if not 0.0 <= self.off < np.inf:
            raise Refused(NO_SIZE(what="mesh", reason=f"it is {self.off} mm off"))


def _check_sizes(what: str, sizes: tuple[float, ...]) -> None:
    """Raises Refused for sizes that are not finite and above 0."""
    if not all(0.0 < size < np.inf for size in sizes):
        said = ", ".join(f"{size:g}" for size in sizes)
        raise Refused(NO_SIZE(what=what, reason=f"it is {said} mm large"))


def _check_corners(what: str, points: Floats) -> None:
    """Raise Refused for invalid points."""
    if points.ndim != 2 or points.shape[1] != 3 or not len(points):
        raise Refused(NO_SIZE(what=what, reason="its points are no rows of three"))
    if not np.isfinite(points).all():
        raise Refused(NO_SIZE(what=what, reason="a point of it is no number"))


Shape = Box | Sphere | Cylinder | Capsule | Convex | Mesh


def extent(shape: Shape) -> tuple[Floats, Floats]:
    """The lowest and the highest coordinates (3,) of a shape in its frame."""
    match shape:
        case Box():
            half = np.array(shape.size) / 2.0
        case Sphere():
            half = np.full(3, shape.radius)
        case Cylinder():
            half = np.array([shape.radius, shape.radius, shape.length / 2.0])
        case Capsule():
            half = np.array([shape.radius, shape.radius, shape.length / 2.0 + shape.radius])
        case Convex() | Mesh():
            return shape.points.min(axis=0), shape.points.max(axis=0)
    return -half, half


def farthest(shape: Shape, points: Floats) -> Floats:
    """(n,) mm that no point of a shape is farther away than from points (n, 3) of its frame."""
    match shape:
        case Sphere():
            return norms(points) + shape.radius
        case Capsule():
            along = np.abs(points[:, 2]) + shape.length / 2.0
            return np.asarray(np.hypot(np.hypot(points[:, 0], points[:, 1]), along) + shape.radius)
        case Cylinder():
            along = np.abs(points[:, 2]) + shape.length / 2.0
            return np.asarray(np.hypot(np.hypot(points[:, 0], points[:, 1]) + shape.radius, along))
    low, high = extent(shape)
    return norms(np.maximum(np.abs(points - low), np.abs(points - high)))


WORLD: Final = "world"
"""Default parent frame of everything that names no other."""
FLANGE: Final = "flange"
"""Parent of a body that a robot's flange carries: `ROBOT.flange`, or `flange` if there is one
robot.
"""
MARGIN: Final = 5.0
"""mm under which a distance is a warning, where neither body says another."""
UNKNOWN_SUFFIX: Final = ".unknown"
"""Suffix of the name of a robot's body that represents unknown space."""
OCCUPIED_SUFFIX: Final = ".occupied"
"""Suffix of the name of a robot's body that represents the positions of contacts."""
CORE_SUFFIX: Final = ".core"
"""Suffix of the name of the thinner copy of a moving body that must keep out of such space."""

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
    locations: named poses in its frame. source: the file that it was read from, for messages.
    taken, released: the output that makes the tool take it or release it, with its value; `hand 1`
    is a hand. shown: True for an object, which pictures and files show; False for unknown space.
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
    """Reference of a cell file to a robot: a name of the catalogue, or the absolute path of its
    file.

    packages: absolute paths of folders by name; capsules: True for links from its lengths, see
    `link_bodies`. explored: absolute path of a chart of the space around it, "" if missing;
    unknown: "free" if only the occupied part of it counts.
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


ROUND_SIDES: Final = 32
"""Flat sides of what is round."""

_Profile = Sequence[tuple[float, float]]
"""Points (radius, z) from the lowest to the highest, to be turned about z."""


@dataclass(frozen=True, slots=True, eq=False)
class Surface:
    """Triangles (m, 3) of points (n, 3) mm, counter-clockwise as seen from outside.

    flat: its edges are sharp; else it is round between its points.
    """

    points: Floats
    triangles: Ints
    flat: bool

    def at(self, pose: Pose) -> Surface:
        """The surface of what has a pose, in the frame of that pose."""
        return Surface(pose.moved(self.points), self.triangles, self.flat)


def part_surface(part: Part) -> Surface:
    """The surface of a part of a body, in the body's frame; `ROUND_SIDES` sides if round."""
    return surface(part.shape).at(part.pose)


def surface(shape: Shape) -> Surface:
    """The surface of a shape in its own frame."""
    match shape:
        case Box():
            corners = (np.indices((2, 2, 2)).reshape(3, -1).T - 0.5) * np.array(shape.size)
            return Surface(corners, _BOX, flat=True)
        case Sphere():
            return _revolved([_half_circles(shape.radius, 0.0)])
        case Capsule():
            return _revolved([_half_circles(shape.radius, shape.length)])
        case Cylinder(radius=r, length=length):
            low, high = -length / 2.0, length / 2.0
            sides = [(0.0, low), (r, low)], [(r, low), (r, high)], [(r, high), (0.0, high)]
            return _revolved(sides)
        case Convex():
            return Surface(shape.hull.points, shape.hull.triangles, flat=True)
    return Surface(shape.points, shape.triangles, flat=True)


_BOX: Final[Ints] = np.array(
    [
        *([0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1]),
        *([2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]),
    ]
)


def _half_circles(radius: float, length: float) -> _Profile:
    """The profile of a sphere that is pulled to a length along z."""
    angles = np.linspace(-np.pi / 2.0, np.pi / 2.0, ROUND_SIDES // 2 + 1)
    half = len(angles) // 2
    lower = [(radius * np.cos(a), radius * np.sin(a) - length / 2.0) for a in angles[: half + 1]]
    upper = [(radius * np.cos(a), radius * np.sin(a) + length / 2.0) for a in angles[half:]]
    return [*lower, *(upper if length else upper[1:])]


def _revolved(profiles: Sequence[_Profile]) -> Surface:
    """Profiles turned about z, with a sharp edge from each to the next."""
    angles = np.linspace(0.0, 2.0 * np.pi, ROUND_SIDES, endpoint=False)
    ring = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    points, triangles, first = list[Floats](), list[Ints](), 0
    here = np.arange(ROUND_SIDES)
    there = (here + 1) % ROUND_SIDES
    for profile in profiles:
        for i, (radius, z) in enumerate(profile):
            points.append(np.column_stack([radius * ring, np.full(ROUND_SIDES, z)]))
            if i:
                low, high = first + (i - 1) * ROUND_SIDES, first + i * ROUND_SIDES
                below, above = (profile[j][0] > 1e-9 for j in (i - 1, i))
                if below:
                    triangles.append(np.stack([low + here, low + there, high + there], axis=1))
                if above:
                    triangles.append(np.stack([low + here, high + there, high + here], axis=1))
        first += len(profile) * ROUND_SIDES
    return Surface(np.concatenate(points), np.concatenate(triangles), flat=False)
