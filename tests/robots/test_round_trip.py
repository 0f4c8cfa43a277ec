"""Joints → pose → joints of every robot of the catalogue, and by way of its vendor's notation.

A pose does not tell the joints at a singularity, and near one rounding decides: an error e of a
pose becomes e / s of the joints, where s is the sine of the angle that is nearly 0. Poses are
good to about 1e-15 of their size, so that 1e-6 degrees are kept as long as s is above some 1e-7.
What is asked here keeps a hundred times that distance and more: away from a singularity are
joints with axis 5 at least 0.01 degrees off the line of axes 4 and 6, the elbow 0.01 degrees off
stretched and folded, and the wrist centre 0.01 mm off axis 1.
"""

from __future__ import annotations

import numpy as np
import pytest

from assistant import robots
from assistant.languages.melfa_basic.tables.poses import configurations_of, flags_of
from assistant.robots import Robot
from assistant.robots.configurations import from_confdata, to_confdata

MARGIN = 0.01
"""degrees or mm."""
CLOSE = 1e-6
"""degrees or mm."""

sizes = pytest.mark.parametrize("count", [400, pytest.param(100_000, marks=pytest.mark.slow)])
every = pytest.mark.parametrize("name", robots.names())


def random_joints(robot: Robot, count: int) -> np.ndarray:
    return np.random.default_rng(count).uniform(*robot.limits.T, (count, len(robot.axes)))


def off_line(degrees: np.ndarray) -> np.ndarray:
    """How far angles are from 0 and 180, where two links or axes are in line."""
    return np.abs(degrees - 180.0 * np.round(degrees / 180.0))


def away(robot: Robot, joints: np.ndarray) -> np.ndarray:
    """(n,) whether joints are away from every singularity, told by the points of the arm."""
    if robot.arm.kind == "scara":
        return off_line(joints[:, 1]) > MARGIN
    points = robot.chain(joints)
    wrist = points[:, 4]
    upper, fore = points[:, 2] - points[:, 1], wrist - points[:, 2]
    sine = np.linalg.norm(np.cross(upper, fore), axis=1)
    elbow = np.degrees(np.arctan2(sine, np.einsum("ij,ij->i", upper, fore)))
    clear = (off_line(elbow) > MARGIN) & (np.hypot(wrist[:, 0], wrist[:, 1]) > MARGIN)
    if robot.arm.spherical:
        clear &= off_line(joints[:, 4]) > MARGIN
    return clear


def apart(robot: Robot, left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Largest difference of joints, whole turns of the axes that turn aside."""
    difference = left - right
    turns = np.where(robot.sliding, 0.0, 360.0 * np.round(difference / 360.0))
    return np.abs(difference - turns).max(axis=-1)


def by_vendor(robot: Robot, joints: np.ndarray) -> np.ndarray:
    """Neutral configurations of joints as they come back from confdata or FLG1 and FLG2."""
    configurations = robot.configuration(joints)
    if "rapid" in robot.languages:
        return from_confdata(to_confdata(configurations))
    return configurations_of(flags_of(configurations, robot), robot)


@every
@sizes
def test_joints_are_among_the_branches_of_their_pose(name: str, count: int) -> None:
    robot = robots.get(name)
    joints = random_joints(robot, count)
    found, valid = robot.ik(*robot.fk(joints))
    best = np.where(valid, apart(robot, found, joints[:, None]), np.inf).min(axis=1)
    clear = away(robot, joints)
    assert clear.sum() > 0.995 * count
    assert best[clear].max() < CLOSE
    # Nearer to a singularity the joints may differ, but some branch still gets there.
    assert np.isfinite(best).all()


@every
@sizes
def test_the_vendors_configuration_gives_the_joints_back(name: str, count: int) -> None:
    robot = robots.get(name)
    joints = random_joints(robot, count)
    joints = joints[away(robot, joints)]
    back = robot.joints_of(*robot.fk(joints), by_vendor(robot, joints))
    assert np.abs(back - joints).max() < CLOSE  # turns included; a row that fails is NaN


@every
@sizes
def test_every_branch_has_a_configuration_of_its_own(name: str, count: int) -> None:
    robot = robots.get(name)
    joints = random_joints(robot, count)
    joints = joints[away(robot, joints)]
    positions, quaternions = robot.fk(joints)
    found, valid = robot.ik(positions, quaternions)
    rows, branches = np.nonzero(valid)
    solutions = found[rows, branches]
    assert len(np.unique(branches)) > 1
    stated = by_vendor(robot, solutions)
    assert (robot.branch_of(stated) == branches).all()
    back = robot.joints_of(positions[rows], quaternions[rows], stated)
    assert np.abs(back - solutions).max() < CLOSE


def test_the_margin_tells_singular_joints() -> None:
    robot = robots.get("irb120-3-0.58")
    stretched = -float(np.degrees(np.arctan2(302.0, 70.0)))
    joints = np.array(
        [
            [10.0, 20.0, 30.0, 40.0, 50.0, 60.0],
            [10.0, 20.0, 30.0, 40.0, 0.005, 60.0],
            [10.0, 20.0, stretched + 0.005, 40.0, 50.0, 60.0],
            [10.0, 0.0, stretched - 90.0, 40.0, 50.0, 60.0],
        ]
    )
    # The last has the elbow at a right angle and leans until the wrist is over axis 1.
    joints[3, 1] = float(np.degrees(np.arctan2(np.hypot(302.0, 70.0), 270.0)))
    assert away(robot, joints).tolist() == [True, False, False, False]
    assert robot.chain(joints)[3, 4, :2] == pytest.approx([0.0, 0.0], abs=1e-9)
