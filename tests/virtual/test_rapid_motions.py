"""Motions, positions and signals of interpreted RAPID against values worked out by hand."""

from __future__ import annotations

import math

import pytest

from assistant.program.geometry import Pose
from assistant.robots import get
from assistant.virtual.events import Moved, Said, Switched, Waited
from tests.virtual.rapid_cell import flanges, near, ran, said


def test_the_flange_of_a_tool_in_a_work_object() -> None:
    first, second = flanges("MoveL p10,v100,fine,tGrip;\nMoveL p20,v100,z10,tGrip\\WObj:=wTable;")
    near(first, (350, 20, 400), (0, 0, 1, 0))  # the tool points down, 100 mm below the flange
    assert second is not None
    assert second.position == pytest.approx((380, 70, 230), abs=1e-3)  # x of the table is y here


def test_a_tool_in_the_room_meets_the_part_that_the_robot_holds() -> None:
    (flange,) = flanges("MoveL p20,v100,fine,tRoom\\WObj:=wPart;")
    assert flange is not None
    part = flange @ Pose((0, 0, 30)) @ Pose((10, 20, 30), (0, 0, 1, 0))
    near(part, (600, 0, 400), (1, 0, 0, 0))
    assert ran("MoveL p20,v100,fine,tRoom;").ended == "error"


def test_offsets() -> None:
    found = flanges(
        "MoveL Offs(p10,1,2,3),v100,fine,tool0;\nMoveL RelTool(p10,1,2,3),v100,fine,tool0;\n"
        "MoveL RelTool(p10,0,0,0\\Rx:=90\\Rz:=90),v100,fine,tool0;"
    )
    near(found[0], (351, 22, 303), (0, 0, 1, 0))
    near(found[1], (349, 22, 297), (0, 0, 1, 0))  # turned half round about y
    half = math.sqrt(0.5)
    turned = Pose((350, 20, 300), (0, 0, 1, 0)) @ Pose((0, 0, 0), (half, half, 0, 0))
    near(found[2], (350, 20, 300), (turned @ Pose((0, 0, 0), (half, 0, 0, half))).quaternion)


def test_poses() -> None:
    main = """VAR pose a:=[[1,2,3],[0.707107,0,0,0.707107]];
VAR pose b;
b:=PoseMult(a,[[10,0,0],[1,0,0,0]]);
TPWrite ""\\Num:=Round(b.trans.y\\Dec:=3);
b:=PoseMult(PoseInv(a),a);
TPWrite ""\\Num:=Round(VectMagn(b.trans)\\Dec:=3);"""
    assert said(main) == ["12", "0"]


def test_a_position_is_read_in_the_tool_and_work_object_of_the_latest_move() -> None:
    main = """VAR robtarget here;
MoveL p20,v100,fine,tGrip\\WObj:=wTable;
here:=CRobT();
TPWrite ""\\Pos:=[Round(here.trans.x),Round(here.trans.y),Round(here.trans.z)];
here:=CRobT(\\Tool:=tool0);
TPWrite ""\\Pos:=[Round(here.trans.x),Round(here.trans.y),Round(here.trans.z)];
here:=CRobT(\\Tool:=tGrip\\WObj:=wobj0);
TPWrite ""\\Pos:=[Round(here.trans.x),Round(here.trans.y),Round(here.trans.z)];"""
    assert said(main) == ["[10,20,30]", "[10,20,130]", "[380,70,130]"]
    assert ran('TPWrite ""\\Pos:=CPos();').ended == "unknown"
    assert said(
        'TPWrite ""\\Pos:=CPos(\\Tool:=tGrip\\WObj:=wobj0);', start=Pose((1, 2, 103), (0, 1, 0, 0))
    ) == ["[1,2,3]"]


