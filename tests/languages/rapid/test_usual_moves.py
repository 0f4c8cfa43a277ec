"""What RobotStudio and the pendant write by default: data of the task, options without effect."""

from __future__ import annotations

from dataclasses import replace

import pytest

from assistant import languages
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.geometry import Pose
from assistant.program.motion import Blend, Speed
from assistant.program.program import Program

RAPID = languages.get("rapid")
HEAD = """MODULE cell
TASK PERS tooldata tG:=[TRUE,[[0,0,100],[1,0,0,0]],[1,[0,0,50],[1,0,0,0],0,0,0]];
TASK PERS wobjdata wA:=[FALSE,TRUE,"",[[300,-110,100],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];
TASK PERS num count:=3;
TASK VAR num turns;
CONST jointtarget jHome:=[[0,-20,20,0,90,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
CONST jointtarget jTrack:=[[0,-20,20,0,90,0],[500,9E9,9E9,9E9,9E9,9E9]];
PERS jointtarget jTaught:=[[0,-20,20,0,90,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
CONST robtarget p10:=[[50,20,50],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
"""


def lifted(body: str, more: str = "") -> Program:
    tree = RAPID.parse(f"{HEAD}PROC main()\n{body}\nENDPROC\n{more}ENDMODULE\n")
    assert tree.findings == ()
    return RAPID.lift(tree)


def first(body: str, more: str = "") -> p.Statement:
    return lifted(body, more).procedures[0].body[0]


def test_data_of_the_task_are_known_and_stay_its_own() -> None:
    program = lifted("MoveL p10,v100,fine,tG\\WObj:=wA;\nturns:=turns+count;")
    assert list(program.tools) == ["tG"]
    assert list(program.frames) == ["wA"]
    assert program.variables["count"].storage == "persistent"
    assert not program.declarations
    built = RAPID.render(RAPID.build(RAPID.adapt(program).program))
    for data in ("PERS tooldata tG", "PERS wobjdata wA", "PERS num count", "VAR num turns"):
        assert f"    TASK {data}" in built
    assert "    CONST jointtarget jHome" in built


def test_a_changed_tool_of_the_task_stays_its_own() -> None:
    program = lifted("MoveL p10,v100,fine,tG\\WObj:=wA;")
    longer = replace(program.tools["tG"], tip=Pose((0.0, 0.0, 120.0)))
    text = RAPID.render(RAPID.lower(replace(program, tools={"tG": longer})))
    assert "TASK PERS tooldata tG:=[TRUE,[[0,0,120]," in text
    unchanged = (line for line in HEAD.splitlines() if "tG" not in line)
    assert all(line in text for line in unchanged)


WRITTEN_OUT = "[[0,-20,20,0,90,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"


@pytest.mark.parametrize("joints", ["jHome", WRITTEN_OUT])
def test_no_offsets_of_external_axes_say_nothing_without_such_axes(joints: str) -> None:
    move = first(f"MoveAbsJ {joints}\\NoEOffs,v100,fine,tG;")
    assert move == first(f"MoveAbsJ {joints},v100,fine,tG;")
    assert isinstance(move, p.MoveJoints)


@pytest.mark.parametrize("joints", ["jTrack", "jTaught", "jElsewhere"])
def test_joints_that_may_move_external_axes_keep_their_text(joints: str) -> None:
    assert isinstance(first(f"MoveAbsJ {joints}\\NoEOffs,v100,fine,tG;"), p.Opaque)


def test_a_name_that_a_routine_has_for_something_else_is_not_known() -> None:
    other = "PROC other(jointtarget jHome)\nMoveAbsJ jHome\\NoEOffs,v100,fine,tG;\nENDPROC\n"
    assert isinstance(first("MoveAbsJ jHome\\NoEOffs,v100,fine,tG;", other), p.Opaque)


def test_a_load_of_none_is_that_of_the_tool() -> None:
    plain = first("MoveL p10,v100,z10,tG\\WObj:=wA;")
    assert first("MoveL p10,v100,z10,tG\\WObj:=wA\\TLoad:=load0;") == plain
    assert isinstance(first("MoveL p10,v100,z10,tG\\TLoad:=lPart;"), p.Opaque)


def test_speeds_and_zones_may_be_written_out() -> None:
    move = first("MoveL p10,[100,500,5000,1000],[FALSE,10,15,15,1.5,15,1.5],tG;")
    assert move == p.Move(
        "linear", e.Name("p10"), p.Motion(Speed(100.0), Blend(10.0), "tG", "base")
    )
    stop = first("MoveL p10,v100,[TRUE,0,0,0,0,0,0],tG;")
    assert stop == first("MoveL p10,v100,fine,tG;")
    for odd in ("[100,500,5000]", "[FALSE,10,15,15,1.5,15,1.5]"):
        assert isinstance(first(f"MoveL p10,{odd},fine,tG;"), p.Opaque)
    assert isinstance(first("MoveL p10,v100,[TRUE,5,0,0,0,0,0],tG;"), p.Opaque)


def test_speeds_and_zones_may_be_worked_out() -> None:
    move = first("MoveL p10,[2*v,500,5000,turns],[stops,r,1,2,3,4,5],tG;")
    assert isinstance(move, p.Move)
    double = e.Binary("*", e.Number(2), e.Name("v"))
    assert move.motion.speed == p.ComputedSpeed(double, external_rotary=e.Name("turns"))
    sizes = tuple(map(e.Number, range(1, 6)))
    assert move.motion.blend == p.ComputedBlend(e.Name("r"), e.Name("stops"), sizes)
    usual = "[FALSE,r,r*1.5,r*1.5,r*0.15,r*1.5,r*0.15]"
    corner = first(f"MoveL p10,v100,{usual},tG;")
    assert isinstance(corner, p.Move)
    assert corner.motion.blend == p.ComputedBlend(e.Name("r"))
