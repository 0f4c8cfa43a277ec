"""Cells that bodies fill, against points of the cells and closed forms of the shapes."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from assistant.base import rotations
from assistant.base.arrays import Floats
from assistant.base.diagnostics import Refused
from assistant.cell.exploration.filled_cells import Filler
from assistant.cell.exploration.occupancy import cells_of_keys
from assistant.cell.scene import (
    Body,
    Box,
    Capsule,
    Convex,
    Cylinder,
    Mesh,
    Part,
    Scene,
    Shape,
    Sphere,
)
from assistant.program.geometry import Pose
from tests.cell.exact import point_segment
from tests.cell.gantry import TURN, gantry, joints

SIZE = 10.0
LATTICE = np.stack(np.meshgrid(*[np.linspace(0.0, SIZE, 4)] * 3, indexing="ij"), -1).reshape(-1, 3)
"""Points of a cell, its corners among them."""
CORNERS = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
OCTAHEDRON = np.concatenate([np.eye(3), -np.eye(3)]) * 60.0

Within = Callable[[Floats], bool]
SHAPES: dict[str, tuple[Shape, Within]] = {
    "sphere": (Sphere(42.0), lambda p: bool(np.linalg.norm(p) <= 42.0)),
    "capsule": (
        Capsule(24.0, 80.0),
        lambda p: point_segment(p, np.array([0, 0, -40.0]), np.array([0, 0, 40.0])) <= 24.0,
    ),
    "cylinder": (
        Cylinder(33.0, 70.0),
        lambda p: bool(np.hypot(p[0], p[1]) <= 33.0 and abs(p[2]) <= 35.0),
    ),
    "box": (Box((40.0, 60.0, 90.0)), lambda p: bool((np.abs(p) <= [20.0, 30.0, 45.0]).all())),
    "hull": (Convex(OCTAHEDRON), lambda p: bool(np.abs(p).sum() <= 60.0)),
}


def carried(shape: Shape, pose: Pose) -> Scene:
    """A gantry that carries a body, whose pose is in the base while the axes are at 0."""
    return Scene((Body("part", (Part(shape),), TURN.inverse() @ pose, "flange"),), (gantry(),))


@pytest.mark.parametrize("name", SHAPES)
def test_a_cell_is_filled_if_and_only_if_its_corners_are_inside(name: str) -> None:
    shape, within = SHAPES[name]
    draw = np.random.default_rng(5)
    filled = 0
    for _ in range(2):
        pose = Pose.of(draw.uniform(-5, 5, 3), rotations.canonical(draw.normal(size=4)))
        cells = cells_of_keys(Filler(carried(shape, pose), None, SIZE).keys(np.zeros((1, 3))))
        found = {tuple(cell) for cell in cells.tolist()}
        back = pose.inverse()
        about = np.stack(np.meshgrid(*[np.arange(-8, 8)] * 3, indexing="ij"), -1).reshape(-1, 3)
        points = (about[:, None] + LATTICE / SIZE) * SIZE
        local = rotations.rotate(np.array(back.quaternion), points) + back.position
        for cell, own in zip(about.tolist(), local, strict=True):
            assert (tuple(cell) in found) == all(within(point) for point in own)
        filled += len(found)
    assert filled > 40


def test_a_body_that_is_moved_fills_what_it_goes_through() -> None:
    """A ball along a line: what it fills lies in a capsule, of which it leaves out little."""
    start, end = np.array([-120.0, 30.0, 11.0]), np.array([150.0, -40.0, 60.0])
    rows = joints(np.linspace(start, end, 400))
    filler = Filler(carried(Sphere(40.0), Pose()), None, SIZE)
    corners = cells_of_keys(filler.keys(rows))[:, None] + CORNERS
    far = max(point_segment(p, start, end) for p in (corners * SIZE).reshape(-1, 3))
    assert 38.0 < far <= 40.0
    whole = 0
    extent = (np.arange(-16, 19), np.arange(-8, 7), np.arange(-3, 10))  # of a radius of 32 mm
    for cell in np.stack(np.meshgrid(*extent, indexing="ij"), -1).reshape(-1, 3):
        points = (cell + CORNERS) * SIZE
        if point_segment(points.mean(axis=0), start, end) < 32.0:
            whole += all(point_segment(p, start, end) <= 40.0 for p in points)
    assert len(corners) > 0.9 * whole


def test_a_thinner_body_fills_what_a_smaller_one_does() -> None:
    rows = np.zeros((1, 3))
    whole = Filler(carried(Capsule(40.0, 100.0), Pose()), None, SIZE)
    small = Filler(carried(Capsule(28.0, 100.0), Pose()), None, SIZE)
    assert whole.keys(rows, np.full((1, 1), 12.0)).tolist() == small.keys(rows).tolist()


def test_a_closed_mesh_fills_what_it_surely_holds() -> None:
    hull = Convex(OCTAHEDRON).hull
    exact = set(Filler(carried(hull_shape(), Pose()), None, SIZE).keys(np.zeros((1, 3))).tolist())
    filler = Filler(carried(Mesh(hull.points, hull.triangles), Pose()), None, SIZE)
    assert filler.findings == []
    found = set(filler.keys(np.zeros((1, 3))).tolist())
    assert found <= exact
    assert len(found) > len(exact) / 3


def hull_shape() -> Convex:
    return Convex(OCTAHEDRON)


def test_an_open_mesh_and_a_thin_body_fill_nothing_and_that_is_said() -> None:
    hull = hull_shape().hull
    opened = Filler(carried(Mesh(hull.points, hull.triangles[1:], solid=False), Pose()), None, SIZE)
    thin = Filler(carried(Capsule(6.0, 100.0), Pose()), None, SIZE)
    assert [[f.code for f in one.findings] for one in (opened, thin)] == [["CK455"], ["CK454"]]
    assert not len(opened.keys(np.zeros((1, 3)))) and not len(thin.keys(np.zeros((1, 3))))


def test_cells_that_are_too_small_are_refused() -> None:
    rows = joints(np.array([[-4000.0, -4000.0, -4000.0], [4000.0, 4000.0, 4000.0]]))
    with pytest.raises(Refused) as refused:
        Filler(carried(Sphere(40.0), Pose()), None, 1.0).keys(rows)
    assert refused.value.findings[0].code == "CK453"
    with pytest.raises(Refused) as refused:
        Filler(carried(Sphere(40.0), Pose()), "other", SIZE)
    assert refused.value.findings[0].code == "CK457"
