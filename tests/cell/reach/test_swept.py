"""Swept space against a capsule in closed form, and against places between the samples."""

from __future__ import annotations

import io

import numpy as np
import pytest

from assistant import robots
from assistant.base import rotations
from assistant.base.arrays import Floats
from assistant.base.diagnostics import Refused
from assistant.cell import link_bodies
from assistant.cell.clearances import CarriedBodies
from assistant.cell.scene import Body, Box, Capsule, Mesh, Part, PlacedRobot, Scene, Sphere
from assistant.cell.swept_space import BEYOND, MOST_CELLS, SweptSpace, swept_space
from assistant.program import pseudo
from assistant.program.expressions import JointValue
from assistant.program.geometry import JointTarget, Pose
from assistant.program.motion import FINE, MAXIMUM_SPEED
from assistant.program.program import Procedure, Program
from assistant.program.statements import Motion, MoveJoints
from assistant.report.workspace import swept_glb, swept_surface
from assistant.robots.robot import Robot
from assistant.robots.timing import Simulation, simulate
from tests.cell.gantry import gantry, joints

IRB = robots.get("irb1200-7-0.7")
PROGRAM = """program cell for irb1200-7-0.7

target a [400, -150, 350] [0, 0, 1, 0]
target b [450, 150, 300] [0, 0, 1, 0]
target c [300, 0, 500] [0, 0, 1, 0]

procedure main
  move joint a speed 500 mm/s blend fine
  move linear b speed 200 mm/s blend 20 mm
  move joint c speed 500 mm/s blend fine
  wait 0.5 s
  move linear a speed 200 mm/s blend fine
end
"""


def through(robot: Robot, rows: Floats) -> Simulation:
    """A program of straight moves of the axes."""
    motion = Motion(MAXIMUM_SPEED, FINE)
    body = tuple(MoveJoints(JointValue(JointTarget(tuple(row))), motion) for row in rows.tolist())
    program = Program(name="way", robot=robot.name, procedures=(Procedure("main", body),))
    return simulate(robots.solve_program(program, robot), start=rows[0])


def apart(points: Floats, start: Floats, end: Floats) -> Floats:
    """(n,) mm of points from the line between two others."""
    way = end - start
    part = np.clip((points - start) @ way / max(float(way @ way), 1e-12), 0.0, 1.0)
    return np.asarray(np.linalg.norm(points - start - part[:, None] * way, axis=1))


@pytest.mark.parametrize("size", [7.0, 20.0])
def test_a_ball_that_goes_straight_sweeps_a_capsule(size):
    radius, base = 30.0, Pose((11.0, 23.0, -5.0))
    placed = gantry(base=base)
    ball = Body("ball", (Part(Sphere(radius)),), parent="gantry.flange")
    ends = np.array([[0.0, 0.0, 0.0], [200.0, -90.0, 60.0]])
    found = swept_space(
        through(placed.robot, joints(ends)), Scene((ball,), (placed,)), placed, size
    )
    start, end = ends + np.array(base.position)
    assert apart(found.middles, start, end).max() <= radius + BEYOND * size
    keys = set(map(tuple, found.cells.tolist()))
    random = np.random.default_rng(0)
    inside = random.normal(size=(20000, 3))
    inside *= (
        radius
        * (random.uniform(size=(20000, 1)) ** (1 / 3))
        / np.linalg.norm(inside, axis=1, keepdims=True)
    )
    points = start + random.uniform(size=(20000, 1)) * (end - start) + inside
    assert set(map(tuple, np.floor(points / size).astype(int).tolist())) <= keys
    length = float(np.linalg.norm(end - start))
    volumes = [
        (np.pi * r**2 * length + 4 / 3 * np.pi * r**3) / 1e6 for r in (radius, radius + 2 * size)
    ]
    assert volumes[0] < found.litres() < volumes[1]
    assert found.litres("ball") == found.litres()


