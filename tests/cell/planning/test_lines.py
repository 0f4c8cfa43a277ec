"""Ways of straight lines: where the tip goes on them, and where joint moves stay."""

from __future__ import annotations

import numpy as np
import pytest

from assistant.cell.collision.model import Model
from assistant.cell.planning.planner import Planned, plan
from assistant.cell.planning.space import goal_joints
from assistant.cell.scene import Scene
from assistant.program import pseudo
from assistant.program.geometry import Pose
from assistant.program.statements import Move, MoveJoints
from benchmarks.cells import AHEAD, ARM, TIP, box, problems, scene_of, shelf
from tests.cell.planning.test_planner import ends_at, planned, proven

DOWN = (0.0, 0.0, 1.0, 0.0)


def straight(scene: Scene, way: Planned) -> None:
    """Each line by poses on it in closed form: in reach, joints without a leap, and apart."""
    model = Model(scene)
    tips = [Pose.of(p, q) @ TIP for p, q in zip(*ARM.fk(way.rows), strict=True)]
    for move in np.flatnonzero(way.linear):
        one, other = tips[move], tips[move + 1]
        rows = [way.rows[move]]
        for part in np.linspace(0.0, 1.0, 60)[1:]:
            position = (1.0 - part) * np.array(one.position) + part * np.array(other.position)
            pose = Pose.of(position, np.array(one.quaternion))
            rows.append(goal_joints(ARM, pose, rows[-1], TIP)[0])
        assert np.abs(np.diff(rows, axis=0)).max() < 20.0
        assert np.abs(rows[-1] - way.rows[move + 1]).max() < 1e-3
        assert model.nearest(np.array(rows))[0].min() > 4.9


def test_a_free_line_is_gone() -> None:
    scene = scene_of()
    begin = goal_joints(ARM, Pose((430.0, -200.0, 300.0), DOWN), ARM.home, TIP)[0]
    goal = Pose((430.0, 200.0, 300.0), DOWN)
    way = plan(scene, begin, goal, robot="arm", tool=TIP, linear=True)
    assert way.linear.tolist() == [True]
    assert isinstance(way.statements()[0], Move)
    straight(scene, way)
    proven(scene, way, {})
    ends_at(way, goal)


@pytest.mark.slow  # lines around a post in a narrow cone are in `test_cones.py`
def test_lines_around_a_post() -> None:
    scene = scene_of(box("post", (60, 60, 340), (430, 0, 170)))
    begin = goal_joints(ARM, Pose((430.0, -200.0, 300.0), DOWN), ARM.home, TIP)[0]
    goal = Pose((430.0, 200.0, 300.0), DOWN)
    way = plan(scene, begin, goal, robot="arm", tool=TIP, linear=True)
    assert len(way.rows) > 2
    assert way.linear.any()
    proven(scene, way, {})
    ends_at(way, goal)


@pytest.mark.slow
def test_out_of_a_shelf_on_lines() -> None:
    scene = shelf()
    *_, problem = problems("shelf", scene, 3, seed=1)
    way = planned(scene, problem, linear=True, seconds=60.0)
    assert way.linear.any()
    proven(scene, way, {})
    ends_at(way, problem.goal)


def test_another_branch_is_gone_to_by_the_joints() -> None:
    pose = Pose((430.0, 0.0, 500.0), AHEAD)
    ways = goal_joints(ARM, pose, ARM.home, TIP)
    other = ways[np.argmax(np.sign(ways[:, 4]) != np.sign(ways[0, 4]))]
    way = plan(scene_of(), ways[0], other, robot="arm", tool=TIP, linear=True)
    assert not way.linear.any()
    assert [one.code for one in way.findings] == ["CK485"]
    assert isinstance(way.statements()[0], MoveJoints)


def test_lines_are_said_and_read_back() -> None:
    begin = goal_joints(ARM, Pose((430.0, -200.0, 300.0), DOWN), ARM.home, TIP)[0]
    goal = Pose((430.0, 200.0, 300.0), DOWN)
    way = plan(scene_of(), begin, goal, robot="arm", tool=TIP, linear=True)
    text = pseudo.print_program(way.program("line")).text
    assert "move linear target [430" in text.replace("429.99999", "430")
