"""Inserts: base point, rotation, scale, mirroring, extrusion, grids, nesting; by hand."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import ezdxf
import numpy as np
import pytest
from ezdxf.document import Drawing
from ezdxf.math import Matrix44
from ezdxf.xclip import XClip
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from assistant.base.diagnostics import Diagnostic, Refused
from assistant.sources.contours.curves import Arc, Curve, FreeCurve, Line
from assistant.sources.drawing import read, read_contents
from assistant.sources.process import NO_PROCESS
from tests.examples import drawn

Save = Callable[..., Path]


def curves(path: Path) -> list[Curve]:
    return list(read_contents(path, NO_PROCESS).curves)


def ends(curve: Curve) -> list[float]:
    return [*curve.start, *curve.end]


def errors(path: Path) -> list[Diagnostic]:
    with pytest.raises(Refused) as caught:
        read(path, NO_PROCESS)
    return [f for f in caught.value.findings if f.severity == "error"]


def segment(document: Drawing, name: str = "B", base: Sequence[float] = (0, 0, 0)) -> None:
    """A block with one line (1, 2, 3) → (4, 6, 3)."""
    document.blocks.new(name, base_point=base).add_line((1, 2, 3), (4, 6, 3))


@pytest.mark.parametrize(
    ("base", "attributes", "expected"),
    [
        pytest.param((0, 0, 0), {}, (11, 22, 33, 14, 26, 33), id="moved"),
        pytest.param((1, 1, 1), {}, (10, 21, 32, 13, 25, 32), id="base point"),
        pytest.param((0, 0, 0), {"rotation": 90}, (8, 21, 33, 4, 24, 33), id="turned"),
        pytest.param(
            (0, 0, 0),
            {"xscale": 2, "yscale": 3, "zscale": 4},
            (12, 26, 42, 18, 38, 42),
            id="scaled",
        ),
        pytest.param(
            (1, 1, 1),
            {"xscale": 2, "yscale": 3, "zscale": 4, "rotation": 90},
            # (p - base) · scale = (0, 3, 8) and (6, 15, 8), turned (-3, 0, 8) and (-15, 6, 8)
            (7, 20, 38, -5, 26, 38),
            id="base, scale, turn",
        ),
        pytest.param((0, 0, 0), {"xscale": -1}, (9, 22, 33, 6, 26, 33), id="mirrored in x"),
        pytest.param(
            (0, 0, 0),
            {"xscale": -1, "rotation": 90},
            # mirrored (-1, 2) and (-4, 6), turned (-2, -1) and (-6, -4)
            (8, 19, 33, 4, 16, 33),
            id="mirrored, then turned",
        ),
        pytest.param(
            (0, 0, 0),
            {"extrusion": (0, 0, -1)},
            # axes (-1, 0, 0), (0, 1, 0), (0, 0, -1), for the insertion point too
            (-11, 22, -33, -14, 26, -33),
            id="extruded downwards",
        ),
        pytest.param(
            (0, 0, 0),
            {"extrusion": (1, 0, 0)},
            # axes y, z, x: (x, y, z) → (z, x, y)
            (33, 11, 22, 33, 14, 26),
            id="extruded along x",
        ),
        pytest.param(
            (0, 0, 0),
            {"extrusion": (0, 1, 0), "rotation": 90},
            # axes -x, z, y: turned (-2, 1, 3), in the world (2, 3, 1); insert (-10, 30, 20)
            (-8, 33, 21, -4, 33, 24),
            id="extruded along y, turned",
        ),
    ],
)
def test_one_insert(
    save: Save,
    drawing: Drawing,
    base: tuple[float, ...],
    attributes: dict[str, Any],
    expected: tuple[float, ...],
) -> None:
    segment(drawing, base=base)
    drawing.modelspace().add_blockref("B", (10, 20, 30), dxfattribs=attributes)
    (line,) = curves(save(drawing))
    assert ends(line) == pytest.approx(expected, abs=1e-12)


def test_unit_scales_the_whole(save: Save) -> None:
    document = ezdxf.new("R2010", units=5)  # centimetres
    segment(document)
    document.modelspace().add_blockref("B", (10, 20, 30), dxfattribs={"xscale": -1})
    (line,) = curves(save(document))
    assert ends(line) == pytest.approx((90, 220, 330, 60, 260, 330), abs=1e-9)


def test_grid_turns_but_does_not_scale(save: Save, drawing: Drawing) -> None:
    drawing.blocks.new("DOT").add_line((0, 0), (1, 0))
    grid = {
        "column_count": 2, "row_count": 3, "column_spacing": 10, "row_spacing": 20,
        "rotation": 90, "xscale": 2, "yscale": 2, "zscale": 2,
    }  # fmt: skip
    drawing.modelspace().add_blockref("DOT", (100, 0), dxfattribs=grid)
    found = curves(save(drawing))
    # Columns go along the turned x, which is y; rows along -x. Row by row.
    expected = [(100 - 20 * row, 10 * column, 0) for row in range(3) for column in range(2)]
    assert np.allclose([c.start for c in found], expected, atol=1e-12)
    assert np.allclose(np.subtract([c.end for c in found], expected), (0, 2, 0), atol=1e-12)


def test_grid_in_a_mirrored_block_below_the_world(save: Save, drawing: Drawing) -> None:
    drawing.blocks.new("DOT").add_line((0, 0), (1, 0))
    outer = drawing.blocks.new("OUTER")
    outer.add_blockref("DOT", (5, 5), dxfattribs={"column_count": 2, "column_spacing": 10})
    place = {"xscale": -1, "rotation": 90, "extrusion": (0, 0, -1)}
    drawing.modelspace().add_blockref("OUTER", (100, 0, 7), dxfattribs=place)
    # x → -x; turned by 90: (x, y) → (-y, -x); plus (100, 0, 7); below the world: x and z negated.
    found = curves(save(drawing))
    assert np.allclose([c.start for c in found], [(-95, -5, -7), (-95, -15, -7)], atol=1e-12)
    assert np.allclose([c.end for c in found], [(-95, -6, -7), (-95, -16, -7)], atol=1e-12)


def test_grid_without_spacing_is_one(save: Save, drawing: Drawing) -> None:
    segment(drawing)
    grid = {"column_count": 3, "row_count": 4, "row_spacing": 10}
    drawing.modelspace().add_blockref("B", (0, 0), dxfattribs=grid)
    assert len(curves(save(drawing))) == 4


def test_three_levels(save: Save, drawing: Drawing) -> None:
    segment(drawing, "IN")
    middle = drawing.blocks.new("MID", base_point=(1, 0))
    middle.add_blockref("IN", (0, 10), dxfattribs={"rotation": 90})
    outer = drawing.blocks.new("OUT")
    outer.add_blockref("MID", (5, 0), dxfattribs={"yscale": -2})
    drawing.modelspace().add_blockref("OUT", (0, 0, 1), dxfattribs={"rotation": 180})
    # (1, 2) → turned (-2, 1) → (-2, 11) → -base (-3, 11) → (-3, -22) → (2, -22) → (-2, 22)
    # (4, 6) → turned (-6, 4) → (-6, 14) → -base (-7, 14) → (-7, -28) → (-2, -28) → (2, 28)
    (line,) = curves(save(drawing))
    assert ends(line) == pytest.approx((-2, 22, 4, 2, 28, 4), abs=1e-12)


def test_mirrored_arc_turns_the_other_way(save: Save, drawing: Drawing) -> None:
    drawing.blocks.new("B").add_arc((0, 0), 10, 0, 90)
    drawing.modelspace().add_blockref("B", (50, 0), dxfattribs={"xscale": -1})
    (arc,) = curves(save(drawing))
    assert isinstance(arc, Arc)
    assert arc.start == pytest.approx((40, 0, 0), abs=1e-12)
    assert arc.end == pytest.approx((50, 10, 0), abs=1e-12)
    half = 10 * math.sqrt(0.5)
    assert arc.via == pytest.approx((50 - half, half, 0), abs=1e-12)
    assert arc.normal == pytest.approx((0, 0, -1), abs=1e-12)


def test_unevenly_scaled_circle_is_an_ellipse(save: Save, drawing: Drawing) -> None:
    drawing.blocks.new("B").add_circle((0, 0), 10)
    drawing.modelspace().add_blockref("B", (50, 0), dxfattribs={"xscale": 3, "rotation": 90})
    (ellipse,) = curves(save(drawing))
    assert isinstance(ellipse, FreeCurve)
    assert ellipse.closed
    at = ellipse.at([0, 0.25, 0.5, 0.75])
    assert np.allclose(at, [(50, 30, 0), (40, 0, 0), (50, -30, 0), (60, 0, 0)], atol=1e-12)


def test_ellipse_that_an_insert_makes_round(save: Save, drawing: Drawing) -> None:
    drawing.blocks.new("B").add_ellipse((1, 1), major_axis=(4, 0), ratio=0.5)
    drawing.modelspace().add_blockref("B", (0, 0), dxfattribs={"yscale": 2})
    (circle,) = curves(save(drawing))
    assert isinstance(circle, Arc)
    assert (circle.closed, circle.radius) == (True, 4.0)
    assert circle.centre == (1.0, 2.0, 0.0)


def test_layer_0_of_a_block_is_the_layer_of_its_insert(save: Save, drawing: Drawing) -> None:
    block = drawing.blocks.new("B")
    block.add_line((0, 0), (1, 0))
    block.add_line((0, 1), (1, 1), dxfattribs={"layer": "CUT"})
    outer = drawing.blocks.new("O")
    outer.add_blockref("B", (0, 0))
    drawing.modelspace().add_blockref("O", (0, 0), dxfattribs={"layer": "GLUE"})
    assert [c.layer for c in curves(save(drawing))] == ["GLUE", "CUT"]


def test_missing_block(save: Save, drawing: Drawing) -> None:
    insert = drawing.modelspace().add_blockref("NOWHERE", (0, 0))
    (error,) = errors(save(drawing))
    assert error.code == "DX206"
    assert error.place == f"INSERT #{insert.dxf.handle}"


@pytest.mark.parametrize("depth", [1, 2, 5])
def test_recursive_blocks(save: Save, drawing: Drawing, depth: int) -> None:
    for i in range(depth):
        block = drawing.blocks.new(f"B{i}")
        block.add_line((0, 0), (1, 0))
        block.add_blockref(f"b{(i + 1) % depth}", (1, 1))
    drawing.modelspace().add_blockref("B0", (0, 0))
    (error,) = errors(save(drawing))
    assert error.code == "DX207"
    assert error.place is not None
    assert error.place.count(">") == depth


def test_nesting_has_an_end(save: Save, drawing: Drawing) -> None:
    for i in range(120):
        drawing.blocks.new(f"B{i}").add_blockref(f"B{i + 1}", (1, 1))
    drawing.modelspace().add_blockref("B0", (0, 0))
    assert [e.code for e in errors(save(drawing))] == ["DX210"]


def test_doubling_blocks_have_an_end(save: Save, drawing: Drawing) -> None:
    grid = {"column_count": 1000, "row_count": 1000, "column_spacing": 1, "row_spacing": 1}
    drawing.blocks.new("B0").add_blockref("B1", (0, 0), dxfattribs=grid)
    drawing.blocks.new("B1").add_blockref("NOWHERE", (0, 0), dxfattribs=grid)
    drawing.modelspace().add_blockref("B0", (0, 0), dxfattribs=grid)
    assert [e.code for e in errors(save(drawing))] == ["DX209"]


def test_clipped_insert(save: Save, drawing: Drawing) -> None:
    segment(drawing)
    insert = drawing.modelspace().add_blockref("B", (0, 0))
    clip = XClip(insert)
    clip.set_block_clipping_path([(0, 0), (2, 2)])
    assert [e.code for e in errors(save(drawing))] == ["DX211"]
    clip.disable_clipping()
    assert len(curves(save(drawing))) == 1


def test_external_reference(save: Save, drawing: Drawing) -> None:
    drawing.add_xref_def("other.dxf", "OTHER")
    drawing.modelspace().add_blockref("OTHER", (0, 0))
    assert [e.code for e in errors(save(drawing))] == ["DX208"]


# Against explicit matrices: ezdxf's own object coordinate systems and 4x4 matrices, which are
# written for row vectors and know nothing of this package.

number = st.floats(-50, 50).map(lambda v: round(v, 3))
factor = st.sampled_from([-2.0, -1.0, -0.5, 0.5, 1.0, 3.0])
unit = st.sampled_from(
    [(0, 0, 1), (0, 0, -1), (1, 0, 0), (0, -1, 0), (0.6, 0, 0.8), (0.001, 0.002, 1), (1, 2, -2)]
)
place = st.fixed_dictionaries(
    {
        "insert": st.tuples(number, number, number),
        "rotation": st.floats(-360, 360).map(lambda v: round(v, 2)),
        "xscale": factor,
        "yscale": factor,
        "zscale": factor,
        "extrusion": unit,
    }
)


@settings(
    max_examples=drawn(40),
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
@given(
    places=st.lists(place, min_size=1, max_size=3),
    bases=st.lists(st.tuples(number, number, number), min_size=3, max_size=3),
    start=st.floats(0, 359),
    sweep=st.floats(1, 359),
    bulge=st.sampled_from([-2.0, -1.0, -0.3, 0.2, 1.0, 1.7]),
)
def test_nested_inserts_against_matrices(
    save: Save,
    places: list[dict[str, Any]],
    bases: list[tuple[float, float, float]],
    start: float,
    sweep: float,
    bulge: float,
) -> None:
    document = ezdxf.new("R2010", units=4)
    shapes = document.blocks.new("B0", base_point=bases[0])
    model = document.modelspace()
    for layout in (shapes, model):  # in the model space as they are, to compare with
        layout.add_arc((1, 2), 5, start, start + sweep, dxfattribs={"extrusion": (1, 2, 2)})
        layout.add_line((1, 2, 3), (-4, 5, 6))
        layout.add_lwpolyline([(0, 0, bulge), (7, 3, 0)], format="xyb")
        layout.add_ellipse((3, 2, 1), (0, 4, 3), 0.3, 0.5, 4)
        layout.add_spline([(0, 0, 0), (3, 4, 5), (6, 1, 0), (9, 9, 9)])
    matrix = Matrix44()
    for i, attributes in enumerate(places):
        outer = document.blocks.new(f"B{i + 1}", base_point=bases[(i + 1) % 3])
        insert = (outer if i + 1 < len(places) else model).add_blockref(
            f"B{i}", attributes["insert"], dxfattribs=attributes
        )
        matrix *= insert.matrix44()
    found = curves(save(document))
    plain, moved = found[:5], found[5:]
    t = np.linspace(0, 1, 9)
    for before, after in zip(plain, moved, strict=True):
        expected = np.array([matrix.transform(tuple(p)).xyz for p in before.at(t)])
        assert np.abs(after.at(t) - expected).max() < 1e-6
        if isinstance(before, Line):
            assert isinstance(after, Line)


def inserts(name: str, times: int) -> str:
    """An INSERT of so many columns and rows."""
    grid = f"70\n{times}\n71\n{times}\n44\n1\n45\n1\n" if times > 1 else ""
    return f"0\nINSERT\n8\n0\n2\n{name}\n10\n0\n20\n0\n{grid}"


def of_blocks(blocks: dict[str, str], model: str) -> bytes:
    """A drawing without a header."""
    told = "".join(
        f"0\nBLOCK\n8\n0\n2\n{name}\n10\n0\n20\n0\n{content}0\nENDBLK\n"
        for name, content in blocks.items()
    )
    text = f"0\nSECTION\n2\nBLOCKS\n{told}0\nENDSEC\n0\nSECTION\n2\nENTITIES\n{model}0\nENDSEC\n"
    return f"{text}0\nEOF\n".encode()


LINE = "0\nLINE\n8\n0\n10\n0\n20\n0\n11\n1\n21\n0\n"


@pytest.mark.parametrize(
    "drawing",
    [
        of_blocks({}, inserts("NOWHERE", 30_000)),
        of_blocks({"B": inserts("B", 1000)}, inserts("B", 2)),
        of_blocks(
            {f"B{i}": 2 * inserts(f"B{i + 1}", 1) for i in range(40)} | {"B40": LINE},
            inserts("B0", 1),
        ),
        of_blocks(
            {f"B{i}": "".join(inserts(f"B{k}", 1) for k in range(9)) for i in range(9)},
            inserts("B0", 1),
        ),
    ],
    ids=["a grid", "a grid of itself", "twice at each of 40 levels", "each in each other"],
)
def test_what_blocks_stand_for_is_known_before_they_are_inserted(
    drawing: bytes, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("ROBOT_ASSISTANT_BUDGET", "0.1")  # a second
    file = tmp_path / "x.dxf"
    file.write_bytes(drawing)
    assert [e.code for e in errors(file)] == ["DX209"]


def test_blocks_on_frozen_layers_stand_for_nothing(save: Save, drawing: Drawing) -> None:
    drawing.layers.add("COLD").freeze()
    for i in range(40):
        block = drawing.blocks.new(f"B{i}")
        for _ in range(2):
            block.add_blockref(f"B{i + 1}", (1, 1))
    drawing.blocks.new("B40").add_line((0, 0), (1, 0))
    drawing.modelspace().add_blockref("B0", (0, 0), dxfattribs={"layer": "COLD"})
    segment(drawing)
    found = read_contents(save(drawing), NO_PROCESS).findings
    assert not [f for f in found if f.severity == "error"]
