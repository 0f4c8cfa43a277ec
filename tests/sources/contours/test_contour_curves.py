"""Curves: points, lengths, reversing."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from assistant.sources.contours.curves import Arc, FreeCurve, Line, sample

coordinates = st.floats(-1000.0, 1000.0)
points = st.tuples(coordinates, coordinates, coordinates)
sweeps = st.floats(1.0, 359.0) | st.floats(-359.0, -1.0) | st.just(360.0)


@st.composite
def arcs(draw):
    centre = np.array(draw(points))
    axis = np.array(draw(st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda v: math.hypot(*v) > 0.1)))
    across = np.cross(axis, np.eye(3)[np.abs(axis).argmin()])
    start = centre + draw(st.floats(0.1, 500.0)) * across / np.linalg.norm(across)
    return Arc.about(centre, axis, start, draw(sweeps), "L", "1F")


def test_a_quarter_of_a_circle():
    arc = Arc.about((0, 0, 0), (0, 0, 1), (10, 0, 0), 90.0)
    assert arc.end == pytest.approx((0, 10, 0), abs=1e-12)
    assert arc.via == pytest.approx((math.sqrt(50), math.sqrt(50), 0))
    assert arc.length == pytest.approx(5 * math.pi)
    assert not arc.closed


def test_a_negative_sweep_runs_the_other_way_round():
    arc = Arc.about((0, 0, 0), (0, 0, 1), (10, 0, 0), -90.0)
    assert arc.end == pytest.approx((0, -10, 0), abs=1e-12)
    assert arc.normal == (0.0, 0.0, -1.0)


def test_a_full_circle_is_closed_with_its_via_opposite():
    circle = Arc.about((5, 0, 0), (0, 0, 1), (15, 0, 0), 360.0)
    assert circle.closed
    assert circle.start == circle.end
    assert circle.via == pytest.approx((-5, 0, 0))
    assert circle.length == pytest.approx(20 * math.pi)


@given(arcs())
def test_an_arc_keeps_to_its_circle_and_its_points(arc):
    along = arc.at(np.linspace(0, 1, 9))
    away = np.linalg.norm(along - arc.centre, axis=1)
    assert np.allclose(away, arc.radius, atol=1e-8)
    assert np.allclose(along[[0, 4, 8]], [arc.start, arc.via, arc.end], atol=1e-6)


@given(arcs())
def test_reversed_arcs_have_the_same_points_backwards(arc):
    t = np.linspace(0, 1, 9)
    assert np.allclose(arc.reversed().at(t), arc.at(1 - t), atol=1e-6)
    assert arc.reversed().reversed() == arc
    assert (arc.reversed().layer, arc.reversed().handle) == ("L", "1F")


@given(arcs().filter(lambda a: not a.closed and a.radius > 1 and 5 < a.sweep < 355))
def test_the_arc_through_three_points_of_an_arc_is_that_arc(arc):
    again = Arc.through(arc.start, arc.at([0.3])[0], arc.end)
    assert again.radius == pytest.approx(arc.radius, rel=1e-5)
    assert np.allclose(again.via, arc.via, atol=1e-3)
    assert again.sweep == pytest.approx(arc.sweep, abs=1e-3)


@given(points, points)
def test_points_on_one_line_make_no_arc(a, b):
    middle = tuple((np.array(a) + b) / 2)
    assert Arc.through(a, middle, b) is None


def test_free_curves_run_backwards_with_their_breaks():
    curve = FreeCurve(lambda t: np.c_[t, t**2, 0 * t], breaks=(0.0, 0.25, 1.0))
    back = curve.reversed()
    assert back.start == curve.end == (1.0, 1.0, 0.0)
    assert back.breaks == (0.0, 0.75, 1.0)
    assert np.allclose(back.at([0.25]), curve.at([0.75]))
    assert curve.length == pytest.approx(1.4789, abs=1e-3)


def test_sampling_many_curves_gives_what_each_of_them_gives():
    curves = [
        Line((0, 0, 0), (1, 2, 3)),
        Arc.about((0, 0, 0), (0, 0, 1), (10, 0, 0), 90.0),
        FreeCurve(lambda t: np.c_[t, t**2, 0 * t]),
        Arc.about((0, 0, 0), (0, 1, 1), (10, 0, 0), 360.0),
    ]
    t = [0.0, 0.3, 1.0]
    assert np.allclose(sample(curves, t), [c.at(t) for c in curves])
