"""Tools and work objects that a program changes, in a language that sets them by positions."""

from __future__ import annotations

import re
from functools import partial
from pathlib import Path

import pytest

import assistant
from assistant.program.pseudo import print_program
from tests.compiler.proven import crossed_module, moves_the_same

HEAD = """MODULE Cell
  CONST robtarget p10:=[[400,0,300],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  CONST robtarget pUp:=[[60,90,250],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  PERS tooldata tGrip:=[TRUE,[[0,0,100],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];
  PERS tooldata tNow:=[TRUE,[[0,0,50],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];
  PERS wobjdata wTaught:=[FALSE,TRUE,"",[[300,-100,50],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];
  PERS wobjdata wBelt:=[FALSE,TRUE,"",[[0,0,0],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];
  VAR robtarget here;
"""
crossed = partial(crossed_module, HEAD)
CASES = {
    "parts and wholes of a work object": """PROC main()
      VAR pose shift;
      wBelt:=wTaught;
      wBelt.oframe.trans.x:=25;
      MoveJ pUp,v500,fine,tGrip\\WObj:=wBelt;
      shift.trans:=[10,-15,0];
      shift.rot:=OrientZYX(8,0,0);
      wBelt.uframe:=PoseMult(wTaught.uframe,shift);
      IF wBelt.uframe.trans.x>0 wBelt.oframe.trans:=[5,wBelt.oframe.trans.x,0];
      MoveL Offs(pUp,0,0,5),v100,fine,tGrip\\WObj:=wBelt;
      MoveL pUp,v100,fine,tGrip\\WObj:=wTaught;
      MoveC Offs(pUp,30,30,50),Offs(pUp,60,0,50),v100,fine,tGrip\\WObj:=wBelt;
    ENDPROC""",
    "parts and wholes of a tool": """PROC main()
      MoveL p10,v100,fine,tNow;
      tNow.tframe.trans.z:=tGrip.tframe.trans.z+20;
      MoveL p10,v100,fine,tNow;
      tNow:=tGrip;
      MoveL p10,v100,fine,tNow;
      tNow:=[TRUE,[[0,10,70],[0,0,1,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];
      MoveL p10,v100,fine,tNow;
    ENDPROC""",
    "a routine that is given both": """PROC main()
      go tNow,wBelt;
      go tGrip,wTaught;
    ENDPROC
    PROC go(PERS tooldata t,PERS wobjdata w)
      FOR i FROM 1 TO 2 DO
        w.uframe.trans.y:=w.uframe.trans.y+10*i;
        t.tframe.trans.x:=t.tframe.trans.x-1;
        MoveL pUp,v100,fine,t\\WObj:=w;
      ENDFOR
    ENDPROC""",
    "a part that a routine changes": """PROC main()
      turned wBelt.oframe,20;
      MoveL pUp,v100,fine,tGrip\\WObj:=wBelt;
    ENDPROC
    PROC turned(INOUT pose at,num by)
      at.rot:=OrientZYX(by,0,0);
    ENDPROC""",
    "where the robot stands in one": """PROC main()
      wBelt.uframe.trans.x:=40;
      tNow.tframe.trans.y:=7;
      MoveL pUp,v100,fine,tNow\\WObj:=wBelt;
      here:=CRobT(\\Tool:=tNow\\WObj:=wBelt);
      here.trans.z:=here.trans.z+12;
      MoveL here,v100,fine,tNow\\WObj:=wBelt;
      here:=CRobT(\\Tool:=tGrip\\WObj:=wobj0);
      here.trans.z:=here.trans.z+12;
      MoveL here,v100,fine,tGrip;
    ENDPROC""",
}


@pytest.mark.parametrize("name", CASES)
def test_they_move_the_robot_as_they_did(name: str) -> None:
    moves_the_same(crossed(CASES[name]))


def test_comments_between_data_of_the_entry_stay() -> None:
    done = crossed(
        "PROC main()\n! first\nVAR num a:=1;\n! second\nVAR num b:=2;\n! third\n"
        "tNow.tframe.trans.z:=a+b;\nMoveL p10,v100,fine,tNow;\nENDPROC"
    )
    written = b"".join(done.files.values()).decode()
    found = re.findall(r"' (first|second|third)\b", written)
    assert found == ["first", "second", "third"]


