"""Arms whose J3 is counted from the floor, as a parallel rod makes it."""

from __future__ import annotations

from importlib.resources import files

import numpy as np
import pytest

from assistant import robots
from assistant.base.diagnostics import Refused
from assistant.program.motion import Path, Speed
from assistant.program.program import Procedure, Program
from assistant.program.statements import Follow
from assistant.robots import Robot, robot_file

PLAIN = robots.get("irb1600-10-1.45")
TEXT = files("assistant.robots").joinpath("catalogue", "irb1600-10-1.45.toml").read_text("utf-8")


def coupled(coupling: float) -> Robot:
    text = TEXT.replace("repeatability_mm", f"coupling = {coupling}\nrepeatability_mm")
    return robot_file.read(text.encode(), "rod.toml")


def random_joints(robot: Robot, count: int) -> np.ndarray:
    return np.random.default_rng(3).uniform(*robot.limits.T, (count, 6))


@pytest.mark.parametrize("coupling", [-1.0, 1.0, 0.25])
def test_j3_turns_with_j2(coupling: float) -> None:
    robot = coupled(coupling)
    joints = random_joints(robot, 200)
    apart = joints.copy()
    apart[:, 2] += coupling * joints[:, 1]
    for mine, plain in zip(robot.fk(joints), PLAIN.fk(apart), strict=True):
        assert mine == pytest.approx(plain, abs=1e-9)
    assert robot.chain(joints) == pytest.approx(PLAIN.chain(apart), abs=1e-9)


def test_where_a_parallel_rod_keeps_the_forearm_level() -> None:
    points = coupled(-1.0).chain([[0, j2, 0, 0, 0, 0] for j2 in (-40, 0, 60)])
    assert points[:, 4, 2] == pytest.approx(points[:, 2, 2])


@pytest.mark.parametrize("coupling", [-1.0, 1.0, 0.25])
def test_joints_come_back(coupling: float) -> None:
    robot = coupled(coupling)
    joints = random_joints(robot, 2000)
    pose = robot.fk(joints)
    back = robot.joints_of(*pose, robot.configuration(joints))
    # Where two turns of axis 3 are inside its limits, a pose does not tell which it was.
    turns = np.round((back - joints) / 360.0)
    assert not turns[:, [0, 1, 3, 4, 5]].any()
    assert np.abs(back - joints - 360.0 * turns).max() < 1e-6
    found, valid = robot.ik(*pose)
    assert robot.inside(found[valid]).all()
    near = np.abs(found - joints[:, None])
    near -= 360.0 * np.round(near / 360.0)
    assert np.where(valid, np.abs(near).max(axis=-1), np.inf).min(axis=1).max() < 1e-6


def test_limits_are_those_of_the_joint_that_the_maker_counts() -> None:
    robot = coupled(-1.0)
    joints = np.array([[0.0, 100.0, 60.0, 0.0, 30.0, 0.0], [0.0, 100.0, 70.0, 0.0, 30.0, 0.0]])
    positions, quaternions = robot.fk(joints)
    seam = Path.of("seam", positions, quaternions, speeds=[Speed(50.0)])
    program = Program("p", (Procedure("main", (Follow(seam),)),))
    (finding,) = (f for f in robot.check(program) if f.code == "RB103")
    assert "J3 would be at 70.00 degrees, its limit is 65" in finding.message


def test_roboticstoolbox_knows_no_coupling() -> None:
    with pytest.raises(Refused) as refused:
        coupled(-1.0).to_rtb()
    assert [f.code for f in refused.value.findings] == ["RB009"]


def test_a_scara_has_no_coupling() -> None:
    text = files("assistant.robots").joinpath("catalogue", "rh-6frh5520.toml").read_text("utf-8")
    with pytest.raises(Refused) as refused:
        robot_file.read(text.replace("reach_mm", "coupling = 1\nreach_mm").encode())
    assert [f.place for f in refused.value.findings] == ["coupling"]
