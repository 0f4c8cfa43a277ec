"""What MELFA-BASIC does that a program keeps as its text."""

from __future__ import annotations

import pytest

from assistant import languages
from assistant.program.expressions import Effect, unknown_effect
from tests.tables import every_row

MELFA = languages.get("melfa-basic-6")


def does(*flags: str, reads: str = "", writes: str = "", calls: str = "") -> Effect:
    named = (frozenset(names.split()) for names in (reads, writes, calls))
    return Effect(*named, "moves" in flags, "jumps" in flags, "waits" in flags)


@every_row(
    ("text", "expected"),
    [
        ("P1.X=M2(M3)+P_Curr.Y", does(reads="p1 m2 m3 p_curr", writes="p1 m3")),
        ("M_Out(8)=1 Dly 0.5", does(reads="m_out", writes="m_out")),
        ("Mvs P1 Wth M_Out(8)=1", does("moves", reads="p1 m_out", writes="m_out")),
        ("EMvs P1", does("moves", reads="p1")),
        ("If M1>0 Then Mov P1 Else GoTo *Out", does("moves", "jumps", reads="m1 p1 out")),
        ("MvTune 2", does()),
        ("Mxt 1,1,50", does("moves")),
        ("Trk On,P1", does("moves", "waits", reads="p1", writes="p1")),
        ("GoTo *Again", does("jumps", reads="again")),
        ("GoSub *Fetch", does(reads="fetch", calls="fetch")),
        ("On M1 GoSub *One,*Two", does(reads="m1 one two", calls="one two")),
        ("On M1 GoTo *One,*Two", does("jumps", reads="m1 one two")),
        ('CallP "FETCH",M1,P2', does(reads="fetch m1 p2", writes="m1 p2", calls="fetch")),
        ("CallP C1$", unknown_effect("CallP C1$")),
        ("Def Act 1,M_In(8)=1 GoSub *Alarm", does(reads="m_in alarm")),
        ("Wait M_In(8)=1", does("waits", reads="m_in")),
        ("Dly M1", does("waits", reads="m1")),
        ("Hlt", does("waits")),
        ("End", does("jumps")),
        ("Error 9100", does("jumps")),
        ("Input #1,M1,C1$", does("waits", reads="m1 c1", writes="m1 c1")),
        ("Servo Off", does(reads="off")),
        ("FsGetDat 1,M1", does("waits", reads="m1", writes="m1")),
        ("Next M1", does("jumps", reads="m1", writes="m1")),
        ("Def Inte COUNT", does(reads="count", writes="count")),
    ],
)
def test_statements(text: str, expected: Effect) -> None:
    assert MELFA.effect(text, "statement") == expected


def test_expressions() -> None:
    assert MELFA.effect("M_NvNum(1)+M1", "expression") == does(reads="m_nvnum m1")
    assert MELFA.effect("FNHYP(M1,M2)", "expression") == does(reads="fnhyp m1 m2", writes="m1 m2")


def test_functions_are_declarations() -> None:
    text = "Function M Grow(M1())\n  Mov P1\n  Grow=M1(1)\nFEnd"
    effect = MELFA.effect(text, "declaration")
    assert effect.moves and effect.jumps
    assert effect.writes == {"grow", "m1"}
    assert effect.reads == {"grow", "m1", "p1"}


@pytest.mark.parametrize("text", ["Mov Mov", "MoveL p1,v100,fine,tool0;", "10 Mov P1"])
def test_what_cannot_be_read_may_do_anything(text: str) -> None:
    for kind in ("statement", "expression", "declaration"):
        assert MELFA.effect(text, kind) == unknown_effect(text)  # type: ignore[arg-type]
