"""Routines that are given tools, frames, speeds and signals, in languages that have no such."""

from __future__ import annotations

from pathlib import Path

import pytest

from assistant.compiler import Translation, translate
from assistant.compiler.motion_proof import Proving

HEAD = """MODULE Cell
  CONST robtarget p10:=[[400,0,300],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  PERS tooldata tGrip:=[TRUE,[[0,0,100],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];
  PERS tooldata tSuck:=[TRUE,[[0,0,50],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];
  PERS wobjdata wBox:=[FALSE,TRUE,"",[[30,0,0],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];
  CONST speeddata vSlow:=[70,500,5000,1000];
  VAR speeddata vSet:=[50,500,5000,1000];
"""
CELL = """[signals.do1]
number = 1
[signals.do2]
number = 2
[signals.di1]
direction = "input"
number = 1
"""


def translated(folder: Path, main: str, routines: str) -> Translation:
    (folder / "cell.toml").write_text(CELL, encoding="utf-8")
    file = folder / "cell.mod"
    text = f"{HEAD}PROC main()\n{main}\nENDPROC\n{routines}\nENDMODULE\n"
    file.write_text(text, encoding="utf-8", newline="\n")
    cell = folder / "cell.toml"
    return translate(file, to="melfa-basic-6", cell=cell, proving=Proving())


PICK = """PROC pick(
  robtarget p,speeddata v,PERS tooldata t,VAR signaldo o\\PERS wobjdata WObj\\num n)
  VAR num above:=20;
  IF Present(n) above:=above+n;
  approach p,above,t\\WObj?WObj;
  MoveL p,v,fine,t\\WObj?WObj;
  IF NOT Present(WObj) THEN
    WaitTime 0.5;
  ENDIF
  SetDO o,1;
ENDPROC
PROC approach(robtarget p,num up,PERS tooldata tool\\PERS wobjdata WObj)
  IF Present(WObj) THEN
    MoveL Offs(p,0,0,up),v200,z10,tool\\WObj:=WObj;
  ELSE
    MoveL Offs(p,0,0,up),v200,z10,tool;
  ENDIF
ENDPROC"""
PLACE = "PROC place(PERS tooldata t)\nMoveL p10,v100,fine,t;\nSetDO do1,0;\nENDPROC"


@pytest.mark.parametrize(
    ("main", "routines", "names"),
    [
        ("pick p10,vSlow,tGrip,do1\\WObj:=wBox;", PICK, {"pick", "approach"}),
        (
            "pick p10,vSlow,tGrip,do1\\WObj:=wBox; pick p10,v100,tSuck,do2\\n:=5;"
            " pick p10,[60,500,5000,1000],tSuck,do2;",
            PICK,
            {"pick_vSlow_tGrip_do1_wBox", "pick_v100_tSuck_do2", "pick_tSuck_do2"}
            | {"approach_tGrip_wBox", "approach_tSuck"},
        ),
        ("place tGrip; place tGrip;", PLACE, {"place"}),
        ("place tGrip; place tool0;", PLACE, {"place_tGrip", "place_tool0"}),
        (
            "hold di1; MoveL p10,v100,fine,tool0;",
            "PROC hold(VAR signaldi s)\nWaitDI s,1;\nENDPROC",
            {"hold"},
        ),
        (
            "FOR i FROM 1 TO 2 DO go z10; ENDFOR go fine;",
            "PROC go(zonedata z)\nMoveL p10,v100,z,tool0;\nMoveL Offs(p10,9,0,0),v100,z,tool0;\n"
            "MoveL p10,v100,fine,tool0;\nENDPROC",
            {"go_z10", "go_fine"},
        ),
        (
            "IF near(tGrip)>3 THEN place tSuck; ENDIF",
            PLACE + "\nFUNC num near(PERS tooldata t)\nMoveL p10,v50,fine,t;\nRETURN 4;\nENDFUNC",
            {"near", "place"},
        ),
    ],
)
def test_each_way_of_calling_is_a_copy_that_moves_alike(
    tmp_path: Path, main: str, routines: str, names: set[str]
) -> None:
    done = translated(tmp_path, main, routines)
    assert done.ok, [f.message for row in done.rows for f in row.reasons]
    assert done.motion is not None and done.motion.holds
    made = {q.name for q in done.compiled.program.procedures} - {"main"}
    assert made == names


