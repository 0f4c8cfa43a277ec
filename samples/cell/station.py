"""Draws station.dxf: what stands on a bench, with what is to be done there. Needs ezdxf alone.

    python samples/cell/station.py [FILE]

The drawing is in mm and seen from above; z is up. Its world is the base of the robot, and the top
of the bench is at z 200.
"""

from __future__ import annotations

import sys
from pathlib import Path

import ezdxf
from ezdxf.document import Drawing
from ezdxf.layouts import BaseLayout
from ezdxf.render.forms import cube

HERE = Path(__file__).with_name("station.dxf")
GREY, BLUE, RED, STEEL, GREEN = 8, 150, 1, 9, 3  # colours by their numbers


def box(layout: BaseLayout, low: tuple[float, ...], high: tuple[float, ...], layer: str) -> None:
    """A box from corner to corner, as a mesh."""
    size = [b - a for a, b in zip(low, high, strict=True)]
    mesh = cube(center=False)
    mesh.scale(*size).translate(*low)
    mesh.render_mesh(layout, dxfattribs={"layer": layer})


def part(drawing: Drawing) -> None:
    """A plate with a boss, a bead of glue around it, and two places to look at."""
    block = drawing.blocks.new("PART")
    box(block, (-45, -40, 0), (45, 40, 30), "PART")
    box(block, (-12, -12, 30), (12, 12, 55), "PART")
    corners = [(-34, -30), (34, -30), (34, 30), (-34, 30)]
    bead = block.add_lwpolyline(corners, close=True, dxfattribs={"layer": "GLUE"})
    bead.dxf.elevation = 30.0
    for x in (-26, 26):
        block.add_point((x, 0, 32), dxfattribs={"layer": "LOOK"})


def post(drawing: Drawing) -> None:
    """A round post, with a place on its top."""
    block = drawing.blocks.new("POST")
    circle = block.add_circle((0, 0, 0), 14.0, dxfattribs={"layer": "POST"})
    circle.dxf.thickness = 75.0
    block.add_blockref("MARK", (0, 0, 78)).add_auto_attribs(
        {"NAME": "post_top", "MOTION": "travel"}
    )


def mark(drawing: Drawing) -> None:
    """The symbol of a location; its attributes say which."""
    block = drawing.blocks.new("MARK")
    block.add_line((-5, 0), (5, 0))
    block.add_line((0, -5), (0, 5))
    for row, tag in enumerate(("NAME", "MOTION")):
        block.add_attdef(tag, (6, -3.0 * row), dxfattribs={"height": 2.5})


def station() -> Drawing:
    """The whole drawing."""
    drawing = ezdxf.new("R2000", units=4)
    layers = {"PART": BLUE, "POST": STEEL, "WALL": RED, "BENCH": GREY}
    for name, colour in {**layers, "GLUE": GREEN, "LOOK": GREEN}.items():
        drawing.layers.add(name, color=colour)
    mark(drawing)
    part(drawing)
    post(drawing)
    model = drawing.modelspace()
    box(model, (160, -230, 180), (430, 230, 200), "BENCH")
    outline = [(220, -6), (365, -6), (365, 6), (220, 6)]
    wall = model.add_lwpolyline(outline, close=True, dxfattribs={"layer": "WALL"})
    wall.dxf.elevation, wall.dxf.thickness = 200.0, 100.0
    model.add_blockref("PART", (290, 115, 200))
    model.add_blockref("PART", (290, -115, 200), dxfattribs={"rotation": 90})
    model.add_blockref("POST", (335, 42, 200))
    return drawing


if __name__ == "__main__":
    station().saveas(sys.argv[1] if len(sys.argv) > 1 else HERE)
