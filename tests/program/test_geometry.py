"""Poses, frames, targets and configurations."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from assistant.base import rotations
from assistant.base.diagnostics import Refused
from assistant.program.geometry import (
    IDENTITY,
    UNUSED_AXIS,
    Configuration,
    Frame,
    JointTarget,
    Pose,
    Target,
)
from tests.tables import every_row

HALF = math.sqrt(0.5)


@st.composite
def poses(draw: st.DrawFn) -> Pose:
    q = np.array(draw(st.tuples(*[st.floats(-1, 1)] * 4)))
    turn = rotations.canonical(q if np.linalg.norm(q) > 0.01 else [1.0, 0, 0, 0])
    return Pose.of(np.array(draw(st.tuples(*[st.floats(-2000, 2000)] * 3))), turn)


def matrix(pose: Pose) -> np.ndarray:
    whole = np.eye(4)
    whole[:3, :3] = rotations.to_matrix(pose.quaternion)
    whole[:3, 3] = pose.position
    return whole


@given(poses(), poses())
def test_composing_is_the_product_of_the_matrices(left: Pose, right: Pose) -> None:
    np.testing.assert_allclose(matrix(left @ right), matrix(left) @ matrix(right), atol=1e-8)


@given(poses(), poses())
def test_one_pose_is_composed_as_columns_are_to_the_bit(left: Pose, right: Pose) -> None:
    moved = np.add(left.position, rotations.rotate(left.quaternion, right.position))
    turned = rotations.canonical(rotations.multiply(left.quaternion, right.quaternion))
    assert left @ right == Pose.of(moved, turned)
    back = rotations.conjugate(left.quaternion)
    there = -rotations.rotate(back, left.position)
    assert left.inverse() == Pose.of(there, rotations.canonical(back))


@given(poses())
def test_a_pose_and_its_inverse_cancel(pose: Pose) -> None:
    for nothing in (pose @ pose.inverse(), pose.inverse() @ pose):
        np.testing.assert_allclose(matrix(nothing), np.eye(4), atol=1e-8)
    np.testing.assert_allclose(matrix(pose @ IDENTITY), matrix(pose), atol=1e-9)


def test_an_offset_goes_along_the_own_axes() -> None:
    down = Pose((100.0, 0.0, 50.0), (0.0, 1.0, 0.0, 0.0))
    assert down.offset(z=-10.0).position == pytest.approx((100.0, 0.0, 60.0))
    assert down.offset(x=1.0, y=2.0).position == pytest.approx((101.0, -2.0, 50.0))


def test_an_object_frame_stands_in_the_user_frame() -> None:
    frame = Frame(Pose((100.0, 0.0, 0.0), (HALF, 0.0, 0.0, HALF)), Pose((10.0, 0.0, 5.0)))
    assert frame.pose.position == pytest.approx((100.0, 10.0, 5.0))


@every_row(
    ("quadrant", "turn"),
    [(-7, -2), (-6, -1), (-3, -1), (-2, 0), (-1, 0), (0, 0), (1, 0), (2, 1), (5, 1), (6, 2)],
)
def test_turns_count_from_minus_to_plus_180_degrees(quadrant: int, turn: int) -> None:
    low, high = 90 * quadrant, 90 * quadrant + 90
    assert -180 + 360 * turn <= low < high <= 180 + 360 * turn
    assert Configuration(quadrants=(quadrant, 0, quadrant)).turns == (turn, 0, turn)


def test_unused_axes_of_equal_targets_are_equal() -> None:
    one = Target(Pose(), None, (1.0, *[UNUSED_AXIS] * 5))
    other = Target(Pose(), None, (1.0, *[float("nan")] * 5))
    assert one == other and hash(one) == hash(other)
    assert one != Target(Pose(), None, (UNUSED_AXIS,) * 6)
    assert one != Target(Pose(), Configuration(), one.external)
    assert one != Target(Pose((0.0, 0.0, 1.0)), None, one.external)
    assert one != "target"


def test_joint_targets_know_missing_joints() -> None:
    five = JointTarget((1.0, 2.0, 3.0, UNUSED_AXIS, 5.0, 6.0))
    assert five == JointTarget((1.0, 2.0, 3.0, float("nan"), 5.0, 6.0))
    assert hash(five) == hash(JointTarget((1.0, 2.0, 3.0, float("nan"), 5.0, 6.0)))
    assert five != JointTarget((1.0, 2.0, 3.0, 4.0, 5.0, 6.0))
    assert five != JointTarget((1.0, 2.0, 3.0))
    assert five != 5


@given(poses())
def test_a_matrix_is_that_of_the_columns_and_comes_back(pose: Pose) -> None:
    np.testing.assert_allclose(pose.matrix, matrix(pose), atol=1e-12)
    np.testing.assert_allclose(pose.rotation, matrix(pose)[:3, :3], atol=1e-12)
    for back in (Pose.of_matrix(pose.matrix), Pose.of_matrix(pose.rotation, pose.position)):
        assert back.position == pose.position
        assert rotations.angle_between(back.quaternion, pose.quaternion) < 1e-6
    assert Pose.of_matrix(pose.rotation.round(6).tolist()).position == (0.0, 0.0, 0.0)


@pytest.mark.parametrize("length", [5e-324, 1e-310, 1e-200, 1e200])
def test_a_quaternion_of_any_length_is_a_rotation(length: float) -> None:
    pose = Pose((0.0, 0.0, 0.0), (0.0, 0.0, length, 0.0))
    np.testing.assert_array_equal(pose.rotation, np.diag([-1.0, 1.0, -1.0]))


SHEAR = [[1, 0.1, 0], [0, 1, 0], [0, 0, 1]]


@every_row(
    ("given", "position", "said"),
    [
        (np.eye(2), None, "a matrix"),
        (np.eye(4)[None], None, "a matrix"),
        ("a pose", None, "it holds text"),
        (np.full((3, 3), np.nan), None, "finite"),
        (2.0 * np.eye(3), None, "scales"),
        (SHEAR, None, "shears"),
        (np.diag([1.0, 1.0, -1.0]), None, "mirrors"),
        (np.eye(4) + np.eye(4, k=-1) * [0, 0, 1, 0], None, "last row"),
        (np.eye(4), (1.0, 2.0, 3.0), "already holds"),
        (np.eye(3), (1.0, 2.0), r"position of shape \(2,\)"),
        (np.eye(3), (1.0, 2.0, np.inf), "not finite"),
    ],
)
def test_what_is_no_matrix_of_a_pose_is_refused(given, position, said: str) -> None:
    with pytest.raises(Refused, match=said):
        Pose.of_matrix(given, position)


@given(poses(), poses())
def test_the_parts_of_a_straight_motion_are_even(start: Pose, end: Pose) -> None:
    assert rotations.angle_between(start.interpolate(end, 0.0).quaternion, start.quaternion) < 1e-6
    assert start.interpolate(end, 1.0).position == pytest.approx(end.position)
    whole = rotations.angle_between(start.quaternion, end.quaternion)
    for part in (0.25, 0.5, 1.0):
        there = start.interpolate(end, part)
        along = np.subtract(there.position, start.position)
        assert along == pytest.approx(part * np.subtract(end.position, start.position), abs=1e-9)
        turned = rotations.angle_between(start.quaternion, there.quaternion)
        assert turned == pytest.approx(part * whole, abs=1e-5)


@pytest.mark.parametrize("part", [-0.01, 1.01, math.nan, math.inf])
def test_a_part_of_a_motion_is_from_0_to_1(part: float) -> None:
    with pytest.raises(Refused, match=r"from 0 to 1|no finite number"):
        IDENTITY.interpolate(IDENTITY, part)


@pytest.mark.parametrize("quaternion", [(0.0, 0.0, 0.0, 0.0), (math.nan, 0.0, 0.0, 0.0)])
def test_a_pose_without_an_orientation_has_no_matrix(quaternion) -> None:
    nowhere = Pose(quaternion=quaternion)
    for asked in (lambda: nowhere.matrix, lambda: IDENTITY.interpolate(nowhere, 0.5)):
        with pytest.raises(Refused, match="no quaternion"):
            asked()
