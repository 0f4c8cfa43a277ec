"""Nesting: what lies inside a closed contour comes before it."""

import itertools
import math

import ezdxf
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from assistant import sources
from assistant.sources.contours.chains import Contour
from assistant.sources.contours.contour_order import holders, order_contours, travel_length
from assistant.sources.contours.curves import Arc, FreeCurve, Line
from tests.examples import drawn
from tests.sources.contours.whole import whole_paths

DOWN = (0.0, 0.0, -1.0)


def circle(x, y, radius):
    return Contour((Arc.about((x, y, 0), (0, 0, 1), (x + radius, y, 0), 360.0),), True, "L")


def ring(*points):
    return Contour(
        tuple(Line(a, b) for a, b in itertools.pairwise([*points, points[0]])), True, "L"
    )


def square(x, y, size, z=0.0):
    half = size / 2
    corners = ((-half, -half), (half, -half), (half, half), (-half, half))
    return ring(*((x + a, y + b, z) for a, b in corners))


@st.composite
def circles(draw):
    """Circles that do not cross, and for each those that are around it."""
    random = np.random.default_rng(draw(st.integers(0, 2**32)))
    made = []
    for _ in range(draw(st.integers(2, 40))):
        x, y, radius = *random.uniform(0, 200, 2), 10 ** random.uniform(0, 2)
        apart = [math.hypot(x - a, y - b) for a, b, _ in made]
        if all(
            d > radius + r + 1 or d + min(radius, r) + 1 < max(radius, r)
            for d, (*_, r) in zip(apart, made, strict=True)
        ):
            made.append((x, y, radius))
    around = [
        [j for j, (a, b, r) in enumerate(made) if r > radius and math.hypot(x - a, y - b) < r]
        for x, y, radius in made
    ]
    return made, around


@settings(max_examples=drawn(60), deadline=None)
@given(circles())
def test_each_comes_before_all_that_are_around_it(drawn):
    made, around = drawn
    contours = [circle(*c) for c in made]
    found = holders(contours, DOWN, 0.05)
    for mine, others in zip(found, around, strict=True):
        assert mine == (min(others, key=lambda j: made[j][2]) if others else -1)
    result = order_contours(contours, found)
    assert result.after == pytest.approx(travel_length(result.contours))
    centres = [c.curves[0].centre for c in result.contours]
    place = [centres.index(c.curves[0].centre) for c in contours]
    assert sorted(place) == list(range(len(contours)))
    assert all(place[i] < place[j] for i, others in enumerate(around) for j in others)


def test_arcs_count_as_drawn():
    # A slot with a round end of 1 m radius: the hole lies between the arc and its chord.
    bow = Arc.through((0, 0, 0), (1000, -1000, 0), (2000, 0, 0))
    outline = Contour((bow, Line((2000.0, 0.0, 0.0), (0.0, 0.0, 0.0))), True, "L")
    hole, outside = circle(1000, -998.0, 1.5), circle(1000, -1003.0, 1.5)
    assert holders([hole, outline, outside], DOWN, 0.05) == [1, -1, -1]


def test_open_contours_and_free_curves_lie_inside_as_well():
    def wave(t):
        return np.column_stack([40 * np.cos(math.tau * t), 20 * np.sin(math.tau * t), 0 * t])

    ellipse = Contour((FreeCurve(wave, True, "L"),), True, "L")
    slit = Contour((Line((-5.0, 0.0, 0.0), (5.0, 0.0, 0.0)),), False, "L")
    beside = Contour((Line((-35.0, 15.0, 0.0), (-30.0, 19.0, 0.0)),), False, "L")
    assert holders([ellipse, slit, beside], DOWN, 0.05) == [-1, 0, -1]


def test_what_touches_the_outline_from_inside():
    wedge = ring((0.0, -50.0, 0.0), (10.0, 0.0, 0.0), (-10.0, 0.0, 0.0))  # its tip on a side
    assert holders([square(0, 0, 100), wedge], DOWN, 0.05) == [-1, 0]
    assert holders([square(0, 0, 100), square(0, 0, 100)], DOWN, 0.05) == [-1, -1]


