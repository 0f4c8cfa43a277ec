"""Rules of moves."""

from __future__ import annotations

from tests.languages.melfa_basic.ruled import Row, found, taught
from tests.tables import every_row

MOVES: dict[str, Row] = {
    "a position of zeros": ("Mov P1\nP1=(0,0,0,0,0,0)(0,0)", ["MB701 1:5"]),
    "a row of zeros": (
        "1 Mov P1\n2 Mov P2\nP1=(1,2,3,0,0,0)(7,0)\nP2=(0,0,0,0,0,0)(0,0)",
        ["MB701 2:7"],
    ),
    "zeros of a line and of a row": (
        "1 Mov PA\n2 Mov P1\n3 Mov P2\nPA=(0,0,0,0,0,0)(0,0)\n"
        "P1=(1,2,3,0,0,0)(7,0)\nP2=(0,0,0,0,0,0)(0,0)",
        ["MB701 1:7", "MB701 3:7"],
    ),
    "zeros that are assigned": ("P1=P_Curr\nMov P1\nP1=(0,0,0,0,0,0)(0,0)", []),
    "a product with zeros": ("Mov P2*P1\nP1=(0,0,0,0,0,0)(0,0)\n" + taught("P2"), []),
    "flags that differ": (
        "Mov PA\nMvs PB\n" + taught("PA") + "\n" + taught("PB", flag=6),
        ["MB702 2:5"],
    ),
    "flags that differ in a table": (
        "1 Mvs P1\n2 Mvs P2\n" + taught("P1") + "\n" + taught("P2", flag=6),
        ["MB702 2:7"],
    ),
    "flags of a joint move": ("Mov PA\nMov PB\n" + taught("PA") + "\n" + taught("PB", flag=6), []),
    "flags of Type 0,1": (
        "Mov PA\nMvs PB Type 0,1\n" + taught("PA") + "\n" + taught("PB", flag=6),
        [],
    ),
    "flags behind a label": (
        "Mov PA\n*X\nMvs PB\nGoTo *X\n" + taught("PA") + "\n" + taught("PB", flag=6),
        [],
    ),
    "flags of a position that changes": (
        "Mov PA\nPB=P_Curr\nMvs PB\n" + taught("PA") + "\n" + taught("PB", flag=6),
        [],
    ),
    "an arc in a line": ("Mov P1\nMvr P1,P2,P3\n" + taught("P1", "P2", "P3"), ["MB703 2:11"]),
    "an arc of two equal points": (
        "Mov P1\nMvr P1,P1,P3\n" + taught("P1", "P2", "P3"),
        ["MB703 2:11"],
    ),
    "an arc": (
        "Mov P1\nMvr P1,P2,P3\n" + taught("P1", "P2") + "\nP3=(150,50,300,180,0,180)(7,0)",
        [],
    ),
    "an arc from elsewhere": (
        "Mov P2\nMvr P1,P2,P3\n" + taught("P1", "P2") + "\nP3=(150,50,300,180,0,180)(7,0)",
        ["MB704 2:5"],
    ),
    "a circle for an arc": (
        "Mvc P1,P2,P3\nMvc P3,P4,P5\n" + taught("P1", "P2", "P3", "P4", "P5"),
        ["MB705 1:1"],
    ),
    "a circle, then a move to its third point": (
        "Mvc P1,P2,P3\nMvs P3\n" + taught("P1", "P2", "P3"),
        [],
    ),
    "two circles": (
        "Mvc P1,P2,P3\nMvc P1,P4,P5\n" + taught("P1", "P2", "P3", "P4", "P5"),
        [],
    ),
    "a corner at a stop": ("Cnt 1\nMov P1\nHlt\n" + taught("P1"), ["MB706 3:1"]),
    "a corner at a hand": ("Cnt 1,5,5\nMov P1\nHClose 1\n" + taught("P1"), ["MB706 3:1"]),
    "a corner that is off": ("Cnt 1\nMov P1\nCnt 0\nMov P2\nHlt\n" + taught("P1", "P2"), []),
    "a corner and a signal": (
        "Cnt 1\nMov P1\nM_Out(1)=1\nMov P2\nCnt 0\n" + taught("P1", "P2"),
        [],
    ),
    "an interrupt that nothing defines": ("Act 2=1", ["MB708 1:1"]),
    "an interrupt that nothing switches on": (
        "Def Act 2,M_In(1)=1 GoTo *X\nAct 2=0\n*X",
        ["MB709 1:5"],
    ),
    "all interrupts are switched on": ("Def Act 2,M_In(1)=1 GoTo *X\nAct 0=1\n*X", []),
    "printed without Open": ("Print #1,5", ["MB711 1:1"]),
    "opened and not closed": ('Open "COM1:" As #1\nPrint #1,5', ["MB712 1:1"]),
    "opened and closed": ('Open "COM1:" As #1\nPrint #1,5\nClose', []),
    "opened twice": ('Open "COM1:" As #1\nOpen "COM2:" As #1\nClose #1', ["MB713 2:1"]),
    "opened again": ('Open "COM1:" As #1\nClose #1\nOpen "COM2:" As #1\nClose #1', []),
}


@every_row(("text", "expected"), MOVES)
def test_motion(text: str, expected: list[str]) -> None:
    assert found(5, text) == expected
