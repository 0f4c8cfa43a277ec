"""Interrupts of RAPID in MELFA-BASIC, run on both sides."""

from __future__ import annotations

import pytest

from assistant.base.source_text import SourceText
from assistant.compiler import translate
from assistant.compiler.cell_defaults import with_neutral_cell
from assistant.compiler.loader import load_text
from assistant.compiler.motion_proof import Proving
from assistant.compiler.translation import Translation

MODULE = r"""MODULE Cell
VAR intnum opened;
VAR intnum other;
VAR num count;
VAR num ticks;
PERS num mode:=0;
PERS bool busy:=FALSE;
CONST robtarget a:=[[400,0,400],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
PROC main()
count:=0;
ticks:=0;
mode:=0;
busy:=FALSE;
{main}
SetGO goCount,count;
SetGO goTicks,ticks;
ENDPROC
TRAP answer
{answer}
ENDTRAP
TRAP tick
Incr ticks;
ENDTRAP
PROC twice(INOUT num n)
n:=n*2;
ENDPROC
ENDMODULE
"""
WAIT = "WaitTime 2;\n"
CONNECTED = "CONNECT opened WITH answer;\n"
TICKING = "CONNECT other WITH tick;\n"
OPENED = f"{CONNECTED}ISignalDI diDoor,1,opened;\n"


def crossed(main: str, to: str = "melfa-basic-6", answer: str = "Incr count;") -> Translation:
    """What becomes of a module, run on both sides with inputs that change."""
    text = MODULE.format(main=main, answer=answer)
    cell = with_neutral_cell(load_text(SourceText(text), language="rapid"))
    return translate(cell, to=to, proving=Proving(seconds=2))


def written(done: Translation) -> str:
    """The lines below the heading, of a program that is whole and does the same when run."""
    reasons = [f.message for row in done.rows if row.level == "not" for f in row.reasons]
    assert not reasons, reasons
    assert done.motion is not None
    assert done.motion.holds, done.motion.findings
    assert done.motion.found is not None
    (text,) = done.compiled.files.values()
    lines = (line.partition(" ")[2].strip() for line in text.decode().splitlines())
    return "\n".join(line for line in lines if not line.startswith("'"))


@pytest.mark.parametrize(
    "to",
    [
        pytest.param("melfa-basic-4", marks=pytest.mark.slow),
        pytest.param("melfa-basic-5", marks=pytest.mark.slow),
        "melfa-basic-6",
    ],
)
def test_a_signal_that_changes_calls_the_trap(to: str) -> None:
    done = crossed(f"{OPENED}{WAIT}MoveL a,v100,fine,tool0;\n{WAIT}", to)
    lines = written(done).upper().splitlines()
    (defined,) = (line for line in lines if line.startswith("DEF ACT 1,M_IN(6)<>MOPE"))
    assert defined.endswith("GOSUB *AC1 ' DIDOOR")
    assert {"ACT 1=1", "*AC1", "RETURN 0"} <= set(lines)


@pytest.mark.parametrize(
    "main",
    [
        f"{OPENED}{WAIT}ISleep opened;\n{WAIT}IWatch opened;\n{WAIT}",
        f"{OPENED}{TICKING}ITimer 0.7,other;\n{WAIT}twice count;",
        f"{CONNECTED}IPers mode,opened;\nmode:=2;\nmode:=2;\nmode:=3;",
    ],
)
def test_both_sides_answer_alike(main: str) -> None:
    assert "Def Act 1," in written(crossed(main))


@pytest.mark.slow
@pytest.mark.parametrize(
    "main",
    [
        f"{OPENED}{WAIT}IDelete opened;\n{WAIT}",
        f"{OPENED}IDisable;\n{WAIT}IEnable;\n{WAIT}",
        f"{CONNECTED}ISignalDI \\Single,diDoor,1,opened;\n{3 * WAIT}",
        f"{CONNECTED}ISignalDI diDoor,edge,opened;\n{3 * WAIT}",
        f"{CONNECTED}ISignalDI diDoor,low,opened;\n{3 * WAIT}",
        f"{CONNECTED}ISignalGI giPart,opened;\n{2 * WAIT}",
        f"{CONNECTED}ISignalDO doLamp,1,opened;\nSet doLamp;\nReset doLamp;",
        f"{CONNECTED}IPers busy,opened;\nbusy:=TRUE;\nbusy:=FALSE;\n",
        f"{TICKING}ITimer 0.5,other;\nWaitTime 2.2;\nIDelete other;\n{WAIT}",
        f"{TICKING}ITimer \\Single,mode+1,other;\nWaitTime 2.2;\n{WAIT}",
    ],
)
def test_every_order_is_answered_alike(main: str) -> None:
    assert "Def Act 1," in written(crossed(main))


