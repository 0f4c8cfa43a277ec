"""Times that programs count with their own timers, compared between two programs."""

from __future__ import annotations

from pathlib import Path

import pytest

from assistant import compare
from tests.compiler import between

HEAD = """MODULE Cell
! signal: di_3 digital input 3
! signal: di_4 digital input 4
! signal: do_5 digital output 5
PERS tooldata tGrip:=[TRUE,[[0,0,100],[1,0,0,0]],[1,[0,0,50],[1,0,0,0],0,0,0]];
CONST robtarget p1:=[[350,20,150],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
VAR clock c;
VAR num n;
VAR bool late;
PROC main()
  MoveL p1,v100,fine,tGrip;
  ClkReset c;
  ClkStart c;
"""
FOOT = """  SetDO do_5,1;
  MoveL p1,v100,fine,tGrip;
ENDPROC
ENDMODULE
"""
MELFA_HEAD = """Tool PTOOL
Spd 100
Mvs P1
M_Timer(1)=0
"""
MELFA_FOOT = """M_Out(5)=1
Mvs P1
End
PTOOL=(+0.00,+0.00,+100.00,+0.00,+0.00,+0.00)
P1=(+350.00,+20.00,+150.00,+180.00,+0.00,+180.00)(7,0)
"""
BOTH = """*LATE
If M_In(3)=1 Then *COME
If M_Timer(1)<2000 Then *LATE
*COME
"""
TOGETHER = "WHILE ClkRead(c)<2 AND di_3=0 DO\nENDWHILE\n"
UNTIL = "WaitUntil ClkRead(c)>0.5;\n"
LONG = "WHILE ClkRead(c)<600 DO\nENDWHILE\n"
DELAYED = f"WaitTime 1;\nClkReset c;\nClkStart c;\n{LONG}".replace("600", "2")
WITH_AN_INPUT = "WaitUntil ClkRead(c)>1 AND di_3=1;\n"
OR_AN_INPUT = "WHILE ClkRead(c)<5 AND di_3=0 DO\nENDWHILE\n"
READ = "late:=FALSE;\nWHILE (NOT late) AND di_3=0 DO\n  late:=ClkRead(c)>2;\nENDWHILE\n"
READ_IN_MELFA = """*LOOK
M1=M_Timer(1)
If M_In(3)=1 Then *COME
If M1<2000 Then *LOOK
*COME
"""
EITHER = "WaitUntil ClkRead(c)>2 OR di_3=1;\nIF di_3=1 n:=1;\n"
RETRY = """FOR i FROM 1 TO 3 DO
  WaitDI di_3,1\\MaxTime:=2\\TimeFlag:=late;
  IF NOT late RETURN;
ENDFOR
"""
RETRY_IN_MELFA = """For M1=1 To 3
M_Timer(1)=0
*LOOK
If M_In(3)=1 Then *GOOD
If M_Timer(1)<2000 Then *LOOK
Next M1
GoTo *FAIL
*GOOD
End
*FAIL
"""
HANDLED = """WaitDI di_3,1\\MaxTime:=2;
  RETURN;
ERROR
  n:=n+1;
  IF n<3 RETRY;
"""
TWO = "WaitUntil di_3=1 AND di_4=0\\MaxTime:=4\\TimeFlag:=late;\nIF NOT late RETURN;\n"
TWO_IN_MELFA = """M9=0
While M9=0 And M_Timer(1)<4000
If M_In(3)=1 And M_In(4)=0 Then M9=1
WEnd
If M9=1 Then End
"""
COUNTING = "n:=0;\nWHILE ClkRead(c)<60 AND n<200 DO\n  n:=n+1;\nENDWHILE\n"


def compared(folder: Path, first: str, second: str) -> str:
    """Either is the part that waits, in RAPID or in MELFA-BASIC V."""
    around = {"rapid": (HEAD, FOOT), "melfa": (MELFA_HEAD, MELFA_FOOT)}
    done = between.compared(folder, first, second, **around)
    return done.answer + "".join(f" {one.what}" for one in done.differences)


