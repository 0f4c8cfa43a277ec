"""No joint moves two bodies nearer to each other than the model says that it can.

Bodies of every shape hang on every link of arms of every kind; points of them are followed by
forward kinematics alone.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from assistant import robots
from assistant.base import rotations
from assistant.base.arrays import Floats
from assistant.cell.collision.continuous import JointPath, hits
from assistant.cell.collision.model import Item, Model
from assistant.cell.scene import (
    Body,
    Box,
    Capsule,
    Convex,
    Cylinder,
    Part,
    PlacedRobot,
    Scene,
    Shape,
    Sphere,
)
from assistant.program.geometry import Pose
from assistant.robots import Robot

COUPLED = replace(robots.get("irb1200-7-0.7"), coupling=-1.0)
"""An arm with a parallel rod that keeps its forearm level as axis 2 turns."""
ARMS = {
    "six axes": robots.get("irb1200-7-0.7"),
    "five axes": robots.get("rv-2aj"),
    "scara": robots.get("rh-6frh5520"),
    "parallel rod": COUPLED,
}
ROWS, POINTS = 40, 12


def shapes(draw: np.random.Generator) -> list[Shape]:
    x, y, z, radius, length = draw.uniform(5.0, 150.0, 5).tolist()
    corners = draw.uniform(-80.0, 80.0, (10, 3))
    return [
        Box((x, y, z)),
        Sphere(radius),
        Cylinder(radius, length),
        Capsule(radius, length),
        Convex(corners),
        Convex(corners).hull,
    ]


def scene(robot: Robot, draw: np.random.Generator) -> Scene:
    """A body of a random shape on each link, and one that stands."""
    bodies = [Body("stands", (Part(Sphere(100.0)),), Pose((500.0, 0.0, 300.0)))]
    for name in ("base", *robot.axes, "flange"):
        some = shapes(draw)
        at = Pose.of(draw.uniform(-80, 80, 3), rotations.canonical(draw.normal(size=4)))
        shape = some[draw.integers(len(some))]
        bodies.append(Body(name, (Part(shape, at),), parent=f"arm.{name}"))
    return Scene(tuple(bodies), (PlacedRobot("arm", robot, Pose((0.0, 0.0, 50.0))),))


def points_of(item: Item, draw: np.random.Generator) -> Floats:
    """Points (k, 3) of the surface of a body, in the frame of what carries it."""
    match shape := item.part.shape:
        case Box():
            own = draw.choice([-0.5, 0.5], (POINTS, 3)) * shape.size
        case Sphere():
            own = unit(draw) * shape.radius
        case Cylinder():
            across = unit(draw) * [1.0, 1.0, 0.0]
            across *= shape.radius / np.linalg.norm(across, axis=1)[:, None]
            own = across + draw.choice([-0.5, 0.5], (POINTS, 1)) * [0.0, 0.0, shape.length]
        case Capsule():
            own = unit(draw) * shape.radius
            own[:, 2] += np.where(own[:, 2] < 0.0, -0.5, 0.5) * shape.length
        case _:
            own = shape.points
    turned = rotations.rotate(np.array(item.pose.quaternion), np.asarray(own, dtype=np.float64))
    return np.asarray(turned + np.array(item.pose.position))


def unit(draw: np.random.Generator) -> Floats:
    some = draw.normal(size=(POINTS, 3))
    return np.asarray(some / np.linalg.norm(some, axis=1)[:, None])


def apart(
    model: Model, rows: Floats, one: tuple[Item, Floats], other: tuple[Item, Floats]
) -> Floats:
    """(n, k, l) mm between points of two bodies."""
    origins, turns = model.carriers.at(rows)
    at = [
        origins[:, item.carrier, None] + points @ turns[:, item.carrier].transpose(0, 2, 1)
        for item, points in (one, other)
    ]
    return np.asarray(np.linalg.norm(at[0][:, :, None] - at[1][:, None], axis=3))


@pytest.mark.parametrize("robot", ARMS.values(), ids=ARMS)
def test_nothing_moves_farther_than_the_levers_say(robot: Robot) -> None:
    draw = np.random.default_rng(5)
    worst = 0.0
    for _ in range(3):
        model = Model(scene(robot, draw))
        low, high = robot.limits.T
        start = draw.uniform(low, high, (ROWS, len(low)))
        by = (high - low) * draw.normal(size=start.shape) * 10.0 ** draw.uniform(-4, 0, (ROWS, 1))
        only = np.arange(ROWS) % (len(low) + 1)  # one joint alone, in the last rows all
        by[(np.arange(len(low)) != only[:, None]) & (only[:, None] < len(low))] = 0.0
        end = np.clip(start + by, low, high)
        allowed = np.abs(end - start) @ model.leverage
        for pair in range(len(model)):
            items = [model.items[i] for i in (model.one[pair], model.other[pair])]
            one, other = ((item, points_of(item, draw)) for item in items)
            change = np.abs(apart(model, end, one, other) - apart(model, start, one, other))
            most = change.max(axis=(1, 2))
            assert (most <= allowed[:, pair] + 1e-6).all(), [item.body.name for item in items]
            moved = allowed[:, pair] > 1e-6
            if moved.any():
                worst = max(worst, float((most[moved] / allowed[moved, pair]).max()))
    assert worst > 0.5  # the bound is of use


def test_a_forearm_on_a_parallel_rod_is_followed_as_axis_2_turns() -> None:
    """What hangs on the upper arm comes to the hand, though both are moved by axis 2."""
    bodies = (
        Body("on the upper arm", (Part(Sphere(10.0), Pose((0.0, 0.0, 400.0))),), parent="J2"),
        Body("hand", (Part(Sphere(10.0)),), parent="flange"),
    )
    model = Model(Scene(bodies, (PlacedRobot("arm", COUPLED),)))
    turn = np.linspace(0.0, 1.0, 2001)[:, None]
    start, end = np.zeros(6), np.zeros(6)
    start[1], end[1] = COUPLED.limits[1]
    rows = start + turn * (end - start)
    sampled = model.exact(rows, np.arange(len(rows)), np.zeros(len(rows), dtype=np.intp))
    nearest = float(sampled.min())
    assert nearest + 1.0 < min(sampled[0], sampled[-1])
    (hit,) = hits(model, JointPath(np.stack([start, end])), nearest + 0.5)
    assert abs(hit.at - np.argmax(sampled <= nearest + 0.5) / 2000.0) < 1e-3
