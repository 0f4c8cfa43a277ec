"""Work that nothing places: a robot refuses it, with the option that places it."""

from __future__ import annotations

from pathlib import Path

import pytest

from assistant.cli import main
from assistant.compiler import compile
from tests.findings.cures.case import dxf
from tests.findings.cures.drawings import square

ROBOT = "irb1200-7-0.7"
FRAME = """\
[motion]
frame = "table"
[frames.table]
position = [420, -40, 300]
"""
PLACEMENT = "[placement]\nposition = [420, -40, 300]\n"


@pytest.fixture
def drawing(tmp_path: Path) -> Path:
    file = tmp_path / "a.dxf"
    made = dxf(square)
    file.write_bytes(made if isinstance(made, bytes) else made.encode())
    return file


def ended(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, str]:
    with pytest.raises(SystemExit) as status:
        main(list(arguments))
    said = capsys.readouterr()
    assert isinstance(status.value.code, int)
    return status.value.code, said.out + said.err


@pytest.mark.parametrize("command", ["check", "compile", "simulate", "view"])
@pytest.mark.parametrize("robot", [ROBOT, "irb4600-20-2.50"])
def test_a_robot_refuses_it(
    command: str, robot: str, drawing: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = drawing.parent / "out"
    more = {
        "compile": ["--language", "rapid", "-o", str(out)],
        "view": ["--html", str(drawing.parent / "a.html")],
    }.get(command, [])
    code, said = ended(capsys, command, str(drawing), "-r", robot, *more)
    assert code == 1
    assert "CO340 error" in said
    assert "--place X,Y,Z" in said
    codes = {line.split()[0] for line in said.splitlines() if line}
    assert not {"RB102", "RB103", "CK421"} & codes
    assert not out.exists()


@pytest.mark.parametrize("text", [FRAME, PLACEMENT])
def test_a_process_file_places_it(
    text: str, drawing: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    drawing.with_suffix(".process.toml").write_text(text, encoding="utf-8")
    assert "CO340" not in ended(capsys, "check", str(drawing), "-r", ROBOT)[1]


def test_an_option_places_it(drawing: Path, capsys: pytest.CaptureFixture[str]) -> None:
    code, said = ended(
        capsys, "check", str(drawing), "-r", ROBOT, "--place", "420,-40,300", "--fail-on", "error"
    )
    assert code == 0
    assert "CO340" not in said
    # drawn around the base, and said so: then the arm is in its own base
    _, said = ended(capsys, "check", str(drawing), "-r", ROBOT, "--place", "0,0,0")
    assert "CO340" not in said
    assert "RB103 error" in said or "CK421 error" in said


def test_without_a_robot_it_compiles(drawing: Path) -> None:
    made = compile(drawing, language="rapid")
    assert made.ok
    assert made.files


def test_a_table_of_metres_in_columns_of_millimetres(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rows = [f"{0.4 + k / 100:.3f},{k / 50:.3f},0.35,0,0,1,0" for k in range(12)]
    table = tmp_path / "t.csv"

    def said(header: str, *more: str) -> str:
        table.write_text("\n".join([header, *rows]) + "\n", encoding="utf-8")
        return ended(capsys, "check", str(table), *more)[1]

    wrong, right = (f"x_{u},y_{u},z_{u},q_w,q_x,q_y,q_z" for u in ("mm", "m"))
    assert "TB208 warning" in said(wrong)
    assert "are they metres?" in said(wrong)
    assert "CO340 error" in said(wrong, "-r", ROBOT)
    assert "TB208" not in said(right)
    assert not {"TB208", "CO340"} & set(said(right, "-r", ROBOT).split())
    process = table.with_suffix(".process.toml")
    process.write_text(FRAME, encoding="utf-8")  # a few millimetres in a frame are none
    assert "TB208" not in said(wrong)