SAME = {
    "a jump, a loop": (BOTH, TOGETHER),
    "a loop, a jump": (TOGETHER, BOTH),
    "a wait until a timer": (UNTIL, "Wait M_Timer(1)>500\n"),
    "a wait, a loop": (UNTIL, "WHILE ClkRead(c)<=0.5 DO\nENDWHILE\n"),
    "ten minutes": (LONG, "While M_Timer(1)<600000\nWEnd\n"),
    "a delay before": (DELAYED, DELAYED),
    "an input that comes some time": (WITH_AN_INPUT, WITH_AN_INPUT),
    "a timer in a variable": (READ, READ_IN_MELFA),
    "a timer or an input": (EITHER, EITHER),
    "a wait that is tried again": (RETRY, RETRY_IN_MELFA),
    "an error handler that tries again": (HANDLED, HANDLED),
    "a wait for two inputs": (TWO, TWO_IN_MELFA),
    "a loop that ends by what it counts": (
        COUNTING,
        COUNTING.replace("  n:=n+1;\n", "  n:=n+2;\n  n:=n-2;\n  n:=n*1;\n  n:=n+1;\n"),
    ),
}
OTHER = {
    "a jump, a longer loop": (BOTH, TOGETHER.replace("<2", "<4")),
    "a jump, a shorter loop": (BOTH, TOGETHER.replace("<2", "<1")),
    "a loop, a longer jump": (TOGETHER, BOTH.replace("<2000", "<20000")),
    "a jump, another operator": (BOTH, TOGETHER.replace("AND", "OR")),
    "a longer wait until a timer": (UNTIL, "Wait M_Timer(1)>1000\n"),
    "in one language": (UNTIL, UNTIL.replace("0.5", "0.9")),
    "no wait at all": (UNTIL, "M_Timer(2)=0\n"),
    "a delay before": (DELAYED, DELAYED.replace("<2", "<5")),
    "an input that never comes": (OR_AN_INPUT, OR_AN_INPUT.replace("<5", "<3.5")),
    "a timer in a variable": (READ, READ_IN_MELFA.replace("2000", "6000")),
    "a timer or an input": (EITHER, EITHER.replace(">2", ">5")),
    "a wait that is tried once more": (RETRY, RETRY_IN_MELFA.replace("To 3", "To 4")),
    "a wait that is tried too often": (RETRY, RETRY.replace("TO 3", "TO 4")),
    "an error handler that tries once more": (HANDLED, HANDLED.replace("<3", "<4")),
    "a wait for two inputs": (TWO, TWO_IN_MELFA.replace("4000", "1000")),
    "twenty minutes": (LONG, LONG.replace("600", "1200")),
}


@pytest.mark.parametrize("name", SAME)
def test_the_same_time_is_equal(tmp_path: Path, name: str) -> None:
    assert compared(tmp_path, *SAME[name]) == "equal"


@pytest.mark.parametrize("name", OTHER)
def test_another_time_is_a_difference(tmp_path: Path, name: str) -> None:
    done = compared(tmp_path, *OTHER[name])
    assert done.startswith("different event") and "another longest time of a wait" in done


def test_a_timer_that_is_not_set_is_a_difference(tmp_path: Path) -> None:
    right, wrong = tmp_path / "right.mb5", tmp_path / "wrong.mb5"
    right.write_text(MELFA_HEAD + BOTH + MELFA_FOOT, encoding="utf-8")
    wrong.write_text(
        MELFA_HEAD.replace("M_Timer(1)=0", "M_Timer(2)=0") + BOTH + MELFA_FOOT, encoding="utf-8"
    )
    assert compare(right, right).equal
    assert compare(right, wrong).answer == "different"


def test_the_time_behind_an_input_is_named(tmp_path: Path) -> None:
    program = tmp_path / "behind.mod"
    for wait, named in ((f"WaitDI di_4,1;\n{UNTIL}", True), (f"{UNTIL}WaitDI di_4,1;\n", False)):
        program.write_text(HEAD + wait + FOOT, encoding="utf-8")
        line = compare(program, program).line()
        assert ("waits for timers behind inputs" in line) == named, line
