"""Comments of RAPID in MELFA-BASIC: where they stand, and what they tell of."""

from __future__ import annotations

from pathlib import Path

from assistant.compiler import translate

CELL = """MODULE Cell
  RECORD spot
    num x;
  ENDRECORD
  PERS num nOld:=3;
  ! where parts are taken
  CONST robtarget pTake:=[[400,100,200],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  !----------
  ! pDrop is above the box
  CONST robtarget pDrop:=[[400,0,200],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  ! all of it
  PROC main()
    VAR num n:=2;
    VAR spot at;
    ! begins
    nOld:=nOld+n;
    at:=found(nOld);
    MoveL Offs(pTake,at.x,0,0),v100,fine,tool0;
    MoveL pDrop,v100,fine,tool0;
  ENDPROC
  ! looks for the part
  FUNC spot found(num n)
    VAR spot at;
    at.x:=n;
    RETURN at;
  ENDFUNC
ENDMODULE
"""


def test_comments_stand_above_what_they_tell_of(tmp_path: Path) -> None:
    """Above a procedure, in front of its first values; of a place at the head, with its name."""
    (tmp_path / "cell.mod").write_text(CELL, encoding="utf-8", newline="\n")
    (text,) = translate(tmp_path / "cell.mod", to="melfa-basic-6").files.values()
    lines = [line.partition(" ")[2].strip() for line in text.decode().splitlines()]
    assert lines[:3] == [
        "' pTake: where parts are taken",
        "' ----------",
        "' pDrop is above the box",
    ]
    for above, below in (
        ("' all of it", "Function V cycle()"),
        ("Function V cycle()", "Mn=2"),
        ("Mn=2", "' begins"),
        ("' looks for the part", "Function V found(ByVal Mn2)"),
    ):
        assert lines[lines.index(above) + 1] == below
