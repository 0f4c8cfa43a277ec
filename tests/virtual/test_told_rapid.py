"""Instructions of RAPID alone: what is said for them elsewhere does the same when both are run."""

from __future__ import annotations

from pathlib import Path as FilePath

import pytest

from assistant import translate
from assistant.base.source_text import SourceText
from assistant.compiler.loader import load_text
from tests.virtual import rapid_words
from tests.virtual.test_translated_cases import HEAD
from tests.virtual.test_translated_rapid import says_the_same

SIX = "melfa-basic-6"
SCENARIOS: tuple[dict[str, float], ...] = ({}, {"di1": 1.0}, {"di1": 1.0, "giorder": 5.0})
THERE = "MoveL p10,v100,fine,tGripper;"
CASES = {
    "pulses": r"""PulseDO do1;
PulseDO\PLength:=0.5,do1;
PulseDO\High,doDone;
SetDO doGrip,1;
PulseDO doGrip;
PulseDO doGrip;""",
    "an inverted output": """FOR i FROM 1 TO 3 DO
InvertDO do1;
ENDFOR
IF di1=1 InvertDO do1;""",
    "settings that tune the motion": r"""ConfJ\Off;
ConfL\Off;
SingArea\Wrist;
AccSet 40,70;
VelSet 50,600;
PathAccLim TRUE\AccMax:=4,FALSE;
SoftAct 3,20;
SoftDeact;
MotionSup\Off;
MoveL p10,v100,z10,tGripper;
SingArea\LockAxis4;
MoveL Offs(p10,0,0,20),v100,fine,tGripper;""",
    "speeds and corners beside their data": r"""MoveL p10,v100\V:=40,fine,tGripper;
MoveL Offs(p10,20,0,0),v100,z10\Z:=4,tGripper;
MoveL\Conc,Offs(p10,20,20,0),v200,fine,tGripper;
SetDO do1,1;""",
    "moves that do something at their ends": """MoveLDO p10,v100,fine,tGripper,do1,1;
MoveJDO Offs(p10,10,0,0),v100,fine,tGripper,do1,0;
MoveCDO Offs(p10,20,10,0),Offs(p10,10,30,0),v100,fine,tGripper,doDone,1;""",
    "waits that tell by a flag that they were too long": r"""VAR bool late;
WaitDI di1,1\MaxTime:=3\TimeFlag:=late;
IF late SetDO do1,1;
WaitUntil di1=1 AND GInput(giOrder)=5\MaxTime:=2\TimeFlag:=late\PollRate:=0.05;
IF late SetDO doDone,1;""",
    "moves that are held while none is made": r"""VAR bool taken;
StopMove;
ClearPath;
StorePath;
RestoPath;
StartMove;
MoveL Offs(p10,0,0,20),v100,fine,tGripper;
PDispOff;""",
    "routines by their names as texts": r"""VAR string s:="part2";
%"Cell:part1"%;
%s%;
FOR i FROM 1 TO 2 DO
CallByVar "part",i;
ENDFOR
%"part"+NumToStr(1,0)%;
ENDPROC
PROC part1()
SetDO do1,1;
ENDPROC
PROC part2()
SetDO do1,0;""",
    "a routine of a module by its name": r"""VAR string modules{2}:=["Cell","Cell"];
%modules{1}+":part3"% 2\More:=1;
%"Ce"+"ll:part3"% 0;
ENDPROC
PROC part3(num n\num More)
IF Present(More) n:=n+More;
IF n=3 SetDO do1,1;
IF n=0 SetDO doDone,1;""",
    "a signal by a second name": r"""AliasIO do1,alOut;
SetDO alOut,1;
IF alOut=1 SetDO doDone,1;
Reset alOut;""".replace("\\\\", "\\"),
    "the date and the time of day": r"""VAR string day;
day:=CDate()+" "+CTime();
IF StrPart(day,1,8)="2026-01-" AND StrLen(day)=19 SetDO do1,1;
WaitTime 1.5;
IF GetTime(\Hour)=0 AND GetTime(\Sec)=1 SetDO doDone,1;
Save "Cell"\FilePath:="HOME:/cell.mod";""".replace("\\\\", "\\"),
    "a wait that people are told of": r"""WaitDI di1,0\Visualize\Header:="Part"\Message:="wait";
WaitUntil\InPos,TRUE;""",
}
ALIAS = "LOCAL VAR signaldo alOut;\n"
TO_DATA = {name: f"{THERE}\n{body}" for name, body in CASES.items()}


