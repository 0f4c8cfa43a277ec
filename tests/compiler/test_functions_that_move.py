"""Functions that move, called in moves, which keep their own speed, corner, tool and frame."""

from __future__ import annotations

import assistant
from assistant.base.source_text import SourceText
from assistant.compiler import Translation
from assistant.compiler.loader import load_text
from assistant.compiler.motion_proof import Proving

HEAD = """MODULE Cell
PERS tooldata tGrip:=[TRUE,[[0,0,100],[1,0,0,0]],[1,[0,0,50],[1,0,0,0],0,0,0]];
CONST robtarget p10:=[[400,50,450],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
CONST robtarget p20:=[[400,150,450],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
"""
MOVES = """FUNC robtarget above()
  MoveL p20,v50,z10,tGrip;
  RETURN p10;
ENDFUNC
FUNC num height()
  MoveL p20,v500,fine,tGrip;
  RETURN 30;
ENDFUNC
FUNC robtarget still()
  RETURN p20;
ENDFUNC
"""


def translated(body: str) -> Translation:
    text = f"{HEAD}PROC main()\n{body}\nENDPROC\n{MOVES}ENDMODULE\n"
    loaded = load_text(SourceText(text), language="rapid")
    return assistant.translate(loaded, to="melfa-basic-6", proving=Proving(seconds=3))


def proven(body: str) -> str:
    done = translated(body)
    assert done.motion is not None and done.motion.holds, done.motion and done.motion.findings
    return "\n".join(data.decode() for data in done.files.values())


def test_the_move_has_its_own_settings() -> None:
    proven("MoveL above(),v200,fine,tool0;")


def test_a_shift_that_a_moving_function_gives() -> None:
    proven("MoveL Offs(p10,0,0,height()),v200,fine,tool0;")


def test_several_of_them_in_one_move() -> None:
    proven("MoveJ p10,v200,fine,tool0;\nMoveL Offs(above(),height(),0,height()),v200,z5,tool0;")


def test_other_functions_stay_in_the_move() -> None:
    assert "Mvs still()" in proven("MoveL still(),v200,fine,tool0;")
