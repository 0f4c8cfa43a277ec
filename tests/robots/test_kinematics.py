"""Forward and inverse kinematics against each other and against published figures."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from assistant import robots
from assistant.base import rotations
from assistant.robots import Robot
from tests.examples import drawn

ABB = ("irb1200-7-0.7", "irb1200-5-0.9", "irb120-3-0.58")


def random_joints(robot: Robot, n: int, seed: int = 0) -> np.ndarray:
    low, high = robot.limits.T
    return np.random.default_rng(seed).uniform(low, high, (n, len(low)))


def apart(left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Largest difference of joints in degrees, whole turns aside."""
    return np.abs((left - right + 180.0) % 360.0 - 180.0).max(axis=-1)


@pytest.mark.parametrize("name", robots.names())
def test_inverse_contains_the_joints_that_it_came_from(name: str) -> None:
    robot = robots.get(name)
    joints = random_joints(robot, 500)
    found, valid = robot.ik(*robot.fk(joints))
    best = np.where(valid, apart(found, joints[:, None]), np.inf).min(axis=1)
    assert best.max() < 1e-6


@pytest.mark.parametrize("name", robots.names())
def test_every_valid_branch_comes_back_to_the_pose(name: str) -> None:
    robot = robots.get(name)
    positions, quaternions = robot.fk(random_joints(robot, 150, seed=1))
    found, valid = robot.ik(positions, quaternions)
    assert valid.sum(axis=1).max() >= 2
    for branch in range(found.shape[1]):
        rows = valid[:, branch]
        p, q = robot.fk(found[rows, branch])
        assert np.abs(p - positions[rows]).max(initial=0.0) < 1e-6
        assert rotations.angle_between(q, quaternions[rows]).max(initial=0.0) < 1e-5
        assert robot.inside(found[rows, branch]).all()


@pytest.mark.parametrize("name", robots.names())
def test_joints_come_back_by_their_configuration(name: str) -> None:
    robot = robots.get(name)
    joints = random_joints(robot, 500, seed=2)
    back = robot.joints_of(*robot.fk(joints), robot.configuration(joints))
    assert np.abs(back - joints).max() < 1e-6


def test_another_configuration_gives_other_joints_for_the_same_pose() -> None:
    robot = robots.get("irb1200-7-0.7")
    pose = robot.fk([[10, 20, 30, 40, 50, 300]])
    turned = robot.configuration([[10, 20, 30, 40, 50, -60]])
    assert robot.joints_of(*pose, turned)[0] == pytest.approx([10, 20, 30, 40, 50, -60])
    wrong = turned.copy()
    wrong[0, 5] = 1
    assert np.isnan(robot.joints_of(*pose, wrong)).all()


