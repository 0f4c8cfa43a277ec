"""Chaining: cut, shuffled and turned pieces come back as the contours they were."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from assistant.base.diagnostics import Severity
from assistant.sources.contours.chains import chain_curves
from assistant.sources.contours.curves import Arc, FreeCurve, Line, vector
from tests.examples import drawn


def lines(*points, layer="L"):
    return [Line(a, b, layer, f"{i:X}") for i, (a, b) in enumerate(itertools.pairwise(points), 1)]


def way(contour):
    return [c.start for c in contour.curves] + [contour.curves[-1].end]


def codes(findings):
    return [f.code for f in findings]


@st.composite
def polylines(draw):
    """Polylines whose points are all well apart, some of them closed."""
    count = draw(st.integers(1, 8))
    random = np.random.default_rng(draw(st.integers(0, 2**32)))
    sizes = [draw(st.integers(3, 12)) for _ in range(count)]
    # One grid cell for each point keeps all of them at least 5 mm apart.
    cells = random.permutation(30**3)[: sum(sizes)]
    grid = np.stack(np.unravel_index(cells, (30, 30, 30)), axis=1) * 10.0
    grid += random.uniform(-2.5, 2.5, grid.shape)
    parts = np.split(grid, np.cumsum(sizes)[:-1])
    return [(p, draw(st.booleans())) for p in parts], random


@settings(max_examples=drawn(150), deadline=None)
@given(polylines(), st.sampled_from([0.0, 1e-9, 0.02]))
def test_shuffled_pieces_come_back(given_, noise):
    parts, random = given_
    pieces = []
    for points, closed in parts:
        ring = np.vstack([points, points[:1]]) if closed else points
        for a, b in itertools.pairwise(ring):
            shifted = (vector(p + random.uniform(-noise, noise, 3)) for p in (a, b))
            piece = Line(*shifted, "L")
            pieces.append(piece.reversed() if random.random() < 0.5 else piece)
    order = random.permutation(len(pieces))
    contours, findings = chain_curves([pieces[i] for i in order], 0.1)
    assert len(contours) == len(parts)
    assert {f.code for f in findings} <= {"CT105"}

    def canonical(points, closed):
        ids = [tuple(np.rint(np.asarray(p)).astype(int)) for p in points]
        if not closed:
            return (min(tuple(ids), tuple(ids[::-1])), False)
        turns = [ids[i:] + ids[:i] for i in range(len(ids))]
        turns += [t[::-1] for t in turns]
        return (min(map(tuple, turns)), True)

    if noise < 0.01:
        wanted = sorted(canonical(p, c) for p, c in parts)
        made = sorted(canonical(way(c)[:-1] if c.closed else way(c), c.closed) for c in contours)
        assert made == wanted
    assert sorted(len(c.curves) for c in contours) == sorted(
        len(p) - (not closed) for p, closed in parts
    )
    for contour in contours:
        for one, two in zip(contour.curves, contour.curves[1:], strict=False):
            assert math.dist(one.end, two.start) <= 0.1


def test_curves_of_all_kinds_make_one_closed_contour():
    half = Arc.about((10, 5, 0), (0, 0, 1), (10, 0, 0), 180.0, "L")
    wave = FreeCurve(lambda t: np.c_[10 * t, 10 + np.sin(np.pi * t), 0 * t], layer="L")
    contours, findings = chain_curves([*lines((0, 10, 0), (0, 0, 0), (10, 0, 0)), wave, half], 0.05)
    assert findings == ()
    (contour,) = contours
    assert contour.closed
    assert [type(c).__name__ for c in contour.curves] == ["Line", "Line", "Arc", "FreeCurve"]
    assert contour.length == pytest.approx(20 + 5 * math.pi + wave.length)


def test_layers_are_chained_apart_and_compared_without_case():
    contours, _ = chain_curves(
        [
            Line((0, 0, 0), (1, 0, 0), "Glue"),
            Line((1, 0, 0), (2, 0, 0), "cut"),
            Line((1, 0, 0), (1, 1, 0), "GLUE"),
        ],
        0.05,
    )
    assert [(c.layer, len(c.curves)) for c in contours] == [("Glue", 2), ("cut", 1)]


def test_the_first_curve_keeps_its_direction():
    contours, _ = chain_curves([Line((5, 0, 0), (0, 0, 0)), Line((5, 0, 0), (9, 0, 0))], 0.05)
    assert way(contours[0]) == [(9, 0, 0), (5, 0, 0), (0, 0, 0)]


def test_a_circle_is_a_contour_of_its_own_and_can_start_at_its_quadrants():
    circle = Arc.about((0, 0, 0), (0, 0, 1), (10, 0, 0), 360.0, "L")
    (contour,), _ = chain_curves([circle], 0.05)
    assert contour.closed
    turned = contour.starting_at(1)
    assert turned.start == pytest.approx((0, 10, 0), abs=1e-12)
    assert turned.curves[0].closed
    assert turned.length == pytest.approx(contour.length)


def test_a_junction_splits_the_contours():
    middle = (10, 0, 0)
    spokes = [Line(middle, p, "L") for p in [(20, 0, 0), (0, 0, 0), (10, 10, 0)]]
    contours, findings = chain_curves([*spokes, Line((20, 0, 0), (20, 10, 0), "L")], 0.05)
    assert [len(c.curves) for c in contours] == [2, 1, 1]
    assert codes(findings) == ["CT104"]
    assert findings[0].severity is Severity.INFO
    assert "1 points" in findings[0].message


def test_a_junction_within_the_tolerance_is_one_too():
    contours, findings = chain_curves(
        [
            Line((0, 0, 0), (10, 0, 0)),
            Line((10.01, 0, 0), (20, 0, 0)),
            Line((10, 0.02, 0), (10, 9, 0)),
        ],
        0.05,
    )
    assert len(contours) == 3
    assert codes(findings) == ["CT105", "CT104"]


def test_a_figure_of_eight_is_two_loops():
    eight = lines((0, 0, 0), (5, 5, 0), (5, -5, 0), (0, 0, 0), (-5, 5, 0), (-5, -5, 0), (0, 0, 0))
    contours, findings = chain_curves(eight, 0.05)
    assert [(len(c.curves), c.closed) for c in contours] == [(3, True), (3, True)]
    assert codes(findings) == ["CT104"]


@pytest.mark.parametrize(
    "copy",
    [
        Line((0, 0, 0), (10, 0, 0), "L", "9"),
        Line((10, 0, 0), (0, 0, 0), "L", "9"),
        Line((0, 0.03, 0), (10, 0, 0.01), "L", "9"),
    ],
)
def test_a_line_drawn_again_is_followed_once(copy):
    contours, findings = chain_curves([*lines((0, 0, 0), (10, 0, 0), (10, 9, 0)), copy], 0.05)
    assert [len(c.curves) for c in contours] == [2]
    assert codes(findings) == ["CT103"]
    assert findings[0].place == "entity 9"


def wave(height, *, back=False):
    """Eight half waves; all of them meet the axis in five points at equal distances."""

    def at(t):
        t = 1.0 - t if back else t
        return np.c_[40 * t, height * np.sin(8 * np.pi * t), 0 * t]

    return FreeCurve(at, layer="L", breaks=tuple(k / 8 for k in range(9)))


@pytest.mark.parametrize("other", [wave(-3), wave(3.2), Line((0, 0, 0), (40, 0, 0), "L")])
def test_curves_that_agree_in_five_points_only_are_not_drawn_again(other):
    _, findings = chain_curves([wave(3), other], 0.05)
    assert "CT103" not in codes(findings)


@pytest.mark.parametrize("other", [wave(3), wave(3, back=True), wave(3.01)])
def test_a_free_curve_drawn_again_is_followed_once(other):
    contours, findings = chain_curves([wave(3), other], 0.05)
    assert codes(findings) == ["CT103"]
    assert len(contours) == 1


def test_arcs_and_circles_drawn_again_are_followed_once():
    arc = Arc.about((0, 0, 0), (0, 0, 1), (10, 0, 0), 100.0, "L")
    circle = Arc.about((50, 0, 0), (0, 0, 1), (60, 0, 0), 360.0, "L")
    other = Arc.about((50, 0, 0), (0, 0, -1), (50, 10, 0), 360.0, "L")
    contours, findings = chain_curves([arc, circle, arc.reversed(), other], 0.05)
    assert len(contours) == 2
    assert "2 curves" in findings[0].message


def test_two_arcs_over_one_chord_are_no_copies():
    upper = Arc.about((0, 0, 0), (0, 0, 1), (10, 0, 0), 180.0, "L")
    lower = Arc.about((0, 0, 0), (0, 0, -1), (10, 0, 0), 180.0, "L")
    contours, findings = chain_curves([upper, lower], 0.05)
    assert findings == ()
    assert [(len(c.curves), c.closed) for c in contours] == [(2, True)]


def test_curves_without_length_are_counted():
    dots = [Line((i, 0, 0), (i, 0, 0), "L", "A") for i in range(3)]
    contours, findings = chain_curves([*dots, *lines((0, 0, 0), (1, 0, 0))], 0.05)
    assert len(contours) == 1
    assert codes(findings) == ["CT102"]
    assert "3 curves" in findings[0].message


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf, 1e12])
def test_a_coordinate_that_is_no_place_is_an_error(bad):
    contours, findings = chain_curves([Line((0, 0, 0), (bad, 0, 0), "L", "2B")], 0.05, path="a.dxf")
    assert contours == ()
    (finding,) = findings
    assert (finding.code, finding.severity) == ("CT101", Severity.ERROR)
    assert finding.where() == "a.dxf entity 2B"


def test_segments_shorter_than_the_tolerance_stay():
    t = np.linspace(0, 2 * np.pi, 1001)
    points = [vector(p) for p in np.c_[np.cos(t), np.sin(t), 0 * t]]
    points[-1] = points[0]
    contours, findings = chain_curves(lines(*points), 0.05)
    assert findings == ()
    assert [(len(c.curves), c.closed) for c in contours] == [(1000, True)]


def test_gaps_between_short_segments_are_closed_in_order():
    pieces = [Line((i * 0.02 + 0.001, 0, 0), ((i + 1) * 0.02, 0, 0), "L") for i in range(200)]
    contours, findings = chain_curves(pieces[::-1], 0.05)
    assert [len(c.curves) for c in contours] == [200]
    assert not contours[0].closed
    assert codes(findings) == ["CT105"]
    assert "199 gaps" in findings[0].message


def test_a_short_segment_alone_is_no_loop():
    contours, findings = chain_curves([Line((0, 0, 0), (0.03, 0, 0))], 0.05)
    assert findings == ()
    assert not contours[0].closed


def test_gaps_over_the_tolerance_stay_open():
    contours, findings = chain_curves(
        [Line((0, 0, 0), (5, 0, 0)), Line((5.06, 0, 0), (9, 0, 0))], 0.05
    )
    assert len(contours) == 2
    assert findings == ()


@pytest.mark.slow
def test_a_star_of_ten_thousand_and_a_crowd_of_loose_ends_end_soon():
    turn = np.linspace(0, 2 * np.pi, 10_000, endpoint=False)
    rim = np.c_[np.cos(turn), np.sin(turn), 0 * turn] * 1e4
    star = [Line((0.0, 0.0, 0.0), vector(p), "S") for p in rim]
    random = np.random.default_rng(1)
    crowd = [Line(vector(random.uniform(0, 0.04, 3)), vector(p), "C") for p in rim]
    contours, findings = chain_curves([*star, *crowd], 0.05)
    assert sum(len(c.curves) for c in contours) == 20_000
    assert "CT104" in codes(findings)


def test_chaining_is_deterministic():
    random = np.random.default_rng(5)
    points = [vector(p) for p in random.integers(0, 6, (300, 3)).astype(float)]
    pieces = [Line(a, b) for a, b in itertools.pairwise(points) if a != b]
    assert chain_curves(pieces, 0.05) == chain_curves(pieces, 0.05)
    contours, _ = chain_curves(pieces, 0.05)
    distinct = {frozenset((p.start, p.end)) for p in pieces}
    assert sum(len(c.curves) for c in contours) == len(distinct)


@pytest.mark.parametrize("tolerance", [0.0, -1.0, math.nan, math.inf])
def test_a_bad_tolerance_is_refused(tolerance):
    with pytest.raises(ValueError, match="tolerance"):
        chain_curves([], tolerance)


def test_nothing_gives_nothing():
    assert chain_curves([], 0.05) == ((), ())
