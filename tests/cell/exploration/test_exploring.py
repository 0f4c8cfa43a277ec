"""Exploring a scene that the robot does not know: what it calls free holds no body of that."""

from __future__ import annotations

import sys
from dataclasses import replace
from functools import cache
from itertools import combinations

import coal  # type: ignore[import-untyped]
import numpy as np
import pytest

from assistant import robots
from assistant.base import rotations
from assistant.base.arrays import Floats, Ints
from assistant.base.diagnostics import Refused
from assistant.cell import link_bodies
from assistant.cell.collision.continuous import JointPath, clear, hits
from assistant.cell.collision.distances import coal_geometry
from assistant.cell.collision.model import Carriers, Model, carrier_of
from assistant.cell.exploration.explorer import Explorer, Touch, asked, in_scene, ranges_of, wander
from assistant.cell.exploration.known_space import with_map
from assistant.cell.exploration.occupancy import CellState, Occupancy
from assistant.cell.scene import (
    Body,
    Box,
    Capsule,
    Cylinder,
    Part,
    PlacedRobot,
    Scene,
    Shape,
    Sphere,
)
from assistant.program.geometry import Pose
from assistant.program.pseudo import parse
from assistant.robots.timing import Simulation, simulate
from tests.cell.gantry import gantry

SIZE = 15.0
RUNS = 16
BASE = Pose((120.0, -40.0, 30.0), (np.cos(0.3), 0.0, 0.0, np.sin(0.3)))


@cache
def own(base: Pose = BASE) -> Scene:
    """An arm, alone."""
    placed = link_bodies.place_robot("arm", robots.get("rv-2aj"), base)
    return Scene((), (placed,), allowed=link_bodies.touching_links(placed))


def arm() -> PlacedRobot:
    return own().robots[0]


@cache
def hidden(seed: int = 0) -> Scene:
    """With bodies about it that are clear of the arm at home."""
    draw = np.random.default_rng(seed)
    shapes: tuple[Shape, ...] = (
        Sphere(60.0),
        Capsule(25.0, 300.0),
        Box((150.0, 90.0, 220.0)),
        Cylinder(40.0, 200.0),
        Box((600.0, 300.0, 4.0)),
    )
    bodies: tuple[Body, ...] = ()
    links = frozenset(combinations(sorted(link.name for link in arm().links), 2))
    while len(bodies) < len(shapes):
        place = draw.uniform([-450, -450, 50], [450, 450, 600])
        pose = BASE @ Pose.of(place, rotations.canonical(draw.normal(size=4)))
        body = Body(f"hidden {len(bodies)}", (Part(shapes[len(bodies)]),), pose)
        scene = replace(own(), bodies=(body,), allowed=links)
        if Model(scene).nearest(np.array([arm().robot.home]))[0][0] > 20.0:
            bodies = (*bodies, body)
    return replace(own(), bodies=bodies)


def apart(scene: Scene, cells: Ints, size: float) -> Floats:
    """(n,) mm that cells of the arm's base are apart from the bodies of a scene, by coal."""
    half, base = 1e-6, arm().base
    cube = coal.Box(size - half, size - half, size - half)
    out = np.full(len(cells), np.inf)
    for body in scene.bodies:
        _, pose = carrier_of(scene, body, Carriers(scene.robots))
        still = coal.Transform3s(
            rotations.to_matrix(np.array(pose.quaternion)), np.array(pose.position)
        )
        shape, request = coal_geometry(body.parts[0].shape), coal.DistanceRequest()
        turn = rotations.to_matrix(np.array(base.quaternion))
        for n, cell in enumerate(cells):
            middle = turn @ ((cell + 0.5) * size) + np.array(base.position)
            result = coal.DistanceResult()
            at = coal.Transform3s(turn, middle)
            out[n] = min(out[n], coal.distance(shape, still, cube, at, request, result))
    return out


@cache
def explored(seed: int = 0, runs: int = RUNS) -> tuple[Explorer, tuple[tuple[int, float], ...]]:
    """Who has wandered in a hidden scene, and the litres that he knew after so many runs."""
    explorer, joints = Explorer(own(), size=SIZE), None
    known, done = [], 0
    for wanted in (runs // 8, runs // 4, runs // 2, runs):
        wandered = wander(
            explorer, in_scene(hidden(seed), arm()), wanted - done, seed=wanted, start=joints
        )
        done, joints = wanted, wandered.joints
        known.append((wanted, explorer.occupancy.litres))
    return explorer, tuple(known)


def test_ranges_of_sliding_axes_are_in_mm() -> None:
    within = np.array([[500.0, 800.0], [-2000.0, -400.0], [0.0, 5000.0]])
    assert ranges_of(gantry().robot, within).tolist() == within.tolist()
    assert ranges_of(gantry().robot).tolist() == [[-5000.0, 5000.0]] * 3
    turning = ranges_of(robots.get("rv-2aj"), np.array([[-500.0, 500.0]] * 5))
    assert turning.tolist() == [[-360.0, 360.0]] * 5


def test_a_free_cell_holds_nothing_of_what_is_hidden(capsys: pytest.CaptureFixture[str]) -> None:
    explorer, known = explored()
    with capsys.disabled():
        told = ", ".join(f"{litres:.0f} l after {runs} runs" for runs, litres in known)
        sys.stdout.write(f" (free space known: {told}) ")
    litres = [one for _, one in known]
    assert litres == sorted(set(litres)) and litres[-1] > 40.0
    occupancy = explorer.occupancy
    assert occupancy.runs == RUNS
    free = occupancy.cells(CellState.FREE)
    draw = np.random.default_rng(0)
    assert apart(hidden(), draw.permutation(free)[:500], SIZE).min() > 0.0
    occupied = occupancy.cells(CellState.OCCUPIED)
    assert len(occupied) > 3
    assert apart(hidden(), occupied, SIZE).max() < 0.2


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(1, 9))
def test_free_cells_of_many_scenes(seed: int) -> None:
    explorer, _ = explored(seed, 80)
    free = explorer.occupancy.cells(CellState.FREE)
    assert apart(hidden(seed), free, SIZE).min() > 0.0


