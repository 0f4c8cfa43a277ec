"""Ordering: nothing lost, nothing longer, the same each time."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from assistant.sources.contours.chains import Contour
from assistant.sources.contours.contour_order import (
    TravelMeasure,
    order_contours,
    order_points,
    travel_length,
)
from assistant.sources.contours.curves import Arc, Line, vector
from tests.examples import drawn


def line(a, b):
    return Contour((Line(tuple(map(float, a)), tuple(map(float, b))),), False, "L")


def ring(*points):
    corners = [*points, points[0]]
    return Contour(tuple(Line(a, b) for a, b in itertools.pairwise(corners)), True, "L")


def circle(centre, radius=3.0):
    start = np.add(centre, (radius, 0, 0))
    return Contour((Arc.about(centre, (0, 0, 1), start, 360.0),), True, "L")


@st.composite
def contours(draw):
    random = np.random.default_rng(draw(st.integers(0, 2**32)))
    made = []
    for _ in range(draw(st.integers(0, 40))):
        p = vector(random.uniform(0, 500, 3))
        kind = draw(st.integers(0, 2))
        if kind == 0:
            made.append(line(p, random.uniform(0, 500, 3)))
        elif kind == 1:
            made.append(circle(p))
        else:
            made.append(ring(p, *(vector(random.uniform(0, 500, 3)) for _ in range(3))))
    return made


def identity(contour):
    """What stays the same however a contour is turned."""
    curve = contour.curves[0]
    if isinstance(curve, Arc):
        return ("circle", tuple(np.round(curve.centre, 6)))
    sides = {frozenset((c.start, c.end)) for c in contour.curves}
    return ("lines", contour.closed, tuple(sorted(map(tuple, map(sorted, sides)))))


@settings(max_examples=drawn(80), deadline=None)
@given(contours())
def test_never_longer_and_nothing_lost(given_):
    result = order_contours(given_)
    assert sorted(map(identity, result.contours)) == sorted(map(identity, given_))
    assert result.before == pytest.approx(travel_length(given_))
    assert result.after == pytest.approx(travel_length(result.contours))
    assert result.after <= result.before
    assert order_contours(given_) == result


@settings(max_examples=drawn(30), deadline=None)
@given(contours())
def test_closed_contours_keep_their_direction(given_):
    def sides(contour):
        return {(c.start, c.end) for c in contour.curves}

    before = [sides(c) for c in given_ if c.closed and len(c.curves) > 1]
    after = [sides(c) for c in order_contours(given_).contours if c.closed and len(c.curves) > 1]
    assert sorted(map(sorted, before)) == sorted(map(sorted, after))


def test_lines_that_follow_each_other_are_met_end_to_end():
    parts = [line((i * 10, 0, 0), (i * 10 + 9, 0, 0)) for i in range(30)]
    mixed = [c.reversed() if i % 3 else c for i, c in enumerate(parts)]
    np.random.default_rng(3).shuffle(mixed)
    result = order_contours(mixed)
    assert result.after == pytest.approx(29.0)


def test_a_closed_contour_starts_where_the_tool_comes_from():
    square = ring((100.0, 0.0, 0.0), (90.0, 0.0, 0.0), (90.0, 10.0, 0.0), (100.0, 10.0, 0.0))
    result = order_contours([line((0, 0, 0), (80, 0, 0)), square])
    assert result.after == pytest.approx(10.0)


@pytest.mark.parametrize("seed", range(5))
def test_small_tours_are_near_the_best_there_is(seed):
    random = np.random.default_rng(seed)
    parts = [line(*random.uniform(0, 100, (2, 3))) for _ in range(5)]
    best = math.inf
    for order in itertools.permutations(range(5)):
        for turns in itertools.product((False, True), repeat=5):
            chosen = [
                parts[i].reversed() if t else parts[i] for i, t in zip(order, turns, strict=False)
            ]
            length = 0.0
            for one, two in itertools.pairwise(chosen):
                length += math.dist(one.end, two.start)
                if length >= best:
                    break
            best = min(best, length)
    assert order_contours(parts).after <= best * 1.25 + 1e-9


@pytest.mark.slow
def test_many_contours_are_ordered_well():
    random = np.random.default_rng(7)
    parts = [circle(vector(p), 0.1) for p in random.uniform(0, 1000, (2500, 3)) * (1, 1, 0)]
    result = order_contours(parts)
    assert len(result.contours) == 2500
    assert result.after < 1.0 * math.sqrt(2500 * 1e6)  # a random tour of the best is 0.71


def test_contours_all_in_one_place():
    parts = [circle((0.0, 0.0, 0.0))] * 50
    assert order_contours(parts).after == pytest.approx(0.0)


def test_none_and_one():
    assert order_contours([]).contours == ()
    one = [circle((0.0, 0.0, 0.0))]
    assert order_contours(one).contours == tuple(one)


def stretched(points):
    """Seconds of an arm that is 20 times as slow along y."""
    return points * (1.0, 20.0, 1.0)


def largest(one, other):
    return max(abs(a - b) for a, b in zip(one, other, strict=True))


SLOW_ALONG_Y = TravelMeasure(stretched, largest)


@pytest.mark.parametrize("seed", range(3))
def test_travel_is_kept_short_by_what_it_is_measured_by(seed):
    random = np.random.default_rng(seed)
    points = random.uniform(0, 100, (7, 3))
    parts = [circle(tuple(p), 0.001) for p in points]
    places = stretched(points)

    def along(order):
        return sum(largest(places[a], places[b]) for a, b in itertools.pairwise(order))

    best = min(map(along, itertools.permutations(range(7))))
    result = order_contours(parts, (), SLOW_ALONG_Y)
    assert result.measured
    assert result.after <= best * 1.25 + 0.5
    by_length = [tuple(np.round(c.curves[0].centre, 6)) for c in order_contours(parts).contours]
    rows = [[tuple(np.round(p, 6)) for p in points].index(c) for c in by_length]
    assert result.after < along(rows)
    visits = order_points(points, SLOW_ALONG_Y)
    assert sorted(visits.rows) == list(range(7))
    assert visits.after == pytest.approx(along(visits.rows))
    assert best - 1e-9 <= visits.after <= min(best * 1.25, visits.before) + 1e-9


def test_mm_count_where_nothing_else_is_known():
    parts = [circle((0.0, 0.0, 0.0)), circle((90.0, 0.0, 0.0)), circle((30.0, 0.0, 0.0))]
    result = order_contours(parts, (), TravelMeasure(lambda points: None, largest))
    assert not result.measured
    assert result == order_contours(parts)
