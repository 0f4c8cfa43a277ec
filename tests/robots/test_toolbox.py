"""Robots of the catalogue as robots of roboticstoolbox."""

from __future__ import annotations

import sys

import numpy as np
import pytest

from assistant import robots
from assistant.base import rotations
from assistant.base.diagnostics import Refused
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
    assert "robot-assistant[toolbox]" in finding.cure
