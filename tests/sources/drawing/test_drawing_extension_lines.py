"""Loose extension lines on a layer of dimensions are no work; what may be work is asked about."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import ezdxf
import pytest

from assistant.base.diagnostics import Refused
from assistant.base.source_text import SourceText
from assistant.project.new_project import process_text
from assistant.sources.drawing import read
from assistant.sources.drawing.survey import survey
from assistant.sources.process.file import parse_process

BEYOND = ((100.0, 29.0), (100.0, 60.0))
"""From beyond the end of the dimension to a corner that is cut off."""
SEAM = ((100.0, 30.0), (100.0, 60.0))
"""The same line, ended at the dimension."""


def drawing(tmp_path: Path, *lines: Any, layer: str = "positions") -> Path:
    """A plate with two holes, dimensioned from its corner on a layer with some lines."""
    document = ezdxf.new("R2010", setup=True, units=4)
    space = document.modelspace()
    space.add_lwpolyline([(0, 0), (90, 0), (100, 10), (100, 60), (0, 60)], close=True)
    for x in (60, 80):
        space.add_circle((x, 40), 4)
        space.add_linear_dim(
            base=(x, 30), p1=(x, 40), p2=(100, 40), dxfattribs={"layer": layer}
        ).render()
    for start, end in lines:
        space.add_line(start, end, dxfattribs={"layer": layer})
    path = tmp_path / "a.dxf"
    document.saveas(path)
    return path


def made(path: Path, text: str = "") -> Any:
    return read(path, parse_process(SourceText(text, "x.toml")))


def procedures(reading: Any) -> list[str]:
    return [one.name for one in reading.program.procedures]


def test_lines_beyond_the_points_of_dimensions_are_left_out_with_the_note(tmp_path: Path) -> None:
    path = drawing(tmp_path, BEYOND)
    reading = made(path)
    assert "positions" not in procedures(reading)
    (note,) = [one for one in reading.findings if one.code == "DX212"]
    assert "layer `positions` (extension lines of dimensions, 1)" in note.message
    # A table, or its name under `follow`, makes them work.
    assert "positions" in procedures(made(path, "[layers.positions]\nspeed = 20"))
    assert "positions" in procedures(made(path, 'follow = ["positions"]'))


def test_init_switches_the_layer_off(tmp_path: Path) -> None:
    found = survey(drawing(tmp_path, BEYOND), parse_process(SourceText("", "x.toml")))
    text = process_text("a.dxf", found)
    assert "[layers.0]" in text
    assert "[layers.positions]" not in text
    assert "positions (extension lines of dimensions)" in text


def test_lines_that_end_at_dimensions_may_be_seams_and_are_asked_about(tmp_path: Path) -> None:
    path = drawing(tmp_path, SEAM)
    with pytest.raises(Refused) as refused:
        made(path)
    (finding,) = [one for one in refused.value.findings if one.severity == "error"]
    assert finding.code == "DX216"
    for key in ("leave_out", "follow"):
        assert f'{key} = ["positions"]' in (finding.cure or "")
    assert "positions" in procedures(made(path, 'follow = ["positions"]'))
    assert "positions" not in procedures(made(path, 'leave_out = ["positions"]'))


@pytest.mark.parametrize(
    ("lines", "layer"),
    (
        ([((20, 20), (50, 25))], "positions"),  # along no extension line
        ([((60, 30), (100, 30))], "positions"),  # along the dimension line: an edge with its size
        ([BEYOND, ((100.0, 60.0), (50.0, 60.0))], "positions"),  # joined to a path
        ([BEYOND, ((0, 5), (50, 5)), ((0, 8), (50, 8))], "positions"),  # more lines than dimensions
        ([SEAM], "seal"),  # a word of work
        ([((60, 28), (60, 45))], "0"),  # where the part is drawn
    ),
)
def test_other_lines_beside_dimensions_are_work(tmp_path: Path, lines: Any, layer: str) -> None:
    without, path = made(drawing(tmp_path, layer=layer)), drawing(tmp_path, *lines, layer=layer)
    reading = made(path)
    assert not {"DX212", "DX216"} & {one.code for one in reading.findings}
    assert len(reading.program.procedures) > len(without.program.procedures)


def test_a_layer_with_a_number_for_its_name_is_called_a_layer(tmp_path: Path) -> None:
    reading = made(drawing(tmp_path))
    assert "layer_0" in procedures(reading)
    (note,) = [one for one in reading.findings if one.code.startswith("NM")]
    assert (note.code, note.message) == ("NM001", "the name '0' is written `layer_0`")
    assert not note.cure
