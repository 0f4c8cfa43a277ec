"""Names that are words of a language stop no program."""

from __future__ import annotations

from pathlib import Path as FilePath

import ezdxf
import pytest

import assistant


@pytest.mark.parametrize("layer", ["Default", "default", "error", "End", "Außenkontur ü", "Ü"])
@pytest.mark.parametrize("language", ["rapid", "melfa-basic-5"])
def test_a_drawing_with_such_a_layer(tmp_path: FilePath, layer: str, language: str) -> None:
    drawing = ezdxf.new(units=4)
    for x in (300, 360, 420):
        points = [(x, 0), (x + 40, 0), (x + 40, 40)]
        drawing.modelspace().add_lwpolyline(points, close=True, dxfattribs={"layer": layer})
    file = tmp_path / f"{layer}.dxf"
    drawing.saveas(file)
    compiled = assistant.compile(file, language=language)
    assert compiled.proof.holds, compiled.findings
