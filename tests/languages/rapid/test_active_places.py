"""Positions that are read in the tool and work object of the move before, whichever that was."""

from __future__ import annotations

from functools import partial

import pytest

from tests.compiler.proven import crossed_module, moves_the_same

HEAD = """MODULE Cell
  CONST robtarget p10:=[[400,0,300],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  PERS tooldata tGrip:=[TRUE,[[0,0,100],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];
  PERS tooldata tSuck:=[TRUE,[[0,0,50],[0,0,1,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];
  PERS wobjdata wBox:=[FALSE,TRUE,"",[[30,0,0],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];
  VAR robtarget here;
  PROC up(num by)
    here:=CRobT();
    here.trans.z:=here.trans.z+by;
    MoveL here,v100,fine,tGrip;
  ENDPROC
"""
crossed = partial(crossed_module, HEAD)
CASES = {
    "called behind moves of several tools": """PROC main()
      MoveL p10,v100,fine,tGrip\\WObj:=wBox;
      up 20;
      MoveL Offs(p10,1,0,0),v100,z10,tool0;
      MoveL p10,v100,fine,tSuck;
      up 30;
    ENDPROC""",
    "behind a choice": """PROC main()
      MoveL p10,v100,fine,tGrip;
      IF here.trans.z<10 MoveL Offs(p10,0,0,5),v100,fine,tSuck\\WObj:=wBox;
      up 10;
    ENDPROC""",
    "in a loop": """PROC main()
      FOR i FROM 1 TO 2 DO
        MoveL Offs(p10,i,0,0),v100,fine,tGrip\\WObj:=wBox;
        here:=CRobT(\\Tool:=tSuck);
        MoveL Offs(here,5,0,0),v100,fine,tSuck\\WObj:=wBox;
        up 5;
        up 7;
      ENDFOR
    ENDPROC""",
    "before the first move": """PROC main()
      here:=CRobT();
      MoveL Offs(here,0,0,20),v100,fine,tool0;
      MoveL p10,v100,fine,tGrip\\WObj:=wBox;
      up 20;
    ENDPROC""",
}


@pytest.mark.parametrize("name", CASES)
def test_they_are_those_of_the_move_before(name: str) -> None:
    done = crossed(CASES[name])
    moves_the_same(done)
    assert any(f.code == "RA362" for f in done.findings) == (name == "before the first move")


def test_a_cycle_begins_with_what_the_one_before_left() -> None:
    done = crossed("""PROC main()
      here:=CRobT();
      MoveL Offs(here,0,0,20),v100,fine,tSuck\\WObj:=wBox;
    ENDPROC""")
    moves_the_same(done)
    (written,) = done.files.values()
    assert b"active" in written.lower()


def test_nobody_knows_them_behind_what_stays_as_its_text() -> None:
    done = crossed(
        "PROC main()\nMoveL p10,v100,fine,tGrip;\nSearchL diX,here,p10,v10,tGrip;\nup 5;\nENDPROC"
    )
    assert next(row.level for row in done.rows if row.text == "here:=CRobT()") == "not"
