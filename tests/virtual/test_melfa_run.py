"""What programs of MELFA-BASIC do, worked out by hand from the manuals' words."""

from __future__ import annotations

import pytest

from assistant import languages
from assistant.virtual import melfa
from assistant.virtual.events import Stopped, Waited
from tests.virtual.melfa_cell import POSITIONS, START, moves, outputs, run, shown, value

# ------------------------------------------------------------------------------------- numbers


@pytest.mark.parametrize(
    ("expression", "result"),
    [
        ("7.6\\2", 4),  # 8 \ 2
        ("7\\2", 3),
        ("7.6 Mod 5", 3),  # 8 Mod 5
        ("7/2", 3.5),
        ("2+3*4", 14),
        ("-2^2", -4),  # the power before the sign
        ("10-4-3", 3),
        ("12\\5*2", 1),  # 12 \ (5*2): the product binds more than the whole quotient
        ("17 Mod 12\\5", 1),  # 17 Mod (12\5)
        ("10+17 Mod 7", 13),
        ("12 And 10", 8),
        ("12 Or 10", 14),
        ("12 Xor 10", 6),
        ("6 Or 3 And 1", 7),  # And before Or
        ("1 Xor 3 Or 2", 2),  # Or before Xor
        ("(2>1)+5", 6),
        ("1<<3", 8),
        ("&HFF And &B1010", 10),
        ("CInt(1.5)", 2),
        ("CInt(-1.5)", -2),
        ("Fix(-1.5)", -1),
        ("Int(-1.5)", -2),
        ("Sgn(-3)", -1),
        ("Max(1,7,3)", 7),
        ("Min(1,7,3)", 1),
        ("Sqr(16)", 4),
        ("Deg(M_PI)", 180),
        ("Atn2(1,1)*4/M_PI", 1),
        ("Len(\"abc\")+Asc(\"A\")", 68),
        ("Val(\"&H1F\")+Val(\"12.5\")", 43.5),
        ("StrPos(\"abcd\",\"cd\")", 3),
        ("Dist(P1,P3)", 100),
    ],
)  # fmt: skip
def test_numbers(expression: str, result: float) -> None:
    assert value(expression) == pytest.approx(result, abs=1e-3)


def test_whole_variables_round_what_they_are_given() -> None:
    assert value("M1", "Def Inte M1\nM1=7.5") == 8
    assert value("M1%", "M1%=7/2") == 4
    assert value("M1", "M1=7/2") == 3.5


def test_a_subscript_is_rounded() -> None:
    assert value("M1(1.6)", "Dim M1(3)\nM1(1)=10\nM1(2)=20") == 20


def test_arrays_begin_at_one() -> None:
    done = run("Dim M1(3)\nM1(0)=1\nEnd")
    assert done.ended == "error" and done.message.startswith("error 4370")


@pytest.mark.parametrize(
    "text", ["Mvs P8", "M1=M2+1", "Dim M1(3)\nM2=M1(2)", "P8=P9*P1", "C1$=C2$+\"x\""]
)  # fmt: skip
def test_what_was_never_set_is_an_error(text: str) -> None:
    done = run(f"Mvs P1\n{text}\nMvs P2\nEnd")
    assert done.ended == "error" and done.message.startswith("error 3700")
    assert len(moves(done)) == 1


@pytest.mark.parametrize(
    ("condition", "holds"),
    [
        ("2", True), ("0", False), ("M_In(1)", False), ("M_In(2)", True),
        ("1=1 And 2=2", True), ("Not (1=1)", False), ("1=2 Or M_In(2)=1", True),
        ("\"ab\"<\"b\"", True), ("2 And 1", False), ("1=1 Xor 2=2", False),
    ],
)  # fmt: skip
def test_conditions(condition: str, holds: bool) -> None:
    done = run(f"If {condition} Then Mvs P1 Else Mvs P2\nEnd", inputs={2: 1})
    assert shown(done) == [(400, 0, 500) if holds else (450, 50, 500)]


@pytest.mark.parametrize(
    "text",
    [
        "M1=2\nFor M2=1 To 60\nM1=M1*M1\nNext M2",
        "M1=9^999", "M1=Exp(1000)", "M1=Val(\"&HG\")", "M1=0^(-1)", "C1$=Str$(1.5)",
    ],
)  # fmt: skip
def test_numbers_that_are_none_do_not_stop_the_interpreter(text: str) -> None:
    assert run(f"{text}\nEnd").ended == "unknown"


