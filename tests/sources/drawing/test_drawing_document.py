"""Opening: text and binary files, damaged ones, and whatever is no drawing."""

from __future__ import annotations

import logging
import os
from collections.abc import Callable
from pathlib import Path

import ezdxf
import pytest
from ezdxf.document import Drawing
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from assistant.base.diagnostics import Refused, Severity, Unreadable
from assistant.sources.contours.curves import Line
from assistant.sources.drawing import read, read_contents
from assistant.sources.process import NO_PROCESS
from tests.examples import drawn

Save = Callable[..., Path]

SAMPLE = Path(__file__).parents[3] / "samples" / "plate.dxf"


def codes(path: Path) -> list[str]:
    """Codes of what keeps a file from being read."""
    with pytest.raises(Unreadable) as caught:
        read(path, NO_PROCESS)
    assert caught.value.exit_status == 2
    assert all(f.path == str(path) and f.cure for f in caught.value.findings)
    return [f.code for f in caught.value.findings]


def damaged(path: Path, old: bytes, new: bytes) -> Path:
    data = path.read_bytes()
    assert old in data
    path.write_bytes(data.replace(old, new, 1))
    return path


@pytest.mark.parametrize("version", ["R12", "R2000", "R2004", "R2007", "R2010", "R2013", "R2018"])
@pytest.mark.parametrize("fmt", ["asc", "bin"])
def test_versions(save: Save, version: str, fmt: str) -> None:
    logging.getLogger("ezdxf").setLevel(logging.ERROR)
    document = ezdxf.new(version, units=4)
    document.modelspace().add_line((1, 2, 3), (4, 5, 6), dxfattribs={"layer": "GLUE"})
    (curve,) = read_contents(save(document, fmt=fmt), NO_PROCESS).curves
    assert isinstance(curve, Line)
    assert (curve.start, curve.end, curve.layer) == ((1, 2, 3), (4, 5, 6), "GLUE")


def test_missing_folder_and_empty(tmp_path: Path) -> None:
    assert codes(tmp_path / "none.dxf") == ["IN001"]
    assert codes(tmp_path) == ["IN002"]
    empty = tmp_path / "empty.dxf"
    empty.touch()
    assert codes(empty) == ["IN005"]


@pytest.mark.skipif(os.name == "nt", reason="Windows has no mode that keeps an owner out")
def test_permission(save: Save, drawing: Drawing) -> None:
    path = save(drawing)
    path.chmod(0)
    user = os.geteuid()
    os.seteuid(user or 65534)  # root may read everything
    try:
        assert codes(path) == ["IN003"]
    finally:
        os.seteuid(user)


@pytest.mark.parametrize(
    "data",
    [
        b"hello\nworld\n",
        b'{"a": 1}',
        b"  0\nEOF\n",
        bytes(range(256)) * 40,
        b"AC1027\x00\x00\x00\x00",
        b"%PDF-1.7\n",
        b"\xff\xfe0\x00\n\x00",
    ],
)
def test_no_drawing(tmp_path: Path, data: bytes) -> None:
    path = tmp_path / "no.dxf"
    path.write_bytes(data)
    assert codes(path) == ["DX001"]


LAYOUT_OF_NO_NAME = """0
SECTION
2
HEADER
9
$ACADVER
1
AC1027
0
ENDSEC
0
SECTION
2
OBJECTS
0
DICTIONARY
5
C
3
ACAD_LAYOUT
350
1A
0
DICTIONARY
5
1A
3
L
350
22
0
LAYOUT
5
22
100
AcDbPlotSettings
100
AcDbLayout
1
L
330
1F
0
BLOCK_RECORD
5
1F
0
ENDSEC
0
EOF
"""


@pytest.mark.parametrize(
    ("data", "why"),
    [
        (LAYOUT_OF_NO_NAME, "cannot be repaired"),
        ("0\nSECTION\n2\nHEADER\n0\nEOF\n", "StopIteration"),
    ],
)
def test_what_the_library_fails_at(tmp_path: Path, data: str, why: str) -> None:
    path = tmp_path / "no.dxf"
    path.write_text(data)
    with pytest.raises(Refused) as caught:
        read(path, NO_PROCESS)
    assert any(why in f.message for f in caught.value.findings if f.code in ("DX003", "DX004"))


def test_dwg_is_named(tmp_path: Path) -> None:
    path = tmp_path / "no.dxf"
    path.write_bytes(b"AC1032\x00" + bytes(100))
    with pytest.raises(Unreadable, match="DWG"):
        read(path, NO_PROCESS)


