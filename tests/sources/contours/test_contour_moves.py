"""Contours as rows of a path: lines, and arcs that controllers accept."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from assistant.program.motion import Kind
from assistant.sources.contours.chains import Contour, chain_curves
from assistant.sources.contours.curves import Arc, FreeCurve, Line
from assistant.sources.contours.moves import contour_moves
from tests.examples import drawn


def rows(*curves, tolerance=0.05, closed=False, **options):
    return contour_moves(Contour(curves, closed), tolerance, **options)


def arc(radius, sweep):
    return Arc.about((0, 0, 0), (0, 0, 1), (radius, 0, 0), sweep)


def driven(made):
    """The arcs and lines that a controller drives."""
    here, pieces = made.start, []
    kinds = made.kinds.tolist()
    for i, kind in enumerate(kinds):
        if kind == Kind.LINEAR:
            pieces.append(Line(tuple(here), tuple(made.positions[i])))
        elif kind == Kind.END:
            pieces.append(Arc.through(here, made.positions[i - 1], made.positions[i]))
        if kind != Kind.VIA:
            here = made.positions[i]
    return pieces


def test_an_arc_is_a_via_and_an_end():
    made = rows(arc(10, 90))
    assert made.kinds.tolist() == [Kind.VIA, Kind.END]
    assert np.allclose(made.positions[1], (0, 10, 0))
    assert np.allclose(made.leaving, [(0, 1, 0), (-math.sqrt(0.5), math.sqrt(0.5), 0)])
    assert np.allclose(made.arriving[1], (-1, 0, 0))


def test_a_full_circle_is_two_arcs():
    made = rows(arc(10, 360), closed=True)
    assert made.kinds.tolist() == [Kind.VIA, Kind.END] * 2
    assert np.allclose(made.positions, [(0, 10, 0), (-10, 0, 0), (0, -10, 0), (10, 0, 0)])
    assert tuple(made.positions[-1]) == tuple(made.start)


@pytest.mark.parametrize(("sweep", "arcs"), [(240, 1), (241, 2), (300, 2), (359, 2)])
def test_wide_arcs_are_split(sweep, arcs):
    assert len(rows(arc(10, sweep))) == 2 * arcs


def test_a_narrower_limit_can_be_asked_for():
    assert len(rows(arc(10, 360), closed=True, widest=120.0)) == 6


@settings(max_examples=drawn(200), deadline=None)
@given(
    st.floats(0.001, 2000),
    st.floats(0.01, 359.9) | st.just(360.0),
    st.sampled_from([0.005, 0.05, 0.5]),
)
def test_every_arc_becomes_moves_a_controller_takes_and_stays_near(radius, sweep, tolerance):
    curve = arc(radius, sweep)
    if curve.length < 1e-3:
        return
    made = rows(curve, tolerance=tolerance, closed=curve.closed)
    pieces = driven(made)
    for piece in pieces:
        assert piece is not None
        if isinstance(piece, Arc):
            assert piece.sweep <= 240.001
            assert math.dist(piece.start, piece.via) >= 0.0999
            assert math.dist(piece.start, piece.end) >= 0.0999
            to_via, to_end = (np.subtract(p, piece.start) for p in (piece.via, piece.end))
            apart = np.arctan2(np.linalg.norm(np.cross(to_via, to_end)), to_via @ to_end)
            assert math.degrees(apart) >= 1.0
        else:
            assert piece.start != piece.end
    points = np.concatenate([p.at(np.linspace(0, 1, 50)) for p in pieces])
    if len(pieces) > 1 or isinstance(pieces[0], Arc):
        assert abs(np.linalg.norm(points, axis=1) - radius).max() <= 0.41 * tolerance + 1e-6
    if sweep < 360:
        assert math.dist(made.positions[-1], curve.end) < 1e-9


def test_a_flat_arc_is_a_line():
    made = rows(arc(1000, 0.5))  # 8.7 mm long, 0.0095 mm high
    assert made.kinds.tolist() == [Kind.LINEAR]


def test_a_tiny_circle_is_a_polygon_within_the_tolerance():
    made = rows(arc(0.04, 360), tolerance=0.01, closed=True)
    assert set(made.kinds.tolist()) == {Kind.LINEAR}
    assert len(made) >= 4


def test_gaps_are_gone_and_closed_contours_close():
    pieces = [
        Line((0, 0, 0), (10, 0, 0)),
        Arc.about((10, 5, 0), (0, 0, 1), (10.0, 0.02, 0), 180.0),
        Line((10.01, 10, 0), (0.03, 0, 0)),
    ]
    contours, _ = chain_curves(pieces, 0.05)
    made = contour_moves(contours[0], 0.05)
    assert contours[0].closed
    assert np.array_equal(made.positions[-1], made.start)
    assert made.kinds.tolist() == [Kind.LINEAR, Kind.VIA, Kind.END, Kind.LINEAR]
    assert driven(made)[1].radius == pytest.approx(5, abs=0.05)


def test_free_curves_report_their_deviation():
    ellipse = FreeCurve(
        lambda t: np.c_[90 * np.cos(2 * np.pi * t), 40 * np.sin(2 * np.pi * t), 0 * t], True
    )
    made = rows(ellipse, closed=True)
    assert (made.fitted, made.within) == (1, True)
    assert 0 < made.deviation <= 0.025
    assert np.array_equal(made.positions[-1], made.start)
    scaled = made.positions[made.kinds != Kind.VIA] / (90, 40, 1)
    assert np.allclose(np.linalg.norm(scaled, axis=1), 1, atol=0.001)


def test_directions_are_unit_and_meet_the_pieces():
    made = rows(Line((0, 0, 0), (10, 0, 0)), Line((10, 0, 0), (10, 5, 0)))
    assert made.leaving.tolist() == made.arriving.tolist() == [[1, 0, 0], [0, 1, 0]]
