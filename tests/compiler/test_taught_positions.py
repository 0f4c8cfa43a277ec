"""Persistent positions of RAPID in MELFA-BASIC, whose position list is where people teach."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from assistant.compiler import Translation, translate
from assistant.compiler.motion_proof import Proving

TARGET = "[[{},0,450],[0,0,1,0],[{}],[9E9,9E9,9E9,9E9,9E9,9E9]]"
MODULE = """MODULE M
  PERS tooldata tVac:=[TRUE,[[0,0,95],[1,0,0,0]],[0.7,[0,0,40],[1,0,0,0],0,0,0]];
  PERS wobjdata wAway:=[FALSE,TRUE,"",{frame},[[10,5,0],[1,0,0,0]]];
  CONST robtarget pHome:={home};
  PERS robtarget pPick:={pick};
  PROC main()
    MoveJ pHome,v500,fine,tVac;
    FOR i FROM 0 TO 2 DO fetch i; ENDFOR
{more}
  ENDPROC
  PROC fetch(num row)
    MoveJ Offs(pPick,0,row*45,60),v800,fine,tVac\\WObj:=wAway;
    MoveL Offs(pPick,0,row*45,0),v80,fine,tVac\\WObj:=wAway;
  ENDPROC
ENDMODULE
"""
FRAME = "[[350,-250,120],[0.965925826,0,0,0.258819045]]"
TURNS = re.compile(r"^PPICK=\(.*\)\(\d+,(\d+)\)", re.MULTILINE | re.IGNORECASE)


def translated(folder: Path, more: str = "", **arms: str) -> tuple[Translation, str]:
    file = folder / "m.mod"
    home, pick = TARGET.format(400, "0,0,0,0"), TARGET.format(0, "-1,0,-1,0").replace("450", "0")
    text = MODULE.format(home=home, pick=pick, more=more, frame=FRAME)
    file.write_text(text, encoding="ascii")
    done = translate(file, to="melfa-basic-5", proving=Proving(), **arms)
    assert done.ok and done.motion is not None and done.motion.holds, done.findings
    return done, "".join(data.decode("ascii") for data in done.files.values())


@pytest.mark.parametrize("arms", [{}, {"robot": "rv-4frl", "from_robot": "irb1200-7-0.7"}])
def test_one_that_nothing_changes_is_in_the_position_list(
    tmp_path: Path, arms: dict[str, str]
) -> None:
    done, text = translated(tmp_path, **arms)
    program, _, positions = text.partition("Return")
    assert "PPICK=(" not in program and "PPICK=(" in positions
    assert "MB227" not in {one.code for row in done.rows for one in row.reasons}


@pytest.mark.parametrize("change", ["pPick:=CRobT();", "pPick.trans.z:=1;", "pPick:=pHome;"])
def test_one_that_is_changed_begins_with_its_value(tmp_path: Path, change: str) -> None:
    done, text = translated(tmp_path, change)
    assert "PPICK=(" in text.partition("End\r\n")[0].replace("\n", "\r\n")
    assert "MB227" in {one.code for row in done.rows for one in row.reasons}


@pytest.mark.parametrize("change", ["", "pPick.trans.z:=1;"])
def test_its_last_axis_has_the_turns_of_the_frame_that_it_is_used_in(
    tmp_path: Path, change: str
) -> None:
    """`check` of the same position as a constant says which they are: none."""
    _, text = translated(tmp_path, change, robot="rv-4frl", from_robot="irb1200-7-0.7")
    assert TURNS.search(re.sub(r"(?m)^\d+ ", "", text))[1] == "0"  # type: ignore[index]