@pytest.mark.parametrize(
    "change",
    [
        "wBelt.robhold:=TRUE;",
        'wBelt.ufmec:="STN1";',
        'wBelt:=[FALSE,FALSE,"STN1",[[0,0,0],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];',
    ],
)
def test_what_carries_a_work_object_does_not_change_in_silence(change: str) -> None:
    done = crossed(f"PROC main()\n{change}\nMoveL p10,v100,fine,tGrip\\WObj:=wBelt;\nENDPROC")
    assert next(row.level for row in done.rows if row.text == change[:-1]) == "not"


def test_what_else_is_given_a_work_object_stays() -> None:
    other = "WaitWobj wBelt;"
    done = crossed(
        "PROC main()\nwBelt.oframe.trans.x:=5;\n"
        f"MoveL p10,v100,fine,tGrip\\WObj:=wBelt;\n{other}\nENDPROC"
    )
    assert next(row.level for row in done.rows if "trans.x" in row.text) == "supported"
    assert next(row.level for row in done.rows if row.text == other[:-1]) == "not"


CARRIED = """PERS wobjdata wTurn:=[FALSE,FALSE,"STN1",[[0,0,0],[1,0,0,0]],[[0,0,10],[1,0,0,0]]];
PROC main()
  MoveL pUp,v100,fine,tGrip\\WObj:=wTurn;
  wTurn.oframe.trans.z:=30;
  MoveL pUp,v100,fine,tGrip\\WObj:=wTurn;
  wTurn:=wTaught;
  MoveL pUp,v100,fine,tGrip\\WObj:=wTurn;
  wTurn:=[FALSE,FALSE,"STN1",[[0,0,0],[1,0,0,0]],[[0,5,0],[1,0,0,0]]];
  MoveL pUp,v100,fine,tGrip\\WObj:=wTurn;
ENDPROC"""


def test_what_a_mechanical_unit_carries_stands_where_the_cell_says(tmp_path: Path) -> None:
    cell = tmp_path / "cell.toml"
    cell.write_text("[frames.STN1_stands]\nposition = [50, 20, 5]\n", encoding="utf-8")
    done = crossed_module(HEAD, CARRIED, cell=cell)
    assert moves_the_same(done) == 12  # four in each of three cycles
    assert [row.level for row in done.rows if '"STN1"' in row.text] == ["partial", "partial"]
    assert any(f.code == "RA361" for f in done.findings)


def test_a_conveyor_does_not_stand_still() -> None:
    body = CARRIED.replace("PROC main()", "PROC main()\nWaitWobj wTurn;").replace("STN1", "CNV1")
    assert next(row.level for row in crossed(body).rows if row.text.startswith("MoveL")) == "not"


RECORDS = {
    "a variable": "VAR tooldata tOther;\nPROC main()\ntOther:=tGrip;\ntNow:=tOther;\nENDPROC",
    "a variable of the routine": (
        "PROC main()\nVAR tooldata tOther;\ntOther:=tGrip;\ntNow:=tOther;\nENDPROC"
    ),
    "an element": ("VAR tooldata tAll{2};\nPROC main()\ntAll{2}:=tGrip;\ntNow:=tAll{2};\nENDPROC"),
    "what is active": "PROC main()\ntNow:=CTool();\nwBelt:=CWObj();\nENDPROC",
    "a function": (
        "PROC main()\ntNow:=chosen(1);\nENDPROC\nFUNC tooldata chosen(num n)\n"
        "IF n=1 RETURN tool0;\nRETURN tGrip;\nENDFUNC"
    ),
    "a work object": "VAR wobjdata wOther;\nPROC main()\nwOther:=wTaught;\nwBelt:=wOther;\nENDPROC",
    "a pose": "VAR pose tip;\nPROC main()\ntip:=tGrip.tframe;\ntNow.tframe:=tip;\nENDPROC",
}


@pytest.mark.parametrize("case", RECORDS)
def test_a_program_that_is_shown_is_compiled_again(case: str, tmp_path: Path) -> None:
    source, shown = tmp_path / "cell.mod", tmp_path / "shown.pseudo"
    source.write_text(f"{HEAD}{RECORDS[case]}\nENDMODULE\n")
    shown.write_text(print_program(assistant.load(source).program).text)
    again = assistant.compile(shown, language="rapid")
    assert again.ok, [str(finding) for finding in again.findings]
    (text,) = (data.decode() for data in again.files.values())
    for line in RECORDS[case].split("\n"):
        if ":=" in line and "VAR" not in line:
            assert line in text