def standard_dh(robot: Robot):
    """The standard DH rows published for the ABB arms, as an independent model."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        from roboticstoolbox import DHRobot, RevoluteDH

    arm, quarter = robot.lengths, np.pi / 2
    return DHRobot(
        [
            RevoluteDH(d=arm.d1, alpha=-quarter),
            RevoluteDH(a=arm.a2, offset=-quarter),
            RevoluteDH(a=-arm.a3, alpha=-quarter),
            RevoluteDH(d=arm.d4, alpha=quarter),
            RevoluteDH(alpha=-quarter),
            RevoluteDH(d=arm.d6, offset=np.pi),
        ]
    )


@pytest.mark.parametrize("name", ABB)
def test_forward_kinematics_against_another_implementation(name: str) -> None:
    robot = robots.get(name)
    joints = random_joints(robot, 50, seed=3)
    expected = np.stack([standard_dh(robot).fkine(q).A for q in np.radians(joints)])
    positions, quaternions = robot.fk(joints)
    assert np.abs(positions - expected[:, :3, 3]).max() < 1e-9
    assert np.abs(rotations.to_matrix(quaternions) - expected[:, :3, :3]).max() < 1e-12


def test_at_zero_the_arms_of_mitsubishi_stand_upright() -> None:
    for name in ("rv-2a", "rv-4frl", "rv-6sl"):
        p, q = robots.get(name).fk([[0, 0, 0, 0, 0, 0]])
        arm = robots.get(name).lengths
        assert p[0] == pytest.approx([arm.a1 + arm.a3, 0, arm.d1 + arm.a2 + arm.d4 + arm.d6])
        assert q[0] == pytest.approx([1, 0, 0, 0])


@pytest.mark.parametrize(
    ("name", "elbow"),
    [("irb1200-7-0.7", -83.18), ("irb1200-5-0.9", -84.68), ("irb120-3-0.58", -76.95)],
)
def test_the_elbow_bit_of_confdata_changes_where_the_forearm_is_in_line(
    name: str, elbow: float
) -> None:
    from assistant.robots.configurations import to_confdata

    joints = np.array([[0, 10, elbow + d, 0, 30, 0] for d in (0.02, -0.02)])
    cfx = to_confdata(robots.get(name).configuration(joints))[:, 3]
    assert cfx.tolist() == [0, 2]


def test_home_has_the_plain_configuration() -> None:
    for name in robots.names():
        robot = robots.get(name)
        said = {"six-axis": [0, 0, 0], "five-axis": [0, 0, 1], "scara": [0, 1, 1]}[robot.arm.kind]
        assert robot.configuration(robot.home).tolist() == [[*said, 0, 0, 0]]


def test_a_boundary_belongs_to_one_quadrant_in_spite_of_rounding() -> None:
    robot = robots.get("irb1200-7-0.7")
    joints = np.array([[-1e-12, 0, 0, 90 - 1e-12, 30, -90 - 1e-12]])
    assert robot.configuration(joints)[0, 3:].tolist() == [0, 1, -1]


def test_half_a_turn_of_axis_six_is_no_turn_for_mitsubishi() -> None:
    from assistant.robots.configurations import to_flags

    robot = robots.get("rv-4frl")
    joints = np.array([[0, 0, 90, 0, 90, j6] for j6 in (180, -180, 181, -181, 0)])
    two = to_flags(robot.configuration(joints))[:, 1]
    assert two.tolist() == [0, 0xF00000, 0x100000, 0xF00000, 0]


def test_wrist_in_line() -> None:
    for name in ("irb1200-7-0.7", "rv-4frl"):
        robot = robots.get(name)
        joints = np.array([[20, 10, 60, 0, 0, 70.0]])
        p, q = robot.fk(joints)
        found, valid = robot.ik(p, q)
        assert apart(found[valid], joints).min() < 1e-6
        assert not np.isnan(robot.joints_of(p, q, robot.configuration(joints))).any()


@settings(max_examples=drawn(60), deadline=None)
@given(
    st.sampled_from(robots.names()),
    st.lists(st.floats(-3000, 3000), min_size=3, max_size=3),
    st.lists(st.floats(-1, 1), min_size=4, max_size=4).filter(lambda q: np.linalg.norm(q) > 0.1),
)
def test_no_pose_at_all_gives_a_wrong_solution(name: str, position, quaternion) -> None:
    robot = robots.get(name)
    p, q = np.array([position]), rotations.canonical([quaternion])
    found, valid = robot.ik(p, q)
    for joints in found[valid]:
        there, turned = robot.fk(joints)
        assert np.abs(there - p).max() < 1e-4
        assert rotations.angle_between(turned, q).max() < (1e-4 if robot.arm.spherical else 0.011)


def test_the_chain_ends_at_the_flange() -> None:
    for name in robots.names():
        robot = robots.get(name)
        joints = random_joints(robot, 20, seed=4)
        chain = robot.chain(joints)
        assert chain[:, -1] == pytest.approx(robot.fk(joints)[0])
        steps = np.linalg.norm(np.diff(chain, axis=1), axis=2)
        if robot.arm.kind == "scara":
            assert steps[:, :2] == pytest.approx(np.tile([robot.arm.l1, robot.arm.l2], (20, 1)))
            assert steps[:, 2] == pytest.approx(joints[:, 2])
            continue
        arm = robot.lengths
        expected = [np.hypot(arm.a1, arm.d1), arm.a2, abs(arm.a3), arm.d4, arm.d6]
        assert steps == pytest.approx(np.tile(expected, (20, 1)))
