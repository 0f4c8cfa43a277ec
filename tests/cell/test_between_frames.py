"""Contacts between frames: nothing thin is stepped over, and nothing that is clear is told of."""

from __future__ import annotations

import sys

import numpy as np
import pytest

from assistant.base import rotations
from assistant.base.arrays import Floats, Rows, Truths
from assistant.cell.collision.continuous import JointPath, clear, closest_approaches, hits
from assistant.cell.collision.model import Model
from assistant.cell.scene import Body, Box, Capsule, Part, PlacedRobot, Scene, Sphere
from assistant.program.geometry import Pose
from tests.cell.gantry import TURN, gantry, joints

every = pytest.mark.parametrize("cases", [30, pytest.param(1000, marks=pytest.mark.slow)])
SPEED = 2000.0
"""mm/s."""
RADIUS, LENGTH, THICK = 1.0, 60.0, 0.2
"""mm of the needle and of the plate."""


def thrust(draw: np.random.Generator) -> tuple[Scene, Floats, float]:
    """A needle that goes 2 m in 1 s through a plate: scene, places (2, 3), seconds to contact.

    It lies along the plate, so that it touches after the way along the normal, less half of the
    plate and the radius of the needle, by the speed along the normal.
    """
    normal = draw.normal(size=3)
    normal /= np.linalg.norm(normal)
    lean = draw.normal(size=3)
    lean -= (lean @ normal) * normal
    direction = normal + 0.8 * draw.uniform() * lean / np.linalg.norm(lean)
    direction /= np.linalg.norm(direction)
    middle, when = draw.uniform(-300, 300, 3), draw.uniform(0.2, 0.8)
    start = middle - direction * SPEED * when
    w, x, y, z = onto(normal)
    plate = Body(
        "plate", (Part(Box((900.0, 900.0, THICK))),), Pose.of(middle, np.array([w, x, y, z]))
    )
    across = np.cross(normal, draw.normal(size=3))
    turn = rotations.multiply(
        rotations.conjugate(TURN.quaternion), onto(across / np.linalg.norm(across))
    )
    needle = Body("needle", (Part(Capsule(RADIUS, LENGTH)),), Pose.of(np.zeros(3), turn), "flange")
    ahead = RADIUS + THICK / 2.0
    contact = float((middle - start) @ normal - ahead) / (SPEED * float(direction @ normal))
    return (
        Scene((plate, needle), (gantry(),)),
        np.stack([start, start + direction * SPEED]),
        contact,
    )


def onto(axis: Floats) -> Floats:
    """A rotation that takes z to an axis."""
    return rotations.canonical([1.0 + axis[2], -axis[1], axis[0], 0.0])


@every
def test_a_needle_through_a_thin_plate_is_found_in_time(
    cases: int, capsys: pytest.CaptureFixture[str]
) -> None:
    draw = np.random.default_rng(2)
    found = missed = 0
    for _ in range(cases):
        scene, places, contact = thrust(draw)
        model = Model(scene)
        hit = hits(model, JointPath(joints(places)))
        found += len(hit) == 1 and abs(hit[0].at - contact) < 1e-3
        every_10_ms = np.linspace(places[0], places[1], 101)
        each, pair = np.arange(101), np.zeros(101, dtype=np.intp)
        missed += bool((model.exact(joints(every_10_ms), each, pair) > 0.0).all())
    with capsys.disabled():
        sys.stdout.write(f" (a look each 10 ms misses {missed} of {cases}) ")
    assert found == cases
    assert missed > cases // 2


@every
def test_what_keeps_its_margin_is_never_told_of(cases: int) -> None:
    """A ball past a post, at a distance that a closed form gives."""
    draw = np.random.default_rng(3)
    margin = 5.0
    for _ in range(cases):
        aside = float(draw.uniform(margin + 0.11, margin + 20.0))
        radius, post = (float(r) for r in draw.uniform(1.0, 80.0, 2))
        level = float(draw.uniform(-300.0, 300.0))
        angle = float(draw.uniform(0.0, 2.0 * np.pi))
        along = np.array([np.cos(angle), np.sin(angle), 0.0])
        across = np.array([-along[1], along[0], 0.0]) * (aside + radius + post)
        places = np.stack([across - 1000.0 * along, across + 1000.0 * along])
        places[:, 2] = level
        bodies = (
            Body("post", (Part(Capsule(post, 2000.0)),)),
            Body("ball", (Part(Sphere(radius)),), parent="flange"),
        )
        model = Model(Scene(bodies, (gantry(),)))
        assert clear(model, JointPath(joints(places)), margin)
        assert not clear(model, JointPath(joints(places)), aside + 0.01)


def test_two_robots_meet() -> None:
    left = PlacedRobot("left", gantry().robot)
    right = PlacedRobot("right", gantry().robot, Pose((500.0, 0.0, 0.0)))
    bodies = (
        Body("hammer", (Part(Sphere(50.0)),), parent="left.flange"),
        Body("anvil", (Part(Sphere(50.0)),), parent="right.flange"),
    )
    model = Model(Scene(bodies, (left, right)))
    rows = np.array([[0, 0, 0, 0, 0, 0], [0, 0, 300, 0, 0, -300]], dtype=np.float64)
    (hit,) = hits(model, JointPath(rows))
    assert abs(hit.at - 400.0 / 600.0) < 1e-3
    contact = model.contact(hit.joints, hit.pair)
    assert {contact.one, contact.other} == {"hammer", "anvil"}
    assert abs(contact.points[0][0] - 250.0) < 1.0


def test_joints_that_jump_are_no_endless_search() -> None:
    """A body that lies in a jump may have been touched."""
    post, ball = Part(Capsule(10.0, 2000.0)), Part(Sphere(20.0))
    bodies = (Body("post", (post,)), Body("ball", (ball,), parent="flange"))
    model = Model(Scene(bodies, (gantry(),)))
    ends = joints(np.array([[-300.0, 0.0, 0.0], [300.0, 0.0, 0.0]]))

    def jumping(_: Rows, part: Floats) -> tuple[Floats, Truths]:
        return ends[(part > 0.3).astype(int)], np.ones(len(part), dtype=bool)

    way = JointPath(ends, np.zeros((1, ends.shape[1])), jumping)
    (hit,) = hits(model, way)
    assert abs(hit.at - 0.3) < 1e-6
    (least,) = closest_approaches(model, way, np.array([50.0]), np.array([0]))
    assert least.bound <= 0.0 < least.distance
