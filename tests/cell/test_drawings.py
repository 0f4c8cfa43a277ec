"""Bodies of drawings, against volumes and places that are worked out by hand."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from ezdxf.acis.dxf import export_dxf
from ezdxf.acis.entities import export_sat
from ezdxf.acis.mesh import body_from_mesh
from ezdxf.document import Drawing
from ezdxf.filemanagement import new
from ezdxf.render.forms import cube
from ezdxf.render.mesh import MeshBuilder

from assistant.base import rotations
from assistant.base.arrays import Floats
from assistant.base.diagnostics import Refused
from assistant.cell.cell_file import read_scene
from assistant.cell.drawing_bodies import Drawn, read_drawing
from assistant.cell.scene import Body, Convex, Cylinder, Mesh


@pytest.fixture
def drawing() -> Drawing:
    return new("R2010", units=4)


def read(folder: Path, document: Drawing) -> Drawn:
    document.saveas(folder / "cell.dxf")
    return read_drawing(folder / "cell.dxf")


def corners(body: Body) -> Floats:
    """Of its convex bodies and meshes, in the world of the drawing."""
    found = []
    for part in body.parts:
        assert isinstance(part.shape, Convex | Mesh)
        pose = body.pose @ part.pose
        found.append(rotations.rotate(np.array(pose.quaternion), part.shape.points) + pose.position)
    return np.concatenate(found)


def volume(body: Body) -> float:
    """By the divergence theorem; each shell has to be closed and to face outwards."""
    total = 0.0
    for part in body.parts:
        shape = part.shape
        assert isinstance(shape, Convex | Mesh)
        mesh = shape.hull if isinstance(shape, Convex) else shape
        assert mesh.solid
        a, b, c = (mesh.points[mesh.triangles[:, i]] for i in range(3))
        total += float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum()) / 6.0
    return total


def box(size: float = 100.0) -> MeshBuilder:
    mesh: MeshBuilder = cube().scale(size, size, size).translate(size / 2, size / 2, size / 2)
    return mesh


def polyface(layout: Any) -> None:
    box().render_polyface(layout)


def mesh(layout: Any) -> None:
    box().render_mesh(layout)


def faces(layout: Any) -> None:
    """Every second one the other way around, as people draw them."""
    for i, face in enumerate(box().faces_as_vertices()):
        layout.add_3dface(list(face)[:: -1 if i % 2 else 1])


def solid(layout: Any) -> None:
    export_dxf(layout.add_3dsolid(), [body_from_mesh(box())])


def lightweight(layout: Any) -> None:
    square = [(0, 0), (100, 0), (100, 100), (0, 100)]
    layout.add_lwpolyline(square, close=True, dxfattribs={"thickness": 100})


def heavy(layout: Any) -> None:
    square = [(0, 0), (0, 100), (100, 100), (100, 0)]
    attributes = {"thickness": -100, "elevation": (0, 0, 100)}
    layout.add_polyline2d(square, close=True, dxfattribs=attributes)


DRAWN = [polyface, mesh, faces, solid, lightweight, heavy]


@pytest.mark.parametrize("draw", DRAWN)
def test_what_stands_for_a_cube_is_one(
    tmp_path: Path, drawing: Drawing, draw: Callable[[Any], None]
) -> None:
    draw(drawing.modelspace())
    found = read(tmp_path, drawing)
    (body,) = found.bodies
    assert body.name == "cell"
    assert isinstance(body.parts[0].shape, Convex)
    assert volume(body) == pytest.approx(1e6, rel=1e-9)
    assert corners(body).min(axis=0) == pytest.approx(np.zeros(3), abs=1e-9)
    assert corners(body).max(axis=0) == pytest.approx(np.full(3, 100.0))


@pytest.mark.parametrize("draw", DRAWN)
def test_blocks_are_bodies_with_all_of_their_inserts(
    tmp_path: Path, drawing: Drawing, draw: Callable[[Any], None]
) -> None:
    """Turned by 90° about z, mirrored, uneven, its base point moved, nested in another block."""
    inner = drawing.blocks.new("part", base_point=(10, 0, 0))
    draw(inner)
    outer = drawing.blocks.new("fixture")
    outer.add_blockref("part", (5, 0, 0), dxfattribs={"xscale": 2, "yscale": -1, "zscale": 3})
    drawing.modelspace().add_blockref("fixture", (100, 200, 300), dxfattribs={"rotation": 90})
    (body,) = read(tmp_path, drawing).bodies
    assert body.name == "fixture"
    assert body.pose.position == pytest.approx((100, 200, 300))
    assert volume(body) == pytest.approx(6e6)
    # x of the block: 5 + 2·(-10 … 90), y: -100 … 0, z: 0 … 300; then 90° about z.
    assert corners(body).min(axis=0) == pytest.approx((100.0, 185.0, 300.0))
    assert corners(body).max(axis=0) == pytest.approx((200.0, 385.0, 600.0))


def test_circles_are_cylinders_and_oval_ones_prisms_about_them(
    tmp_path: Path, drawing: Drawing
) -> None:
    block = drawing.blocks.new("post")
    block.add_circle((10, 0), 20, dxfattribs={"thickness": 50})
    model = drawing.modelspace()
    model.add_blockref("post", (0, 0, 7), dxfattribs={"xscale": 2, "yscale": 2, "zscale": 2})
    model.add_blockref("post", (500, 0), dxfattribs={"xscale": 2})
    even, oval = read(tmp_path, drawing).bodies
    assert (even.name, oval.name) == ("post_1", "post_2")
    assert even.parts[0].shape == Cylinder(40.0, 100.0)
    assert (even.pose @ even.parts[0].pose).position == pytest.approx((20, 0, 57))
    low, high = corners(oval).min(axis=0), corners(oval).max(axis=0)
    assert low == pytest.approx((480, -20, 0), abs=0.02)
    assert high == pytest.approx((560, 20, 50), abs=0.02)
    assert volume(oval) >= math.pi * 40 * 20 * 50


def test_an_arc_of_an_outline_is_never_thinner(tmp_path: Path, drawing: Drawing) -> None:
    slot = [(0, 0, 0), (100, 0, 1), (100, 40, 0), (0, 40, 1)]
    thick = {"thickness": 10}
    drawing.modelspace().add_lwpolyline(slot, format="xyb", close=True, dxfattribs=thick)
    (body,) = read(tmp_path, drawing).bodies
    shape = body.parts[0].shape
    assert isinstance(shape, Mesh)
    chord = shape.points[:, 0].max() - 100.0
    assert chord <= 20.0 <= chord + shape.off + 1e-9
    assert 0.0 < shape.off < 0.01


def test_locations_in_a_block_are_those_of_its_body(tmp_path: Path, drawing: Drawing) -> None:
    mark = drawing.blocks.new("mark")
    for tag in ("NAME", "RX", "RY", "RZ", "TOOL"):
        mark.add_attdef(tag, (0, 0))
    tray = drawing.blocks.new("tray")
    box().render_mesh(tray)
    attributes = {"NAME": "pick", "RX": "180", "RY": "0", "RZ": "0", "TOOL": "gripper"}
    tray.add_blockref("mark", (50, 50, 100)).add_auto_attribs(attributes)
    model = drawing.modelspace()
    model.add_blockref("tray", (1000, 0, 0), dxfattribs={"rotation": 90})
    model.add_blockref("mark", (1, 2, 3)).add_auto_attribs(attributes | {"NAME": "home"})
    found = read(tmp_path, drawing)
    (body,) = found.bodies
    assert body.locations["pick"].position == pytest.approx((50, 50, 100))
    assert found.locations["home"].position == pytest.approx((1, 2, 3))
    whole = found.as_one("all")
    assert whole.locations["pick"].position == pytest.approx((950, 50, 100))
    assert volume(whole) == pytest.approx(1e6)
    assert not [f for f in found.findings if f.severity == "error"]


def test_inches_are_read_in_mm(tmp_path: Path) -> None:
    document = new("R2010", units=1)
    lightweight(document.modelspace())
    (body,) = read(tmp_path, document).bodies
    assert volume(body) == pytest.approx(1e6 * 25.4**3)


def test_what_is_left_out_is_counted(tmp_path: Path, drawing: Drawing) -> None:
    model = drawing.modelspace()
    box().render_mesh(model)
    model.add_line((0, 0), (1, 1))
    model.add_line((0, 0), (1, 2))
    model.add_line((0, 0), (1, 1), dxfattribs={"thickness": 3})
    model.add_lwpolyline([(0, 0), (9, 0), (9, 9)], dxfattribs={"thickness": 3})
    bow = [(0, 0), (9, 9), (9, 0), (0, 8)]
    model.add_lwpolyline(bow, close=True, dxfattribs={"thickness": 3})
    export_dxf(model.add_region(), [body_from_mesh(box())])
    drawing.layers.add("hidden").freeze()
    box().render_mesh(model, dxfattribs={"layer": "hidden"})
    found = read(tmp_path, drawing)
    assert len(found.bodies) == 1
    messages = [f"{f.code} {f.message}" for f in found.findings]
    for part in (
        "CK430 2 LINE on layer `0` left out: it has no thickness",
        "CK431 1 LINE on layer `0` cannot be read",
        "CK431 1 LWPOLYLINE on layer `0` cannot be read as bodies: it is open",
        "DX203 1 LWPOLYLINE on layer `0` left out: its outline crosses itself",
        "CK431 1 REGION",
        "DX202 1 MESH on layer `hidden` left out: the layer is frozen",
    ):
        assert [m for m in messages if m.startswith(part)], (part, messages)


@pytest.mark.parametrize("curved", [1, 6])
def test_a_solid_without_its_curved_faces_is_told_of(
    tmp_path: Path, drawing: Drawing, curved: int
) -> None:
    lines = list(export_sat([body_from_mesh(box())]))
    planes = [i for i, line in enumerate(lines) if line.startswith("plane-surface")]
    assert len(planes) == 6
    for i in planes[:curved]:
        lines[i] = lines[i].replace("plane-surface", "cone-surface")
    drawing.modelspace().add_3dsolid().sat = lines
    if curved == 6:
        with pytest.raises(Refused) as refused:
            read(tmp_path, drawing)
        assert {f.code for f in refused.value.findings} >= {"CK431", "CK433"}
        return
    found = read(tmp_path, drawing)
    assert {f.code for f in found.findings} >= {"CK432", "CK408"}
    shape = found.bodies[0].parts[0].shape
    assert isinstance(shape, Mesh)
    assert not shape.solid
    assert len(shape.triangles) == 10


def test_an_empty_drawing_is_refused(tmp_path: Path, drawing: Drawing) -> None:
    with pytest.raises(Refused) as refused:
        read(tmp_path, drawing)
    assert [f.code for f in refused.value.findings] == ["CK433"]


def test_a_cell_file_names_drawings(tmp_path: Path, drawing: Drawing) -> None:
    block = drawing.blocks.new("vice")
    box(30.0).render_mesh(block)
    drawing.modelspace().add_blockref("vice", (100, 0, 0), dxfattribs={"color": 1})
    drawing.saveas(tmp_path / "cell.dxf")
    text = (
        '[frames.bench]\nposition = [0, 0, 50]\n[world]\ndrawing = "cell.dxf"\nframe = "bench"\n'
        '[bodies.copy]\ndrawing = "cell.dxf"\nposition = [0, 500, 0]\n'
    )
    (tmp_path / "cell.toml").write_text(text)
    scene, findings = read_scene(tmp_path / "cell.toml")
    assert findings == ()
    vice, copy = scene.bodies
    assert (vice.name, vice.parent, vice.pose.position) == ("vice", "bench", (100, 0, 0))
    assert corners(copy).min(axis=0) == pytest.approx((100, 500, 0))
    (tmp_path / "cell.toml").write_text(text + "[bodies.vice]\nsphere = 3\n")
    with pytest.raises(Refused) as refused:
        read_scene(tmp_path / "cell.toml")
    assert [f.code for f in refused.value.findings] == ["CK435"]