@pytest.mark.parametrize(
    "text", ["C1$=Chr$(300)", "M1=Sin(1,2)", "Tool", "M1=Len(3)", "Cnt 2", "M1=Sqr(-1)"]
)
def test_arguments_that_a_controller_refuses(text: str) -> None:
    assert run(f"{text}\nEnd").ended == "error"


@pytest.mark.parametrize("text", ["M1=-7\\2", "M1=-7 Mod 3", "M1=1/0", "M1=Rnd(0)", "M1=M_Uar"])
def test_what_nothing_tells_is_not_guessed(text: str) -> None:
    assert run(f"{text}\nEnd").ended == "unknown"


# ----------------------------------------------------------------------------------------- flow


@pytest.mark.parametrize(
    ("head", "turns"),
    [
        ("For M1=1 To 3", 3), ("For M1=3 To 1", 0), ("For M1=3 To 1 Step -1", 3),
        ("For M1=0 To 1 Step 0.25", 5), ("For M1=2 To 2", 1), ("For M1=M2 To M3 Step M4", 3),
    ],
)  # fmt: skip
def test_a_loop_is_tested_before_its_first_turn(head: str, turns: int) -> None:
    done = run(f"M2=5\nM3=1\nM4=-2\n{head}\nMvs P1\nNext M1\nEnd")
    assert len(moves(done)) == turns


def test_one_next_closes_two_loops() -> None:
    text = "M3=0\nFor M1=1 To 2\nFor M2=1 To 3\nM3=M3+1\nNext M2,M1"
    assert value("M3", text) == 6


def test_behind_a_loop_its_variable_is_one_step_further() -> None:
    assert value("M1", "For M1=1 To 3\nNext M1") == 4


def test_while_and_break() -> None:
    text = "M1=0\nWhile 1\nM1=M1+1\nIf M1=4 Then Break\nWEnd"
    assert value("M1", text) == 4


def test_break_leaves_the_innermost_block() -> None:
    text = "M1=0\nWhile M1<3\nM1=M1+1\nIf M1>0 Then\nBreak\nM1=100\nEndIf\nWEnd"
    assert value("M1", text) == 3


def test_blocks() -> None:
    text = "If M1=1 Then\nM2=10\nElseIf M1=2 Then\nM2=20\nElse\nM2=30\nEndIf"
    assert [value("M2", f"M1={i}\n{text}") for i in (1, 2, 3)] == [10, 20, 30]


def test_select() -> None:
    text = (
        "Select M1\nM2=-1\nCase 1\nM2=10\nBreak\nM2=11\nCase 2 To 4\nM2=20\n"
        "Case Is >7\nM2=30\nDefault\nM2=40\nEnd Select"
    )
    assert [value("M2", f"M1={i}\n{text}") for i in (1, 2, 4, 8, 6)] == [10, 20, 20, 30, 40]


def test_subroutines_and_an_early_return() -> None:
    text = (
        "M1=0\nGoSub *A\nGoSub *A\nMvs P1+(0,0,1,0,0,0)(0,0)\nEnd\n"
        "*A\nM1=M1+1\nIf M1=2 Then Return\nGoSub *B\nReturn\n*B\nMvs P2\nReturn"
    )
    assert shown(run(text)) == [(450, 50, 500), (400, 0, 501)]


def test_return_needs_a_gosub() -> None:
    assert run("Return\nEnd").message.startswith("error 3840")


@pytest.mark.parametrize(
    ("which", "ends"), [("1", "P1"), ("1.6", "P2"), ("0", ""), ("3", ""), ("-1", "error")]
)
def test_jumps_by_number(which: str, ends: str) -> None:
    done = run(f"M1={which}\nOn M1 GoSub *A,*B\nEnd\n*A\nMvs P1\nReturn\n*B\nMvs P2\nReturn")
    where = {"P1": [(400, 0, 500)], "P2": [(450, 50, 500)]}.get(ends, [])
    assert shown(done) == where and (done.ended == "error") == (ends == "error")


def test_steps_are_places_of_jumps_in_four() -> None:
    done = run("10 GOTO 40\n20 MVS P1\n30 END\n40 MVS P2\n50 END", level=4)
    assert shown(done) == [(450, 50, 500)]


def test_a_loop_without_an_end_is_over_at_some_time() -> None:
    done = run("*L\nGoTo *L", most_steps=50)
    assert done.ended == "steps"


def test_a_program_goes_on_after_a_halt() -> None:
    done = run("Hlt\nDly 0.5\nMvs P1\nEnd\nMvs P2")
    assert done.events[:2] == (Stopped(), Waited(0.5)) and len(moves(done)) == 1


