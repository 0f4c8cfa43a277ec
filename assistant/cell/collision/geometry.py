"""Shapes as coal has them, and the box that each lies in.

Lengths stay mm: coal's tolerances are absolute, and 1e-9 of them keeps distances of things of
metres right to 1e-7 mm (measured against closed forms in tests/cell/test_distances.py).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final
from weakref import WeakKeyDictionary

import numpy as np

from assistant.base.arrays import Floats
from assistant.base.diagnostics import Refused
from assistant.cell.rules import NO_LIBRARY
from assistant.cell.shapes import Box, Capsule, Convex, Cylinder, Mesh, Shape, Sphere, extent

if TYPE_CHECKING:
    from types import ModuleType

COAL_TOLERANCE: Final = 1e-9
"""mm, of the distances of convex shapes."""
COAL_ITERATIONS: Final = 1000


def coal_library() -> ModuleType:
    """coal; raises Refused, naming the extra, without it."""
    try:
        import coal  # type: ignore[import-untyped]
    except ImportError:
        raise Refused(NO_LIBRARY(what="collisions are", name="coal"), exit_status=2) from None
    return coal  # type: ignore[no-any-return]


def distance_request() -> Any:
    """What is asked of a distance."""
    wanted = coal_library().DistanceRequest()
    wanted.gjk_tolerance = COAL_TOLERANCE
    wanted.gjk_max_iterations = COAL_ITERATIONS
    return wanted


@dataclass(frozen=True, slots=True, eq=False)
class BoundingBox:
    """A box about a shape: middle (3,) and half edges (3,) in its frame, and the sphere of both."""

    middle: Floats
    half: Floats

    @property
    def radius(self) -> float:
        return float(np.linalg.norm(self.half))


def bounding_box(shape: Shape) -> BoundingBox:
    low, high = extent(shape)
    return BoundingBox((low + high) / 2.0, (high - low) / 2.0)


def coal_geometry(shape: Shape) -> Any:
    """A shape as a geometry of coal."""
    coal = coal_library()
    match shape:
        case Box(size=(x, y, z)):
            return coal.Box(float(x), float(y), float(z))
        case Sphere():
            return coal.Sphere(float(shape.radius))
        case Cylinder():
            return coal.Cylinder(float(shape.radius), float(shape.length))
        case Capsule():
            return coal.Capsule(float(shape.radius), float(shape.length))
        case Convex():
            return _convex(shape.hull)
    return _surface(shape)


def _convex(hull: Mesh) -> Any:
    coal = coal_library()
    return coal.Convex(_points(hull), _triangles(hull))


_BUILT: Final[WeakKeyDictionary[Mesh, Any]] = WeakKeyDictionary()
"""Surfaces of meshes, for as long as these are there: building one takes long."""


def _surface(mesh: Mesh) -> Any:
    if mesh not in _BUILT:
        _BUILT[mesh] = _built_surface(mesh)
    return _BUILT[mesh]


def _built_surface(mesh: Mesh) -> Any:
    coal = coal_library()
    model = coal.BVHModelOBBRSS()
    model.beginModel(len(mesh.triangles), len(mesh.points))
    model.addVertices(np.ascontiguousarray(mesh.points))
    model.addTriangles(np.ascontiguousarray(mesh.triangles.astype(np.int64)))
    model.endModel()
    return model


def _points(mesh: Mesh) -> Any:
    out = coal_library().StdVec_Vec3s()
    out.extend(list(mesh.points.astype(np.float64)))
    return out


def _triangles(mesh: Mesh) -> Any:
    coal = coal_library()
    out = coal.StdVec_Triangle()
    for a, b, c in mesh.triangles.tolist():
        out.append(coal.Triangle(a, b, c))
    return out
