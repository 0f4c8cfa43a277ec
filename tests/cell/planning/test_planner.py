"""Ways through cells, proven by another check than the planner's, and what is said without one."""

from __future__ import annotations

import sys
import time
from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest

from assistant import robots
from assistant.base import rotations
from assistant.base.arrays import Floats
from assistant.base.diagnostics import Diagnostic, Refused
from assistant.cell import link_bodies
from assistant.cell.collision.continuous import hits
from assistant.cell.collision.model import Model
from assistant.cell.planning.planner import Planned, plan
from assistant.cell.planning.space import Cone, Space
from assistant.cell.scene import Scene
from assistant.program.geometry import Pose
from assistant.robots.timing import simulate
from assistant.robots.timing.uninterrupted_moves import stretches_of
from benchmarks.cells import (
    AHEAD,
    ARM,
    CELLS,
    TIP,
    Problem,
    box,
    problems,
    scene_of,
    shelf,
)
from benchmarks.planning import COUNTS


def proven(scene: Scene, way: Planned, others: Mapping[str, Floats]) -> None:
    """Clear as the controller goes it: what `timing` makes of the program, by `hits`."""
    model = Model(scene)
    arm = next(placed for placed in scene.robots if placed.name == "arm")
    space = Space(scene, arm, others=others)
    assert way.robot.inside(way.rows).all()
    simulation = simulate(robots.solve_program(way.program(), way.robot), start=way.rows[0])
    assert simulation.passed
    last = way.rows[0]
    for passed in simulation.passed:
        stretches = stretches_of(passed.plan)
        assert np.abs(stretches.joints[0] - last).max() < 1e-6
        last = stretches.joints[-1]
        found = space.way(stretches)
        assert not hits(model, found, model.margins)
    # Near a singularity joints come back from a stated pose to fewer digits than the pose has.
    assert np.abs(last - way.rows[-1]).max() < 1e-3
    places, _ = way.robot.fk(np.array([last, way.rows[-1]]))
    assert np.linalg.norm(places[0] - places[1]) < 1e-5


def ends_at(way: Planned, goal: Pose) -> None:
    p, q = way.robot.fk(way.rows[-1:])
    tip = Pose.of(p[0], q[0]) @ way.tool
    assert np.linalg.norm(np.array(tip.position) - goal.position) < 1e-3
    assert abs(np.array(tip.quaternion) @ goal.quaternion) > 1.0 - 1e-9


def planned(scene: Scene, problem: Problem, **more: Any) -> Planned:
    return plan(
        scene, problem.start, problem.goal, robot="arm", tool=TIP, others=problem.others, **more
    )


def finding(scene: Scene, start: Any, goal: Any, **more: Any) -> Diagnostic:
    with pytest.raises(Refused) as refused:
        plan(scene, start, goal, robot="arm", tool=TIP, **more)
    (one,) = refused.value.findings
    return one


@pytest.mark.one_in(3)
@pytest.mark.parametrize("cell", [*reversed(CELLS)])  # two robots first
def test_a_way_is_found_and_is_clear(cell: str) -> None:
    scene = CELLS[cell]()
    (problem,) = problems(cell, scene, 1, seed=5)
    way = planned(scene, problem, seconds=30.0)
    proven(scene, way, problem.others)
    ends_at(way, problem.goal)


@pytest.mark.slow
@pytest.mark.parametrize("linear", [False, True])
def test_at_least_90_of_100_are_found_in_30_seconds(
    linear: bool, capsys: pytest.CaptureFixture[str]
) -> None:
    found, lines = 0, []
    for cell, count in COUNTS.items():
        scene = CELLS[cell]()
        for problem in problems(cell, scene, count, seed=1):
            begun = time.monotonic()
            try:
                way = planned(scene, problem, seconds=25.0, linear=linear)
            except Refused:
                continue
            found += time.monotonic() - begun < 30.0
            lines.append(way.linear.mean())
            proven(scene, way, problem.others)
            ends_at(way, problem.goal)
    with capsys.disabled():
        sys.stdout.write(f" ({found} of 100 found, {np.mean(lines):.0%} of their moves lines) ")
    assert found >= 90


@pytest.mark.slow
def test_the_same_seed_gives_the_same_way() -> None:
    scene = shelf()
    *_, problem = problems("shelf", scene, 2, seed=1)
    one, other = (planned(scene, problem, seed=3, seconds=60.0) for _ in range(2))
    assert len(one.rows) > 2
    assert np.array_equal(one.rows, other.rows)
    assert np.array_equal(one.radii, other.radii)


def test_what_is_free_is_gone_straight() -> None:
    scene = scene_of()
    to = ARM.home + np.array([60.0, 10.0, -20.0, 0.0, 20.0, 90.0])
    way = plan(scene, ARM.home, to, robot="arm")
    assert np.array_equal(way.rows, np.stack([ARM.home, to]))
    (move,) = way.statements()
    assert move.motion.blend.fine  # type: ignore[union-attr]


def test_a_post_on_the_straight_way_is_gone_around() -> None:
    post = box("post", (60, 60, 1400), (420, 0, 700))
    scene = scene_of(post)
    start, goal = (ARM.home + np.array([turn, 20, 0, 0, 30, 0.0]) for turn in (-50, 50))
    way = plan(scene, start, goal, robot="arm", tool=TIP)
    assert len(way.rows) > 2
    proven(scene, way, {})


def test_a_start_in_contact() -> None:
    wall = box("wall", (20, 800, 1600), (450, 0, 800))
    one = finding(scene_of(wall), ARM.home, ARM.home + 10.0)
    assert one.code == "CK442"
    assert "`wall`" in one.message


