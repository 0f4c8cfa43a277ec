"""The limit of VelSet holds in the translation, whatever sets it."""

from __future__ import annotations

from pathlib import Path

import pytest

from assistant.base.source_text import SourceText
from assistant.compiler import translate
from assistant.compiler.loader import load_text
from tests.virtual import rapid_words as w
from tests.virtual.test_translated_rapid import judged

MODULE = """MODULE Cell
PERS tooldata tG:=[TRUE,[[0,0,90],[1,0,0,0]],[1,[0,0,50],[1,0,0,0],0,0,0]];
CONST robtarget p10:=[[350,20,250],[0,0,1,0],[0,0,0,0],{unused}];
CONST robtarget p20:=[[320,-40,260],[0,0,1,0],[0,0,0,0],{unused}];
CONST speeddata vOwn:=[320,500,5000,1000];
VAR num n:=70;
PROC main()
{body}
ENDPROC
PROC Slow()
VelSet 100,90;
MoveL p20,v300,fine,tG;
ENDPROC
PROC Free()
MoveL p10,v300,fine,tG;
MoveL p20,v50,fine,tG;
ENDPROC
ENDMODULE
"""
MOVES = (
    "MoveL p10,v200,fine,tG; MoveL p20,v1000,fine,tG; MoveL p10,v50,z5,tG; MoveL p20,vOwn,fine,tG;"
)
BODIES = {
    "one for all": f"VelSet 100,80; {MOVES}",
    "after some moves": f"{MOVES} VelSet 100,120; {MOVES}",
    "with a share": f"VelSet 50,60; {MOVES} VelSet 25,5000; {MOVES}",
    "taken back": f"VelSet 100,80; {MOVES} VelSet 100,5000; {MOVES}",
    "in a branch": f"IF diPart=1 VelSet 100,70; {MOVES}",
    "worked out": f"VelSet 100,n+15; {MOVES} n:=200; VelSet 100,n; {MOVES}",
    "by what is called": f"Free; Slow; Free; {MOVES}",
    "in a loop": f"FOR i FROM 1 TO 3 DO VelSet 100,40*i; {MOVES} ENDFOR",
    "moves with more options": "VelSet 100,60; MoveL p10,v400,fine\\Inpos:=inpos20,tG; "
    "MoveL p20,v400\\V:=350,fine,tG; MoveLDO p10,v300,fine,tG,do1,1;",
    "a long run": "VelSet 100,75; " + MOVES * 5,
    "a long run, worked out": "VelSet 100,n; " + MOVES * 5 + "n:=n+100;",
}  # fmt: skip


def test_the_next_cycle_begins_with_the_limit_of_the_one_before() -> None:
    text = MODULE.format(body=BODIES["after some moves"], unused=w.UNUSED)
    text = text[: text.index("PROC Slow")] + "ENDMODULE\n"
    made = translate(load_text(SourceText(text), language="rapid"), to="melfa-basic-5")
    (written,) = made.files.values()
    assert made.ok
    assert b"Min(1000," in written


@pytest.mark.one_in(3)
@pytest.mark.parametrize("name", BODIES)
def test_no_move_is_faster_than_the_limit(name: str, tmp_path: Path) -> None:
    text = MODULE.format(body=BODIES[name], unused=w.UNUSED)
    inputs = [{"dipart": 0.0}, {"dipart": 1.0}]
    tally = judged("melfa-basic-6", [(name, text, inputs)], tmp_path)
    assert tally.kept == []
    assert not tally.reasons
    assert tally.counts["equal"] == 1


def test_a_limit_that_is_known_is_written_as_a_speed() -> None:
    text = MODULE.format(body=BODIES["one for all"], unused=w.UNUSED)
    text = text[: text.index("PROC Slow")] + "ENDMODULE\n"
    made = translate(load_text(SourceText(text), language="rapid"), to="melfa-basic-5")
    (written,) = made.files.values()
    assert b"Spd 80\r\n" in written
    assert b"Spd 1000" not in written
    assert b"limit" not in written
