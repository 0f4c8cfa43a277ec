"""The A, B coding of five-axis arms."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from assistant import robots
from assistant.base import rotations
from assistant.robots.arms import closed_form

coordinates = st.lists(st.floats(-500, 500), min_size=3, max_size=3)
angles = st.floats(-180, 180, exclude_min=True)


def close(left: np.ndarray, right: np.ndarray) -> bool:
    return bool(np.abs((left - right + 180.0) % 360.0 - 180.0).max() < 1e-9)


@given(coordinates, angles, angles)
def test_angles_come_back(position, a, b) -> None:
    p, ab = np.array([position]), np.array([[a, b]])
    q = closed_form.from_ab(p, ab)
    assert closed_form.plane_miss(p, q)[0] < 1e-9
    back = closed_form.to_ab(p, q)
    assert (back > -180.0).all()
    assert (back <= 180.0).all()
    assert close(back, ab)


@given(coordinates, angles, st.sampled_from([0.0, 180.0]))
def test_a_vertical_tool_is_in_every_plane(position, roll, b) -> None:
    p = np.array([position])
    q = rotations.canonical(
        rotations.multiply(
            rotations.from_euler([0.0, b, 0.0]), rotations.about((0.0, 0.0, 1.0), roll)
        )
    )[None]
    assert closed_form.plane_miss(p, q)[0] == pytest.approx(0.0, abs=1e-9)
    back = closed_form.from_ab(p, closed_form.to_ab(p, q))
    assert rotations.angle_between(q, back)[0] < 1e-9


def test_a_tool_that_points_down_is_180_in_spite_of_rounding() -> None:
    p = np.array([[200.0, 100.0, 300.0]] * 4)
    tiny = np.array([0.0, 1e-17, -1e-17, 1e-13])
    q = np.stack([tiny, 0 * tiny, 1 + 0 * tiny, 0 * tiny], axis=-1)
    assert closed_form.to_ab(p, q)[:, 1].tolist() == pytest.approx([180.0] * 4)


def test_on_axis_one_the_azimuth_is_nought() -> None:
    p = np.array([[0.0, 0.0, 700.0], [1e-12, -1e-12, 700.0]])
    ab = np.array([[30.0, 60.0], [30.0, 60.0]])
    assert close(closed_form.to_ab(p, closed_form.from_ab(p, ab)), ab)


def test_a_tool_axis_beside_the_plane_misses() -> None:
    p = np.array([[300.0, 0.0, 300.0]])
    sideways = rotations.from_euler([[0.0, 0.0, 170.0]])  # down, tilted 10 degrees to the side
    assert closed_form.plane_miss(p, sideways)[0] == pytest.approx(10.0)
    forward = rotations.from_euler([[0.0, 170.0, 0.0]])
    assert closed_form.plane_miss(p, forward)[0] == pytest.approx(0.0, abs=1e-9)


def test_angles_are_those_of_the_joints() -> None:
    robot = robots.get("rv-2aj")
    joints = np.array([[30.0, 20.0, 60.0, 40.0, 15.0], [-40.0, 10.0, 80.0, 90.0, -50.0]])
    p, q = robot.fk(joints)
    b = joints[:, 1:4].sum(axis=1)
    a = joints[:, 4] + joints[:, 0] * np.cos(np.radians(b))
    assert closed_form.to_ab(p, q) == pytest.approx(np.stack([a, b], axis=-1))
