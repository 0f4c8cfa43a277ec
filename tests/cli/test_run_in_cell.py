"""Runs in the cell of a program: signals by their names, values of the cell file and controller."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.cli.test_commands import run

Capture = pytest.CaptureFixture[str]
MODULE = """MODULE part
  PROC main()
    IF diReady=0 WaitTime nPause;
    WaitDI diReady,1\\MaxTime:=2;
    SetDO doGrip,1;
    WaitTime 1;
  ENDPROC
ENDMODULE
"""
CELL = """[data.nPause]
type = "num"
value = 0.25

[signals.diReady]
kind = "digital"
direction = "input"
number = 4

[signals.doGrip]
kind = "digital"
direction = "output"
number = 5

[signals.giPart]
kind = "group"
direction = "input"
number = 8
bits = 4
"""
SCRIPT = '[[set]]\ninput = "diReady"\nat = 1\n\n[[set]]\ninput = "diReady"\nvalue = 0\n'
SCRIPT += 'when = "doGrip = 1"\n'


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "part.mod").write_text(MODULE)
    (tmp_path / "script.toml").write_text(SCRIPT)
    return tmp_path


def test_the_cell_file_beside_a_program_gives_it_values(folder: Path, capsys: Capture) -> None:
    given = ("run", "part.mod", "--signals", "script.toml")
    status, said, err = run(capsys, *given)
    assert (status, "nPause" in err) == (1, True), err
    (folder / "cell.toml").write_text(CELL)
    status, said, _ = run(capsys, *given)
    assert status == 0
    assert "waits 0.25 s" in said
    assert "input diReady = 1" in said and "doGrip = 1" in said
    _, said, _ = run(capsys, *given, "--format", "json")
    signals = [one["signal"] for one in json.loads(said)["events"] if "signal" in one]
    assert signals == ["diReady", "doGrip", "diReady"]


def test_another_cell_file_is_named(folder: Path, capsys: Capture) -> None:
    (folder / "cell.toml").write_text(CELL)
    (folder / "other.toml").write_text(CELL.replace("0.25", "0.75"))
    _, said, _ = run(capsys, "run", "part.mod", "--cell", "other.toml")
    assert "waits 0.75 s" in said


def test_a_message_spells_a_signal_as_the_program_does(folder: Path, capsys: Capture) -> None:
    (folder / "cell.toml").write_text(CELL)
    _, _, err = run(capsys, "run", "part.mod")
    assert "`diReady` is 0, 1 is waited for" in err


def test_the_controllers_files_name_signals(folder: Path, capsys: Capture) -> None:
    (folder / "part.mod").write_text(MODULE.replace("nPause", "diReady+0.5"))
    (folder / "SYSPAR").mkdir()
    (folder / "SYSPAR" / "EIO.cfg").write_text(
        'EIO:CFG_1.0:6:1::\nEIO_SIGNAL:\n      -Name "diReady" -SignalType "DI" -UnitMap "1"\n'
    )
    _, said, _ = run(capsys, "run", "part.mod")
    assert "waits 0.5 s" in said


TRANSLATED = """1 Dly 0.1
2 M1=M_In8(8) And &HF
3 If M1<>3 Then Error 9101
4 Wait M_In(4)=1
5 M_Out(5)=1
6 End
"""


def test_a_script_names_the_signals_of_a_translated_program(folder: Path, capsys: Capture) -> None:
    (folder / "PART.prg").write_text(TRANSLATED)
    (folder / "cell.toml").write_text(CELL)
    (folder / "script.toml").write_text(SCRIPT + '[[set]]\ninput = "giPart"\nvalue = 3\n')
    status, said, err = run(capsys, "run", "PART.prg", "--signals", "script.toml")
    assert (status, "CL026" in err) == (0, False), err
    assert "input diReady = 1" in said and "doGrip = 1" in said
    (folder / "script.toml").write_text('[[set]]\ninput = "diRedy"\n')
    _, _, err = run(capsys, "run", "PART.prg", "--signals", "script.toml")
    assert "CL026" in err and "write `diready`" in err.lower()


TOOLED = """MODULE part
  PROC main()
    MoveL [[400,0,400],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tHand;
    MoveL [[400,0,300],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tHand;
  ENDPROC
ENDMODULE
"""


def test_a_simulation_takes_the_tool_of_the_cell_file(folder: Path, capsys: Capture) -> None:
    (folder / "part.mod").write_text(TOOLED)
    given = ("simulate", "part.mod", "-r", "irb1200-7-0.7")
    (folder / "cell.toml").write_text("[tools.tHand]\ntip = [0, 0, 2000]\n")
    status, said, err = run(capsys, *given)
    assert status == 1 and "out of reach" in said + err
    (folder / "cell.toml").write_text("[tools.tHand]\ntip = [0, 0, 100]\n")
    status, said, err = run(capsys, *given)
    assert status == 0, said + err


def test_a_check_takes_the_values_of_the_cell_file(folder: Path, capsys: Capture) -> None:
    (folder / "part.mod").write_text(
        TOOLED.replace("v100,fine,tHand;\n  ENDPROC", "vNear,fine,tHand;\n    rWash;\n  ENDPROC")
    )
    status, said, err = run(capsys, "check", "part.mod", "-r", "irb1200-7-0.7")
    assert status == 1 and {"RA401", "RA403", "RB111"} <= set(said.split() + err.split())
    values = '[speeds.vNear]\nspeed = 50\n[routines.rWash]\nroutine = "empty"\n[tools.tHand]\n'
    (folder / "cell.toml").write_text(f"{values}tip = [0, 0, 100]\n")
    status, said, err = run(capsys, "check", "part.mod", "-r", "irb1200-7-0.7")
    assert (status, "1 checked, 0 findings" in said) == (0, True), said + err
    (folder / "cell.toml").rename("other.toml")
    status, said, err = run(capsys, "check", "part.mod", "-r", "irb1200-7-0.7")
    assert status == 1
    status, said, err = run(
        capsys, "check", "part.mod", "-r", "irb1200-7-0.7", "--cell", "other.toml"
    )
    assert (status, err) == (0, ""), said + err
    (folder / "other.toml").write_text(f"{values}tip = [0, 0, 2000]\n")
    status, said, err = run(
        capsys, "check", "part.mod", "-r", "irb1200-7-0.7", "--cell", "other.toml"
    )
    assert status == 1 and "RB102" in said + err


def test_a_cell_file_that_is_wrong_is_a_finding_of_the_check(folder: Path, capsys: Capture) -> None:
    (folder / "cell.toml").write_text('[signals.diReady]\nkind = "loud"\n')
    status, said, err = run(capsys, "check", "part.mod")
    assert status == 1 and "cell.toml" in said + err and "Traceback" not in err