def test_an_interrupt_that_moves_the_arm_is_told() -> None:
    done = crossed(f"{OPENED}WaitTime 2;", answer="MoveL a,v100,fine,tool0;")
    reasons = [f.message for row in done.rows for f in row.reasons]
    assert any("moves the robot" in one for one in reasons)
    assert done.motion is None or not done.motion.holds


def test_a_trap_that_ends_the_cycle_ends_it_here() -> None:
    held = "IF NOT IsStopMoveAct(\\FromMoveTask) StopMove;\nClearPath;\nStartMove;"
    answer = f"IF count<3 THEN\nIncr count;\nRETURN;\nENDIF\n{held}\nExitCycle;"
    body = f"{OPENED}FOR i FROM 1 TO 3 DO\n{WAIT}ENDFOR"
    assert "Then End" in written(crossed(body, answer=answer.replace("3", "0")))
    assert "Then End" in written(crossed(body, answer=answer))


def test_a_trap_that_raises_an_error_stays_as_its_text() -> None:
    done = crossed(f"{OPENED}WaitTime 2;", answer="RAISE 12;")
    kept = [row for row in done.rows if row.level == "not"]
    assert len(kept) >= 2  # CONNECT and what orders it


def test_what_a_trap_shares_with_the_program_is_refused_where_data_are_there_once() -> None:
    main, answer = f"{OPENED}twice count;\nWaitTime 2;", "twice count;"
    assert "twice(" in written(crossed(main, answer=answer))
    old = crossed(main, "melfa-basic-5", answer)
    assert any("as what it interrupts does" in f.message for row in old.rows for f in row.reasons)


LINES = """Def Act 1,M_In(10)=1 GoSub *Disc,S
Def Act 2,{condition} GoTo *Out
Spd 100
Mvs P1
Act 1=1
Act 2=1
For M1=1 To 2
Mvs P2
Dly 1
M_Out(1)=1
Next M1
Act 1=0
Act 2=0
End
*Disc
Act 1=0
M_Out(2)=1
Return {back}
*Out
Act 2=0
Mvs P1
M_Out(3)=1
End
P1=(400,0,500,180,0,180)(7,0)
P2=(400,200,500,180,0,180)(7,0)
"""


def of_lines(condition: str, back: str = "0") -> Translation:
    text = SourceText(LINES.format(condition=condition, back=back))
    cell = with_neutral_cell(load_text(text, language="melfa-basic-5"))
    return translate(cell, to="rapid", proving=Proving(seconds=2))


@pytest.mark.parametrize("condition", ["M_In(11)=1", "M_In(11)=1 And M_In(12)=1"])
def test_what_interrupts_call_and_go_to_is_answered_by_trap_routines(condition: str) -> None:
    done = of_lines(condition)
    assert not [row for row in done.rows if row.level == "not"]
    assert done.motion is not None
    assert done.motion.holds, done.motion.findings
    (text,) = done.compiled.files.values()
    said = text.decode()
    assert "ISignalDI di_10,1,act_1;" in said
    assert ("ISignalDI di_11,1,act_2;" in said) == ("And" not in condition)
    assert "TRAP act_1_trap" in said
    assert "ExitCycle;" in said


def test_an_interrupt_that_goes_on_elsewhere_stays_as_its_text() -> None:
    done = of_lines("M_In(11)=1", back="1")
    kept = [row for row in done.rows if row.level == "not"]
    assert len(kept) >= 3  # what defines it, what switches it, and the way back


def test_an_error_of_the_program_stops_it_for_good() -> None:
    lines = "If M_In(1)=1 Then\nM_Out(1)=1\nError {0}\nEndIf\nM_Out(2)=1\nEnd\n"

    def stopped(number: int) -> Translation:
        text = SourceText(lines.format(number))
        cell = with_neutral_cell(load_text(text, language="melfa-basic-5"))
        return translate(cell, to="rapid", proving=Proving(seconds=2))

    done = stopped(9100)
    assert [row.level for row in done.rows if "Error" in row.text] == ["partial"]
    assert done.motion is not None
    assert done.motion.holds, done.motion.findings
    caution = stopped(9200)  # the program goes on
    assert [row.level for row in caution.rows if "Error" in row.text] == ["partial"]
    assert caution.motion is not None
    assert caution.motion.holds, caution.motion.findings