def test_a_goal_in_a_body() -> None:
    block = box("block", (200, 200, 200), (500, 300, 300))
    one = finding(scene_of(block), ARM.home, Pose((500.0, 300.0, 300.0), AHEAD))
    assert one.code == "CK444"
    assert "`block`" in one.message


def test_a_start_out_of_limits() -> None:
    one = finding(scene_of(), [171.0, 0, 0, 0, 0, 0], ARM.home)
    assert (one.code, "J1" in one.message) == ("CK441", True)


@pytest.mark.parametrize("start", [[0.0] * 5, [0.0, 0, 0, 0, 0, np.nan]])
def test_joints_that_are_none(start: list[float]) -> None:
    assert finding(scene_of(), start, ARM.home).code == "CK449"


def test_a_goal_out_of_reach() -> None:
    assert finding(scene_of(), ARM.home, Pose((2000.0, 0.0, 0.0), AHEAD)).code == "CK443"


def test_a_robot_that_is_not_there() -> None:
    with pytest.raises(Refused) as refused:
        plan(scene_of(), ARM.home, ARM.home, robot="leg")
    assert refused.value.findings[0].code == "CK413"


@pytest.mark.parametrize(
    "more",
    [
        {"seconds": float("nan")},
        {"seconds": float("inf")},
        {"margin": -1.0},
        {"margin": float("nan")},
        {"cone": Cone((0.0, 0.0, 0.0), 10.0)},
        {"cone": Cone((0.0, 0.0, 1.0), 10.0, (0.0, float("nan"), 1.0))},
        {"cone": Cone((0.0, 0.0, 1.0), -1.0)},
        {"goal": Pose((float("nan"), 0.0, 0.0))},
    ],
)
def test_numbers_that_cannot_be_meant(more: dict[str, Any]) -> None:
    goal = more.pop("goal", ARM.home)
    assert finding(scene_of(), ARM.home, goal, **more).code == "CK486"


@pytest.mark.parametrize("name", ["leg", "arm"])
def test_joints_of_another_robot_that_is_not_there(name: str) -> None:
    one = finding(scene_of(), ARM.home, ARM.home, others={name: ARM.home})
    assert one.code == "CK413"


def test_a_goal_in_a_closed_box() -> None:
    x, y, z, edge = 480.0, 350.0, 450.0, 500.0
    far = edge / 2.0
    walls = [
        box("left", (10, edge, edge), (x - far, y, z)),
        box("right", (10, edge, edge), (x + far, y, z)),
        box("front", (edge, 10, edge), (x, y - far, z)),
        box("rear", (edge, 10, edge), (x, y + far, z)),
        box("floor", (edge, edge, 10), (x, y, z - far)),
        box("lid", (edge, edge, 10), (x, y, z + far)),
    ]
    one = finding(scene_of(*walls), ARM.home, Pose((x, y, z), AHEAD), seconds=0.5)
    assert one.code == "CK444"  # wherever the tip is inside, the arm goes through a wall


def test_no_way_in_time_tells_how_near_it_came() -> None:
    scene = CELLS["window"]()
    (problem,) = problems("window", scene, 1, seed=5)
    with pytest.raises(Refused) as refused:
        planned(scene, problem, seconds=0.0)
    (one,) = refused.value.findings
    assert one.code == "CK445"
    assert "nearest approach is" in one.message


def test_a_goal_within_a_margin_is_reached_and_told_of() -> None:
    board = box("board", (200, 200, 20), (560, 0, 300))
    goal = Pose((560.0, 0.0, 313.0), (0.0, 0.0, 1.0, 0.0))  # 3 mm above the board, tip down
    scene = scene_of(board)
    way = plan(scene, ARM.home, goal, robot="arm", tool=TIP)
    ends_at(way, goal)
    assert [one.code for one in way.findings if one.code == "CK446"]


def test_five_axes() -> None:
    robot = robots.get("rv-2aj")
    arm = link_bodies.place_robot("arm", robot)
    scene = Scene(
        (box("post", (40, 40, 900), (230, 0, 450)),),
        (arm,),
        allowed=link_bodies.touching_links(arm),
    )
    start, goal = (robot.home + np.array([turn, 30, 0, 0, 0.0]) for turn in (-60, 60))
    way = plan(scene, start, goal)
    proven(scene, way, {})
    assert way.rows.shape[1] == 5
    assert len(way.rows) > 2


@pytest.mark.slow  # narrower cones are in `test_cones.py`
def test_a_level_tool_stays_level() -> None:
    scene = scene_of(box("post", (40, 40, 500), (500, 0, 250)))
    down = (0.0, 0.0, 1.0, 0.0)
    start = Pose((430.0, -260.0, 300.0), down)
    joints, valid = ARM.ik(*(np.array([v]) for v in _flange(start)))
    begin = joints[0][np.flatnonzero(valid[0])[0]]
    cone = Cone((0.0, 0.0, -1.0), 25.0)
    way = plan(scene, begin, Pose((430.0, 260.0, 300.0), down), robot="arm", tool=TIP, cone=cone)
    parts = np.linspace(0.0, 1.0, 200)[:, None]
    for one, other in zip(way.rows[:-1], way.rows[1:], strict=True):
        _, q = ARM.fk(one + parts * (other - one))
        z = rotations.to_matrix(q)[:, :, 2]
        assert np.degrees(np.arccos(np.clip(-z[:, 2], -1.0, 1.0))).max() < 25.2
    tilted = finding(scene, ARM.home, ARM.home + 5.0, cone=cone)
    assert tilted.code == "CK447"


def _flange(tip: Pose) -> tuple[tuple[float, ...], tuple[float, ...]]:
    flange = tip @ TIP.inverse()
    return flange.position, flange.quaternion