@pytest.mark.parametrize("name", CASES)
def test_it_does_the_same(name: str, tmp_path: FilePath) -> None:
    text = f"{HEAD}{ALIAS}PROC main()\n{TO_DATA[name]}\nENDPROC\nENDMODULE\n"
    says_the_same((name, text, SCENARIOS), SIX, tmp_path)


def written(body: str, tmp_path: FilePath) -> tuple[str, list[str]]:
    """The program of a body, and the codes of what is found."""
    process = tmp_path / "cell.process.toml"
    process.write_text(rapid_words.process_file(), encoding="utf-8")
    text = f"{HEAD}PROC main()\n{body}\nENDPROC\nENDMODULE\n"
    found = translate(load_text(SourceText(text), process=process, language="rapid"), to=SIX)
    texts = [data.decode("utf-8") for data in found.files.values()]
    return "\n".join(texts), [one.code for one in found.findings]


def test_an_output_that_is_only_pulsed_is_taken_to_be_off(tmp_path: FilePath) -> None:
    text, codes = written(r"PulseDO\PLength:=0.5,do1;", tmp_path)
    assert "M_Out(6)=1 Dly 0.5" in text
    assert "RA314" in codes
    assert "If " not in text


def test_the_module_of_a_late_call_is_told(tmp_path: FilePath) -> None:
    body = 'VAR string m:="Cell";\n%m+":part"%;\nENDPROC\nPROC part()\nSetDO do1,1;'
    text, codes = written(body, tmp_path)
    assert "RA394" in codes
    assert "M_Out(6)=1" in text
    _, codes = written('%"Other"+":part"%;\nENDPROC\nPROC part()\nSetDO do1,1;', tmp_path)
    assert "MB209" in codes


def test_a_group_is_set_and_a_procedure_called_at_the_end_of_a_move(tmp_path: FilePath) -> None:
    move = """MoveLGO p10,v100,fine,tGripper,goSlot\\Value:=5;
MoveLSync p10,v100,fine,tGripper,"there";
ENDPROC
PROC there()
SetDO doDone,1;"""
    lines = written(move, tmp_path)[0].splitlines()
    plain = [line.split(" ", 1)[1] for line in lines if line[:1].isdigit()]
    at = plain.index("Mvs p10")
    assert plain[at + 1].startswith("M_Out8(24)=")
    assert plain[at + 2 : at + 4] == ["Mvs p10", "GoSub *there"]


@pytest.mark.parametrize(
    ("behind", "code"),
    [
        ("WaitTime 0.5;\nMoveL p10,v100,fine,tGripper;", "RA472"),
        ("FOR i FROM 1 TO 2 DO\nWaitTime 1;\nENDFOR", "RA472"),
        ("WaitTime 0.2;\nSetDO doDone,1;\nMoveL p10,v100,fine,tGripper;", "RA473"),
        ("MoveLDO p10,v100,fine,tGripper,doDone,1;", "RA473"),
    ],
)
def test_a_program_waits_for_an_output_set_later(
    behind: str, code: str, tmp_path: FilePath
) -> None:
    text, codes = written(f"SetDO\\SDelay:=0.5,do1,0;\n{behind}", tmp_path)
    assert {"RA472", "RA473"} & {*codes} == {code}
    assert bool(text) is (code == "RA472")
    # No manual says what `M_Out(6)=1 Dly 0.5` leaves of an output that is on.
    assert " Dly 0.5" in text or not text
    assert "M_Out(6)=1" not in text.replace("If M_Out(6)=1 ", "")


def test_an_output_set_later_is_proved(tmp_path: FilePath) -> None:
    body = "SetDO do1,1;\nSetDO\\SDelay:=0.5,do1,0;\nWaitTime 1;\nSetDO doDone,1;"
    says_the_same(
        ("later", f"{HEAD}PROC main()\n{body}\nENDPROC\nENDMODULE\n", SCENARIOS), SIX, tmp_path
    )


@pytest.mark.parametrize(
    ("body", "told"),
    [
        ("VelSet 50,600;\nMoveL p10,v100,fine,tGripper;", False),
        ("VelSet 50,600;\nMoveL p10,v2000,fine,tGripper;", False),
        ("AccSet 50,60;", True),
        ("ActUnit STN1;", True),
        ("PDispOff;", False),
        ("MoveLDO p10,v100,fine,tGripper,do1,1;", False),
        ("MoveLDO p10,v100,z10,tGripper,do1,1;", True),
    ],
)
def test_what_is_lost_is_told(body: str, told: bool, tmp_path: FilePath) -> None:
    text, codes = written(body, tmp_path)
    assert text
    assert ("RA311" in codes) is told


