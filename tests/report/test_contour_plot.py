"""The picture of contours, as the command line draws it."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from pathlib import Path

import ezdxf
import pytest

from assistant.cli import main

PROCESS = """
leave_out = ["*"]
[layers.CUT]
offset = 2
lead_in = {arc = 3}
approach = 20
retract = 20
"""


def run(capsys: pytest.CaptureFixture[str], *words: object) -> tuple[int, str]:
    with pytest.raises(SystemExit) as ended:
        main(list(map(str, words)))
    out, err = capsys.readouterr()
    return int(ended.value.code or 0), out + err


@pytest.fixture
def drawing(tmp_path: Path) -> Path:
    doc = ezdxf.new()
    doc.header["$INSUNITS"] = 4
    page = doc.modelspace()
    page.add_circle((400, 0), 60, dxfattribs={"layer": "CUT"})
    page.add_circle((400, 0), 20, dxfattribs={"layer": "CUT"})
    doc.saveas(tmp_path / "ring.dxf")
    (tmp_path / "ring.process.toml").write_text(PROCESS)
    return tmp_path / "ring.dxf"


def texts(file: Path) -> list[str]:
    """What an .svg of matplotlib says: each drawn text stands in a comment before its outlines."""
    text = file.read_text("utf-8")
    ET.fromstring(text)
    return re.findall(r"<!-- (.*?) -->", text)


def test_contours_are_numbered_in_their_order(
    capsys: pytest.CaptureFixture[str], drawing: Path, tmp_path: Path
) -> None:
    picture = tmp_path / "ring.svg"
    words = ("compile", drawing, "-l", "rapid", "-o", tmp_path / "out", "--plot", picture)
    status, said = run(capsys, *words)
    assert status == 0, said
    assert f"wrote {picture}" in said
    found = texts(picture)
    assert found.count("1") == found.count("2") == 1
    assert "ring.dxf in rapid" in found


def dashed(file: Path) -> int:
    """Lines with gaps in an .svg, but for dots."""
    return len(re.findall(r"stroke-dasharray: 2\.96", file.read_text("utf-8")))


def test_what_is_left_out_is_dashed_and_the_legend_says_so(
    capsys: pytest.CaptureFixture[str], drawing: Path, tmp_path: Path
) -> None:
    picture = tmp_path / "ring.svg"
    status, said = run(capsys, "check", drawing, "--plot", picture)
    assert status == 0, said
    assert "left out" not in texts(picture)
    assert {"drawn work", "travel", "path of the tool"} <= set(texts(picture))
    assert not dashed(picture)
    doc = ezdxf.readfile(drawing)
    for layer in ("CENTER", "OTHER"):  # by its name, and by `leave_out = ["*"]`
        doc.modelspace().add_line((300, 0), (500, 9), dxfattribs={"layer": layer})
    doc.saveas(drawing)
    status, said = run(capsys, "check", drawing, "--plot", picture)
    assert status == 0, said
    assert "left out" in texts(picture)
    assert dashed(picture) == 3  # two lines, and the legend


def test_findings_stand_beside_what_they_tell_of(
    capsys: pytest.CaptureFixture[str], drawing: Path, tmp_path: Path
) -> None:
    """Nothing can be made of it, and the picture shows why."""
    process = tmp_path / "wide.toml"
    process.write_text(PROCESS.replace("arc = 3", "arc = 30"))
    picture = tmp_path / "ring.svg"
    status, said = run(capsys, "check", drawing, "-p", process, "--plot", picture)
    assert status == 1
    assert "CT217" in said
    assert "CT217" in texts(picture)


def test_like_findings_are_one_but_each_is_in_the_picture(
    capsys: pytest.CaptureFixture[str], drawing: Path, tmp_path: Path
) -> None:
    doc = ezdxf.readfile(drawing)
    for x in (360, 440):
        doc.modelspace().add_circle((x, 0), 1, dxfattribs={"layer": "CUT"})
    doc.saveas(drawing)
    picture = tmp_path / "ring.svg"
    words = ("compile", drawing, "-l", "rapid", "-o", tmp_path / "out", "--plot", picture)
    status, said = run(capsys, *words)
    assert status == 0, said
    assert said.count("CT213 warning") == 1
    assert "2 times" in said
    assert texts(picture).count("CT213") == 2


def test_pictures_have_the_name_of_a_picture(
    capsys: pytest.CaptureFixture[str], drawing: Path, tmp_path: Path
) -> None:
    status, said = run(capsys, "check", drawing, "--plot", tmp_path / "ring.pdf")
    assert (status, "CL009" in said) == (2, True)
    assert not (tmp_path / "ring.pdf").exists()
