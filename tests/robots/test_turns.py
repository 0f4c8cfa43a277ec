"""Whole turns of axes 1, 4 and 6 along a path, and the wrist in line."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from assistant import robots
from assistant.base import rotations
from assistant.base.diagnostics import Severity
from assistant.program.geometry import Configuration, Pose, Tool
from assistant.program.motion import UNSTATED, Kind, Path, Speed
from assistant.program.statements import Follow, Move
from tests.robots.test_configure import (
    ABB,
    DOWN,
    MOTION,
    codes,
    down,
    followed,
    path_of,
    program,
    turning,
)  # fmt: skip


def test_axis_six_goes_over_180_without_a_break() -> None:
    path = path_of(np.tile([450, 0, 300.0], (300, 1)), turning(np.linspace(-170, 350, 300)))
    done, joints, findings = followed(path)
    assert not findings
    assert np.abs(np.diff(joints, axis=0)).max() < 2.0
    assert np.ptp(done.configurations[:, 5]) >= 5


def test_axis_one_goes_over_180_without_a_break() -> None:
    robot = robots.get("rv-4frl")
    t = np.radians(np.linspace(100, 230, 200))
    path = path_of(np.c_[400 * np.cos(t), 400 * np.sin(t), 400 + 0 * t])
    _, joints, findings = followed(path, robot)
    assert not findings
    assert np.abs(np.diff(joints, axis=0)).max() < 2.0
    assert joints[-1, 0] == pytest.approx(230.0)


def test_where_the_turns_end_a_linear_path_is_refused_and_a_joint_path_unwound() -> None:
    positions, turned = np.tile([450, 0, 300.0], (400, 1)), turning(np.linspace(0, 1000, 400))
    _, _, findings = followed(path_of(positions, turned))
    assert codes(findings) == ["RB106"]
    assert "J6" in findings[0].message
    # No turn of the tool helps: it turns farther than the axis can.
    assert "by 1000 degrees in all, and it has 720" in str(findings[0].cure)
    _, joints, findings = followed(path_of(positions, turned, kinds=Kind.JOINT))
    assert not findings
    assert ABB.inside(joints).all()


def _degrees(text: str) -> float:
    found = re.search(r"by (-?\d+) degrees", text)
    assert found is not None, text
    return float(found[1])


@pytest.mark.parametrize("name", ["irb1200-7-0.7", "rv-4frl", "irb6700-150-3.20"])
@pytest.mark.parametrize("way", [1, -1])
def test_mounting_the_tool_as_the_cure_says_keeps_axis_six_inside(name: str, way: int) -> None:
    robot = robots.get(name)
    low, high = robot.limits[5].tolist()
    sweep = way * np.linspace(0.0, 0.9 * (high - low), 400)
    at = np.tile([0.6 * robot.reach, 0.0, 300.0], (400, 1))
    tilted = Pose((10.0, 20.0, 80.0), rotations.from_euler(np.array([30.0, 20.0, 10.0]), "ZYX"))
    # Neither from here nor from half a turn further, which the wrist turned over has.
    start = rotations.multiply(DOWN, rotations.about((0.0, 0.0, 1.0), way * 120.0))
    flange = rotations.multiply(start, rotations.about(np.tile([0, 0, 1.0], (400, 1)), sweep))
    # Poses of a tilted tip, so that the flange only turns about its own axis.
    positions = at + rotations.rotate(flange, np.array(tilted.position))
    path = path_of(positions, rotations.multiply(flange, np.array(tilted.quaternion)), tools=["t"])
    _, _, findings = followed(path, robot, tools={"t": Tool(tilted)})
    assert codes(findings) == ["RB106"]
    assert "J6" in findings[0].message
    assert findings[0].cure is not None
    turn = rotations.about((0.0, 0.0, 1.0), _degrees(findings[0].cure))
    _, _, after = followed(path, robot, tools={"t": Tool(Pose.of(np.zeros(3), turn) @ tilted)})
    assert not after


@pytest.mark.parametrize("name", ["rv-4frl", "rv-7frl"])
def test_turning_the_work_as_the_cure_says_keeps_axis_one_inside(name: str) -> None:
    robot = robots.get(name)
    around = np.radians(np.linspace(90.0, 390.0, 400))
    circle = 0.75 * robot.reach * np.c_[np.cos(around), np.sin(around), 0.2 + 0.0 * around]
    _, _, findings = followed(path_of(circle), robot)
    assert codes(findings) == ["RB106"]
    assert "J1" in findings[0].message
    assert findings[0].cure is not None
    turn = rotations.about((0.0, 0.0, 1.0), _degrees(findings[0].cure))
    turned = path_of(rotations.rotate(turn, circle), rotations.multiply(turn, np.array(DOWN)))
    _, joints, after = followed(turned, robot)
    assert not after
    assert robot.inside(joints).all()


def test_a_wrist_in_line_leaves_axis_four_where_it_was() -> None:
    joints = np.zeros((50, 6))
    joints[:, 3] = 40.0
    joints[:, 4] = np.linspace(20, 0, 50)
    joints[:, 0] = np.linspace(0, 20, 50)
    path = path_of(*ABB.fk(joints))
    done, _, findings = followed(path)
    assert not findings
    assert (done.configurations[:, 3:] == 0).all()


def test_an_axis_that_turns_more_than_half_way_round_in_one_linear_move() -> None:
    ends = np.radians([-40.0, 40.0])
    positions = np.c_[450 * np.cos(ends), 450 * np.sin(ends), [300.0, 300.0]]
    _, joints, findings = followed(path_of(positions, turning(np.array([0.0, 170.0]))))
    assert not findings
    assert joints[1, 5] - joints[0, 5] == pytest.approx(250.0)
    many = np.linspace(0, 1, 200)[:, None]
    dense = path_of(positions[0] + many * (positions[1] - positions[0]), turning(170 * many[:, 0]))
    _, all_joints, _ = followed(dense)
    assert all_joints[-1, 5] - all_joints[0, 5] == pytest.approx(250.0)


def test_straight_through_the_wrist_axis_four_stays_and_axis_five_changes_sign() -> None:
    z = np.linspace(200, 150, 40)
    path = path_of(np.c_[240 + 0 * z, -50 + 0 * z, z], tools=("gripper",))
    tools = {"gripper": Tool(Pose((0, 0, 60)))}
    out, findings = robots.configure(program(Follow(path), tools=tools), ABB)
    assert codes(findings) == ["RB115"]
    assert findings[0].severity is Severity.WARNING
    done = out.procedures[0].body[0].path
    flange = done.positions + np.array([0, 0, 60])
    joints = ABB.joints_of(flange, done.quaternions, done.configurations)
    assert np.abs(np.diff(joints, axis=0)).max() < 3.0
    assert np.sign(joints[0, 4]) == -np.sign(joints[-1, 4])
    assert sorted(set(done.configurations[:, 2].tolist())) == [0, 1]


def test_beside_the_wrist_singularity_the_branch_stays_and_axis_four_turns() -> None:
    z = np.linspace(200, 150, 400)
    tilted = rotations.multiply(DOWN, rotations.about((1.0, 0.0, 0.0), 5.0))
    path = path_of(np.c_[240 + 0 * z, 0 * z, z], tilted)
    done, joints, findings = followed(path)
    assert not findings
    assert (done.configurations[:, 2] == done.configurations[0, 2]).all()
    assert np.abs(np.diff(joints, axis=0)).max() < 3.0


def test_a_stated_turn_beyond_the_limits_is_an_error() -> None:
    robot = robots.get("rv-4frl")
    stated = Configuration(quadrants=(4, 0, 0))
    _, findings = robots.configure(
        program(Move("joint", down(400, 10, 300, stated), MOTION)), robot
    )
    assert codes(findings) == ["RB108"]
    assert findings[0].severity is Severity.ERROR
    assert "turns 0 0 0, not 1 0 0" in findings[0].message


@pytest.mark.parametrize(("fourth", "taken"), [(199.99, -160.01), (198.0, 198.0)])
def test_an_axis_is_wound_back_rather_than_left_at_its_limit(fourth: float, taken: float) -> None:
    """Axis 4 of an RV-4FRL goes to 200: printed with two decimals a target may be beyond it."""
    arm = robots.get("rv-4frl")
    joints = np.array([[10.0, 20.0, 90.0, angle, 40.0, 0.0] for angle in (170.0, fourth)])
    path = Path.of("p", *arm.fk(joints), kinds=[Kind.JOINT] * 2, speeds=[Speed(100.0)])
    stated = replace(
        path, configurations=np.vstack([arm.configuration(joints[:1]), [UNSTATED] * 6])
    )
    _, got, findings = followed(stated, arm)
    assert not findings
    assert got[1, 3] == pytest.approx(taken, abs=1e-6)


def test_an_axis_of_many_turns_is_followed_and_wound_back() -> None:
    """Axis 6 of an arm of one's own may turn 20 times."""
    limits = ABB.limits.copy()
    limits[5] = -3600.0, 3600.0
    positions, turned = np.tile([450, 0, 300.0], (100, 1)), turning(np.linspace(0, 3000, 100))
    path = path_of(positions, turned, kinds=[Kind.JOINT, *[Kind.LINEAR] * 99])
    _, joints, findings = followed(path, replace(ABB, limits=limits))
    assert not findings
    assert np.ptp(joints[:, 5]) == pytest.approx(3000.0)


