"""Displacements of all targets, in a language that has none: work objects that move along."""

from __future__ import annotations

from functools import partial

import pytest

from tests.compiler.proven import crossed_module, moves_the_same

HEAD = """MODULE Cell
  CONST robtarget p10:=[[400,0,300],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  PERS tooldata tGrip:=[TRUE,[[0,0,100],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];
  PERS wobjdata wBox:=[FALSE,TRUE,"",[[30,0,0],[0.92388,0,0,0.382683]],[[0,5,0],[1,0,0,0]]];
  VAR pose shift:=[[10,20,30],[1,0,0,0]];
  VAR robtarget here;
"""
crossed = partial(crossed_module, HEAD)
CASES = {
    "set, added to, ended": """PROC main()
      MoveL p10,v100,fine,tGrip\\WObj:=wBox;
      PDispSet shift;
      MoveL p10,v100,fine,tGrip\\WObj:=wBox;
      MoveJ p10,v100,fine,tGrip;
      shift.rot:=OrientZYX(10,0,0);
      PDispAdd shift;
      MoveL p10,v100,fine,tGrip\\WObj:=wobj0;
      PDispOff;
      MoveL p10,v100,fine,tGrip\\WObj:=wBox;
    ENDPROC""",
    "where the robot stands": """PROC main()
      PDispSet shift;
      MoveL p10,v100,fine,tGrip\\WObj:=wBox;
      here:=CRobT(\\Tool:=tGrip\\WObj:=wBox);
      MoveL Offs(here,0,0,5),v100,fine,tGrip\\WObj:=wBox;
      here:=CRobT();
      PDispOn p10,tGrip;
      MoveL here,v100,fine,tGrip;
    ENDPROC""",
    "from one place to another": """PROC main()
      here:=p10;
      here.trans.z:=320;
      here.rot:=OrientZYX(15,180,0);
      PDispOn \\Rot\\ExeP:=here,p10,tGrip\\WObj:=wBox;
      MoveL p10,v100,fine,tGrip\\WObj:=wBox;
      PDispOn \\ExeP:=here,p10,tGrip;
      MoveL p10,v100,fine,tGrip;
    ENDPROC""",
    "in routines that are given work objects which change": """PROC main()
      go wBox;
      IF here.trans.z=0 PDispSet shift;
      wBox.oframe.trans.x:=7;
      go wBox;
      go wobj0;
    ENDPROC
    PROC go(PERS wobjdata w)
      MoveL p10,v100,fine,tGrip\\WObj:=w;
    ENDPROC""",
}


@pytest.mark.parametrize("name", CASES)
def test_they_displace_the_same_moves(name: str) -> None:
    moves_the_same(crossed(CASES[name]))


def test_they_stay_where_a_routine_is_told_its_work_object_some_other_way() -> None:
    done = crossed(
        "PROC main()\nPDispSet shift;\nsub;\nENDPROC\nPROC sub()\n"
        'VAR wobjdata w:=[FALSE,TRUE,"",[[0,0,0],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];\n'
        "MoveL p10,v100,fine,tGrip\\WObj:=w;\nENDPROC"
    )
    assert next(row.level for row in done.rows if row.text == "PDispSet shift") == "not"
