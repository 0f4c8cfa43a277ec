"""Small MELFA-BASIC programs that were refused, or did something else in RAPID, once."""

from __future__ import annotations

import pytest

import assistant
from assistant.base.diagnostics import Severity
from assistant.base.source_text import SourceText
from assistant.compiler.loader import load_text
from tests.virtual.random_melfa_values import DATA
from tests.virtual.test_translated_melfa import SCENARIOS, SIGNALS, run_melfa, run_rapid
from tests.virtual.translating import Tally, in_turn, judge

CASES = {
    "subroutines in front of the main part": """Spd 100
GoTo *S
*A
Mvs P1
GoSub *B
Return
' the other one
*B
Mvs P2
Return
*S
GoSub *A
If M_In(1)=1 Then GoTo *E
GoSub *B
GoTo *S2
*C
Mvs P4
Return
*E
Mvs P5
*S2
GoSub *C
Mvs P3
End""",
    "bits of numbers": """M1=Abs(M_Inb(8)-3.6)
M_Outb(16)=(M1 And 7) Or (M_Inb(24) Xor 255)
If M1 And 2 Then M_Out(1)=1
If M_Inb(8) Xor 1 Then M_Out(2)=1
M2=(M1 And 6)\\2+1
Dly M2
End""",
    "numbers that outputs round": """M1=0.4
M_Out(1)=M1
M_Out(2)=M1+0.3
M_Outb(16)=M1*3+4.6
M_Outb(24)=M_Inb(8)/3
End""",
    "whole numbers below": """For M1=-2 To 2 Step 0.25
M2=Int(M1)
Dly M2+3
Next M1
Dly Int(2.999)
Dly Int(M_Inb(8)/3)
End""",
    "numbers that stand behind the program": """Dim MA(2)
M2=M2+M1
Dly M2
Dly MA(2)
End
M1=+2.50
M2=+1
MA(1)=+3
MA(2)=+4""",
    "a subroutine in several pieces": """Spd 100
For M1=1 To 3
GoSub *A
Next M1
GoTo *LAST
*A
If M1=2 Then GoTo *TWO
Mvs P1
*BACK
GoSub *B
Return
*TWO
Mvs P2
If M_In(1)=1 Then GoTo *B2
GoTo *BACK
*B
M2=M2+1
*B2
Dly M2
Return
*LAST
GoSub *B
End
M2=+1""",
    "subroutines that share lines with the main program": """Spd 100
M1=0
*AGAIN
M1=M1+1
If M1>3 Then GoTo *LAST
GoSub *A
Mvs P1
GoTo *AGAIN
*A
Mvs P2
If M_In(1)=1 Then GoTo *B
If M_In(2)=1 Then GoTo *AGAIN
Return
*LAST
GoSub *B
Dly 1
End
*B
Mvs P3
M1=M1+1
Return""",
    "the end of the cycle from deep inside": """Spd 100
For M1=1 To 4
GoSub *A
M_Out(1)=1
Next M1
GoSub *B
End
*A
If M1=3 Then GoSub *B
Mvs P1
Return
*B
M_Out(2)=1
If M_In(1)=1 Then End
Mvs P2
Return""",
    "lines that run on into a subroutine": """Spd 100
GoSub *A
Mvs P2
If M_In(1)=0 Then End
*A
Mvs P1
M_Out(1)=1
Return
End""",
    "a loop for ever above subroutines": """Spd 100
While 1=1
M1=M1+1
GoSub *A
WEnd
*A
Mvs P1
If M1>=2 Then End
Return
End
M1=+0""",
    "pallets that are worked out": """Spd 100
M1=M_Inb(8)+2
P7=P3*(0,0,5,0,0,7)
Def Plt 2,P1,P2,P7,,M1,2,1
For M2=1 To 4
P9=(Plt 2,M2)
Mvs P9
Mvs (Plt 2,M2)
Next M2
Def Plt 2,P4,P2,P7,P5,2,3,2
Mvs (Plt 2,5)
Def Plt 2,P4,P2,P7,P5,3,3,M_In(1)+2
P9=(Plt 2,2)
Mvs P9
Def Plt 3,P1,P2,P7,,5,0,3
Def Plt 4,P1,P2,P7,P4,3,2,11
For M2=1 To 5
Mvs (Plt 3,M2)
P9=(Plt 4,M2)
P9.Z=P9.Z+2
Mvs P9
Next M2
M3=M_In(1)*10+3
Def Plt 5,P1,P2,P7,,4,2,M3
Mvs (Plt 5,2)
Mvs (Plt 5,4)
End""",
    "positions of numbers and where the robot is": """Spd 100
M1=M_Inb(8)/3
P7=SetPos(P1.X-M1,P1.Y,440,Rad(180),0,P1.C+Rad(200))
Mvs P7
M2=Deg(P7.C)
If M2>180 Then M_Out(4)=1
P8=SetPos(380+M1,10,430,Rad(180),0,Rad(170),0)
Mvs P8
If Dist(P_Curr,P8*(0,0,5,0,0,0))<12 Then M_Out(3)=1
If Dist(P1,P2)<70 And Dist(P_Curr,P1)>1 Then M_Out(5)=1
P9=P5
P9.C=P9.C-Rad(40)
If Zone(P5,P1,P2) Then M_Out(1)=1 Else M_Out(2)=1
M3=Zone(P_Curr,P8,P9)+2*Zone(P5,P9,P5)+4*Zone(P9,P9,P5)
M_Outb(16)=M3
End""",
    "speeds that are asked for, and too high ones": """Spd 120
If M_In(1)=1 Then Spd 50
Mvs P1
Dly M_Spd/100
Spd 100000
Mvs P2
M1=M_Spd
Dly M1/1000
End""",
    "an interrupt that ends with an error": """Spd 100
Def Act 2,M_In(1)=1 GoTo *EM,S
Mvs P1
Act 2=1
GoSub *A
Act 2=0
Mvs P2
End
*EM
M_Out(3)=1
Error 9100
*A
M_Out(1)=1
Return
End""",
    "cautions, after which the program goes on": """Spd 100
Title "cell"
Mvs P1
If M_In(1)=1 Then Error 9200
M_Out(1)=1
Mvs P2
End""",
    "hands and outputs by numbers that loops count": """Spd 100
Dim MA(3)
For M9=1 To 2
HOpen M9
Next M9
For M1=0 To 2
M_Outb(8+M1*8)=M1*2+1
Next M1
For M1=1 To 3
MA(M1)=M_In(M1*2)
M_Out(M1)=MA(M1)
Next M1
For M1=1 To M_Inb(8)+1
Dly 0.1
Next M1
For M9=2 To 1 Step -1
HClose M9
Next M9
End""",
    "pallets with numbers that are out of range": """Spd 100
M1=M_Inb(8)
Def Plt 2,P1,P2,P3,,M1,2,1
Mvs (Plt 2,1)
M_Out(1)=1
Mvs (Plt 2,3)
M_Out(2)=1
End""",
}