@pytest.mark.parametrize("fmt", ["asc", "bin"])
@pytest.mark.parametrize("share", [0.3, 0.6, 0.9, 0.999])
def test_truncated(save: Save, drawing: Drawing, fmt: str, share: float) -> None:
    drawing.modelspace().add_line((0, 0), (1, 1))
    path = save(drawing, fmt=fmt)
    data = path.read_bytes()
    path.write_bytes(data[: int(len(data) * share)])
    assert codes(path) == ["DX002"]


def test_padding_after_the_end_is_allowed(save: Save, drawing: Drawing) -> None:
    drawing.modelspace().add_line((0, 0), (1, 1))
    path = save(drawing)
    path.write_bytes(path.read_bytes() + b"\x1a" + bytes(500))
    assert len(read_contents(path, NO_PROCESS).curves) == 1


def test_repair_is_told(save: Save, drawing: Drawing) -> None:
    drawing.modelspace().add_line((0, 0), (1, 1))
    path = damaged(save(drawing), b"  0\nENDSEC\n", b"")
    contents = read_contents(path, NO_PROCESS)
    assert len(contents.curves) == 1
    repaired = [f for f in contents.findings if f.code == "DX004"]
    assert repaired[0].severity is Severity.WARNING
    assert any("ENDSEC" in f.message for f in repaired)


def test_many_repairs_are_one_finding_with_a_count(save: Save, drawing: Drawing) -> None:
    for i in range(30):
        drawing.modelspace().add_line((i, 0), (i, 1), dxfattribs={"linetype": "NOWHERE"})
    path = damaged(save(drawing), b"  0\nENDSEC\n", b"")
    (told,) = (f for f in read_contents(path, NO_PROCESS).findings if f.code == "DX004")
    assert "ENDSEC" in told.message and "32 repairs in all" in told.message
    assert len(told.message) < 400


def test_repair_that_drops_an_insert_is_an_error(save: Save, drawing: Drawing) -> None:
    drawing.modelspace().add_line((0, 0), (1, 1))
    drawing.modelspace().add_blockref("NOWHERE", (0, 0))
    path = damaged(save(drawing), b"  0\nENDSEC\n", b"")
    with pytest.raises(Refused) as caught:
        read(path, NO_PROCESS)
    assert "DX005" in [f.code for f in caught.value.findings]


@pytest.mark.parametrize("fmt", ["asc", "bin"])
def test_beyond_repair(save: Save, drawing: Drawing, fmt: str) -> None:
    drawing.modelspace().add_line((0, 0), (1, 1))
    path = save(drawing, fmt=fmt)
    line, junk = (b"AcDbLine\n", b"none\n") if fmt == "asc" else (b"AcDbLine\0", b"\xff" * 64)
    path.write_bytes(path.read_bytes().replace(line, line + junk))
    assert codes(path) == ["DX003"]


def test_reader_does_not_write_to_the_terminal(
    save: Save, drawing: Drawing, capfd: pytest.CaptureFixture[str]
) -> None:
    drawing.modelspace().add_line((0, 0), (1, 1))
    damaged_file = damaged(save(drawing), b"  0\nENDSEC\n", b"")
    read_contents(damaged_file, NO_PROCESS)
    out, err = capfd.readouterr()
    assert (out, err) == ("", "")


@settings(
    max_examples=drawn(60),
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
@given(
    changes=st.lists(
        st.tuples(
            st.floats(0, 1, exclude_max=True),
            st.sampled_from(
                ["", "0", "-1", "nan", "1e400", "abc", "ü", "INSERT", "ENDBLK", "SEQEND"]
            ),
        ),
        min_size=1,
        max_size=3,
    )
)
def test_damaged_lines_never_escape(tmp_path: Path, changes: list[tuple[float, str]]) -> None:
    """Any line of the sample's blocks and entities replaced: read, or refused with reasons."""
    lines = SAMPLE.read_text("utf-8").split("\n")
    first, last = lines.index("BLOCKS"), lines.index("OBJECTS")
    for where, text in changes:
        lines[first + int(where * (last - first))] = text
    path = tmp_path / "damaged.dxf"
    path.write_text("\n".join(lines), "utf-8")
    try:
        findings = read(path, NO_PROCESS).findings
    except Refused as refused:
        findings = refused.findings
        assert any(f.severity is Severity.ERROR for f in findings)
    assert all(f.message.isprintable() and f.where().isprintable() for f in findings)
