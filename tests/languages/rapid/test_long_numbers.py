"""Numbers of 64 bits cross over as numbers: both sides are run."""

from __future__ import annotations

from pathlib import Path

from assistant.compiler import translate
from assistant.compiler.motion_proof import Proving

PROGRAM = r"""MODULE m
ALIAS dnum big;
RECORD pack
  dnum a;
  num b;
ENDRECORD
VAR pack q:=[7,8];
VAR big many{2}:=[5,6];
FUNC dnum doubled(dnum x)
  RETURN PowDnum(x,2)+AbsDnum(-1);
ENDFUNC
PROC main()
  VAR dnum n:=3;
  VAR num m;
  n:=doubled(n)+NumToDnum(q.b)+many{2}+q.a;
  m:=DnumToNum(TruncDnum(n/4));
  IF BitCheckDnum(n,6) m:=m+100;
  MoveL [[300+m,0,300],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tool0;
ENDPROC
ENDMODULE
"""


def test_a_long_number_is_a_number(tmp_path: Path) -> None:
    file = tmp_path / "m.mod"
    file.write_text(PROGRAM, encoding="utf-8", newline="\n")
    done = translate(file, to="melfa-basic-6", proving=Proving())
    assert done.ok, [f.message for row in done.rows for f in row.reasons]
    assert done.motion is not None and done.motion.holds
    assert done.motion.found is not None and done.motion.found.visits == 1
    told = {row.text for row in done.rows for f in row.reasons if f.code == "RA348"}
    assert told >= {"RECORD pack", "FUNC dnum doubled(dnum x)", "VAR dnum n:=3;"}


def test_bits_of_a_long_number_stay(tmp_path: Path) -> None:
    file = tmp_path / "m.mod"
    text = PROGRAM.replace("TruncDnum(n/4)", "BitAndDnum(n,12)")
    file.write_text(text, encoding="utf-8", newline="\n")
    done = translate(file, to="melfa-basic-6")
    (row,) = (row for row in done.rows if row.level == "not")
    assert "BitAndDnum" in row.text
