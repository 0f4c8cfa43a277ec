"""A map as a scene: unknown space as one body, and ways that are found by the map alone."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import coal  # type: ignore[import-untyped]
import numpy as np
import pytest

from assistant.base.arrays import Floats, Truths
from assistant.base.diagnostics import Refused
from assistant.cell.collision.continuous import JointPath, clear
from assistant.cell.collision.model import Model
from assistant.cell.exploration.explorer import Explorer, in_scene, wander
from assistant.cell.exploration.known_space import boxes_of, surface_of, with_map
from assistant.cell.exploration.occupancy import Occupancy, keys_of
from assistant.cell.placement import best_base
from assistant.cell.planning.planner import plan
from assistant.cell.scene import Body, Box, Capsule, Part, PlacedRobot, Scene, Shape, Sphere
from assistant.program.geometry import Pose
from assistant.robots.robot_file import read
from tests.cell.exploration.test_exploring import arm, hidden, own
from tests.cell.gantry import GANTRY, TURN, gantry, joints

SIZE = 10.0


def some_cells(share: float, seed: int = 3) -> Truths:
    return np.random.default_rng(seed).uniform(size=(7, 8, 9)) < share


@pytest.mark.parametrize("share", [0.0, 0.1, 0.5, 0.9, 1.0])
def test_a_surface_is_that_of_its_cells(share: float) -> None:
    """Area of each face that has a free one beside it, volume by Gauss: both counted in cells."""
    cells = some_cells(share)
    corners, triangles = surface_of(cells)
    a, b, c = (corners[triangles[:, i]].astype(float) for i in range(3))
    across = np.cross(b - a, c - a) / 2.0
    padded = np.pad(cells, 1).astype(int)
    faces = [int(np.abs(np.diff(padded, axis=k)).sum()) for k in range(3)]
    assert np.abs(across).sum(axis=0) == pytest.approx(faces)
    assert (across * a).sum() / 3.0 == pytest.approx(float(cells.sum()))
    assert len(triangles) <= 2 * sum(faces)
    if share == 1.0:
        assert len(triangles) == 12


def known(free: Truths, shape: Shape, *bodies: Body) -> Scene:
    """A gantry that carries a body, and a map of which some cells are free from (-3, -3, -3) on."""
    part = Body("part", (Part(shape),), TURN.inverse(), "flange")
    keys = np.sort(keys_of(np.argwhere(free) - 3))
    none = np.zeros(0, dtype=np.int64)
    occupancy = Occupancy.unknown(SIZE, "gantry").with_run(keys, none)
    return with_map(Scene((part, *bodies), (gantry(),)), occupancy)


def by_boxes(free: Truths, core: Shape, place: Floats) -> float:
    """Mm from a shape to all that is not free, box by box, by coal."""
    wide = np.pad(~free, 12, constant_values=True)
    assert isinstance(core, Capsule)
    shape, at = coal.Capsule(core.radius, core.length), coal.Transform3s(np.eye(3), place)
    out = np.inf
    for low, high in boxes_of(wide):
        size, middle = (high - low) * SIZE, ((low + high) / 2.0 - 15.0) * SIZE
        still = coal.Transform3s(np.eye(3), middle)
        result, wanted = coal.DistanceResult(), coal.DistanceRequest()
        out = min(out, coal.distance(coal.Box(*size), still, shape, at, wanted, result))
    return float(out)


def test_unknown_space_is_as_far_away_as_each_of_its_cells() -> None:
    free = np.ones((14, 12, 10), dtype=bool)
    free[5:7, 3:5, 4:6] = free[2, 8:, :3] = False
    scene = known(free, Capsule(25.0, 30.0))
    core = next(body for body in scene.bodies if body.name == "part.core").parts[0].shape
    assert isinstance(core, Capsule) and core.radius < 5.0
    model = Model(scene)
    draw = np.random.default_rng(1)
    places = draw.uniform([-40, -40, -40], [120, 100, 80], (100, 3))
    found = model.nearest(joints(places))[0]
    truth = np.array([by_boxes(free, core, place) for place in places])
    apart = truth > 0.0
    assert 20 < apart.sum() < 90
    assert found[apart] == pytest.approx(truth[apart], abs=1e-6)
    assert (found[~apart] <= 0.0).all()  # wholly inside, too


def test_what_a_program_takes_keeps_out_of_unknown_space_as_well() -> None:
    """It stands in space that it fills itself, which is known then."""
    taken = Body("cup", (Part(Sphere(40.0)),), Pose((25.0, 15.0, 15.0)), taken=("grip", 1.0))
    scene = known(np.zeros((1, 1, 1), dtype=bool), Sphere(40.0), taken)
    carried = replace(taken, parent="flange", pose=TURN.inverse())
    now = replace(scene, bodies=tuple(carried if b.name == "cup" else b for b in scene.bodies))
    model = Model(now)
    names = [
        {model.items[int(i[pair])].body.name for i in (model.one, model.other)}
        for pair in range(len(model))
    ]
    (pair,) = (k for k, both in enumerate(names) if both == {"gantry.cup.core", "gantry.unknown"})
    rows = joints(np.array([[25.0, 15.0, 15.0], [65.0, 15.0, 15.0]]))
    apart = model.exact(rows, np.arange(2), np.full(2, pair))
    assert apart[0] > 0.0 >= apart[1]


def test_a_body_that_is_called_as_what_a_map_adds_is_refused() -> None:
    with pytest.raises(Refused) as refused:
        known(np.ones((3, 3, 3), dtype=bool), Sphere(40.0), Body("gantry.unknown", ()))
    assert refused.value.findings[0].code == "CK491"


def test_a_chart_tells_nothing_of_another_place_of_the_robot() -> None:
    scene = known(np.ones((3, 3, 3), dtype=bool), Sphere(40.0))
    with pytest.raises(Refused) as refused:
        best_base(scene, scene.robots[0], np.zeros((1, 4)), [])
    assert refused.value.findings[0].code == "CK493"


# ---------------------------------------------------------------------------------------- ways


@cache
def wandered(seed: int, runs: int) -> tuple[Explorer, Model]:
    """Who knows of a hidden scene what he has gone through, and what he would touch there."""
    explorer = Explorer(own(), size=15.0)
    wander(explorer, in_scene(hidden(seed), arm()), runs, seed=seed)
    return explorer, Model(hidden(seed))


def goals(seed: int, runs: int, count: int) -> Floats:
    """Places that are clear by the map, to which the straight move is not clear in truth."""
    explorer, truth = wandered(seed, runs)
    model = Model(with_map(own(), explorer.occupancy))
    low, high = arm().robot.limits.T
    rows = np.random.default_rng(seed).uniform(low, high, (400, len(low)))
    rows = rows[model.nearest(rows)[0] > 1.0]
    assert truth.nearest(rows)[0].min() > 0.0
    blocked = (row for row in rows if not clear(truth, JointPath(np.stack([explorer.home, row]))))
    return np.array([row for row, _ in zip(blocked, range(count), strict=False)])


@pytest.mark.slow
def test_a_way_around_a_hidden_wall_is_found_by_the_map_alone() -> None:
    """A ball on three straight axes, and a wall that leaves a gap at one side."""
    robot = read(GANTRY.replace(b"5000", b"400"))
    ball = Body("ball", (Part(Sphere(100.0)),), TURN.inverse(), "flange")
    alone = Scene((ball,), (PlacedRobot("gantry", robot),))
    wall = Body("wall", (Part(Box((20.0, 600.0, 2000.0))),), Pose((0.0, -200.0, 0.0)))
    truth = replace(alone, bodies=(ball, wall))
    start = joints(np.array([[-250.0, -200.0, 0.0]]))[0]
    explorer = Explorer(alone, size=30.0)
    wander(explorer, in_scene(truth, alone.robots[0]), 300, seed=2, start=start)
    scene = with_map(alone, explorer.occupancy)
    behind = joints(np.random.default_rng(0).uniform([150, -380, -300], [390, -50, 300], (200, 3)))
    goal = behind[Model(scene).nearest(behind)[0] > 1.0][0]
    assert not clear(Model(truth), JointPath(np.stack([start, goal])))
    way = plan(scene, start, goal, margin=0.0, seconds=60.0)
    assert clear(Model(scene), JointPath(way.rows))
    assert clear(Model(truth), JointPath(way.rows))
    assert way.rows[:, 1].max() > 200.0  # through the gap
    with pytest.raises(Refused) as refused:  # where nobody has been
        plan(scene, start, joints(np.array([[0.0, -200.0, 0.0]]))[0])
    assert refused.value.findings[0].code == "CK444"


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
def test_ways_of_an_arm_around_what_is_hidden(seed: int) -> None:
    explorer, truth = wandered(seed, 80)
    scene = with_map(own(), explorer.occupancy)
    found = 0
    for goal in goals(seed, 80, 4):
        try:
            way = plan(scene, explorer.home, goal, margin=0.0, seconds=60.0)
        except Refused as refused:
            assert refused.findings[0].code == "CK445"
            continue
        assert clear(truth, JointPath(way.rows))
        assert way.rows[-1] == pytest.approx(goal, abs=0.01)
        found += 1
    assert found > 0