@pytest.mark.parametrize(
    "body",
    [
        "EOffsSet [1,0,0,0,0,0];\nMoveAbsJ [[0,0,0,0,30,0],[5,9E9,9E9,9E9,9E9,9E9]]\\NoEOffs,"
        "v100,fine,tGripper;",
        "MoveL p10,v100\\T:=5,fine,tGripper;",
        "SetDO\\SDelay:=0.5,do1,reg1;",
    ],
)
def test_what_cannot_be_said_stays(body: str, tmp_path: FilePath) -> None:
    text, codes = written(body, tmp_path)
    assert not text
    assert "MB209" in codes


DATA = """TASK PERS welddata weld1:=[7,0,[1,2]];
TASK PERS seamdata seam1:=[0,0];
PERS tasks both{2}:=[["T_ROB1"],["T_ROB2"]];
VAR syncident there;
"""


def plain(body: str, tmp_path: FilePath) -> list[str]:
    """The lines that are said, behind the heading, without their numbers."""
    process = tmp_path / "cell.process.toml"
    more = "\n[signals.arc_on]\nnumber = 11\n"
    process.write_text(rapid_words.process_file() + more, encoding="utf-8")
    text = f"{HEAD}{DATA}PROC main()\n{body}\nENDPROC\nENDMODULE\n"
    found = translate(load_text(SourceText(text), process=process, language="rapid"), to=SIX)
    (data,) = found.files.values()
    lines = [line.partition(" ")[2] for line in data.decode().splitlines() if line[:1].isdigit()]
    return [line for line in lines if not line.startswith("'")]


def test_a_weld_is_moves_at_its_speed_and_an_output(tmp_path: FilePath) -> None:
    arc = """ArcLStart p10,v100,seam1,weld1\\Weave:=w1,z10,tGripper;
ArcL Offs(p10,10,0,0),v100,seam1,weld1,z1,tGripper\\Track:=tr1;
ArcLEnd Offs(p10,20,0,0),v100,seam1,weld1,fine,tGripper;"""
    lines = plain(arc, tmp_path)
    said = [line for line in lines if line.startswith(("Mvs", "M_Out", "Spd"))]
    assert said == [
        "Spd 100",
        "Mvs p10",
        "M_Out(11)=1 ' arc_on",
        "Spd 7",
        "Mvs p10+(10,0,0,0,0,0)",
        "Mvs p10+(20,0,0,0,0,0)",
        "M_Out(11)=0 ' arc_on",
    ]


def test_tasks_meet_by_a_count_that_they_share(tmp_path: FilePath) -> None:
    lines = plain("WaitSyncTask there,both;\nSetDO do1,1;", tmp_path)
    assert [line.replace("_", "").upper() for line in lines] == [
        "MALLTHERE=(FIX(MTHERE/2)+1)*2",
        "MTHERE=MTHERE+1",
        "WAIT MTHERE>=MALLTHERE",
        "MOUT(6)=1 ' DO1",
        "END",
    ]


def test_a_weld_whose_speed_changes_is_moves_at_the_speed_that_it_has(tmp_path: FilePath) -> None:
    none = "[0,0,0,0,0,0,0,0,0]"
    text = f"""{HEAD}TASK PERS welddata weld1:=[7,0,{none},{none}];
TASK PERS seamdata seam1:=[0,0,{none},0,0,0,0,0,{none},0,0,{none},0,0,{none},0];
PROC main()
weld1.weld_speed:=weld1.weld_speed*2;
seam1.purge_time:=1;
ArcL Offs(p10,10,0,0),v100,seam1,weld1,z1,tGripper;
ENDPROC
ENDMODULE
"""
    process = tmp_path / "cell.process.toml"
    process.write_text(rapid_words.process_file() + "\n[signals.arc_on]\nnumber = 11\n", "utf-8")
    found = translate(load_text(SourceText(text), process=process, language="rapid"), to=SIX)
    assert found.ok, [f"{f.code} {f.message}" for f in found.findings]
    (data,) = found.files.values()
    assert b"Spd Mweld1_weld_speed" in data
