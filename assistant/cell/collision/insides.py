"""What lies wholly inside a closed mesh: its triangles alone report such a thing as clear of them.

A thing that does not touch the surface is inside if one point of it is: a ray from there passes the
surface an odd number of times. Three rays vote, as one may run along an edge.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import numpy as np

from assistant.base.arrays import Floats
from assistant.cell.shapes import Convex, Mesh, Shape, extent

RAYS: Final = (
    (0.5773502691896258, 0.5773502691896257, 0.5773502691896259),
    (-0.2672612419124244, 0.5345224838248488, 0.8017837257372732),
    (0.8728715609439694, -0.2182178902359924, 0.4364357804719847),
)
"""Unit vectors along no axis, which many edges and faces of drawings lie along."""


class InsideTest:
    """Of shapes by their numbers."""

    def __init__(self, shapes: Sequence[Shape]) -> None:
        self._shapes = shapes
        self._extents = [extent(shape) for shape in shapes]

    def signed(self, distance: float, one: int, other: int, at_one: Any, at_other: Any) -> float:
        """A distance above 0 of two shapes, made negative if one lies inside the other."""
        for outer, inner, frame, point in (
            (one, other, at_one, at_other),
            (other, one, at_other, at_one),
        ):
            shape = self._shapes[outer]
            if isinstance(shape, Mesh) and shape.solid:
                place = point.getRotation() @ self._some_point(inner) + point.getTranslation()
                local = frame.getRotation().T @ (place - frame.getTranslation())
                low, high = self._extents[outer]
                if ((local > low) & (local < high)).all() and points_inside(shape, local[None])[0]:
                    return -distance
        return distance

    def _some_point(self, number: int) -> Floats:
        """Of a shape, in its frame: a corner of what has some, else the middle."""
        shape = self._shapes[number]
        if isinstance(shape, Mesh):
            return np.asarray(shape.points[shape.triangles[0, 0]])
        if isinstance(shape, Convex):  # the middle of the box about it may be outside
            return np.asarray(shape.points[0])
        low, high = self._extents[number]
        return np.asarray((low + high) / 2.0)


def points_inside(mesh: Mesh, points: Floats) -> Any:
    """(n,) whether points (n, 3) lie inside a closed mesh, in its frame."""
    if mesh.within is not None:
        return mesh.within(points)
    votes = sum(
        (ray_crossings(mesh, points, np.array(ray)) % 2 for ray in RAYS), np.zeros(len(points))
    )
    return votes >= 2


def ray_crossings(mesh: Mesh, points: Floats, ray: Floats) -> Any:
    """(n,) how many triangles a ray (3,) from points (n, 3) passes (Möller and Trumbore, 1997)."""
    a, b, c = (mesh.points[mesh.triangles[:, i]] for i in range(3))
    e1, e2 = b - a, c - a
    p = np.cross(ray, e2)
    det = np.einsum("ij,ij->i", e1, p)
    flat = np.abs(det) < 1e-15
    inv = np.where(flat, 0.0, 1.0 / np.where(flat, 1.0, det))
    out = np.zeros(len(points), dtype=np.intp)
    for n, point in enumerate(points):
        s = point - a
        u = np.einsum("ij,ij->i", s, p) * inv
        q = np.cross(s, e1)
        v = q @ ray * inv
        t = np.einsum("ij,ij->i", e2, q) * inv
        out[n] = (~flat & (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0) & (t > 0.0)).sum()
    return out
