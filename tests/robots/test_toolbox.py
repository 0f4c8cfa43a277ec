"""Robots of the catalogue as robots of roboticstoolbox."""

from __future__ import annotations

import sys

import numpy as np
import pytest
from spatialmath import SE3

from assistant import robots
from assistant.base import rotations
from assistant.base.diagnostics import Refused
from assistant.program.geometry import Pose
from assistant.robots import Robot


def in_its_units(robot: Robot, joints: np.ndarray) -> np.ndarray:
    """Joints (n, a) deg, of an axis that slides mm → radians and metres."""
    return np.where(robot.sliding, joints / 1000.0, np.radians(joints))


@pytest.mark.parametrize("name", robots.names())
def test_forward_kinematics_agree(name: str) -> None:
    robot = robots.get(name)
    low, high = robot.limits.T
    joints = np.random.default_rng(7).uniform(low, high, (100, len(low)))
    other = robot.to_rtb()
    there = np.stack([pose.A for pose in map(other.fkine, in_its_units(robot, joints))])
    positions, quaternions = robot.fk(joints)
    assert positions / 1000.0 == pytest.approx(there[:, :3, 3], abs=1e-12)
    assert np.abs(rotations.to_matrix(quaternions) - there[:, :3, :3]).max() < 1e-9


@pytest.mark.parametrize("name", ["irb1200-7-0.7", "rv-2aj", "rh-6frh5520"])
def test_the_jacobian_and_manipulability_agree(name: str) -> None:
    robot = robots.get(name)
    joints = np.random.default_rng(7).uniform(*robot.limits.T, (5, len(robot.axes)))
    theirs, other = in_its_units(robot, joints), robot.to_rtb()
    wanted = np.stack([other.jacob0(row) for row in theirs])
    assert np.abs(robot.jacobian(theirs, unit="rad") - wanted).max() < 1e-12
    measure = np.linalg.svd(wanted, compute_uv=False).prod(axis=1)
    if len(robot.axes) == 6:
        assert measure == pytest.approx([other.manipulability(row) for row in theirs])
    assert robot.manipulability(theirs, unit="rad") == pytest.approx(measure)
    assert robot.manipulability(joints, unit="deg") == pytest.approx(measure)


@pytest.mark.parametrize("name", ["irb1200-7-0.7", "rh-6frh5520"])
def test_the_jacobian_in_degrees_is_how_a_tool_moves(name: str) -> None:
    robot, tool = robots.get(name), Pose((10.0, -20.0, 150.0), (0.6, 0.0, 0.8, 0.0))
    joints = robot.home + 3.0
    matrix = robot.jacobian(joints, unit="deg", tool=tool)[0]
    for axis, column in enumerate(matrix.T):
        ends = []
        for change in (-1e-4, 1e-4):
            place, turn = robot.fk(joints + change * np.eye(len(joints))[axis])
            ends.append(Pose.of(place[0], turn[0]) @ tool)
        moved = np.subtract(ends[1].position, ends[0].position) / 2e-4
        turned = rotations.angle_between(ends[0].quaternion, ends[1].quaternion) / 2e-4
        assert column[:3] == pytest.approx(moved, abs=1e-6)
        assert np.linalg.norm(column[3:]) == pytest.approx(float(turned), abs=1e-6)


def test_ik_takes_poses_of_every_form() -> None:
    robot = robots.get("irb1200-7-0.7")
    pose = SE3(0.4, 0.1, 0.3) * SE3.Rx(180, "deg")
    joints, valid = robot.ik(pose, unit="m")
    assert valid.any()
    back = [SE3(row / 1000.0) for row in robot.fk(joints[valid])[0]]
    assert all(np.abs(one.t - pose.t).max() < 1e-8 for one in back)
    mm = Pose.of_matrix(pose.R, 1000.0 * pose.t)
    for form in (mm, [mm], ([mm.position], [mm.quaternion])):
        assert np.array_equal(robot.ik(form)[1], valid)
    assert np.array_equal(robot.ik([pose, pose], unit="m")[1], np.vstack([valid, valid]))
    assert np.array_equal(robot.ik(pose.t, mm.quaternion, unit="m")[1], valid)


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda one: one.ik(SE3(0.4, 0.1, 0.3)), "TB445.*mm or m"),
        (lambda one: one.ik(SE3(0.4, 0.1, 0.3), unit="cm"), "TB446"),
        (lambda one: one.ik(np.zeros((3, 5)), unit="m"), r"the shape is \(3, 5\)"),
        (lambda one: one.fk(np.zeros(5)), r"the shape is \(5,\), not \(n, 6\)"),
        (lambda one: one.jacobian(np.zeros(5), unit="deg"), r"\(5,\), not \(n, 6\)"),
        (lambda one: one.jacobian([[0, 0, 0, 0, np.nan, 0]], unit="rad"), "row 1 .* not finite"),
        (lambda one: one.jacobian(np.zeros(6), unit="grad"), "RB012"),
        (lambda one: one.manipulability(np.zeros(6), unit="deg", tool=[Pose()] * 2), "one pose"),
        (lambda one: one.plot(np.zeros((2, 5))), r"not \(n, 6\)"),
    ],
)
def test_other_shapes_and_units_are_refused(call, said: str) -> None:
    with pytest.raises(Refused, match=said):
        call(robots.get("irb1200-7-0.7"))


def test_an_arm_is_drawn() -> None:
    robot = robots.get("irb1200-7-0.7")
    figure = robot.plot([robot.home, robot.home + 20.0])
    (space,) = figure.axes
    tips = [np.array(line.get_data_3d())[:, -1] for line in space.lines[:2]]
    assert np.array(tips) == pytest.approx(robot.fk([robot.home, robot.home + 20.0])[0])
    assert figure._repr_png_().startswith(b"\x89PNG")


@pytest.mark.parametrize("name", robots.names())
def test_limits_and_names_are_taken_over(name: str) -> None:
    robot = robots.get(name)
    other = robot.to_rtb()
    assert other.n == len(robot.axes)
    assert other.name == robot.title
    assert other.manufacturer == robot.maker
    assert np.abs(other.qlim - in_its_units(robot, robot.limits.T)).max() < 1e-12
    assert [link.isprismatic for link in other.links] == robot.sliding.tolist()


def test_without_the_package_the_extra_is_named(monkeypatch) -> None:
    monkeypatch.setitem(sys.modules, "roboticstoolbox", None)
    with pytest.raises(Refused) as refused:
        robots.get("rv-2a").to_rtb()
    (finding,) = refused.value.findings
    assert finding.code == "RB003"
    assert "[toolbox]" in finding.cure
