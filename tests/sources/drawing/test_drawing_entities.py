"""Entities as curves in the world, and everything else counted."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import ezdxf
import numpy as np
import pytest
from ezdxf.document import Drawing
from ezdxf.math import BSpline
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from assistant.base.diagnostics import Diagnostic, Refused, Severity
from assistant.program.program import IDENTIFIER
from assistant.sources.contours.curves import Arc, Curve, FreeCurve, Line
from assistant.sources.drawing import read, read_contents
from assistant.sources.drawing.findings import shown
from assistant.sources.process import NO_PROCESS
from tests.examples import drawn
from tests.tables import every_row

Save = Callable[..., Path]

DIAGONAL = math.sqrt(0.5)


def curves(path: Path) -> list[Curve]:
    return list(read_contents(path, NO_PROCESS).curves)


def findings(path: Path, *codes: str) -> list[Diagnostic]:
    return [f for f in read_contents(path, NO_PROCESS).findings if f.code in codes]


def assert_arc(
    curve: Curve, start: tuple[float, ...], via: tuple[float, ...], end: tuple[float, ...]
) -> None:
    assert isinstance(curve, Arc)
    assert curve.start == pytest.approx(start, abs=1e-9)
    assert curve.via == pytest.approx(via, abs=1e-9)
    assert curve.end == pytest.approx(end, abs=1e-9)


def test_line(save: Save, drawing: Drawing) -> None:
    line = drawing.modelspace().add_line((1, 2, 3), (4, 5, 6), dxfattribs={"layer": "CUT"})
    assert curves(save(drawing)) == [Line((1, 2, 3), (4, 5, 6), "CUT", line.dxf.handle)]


def test_line_ignores_its_extrusion(save: Save, drawing: Drawing) -> None:
    drawing.modelspace().add_line((1, 2, 3), (4, 5, 6), dxfattribs={"extrusion": (0, 0, -1)})
    (line,) = curves(save(drawing))
    assert line.start == (1, 2, 3)


@pytest.mark.parametrize(
    ("attributes", "start", "via", "end"),
    [
        ({}, (15, 0, 2), (10 + 5 * DIAGONAL, 5 * DIAGONAL, 2), (10, 5, 2)),
        # Downwards: x and z negated, so that it is clockwise from above.
        (
            {"extrusion": (0, 0, -1)},
            (-15, 0, -2),
            (-10 - 5 * DIAGONAL, 5 * DIAGONAL, -2),
            (-10, 5, -2),
        ),
        # Along x: (x, y, z) → (z, x, y).
        (
            {"extrusion": (1, 0, 0)},
            (2, 15, 0),
            (2, 10 + 5 * DIAGONAL, 5 * DIAGONAL),
            (2, 10, 5),
        ),
    ],
)
def test_arc(
    save: Save,
    drawing: Drawing,
    attributes: dict[str, Any],
    start: tuple[float, ...],
    via: tuple[float, ...],
    end: tuple[float, ...],
) -> None:
    drawing.modelspace().add_arc((10, 0, 2), 5, 0, 90, dxfattribs=attributes)
    (arc,) = curves(save(drawing))
    assert_arc(arc, start, via, end)


def test_arc_over_zero_degrees(save: Save, drawing: Drawing) -> None:
    drawing.modelspace().add_arc((0, 0), 10, 315, 45)
    (arc,) = curves(save(drawing))
    half = 10 * DIAGONAL
    assert_arc(arc, (half, -half, 0), (10, 0, 0), (half, half, 0))


def test_arc_all_around_is_a_circle(save: Save, drawing: Drawing) -> None:
    drawing.modelspace().add_arc((0, 0), 10, 0, 360)
    (circle,) = curves(save(drawing))
    assert isinstance(circle, Arc)
    assert circle.closed


def test_circle(save: Save, drawing: Drawing) -> None:
    drawing.modelspace().add_circle((1, 2, 3), 4)
    (circle,) = curves(save(drawing))
    assert isinstance(circle, Arc)
    assert (circle.closed, circle.centre, circle.radius) == (True, (1, 2, 3), 4.0)
    assert_arc(circle, (5, 2, 3), (-3, 2, 3), (5, 2, 3))


def test_ellipse(save: Save, drawing: Drawing) -> None:
    drawing.modelspace().add_ellipse((1, 2, 3), major_axis=(0, 10, 0), ratio=0.5)
    (ellipse,) = curves(save(drawing))
    assert isinstance(ellipse, FreeCurve)
    assert ellipse.closed
    at = ellipse.at([0, 0.25, 0.5, 1])
    assert np.allclose(at, [(1, 12, 3), (-4, 2, 3), (1, -8, 3), (1, 12, 3)], atol=1e-12)


def test_part_of_an_ellipse_downwards(save: Save, drawing: Drawing) -> None:
    drawing.modelspace().add_ellipse(
        (0, 0, 1), (10, 0, 0), 0.5, 0, math.pi / 2, dxfattribs={"extrusion": (0, 0, -1)}
    )
    (ellipse,) = curves(save(drawing))
    assert isinstance(ellipse, FreeCurve)
    assert not ellipse.closed
    # The minor axis is extrusion × major axis: (0, -5, 0). Centre and axis are world's.
    assert np.allclose(ellipse.at([0, 1]), [(10, 0, 1), (0, -5, 1)], atol=1e-12)


def test_ellipse_of_ratio_one_is_an_arc(save: Save, drawing: Drawing) -> None:
    drawing.modelspace().add_ellipse((0, 0), (10, 0), 1.0, math.pi, 1.5 * math.pi)
    (arc,) = curves(save(drawing))
    assert_arc(arc, (-10, 0, 0), (-10 * DIAGONAL, -10 * DIAGONAL, 0), (0, -10, 0))


def test_lwpolyline(save: Save, drawing: Drawing) -> None:
    corners = [(0, 0, 0), (10, 0, 1), (10, 10, 0), (10, 10, 0), (0, 10, -math.tan(math.pi / 8))]
    drawing.modelspace().add_lwpolyline(
        corners, format="xyb", close=True, dxfattribs={"elevation": 4}
    )
    line, arc, top, corner = curves(save(drawing))
    assert line == Line((0, 0, 4), (10, 0, 4), line.layer, line.handle)
    assert_arc(arc, (10, 0, 4), (15, 5, 4), (10, 10, 4))  # to the left: a half circle outside
    assert top == Line((10, 10, 4), (0, 10, 4), line.layer, line.handle)
    # A quarter to the right from (0, 10) to (0, 0): centre (-5, 5) + ... is at (5, 5)·(-1, 1).
    radius = 5 * math.sqrt(2)
    assert_arc(corner, (0, 10, 4), (-5 + radius, 5, 4), (0, 0, 4))


def test_lwpolyline_downwards(save: Save, drawing: Drawing) -> None:
    drawing.modelspace().add_lwpolyline(
        [(0, 0, 1), (10, 0, 0)],
        format="xyb",
        dxfattribs={"elevation": 4, "extrusion": (0, 0, -1)},
    )
    (arc,) = curves(save(drawing))
    assert_arc(arc, (0, 0, -4), (-5, -5, -4), (-10, 0, -4))


@pytest.mark.parametrize("bulge", [1e-7, -3e-8, 1e-9, 1e-12])
def test_a_bulge_that_is_noise_is_straight(save: Save, drawing: Drawing, bulge: float) -> None:
    rows = [(0, 0, bulge), (30, 0, 0), (30, 20, bulge), (0, 20, 0)]
    drawing.modelspace().add_lwpolyline(rows, format="xyb", close=True)
    path = save(drawing)
    found = curves(path)
    assert all(isinstance(one, Line) for one in found) and not findings(path, "DX205")
    ends = [(0, 0, 0), (30, 0, 0), (30, 20, 0), (0, 20, 0)]
    assert [one.start for one in found] == [pytest.approx(end, abs=1e-5) for end in ends]


def test_an_arc_around_a_place_far_away_is_straight(save: Save, drawing: Drawing) -> None:
    radius = 1e8
    turn = math.degrees(30.0 / radius)
    drawing.modelspace().add_arc((-radius, 0), radius, 0.0, turn)
    (found,) = curves(save(drawing))
    assert isinstance(found, Line)
    assert found.start == pytest.approx((0, 0, 0), abs=1e-5)
    assert found.end == pytest.approx((0, 30, 0), abs=1e-5)


def test_an_arc_around_a_place_far_away_that_is_not_straight_is_refused(
    save: Save, drawing: Drawing
) -> None:
    drawing.modelspace().add_arc((-1e8, 0), 1e8, 0.0, math.degrees(3e4 / 1e8))
    assert len(findings(save(drawing), "DX205")) == 1


@pytest.mark.parametrize("close", [False, True])
def test_old_polylines(save: Save, drawing: Drawing, close: bool) -> None:
    model = drawing.modelspace()
    model.add_polyline2d(
        [(0, 0, 0, 0, 1), (10, 0)],
        format="xyseb",
        close=close,
        dxfattribs={"elevation": (0, 0, 3)},
    )
    model.add_polyline3d([(0, 0, 0), (1, 2, 3), (4, 5, 6)], close=close)
    found = curves(save(drawing))
    assert len(found) == (5 if close else 3)
    assert_arc(found[0], (0, 0, 3), (5, -5, 3), (10, 0, 3))
    places = [c.start for c in found if c.handle != found[0].handle]
    assert places == [(0, 0, 0), (1, 2, 3), (4, 5, 6)][: len(places)]
    assert found[-1].end == ((0, 0, 0) if close else (4, 5, 6))


def test_smoothed_polyline_leaves_its_frame_out(save: Save, drawing: Drawing) -> None:
    polyline = drawing.modelspace().add_polyline3d([(0, 0), (5, 9), (10, 0), (5, 4)])
    for i, vertex in enumerate(polyline.vertices):
        vertex.dxf.flags |= 16 if i == 1 else 8
    found = curves(save(drawing))
    assert [c.start for c in found] == [(0, 0, 0), (10, 0, 0)]


@settings(
    max_examples=drawn(40),
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
@given(
    points=st.lists(
        st.tuples(*[st.floats(-100, 100).map(lambda v: round(v, 2))] * 3),
        min_size=5,
        max_size=9,
        unique=True,
    ),
    degree=st.integers(1, 4),
    weighted=st.booleans(),
    uniform=st.booleans(),
)
def test_splines_against_ezdxf(
    save: Save,
    points: list[tuple[float, float, float]],
    degree: int,
    weighted: bool,
    uniform: bool,
) -> None:
    import ezdxf

    document = ezdxf.new("R2010", units=4)
    count = len(points)
    weights = [1.0 + (i % 3) for i in range(count)] if weighted else None
    knots = [float(i) for i in range(count + degree + 1)] if uniform else None
    oracle = BSpline(points, degree + 1, knots, weights)
    spline = document.modelspace().add_spline(degree=degree)
    spline.control_points = points
    spline.knots = oracle.knots()
    if weights:
        spline.weights = weights
    (curve,) = curves(save(document))
    assert isinstance(curve, FreeCurve)
    low, high = oracle.knots()[degree], oracle.knots()[count]
    t = np.linspace(0, 1, 33)
    inside = np.clip(low + t * (high - low), low, high - 1e-12 * high)
    expected = np.array([oracle.point(float(v)).xyz for v in inside])
    assert np.abs(curve.at(t) - expected).max() < 1e-6
    assert (curve.breaks[0], curve.breaks[-1]) == (0.0, 1.0)
    assert list(curve.breaks) == sorted(set(curve.breaks))


def test_spline_through_fit_points(save: Save, drawing: Drawing) -> None:
    fit = [(0, 0, 1), (10, 8, 2), (25, -3, 0), (30, 5, 5)]
    spline = drawing.modelspace().add_spline(fit)
    spline.dxf.start_tangent = (1, 0, 0)
    spline.dxf.end_tangent = (0, 1, 0)
    (curve,) = curves(save(drawing))
    dense = curve.at(np.linspace(0, 1, 20001))
    for point in fit:
        assert np.linalg.norm(dense - point, axis=1).min() < 0.01
    assert (curve.start, curve.end) == (pytest.approx(fit[0]), pytest.approx(fit[-1]))
    first = dense[1] - dense[0]
    last = dense[-1] - dense[-2]
    assert first / np.linalg.norm(first) == pytest.approx((1, 0, 0), abs=1e-3)
    assert last / np.linalg.norm(last) == pytest.approx((0, 1, 0), abs=1e-3)


def test_closed_spline_through_fit_points(save: Save, drawing: Drawing) -> None:
    drawing.modelspace().add_spline([(0, 0), (10, 0), (10, 10)]).closed = True
    (curve,) = curves(save(drawing))
    assert np.allclose(curve.at([0, 1]), 0, atol=1e-9)


def test_spline_through_two_points_is_straight(save: Save, drawing: Drawing) -> None:
    drawing.modelspace().add_spline([(0, 0, 1), (10, 0, 1)])
    (line,) = curves(save(drawing))
    assert isinstance(line, Line)


@pytest.mark.parametrize(
    ("knots", "weights"),
    [
        ([0, 0, 0, 1, 1], []),
        ([0, 0, 0, 0, 1, 1, 0.5, 1], []),
        ([0] * 8, []),
        ([0, 0, 0, 0, 1, 1, 1, 1], [1, 1, 1]),
        ([0, 0, 0, 0, 1, 1, 1, 1], [1, 1, 0, 1]),
        ([0, 0, 0, 0, 1, 1, 1, 1], [1, 1, -1, 1]),
    ],
)
def test_broken_splines(
    save: Save, drawing: Drawing, knots: list[float], weights: list[float]
) -> None:
    spline = drawing.modelspace().add_spline()
    spline.control_points = [(0, 0), (1, 2), (3, 4), (5, 0)]
    spline.knots = knots
    spline.weights = weights
    with pytest.raises(Refused) as caught:
        read(save(drawing), NO_PROCESS)
    (error,) = [f for f in caught.value.findings if f.severity is Severity.ERROR]
    assert (error.code, error.place) == ("DX205", f"SPLINE #{spline.dxf.handle}")


@every_row("value", ["nan", "inf", "1e300", "-1e12"])
@every_row("kind", ["LINE", "CIRCLE", "LWPOLYLINE", "POINT", "ELLIPSE", "SPLINE", "INSERT"])
def test_coordinates_that_are_no_place(save: Save, kind: str, value: str) -> None:
    drawing = ezdxf.new("R2010", units=4)
    model = drawing.modelspace()
    drawing.blocks.new("DOT").add_line((0, 0), (1, 0))
    {
        "LINE": lambda: model.add_line((0, 7.125), (1, 1)),
        "CIRCLE": lambda: model.add_circle((0, 7.125), 1),
        "LWPOLYLINE": lambda: model.add_lwpolyline([(0, 7.125, 0.3), (1, 1, 0)], format="xyb"),
        "POINT": lambda: model.add_point((0, 7.125)),
        "ELLIPSE": lambda: model.add_ellipse((0, 7.125), (1, 0), 0.5),
        "SPLINE": lambda: model.add_spline([(0, 7.125), (1, 1), (2, 5)]),
        "INSERT": lambda: model.add_blockref("DOT", (0, 7.125)),
    }[kind]()
    path = save(drawing)
    path.write_text(path.read_text().replace("7.125", value, 1))
    with pytest.raises(Refused) as caught:
        read(path, NO_PROCESS)
    (error,) = [f for f in caught.value.findings if f.severity is Severity.ERROR]
    assert (error.code, (error.place or "").split()[0]) == ("DX205", kind)


def test_what_has_no_length_is_counted(save: Save, drawing: Drawing) -> None:
    model = drawing.modelspace()
    model.add_line((1, 1), (1, 1))
    model.add_line((2, 1), (2, 1))
    model.add_circle((0, 0), 0)
    model.add_arc((0, 0), 5, 30, 30)
    model.add_lwpolyline([(0, 0), (0, 0)])
    path = save(drawing)
    assert curves(path) == []
    told = findings(path, "DX203")
    assert [(f.message.split()[0], f.message.split()[1]) for f in told] == [
        ("2", "LINE"), ("1", "CIRCLE"), ("1", "ARC"), ("1", "LWPOLYLINE"),
    ]  # fmt: skip


def test_width_and_thickness_are_counted(save: Save, drawing: Drawing) -> None:
    model = drawing.modelspace()
    model.add_lwpolyline([(0, 0, 1, 1), (9, 0, 1, 1)], format="xyse")
    model.add_line((0, 0), (1, 1), dxfattribs={"thickness": 5})
    path = save(drawing)
    assert len(curves(path)) == 2
    assert [f.message.split(" of ")[0] for f in findings(path, "DX204")] == ["width", "thickness"]


def test_unused_entities_are_counted_by_type_and_layer(save: Save, drawing: Drawing) -> None:
    model = drawing.modelspace()
    model.add_line((0, 0), (1, 1))
    for layer in ("A", "A", "B"):
        model.add_3dface([(0, 0), (1, 0), (1, 1)], dxfattribs={"layer": layer})
    model.add_text("hello")
    model.add_polyface().append_faces([[(0, 0, 0), (1, 0, 0), (1, 1, 0)]])
    told = findings(save(drawing), "DX201", "DX202")
    assert [f.message.split(" cannot")[0].split(" left")[0] for f in told] == [
        "2 3DFACE on layer `A`",
        "1 3DFACE on layer `B`",
        "1 TEXT on layer `0`",
        "1 POLYLINE on layer `0`",
    ]
    assert [f.severity for f in told] == ["warning", "warning", "info", "warning"]


@pytest.mark.parametrize("where", ["model", "block"])
def test_unknown_types_are_counted_too(save: Save, drawing: Drawing, where: str) -> None:
    block = drawing.blocks.new("B")
    layout = drawing.modelspace() if where == "model" else block
    layout.add_ray((0, 0), (1, 0), dxfattribs={"layer": "NEW"})
    drawing.modelspace().add_blockref("B", (0, 0))
    path = save(drawing)
    path.write_text(path.read_text().replace("\nRAY\n", "\nSUPERCURVE\n"))
    (told,) = findings(path, "DX201")
    assert told.message.startswith("1 SUPERCURVE on layer `NEW`")


@pytest.mark.parametrize(
    ("kind", "group", "name"),
    [
        ("LINE", " 11\n4.5\n 21\n0.0\n 31\n0.0\n", "end"),
        ("CIRCLE", " 40\n4.5\n", "radius"),
        ("POINT", " 10\n4.5\n 20\n0.0\n 30\n0.0\n", "location"),
        ("INSERT", " 10\n4.5\n 20\n0.0\n 30\n0.0\n", "insert"),
    ],
)
def test_what_is_not_stated_is_not_made_up(
    save: Save, drawing: Drawing, kind: str, group: str, name: str
) -> None:
    model = drawing.modelspace()
    drawing.blocks.new("B").add_line((0, 0), (1, 1))
    {
        "LINE": lambda: model.add_line((1, 1), (4.5, 0)),
        "CIRCLE": lambda: model.add_circle((1, 1), 4.5),
        "POINT": lambda: model.add_point((4.5, 0)),
        "INSERT": lambda: model.add_blockref("B", (4.5, 0)),
    }[kind]()
    path = save(drawing)
    text = path.read_text()
    assert group in text
    path.write_text(text.replace(group, ""))
    with pytest.raises(Refused) as caught:
        read(path, NO_PROCESS)
    (error,) = [f for f in caught.value.findings if f.severity is Severity.ERROR]
    assert error.code == "DX205"
    assert name in error.message


def test_hidden_layers_and_paper_space(save: Save, drawing: Drawing) -> None:
    for name in ("FROZEN", "OFF", "ON"):
        drawing.layers.add(name)
    drawing.layers.get("FROZEN").freeze()
    drawing.layers.get("OFF").off()
    model = drawing.modelspace()
    for layer in ("frozen", "OFF", "ON", "NOT_IN_TABLE", "Defpoints"):
        model.add_line((0, 0), (1, 1), dxfattribs={"layer": layer})
    model.add_line((0, 0), (2, 2), dxfattribs={"invisible": 1})
    block = drawing.blocks.new("B")
    block.add_line((5, 5), (6, 6))
    block.add_line((7, 7), (8, 8), dxfattribs={"layer": "ON"})
    model.add_blockref("B", (0, 0), dxfattribs={"layer": "FROZEN"})
    model.add_blockref("B", (0, 0), dxfattribs={"layer": "OFF"})
    drawing.layout("Layout1").add_circle((0, 0), 1)
    path = save(drawing)
    assert [(c.layer, c.start[0]) for c in curves(path)] == [
        ("ON", 0), ("NOT_IN_TABLE", 0), ("ON", 7),
    ]  # fmt: skip
    told = [
        (f.message.split(" left")[0], f.message.split(": ")[1]) for f in findings(path, "DX202")
    ]
    assert told == [
        ("1 LINE on layer `frozen`", "the layer is frozen"),
        ("2 LINE on layer `OFF`", "the layer is off"),
        ("1 LINE on layer `Defpoints`", "construction points of dimensions"),
        ("1 LINE on layer `0`", "it is invisible"),
        ("1 INSERT on layer `FROZEN`", "the layer is frozen"),
        ("1 CIRCLE on layer `0`", "it is in the paper space `Layout1`"),
    ]


@pytest.mark.parametrize(
    "layer",
    ['a"b', "a\\Pb", "a;b", "100%", "{x}", "a'b ü", "%%d{0}", "a\\U+000Ab", "x*y", "a<|>b", "a^Jb"],
)
def test_hostile_layer_names(save: Save, drawing: Drawing, layer: str) -> None:
    model = drawing.modelspace()
    model.add_text("x", dxfattribs={"layer": "HOSTILE"})
    model.add_point((1, 2), dxfattribs={"layer": "HOSTILE"})
    path = save(drawing)
    path.write_text(path.read_text("utf-8").replace("HOSTILE", layer), "utf-8")
    reading = read(path, NO_PROCESS)
    (target,) = reading.program.targets
    assert IDENTIFIER.fullmatch(target)
    assert any(f.code == "NM001" and f"`{target[:-2]}`" in f.message for f in reading.findings)
    assert all(f.message.isprintable() and f.where().isprintable() for f in reading.findings)


def test_shown_text_is_one_printable_line() -> None:
    assert shown("a\nb\x1b[31m\u2028\udc80") == "a\\nb\\x1b[31m\\u2028\\udc80"
    assert len(shown("x" * 500)) == 80


def test_nothing_to_do(save: Save, drawing: Drawing) -> None:
    drawing.modelspace().add_text("nothing")
    with pytest.raises(Refused) as caught:
        read(save(drawing), NO_PROCESS)
    assert "DX007" in [f.code for f in caught.value.findings]
    assert caught.value.exit_status == 1
