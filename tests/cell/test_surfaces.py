"""Surfaces to be looked at: closed, outside out, and of the shape that they stand for."""

from __future__ import annotations

import math
from collections import Counter

import numpy as np
import pytest

from assistant.cell.scene import (
    ROUND_SIDES,
    Box,
    Capsule,
    Convex,
    Cylinder,
    Part,
    Shape,
    Sphere,
    Surface,
    extent,
    part_surface,
    surface,
)
from assistant.program.geometry import Pose

CUBE = np.indices((2, 2, 2)).reshape(3, -1).T * 10.0
SHAPES: dict[str, tuple[Shape, float]] = {
    "box": (Box((10.0, 20.0, 30.0)), 6000.0),
    "sphere": (Sphere(10.0), 4.0 / 3.0 * math.pi * 1000.0),
    "cylinder": (Cylinder(10.0, 30.0), math.pi * 3000.0),
    "capsule": (Capsule(10.0, 30.0), math.pi * 3000.0 + 4.0 / 3.0 * math.pi * 1000.0),
    "convex": (Convex(np.concatenate([CUBE, [[5.0, 5.0, 5.0]]])), 1000.0),
}


def volume(seen: Surface) -> float:
    """By the divergence theorem: below 0 if the triangles face inwards."""
    a, b, c = (seen.points[seen.triangles[:, i]] for i in range(3))
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6.0)


@pytest.mark.parametrize("name", SHAPES)
def test_a_surface_holds_what_its_shape_holds(name: str) -> None:
    shape, exact = SHAPES[name]
    round_ones = name in ("sphere", "cylinder", "capsule")
    least = 1.0 - 2.0 * (math.pi / ROUND_SIDES) ** 2 if round_ones else 1.0 - 1e-9
    seen = surface(shape)
    assert least * exact <= volume(seen) <= exact * (1.0 + 1e-9)
    low, high = extent(shape)
    assert np.allclose(seen.points.min(axis=0), low)
    assert np.allclose(seen.points.max(axis=0), high)


@pytest.mark.parametrize("name", SHAPES)
def test_a_surface_is_closed(name: str) -> None:
    seen = surface(SHAPES[name][0])
    corners = [tuple(np.round(p, 6) + 0.0) for p in seen.points]
    edges: Counter[tuple[tuple[float, ...], tuple[float, ...]]] = Counter()
    for triangle in seen.triangles.tolist():
        for i in range(3):
            edges[corners[triangle[i]], corners[triangle[(i + 1) % 3]]] += 1
    assert all(edges[b, a] == count for (a, b), count in edges.items())


def test_a_part_stands_at_its_pose() -> None:
    pose = Pose((1.0, 2.0, 3.0), (math.sqrt(0.5), math.sqrt(0.5), 0.0, 0.0))  # z to -y
    seen = part_surface(Part(Box((2.0, 4.0, 6.0)), pose))
    assert np.allclose(seen.points.min(axis=0), [0.0, -1.0, 1.0])
    assert np.allclose(seen.points.max(axis=0), [2.0, 5.0, 5.0])
