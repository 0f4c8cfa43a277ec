"""Fitting: arcs and lines stay near the true curve, in both directions, and join smoothly."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from assistant.sources.contours.biarcs import fit_curve
from assistant.sources.contours.curves import Arc, FreeCurve, Line
from tests.examples import drawn


def ellipse(a, b, closed=True, turn=1.0):
    return FreeCurve(
        lambda t: np.c_[a * np.cos(2 * np.pi * turn * t), b * np.sin(2 * np.pi * turn * t), 0 * t],
        closed,
        "L",
        "E1",
    )


def bezier(points):
    n = len(points) - 1
    weights = [math.comb(n, i) for i in range(n + 1)]
    return FreeCurve(
        lambda t: sum(
            (w * t**i * (1 - t) ** (n - i))[:, None] * np.asarray(p)
            for i, (w, p) in enumerate(zip(weights, points, strict=False))
        )
    )


def distances(points, others):
    """From each point to the polyline through others."""
    a, v = others[:-1], np.diff(others, axis=0)
    size = np.maximum((v * v).sum(1), 1e-30)
    least = np.full(len(points), np.inf)
    for i in range(len(a)):
        share = np.clip((points - a[i]) @ v[i] / size[i], 0, 1)
        least = np.minimum(least, np.linalg.norm(points - a[i] - share[:, None] * v[i], axis=1))
    return least


def to_piece(points, piece):
    """Exact distances from points to a line or arc."""
    if isinstance(piece, Line):
        return distances(points, np.array([piece.start, piece.end]))
    w = points - piece.centre
    height = w @ piece.normal
    flat = w - height[:, None] * piece.normal
    start = np.subtract(piece.start, piece.centre)
    angle = np.degrees(
        np.arctan2(np.cross(np.broadcast_to(start, flat.shape), flat) @ piece.normal, flat @ start)
    )
    beside = np.hypot(np.linalg.norm(flat, axis=1) - piece.radius, height)
    ends = [np.linalg.norm(points - end, axis=1) for end in (piece.start, piece.end)]
    return np.where(angle % 360.0 <= piece.sweep, beside, np.minimum(*ends))


def dense(pieces, each=200):
    return np.concatenate([p.at(np.linspace(0, 1, each)) for p in pieces])


def check(curve, tolerance, count=400):
    """The fit is connected, and within the tolerance of the curve, and the curve of it."""
    result = fit_curve(curve, tolerance)
    assert result.within
    assert result.deviation <= tolerance
    true = curve.at(np.linspace(0, 1, count))
    coarse = 0.05 * tolerance + 1e-9 * np.abs(true).max()
    there = dense(result.pieces, max(12, 1200 // len(result.pieces)))
    sag = np.linalg.norm(np.diff(true, axis=0), axis=1).max()
    nearest = np.min([to_piece(true, piece) for piece in result.pieces], axis=0)
    assert nearest.max() <= tolerance * 1.02 + 1e-6
    assert distances(there[::5], true).max() <= tolerance * 1.05 + coarse + 0.01 * sag
    for one, two in zip(result.pieces, result.pieces[1:], strict=False):
        assert math.dist(one.end, two.start) < 1e-9
    assert math.dist(result.pieces[0].start, true[0]) < 1e-9
    assert math.dist(result.pieces[-1].end, true[-1]) < 1e-6
    return result


@settings(max_examples=drawn(25), deadline=None)
@given(st.floats(2, 500), st.floats(0.05, 1.0), st.sampled_from([0.01, 0.05, 0.5]))
def test_ellipses(a, ratio, tolerance):
    result = check(ellipse(a, a * ratio), tolerance)
    assert result.pieces[-1].end == result.pieces[0].start


coordinates = st.floats(-200, 200).map(lambda v: round(v, 3))


@settings(max_examples=drawn(40), deadline=None)
@given(st.lists(st.tuples(coordinates, coordinates), min_size=3, max_size=6), st.booleans())
def test_bezier_curves_in_the_plane_and_in_space(flat, lifted):
    points = np.array([(x, y, (x + y * y / 200 if lifted else 0.0)) for x, y in flat])
    if np.ptp(points, axis=0).max() < 1.0:
        points[-1] += 50.0
    curve = bezier(points)
    if math.dist(curve.start, curve.end) < 1e-3:
        return
    check(curve, 0.05)


def test_planar_curves_stay_in_their_plane():
    result = fit_curve(ellipse(100, 30), 0.05)
    assert all(p.start[2] == 0.0 and abs(p.via[2]) < 1e-12 for p in result.pieces)


def test_a_fit_is_smooth_where_the_curve_is():
    pieces = fit_curve(ellipse(100, 50), 0.05).pieces
    for one, two in itertools.pairwise(pieces):
        leaving = one.at([1 - 1e-6, 1.0])
        entering = two.at([0.0, 1e-6])
        u, v = leaving[1] - leaving[0], entering[1] - entering[0]
        turn = math.degrees(math.acos(min(1.0, u @ v / np.linalg.norm(u) / np.linalg.norm(v))))
        assert turn < 0.1


def test_pieces_carry_layer_and_handle():
    assert {(p.layer, p.handle) for p in fit_curve(ellipse(9, 5), 0.05).pieces} == {("L", "E1")}


def test_a_tighter_tolerance_takes_more_pieces():
    counts = [len(fit_curve(ellipse(100, 50), t).pieces) for t in (1.0, 0.1, 0.01)]
    assert counts == sorted(counts)
    assert counts[0] < 20 < counts[2] < 120


def test_a_circle_given_as_a_curve_comes_back_as_two_arcs():
    pieces = fit_curve(ellipse(40, 40), 0.05).pieces
    assert len(pieces) == 2
    assert all(isinstance(p, Arc) and abs(p.radius - 40) < 1e-4 for p in pieces)


@pytest.mark.parametrize(
    "curve",
    [
        bezier([(0, 0, 0), (1, 2, 3), (2, 4, 6), (30, 60, 90)]),
        FreeCurve(lambda t: np.c_[100 * t**2, 50 * t**2, 0 * t]),
    ],
)
def test_a_straight_curve_is_one_exact_line(curve):
    (line,) = fit_curve(curve, 0.05).pieces
    assert isinstance(line, Line)
    assert (line.start, line.end) == (curve.start, curve.end)


def test_straight_parts_between_breaks_are_exact_lines_with_their_corner():
    def square(t):
        corners = np.array([(0, 0, 0), (9, 0, 0), (9, 9, 0), (0, 9, 0), (0, 0, 0)], float)
        return np.stack([np.interp(t * 4, range(5), corners[:, i]) for i in range(3)], axis=1)

    result = fit_curve(FreeCurve(square, True, breaks=(0, 0.25, 0.5, 0.75, 1)), 0.05)
    assert [type(p) for p in result.pieces] == [Line] * 4
    assert [p.start for p in result.pieces] == [(0, 0, 0), (9, 0, 0), (9, 9, 0), (0, 9, 0)]


def test_a_corner_without_a_break_stays_within_the_tolerance():
    corner = FreeCurve(lambda t: np.c_[np.where(t < 0.37, t, 0.74 - t) * 99, t * 99, 0 * t])
    check(corner, 0.05, 6000)


def test_a_fast_wiggle_is_not_overlooked():
    wiggle = FreeCurve(lambda t: np.c_[200 * t, np.sin(2 * np.pi * 64 * t), 0 * t])
    result = check(wiggle, 0.05, 2000)
    assert sum(p.length for p in result.pieces) > 300


def test_a_helix():
    check(FreeCurve(lambda t: np.c_[50 * np.cos(9 * t), 50 * np.sin(9 * t), 30 * t]), 0.02)


def test_a_cusp():
    check(FreeCurve(lambda t: np.c_[(t - 0.4) ** 2 * 99, (t - 0.4) ** 3 * 99, 0 * t]), 0.05)


@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_a_curve_that_is_no_number_somewhere_is_not_within(bad):
    result = fit_curve(FreeCurve(lambda t: np.c_[t, np.where(t > 0.5, bad, t), 0 * t]), 0.05)
    assert not result.within
    assert result.pieces == ()
