"""Tools that have to stay in a cone: however narrow it is, and all along the way."""

from __future__ import annotations

import numpy as np
import pytest

from assistant import robots
from assistant.base import rotations
from assistant.cell import link_bodies
from assistant.cell.planning.planner import Planned, plan
from assistant.cell.planning.space import Cone, goal_joints
from assistant.cell.scene import Body, Cylinder, Part, Scene
from assistant.program.geometry import Pose
from assistant.robots.timing import simulate
from benchmarks.cells import AHEAD, ARM, TIP, box, scene_of
from tests.cell.planning.test_planner import ends_at, finding, proven

DOWN = (0.0, 0.0, 1.0, 0.0)
DOWNWARDS = (0.0, 0.0, -1.0)


def most_tilted(way: Planned, axis: tuple[float, ...], to: tuple[float, ...]) -> float:
    """Degrees, at samples of the program as it is timed."""
    simulation = simulate(
        robots.solve_program(way.program(), way.robot), start=way.rows[0], period=0.002
    )
    samples = simulation.samples
    _, flange = way.robot.fk(samples.joints)
    turned = rotations.multiply(flange, np.array(way.tool.quaternion))
    there = rotations.rotate(turned, np.array(axis))
    assert len(there) > 50
    return float(np.degrees(np.arccos(np.clip(there @ np.array(to), -1.0, 1.0))).max())


@pytest.mark.parametrize(
    ("angle", "linear"),
    [
        (5.0, True),
        pytest.param(5.0, False, marks=pytest.mark.slow),
        *(pytest.param(a, b, marks=pytest.mark.slow) for a in (0.5, 25.0) for b in (False, True)),
    ],
)
def test_around_a_post_with_the_tool_upright(angle: float, linear: bool) -> None:
    scene = scene_of(box("post", (40, 40, 500), (500, 0, 250)))
    begin = goal_joints(ARM, Pose((430.0, -260.0, 300.0), DOWN), ARM.home, TIP)[0]
    goal, cone = Pose((430.0, 260.0, 300.0), DOWN), Cone(DOWNWARDS, angle)
    way = plan(scene, begin, goal, robot="arm", tool=TIP, cone=cone, seconds=60.0, linear=linear)
    assert len(way.rows) > 2
    assert way.linear.any() == linear
    assert most_tilted(way, (0.0, 0.0, 1.0), DOWNWARDS) < angle + 0.25
    proven(scene, way, {})
    ends_at(way, goal)


def test_a_tool_that_is_tilted_at_its_start_straightens() -> None:
    scene = scene_of(box("post", (40, 40, 500), (500, 0, 250)))
    leaning = Pose((430.0, -260.0, 300.0), DOWN) @ Pose.of(
        np.zeros(3), np.array([np.cos(np.radians(2.4)), np.sin(np.radians(2.4)), 0.0, 0.0])
    )
    begin = goal_joints(ARM, leaning, ARM.home, TIP)[0]
    goal = Pose((430.0, 260.0, 300.0), DOWN)
    cone = Cone(DOWNWARDS, 5.0)
    way = plan(scene, begin, goal, robot="arm", tool=TIP, cone=cone, seconds=60.0)
    assert len(way.rows) > 2
    assert most_tilted(way, (0.0, 0.0, 1.0), DOWNWARDS) < 5.25
    proven(scene, way, {})
    ends_at(way, goal)
    steep = Cone(DOWNWARDS, 4.0)
    assert finding(scene, begin, goal, cone=steep).code == "CK447"


def test_a_carried_glass_stays_level() -> None:
    """The gripper holds it from the side: the axis of the tool that points up is not its z."""
    glass = Body(
        "glass",
        (Part(Cylinder(30.0, 100.0)),),
        Pose.of(np.array([0.0, 0.0, 160.0]), np.array([0.5**0.5, 0.0, 0.5**0.5, 0.0])),
        "arm.flange",
    )
    whole = scene_of(box("post", (40, 40, 1400), (560, 0, 700)), glass)
    scene = Scene(whole.bodies, whole.robots, allowed=whole.allowed | {("glass", "tool")})
    begin = goal_joints(ARM, Pose((400.0, -250.0, 450.0), AHEAD), ARM.home, TIP)[0]
    goal = Pose((400.0, 250.0, 450.0), AHEAD)
    up = Cone((0.0, 0.0, 1.0), 5.0, (-1.0, 0.0, 0.0))
    way = plan(scene, begin, goal, robot="arm", tool=TIP, cone=up, seconds=60.0)
    assert len(way.rows) > 2
    assert most_tilted(way, (-1.0, 0.0, 0.0), (0.0, 0.0, 1.0)) < 5.25
    proven(scene, way, {})
    ends_at(way, goal)


def test_five_axes_keep_their_tool_upright() -> None:
    robot = robots.get("rv-2aj")
    arm = link_bodies.place_robot("arm", robot)
    post = box("post", (30, 30, 320), (250, 0, 160))
    scene = Scene((post,), (arm,), allowed=link_bodies.touching_links(arm))
    begin, goal = (
        goal_joints(robot, Pose((220.0, y, 220.0), DOWN), robot.home)[0] for y in (-120.0, 120.0)
    )
    way = plan(scene, begin, goal, cone=Cone(DOWNWARDS, 3.0), seconds=60.0)
    assert most_tilted(way, (0.0, 0.0, 1.0), DOWNWARDS) < 3.25
    proven(scene, way, {})
