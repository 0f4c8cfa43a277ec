"""Comparing programs that wait for ever or end early, or that only take different times."""

from __future__ import annotations

from pathlib import Path

import pytest

from assistant.compiler import translate
from assistant.compiler.comparison import Comparison
from assistant.compiler.motion_proof import Proving
from tests.compiler import between

HEAD = """MODULE Cell
! signal: di_3 digital input 3
! signal: di_4 digital input 4
! signal: do_5 digital output 5
! signal: do_6 digital output 6
PERS tooldata tGrip:=[TRUE,[[0,0,100],[1,0,0,0]],[1,[0,0,50],[1,0,0,0],0,0,0]];
CONST robtarget p1:=[[350,20,150],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
PERS bool go:=FALSE;
PERS num took:=0;
PERS string said:="";
VAR clock c;
VAR intnum i;
PROC main()
  MoveL p1,v100,fine,tGrip;
"""
FOOT = """  MoveL p1,v100,fine,tGrip;
ENDPROC
TRAP came
  SetDO do_6,1;
ENDTRAP
ENDMODULE
"""
MELFA_HEAD = "Tool PTOOL\nSpd 100\nMvs P1\n"
MELFA_FOOT = """Mvs P1
End
PTOOL=(+0.00,+0.00,+100.00,+0.00,+0.00,+0.00)
P1=(+350.00,+20.00,+150.00,+180.00,+0.00,+180.00)(7,0)
"""
DONE = "  SetDO do_5,1;\n"


def compared(folder: Path, first: str, second: str) -> Comparison:
    """Programs with such statements between two motions."""
    around = {"rapid": (HEAD, FOOT), "melfa": (MELFA_HEAD, MELFA_FOOT)}
    return between.compared(folder, first, second, **around)


@pytest.mark.parametrize("wait", ["WaitUntil go;", "WaitDO do_6,1;", "WaitUntil do_6=1;"])
def test_what_follows_a_wait_that_nothing_ends_is_not_called_equal(
    tmp_path: Path, wait: str
) -> None:
    done = compared(tmp_path, f"{wait}\n{DONE}", f"{wait}\n{DONE.replace('5,1', '5,0')}")
    assert done.answer == "not compared"
    (finding,) = [one for one in done.findings if one.code == "CO119"]
    assert finding.line == HEAD.count("\n") + 1 and "no run came further" in finding.message


def test_such_a_wait_in_a_branch_is_named(tmp_path: Path) -> None:
    wait = "IF di_3=1 THEN\n  WaitUntil go;\n  SetDO do_6,1;\nENDIF\n"
    done = compared(tmp_path, wait + DONE, wait + DONE)
    assert done.answer == "equal"
    (finding,) = [one for one in done.findings if one.code == "CO114"]
    assert finding.line == HEAD.count("\n") + 2 and "nothing that was tried" in finding.message
    twice = wait + wait.replace("di_3", "di_4")
    assert [one.code for one in compared(tmp_path, twice, twice).findings].count("CO114") == 2
    wait = wait.replace("WaitUntil go", "WaitDI di_4,1")
    assert "CO114" not in {one.code for one in compared(tmp_path, wait, wait).findings}


def test_a_wait_that_an_interrupt_ends_is_passed(tmp_path: Path) -> None:
    wait = "CONNECT i WITH came;\nISignalDI di_4,1,i;\nWaitDO do_6,1;\nIDelete i;\n"
    done = compared(tmp_path, wait + DONE, wait + DONE)
    assert done.answer == "equal" and "CO114" not in {one.code for one in done.findings}
    assert compared(tmp_path, wait + DONE, wait).answer == "different"


def test_a_program_that_ends_for_good_is_equal_to_itself(tmp_path: Path) -> None:
    assert compared(tmp_path, "EXIT;\n", "EXIT;\n").answer == "equal"
    assert compared(tmp_path, "EXIT;\n", "Stop;\n").answer == "different"
    assert compared(tmp_path, "Stop;\n", "EXIT;\n").answer == "different"


def test_what_shared_data_holds_at_an_error_is_no_difference(tmp_path: Path) -> None:
    fails = "IF di_3=1 THEN\n  took:=7;\n  RAISE 9;\nENDIF\n"
    stops = fails.replace("RAISE 9;", "Stop;\n  EXIT;")
    assert compared(tmp_path, fails + DONE, stops + DONE).answer == "equal"
    assert compared(tmp_path, fails + DONE, stops).answer == "different"


def test_looking_for_an_input_takes_no_time(tmp_path: Path) -> None:
    waits = "ClkReset c;\nClkStart c;\n" + "WaitDI di_3,1;\nWaitDI di_3,0;\n" * 4
    waits += "IF ClkRead(c)<1 SetDO do_6,1;\n"
    looks = "".join(
        f"*HIGH{k}\nIf M_In(3)=0 Then *HIGH{k}\n*LOW{k}\nIf M_In(3)=1 Then *LOW{k}\n"
        for k in range(4)
    )
    looks = f"M_Timer(1)=0\n{looks}If M_Timer(1)<1000 Then M_Out(6)=1\n"
    assert compared(tmp_path, waits, looks).answer == "equal"


def test_long_work_without_an_effect_is_work(tmp_path: Path) -> None:
    works = "For M1=1 To 60000\nNext\nM_Out(5)=1\n"
    assert compared(tmp_path, DONE, works).answer == "equal"


def test_a_time_in_shared_data_is_named(tmp_path: Path) -> None:
    takes = "ClkReset c;\nClkStart c;\n{}took:=ClkRead(c);\n" + DONE
    first, longer = takes.format(""), takes.format("go:=FALSE;\n" * 40)
    done = compared(tmp_path, first, longer)
    assert done.answer == "equal" and "times in shared data" in done.line()
    done = compared(tmp_path, first.replace("ClkRead(c)", "4"), first.replace("ClkRead(c)", "5"))
    assert done.answer == "different"


def test_an_interrupt_that_comes_with_the_last_motion_is_answered(tmp_path: Path) -> None:
    order = "CONNECT i WITH came;\nISignalDI di_4,1,i;\n"
    program = tmp_path / "cell.mod"
    program.write_text(HEAD + order + FOOT, encoding="utf-8")
    done = translate(program, to="melfa-basic-5", proving=Proving())
    assert done.motion is not None and done.motion.holds, done.motion
