"""Distances of shapes against closed forms, where an arm of six axes takes them."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from assistant import robots
from assistant.base import rotations
from assistant.base.arrays import Floats
from assistant.cell.collision.model import Model
from assistant.cell.scene import (
    Body,
    Box,
    Capsule,
    Convex,
    Mesh,
    Part,
    PlacedRobot,
    Scene,
    Shape,
    Sphere,
)
from assistant.program.geometry import Pose
from tests.cell.exact import point_box, point_segment, segment_box, segments

NEAR = 1e-6
"""mm."""
SCENES, ROWS = 8, 100
"""Of each of the five pairs of shapes: 10,000 poses in all."""
ARM = PlacedRobot("arm", robots.get("irb1200-7-0.7"))
Ends = tuple[Floats, Floats]


def random_pose(draw: np.random.Generator) -> Pose:
    return Pose.of(draw.uniform(-600, 600, 3), rotations.canonical(draw.normal(size=4)))


def ends(pose: Pose, length: float) -> Ends:
    """Of the middle line of a capsule."""
    half = np.array([0.0, 0.0, length / 2.0])
    turned = rotations.rotate(np.array(pose.quaternion), half)
    return np.array(pose.position) - turned, np.array(pose.position) + turned


def into(pose: Pose, points: Ends) -> Ends:
    """Points of the world in the frame of a pose."""
    back = pose.inverse()
    a, b = (rotations.rotate(np.array(back.quaternion), p) + back.position for p in points)
    return a, b


def capsules(fixed: Pose, moved: Pose, one: Capsule, other: Capsule) -> float:
    lines = (*ends(fixed, one.length), *ends(moved, other.length))
    return segments(*lines) - one.radius - other.radius


def capsule_box(fixed: Pose, moved: Pose, one: Box, other: Capsule) -> float:
    a, b = into(fixed, ends(moved, other.length))
    return segment_box(a, b, np.array(one.size) / 2.0) - other.radius


def sphere_box(fixed: Pose, moved: Pose, one: Box, other: Sphere) -> float:
    point, _ = into(fixed, ends(moved, 0.0))
    return point_box(point, np.array(one.size) / 2.0) - other.radius


def sphere_capsule(fixed: Pose, moved: Pose, one: Capsule, other: Sphere) -> float:
    return point_segment(np.array(moved.position), *ends(fixed, one.length)) - (
        one.radius + other.radius
    )


def spheres(fixed: Pose, moved: Pose, one: Sphere, other: Sphere) -> float:
    apart = np.subtract(fixed.position, moved.position)
    return float(np.linalg.norm(apart)) - one.radius - other.radius


def a_box(draw: np.random.Generator) -> Box:
    x, y, z = draw.uniform(2.0, 500.0, 3).tolist()
    return Box((x, y, z))


def a_capsule(draw: np.random.Generator) -> Capsule:
    return Capsule(float(draw.uniform(1, 80)), float(draw.uniform(10, 600)))


def a_sphere(draw: np.random.Generator) -> Sphere:
    return Sphere(float(draw.uniform(1, 150)))


CASES: list[tuple[Callable[..., Shape], Callable[..., Shape], Callable[..., float]]] = [
    (a_capsule, a_capsule, capsules),
    (a_box, a_capsule, capsule_box),
    (a_box, a_sphere, sphere_box),
    (a_capsule, a_sphere, sphere_capsule),
    (a_sphere, a_sphere, spheres),
]


@pytest.mark.parametrize("case", CASES, ids=[case[2].__name__ for case in CASES])
def test_distances_are_those_of_closed_forms(
    case: tuple[Callable[..., Shape], Callable[..., Shape], Callable[..., float]],
) -> None:
    make_one, make_other, exact = case
    draw = np.random.default_rng(19)
    worst, apart = 0.0, 0
    for _ in range(SCENES):
        one, other, at = make_one(draw), make_other(draw), random_pose(draw)
        model, rows = on_the_arm(one, other, at, draw)
        found, _ = model.nearest(rows)
        p, q = ARM.robot.fk(rows)
        for distance, position, turn in zip(found, p, q, strict=True):
            wanted = exact(at, Pose.of(position, turn), one, other)
            if wanted > 0.0:
                worst, apart = max(worst, abs(distance - wanted)), apart + 1
            else:
                assert distance <= NEAR
    assert worst < NEAR
    assert apart > SCENES * ROWS // 2


def on_the_arm(
    one: Shape, other: Shape, at: Pose, draw: np.random.Generator
) -> tuple[Model, Floats]:
    """A scene with a body that stands and one on a flange, and joints of the arm."""
    bodies = Body("one", (Part(one),), at), Body("other", (Part(other),), parent="flange")
    low, high = ARM.robot.limits.T
    return Model(Scene(bodies, (ARM,))), draw.uniform(low, high, (ROWS, 6))


def test_a_mesh_and_its_hull_are_as_far_away_as_the_box_that_they_are() -> None:
    box, at = Box((200.0, 120.0, 60.0)), Pose((300.0, 100.0, 400.0))
    corners = np.array([[x, y, z] for x in (-100, 100) for y in (-60, 60) for z in (-30, 30)])
    hull = Convex(corners.astype(np.float64))
    shapes: list[Shape] = [box, hull, hull.hull]
    found = []
    for shape in shapes:
        model, rows = on_the_arm(shape, Capsule(20.0, 100.0), at, np.random.default_rng(7))
        found.append(np.maximum(model.nearest(rows)[0], 0.0))
    assert np.abs(found[1] - found[0]).max() < NEAR
    assert np.abs(found[2] - found[0]).max() < NEAR
    assert (found[0] > 0.0).any()


def test_what_lies_wholly_inside_a_closed_mesh_touches_it() -> None:
    corners = np.array([[x, y, z] for x in (-900, 900) for y in (-900, 900) for z in (0, 1800)])
    room = Convex(corners.astype(np.float64)).hull
    open_ = Mesh(room.points, room.triangles[1:], solid=False)
    rows = ARM.robot.home[None]
    for shape, inside in ((room, True), (open_, False)):
        bodies = Body("room", (Part(shape),)), Body("tool", (Part(Sphere(5.0)),), parent="flange")
        distance, _ = Model(Scene(bodies, (ARM,))).nearest(rows)
        assert (distance[0] < 0.0) == inside
