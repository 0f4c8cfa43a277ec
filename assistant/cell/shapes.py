"""Shapes of bodies, each about its own frame, in mm.

A cylinder and a capsule stand on the z axis of their frame, all but a mesh with their middle in its
origin.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from assistant.base.arrays import Floats, Ints, Truths, norms
from assistant.base.diagnostics import Refused
from assistant.cell.rules import NO_SIZE
from assistant.program.geometry import Vector


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
    """Raises Refused for points that are none."""
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
