"""Names that are words of a language, or have letters that it lacks, stop no program."""

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
    # The comments about layers are the compiler's own.
    assert "RA306" not in {finding.code for finding in compiled.findings}


def test_the_spelling_of_the_comments_of_users_is_told(tmp_path: FilePath) -> None:
    table = tmp_path / "Übersicht.csv"
    table.write_text(
        "name,x_mm,y_mm,z_mm,qw,qx,qy,qz,comment\nP1,600,0,500,0,0,1,0,kürzer\n", "utf-8"
    )
    compiled = assistant.compile(table, language="rapid", robot="irb1200-7-0.7")
    told = [finding.message for finding in compiled.findings if finding.code == "RA306"]
    assert told == ["the comment `kürzer` is written as `kuerzer`"], compiled.findings