def test_no_turn_of_the_tool_is_offered_for_axis_four() -> None:
    """It is in line with axis 6 only where the wrist is straight."""
    robot = robots.get("rv-4frl")
    joints = np.tile([0.0, 20.0, 90.0, 0.0, 50.0, 0.0], (400, 1))
    joints[:, 3] = np.linspace(-100.0, 285.0, 400)
    positions, quaternions = robot.fk(joints)
    _, _, findings = followed(path_of(positions, quaternions), robot)
    assert codes(findings) == ["RB106"]
    assert "J4" in findings[0].message
    assert "flange" not in str(findings[0].cure)


@pytest.mark.parametrize(
    ("tip", "cure"),
    [
        (Pose((0.0, 0.0, 100.0)), "tilt the tool"),
        (Pose((40.0, 0.0, 100.0)), "turn the tool about its axis"),
        (Pose((0.0, 0.0, 100.0), (0.924, 0.0, 0.383, 0.0)), "turn the tool about its axis"),
    ],
)
def test_a_turn_about_the_flange_is_no_cure_for_an_axis_before_the_last(
    tip: Pose, cure: str
) -> None:
    robot = robots.get("rv-4frl")
    p, q = robot.fk(np.array([[0.0, 0.0, 90.0, 0.0, 130.0, 0.0]]))
    wanted = Pose.of(p[0], q[0]) @ tip
    path = path_of(np.array([wanted.position]), np.array([wanted.quaternion]), tools=["t"])
    _, _, findings = followed(path, robot, tools={"t": Tool(tip)})
    assert codes(findings) == ["RB103"] and "J5" in findings[0].message
    assert str(findings[0].cure).startswith(cure)
