"""Rules over files with syntax errors: sound lines have findings, none follows from the damage."""

from __future__ import annotations

from assistant.base.source_text import SourceText
from assistant.compiler.checker import check_text
from tests.tables import every_row

ROWS: dict[str, tuple[int, str, list[str]]] = {
    "a jump elsewhere": (5, "X=1+\nGoTo *LOP", ["MB002 1", "MB101 2"]),
    "a move elsewhere": (5, "X=1+\nMov P1", ["MB002 1", "MB104 2"]),
    "an argument elsewhere": (5, "X=1+\nDly -1", ["MB002 1", "MB601 2"]),
    "a block elsewhere": (5, "X=1+\nFor M1=1 To 3\nDly 1", ["MB002 1", "MB105 2"]),
    "what nothing leads to": (5, "X=1+\nEnd\nDly 1", ["MB002 1", "MB141 3"]),
    "a label that is damaged": (5, "*LOP 1\nDly 1\nGoTo *LOP", ["MB002 1"]),
    "a label that lost its name": (5, "*\nDly 1\nGoTo *LOP", ["MB002 1"]),
    "a label that is parted": (5, "*LO P\nDly 1\nGoTo *LOP", ["MB002 1"]),
    "a position that is damaged": (5, "Mov P1\nEnd\nP1=(1,2,", ["MB002 3"]),
    "a position that is parted": (5, "Mov P1\nEnd\nP 1=(1,2,3)", ["MB002 3"]),
    "positions before a damaged one": (
        5,
        "1 Mov P1\n2 End\nP1=(1,2,3,0,0,0)(7,0)\nP2=(1,2,3,0,0,0(7,0)",
        ["MB002 4"],
    ),
    "a variable that is damaged": (5, "M1=1+\nM_Out(1)=M1", ["MB002 1"]),
    "a type that is damaged": (5, 'Def Char DA TA\nIf DATA="0" Then End', ["MB002 1"]),
    "a dimension that is damaged": (5, "Dim MA(3\nMA(1)=2\nM_Out(1)=MA(1)", ["MB002 1"]),
    "a loop that is damaged": (5, "For M1=1 T 3\nDly 1\nNext", ["MB002 1"]),
    "a word that is misspelt": (5, "Whlie M_In(1)=1\nDly 1\nWEnd", ["MB002 1"]),
    "a jump that is damaged": (5, "End\nGoTo *A 1\n*B\nDly 1", ["MB002 2"]),
    "a step that is damaged": (4, "10 X=1+\n20 GOTO 10", ["MB002 1"]),
    "an include that is damaged": (6, "#Include B\nM_Out(1)=MX", ["MB002 1"]),
    "a file that is opened": (5, 'Open "COM1:" A #1\nPrint #1,5\nClose #1', ["MB002 1"]),
}


@every_row(("version", "text", "expected"), ROWS)
def test_damage(version: int, text: str, expected: list[str]) -> None:
    source = SourceText(text + "\n", "A.prg")
    checked = check_text(source, language=f"melfa-basic-{version}")
    findings = [f for f in checked.findings if f.code not in ("MB116", "MB710")]
    assert [f"{f.code} {f.line}" for f in findings] == expected


def test_what_uses_a_name_may_be_damaged() -> None:
    """What nothing uses is not told where a use may not be readable."""
    for text, codes in (("M1=1\nDly 1", {"MB116"}), ("M1=1\nDly 1+", {"MB002"})):
        checked = check_text(SourceText(text + "\n", "A.prg"), language="melfa-basic-5")
        assert {f.code for f in checked.findings} == codes