def test_where_a_robot_has_been_it_may_go_again_by_its_map() -> None:
    """By the map alone: on the rows that it went, not in space that it has not been in."""
    explorer = Explorer(own(), size=SIZE)
    rows = np.linspace(
        explorer.home, explorer.home + np.array([50.0, 25.0, -20.0, 10.0, 90.0]), 200
    )
    explorer.gone(rows)
    model = Model(with_map(own(), explorer.occupancy))
    assert model.nearest(rows[::30])[0].min() > 0.0
    assert clear(model, JointPath(rows[[90, 60]]))
    aside = explorer.home - np.array([50.0, 0.0, 0.0, 0.0, 0.0])
    distance, pair = model.nearest(aside[None])
    touched = {model.items[int(i[pair[0]])].body.name for i in (model.one, model.other)}
    assert distance[0] <= 0.0 and "arm.unknown" in touched
    assert all(name.endswith(".core") for name in touched - {"arm.unknown"})


def test_a_contact_without_a_place_ends_a_run_and_marks_nothing() -> None:
    calls = []

    def key(row: Floats) -> Touch | None:
        calls.append(row)
        return Touch() if len(calls) > 30 else None

    explorer = Explorer(own(), size=30.0)
    wandered = wander(explorer, asked(key), 1, seed=2)
    assert (wandered.contacts, wandered.placeless) == (1, 1)
    assert explorer.occupancy.counts()[CellState.OCCUPIED] == 0
    assert explorer.occupancy.counts()[CellState.FREE] == wandered.new > 0
    again = Explorer(own(), size=30.0)
    again.gone(np.array(calls[1:-1]))  # the first was asked for the start, the last was the contact
    assert again.occupancy.keys.tolist() == explorer.occupancy.keys.tolist()


def test_who_starts_in_contact_explores_nothing() -> None:
    explorer = Explorer(own(), size=30.0)
    with pytest.raises(Refused) as refused:
        wander(explorer, asked(lambda row: Touch()), 1)
    assert refused.value.findings[0].code == "CK456"
    blocked = replace(own(), bodies=(Body("block", (Part(Sphere(3000.0)),)),))
    with pytest.raises(Refused):
        wander(explorer, in_scene(blocked, arm()), 1)


def test_a_map_is_gone_on_with_and_is_of_one_kind_of_robot() -> None:
    explorer, _ = explored()
    more = Explorer(own(), known=explorer.occupancy)
    more.gone(more.home[None])
    assert more.occupancy.runs == RUNS + 1
    other = Occupancy.unknown(SIZE, "other")
    for asked_ in (lambda: Explorer(own(), known=other), lambda: with_map(own(), other)):
        with pytest.raises(Refused) as refused:
            asked_()
        assert refused.value.findings[0].code == "CK452"


# ------------------------------------------------------------------------------- programs

PROGRAM = """
program demo
target a [250, -100, 300] [0, 0, 1, 0]
target b [250, 100, 300] [0, 0, 1, 0]
procedure main
move joint a speed 200 mm/s blend fine
move linear b speed 200 mm/s blend fine
end
"""


def program() -> Simulation:
    return simulate(robots.solve_program(parse(PROGRAM), arm().robot))


def test_a_program_explores_the_space_of_its_ways() -> None:
    scene = own(Pose())
    explorer = Explorer(scene, size=SIZE)
    new = explorer.ran(program())
    assert new == explorer.occupancy.counts()[CellState.FREE] > 500
    flange = np.linspace([250.0, -100.0, 340.0], [250.0, 100.0, 340.0], 50)
    assert (explorer.occupancy.at(flange) == CellState.FREE).mean() > 0.9
    assert explorer.ran(program()) == 0
    assert explorer.occupancy.filled.min() == 2


def test_a_program_that_is_stopped_explores_what_was_before() -> None:
    whole, half = (Explorer(own(Pose()), size=SIZE) for _ in range(2))
    done = program()
    whole.ran(done)
    half.ran(done, until=done.seconds / 2.0)
    change = half.occupancy.compared(whole.occupancy)
    assert change.gained > 100 and change.lost == change.blocked == 0
    none = Explorer(own(Pose()), size=SIZE)
    assert none.ran(done, until=0.0) == 0


def test_a_program_that_touches_something_marks_it() -> None:
    post = Body("post", (Part(Capsule(10.0, 900.0)),), Pose((250.0, 60.0, 300.0)))
    scene = replace(own(Pose()), bodies=(post,))
    explorer = Explorer(own(Pose()), size=SIZE)
    explorer.ran(program(), hidden=scene)
    (cell,) = explorer.occupancy.cells(CellState.OCCUPIED)
    middle = (cell + 0.5) * SIZE
    assert np.hypot(middle[0] - 250.0, middle[1] - 60.0) < 10.0 + SIZE
    assert (explorer.occupancy.cells(CellState.FREE)[:, 1] + 1).max() * SIZE < 60.0 + 60.0
    assert not len(hits(Model(scene), JointPath(np.array([explorer.home, explorer.home]))))
