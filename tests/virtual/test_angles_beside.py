"""Angles of positions beyond 180 degrees count in another language as MELFA-BASIC stores them."""

from __future__ import annotations

import pytest

from assistant.base.source_text import SourceText
from assistant.compiler import translate
from assistant.compiler.loader import load_text
from tests.virtual.test_translated_melfa import SCENARIOS, SIGNALS, run_melfa, run_rapid
from tests.virtual.translating import Tally, judge

PLACES = """
P1=(+340.00,+30.00,+260.00,+180.00,+0.00,+175.00)(7,0)
P2=(+310.00,-40.00,+240.00,+180.00,+0.00,-170.00)(7,0)
P3=(+330.00,+10.00,+250.00,+90.00,+90.00,+0.00)(7,0)
P4=(+330.00,+10.00,+250.00,+180.00,+0.00,+200.00)(7,0)
P5=(+320.00,-10.00,+230.00,+170.00,+20.00,+190.00)(7,0)
PS=(+0.00,+0.00,+15.00,+0.00,+0.00,+40.00)(0,0)
"""
HEAD = ("Tool P_NTool", "Base P_NBase", "Spd 120", "Cnt 0")
PROGRAMS = {
    "a loop over a turn": (
        "P9=P1", "P9.C=Rad(0)", "While P9.C<=Rad(350)", "Mvs P9", "P9.C=P9.C+Rad(50)", "WEnd",
    ),
    "compared": (
        "P9=P1", "P9.C=P9.C+Rad(25)", "If P9.C>Rad(190) Then M_Out(3)=1 Else M_Out(4)=1", "Mvs P9",
    ),
    "read into a number": (
        "P9=P2", "P9.C=P9.C-Rad(30)", "M1=Deg(P9.C)", "M_Outb(16)=Abs(M1)-150", "Mvs P1,M1/10",
    ),
    "halved": ("P9=P1", "P9.C=(P1.C+P2.C)/2", "Mvs P9"),
    "handed on": ("P8=P1", "P8.C=P8.C+Rad(60)", "P9=P8", "P7=P9+(0,0,9,0,0,0)", "M1=Deg(P7.C)",
                  "If M1>200 Then M_Out(5)=1", "Mvs P7"),
    "about y beyond 90": (
        "P9=P1", "P9.B=Rad(100)", "Mvs P9", "P9.A=Rad(20)", "Mvs P9", "P9.C=Rad(10)", "Mvs P9",
    ),
    "set where the tool is level": ("P9=P3", "P9.C=Rad(45)", "Mvs P9", "P9.A=Rad(30)", "Mvs P9"),
    "taught beyond": ("M1=Deg(P4.C)", "If M1>180 Then M_Out(6)=1", "P9=P4", "P9.C=P9.C/2",
                      "Mvs P9"),
    "a variable that was taught": ("M1=Deg(P5.C)", "P5.A=P5.A+Rad(30)", "Mvs P5", "P5.C=Rad(M1/2)",
                                   "Mvs P5"),
    "products": ("P9=P1*PS", "P9.C=P9.C+Rad(10)", "M1=Deg(P9.C)", "If M1>0 Then M_Out(7)=1",
                 "Mvs P9"),
    "by itself": ("P9=P1", "P9.C=P9.C+Rad(5)", "M_Outb(16)=Abs(Deg(P9.C))", "P8=P9*(0,0,8,0,0,30)",
                  "Mvs P8"),
    "arrays": ("Dim PA(3)", "PA(1)=P1", "PA(2)=P2", "PA(1).C=PA(1).C+Rad(40)", "PA(3)=PA(1)",
               "M1=Deg(PA(3).C)", "If M1>200 Then M_Out(8)=1", "Mvs PA(3)"),
    "places of a pallet": (
        "Def Plt 1,P1,P2,P4,,2,2,1", "P9=(Plt 1,2)", "If P9.C>Rad(170) Then M_Out(3)=1", "Mvs P9",
        "Mvs (Plt 1,3)",
    ),
    "elements by inputs": (
        "Dim PA(2)", "PA(1)=P2", "PA(2)=P4", "PA(M_In(1)+1)=P1", "PA(M_In(2)+1).C=Rad(200)",
        "P9=PA(M_In(1)+1)", "If P9.C>Rad(170) Then M_Out(3)=1", "Mvs P9", "Mvs PA(2)",
    ),
    "subroutines": ("P9=P1", "For M2=1 To 4", "GoSub *TURN", "Next M2",
                    "If P9.C>=Rad(275) Then M_Out(9)=1", "End", "*TURN", "P9.C=P9.C+Rad(25)",
                    "Mvs P9", "Return"),
    "where the arm is": ("Mvs P1", "P9=P_Curr", "P9.C=P9.C+Rad(10)", "M1=Deg(P9.C)",
                         "If M1>180 Then M_Out(2)=1", "Mvs P9"),
}  # fmt: skip


def text_of(lines: tuple[str, ...]) -> str:
    end = () if "End" in lines else ("End",)
    numbered = (f"{at} {line}" for at, line in enumerate((*HEAD, *lines, *end), 1))
    return "\n".join(numbered) + PLACES


@pytest.mark.parametrize("name", PROGRAMS)
def test_angles_mean_the_same(name: str) -> None:
    tally = Tally()
    judge(
        tally,
        name,
        text_of(PROGRAMS[name]),
        SCENARIOS[:1],
        source=("melfa-basic-5", lambda *given: run_melfa(5, None, *given)),
        target=("rapid", lambda *given: run_rapid(None, *given)),
        signals=SIGNALS,
    )
    assert tally.kept == []
    assert not tally.reasons
    assert tally.counts["equal"] == 1


def test_a_position_that_is_only_turned_on_has_no_numbers_beside_it() -> None:
    lines = ("P9=P1", "P9.C=P9.C+Rad(25)", "Mvs P9", "P9.A=P9.A-Rad(5)", "Mvs P9")
    made = translate(load_text(SourceText(text_of(lines)), language="melfa-basic-5"), to="rapid")
    (written,) = made.files.values()
    assert b"P9_C" not in written


def test_angles_that_nobody_knows_are_refused() -> None:
    text = (
        "Function Main\nP9=P1\nfnT(P9)\nIf P9.C>Rad(170) Then M_Out(3)=1\nFEnd\n"
        "Function V fnT(ByRef PX)\nPX.C=PX.C/2\nFEnd\n" + PLACES.lstrip()
    )
    loaded = load_text(SourceText(text), language="melfa-basic-6")
    made = translate(loaded, to="rapid")
    assert not made.ok
    assert "MB292" in {finding.code for finding in made.findings}