# ------------------------------------------------------------------------------------- signals


def test_outputs_and_groups() -> None:
    done = run("M_Out(9)=1\nM_Outb(16)=5\nM_Out(30)=M_Outb(16) And 1\nEnd", level=5)
    bits = [(str(16 + i), float(v)) for i, v in enumerate((1, 0, 1, 0, 0, 0, 0, 0))]
    assert outputs(done) == [("9", 1), *bits, ("30", 1)]


def test_inputs_in_groups() -> None:
    done = run("M_Outb(0)=M_Inb(8)\nEnd", inputs={8: 1, 10: 1})
    assert [n for n, v in outputs(done) if v] == ["0", "2"]


def test_names_of_signals() -> None:
    done = run(
        "Def Io GRP=Byte,16\nDef Io DONE=Bit,3\nDONE=1\nM1=GRP\nM_Out(4)=M1-2\nEnd",
        inputs={16: 1, 17: 1},
    )
    assert outputs(done) == [("3", 1), ("4", 1)]


def test_a_pulse_goes_back() -> None:
    assert outputs(run("M_Out(9)=1 Dly 0.5\nEnd")) == [("9", 1), ("9", 0)]


def test_hands() -> None:
    assert outputs(run("HOpen 1\nHClose 1\nEnd")) == [("hand1", 1), ("hand1", 0)]


def test_a_wait_for_an_input_that_never_comes() -> None:
    assert run("Wait M_In(1)=1\nMvs P1\nEnd").ended == "stopped"
    assert run("Wait M_In(1)=1\nMvs P1\nEnd", inputs={1: 1}).ended == "end"


def test_a_timer_counts_milliseconds() -> None:
    done = run("M_Timer(1)=0\nDly 2\nIf M_Timer(1)>=2000 And M_Timer(1)<3000 Then Mvs P1\nEnd")
    assert len(moves(done)) == 1


def test_what_a_motion_is_given_to_do() -> None:
    done = run("Mvs P1 Wth M_Out(17)=1\nMvs P2 WthIf M_In(3)=1,M_Out(18)=1\nEnd")
    assert outputs(done) == [("17", 1)] and len(moves(done)) == 2


# ----------------------------------------------------------------------------------- functions


def test_functions_take_copies_or_references() -> None:
    text = """
Function M Twice(ByVal M1,ByRef M2)
M1=M1+1
M2=M2+M1
Twice=2*M1
FEnd
Function Main
Dim MA(2)
MX=3
MA(1)=10
MY=Twice(MX,MA(1))
P9=P1+(0,0,0,0,0,0)(0,0)
P9.X=MX
P9.Y=MY
P9.Z=MA(1)
Mvs P9
FEnd
"""
    assert shown(run(text, 6)) == [(3, 8, 14)]


def test_variables_of_a_function_are_its_own() -> None:
    text = """
Def Float MG
Function V Count()
Static Def Inte MS
If MG>1 Then
MS=MS+1
Else
MS=1
EndIf
ML=MS
MG=MG+ML
FEnd
Function Main
MG=1
ML=50
Count()
Count()
P9=P1
P9.X=MG
P9.Z=ML
Mvs P9
FEnd
"""
    assert shown(run(text, 6)) == [(4, 0, 50)]


def test_functions_of_one_expression() -> None:
    assert value("FNMSUM(2,3)", "Def FNMSUM(MA,MB)=MA*10+MB") == 23


def test_programs_call_others_with_values() -> None:
    language = languages.get("melfa-basic-5")
    main = language.parse('M1=5\nCallP "SUB",M1,P1\nP8=P1\nP8.X=M1\nMvs P8\nEnd' + POSITIONS)
    sub = language.parse("FPrm M9,P9\nM9=M9+1\nP9.Z=M9\nMvs P9\nEnd")
    done = melfa.run([main, sub], names=["MAIN", "SUB"], start=START)
    assert done.ended == "end", done.message
    assert shown(done) == [(400, 0, 6), (5, 0, 500)]


def test_a_program_that_cannot_be_read_does_not_run() -> None:
    assert run("Mvs P1\nMvs Mvs\nEnd").ended == "error"
    assert run("For M1=1 To 2\nEnd").message.startswith("error 3230")
    assert run("GoTo *NOWHERE\nEnd").message.startswith("error 3600")


def test_an_error_of_the_programs_own() -> None:
    assert run("Error 9100\nMvs P1\nEnd").message.startswith("error 9100")
