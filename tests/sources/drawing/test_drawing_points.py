"""Points of drawings: where they are, how the tool stands there and what they are called."""

from __future__ import annotations

import numpy as np
import pytest
from ezdxf.document import Drawing

from assistant.program.geometry import Tool
from assistant.program.motion import FINE, Speed
from assistant.program.statements import Motion
from assistant.sources.process import Layer, Process
from tests.sources.drawing.test_drawing_locations import (
    ROUNDING,
    Save,
    codes,
    matrix,
    moves,
    one,
    program,
)


@pytest.mark.parametrize(
    ("extrusion", "expected"),
    [
        ((0, 0, 1), [(1, 0, 0), (0, -1, 0), (0, 0, -1)]),
        ((1, 0, 0), [(0, 1, 0), (0, 0, -1), (-1, 0, 0)]),
        ((0, 1, 0), [(-1, 0, 0), (0, 0, -1), (0, -1, 0)]),
    ],
)
def test_point_faces_its_extrusion(
    save: Save, drawing: Drawing, extrusion: tuple[float, ...], expected: list[tuple[int, ...]]
) -> None:
    drawing.modelspace().add_point((10, 20, 30), dxfattribs={"extrusion": extrusion})
    pose = one(save(drawing))
    assert pose.position == (10, 20, 30)
    assert np.allclose(matrix(pose).T, expected, atol=ROUNDING)


def test_points_are_named_by_layer(save: Save, drawing: Drawing) -> None:
    model = drawing.modelspace()
    for i, layer in enumerate(["DRILL", "SPOT", "DRILL"]):
        model.add_point((i, 0), dxfattribs={"layer": layer, "angle": 30, "thickness": 2})
    path = save(drawing)
    assert list(program(path).targets) == ["DRILL_1", "SPOT_1", "DRILL_2"]
    assert codes(path).count("DX204") == 2


def test_point_in_a_block(save: Save, drawing: Drawing) -> None:
    drawing.blocks.new("PLATE", base_point=(1, 0)).add_point((3, 4, 5))
    drawing.modelspace().add_blockref("PLATE", (100, 0), dxfattribs={"rotation": 90})
    pose = one(save(drawing))
    assert pose.position == pytest.approx((96, 2, 5), abs=ROUNDING)
    # x along the turned x, tool down.
    assert np.allclose(matrix(pose).T, [(0, 1, 0), (1, 0, 0), (0, 0, -1)], atol=ROUNDING)


def test_point_on_a_layer_with_a_process(save: Save, drawing: Drawing) -> None:
    model = drawing.modelspace()
    model.add_point((1, 2), dxfattribs={"layer": "GLUE"})
    model.add_point((1, 2), dxfattribs={"layer": "GLUE", "extrusion": (1, 0, 0)})
    motion = Motion(Speed(25.0), FINE, "nozzle", "base")
    layer = Layer("gluing", motion, direction=(0.0, 1.0, 0.0))
    process = Process(tools={"nozzle": Tool()}, layers={"glue": layer})
    result = program(save(drawing), process)
    flat, slope = (matrix(t.pose) for t in result.targets.values())
    assert np.allclose(flat[:, 2], (0, 1, 0), atol=ROUNDING)
    assert np.allclose(slope[:, 2], (-1, 0, 0), atol=ROUNDING)
    assert [m.motion for m in moves(result)] == [motion, motion]
