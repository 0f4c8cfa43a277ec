"""From a program alone to a complete translation: one command, one filled table, once more."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest

from tests.cli.test_commands import SAMPLES, run

Capture = pytest.CaptureFixture[str]
PLACE = "[[400,0,400],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"


def filled(cell: Path) -> None:
    """Gives each signal of a cell file a number."""
    numbers = iter(range(10, 99))
    text = re.sub(r'number = "\?"', lambda _: f"number = {next(numbers)}", cell.read_text("utf-8"))
    cell.write_text(text.replace('bits = "?"', "bits = 4"), encoding="utf-8")


def next_command(said: str) -> list[str]:
    (line,) = (line for line in said.splitlines() if line.startswith("then: "))
    return shlex.split(line.removeprefix("then: robot-assistant "))


def test_pick_and_place(tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch) -> None:
    source = SAMPLES / "rapid" / "pick_and_place.mod"
    monkeypatch.chdir(tmp_path)
    Path(source.name).write_bytes(source.read_bytes())
    status, said, _ = run(capsys, "translate", source.name, "--to", "melfa-basic-6")
    lines = said.splitlines()
    assert status == 1
    assert lines[0].startswith(f"{source.name}: 100 % translated: 44 of 44 statements")
    assert "; a draft, which lacks 9 values; no arm is named" in lines[0]
    assert lines[2] == "to be filled in: 9 values, in cell.toml"
    table = [line.split()[:3] for line in lines[4:13]]
    assert ["doGrip", "digital", "output"] in table
    assert ["giOrder", "group", "input?"] in table
    draft = Path("PICKANDPLACE.prg").read_text("ascii")
    assert draft.startswith("1 ' Castings") and "' DRAFT: not for production" in draft
    filled(Path("cell.toml"))
    status, said, _ = run(capsys, *next_command(said))
    assert status == 0
    assert said.startswith(f"{source.name}: 100 % translated: 44 of 44 statements, 7 with")
    assert "text read back: proven" in said and "then: " not in said
    assert "DRAFT" not in Path("PICKANDPLACE.prg").read_text("ascii")
    assert "Comments" not in said and "' Castings from the tray" in draft


def test_a_cell_file_above_a_program_is_found(
    tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    source = Path("line", "robot", "part.mod")
    source.parent.mkdir(parents=True)
    source.write_text("MODULE part\nPROC main()\nSetDO doGrip,1;\nENDPROC\nENDMODULE\n")
    Path("line", "cell.toml").write_text(
        '[signals.doGrip]\nkind = "digital"\ndirection = "output"\nnumber = 33\n'
    )
    status, said, _ = run(capsys, "translate", source, "--to", "melfa-basic-6", "-o", "out")
    assert (status, "lacks" in said) == (0, False)
    assert "M_Out(33)=1" in Path("out", "PART.prg").read_text("ascii")
    assert not Path("out", "cell.toml").exists()


JOINTS = f"""MODULE cell
  PERS tooldata tHand:=[TRUE,[[0,0,90],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];
  PROC main()
    MoveJ {PLACE},v100,fine,tHand;
  ENDPROC
ENDMODULE
"""
PERCENT = """1 Tool (0,0,90,0,0,0)
2 Base P_NBase
3 JOvrd 40
4 Mov P1
5 End
P1=(+400.00,+0.00,+400.00,+180.00,+0.00,+180.00)(7,0)
"""


def test_the_speed_of_joint_moves_is_in_the_table(
    tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("PART.prg").write_text(PERCENT)
    status, said, _ = run(capsys, "translate", "PART.prg", "--to", "rapid")
    assert status == 1
    assert any(line.split()[:2] == ["joint_speed", "speed"] for line in said.splitlines())
    made = Path("PART.mod").read_text("ascii")
    assert made.index("Stop;") < made.index("MoveJ ")
    cell = Path("cell.toml")
    cell.write_text(cell.read_text("utf-8").replace('speed = "?"', "speed = 250"))
    status, said, _ = run(capsys, *next_command(said))
    assert status == 1, "the load of the tool is still asked for"
    stated = cell.read_text("utf-8").replace('mass = "?"', "mass = 1.2")
    cell.write_text(stated.replace('centre = "?"', "centre = [0, 0, 40]"))
    status, said, _ = run(capsys, *next_command(said))
    assert status == 0
    assert "Stop;" not in Path("PART.mod").read_text("ascii")


LIBRARY = f"""MODULE parts
  VAR iodev io;
  PROC main()
    Grip;
    Rewind io;
  ENDPROC
  PROC Grip()
    WaitTime 1;
  ENDPROC
  PROC Washed()
    MoveL {PLACE},v100,fine,tool0;
  ENDPROC
ENDMODULE
"""


def test_a_draft_stops_wherever_it_may_be_started(tmp_path: Path, capsys: Capture) -> None:
    source = tmp_path / "parts.mod"
    source.write_text(LIBRARY)
    status, _, _ = run(capsys, "translate", source, "--to", "melfa-basic-6", "-o", tmp_path / "out")
    lines = (tmp_path / "out" / "PARTS.prg").read_text("ascii").splitlines()
    code = [line.split(maxsplit=1)[1].strip() for line in lines if line[:1].isdigit()]
    code = [line for line in code if not line.startswith("'")]
    assert status == 1
    assert code[0] == "Hlt"
    assert code[code.index("*Grip") + 1] == "Dly 1"
    assert code[code.index("*Washed") + 1] == "Hlt"


ROUTINES = """MODULE station
  PROC Grip()
    SetDO doGrip,1;
  ENDPROC
  PROC Cycle()
    Grip;
  ENDPROC
ENDMODULE
"""


def test_the_command_that_goes_on_names_what_a_program_begins_with(
    tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("station.mod").write_text(ROUTINES)
    status, said, _ = run(capsys, "translate", "station.mod", "--to", "melfa-basic-6")
    assert status == 1
    assert "nothing is written, as no procedure is named" in said.splitlines()[0]
    assert "--entry may name another procedure: Grip" in said
    assert next_command(said)[-4:] == ["--cell", "cell.toml", "--entry", "Cycle"]
    filled(Path("cell.toml"))
    status, said, _ = run(capsys, *next_command(said))
    assert (status, "then: " in said) == (0, False), said
    assert "M_Out(10)=1" in Path("STATION.prg").read_text("ascii")


PENDANT = f"""MODULE desk
  VAR num n;
  PROC main()
    TPReadNum n,"how many";
    MoveAbsJ [[0,0,0,0,30,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tool0;
    MoveL {PLACE},v100,fine,tool0;
  ENDPROC
ENDMODULE
"""


def test_the_table_tells_where_a_value_is_needed_that_no_program_names(
    tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("desk.mod").write_text(PENDANT)
    _, said, _ = run(capsys, "translate", "desk.mod", "--to", "melfa-basic-6")
    table = {line.split()[0]: line.split()[-1] for line in said.splitlines()[4:7]}
    assert table == {
        "operator_entered": "desk.mod:4",
        "operator_number": "desk.mod:4",
        "taught_on": "desk.mod:5",
    }
    Path("cell.toml").unlink()
    given = ("translate", "desk.mod", "--to", "melfa-basic-6", "--from-robot", "irb1200-7-0.7")
    _, said, _ = run(capsys, *given)
    assert "1 statement needs the arm that will run it: add --robot NAME" in said
    filled(Path("cell.toml"))
    status, said, err = run(capsys, *next_command(said), "--robot", "rv-4frl")
    assert (status, "--robot NAME" in said) == (0, False), said + err


def test_what_programs_of_a_folder_share_is_told_once(
    tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("one", "two"):
        module = f"MODULE {name}\nPROC main()\nMoveL {PLACE},v9,fine,tool0;\nENDPROC\nENDMODULE\n"
        Path(f"{name}.mod").write_text(module.replace("v9", "v100"))
    Path("SYSPAR").mkdir()
    Path("SYSPAR", "MOC.cfg").write_text(
        'MOC:CFG_1.0:6:1::\nROBOT:\n      -name "ROB_1" -use_robot_type "ROB1_1200_0.7_7" '
        "-base_frame_pos_z 0.5\n"
    )
    _, _, err = run(capsys, "translate", "one.mod", "two.mod", "--to", "melfa-basic-6")
    assert err.count("RA381 ") == 1, err


def test_each_program_without_a_beginning_has_a_command(
    tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("one.mod").write_text("MODULE one\nPROC First()\nWaitTime 1;\nENDPROC\nENDMODULE\n")
    Path("two.mod").write_text("MODULE two\nPROC main()\nWaitTime 2;\nENDPROC\nENDMODULE\n")
    status, said, _ = run(capsys, "translate", "one.mod", "two.mod", "--to", "melfa-basic-6")
    assert (status, Path("TWO.prg").is_file()) == (1, True)
    assert next_command(said) == [
        *("translate", "one.mod", "--to", "melfa-basic-6", "--entry", "First")
    ]
    status, _, _ = run(capsys, *next_command(said))
    assert (status, Path("ONE.prg").is_file()) == (0, True)


def test_a_translation_takes_what_the_project_states(
    tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("cell.mod").write_text(JOINTS)
    Path("values.toml").write_text("joint_percent = 17\n")
    Path("assistant.toml").write_text(
        '[programs.cell]\nsource = "cell.mod"\nlanguage = "melfa-basic-6"\nrobot = "rv-4frl"\n'
        'from_robot = "irb1200-7-0.7"\ncell = "values.toml"\n'
    )
    status, said, _ = run(capsys, "translate", "cell.mod", "--to", "melfa-basic-6")
    assert status == 0, said
    assert "JOvrd 17" in Path("CELL.prg").read_text("ascii")


def test_a_copy_of_a_file_that_a_task_loads_is_no_program_of_its_own(
    tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    system = "MODULE user(SYSMODULE)\nPERS num nUser:=1;\nENDMODULE\n"
    main = "MODULE part\nPROC main()\nWaitTime 1;\nENDPROC\nENDMODULE\n"
    for name, text in (
        ("HOME/user.sys", system),
        ("HOME/other.sys", system.replace("nUser", "nOther").replace("user", "other")),
        ("RAPID/TASK1/SYSMOD/user.sys", system),
        ("RAPID/TASK1/PROGMOD/part.mod", main),
    ):
        Path("backup", name).parent.mkdir(parents=True, exist_ok=True)
        Path("backup", name).write_text(text)
    _, said, _ = run(capsys, "translate", "backup", "--to", "melfa-basic-6", "-o", "out")
    assert "backup/HOME/other.sys: " in said and "backup/RAPID/TASK1: " in said
    assert "HOME/user.sys" not in said


def test_no_arm_of_one_maker_is_the_same_as_one_of_another(
    tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("home.mod").write_text(
        "MODULE home\n"
        "  CONST jointtarget home:=[[0,-10,20,0,80,0],[9E9,9E9,9E9,9E9,9E9,9E9]];\n"
        "  PROC main()\n    MoveAbsJ home,v100,fine,tool0;\n  ENDPROC\nENDMODULE\n"
    )
    Path("cell.toml").write_text('[arms.taught_on]\narm = "same"\n')
    given = ("translate", "home.mod", "--to", "melfa-basic-6", "--robot", "rv-7frl")
    status, _, err = run(capsys, *given, "--cell", "cell.toml")
    assert status == 1 and "CO080" in err
    assert not Path("HOME.prg").exists()
    Path("cell.toml").write_text('[arms.taught_on]\narm = "irb1200-7-0.7"\n')
    status, said, err = run(capsys, *given, "--cell", "cell.toml")
    assert "CO080" not in err and "CO501" in said
