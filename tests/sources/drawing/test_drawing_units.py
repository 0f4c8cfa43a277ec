"""Units: every code of $INSUNITS, and none."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import ezdxf
import numpy as np
import pytest
from click.testing import CliRunner
from ezdxf.document import Drawing

from assistant import sources
from assistant.base.diagnostics import Refused, Severity
from assistant.cli.app import app
from assistant.program.statements import Follow
from assistant.sources.contours.curves import Arc
from assistant.sources.drawing import read, read_contents
from assistant.sources.process import NO_PROCESS
from tests.tables import every_row

Save = Callable[..., Path]

EXACT = {
    1: "25.4", 2: "304.8", 3: "1609344", 4: "1", 5: "10", 6: "1000", 7: "1e6", 8: "2.54e-5",
    9: "0.0254", 10: "914.4", 11: "1e-7", 12: "1e-6", 13: "1e-3", 14: "100", 15: "1e4", 16: "1e5",
    17: "1e12", 18: "1.495978707e14", 19: "9.4607304725808e18", 20: "3.0856775814913673e19",
    21: "304.8006096012192", 22: "25.4000508001016", 23: "914.4018288036576",
    24: "1609347.2186944373",
}  # fmt: skip


@every_row("code", list(EXACT))
def test_every_code(save: Save, code: int) -> None:
    document = ezdxf.new("R2010", units=code)
    size = 100.0 / float(EXACT[code])  # 100 mm, which no unit makes too large or small
    document.modelspace().add_circle((2 * size, 0), size)
    (circle,) = read_contents(save(document), NO_PROCESS).curves
    assert isinstance(circle, Arc)
    assert circle.radius == pytest.approx(100.0, rel=1e-12)
    assert circle.centre == pytest.approx((200.0, 0.0, 0.0), rel=1e-12)


@pytest.mark.parametrize("missing", [True, False])
def test_without_unit(save: Save, drawing: Drawing, missing: bool) -> None:
    drawing.modelspace().add_circle((0, 0), 5)
    if missing:
        del drawing.header["$INSUNITS"]
    else:
        drawing.header["$INSUNITS"] = 0
    contents = read_contents(save(drawing), NO_PROCESS)
    (finding,) = [f for f in contents.findings if f.code == "DX101"]
    assert finding.severity is Severity.WARNING
    assert ("missing" in finding.message) is missing
    (circle,) = contents.curves
    assert isinstance(circle, Arc)
    assert circle.radius == 5.0


@pytest.mark.parametrize("code", [25, -1, 99])
def test_unknown_code(save: Save, drawing: Drawing, code: int) -> None:
    drawing.modelspace().add_circle((0, 0), 5)
    drawing.header["$INSUNITS"] = code
    with pytest.raises(Refused) as caught:
        read(save(drawing), NO_PROCESS)
    assert [f.code for f in caught.value.findings] == ["DX102"]
    assert caught.value.exit_status == 1


LINE = "0\nSECTION\n2\nENTITIES\n0\nLINE\n8\nCUT\n10\n0\n20\n0\n11\n100\n21\n0\n0\nENDSEC\n0\nEOF\n"
HEADER = "0\nSECTION\n2\nHEADER\n{}0\nENDSEC\n"
BLOCK = (
    "0\nSECTION\n2\nBLOCKS\n0\nBLOCK\n8\n0\n2\nHEADER\n70\n0\n10\n0\n20\n0\n3\nHEADER\n"
    "0\nENDBLK\n8\n0\n0\nENDSEC\n"
)


@pytest.mark.parametrize(
    "before",
    ["", HEADER.format(""), HEADER.format("9\n$ACADVER\n1\nAC1009\n"), BLOCK],
    ids=["no header", "empty header", "no unit", "a block of that name"],
)
@pytest.mark.parametrize("newline", ["\n", "\r\n"])
def test_a_file_that_states_no_unit_is_in_millimetres(
    tmp_path: Path, before: str, newline: str
) -> None:
    path = tmp_path / "part.dxf"
    path.write_bytes((before + LINE).replace("\n", newline).encode())
    contents = read_contents(path, NO_PROCESS)
    assert contents.curves[0].end == (100.0, 0.0, 0.0)
    assert contents.unit == "millimetres"
    (finding,) = [f for f in contents.findings if f.code == "DX101"]
    assert "$INSUNITS is missing" in finding.message
    assert "English" not in finding.message
    assert "--unit" in finding.cure


def test_a_binary_file_keeps_its_unit(save: Save, drawing: Drawing) -> None:
    drawing.header["$INSUNITS"] = 1
    drawing.modelspace().add_line((0, 0), (1, 0))
    (line,) = read_contents(save(drawing, fmt="bin"), NO_PROCESS).curves
    assert line.end == (25.4, 0.0, 0.0)


@pytest.mark.parametrize(
    ("code", "said"), [(None, None), (0, None), (25, None), (4, "millimetres"), (1, None)]
)
def test_a_stated_unit_holds(
    save: Save, drawing: Drawing, code: int | None, said: str | None
) -> None:
    drawing.modelspace().add_line((0, 0), (2, 0))
    drawing.header["$INSUNITS"] = code or 0
    if code is None:
        del drawing.header["$INSUNITS"]
    path = save(drawing)
    path.with_suffix(".process.toml").write_text('unit = "in"\n')
    reading = sources.read(path)
    (line,) = read_contents(path, sources.process_of(path)).curves
    assert line.end == (50.8, 0.0, 0.0)
    assert reading.program.comments[0].startswith("drawing part.dxf, in inches")
    told = [f for f in reading.findings if f.code.startswith("DX10")]
    assert [f.code for f in told] == (["DX104"] if said else [])
    assert said is None or said in told[0].message
    metres = sources.read(path, unit="m").program
    assert "in metres" in metres.comments[0]  # nearer than the process file


def test_the_unit_on_the_command_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("part.dxf").write_text(LINE)
    done = CliRunner().invoke(app, ["show", "part.dxf", "--unit", "cm"])
    assert "target cut_1_end [1000, 0, 0]" in done.stdout
    command = ["compile", "part.dxf", "-l", "rapid", "-o", "-", "--unit", "cm"]
    assert "[[1000,0,0]" in CliRunner().invoke(app, command).stdout
    for unit, status in (("mm", 0), (None, 1), ("furlong", 2)):
        stated = ["--unit", unit] if unit else []
        assert CliRunner().invoke(app, ["check", "part.dxf", *stated]).exit_code == status


def test_a_unit_that_is_none(tmp_path: Path) -> None:
    with pytest.raises(Refused) as caught:
        sources.read(tmp_path / "part.csv", unit="furlong")
    assert [f.code for f in caught.value.findings] == ["SR002"]
    process = tmp_path / "part.process.toml"
    process.write_text('unit = "furlong"\n')
    with pytest.raises(Refused) as caught:
        sources.process_of(tmp_path / "part.dxf")
    assert [f.code for f in caught.value.findings] == ["CT303"]


def test_the_unit_of_arrays(tmp_path: Path) -> None:
    rows = [[0.1, 0, 0, 1, 0, 0, 0], [0.2, 0, 0, 1, 0, 0, 0]]
    np.save(tmp_path / "way.npy", np.array(rows))
    reading = sources.read(tmp_path / "way.npy", unit="m")
    assert not [f for f in reading.findings if f.code == "TB208"]
    path = next(s.path for s in reading.program.procedures[0].body if isinstance(s, Follow))
    assert path.positions[-1].tolist() == [200.0, 0.0, 0.0]


def test_where_the_file_states_its_lengths_a_unit_changes_nothing(tmp_path: Path) -> None:
    table = tmp_path / "way.csv"
    table.write_text("x_mm,y_mm,z_mm,q_w,q_x,q_y,q_z\n1,0,0,1,0,0,0\n2,0,0,1,0,0,0\n")
    stated = sources.read(table, unit="m")
    assert [f.code for f in stated.findings if f.code[:2] == "SR"] == ["SR003"]
    assert stated.program == sources.read(table).program
    taught = tmp_path / "taught.toml"
    taught.write_text('unit = "m"\n[[targets]]\nname="a"\nposition=[1,2,3]\n')
    with pytest.raises(Refused) as caught:
        sources.read(taught)
    assert "CT302" in [f.code for f in caught.value.findings]


def test_current_ucs_is_mentioned(save: Save, drawing: Drawing) -> None:
    drawing.modelspace().add_line((0, 0), (1, 1))
    drawing.header["$UCSORG"] = (10, 0, 0)
    contents = read_contents(save(drawing), NO_PROCESS)
    assert "DX103" in [f.code for f in contents.findings]
    assert contents.curves[0].start == (0.0, 0.0, 0.0)
