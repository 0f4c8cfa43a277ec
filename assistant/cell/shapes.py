"""Shapes of bodies, each about its own frame, in mm.

A cylinder and a capsule stand on the z axis of their frame, all but a mesh with their middle in its
origin.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from assistant.program.arrays import Floats, Ints, Truths, norms
from assistant.program.geometry import Vector


@dataclass(frozen=True, slots=True)
class Box:
    """size: its three edges."""

    size: Vector


@dataclass(frozen=True, slots=True)
class Sphere:
    radius: float


@dataclass(frozen=True, slots=True)
class Cylinder:
    radius: float
    length: float


@dataclass(frozen=True, slots=True)
class Capsule:
    """length: between the middles of its two half spheres."""

    radius: float
    length: float


@dataclass(frozen=True, eq=False)
class Convex:
    """The convex hull of points (n, 3), at least four that lie in no plane."""

    points: Floats

    @cached_property
    def hull(self) -> Mesh:
        """Its surface, with the corners only."""
        from scipy.spatial import ConvexHull  # type: ignore[import-untyped]

        found = ConvexHull(self.points)
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
