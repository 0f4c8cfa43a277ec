"""Speeds and corners that a program changes: both sides move alike, in both directions."""

from __future__ import annotations

import pytest

from tests.compiler.proven import crossed, crossed_module, moves_the_same

HEAD = """MODULE Cell
RECORD pace
  speeddata speed;
  zonedata zone;
ENDRECORD
CONST robtarget p10:=[[354,0,300],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
CONST robtarget p20:=[[354,90,300],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
VAR pace all;
VAR speeddata slow;
VAR zonedata near;
PERS speeddata air:=[200,500,5000,1000];
VAR speeddata table{2};
VAR num i;
"""


@pytest.mark.parametrize(
    ("routines", "body", "said"),
    [
        ("", "slow:=v100; slow.v_tcp:=slow.v_tcp/2; MoveL p10,slow,fine,tool0;", "Spd Mslow_v_tcp"),
        ("", "slow:=v80; MoveL p20,slow,z1,tool0; slow:=v30; MoveL p10,slow,fine,tool0;", "Spd"),
        (
            "",
            "FOR k FROM 1 TO 3 DO air.v_tcp:=100*k; MoveJ p10,air,fine,tool0; ENDFOR",
            "JOvrd Max(",
        ),
        ("", "table{1}:=v20; table{2}:=v30; i:=2; MoveL p10,table{i},fine,tool0;", "(Mi)"),
        (
            "",
            "FOR k FROM 1 TO 3 DO near:=fine; IF k=2 near:=z20; MoveL p10,v50,near,tool0;"
            " MoveL p20,v50,near,tool0; ENDFOR",
            "Cnt 1,Mnear_pzone_tcp",
        ),
        (
            "FUNC speeddata half(speeddata s) VAR speeddata r; r:=s; r.v_tcp:=s.v_tcp/2;"
            " RETURN r; ENDFUNC",
            "slow:=v100; slow.v_tcp:=90; MoveL p10,half(slow),fine,tool0;",
            "Spd Mhalf_v_tcp",
        ),
        (
            "PROC go(robtarget p,speeddata s,zonedata z) MoveL p,s,z,tool0; ENDPROC",
            "slow:=v100; slow.v_tcp:=90; near:=z1; IF i=0 near:=z5; go p10,slow,near;"
            " go p20,v20,fine;",
            "_v_tcp",
        ),
        (
            "",
            "all.speed:=v40; all.zone:=z1; MoveL p10,all.speed,all.zone,tool0; all.speed:=v60;"
            " all.zone:=fine; MoveL p20,all.speed,all.zone,tool0;",
            "Spd Mall_speed_v_tcp",
        ),
    ],
    ids=["a part", "two", "joint", "array", "zone", "function", "parameter", "record"],
)
def test_speeds_that_a_rapid_program_changes(routines: str, body: str, said: str) -> None:
    done = crossed_module(HEAD, f"{routines}\nPROC main()\n{body}\nENDPROC", runs=2)
    moves_the_same(done)
    assert said in b"".join(done.files.values()).decode("ascii")


@pytest.mark.parametrize(
    "body",
    [
        "MV=50\nSpd MV\nMvs P1\nMV=MV+10\nSpd MV*2\nMvs P2",
        "For M1=1 To 3\nSpd 10*M1\nMvs P1\nMvs P2\nNext M1",
        "MV=20\nGoSub *GO\nMV=30\nGoSub *GO\nEnd\n*GO\nSpd MV\nMvs P1\nSpd M_NSpd\nMvs P2\nReturn",
    ],
    ids=["twice", "loop", "subroutine"],
)
def test_speeds_that_a_melfa_program_changes(body: str) -> None:
    end = "" if "Return" in body else "End\n"
    text = f"{body}\n{end}P1=(354,0,300,180,0,180)(7,0)\nP2=(354,90,300,180,0,180)(7,0)\n"
    moves_the_same(crossed(text, "melfa-basic-6", "rapid", runs=2))


def test_arms_that_move_together_meet_and_move_each_by_itself() -> None:
    tasks = 'PERS tasks arms{1}:=[["T_ROB1"]];\nVAR syncident begins;\nVAR syncident ends;\n'
    body = "SyncMoveOn begins,arms;\nMoveL p10\\ID:=1,v50,fine,tool0;\nSyncMoveOff ends;"
    done = crossed_module(HEAD, f"{tasks}PROC main()\n{body}\nENDPROC")
    levels = {row.text.split()[0]: row.level for row in done.rows}
    assert levels["SyncMoveOn"] == levels["MoveL"] == levels["SyncMoveOff"] == "partial"


def test_a_tool_that_is_nowhere_stops_nothing_where_no_move_has_it() -> None:
    lost = "PERS tooldata lost:=[TRUE,[[6E7,0,0],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];\n"
    for tool, ok in (("tool0", True), ("lost", False)):
        body = f"PROC main()\nMoveL p10,v50,fine,{tool};\nENDPROC"
        assert crossed_module(HEAD, f"{lost}{body}").ok == ok


def test_the_most_that_an_arm_can_is_told_of() -> None:
    body = "slow:=v50;\nslow.v_tcp:=MaxRobSpeed()/100*i;\nMoveL p10,slow,fine,tool0;"
    done = crossed_module(HEAD, f"PROC main()\n{body}\nENDPROC", runs=2)
    assert [f.code for f in done.findings].count("RA379") == 1
    assert all(row.level != "not" for row in done.rows)
