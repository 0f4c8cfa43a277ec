"""What MELFA-BASIC alone has does in RAPID what it did, as two interpreters tell it."""

from __future__ import annotations

import pytest

import assistant
from assistant.base.diagnostics import Severity
from assistant.base.source_text import SourceText
from assistant.compiler.loader import load_text
from assistant.compiler.motion_proof import Proving
from tests.virtual.random_melfa_values import DATA
from tests.virtual.test_translated_melfa import SCENARIOS, SIGNALS, run_melfa, run_rapid
from tests.virtual.translating import Tally, judge

PLAIN = {
    "an output by number": """For M1=1 To 3
M_Out(20+M1)=1
Next M1
MA=4
M_Out(MA)=1
M_Out(MA)=0
End""",
    "an input by number": """MN=1
If M_In(MN)=1 Then M_Out(5)=1
MN=8
If M_In(MN+1)=1 Then M_Out(6)=1
M2=M_In(MN)*2
Dly M2+1
Wait M_In(MN+20)=0
End""",
    "an output that a loop of jumps counts": """MLeast=20
M1=0
*Next
M_Out(MLeast+M1)=1
M1=M1+1
If M1<(2*3) Then *Next
M1=30
While M1>=28
M_Out(M1)=1
M1=M1-1
WEnd
End""",
    "groups by number": """For M1=8 To 16 Step 8
M_Outb(M1+16)=M_Inb(M1)+1
Next M1
End""",
    "motors that are on": """If M_Svo=0 Then
Servo On
Wait M_Svo=1
EndIf
If M_Svo(1)=1 Then M_Out(3)=1
Dly 200/M_OPovrd
End""",
}
FUNCTIONS = {
    "an input that a caller names": """MR=Check(1,1)
M_Out(5)=MR
MR=Check(9,0)
M_Out(6)=MR
End
Function M Check(MNumber%,MValue%)
Check=0
If M_In(MNumber%)=MValue% Then Check=1
FEnd""",
    "an output of an array": """Dim MCase%(2)
MCase%(1)=26
MCase%(2)=31
MR=Press(MCase%)
End
Function M Press(ByVal MGiven%())
M_Out(MGiven%(2))=1
Wait M_In(MGiven%(1))=0
M_Out(MGiven%(2))=0
Press=1
FEnd""",
    "a function whose result nobody asks for": """MR=1
Bump()
Bump()
Dly MR
End
Function M Bump()
MR=MR+1
Bump=MR
FEnd""",
    "a loop in which its variable and its end change": """MFin=2
For MC=0 To MFin
MR=Look(MC)
If MR=2 Then
M_Out(4)=1
MC=MFin
EndIf
Dly MC+1
Next MC
End
Function M Look(MX)
Look=MX+M_In(1)
FEnd""",
    "a corner that differs at a label of a function": """MR=Bring()
M_Out(5)=MR
End
Function M Bring()
Bring=1
MTries=0
Cnt 0
Mov P1
*Again
Mvs P2
Mvs P3
If M_In(1)=0 Then GoTo *Out
MTries=MTries+1
Cnt 1,10,10
Mvs P4
If MTries<2 Then GoTo *Again
Bring=2
*Out
Cnt 0
FEnd""",
    "a function that nothing calls": """Spd 100
Mvs P1
End
Function M Spare(MX)
Mov P2
Mvs P3
Spare=1
FEnd""",
}


def tally_of(name: str, text: str, level: int) -> Tally:
    lines = text.split("\n")
    if level < 6:
        lines = [f"{at * 10} {line}" for at, line in enumerate(lines, 1)]
    whole = "\n".join([*lines, DATA.strip(), ""])
    tally = Tally()
    judge(
        tally,
        name,
        whole.upper() if level == 4 else whole,
        SCENARIOS[:2],
        source=(f"melfa-basic-{level}", lambda *given: run_melfa(level, None, *given)),
        target=("rapid", lambda *given: run_rapid(None, *given)),
        signals=SIGNALS,
    )
    return tally


@pytest.mark.parametrize("level", [5, 6])
@pytest.mark.parametrize("name", PLAIN)
def test_it_does_the_same(name: str, level: int) -> None:
    tally = tally_of(name, PLAIN[name], level)
    assert (tally.kept, tally.counts["equal"]) == ([], 1), tally.reasons


@pytest.mark.parametrize("name", FUNCTIONS)
def test_functions_do_the_same(name: str) -> None:
    tally = tally_of(name, FUNCTIONS[name], 6)
    assert (tally.kept, tally.counts["equal"]) == ([], 1), tally.reasons


def codes(text: str, level: int = 6) -> list[str]:
    source = SourceText(text + "\n" + DATA.strip() + "\n")
    made = assistant.translate(load_text(source, language=f"melfa-basic-{level}"), to="rapid")
    return [f.code for f in made.findings if f.severity is not Severity.INFO]


def test_a_number_that_may_be_any_is_refused() -> None:
    assert codes("M_Out(M_Inb(8))=1\nEnd") == ["RA304"]
    assert codes("M1=0\n*A\nM_Out(M1+1)=1\nM1=M1+1\nIf M_In(1)=1 Then *A\nEnd") == ["RA304"]


def test_what_is_chosen_among_is_told() -> None:
    assert codes("For M1=1 To 3\nM_Out(20+M1)=1\nNext M1\nEnd") == ["MB270"]


GIVEN_NOTHING = """Def Inte MCount
MCount=MCount+Found(3)
Dly MCount+1
MCount=MCount+Found(4)
Dly MCount+1
End
Function M Found(MX)
If MX=3 Then GoTo *Out
Found=2
*Out
FEnd
"""


def test_numbers_that_nothing_was_given_are_none() -> None:
    source = load_text(SourceText(GIVEN_NOTHING + DATA), language="melfa-basic-6")
    made = assistant.translate(source, to="rapid", proving=Proving())
    assert made.motion is not None and made.motion.holds, made.motion
    assert "MB251" in {f.code for f in made.findings}