def test_arcs_displacements_and_speeds() -> None:
    main = """VelSet 50,80;
MoveC p10,Offs(p10,10,0,0),v100,z10,tool0;
MoveL p10,v300\\V:=200,z10\\Z:=3,tool0;
VelSet 100,5000;
MoveL p10,vmax,z50\\Inpos:=inpos50,tool0;"""
    arc, line, fast = (e for e in ran(main, data="").events if isinstance(e, Moved))
    assert (arc.kind, arc.speed, arc.blend) == ("circular", 50, 10)
    assert arc.via is not None and arc.via.position == (350, 20, 300)
    assert (line.speed, line.blend, fast.speed, fast.blend) == (80, 3, 5000, 0)
    (moved,) = flanges("PDispSet [[0,0,5],[1,0,0,0]];\nMoveL p10,v100,fine,tool0;")
    near(moved, (350, 20, 305), (0, 0, 1, 0))


def test_joints() -> None:
    found = ran("MoveAbsJ jHome\\NoEOffs,v100,fine,tGrip;").events[0]
    assert isinstance(found, Moved)
    assert (found.joints, found.flange) == ((0, -20, 20, 0, 90, 0), None)
    assert found.tool.position == (0, 0, 100)
    robot = get("irb1200-7-0.7")
    main = """VAR pos at;
VAR jointtarget joints;
MoveAbsJ jHome,v100,fine,tool0;
at:=CPos();
joints:=CJointT();
TPWrite ""\\Num:=Round(at.x);
TPWrite ""\\Num:=joints.robax.rax_2;"""
    x = robot.fk([[0, -20, 20, 0, 90, 0]])[0][0, 0]
    assert said(main, robot=robot) == [f"{x:.0f}", "-20"]


# ----------------------------------------------------------------------------------- signals


def test_outputs_and_waits() -> None:
    main = "SetDO doA,1;\nSet doB;\nReset doA;\nSetGO goC,5;\nInvertDO doB;\n"
    main += "WaitTime\\InPos,0.5;\nPulseDO doB;"
    assert ran(main).events == (
        *(Switched("doa", 1), Switched("dob", 1), Switched("doa", 0), Switched("goc", 5)),
        *(Switched("dob", 0), Waited(0.5), Switched("dob", 1), Switched("dob", 0, after=0.2)),
    )


def test_inputs_are_as_they_were_given() -> None:
    main = 'IF diA=1 AND DInput(diB)=0 THEN\nTPWrite "a";\nENDIF\nWaitUntil giC=5;\nWaitDI diB,1;'
    found = ran(main, inputs={"dia": 1, "gic": 5})
    assert (found.events, found.ended) == ((Said("a"),), "stopped")
    assert "diB" in found.message or "dib" in found.message
    assert ran(main, inputs=lambda name: {"dia": 1, "dib": 0, "gic": 4}[name]).ended == "stopped"
    flag = 'VAR bool late;\nWaitDI diB,1\\MaxTime:=2\\TimeFlag:=late;\nIF late TPWrite "late";'
    assert ran(flag).events == (Waited(2, limit=True), Said("late"))
    assert ran("WaitDI diB,1\\MaxTime:=2;").ended == "error"


def test_clocks_count_stated_delays() -> None:
    data = "VAR clock c;"
    main = "ClkReset c;\nClkStart c;\nWaitTime 2;\nClkStop c;\nWaitTime 1;\n"
    assert said(main + 'TPWrite ""\\Num:=ClkRead(c);', data=data) == ["2"]


def test_tables_of_targets_and_moves_run_as_their_text() -> None:
    rows = "".join(
        f"CONST robtarget q{i}:=[[{i},0,0],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];\n"
        for i in range(20)
    )
    moves = "".join(f"MoveL q{i},v50,z1,tGrip\\WObj:=wTable;\n" for i in range(20))
    found = ran(moves, data=rows)
    assert [
        event.flange.position[1]
        for event in found.events
        if isinstance(event, Moved) and event.flange
    ] == (pytest.approx([60.0 + i for i in range(20)], abs=1e-3))
