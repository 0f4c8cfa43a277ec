"""Arms of every kind among bodies drawn at random, some with a body that they hold."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pytest

from assistant import robots
from assistant.base.arrays import Floats
from assistant.base.diagnostics import Refused
from assistant.cell import link_bodies
from assistant.cell.planning.planner import Planned, plan
from assistant.cell.planning.space import Space
from assistant.cell.scene import Body, Box, Capsule, Cylinder, Part, Scene, Shape, Sphere
from assistant.program.geometry import Pose
from tests.cell.gantry import gantry
from tests.cell.planning.test_planner import proven

ARMS = ["gantry", "rh-6frh5520", "rv-2aj", "irb1200-7-0.7", "irb4600-40-2.55"]
"""Three sliding axes, a SCARA, five axes, six, and six with a parallel rod."""


@dataclass(frozen=True, slots=True, eq=False)
class Drawn:
    """A scene with two places that are free, the second as a pose every other time."""

    scene: Scene
    tip: Pose
    start: Floats
    end: Floats
    goal: Pose | Floats


def drawn(name: str, count: int, seed: int) -> Iterator[Drawn]:
    arm = gantry("arm") if name == "gantry" else link_bodies.place_robot("arm", robots.get(name))
    touching = link_bodies.touching_links(arm)
    draw = np.random.default_rng(seed)
    low, high = np.clip(arm.robot.limits, -1000.0, 1000.0).T
    reach = 1.3 * float(np.abs(arm.robot.fk(arm.robot.home[None])[0]).max()) + 100.0
    if name == "gantry":
        reach = 1000.0
    while count:
        bodies = list(_bodies(draw, reach))
        allowed, tip = set(touching), Pose((0.0, 0.0, 0.0))
        if draw.random() < 0.5:
            long = float(draw.uniform(30.0, 150.0))
            shape = Box((30.0, 30.0, long))
            at = Pose((0.0, 0.0, long / 2.0 + 5.0))
            bodies.append(Body("held", (Part(shape),), at, "arm.flange"))
            allowed |= {(min(b.name, "held"), max(b.name, "held")) for b in arm.links[-3:]}
            tip = Pose((0.0, 0.0, long + 5.0))
        scene = Scene(tuple(bodies), (arm,), allowed=frozenset(allowed))
        space = Space(scene, arm, tool=tip)
        rows = draw.uniform(low, high, (200, len(low)))
        free = rows[space.free(rows)]
        if len(free) < 2:
            continue
        count -= 1
        p, q = space.tip(free[1:2])
        goal = Pose.of(p[0], q[0]) if count % 2 else free[1]
        yield Drawn(scene, tip, free[0], free[1], goal)


def _bodies(draw: np.random.Generator, reach: float) -> Iterator[Body]:
    for number in range(int(draw.integers(1, 7))):
        x, y, z = (reach * draw.uniform(0.03, 0.25, 3)).tolist()
        shapes: list[Shape] = [Box((x, y, z)), Sphere(x / 2), Cylinder(x / 2, y), Capsule(x / 3, y)]
        turn = draw.normal(size=4)
        at = Pose.of(draw.uniform(-reach, reach, 3), turn / np.linalg.norm(turn))
        yield Body(f"body{number}", (Part(shapes[int(draw.integers(4))]),), at)


def tried(one: Drawn, *, linear: bool, seconds: float) -> Planned | None:
    """The way, proven to be clear and to end where it should; None without one."""
    try:
        way = plan(one.scene, one.start, one.goal, tool=one.tip, linear=linear, seconds=seconds)
    except Refused as refused:
        assert [finding.code for finding in refused.findings] == ["CK445"]
        return None
    proven(one.scene, way, {})
    if isinstance(one.goal, Pose):
        p, q = way.robot.fk(way.rows[-1:])
        tip = Pose.of(p[0], q[0]) @ one.tip
        assert np.linalg.norm(np.array(tip.position) - one.goal.position) < 2e-3
    else:
        assert np.array_equal(way.rows[-1], one.goal)
    return way


@pytest.mark.parametrize("name", ARMS[:3])
def test_a_way_among_bodies(name: str) -> None:
    (one,) = drawn(name, 1, 7)
    assert tried(one, linear=True, seconds=20.0)


@pytest.mark.slow
@pytest.mark.parametrize("name", ARMS)
def test_many_ways_among_bodies(name: str) -> None:
    """Nobody knows whether there is a way to each, so some may have none."""
    found = Counter(
        tried(one, linear=bool(i % 2), seconds=15.0) is not None
        for i, one in enumerate(drawn(name, 20, 8))
    )
    assert found[True] >= 16, found