@pytest.mark.parametrize(
    ("main", "routines"),
    [
        (
            "pass_on vSet;",
            "PROC pass_on(speeddata v)\nv.v_tcp:=9;\nMoveL p10,v,fine,tool0;\nENDPROC",
        ),
        (
            "vSet.v_tcp:=9; late vSet;",
            "PROC late(speeddata v)\nvSet.v_tcp:=70;\nMoveL p10,v,fine,tool0;\nENDPROC",
        ),
    ],
)
def test_what_changes_meanwhile_is_not_named_in_a_copy(
    tmp_path: Path, main: str, routines: str
) -> None:
    done = translated(tmp_path, main, routines)
    made = b"".join(done.files.values())
    assert done.ok is bool(made)
    assert not made or (done.motion is not None and done.motion.holds)


def test_a_routine_that_is_called_by_a_worked_out_name_stays_beside_its_copies(
    tmp_path: Path,
) -> None:
    done = translated(tmp_path, 'place tGrip; %"place"% tSuck;', PLACE)
    assert not done.ok
    assert [row.level for row in done.rows if row.text.startswith("PROC place")] == ["not"]


LIBRARY = """MODULE Library
CONST robtarget p10:=[[400,0,300],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
PROC pick(robtarget p,PERS tooldata t,VAR signaldo do1\\PERS wobjdata w\\VAR signaldo other)
  MoveL p,v100,fine,t\\WObj?w;
  IF Present(other) THEN
    SetDO other,1;
  ENDIF
  lengthen t;
  close do1\\twice;
ENDPROC
PROC lengthen(PERS tooldata t)
  t.tframe.trans.z:=t.tframe.trans.z+9;
ENDPROC
PROC close(VAR signaldo o\\switch twice)
  SetDO o,1;
  IF Present(twice) SetDO o,0;
ENDPROC
PROC main_of_test()
  {calls}
ENDPROC
ENDMODULE
"""


def _library(folder: Path, calls: str) -> Translation:
    (folder / "cell.toml").write_text(CELL, encoding="utf-8")
    file = folder / "library.mod"
    file.write_text(LIBRARY.format(calls=calls), encoding="utf-8", newline="\n")
    return translate(file, to="melfa-basic-6", cell=folder / "cell.toml", entry="main_of_test")


def test_a_routine_that_nothing_calls_in_a_library_has_data_of_the_program(tmp_path: Path) -> None:
    done = _library(tmp_path, "MoveL p10,v100,fine,tool0;")
    assert done.ok, [f.message for row in done.rows for f in row.reasons]
    (told,) = [f.message for row in done.rows for f in row.reasons if f.code == "RA347"]
    assert "`t`, `do1`, `w`, never `\\other`" in told
    made = b"".join(done.files.values()).decode("ascii")
    assert made.count("M_Out(1)=") == 2
    assert "Function V pick(" in made


def test_a_routine_of_a_library_that_is_called_has_what_it_is_given(tmp_path: Path) -> None:
    done = _library(tmp_path, "close do1; close do2;")
    names = {q.name for q in done.compiled.program.procedures}
    assert {"close_do1", "close_do2"} < names
    told = [f.message for row in done.rows for f in row.reasons if f.code == "RA347"]
    assert len(told) == 1
    assert "`pick`" in told[0]


def test_a_routine_that_nothing_calls_is_left_out_of_a_program(tmp_path: Path) -> None:
    done = translated(tmp_path, "MoveL p10,v100,fine,tool0;", PLACE)
    assert done.ok
    assert "RA346" in [f.code for row in done.rows for f in row.reasons]


PARTS = """FUNC num reach(tooldata t,num more)
  RETURN inner(t)+more;
ENDFUNC
FUNC num inner(tooldata t)
  RETURN t.tframe.trans.z;
ENDFUNC
PROC longer(INOUT tooldata t,num by)
  t.tframe.trans.z:=t.tframe.trans.z+by;
ENDPROC
PROC go(num z)
  MoveL Offs(p10,0,0,z),v100,fine,tGrip;
ENDPROC"""


def test_a_routine_takes_the_parts_of_a_tool_that_no_move_has(tmp_path: Path) -> None:
    main = """VAR tooldata own;
own:=tSuck;
own.tframe.trans.x:=30;
longer own,7;
go reach(own,2);
longer tGrip,20;
go reach(tGrip,3);"""
    done = translated(tmp_path, main, PARTS)
    assert done.ok, [f.message for row in done.rows for f in row.reasons]
    assert done.motion is not None and done.motion.holds
    assert done.motion.found is not None and done.motion.found.visits >= 2
