"""An input that is read once is read once in the translation, whatever it becomes between reads."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.virtual import rapid_words as w
from tests.virtual import test_translated_melfa as from_melfa
from tests.virtual import test_translated_rapid as from_rapid
from tests.virtual.translating import Changing, Tally, judge

CHANGES = [Changing(number) for number in range(5)]
MELFA_PLACES = """
P1=(+340.00,+30.00,+260.00,+180.00,+0.00,+180.00)(7,0)
P2=(+310.00,-40.00,+240.00,+180.00,+0.00,+180.00)(7,0)
"""
SELECTS = {
    "ranges": ("Select M_Inb(24) And &H07", "Case 1 To 2", "Mvs P1", "Break", "Case 3",
               "Mvs P2", "Break", "Case Is >4", "M_Out(3)=1", "Break", "Default", "M_Out(4)=1",
               "Break", "End Select"),
    "arithmetic": ("M1=2", "Select M_Inb(8)*2+M1", "Case 2 To 100", "M_Out(3)=1", "Break",
                   "Case Is >300", "Mvs P1", "Break", "Case 102", "Case 104", "Mvs P2", "Break",
                   "End Select"),
    "one inside another": ("Select M_Inb(8) Mod 4", "Case 0 To 1", "Select M_Inb(24) Mod 4",
                           "Case 2 To 3", "Mvs P1", "Break", "Default", "M_Out(5)=1", "Break",
                           "End Select", "Break", "Case 2 To 3", "Mvs P2", "Break", "End Select"),
    "a list of subroutines": ("On (M_Inb(24) And &H03)+1 GoSub *A,*B,*B,*A", "M_Out(6)=1", "End",
                              "*A", "Mvs P1", "Return", "*B", "Mvs P2", "Return"),
    "a loop": ("For M2=1 To M_Inb(24) And &H03", "Mvs P1,-M2", "Next M2", "M_Out(1)=1"),
    "the least and the most": ("M1=Max(M_Inb(8),M_Inb(24))", "M2=Min(M_Inb(8),100)",
                               "M3=Abs(M_Inb(24)-90)", "Mvs P1,-M1/10", "Mvs P2,-M2/10",
                               "Mvs P1,-M3/10"),
    "whole numbers below": ("M1=Int(M_Inb(8)/3)", "Mvs P1,-Int(M_Inb(24)/7)", "Mvs P2,-M1",
                            "If Int(M_Inb(8)/2)>40 Then M_Out(2)=1", "Mvs P1"),
    "a remainder": ("M1=M_Inb(8) Mod 7", "M2=M_Inb(24)\\5", "Mvs P1,-M1", "Mvs P2,-M2"),
}  # fmt: skip


@pytest.mark.parametrize("name", SELECTS)
def test_melfa_basic_to_rapid(name: str) -> None:
    lines: tuple[str, ...] = ("Tool P_NTool", "Base P_NBase", "Spd 120", "Cnt 0", *SELECTS[name])
    lines += () if "End" in lines else ("End",)
    numbered = "\n".join(f"{at} {line}" for at, line in enumerate(lines, 1))
    tally = Tally()
    judge(
        tally,
        name,
        numbered + MELFA_PLACES,
        CHANGES,
        source=("melfa-basic-5", lambda *given: from_melfa.run_melfa(5, None, *given)),
        target=("rapid", lambda *given: from_melfa.run_rapid(None, *given)),
        signals=from_melfa.SIGNALS,
    )
    assert tally.kept == []
    assert not tally.reasons
    assert tally.counts["equal"] == 1


TESTS = {
    "lists": "TEST giOrder CASE 1,5: MoveL p10,v100,fine,tG; CASE 2,7,9: MoveL p20,v100,fine,tG; "
    "DEFAULT: SetDO do1,1; ENDTEST",
    "arithmetic": "TEST giOrder MOD 3+1 CASE 1,2: MoveL p10,v100,fine,tG; CASE 3: SetDO do1,1; "
    "ENDTEST",
    "one inside another": "TEST giOrder CASE 0,1,2,3,4,5,6,7: TEST giOrder CASE 1,2,3: MoveL p10,"
    "v100,fine,tG; DEFAULT: SetDO do1,1; ENDTEST DEFAULT: MoveL p20,v100,fine,tG; ENDTEST",
    "a function": "TEST Next(giOrder) CASE 1,2,3,4: MoveL p10,v100,fine,tG; CASE 5,6: "
    "MoveL p20,v100,fine,tG; DEFAULT: SetDO do1,1; ENDTEST MoveL Offs(p10,0,0,n),v50,fine,tG;",
    "a loop": "FOR i FROM 1 TO giOrder DO MoveL Offs(p10,0,0,i),v100,fine,tG; ENDFOR",
    "a routine by its name": '%"rDo"+ValToStr(giOrder MOD 2)%;',
    "an index": "k{1+giOrder MOD 3}:=4; n:=k{1+giOrder MOD 3}; MoveL Offs(p10,0,0,n),v50,fine,tG;",
}
MODULE = """MODULE Cell
PERS tooldata tG:=[TRUE,[[0,0,100],[1,0,0,0]],[1,[0,0,50],[1,0,0,0],0,0,0]];
CONST robtarget p10:=[[350,20,250],[0,0,1,0],[0,0,0,0],{unused}];
CONST robtarget p20:=[[320,-40,260],[0,0,1,0],[0,0,0,0],{unused}];
VAR num n;
VAR num k{{3}}:=[1,2,3];
PROC main()
{body}
ENDPROC
FUNC num Next(num x)
n:=n+1;
RETURN x MOD 8;
ENDFUNC
PROC rDo0()
SetDO do1,1;
ENDPROC
PROC rDo1()
MoveL p20,v100,fine,tG;
ENDPROC
ENDMODULE
"""


@pytest.mark.parametrize("name", TESTS)
def test_rapid_to_melfa_basic(name: str, tmp_path: Path) -> None:
    text = MODULE.format(body=TESTS[name].replace(" CASE", "\nCASE"), unused=w.UNUSED)
    tally = from_rapid.judged("melfa-basic-6", [(name, text, CHANGES)], tmp_path)
    assert tally.kept == []
    assert tally.counts["equal"] == 1


def test_a_group_of_inputs_may_be_the_lower_bits_of_another() -> None:
    lines = ("Tool P_NTool", "Base P_NBase", "Spd 90", "Cnt 0", "M1=M_Inb(8)", "M2=M_Inb(8) And 3")
    code = "\n".join(f"{at} {one}" for at, one in enumerate((*lines, "Mvs P1,-M1-M2", "End"), 1))
    tally = Tally()
    judge(
        tally,
        "lower bits",
        code + MELFA_PLACES,
        CHANGES[:3],
        source=("melfa-basic-5", lambda *given: from_melfa.run_melfa(5, None, *given)),
        target=("rapid", lambda *given: from_melfa.run_rapid(None, *given)),
        signals=from_melfa.SIGNALS,
    )
    assert tally.kept == []
    assert tally.counts["equal"] == 1
