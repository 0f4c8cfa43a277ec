"""How deep places are inside shapes, and shapes that are thinner all round."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np

from assistant.base.arrays import Floats, Truths, norms
from assistant.cell.collision.geometry import coal_geometry, coal_library, distance_request
from assistant.cell.collision.insides import points_inside
from assistant.cell.shapes import Box, Capsule, Convex, Cylinder, Mesh, Shape, Sphere, extent

DepthFunction = Callable[[Floats, Floats, Floats], Floats]
"""Coordinates x, y, z of places in the frame of a shape → mm to its surface, below 0 outside."""

LEAST_LEFT: Final = 0.01
"""mm that a shape keeps of itself, however much thinner it is made."""
VOXELS: Final = 3000
"""Places in the box about a mesh that its depth is worked out at."""
POINT_RADIUS: Final = 1e-3
"""mm: the radius of a ball that stands for a point."""


@dataclass(frozen=True, slots=True)
class SolidDepth:
    """depth: of a convex shape exactly, else at least. convex: whether it is; deepest: its largest
    depth.
    """

    depth: DepthFunction
    convex: bool
    deepest: float


def solid_depth(shape: Shape) -> SolidDepth | None:
    """None for a mesh that is open."""
    match shape:
        case Sphere(radius=r):
            return SolidDepth(lambda x, y, z: r - np.sqrt(x * x + y * y + z * z), True, r)
        case Capsule(radius=r, length=length):
            return SolidDepth(lambda x, y, z: _capsule(r, length, x, y, z), True, r)
        case Cylinder(radius=r, length=length):
            deepest = min(r, length / 2.0)
            return SolidDepth(
                lambda x, y, z: np.minimum(r - np.hypot(x, y), length / 2.0 - np.abs(z)),
                True,
                deepest,
            )
        case Box(size=(a, b, c)):
            return SolidDepth(
                lambda x, y, z: np.minimum(
                    np.minimum(a / 2.0 - np.abs(x), b / 2.0 - np.abs(y)), c / 2.0 - np.abs(z)
                ),
                True,
                min(a, b, c) / 2.0,
            )
        case Convex():
            planes = _planes(shape)
            return SolidDepth(lambda x, y, z: _behind(planes, x, y, z), True, _middle(planes)[1])
    return _of_mesh(shape) if shape.solid else None


def _capsule(radius: float, length: float, x: Floats, y: Floats, z: Floats) -> Floats:
    beyond = np.maximum(np.abs(z) - length / 2.0, 0.0)
    return np.asarray(radius - np.sqrt(x * x + y * y + beyond * beyond))


def _planes(shape: Convex) -> Floats:
    """(k, 4) unit normals of the faces, outwards, and how far the origin is behind each."""
    from scipy.spatial import ConvexHull  # type: ignore[import-untyped]

    found = np.unique(np.round(ConvexHull(shape.points).equations, 12), axis=0)
    return np.column_stack([found[:, :3], -found[:, 3]])


def _behind(planes: Floats, x: Floats, y: Floats, z: Floats) -> Floats:
    out = np.full(np.broadcast_shapes(x.shape, y.shape, z.shape), np.inf)
    for a, b, c, far in planes.tolist():
        np.minimum(out, far - (a * x + b * y + c * z), out=out)
    return out


def _middle(planes: Floats) -> tuple[Floats, float]:
    """The middle and the radius of the largest ball behind all planes, a linear program."""
    from scipy.optimize import linprog  # type: ignore[import-untyped]

    sides = np.column_stack([planes[:, :3], np.ones(len(planes))])
    bounds = [(None, None)] * 3 + [(0.0, None)]
    found = linprog([0.0, 0.0, 0.0, -1.0], sides, planes[:, 3], bounds=bounds).x
    return found[:3], float(found[3])


def _of_mesh(mesh: Mesh) -> SolidDepth:
    """At least how deep, from places of a grid: a place is no less deep than another one less the
    way between them.
    """
    low, high = extent(mesh)
    edge = max(float((np.prod(high - low) / VOXELS) ** (1.0 / 3.0)), 1e-6)
    shape = np.maximum(np.ceil((high - low) / edge), 1).astype(np.intp)
    indices = np.stack(np.meshgrid(*map(np.arange, shape), indexing="ij"), axis=-1).reshape(-1, 3)
    places = low + (indices + 0.5) * edge
    known = (_from_surface(mesh, places) - mesh.off) * _inside(mesh, places)
    known = known.reshape(tuple(shape))

    def depth(x: Floats, y: Floats, z: Floats) -> Floats:
        points = np.stack(np.broadcast_arrays(x, y, z), axis=-1)
        cell = np.clip(((points - low) / edge).astype(np.intp), 0, shape - 1)
        away = norms(points - (low + (cell + 0.5) * edge))
        return np.asarray(known[cell[..., 0], cell[..., 1], cell[..., 2]] - away)

    return SolidDepth(depth, False, float(known.max()))


def _from_surface(mesh: Mesh, points: Floats) -> Floats:
    coal = coal_library()
    surface, ball, result, wanted = (
        coal_geometry(mesh),
        coal.Sphere(POINT_RADIUS),
        None,
        distance_request(),
    )
    still = coal.Transform3s()
    out = np.empty(len(points))
    for n, point in enumerate(points):
        result = coal.DistanceResult()
        at = coal.Transform3s(np.eye(3), point)
        out[n] = max(coal.distance(surface, still, ball, at, wanted, result), 0.0)
    return out


def _inside(mesh: Mesh, points: Floats) -> Truths:
    return np.asarray(points_inside(mesh, points), dtype=np.bool_)


def thinner_shape(shape: Shape, by: float) -> Shape:
    """A shape that lacks `by` mm all round, or as much as leaves `LEAST` of it.

    Of a mesh its convex hull is taken, which is more than the mesh.
    """
    match shape:
        case Sphere(radius=r):
            return Sphere(max(r - by, LEAST_LEFT))
        case Capsule(radius=r, length=length):
            return Capsule(max(r - by, LEAST_LEFT), length)
        case Cylinder(radius=r, length=length):
            return Cylinder(max(r - by, LEAST_LEFT), max(length - 2.0 * by, 2.0 * LEAST_LEFT))
        case Box(size=(a, b, c)):
            least = 2.0 * LEAST_LEFT
            return Box((max(a - 2 * by, least), max(b - 2 * by, least), max(c - 2 * by, least)))
        case Convex():
            return _thinner_hull(shape, by)
    return shape if by <= shape.off else _thinner_hull(Convex(shape.points), by - shape.off)


def _thinner_hull(shape: Convex, by: float) -> Convex:
    from scipy.spatial import HalfspaceIntersection

    planes = _planes(shape)
    middle, deepest = _middle(planes)
    by = min(by, deepest - LEAST_LEFT)
    if by <= 0.0:
        return shape
    sides = np.column_stack([planes[:, :3], by - planes[:, 3]])
    return Convex(HalfspaceIntersection(sides, middle).intersections)
