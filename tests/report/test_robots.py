"""Drawings of arms: their axes are those of the kinematics, and equal arms give equal bytes."""

from __future__ import annotations

import numpy as np
import pytest

from assistant import robots
from assistant.report.robots import arm_drawing, joint_axes
from tests.cli.tables import each


def test_the_axes_of_a_drawing_are_those_of_the_arm() -> None:
    each(robots.names(), _check_axes)


def _check_axes(name: str) -> None:
    robot = robots.get(name)
    axes = {axis.name: axis for axis in joint_axes(robot)}
    assert tuple(axes) == robot.axes
    for turned in np.flatnonzero(~robot.sliding):
        # What lies on an axis stays where it is when only its joint turns.
        axis = axes[robot.axes[turned]]
        joints = np.array(robot.home, dtype=float)
        fixed = robot.fk([joints])[0][0] - axis.point
        joints[turned] += 50.0
        moved = robot.fk([joints])[0][0] - axis.point
        assert moved @ axis.direction == pytest.approx(fixed @ axis.direction, abs=1e-6)
        assert np.linalg.norm(moved) == pytest.approx(np.linalg.norm(fixed), abs=1e-6)
    assert axes["J1"].direction == pytest.approx([0.0, 0.0, 1.0])
    if robot.arm.kind != "scara":
        axis_2 = [robot.lengths.a1, 0.0, robot.lengths.d1]
        assert axes["J2"].point == pytest.approx(axis_2, abs=1e-6)


def test_the_same_robot_gives_the_same_bytes() -> None:
    robot = robots.get("rv-2aj")
    assert arm_drawing(robot, "svg") == arm_drawing(robot, "svg")
