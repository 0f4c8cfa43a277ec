"""`coverage`: what of a program can be translated, construct by construct."""

from __future__ import annotations

import io
import json
from pathlib import Path

import pytest

from tests.cli.test_commands import run

MODULE = """MODULE m
  VAR clock c;
  PROC main()
    MoveJ p1,v100,fine,tool0;
    movej Offs(p1,0,0,5),v100,fine,tool0;
    MoveL CalcRobT(j1,tool0\\WObj:=wobj0),v100,fine,tool0;
    ClkReset c;
    x:=1;
  ENDPROC
  TRAP t
  ENDTRAP
ENDMODULE
"""


Capture = pytest.CaptureFixture[str]


def table(capsys: Capture, *arguments: str) -> dict[str, tuple[int, int, int]]:
    status, out, err = run(capsys, "coverage", *arguments, "--format", "json")
    assert status == 0, err
    rows = json.loads(out)
    return {row["name"]: (row["supported"], row["partial"], row["verbatim"]) for row in rows}


def test_each_construct_is_counted_at_its_level(tmp_path: Path, capsys: Capture) -> None:
    file = tmp_path / "m.mod"
    file.write_text(MODULE)
    assert table(capsys, str(file)) == {
        "MoveJ": (2, 0, 0),
        "MoveL": (0, 1, 0),
        "ClkReset": (0, 0, 1),
        "assignment": (1, 0, 0),
        "routine": (1, 0, 0),
        "VAR clock": (0, 0, 1),
        "TRAP": (0, 0, 1),
    }


def test_a_folder_is_one_table(tmp_path: Path, capsys: Capture) -> None:
    (tmp_path / "a.mod").write_text(MODULE)
    (tmp_path / "b.mod").write_text(MODULE)
    assert table(capsys, str(tmp_path))["MoveJ"] == (4, 0, 0)


def test_people_get_a_table(tmp_path: Path, capsys: Capture) -> None:
    file = tmp_path / "m.mod"
    file.write_text(MODULE)
    status, out, _ = run(capsys, "coverage", str(file))
    assert status == 0
    lines = out.splitlines()
    assert lines[0].split() == ["Construct", "Supported", "Partial", "Kept", "verbatim"]
    assert lines[-1].split() == ["total", "4", "1", "3"]


def test_a_broken_program_is_said_to_be_broken(tmp_path: Path, capsys: Capture) -> None:
    file = tmp_path / "m.mod"
    file.write_text("MODULE m\nPROC p()\na:=1\nENDPROC\nENDMODULE\n")
    status, _, err = run(capsys, "coverage", str(file))
    assert status == 1
    assert "is missing" in err
    status, out, _ = run(capsys, "coverage", str(file), "--format", "json")
    answer = json.loads(out)
    assert (status, answer["ok"], answer["constructs"]) == (1, False, [])
    assert "is missing" in answer["findings"][0]["message"]


def test_rows_of_a_table_count_one_by_one(tmp_path: Path, capsys: Capture) -> None:
    file = tmp_path / "m.mod"
    target = "[[1,2,3],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"
    rows = f"    MoveL {target},v100,fine,tool0;\n" * 20
    file.write_text(f"MODULE m\n  PROC main()\n{rows}  ENDPROC\nENDMODULE\n")
    assert table(capsys, str(file))["MoveL"] == (20, 0, 0)


def test_standard_input_is_read_in_the_language_that_it_shows(
    capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    given(
        monkeypatch,
        "10 MOV P1\n20 SERVO ON\n30 M_01=1\n40 END\nP1=(1,2,3,0,0,0)(7,0)\n",
    )
    status, out, err = run(capsys, "coverage", "-", "--format", "json")
    assert status == 0, err
    rows = {row["name"]: row["verbatim"] for row in json.loads(out)}
    assert rows["MOV"] == 0
    assert rows["SERVO"] == 1
    assert not {"10", "20", "ON"} & set(rows)


def test_standard_input_that_shows_no_language_is_refused(
    capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    given(monkeypatch, "good morning\n")
    status, _, err = run(capsys, "coverage", "-")
    assert status == 2
    assert "--from" in err


def given(monkeypatch: pytest.MonkeyPatch, text: str) -> None:
    """The text on standard input."""
    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO(text.encode())))
