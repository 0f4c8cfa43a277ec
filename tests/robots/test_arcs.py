"""Circles through three points, against circles that are known beforehand."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from assistant.base import rotations
from assistant.robots.motion.interpolation import arcs_of, circles, vias_of

shares = st.floats(0.02, 0.98)


def on_circle(angles: np.ndarray, radius: float, seed: int) -> np.ndarray:
    """Points of a circle somewhere in space, at radians from its first point."""
    rng = np.random.default_rng(seed)
    q = rotations.canonical(rng.normal(size=4))
    flat = radius * np.stack([np.cos(angles), np.sin(angles), 0.0 * angles], axis=-1)
    return rotations.rotate(q, flat) + rng.uniform(-500, 500, 3)


@given(st.floats(0.5, 2000.0), st.floats(0.05, 6.2), shares, st.integers(0, 2**31))
def test_points_of_a_circle_are_found_again(radius, sweep, share, seed) -> None:
    angles = np.array([0.0, share * sweep, sweep])
    start, via, end = on_circle(angles, radius, seed)[:, None]
    found = circles(start, via, end)
    assert found.radii == pytest.approx(radius, rel=1e-4)
    assert (found.vias, found.ends) == pytest.approx((angles[1], sweep), rel=1e-4)
    between = np.linspace(0.0, sweep, 9)
    expected = on_circle(between, radius, seed)
    np.testing.assert_allclose(found.points(between[None])[0], expected, atol=1e-4 * radius)
    step = 1e-6
    ahead = found.points(angles[1:2] + step) - found.points(angles[1:2])
    np.testing.assert_allclose(ahead / step, found.directions(angles[1:2]), atol=1e-3 * radius)


@given(st.floats(0.5, 2000.0), st.floats(0.05, 6.2), shares, st.integers(0, 2**31))
def test_an_arc_is_two_moves_up_to_its_via_point_and_on(radius, sweep, share, seed) -> None:
    start, via, end = on_circle(np.array([0.0, share * sweep, sweep]), radius, seed)[:, None]
    arcs = arcs_of(np.array([7]), start, via, end)
    assert arcs is not None
    assert arcs.rows.tolist() == [7, 8]
    assert arcs.lengths.sum() == pytest.approx(radius * sweep, rel=1e-3)
    both = np.array([0, 1])
    np.testing.assert_allclose(arcs.points(both, np.ones(2)), [via[0], end[0]], atol=1e-4 * radius)
    np.testing.assert_allclose(
        arcs.points(both, np.zeros(2)), [start[0], via[0]], atol=1e-4 * radius
    )
    half = arcs.points(both, np.full(2, 0.5))
    chords = np.stack([start[0] + via[0], via[0] + end[0]]) / 2.0
    off = np.linalg.norm(half - chords, axis=1)
    np.testing.assert_allclose(off, arcs.bulges, atol=1e-4 * radius)


def test_points_on_a_line_or_twice_the_same_or_unknown_are_no_arc() -> None:
    start = np.zeros((4, 3))
    via = np.array([[1.0, 0, 0], [0, 0, 0], [1, 1, 0], [np.nan, 0, 0]])
    end = np.array([[2.0, 0, 0], [1, 0, 0], [0, 0, 0], [1, 1, 0]])
    assert arcs_of(np.arange(4), start, via, end) is None
    assert circles(start, via, end).ends.tolist() == [0.0] * 4


def test_a_via_point_without_an_end_begins_no_arc() -> None:
    assert vias_of(np.array([0, 2, 3, 1, 2, 2, 3, 3, 2], dtype=np.uint8)).tolist() == [1, 5]
