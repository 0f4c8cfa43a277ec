"""Joints of a target and targets of joints, in a language that counts without a tool."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.compiler.proven import crossed_module, moves_the_same

HEAD = """MODULE Cell
  CONST jointtarget j1:=[[10,20,10,5,40,30],[9E9,9E9,9E9,9E9,9E9,9E9]];
  PERS tooldata tGrip:=[TRUE,[[0,5,100],[0,0,0,1]],[1,[0,0,1],[1,0,0,0],0,0,0]];
  PERS wobjdata wBox:=[FALSE,TRUE,"",[[30,0,0],[0.92388,0,0,0.382683]],[[0,5,0],[1,0,0,0]]];
  VAR robtarget here;
  VAR jointtarget there;
"""
CASES = {
    "there and back": """PROC main()
      here:=CalcRobT(j1,tGrip\\WObj:=wBox);
      here.trans.z:=here.trans.z+15;
      MoveL here,v100,fine,tGrip\\WObj:=wBox;
      there:=CalcJointT(here,tGrip\\WObj:=wBox);
      here:=CalcRobT(there,tool0);
      MoveL Offs(here,0,0,5),v100,fine,tool0;
    ENDPROC""",
    "with a tool and a displacement that change": """PROC main()
      VAR pose shift:=[[10,20,30],[1,0,0,0]];
      tGrip.tframe.trans.z:=80;
      PDispSet shift;
      here:=CalcRobT(j1,tGrip);
      MoveL here,v100,fine,tGrip;
      there:=CalcJointT(here,tGrip);
      PDispOff;
      MoveL CalcRobT(there,tGrip\\WObj:=wBox),v100,fine,tGrip\\WObj:=wBox;
    ENDPROC""",
}
VISITS = {"there and back": 2, "with a tool and a displacement that change": 6}  # in three cycles


@pytest.mark.parametrize("name", CASES)
def test_they_give_the_same_places(tmp_path: Path, name: str) -> None:
    cell = tmp_path / "cell.toml"
    cell.write_text('[arms.taught_on]\narm = "irb1200-7-0.7"\n', encoding="utf-8")
    done = crossed_module(HEAD, CASES[name], cell=cell, robot="irb1200-7-0.7")
    assert moves_the_same(done) == VISITS[name]
