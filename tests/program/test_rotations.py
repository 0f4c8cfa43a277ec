"""Rotations: against the textbook matrices, against spatialmath, and against themselves."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from spatialmath import base

from assistant.base import rotations
from assistant.base.rotations import EulerOrder

ORDERS: tuple[EulerOrder, ...] = ("ZYX", "XYZ", "ZYZ")

angles = st.floats(-720, 720) | st.sampled_from([0.0, -0.0, 90.0, -90.0, 180.0, -180.0, 89.9999999])
three_angles = st.tuples(angles, angles, angles)
unit = (
    st.tuples(*[st.floats(-1, 1)] * 4)
    .map(np.array)
    .filter(lambda q: np.linalg.norm(q) > 1e-3)
    .map(lambda q: q / np.linalg.norm(q))
)


def by_matrices(angles: tuple[float, float, float], order: EulerOrder) -> np.ndarray:
    turns = {"X": base.rotx, "Y": base.roty, "Z": base.rotz}
    first, second, third = (
        turns[letter](angle, unit="deg") for letter, angle in zip(order, angles, strict=True)
    )
    return np.asarray(first @ second @ third)


@pytest.mark.parametrize("order", ORDERS)
@given(three_angles)
def test_euler_angles_turn_about_the_moved_axes_in_their_order(
    order: EulerOrder, angles: tuple[float, float, float]
) -> None:
    matrix = rotations.to_matrix(rotations.from_euler(angles, order))
    np.testing.assert_allclose(matrix, by_matrices(angles, order), atol=1e-12)


@pytest.mark.parametrize("order", ORDERS)
@given(three_angles)
def test_euler_angles_come_back_as_the_same_rotation(
    order: EulerOrder, angles: tuple[float, float, float]
) -> None:
    q = rotations.from_euler(angles, order)
    back = rotations.to_euler(q, order)
    assert np.all((back > -180.0) & (back <= 180.0))
    # just beside the lock each outer angle is known to seven digits only
    assert rotations.angle_between(q, rotations.from_euler(back, order)) < 2e-8


@given(st.tuples(st.floats(-179, 179), st.floats(-89, 89), st.floats(-179, 179)))
def test_angles_away_from_a_lock_come_back_themselves(angles: tuple[float, float, float]) -> None:
    for order in ("ZYX", "XYZ"):
        np.testing.assert_allclose(
            rotations.to_euler(rotations.from_euler(angles, order), order), angles, atol=1e-9
        )


@pytest.mark.parametrize("middle", [90.0, -90.0])
def test_in_the_lock_the_last_turn_of_a_controller_is_zero(middle: float) -> None:
    c, b, _ = rotations.to_euler(rotations.from_euler((30.0, middle, 10.0)))
    assert (c, b) == (0.0, pytest.approx(middle))


def test_a_lock_of_zyz_leaves_its_first_angle_zero() -> None:
    np.testing.assert_allclose(
        rotations.to_euler(rotations.from_euler((30.0, 0.0, 10.0), "ZYZ"), "ZYZ"), [0.0, 0.0, 40.0]
    )


@given(unit)
def test_matrices_are_those_of_spatialmath_and_come_back(q: np.ndarray) -> None:
    matrix = rotations.to_matrix(q)
    np.testing.assert_allclose(matrix, base.q2r(q), atol=1e-12)
    np.testing.assert_allclose(rotations.from_matrix(matrix), rotations.canonical(q), atol=1e-9)


@given(unit, unit)
def test_products_are_those_of_the_matrices(left: np.ndarray, right: np.ndarray) -> None:
    np.testing.assert_allclose(
        rotations.to_matrix(rotations.multiply(left, right)),
        rotations.to_matrix(left) @ rotations.to_matrix(right),
        atol=1e-12,
    )


@given(unit, st.tuples(*[st.floats(-1e4, 1e4)] * 3))
def test_a_vector_turns_as_the_matrix_says(q: np.ndarray, v: tuple[float, ...]) -> None:
    np.testing.assert_allclose(rotations.rotate(q, v), rotations.to_matrix(q) @ v, atol=1e-8)


@given(unit)
def test_equal_rotations_have_equal_columns(q: np.ndarray) -> None:
    one, other = rotations.canonical(q), rotations.canonical(-3.0 * q)
    np.testing.assert_allclose(one, other, atol=1e-15)
    assert np.linalg.norm(one) == pytest.approx(1.0, abs=1e-15)
    assert one[np.abs(one) > 1e-9][0] > 0
    assert not np.any(np.signbit(one) & (one == 0.0))


@given(unit, st.floats(1e-7, 179.9))
def test_the_angle_between_is_exact_even_when_small(q: np.ndarray, degrees: float) -> None:
    turned = rotations.multiply(q, rotations.about((0.6, 0.0, 0.8), degrees))
    assert rotations.angle_between(q, turned) == pytest.approx(degrees, rel=1e-6, abs=1e-13)
    assert rotations.angle_between(q, -turned) == pytest.approx(degrees, rel=1e-6, abs=1e-13)


@given(unit, st.floats(0.0, 179.9), st.floats(0.0, 1.0))
def test_part_of_a_turn_is_that_part_of_its_angle(
    q: np.ndarray, degrees: float, part: float
) -> None:
    axis = (0.6, 0.0, 0.8)
    last = rotations.multiply(q, rotations.about(axis, degrees))
    expected = rotations.multiply(q, rotations.about(axis, part * degrees))
    for end in (last, -last):
        found = rotations.between(q, end, part)
        assert np.linalg.norm(found) == pytest.approx(1.0, abs=1e-9)
        assert rotations.angle_between(found, expected) == pytest.approx(0.0, abs=1e-6)


def test_parts_of_turns_in_columns() -> None:
    first = np.tile((1.0, 0.0, 0.0, 0.0), (3, 1))
    last = rotations.about(np.tile([1.0, 0.0, 0.0], (3, 1)), np.array([10.0, 20.0, 30.0]))
    parts = np.array([0.0, 0.5])
    found = rotations.between(first[:, None], last[:, None], parts)
    assert found.shape == (3, 2, 4)
    np.testing.assert_allclose(rotations.angle_between(found[:, 1], last), [5.0, 10.0, 15.0])


@pytest.mark.parametrize("axis", [(1.0, 0, 0), (0, 1.0, 0), (0, 0, 1.0)])
def test_half_turns_survive_the_matrix(axis: tuple[float, float, float]) -> None:
    q = rotations.about(axis, 180.0)
    np.testing.assert_allclose(
        rotations.from_matrix(rotations.to_matrix(q)), [0, *axis], atol=1e-12
    )


def test_columns_of_any_length_and_shape() -> None:
    random = np.random.default_rng(3)
    q = rotations.canonical(random.normal(size=(4, 5, 4)))
    v = random.normal(size=(4, 5, 3))
    assert rotations.to_euler(q).shape == (4, 5, 3)
    assert rotations.from_matrix(rotations.to_matrix(q)).shape == (4, 5, 4)
    one = rotations.rotate(q[2, 3], v[2, 3])
    np.testing.assert_allclose(rotations.rotate(q, v)[2, 3], one, rtol=1e-14)
    assert rotations.to_euler(np.empty((0, 4))).shape == (0, 3)
    assert rotations.canonical(np.empty((0, 4))).shape == (0, 4)
    np.testing.assert_allclose(rotations.multiply(q, rotations.conjugate(q))[..., 0], 1.0)


def test_a_known_quaternion() -> None:
    half = math.sqrt(0.5)
    np.testing.assert_allclose(rotations.from_euler((90.0, 0.0, 0.0)), [half, 0, 0, half])
    np.testing.assert_allclose(rotations.from_euler((0.0, 90.0, 0.0)), [half, 0, half, 0])
    np.testing.assert_allclose(rotations.from_euler((0.0, 0.0, 90.0)), [half, half, 0, 0])
