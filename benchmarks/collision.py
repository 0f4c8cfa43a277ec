"""Cases: how near things are, ways looked at without gaps beside samples of equal safety, and a
whole program in a cell of a hundred bodies.

The program is the surface of `benchmarks.arms`: a tool that goes over a work piece 20 mm below it,
among 98 bodies of all shapes that it does not touch.
"""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from assistant import robots
from assistant.base import rotations
from assistant.cell import link_bodies
from assistant.cell.clearances import closeness, rows_of
from assistant.cell.collision.continuous import JointPath, hits
from assistant.cell.collision.model import Model
from assistant.cell.scene import Body, Box, Capsule, Convex, Cylinder, Part, Scene, Shape, Sphere
from assistant.program.geometry import Pose
from assistant.program.motion import Blend, Path, Speed
from assistant.program.program import Procedure, Program
from assistant.program.statements import Follow
from assistant.robots.timing import Simulation, simulate
from assistant.robots.timing.uninterrupted_moves import stretches_of
from benchmarks.arms import AREA, DOWN, START, surface
from benchmarks.reading import Reading

BODIES: Final = 100
SEED: Final = 19
KEPT: Final = 5.0
"""mm that ways keep from things."""
SAFETY: Final = 1.0
"""mm that anything moves between two samples at most, and in the shortest stretch."""
SAMPLED: Final = 3
"""Ways that are looked at by samples: it takes a hundred times as long."""


def cell() -> Scene:
    """An arm with a tool, a floor, a work piece, and bodies of all shapes beside its way."""
    robot, _ = surface(2)
    arm = link_bodies.place_robot("arm", robot)
    draw = np.random.default_rng(SEED)
    bodies = [
        Body("floor", (Part(Box((3000.0, 3000.0, 20.0))),), Pose((0.0, 0.0, -30.0))),
        Body("work piece", (Part(Box((240.0, 440.0, 60.0))),), Pose((450.0, 0.0, 115.0))),
        Body("tool", (Part(Capsule(10.0, 40.0), Pose((0.0, 0.0, 25.0))),), parent="flange"),
    ]
    while len(bodies) < BODIES:
        place = draw.uniform([-900.0, -900.0, 0.0], [900.0, 900.0, 1200.0])
        x, y, z = place.tolist()
        above = 150.0 < x < 750.0 and abs(y) < 420.0 and z < 900.0
        if np.hypot(x, y) > 400.0 and not above:
            turn = rotations.canonical(draw.normal(size=4))
            shape = a_shape(len(bodies), draw)
            bodies.append(Body(f"body {len(bodies)}", (Part(shape),), Pose.of(place, turn)))
    beside = {("arm.J5", "tool"), ("arm.J6", "tool"), ("arm.base", "floor")}
    return Scene(tuple(bodies), (arm,), allowed=link_bodies.touching_links(arm) | beside)


def a_shape(number: int, draw: np.random.Generator) -> Shape:
    x, y, z = draw.uniform(20.0, 120.0, 3).tolist()
    points = draw.uniform(-60.0, 60.0, (20, 3))
    kinds = (Box((x, y, z)), Cylinder(x, y), Capsule(x, y), Sphere(x), Convex(points))
    return kinds[number % len(kinds)]


def drawn(n: int) -> tuple[Model, np.ndarray]:
    """Joints (n, 6) anywhere inside the limits."""
    model = Model(cell())
    low, high = model.scene.robots[0].robot.limits.T
    return model, np.random.default_rng(SEED).uniform(low, high, (n, len(low)))


def each_pair(n: int) -> tuple[Model, np.ndarray, np.ndarray, np.ndarray]:
    """N pairs, each for a row of its own."""
    model, rows = drawn(n)
    return model, rows, np.arange(n), np.random.default_rng(SEED).integers(0, len(model), n)


def distances(given: tuple[Model, np.ndarray, np.ndarray, np.ndarray]) -> None:
    model, rows, row, pair = given
    model.exact(rows, row, pair)


def nearest(given: tuple[Model, np.ndarray]) -> None:
    model, rows = given
    model.nearest(rows)


def edges(n: int) -> tuple[Model, np.ndarray]:
    """Edges (n, 2, 6) as a planner asks for them: from anywhere, 10 degrees with each joint."""
    model, rows = drawn(n)
    by = np.random.default_rng(SEED + 1).choice([-10.0, 10.0], rows.shape)
    low, high = model.scene.robots[0].robot.limits.T
    return model, np.stack([rows, np.clip(rows + by, low, high)], axis=1)


def without_gaps(given: tuple[Model, np.ndarray]) -> None:
    model, ways = given
    for way in ways:
        hits(model, JointPath(way), KEPT, SAFETY)


def sampled(given: tuple[Model, np.ndarray]) -> float:
    """As safe by samples: how many ways were looked at."""
    model, ways = given
    for start, end in ways[:SAMPLED]:
        most = float((np.abs(end - start) @ model.leverage).max())
        part = np.linspace(0.0, 1.0, max(int(np.ceil(most / SAFETY)), 1) + 1)[:, None]
        model.nearest(start + part * (end - start))
    return float(len(ways[:SAMPLED]))


def simulated(n: int) -> tuple[Simulation, Scene]:
    robot, program = surface(n)
    return simulate(robots.solve_program(program, robot)), cell()


def jumping(n: int) -> tuple[Simulation, Scene]:
    """Targets anywhere over the work piece, some 160 mm from each other."""
    robot = surface(2)[0]
    draw = np.random.default_rng(SEED)
    positions = START + draw.random((n, 3)) * [*AREA, 40.0]
    path = Path.of(
        "jumps", positions, np.tile(DOWN, (n, 1)), speeds=[Speed(150.0)], blends=[Blend(5.0)]
    )
    program = Program("jumps", (Procedure("main", (Follow(path),)),))
    return simulate(robots.solve_program(program, robot)), cell()


def whole(given: tuple[Simulation, Scene]) -> None:
    """Every contact and every margin of a program, as `check --cell` looks for them."""
    simulation, scene = given
    for margin in (0.0, None):
        for found in closeness(simulation, scene, "arm", margin):
            raise SystemExit(f"nothing comes near, but {found.contact} is said")


def stretches(n: int) -> tuple[Model, JointPath]:
    simulation, scene = simulated(n)
    (passed,) = simulation.passed
    return Model(scene), JointPath(*rows_of(scene, scene.robots[0], stretches_of(passed.plan)))


def culled(given: tuple[Model, JointPath]) -> Any:
    """How many stretches there were, and that none comes near."""
    model, way = given
    if hits(model, way, model.margins):
        raise SystemExit("nothing comes near, but something is said to")
    return float(len(way.rows) - 1)


TITLE: Final = f"Collision: an arm with its tool in a cell of {BODIES} bodies"
COLLISION: Final[dict[str, Reading]] = {
    "distance of a pair, any shapes": Reading((each_pair, distances), (100_000,), "distances"),
    "nearest of all pairs": Reading((drawn, nearest), (5_000,), "poses"),
    f"ways of 10 degrees, {KEPT:g} mm kept, no gaps": Reading(
        (edges, without_gaps), (200,), "ways"
    ),
    "the same, samples as safe": Reading((edges, sampled), (SAMPLED,), "ways"),
    "stretches of a program, no gaps": Reading((stretches, culled), (10_000,), "stretches"),
    "whole check of a program": Reading((simulated, whole), (10_000,), "targets checked"),
    "the same, 160 mm a move": Reading((jumping, whole), (10_000,), "targets checked"),
}