@pytest.mark.parametrize(("name", "level"), in_turn(CASES, [4, 5, 6]))
def test_it_does_the_same(name: str, level: int) -> None:
    lines = CASES[name].split("\n")
    code = lines[: len(lines) - lines[::-1].index("End")]
    numbered = [f"{at * 10} {line}" for at, line in enumerate(code, 1)]
    text = "\n".join([*numbered, *lines[len(code) :], DATA.strip(), ""])
    tally = Tally()
    judge(
        tally,
        name,
        text.upper() if level == 4 else text,
        SCENARIOS,
        source=(f"melfa-basic-{level}", lambda *given: run_melfa(level, None, *given)),
        target=("rapid", lambda *given: run_rapid(None, *given)),
        signals=SIGNALS,
    )
    assert tally.kept == []
    assert not tally.reasons
    assert tally.counts["equal"] == 1


@pytest.mark.parametrize(
    ("read", "refused"),
    [
        ("If M_Out(17)=1 Then M_Out(30)=1", True),
        ("If M_Out(24)=1 Then M_Out(30)=1", False),  # beside the eight
        ("If M_Outb(16)=5 Then M_Out(30)=1", False),
        ("If M_Outb(20)=5 Then M_Out(30)=1", True),
        ("M_Out(17)=1", False),
        ("If M_In(17)=1 Then M_Out(30)=1", False),
    ],
)
def test_an_output_is_read_by_the_name_that_it_is_set_by(read: str, refused: bool) -> None:
    source = SourceText(f"M_Outb(16)=5\n{read}\nEnd\n")
    found = assistant.translate(load_text(source, language="melfa-basic-5"), to="rapid")
    assert [f.code for f in found.findings if f.severity is Severity.ERROR] == ["RA305"] * refused
    assert found.ok != refused


@pytest.mark.parametrize(("line", "refused"), [("MA(F())=F()", True), ("MA(2)=F()+F()", False)])
def test_no_order_of_evaluation_is_made_up(line: str, refused: bool) -> None:
    text = f"Def Float MN\nDim MA(3)\nFunction V Main()\nMN=0\n{line}\nFEnd\n"
    source = SourceText(text + "Function M F()\nMN=MN+1\nF=MN\nFEnd\n")
    found = assistant.translate(load_text(source, language="melfa-basic-6"), to="rapid")
    errors = [f.message for f in found.findings if f.severity is Severity.ERROR]
    assert [message for message in errors if "worked out first" in message] == errors
    assert bool(errors) == refused
