"""Cell files that say which external axes of a program stand still in the cell."""

from __future__ import annotations

from pathlib import Path

from assistant.compiler import Translation, load, translate
from assistant.compiler.cell_defaults import neutral_cell
from assistant.compiler.motion_proof import Proving
from tests.compiler.test_filling import program

HEAD = """MODULE Cell
  CONST robtarget p10:=[[400,0,300],[0,0,1,0],[0,0,0,0],[7,8,9,9E9,9E9,9E9]];
  CONST robtarget p20:=[[400,50,300],[0,0,1,0],[0,0,0,0],[7,8,10,9E9,9E9,9E9]];
  VAR robtarget here:=[[410,0,300],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  VAR jointtarget home:=[[0,0,0,0,30,0],[5,9E9,9E9,9E9,9E9,9E9]];
  VAR extjoint table;
"""
USES = f"""{HEAD}  PROC main()
    table.eax_a:=45;
    MoveAbsJ home,v100,fine,tool0;
    MoveL p10,v100,z10,tool0;
    MoveL p20,v100,fine,tool0;
    here.extax.eax_a:=30;
    here.extax:=table;
    home.extax.eax_c:=table.eax_a;
    MoveL here,v100,fine,tool0;
    MoveL [[400,0,320],[0,0,1,0],[0,0,0,0],[1,9E9,9E9,9E9,9E9,9E9]],v100,fine,tool0;
  ENDPROC
ENDMODULE
"""
AXES = '[data.eax_{}_stands]\ntype = "bool"\nvalue = {}\n'


def told(folder: Path, cell: str, text: str = USES) -> Translation:
    path = folder / "cell.toml"
    path.write_text(cell, encoding="utf-8")
    return translate(program(folder, text), to="melfa-basic-6", cell=path, proving=Proving())


def test_axes_that_stand_still_are_left_out_and_told(tmp_path: Path) -> None:
    cell = neutral_cell(load(program(tmp_path, USES)))
    assert all(AXES.format(axis, "true") in cell for axis in "abc")
    assert "eax_d" not in cell
    done = told(tmp_path, cell)
    assert done.ok, [f"{f.code} {f.message}" for f in done.findings]
    assert done.motion is not None and done.motion.holds
    left = [row.text for row in done.rows if any(f.code == "RA373" for f in row.reasons)]
    assert [text.split()[-1][:3] for text in left[:2]] == ["p10", "p20"]
    assert left[-1].startswith("MoveL [[400,0,320]")
    parts = [row.text for row in done.rows if any(f.code == "RA343" for f in row.reasons)]
    assert parts == ["here.extax.eax_a:=30", "here.extax:=table", "home.extax.eax_c:=table.eax_a"]


def test_axes_that_move_are_not(tmp_path: Path) -> None:
    cell = neutral_cell(load(program(tmp_path, USES)))
    done = told(tmp_path, cell.replace("value = true", "value = false"))
    assert not done.ok
    assert not any(f.code in ("RA343", "RA373") and "eax_a" in f.message for f in done.findings)


def test_what_can_be_said_of_axes_is_not_asked_for(tmp_path: Path) -> None:
    text = HEAD.replace("8,9,9E9", "8,9E9,9E9").replace("8,10,9E9", "8,9E9,9E9")
    text += "PROC main()\nMoveL p10,v100,fine,tool0;\nENDPROC\nENDMODULE\n"
    assert "eax" not in neutral_cell(load(program(tmp_path, text)))