def test_every_place_of_the_arm_at_every_time_is_in_it_and_little_else():
    """The surface of each capsule, at times of which the sweep knows nothing."""
    placed = link_bodies.place_robot("arm", IRB, Pose((100.0, 50.0, 0.0), (0.8, 0.0, 0.0, 0.6)))
    tool = Body("tool", (Part(Box((20.0, 60.0, 90.0)), Pose((0, 0, 45.0))),), parent="arm.flange")
    scene = Scene((tool,), (placed,))
    done = simulate(robots.solve_program(pseudo.parse(PROGRAM), IRB), period=0.0331)
    size = 25.0
    found = swept_space(done, scene, placed, size)
    assert list(found.bodies) == ["tool", *(body.name for body in placed.links[1:])]
    rows = done.samples.joints
    origins, turns = IRB.link_frames(rows)
    base = rotations.to_matrix(np.array(placed.base.quaternion))
    near = np.full(len(found.cells), np.inf)
    random = np.random.default_rng(1)
    numbers = {f"arm.J{i + 1}": i for i in range(6)}
    for body in (*placed.links[1:], tool):
        which = found.bodies[body.name]
        keys = set(map(tuple, found.cells[which].tolist()))
        link = numbers.get(body.name, 6)
        for part in body.parts:
            shape = part.shape
            if isinstance(shape, Capsule):
                around = random.normal(size=(150, 3))
                local = shape.radius * around / np.linalg.norm(around, axis=1, keepdims=True)
                local[:, 2] += random.uniform(-0.5, 0.5, 150) * shape.length
            else:
                local = random.uniform(-0.5, 0.5, (150, 3)) * np.array([20.0, 60.0, 90.0])
            there = rotations.rotate(np.array(part.pose.quaternion), local) + part.pose.position
            points = origins[:, None, link] + np.einsum("npq,kq->nkp", turns[:, link], there)
            points = points @ base.T + np.array(placed.base.position)
            cells = np.unique(np.floor(points.reshape(-1, 3) / size).astype(int), axis=0)
            assert set(map(tuple, cells.tolist())) <= keys
            for k in range(0, len(rows), 4):
                away = np.linalg.norm(found.middles[which][:, None] - points[k, ::5], axis=2)
                near[which] = np.minimum(near[which], away.min(axis=1))
    outside = np.array([body.parts[0].shape.radius for body in placed.links[1:]]).max()
    assert near.max() < outside + BEYOND * size  # a middle inside a link is as far as its radius


def test_what_is_carried_sweeps_from_where_it_is_taken():
    plain = "\n".join(
        line for line in PROGRAM.splitlines() if not line.startswith("  wait")
    ).replace("target a", "signal grip digital output\n\ntarget a")
    text = plain.replace("  move linear b", "  set grip = 1\n  move linear b")
    placed = link_bodies.place_robot("arm", IRB)
    finger = Body("finger", (Part(Sphere(5.0)),), parent="arm.flange")
    part = Body("part", (Part(Sphere(20.0)),), Pose((400.0, -150.0, 330.0)), taken=("grip", 1.0))
    scene = Scene((part, finger), (placed,))
    solution = robots.solve_program(pseudo.parse(text), IRB)
    done = simulate(solution, carried=CarriedBodies.at_first(scene, placed))
    found = swept_space(done, scene, placed, 20.0)
    middles = found.middles[found.bodies["part"]]
    for place in ((400, -150, 330), (450, 150, 280), (300, 0, 480)):
        assert np.linalg.norm(middles - place, axis=1).min() < 20.0
    nothing = swept_space(simulate(solution), scene, placed, 20.0)
    assert "part" not in nothing.bodies


def test_meshes_count_as_their_hull_flat_ones_too():
    corners = np.array([[-50.0, -20.0, 10.0], [50.0, -20.0, 10.0], [0.0, 40.0, 10.0]])
    sheet = Mesh(corners, np.array([[0, 1, 2]]), solid=False)
    wedge = Mesh(np.vstack([corners, [0.0, 0.0, 60.0]]), np.array([[0, 1, 2], [0, 1, 3]]), False)
    placed = gantry()
    for shape in (sheet, wedge):
        body = Body("blade", (Part(shape),), parent="gantry.flange")
        ends = joints(np.array([[0.0, 0.0, 0.0], [100.0, 0.0, 0.0]]))
        found = swept_space(through(placed.robot, ends), Scene((body,), (placed,)), placed, 10.0)
        keys = set(map(tuple, found.cells.tolist()))
        _, turns = placed.robot.link_frames(ends[:1])
        for part in np.linspace(0.0, 1.0, 7):
            there = shape.points @ turns[0, -1].T + [100.0 * part, 0.0, 0.0]
            assert set(map(tuple, np.floor(there / 10.0).astype(int).tolist())) <= keys


def test_the_surface_is_closed_and_holds_what_is_swept():
    import trimesh

    cells = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [1, 1, 1], [-3, 2, 5]])
    found = SweptSpace(10.0, cells, {"tool": np.ones(5, dtype=bool)})
    mesh = swept_surface(found)
    shape = trimesh.Trimesh(mesh.points, mesh.triangles)
    assert shape.is_watertight
    assert np.isclose(shape.volume, 5000.0)
    assert np.isclose(shape.area, 2400.0)  # 5 cubes of 600, less 3 faces on both sides
    read = trimesh.load(io.BytesIO(swept_glb(found)), file_type="glb", force="mesh")
    assert np.isclose(read.volume, 5000.0e-9)  # metres


@pytest.mark.parametrize(
    ("size", "code"), [(0.0, "CK458"), (-1.0, "CK458"), (float("nan"), "CK458"), (0.5, "CK461")]
)
def test_sizes_that_are_none_or_too_small_are_refused(size, code):
    placed = PlacedRobot("arm", IRB)
    body = Body("ball", (Part(Sphere(100.0)),), parent="arm.flange")
    done = simulate(robots.solve_program(pseudo.parse(PROGRAM), IRB))
    with pytest.raises(Refused) as refused:
        swept_space(done, Scene((body,), (placed,)), placed, size)
    assert [f.code for f in refused.value.findings] == [code]
    assert MOST_CELLS < 1e8