def test_a_line_there_and_back_holds_nothing():
    ends = (0.0, 0.0, 0.0), (9.0, 0.0, 0.0)
    flat = Contour((Line(*ends, "L"), Line(*ends[::-1], "L")), True, "L")
    assert holders([flat, flat], DOWN, 0.05) == [-1, -1]
    assert holders([flat, square(0, 0, 100)], DOWN, 0.05) == [1, -1]


def test_it_is_seen_along_the_tool():
    def upright(size):
        corners = ((-size, -size), (size, -size), (size, size), (-size, size))
        return ring(*((0.0, a, b) for a, b in corners))

    assert holders([upright(50.0), upright(5.0)], (1.0, 0.0, 0.0), 0.05) == [-1, 0]


@pytest.mark.slow
def test_parts_in_a_frame():
    contours = [square(1500, 1500, 3200)]
    for x, y in itertools.product(range(30), range(30)):
        contours.append(square(100.0 * x, 100.0 * y, 80))
        contours += [circle(100.0 * x + a, 100.0 * y, 5) for a in (-20, 20)]
    found = holders(contours, DOWN, 0.05)
    assert found[0] == -1
    assert all(i == 0 for i in found[1::3])
    assert found[2::3] == found[3::3] == list(range(1, len(contours), 3))
    result = order_contours(contours, found)
    again = holders(result.contours, DOWN, 0.05)
    assert all(i < holder for i, holder in enumerate(again[:-1]))
    assert result.after < 1.5 * order_contours(contours).after


@pytest.fixture
def panel(tmp_path):
    document = ezdxf.new("R2010", units=4)
    model = document.modelspace()
    model.add_lwpolyline([(0, 0), (200, 0), (200, 100), (0, 100)], close=True)
    model.add_circle((50, 50), 10)
    model.add_circle((150, 50), 10)
    document.saveas(tmp_path / "panel.dxf")
    return tmp_path / "panel.dxf"


def ways(path):
    """The paths of a drawing in the order in which they are followed."""
    program = sources.read(path).program
    return [w for p in program.procedures for w in whole_paths(p, program.targets)]


def test_holes_of_a_drawing_are_cut_first(panel):
    assert [len(p) for p in ways(panel)] == [4, 4, 4]
    round_, another, outline = ways(panel)
    assert np.ptp(round_.positions[:, 0]) == np.ptp(another.positions[:, 0]) == 20.0
    assert np.ptp(outline.positions[:, 0]) == 200.0
    (told,) = (f for f in sources.read(panel).findings if f.code == "CT206")
    assert "inside" in told.message


def test_a_layer_may_say_otherwise(panel):
    process = panel.with_suffix(".process.toml")
    process.write_text('[layers."0"]\ninside_first = false\n')
    assert [np.ptp(p.positions[:, 0]) for p in ways(panel)] != [20.0, 20.0, 200.0]
    (told,) = (f for f in sources.read(panel).findings if f.code == "CT206")
    assert "inside" not in told.message


def test_an_outline_of_many_waves_holds_what_lies_in_its_lobes_only():
    def at(t):
        angle = 2 * np.pi * t
        far = 100 + 40 * np.sin(64 * angle)  # at 64 equal steps it is a circle
        return np.stack([far * np.cos(angle), far * np.sin(angle), 0 * t], axis=1)

    flower = FreeCurve(at, True, "L")
    lobe, gap = (math.pi / 128 * k for k in (1, 3))
    inside, outside = (
        Arc.about((r * math.cos(a), r * math.sin(a), 0), (0, 0, 1),
                  (r * math.cos(a) + 0.5, r * math.sin(a), 0), 360.0, "L")
        for r, a in ((115, lobe), (90, gap))
    )  # fmt: skip
    contours = [Contour((c,), True) for c in (flower, inside, outside)]
    assert holders(contours, (0.0, 0.0, -1.0), 0.05) == [-1, 0, -1]
