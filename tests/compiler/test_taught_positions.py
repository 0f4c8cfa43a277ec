"""Persistent positions of RAPID in MELFA-BASIC, whose position list is where people teach."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from assistant.compiler import Translation, translate
from assistant.compiler.motion_proof import Proving
from assistant.program.geometry import Target
from assistant.program.rewriting import records
from tests.languages.melfa_basic.lifting import lifted

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


SHELF = """MODULE Shelf
  PERS tooldata tVac:=[TRUE,[[0,0,95],[1,0,0,0]],[0.7,[0,0,40],[1,0,0,0],0,0,0]];
  {storage} robtarget pSlot{{2,2}}:=[[{a},{b}],[{c},{d}]];
  CONST jointtarget jSafe{{1}}:=[[[0,10,10,0,60,0],[9E9,9E9,9E9,9E9,9E9,9E9]]];
  PROC main()
    MoveAbsJ jSafe{{1}},v200,fine,tVac;
    FOR i FROM 1 TO 2 DO
      FOR j FROM 1 TO 2 DO MoveL pSlot{{i,j}},v200,fine,tVac; ENDFOR
    ENDFOR
    aside;
    {change}
  ENDPROC
  PROC aside()
    CONST robtarget pOwn{{1}}:=[{a}];
    FOR k FROM 1 TO 1 DO MoveL pOwn{{k}},v200,fine,tVac; ENDFOR
  ENDPROC
ENDMODULE
"""


def shelf(folder: Path, change: str = "", storage: str = "CONST", version: str = "5") -> str:
    file = folder / "shelf.mod"
    places = {k: TARGET.format(380.126 + at, "0,0,0,0") for at, k in enumerate("abcd")}
    text = SHELF.format(change=change, storage=storage, **places)
    file.write_text(text, encoding="ascii")
    arms = {"robot": "rv-4frl", "from_robot": "irb1200-7-0.7"}
    done = translate(file, to=f"melfa-basic-{version}", proving=Proving(), **arms)
    assert done.ok and done.motion is not None and done.motion.holds, done.findings
    return "".join(data.decode("ascii") for data in done.files.values()).replace("\r\n", "\n")


@pytest.mark.parametrize(("storage", "version"), [("CONST", "5"), ("PERS", "4"), ("CONST", "6")])
def test_elements_of_an_array_are_in_the_position_list(
    tmp_path: Path, storage: str, version: str
) -> None:
    """One who teaches a place of the array keeps it at the next start."""
    lines = shelf(tmp_path, storage=storage, version=version).upper().splitlines()
    code = [line.lstrip("0123456789 ") for line in lines if line[0].isdigit()]
    positions = "".join(f"{line}\n" for line in lines if not line[0].isdigit())
    for array in ("PSLOT", "POWN", "JSAFE"):
        assert any(line.startswith(f"DIM {array}(") for line in code)
        assert not any(line.startswith(f"{array}(") for line in code)
    assert "PSLOT(2,1)=(+382.13,+0.00,+450.00,+180.00,+0.00,+180.00)(7,0)" in positions
    assert "JSAFE(1)=(" in positions and "POWN(1)=(" in positions


def test_an_array_that_is_changed_is_filled_at_each_start(tmp_path: Path) -> None:
    text = shelf(tmp_path, "pSlot{1,2}.trans.z:=440;", "VAR")
    assert re.search(r"(?m)^\d+ PSLOT\(1,2\)=\(381\.126,", text)
    assert not re.search(r"(?m)^PSLOT", text)


def test_a_taught_element_is_read_as_it_was_taught(tmp_path: Path) -> None:
    """The array is a constant as before, unless a line was added that changes it."""
    text = shelf(tmp_path).replace("PSLOT(2,2)=(+383.13,", "PSLOT(2,2)=(+390.50,")
    array = lifted(text).variables["pSlot"]
    found = sorted(x.pose.position[0] for x in records(array.initial) if isinstance(x, Target))
    assert found == [380.13, 381.13, 382.13, 390.5] and array.storage == "constant"
    changing = re.sub(r"(?m)^(\d+) \*ASIDE$", r"\1 *ASIDE:PSLOT(1,1)=P_Curr", text)
    assert changing != text and lifted(changing).variables["pSlot"].storage == "persistent"
