"""The rules of MELFA-BASIC: small programs, and where each finding stands.

A row is a program and what is found in it, as `CODE line:column`. Most come in pairs: one that has
the finding, and one that comes near to it and has not.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

import assistant
from assistant import languages
from assistant.languages.melfa_basic.checks import ADVICE, RULES
from assistant.program.diagnostics import Severity
from assistant.program.text import SourceText

Row = tuple[str, list[str]]

SAMPLES = Path(__file__).parents[3] / "samples"

QUIET = ("MB116", "MB710")
"""What nothing uses, and tools: nearly every small program has these; they have tests below."""


def found(version: int, *texts: str, quiet: tuple[str, ...] = QUIET, first: str = "A") -> list[str]:
    """Findings in the first of some programs, named A, B and so on, which stand together."""
    language = languages.get(f"melfa-basic-{version}")
    names = [first, *"BCDEFGHIJK"][: len(texts)]
    pairs = zip(texts, names, strict=True)
    trees = [language.parse(SourceText(text + "\n", f"{name}.prg")) for text, name in pairs]
    assert not [f for tree in trees for f in tree.findings]
    findings = [f for f in language.check(trees) if f.path == f"{first}.prg"]
    assert all(f.cure and "{" not in f.message + f.cure for f in findings)
    return [f"{f.code} {f.line}:{f.column}" for f in findings if f.code not in quiet]


def numbered(lines: str, step: int = 10) -> str:
    return "\n".join(f"{i * step} {line}" for i, line in enumerate(lines.split("\n"), 1))


POINT = "({x},0,300,180,0,180)({flag},0)"


def taught(*names: str, flag: int = 7) -> str:
    """Lines of positions, 100 mm apart."""
    return "\n".join(
        f"{name}={POINT.format(x=(i + 1) * 100, flag=flag)}" for i, name in enumerate(names)
    )


LINES: dict[str, Row] = {
    "a jump without label": ("GoTo *X", ["MB101 1:6"]),
    "a jump to a label in another case": ("*loop\nDly 1\nGoTo *LOOP", []),
    "a branch without label": ("If M_In(1)=1 Then *X Else *Y\n*X", ["MB101 1:27"]),
    "an interrupt without label": ("Def Act 1,M_In(1)=1 GoSub *X\nAct 1=1", ["MB101 1:27"]),
    "one of several without label": ("*X\nOn M_In(1) GoTo *X,,*Y", ["MB101 2:21"]),
    "two labels of one name": ("*X\nDly 1\n*x\nGoTo *X", ["MB103 3:1"]),
    "a comment that looks like a label": ("*X\nDly 1 ' *X\nGoTo *X", []),
    "a name of 41": (f"M{'1' * 40}=1", ["MB106 1:1"]),
    "a name of 40": (f"M{'1' * 39}=1", []),
    "a label of 41": (f"*L{'1' * 40}\nGoTo *L{'1' * 40}", ["MB106 1:1"]),
    "an external name of 41": (f"M_{'1' * 39}=1", []),
    "a step of 241": (f"M1=1 '{'x' * 235}", ["MB107 1:1"]),
    "a step of 240": (f"M1=1 '{'x' * 234}", []),
    "declared twice": ("Def Inte MA\nDim MA(2)", ["MB120 2:5"]),
    "declared once each": ("Def Inte MA\nDim MB(2)", []),
    "read, never assigned": ("M_Out(1)=MA+MA", ["MB113 1:10"]),
    "assigned below": ("*X\nM_Out(1)=MA\nMA=1\nGoTo *X", []),
    "read from a line": (
        'Open "COM1:" As #1\nInput #1,MA,PA\nM_Out(1)=MA\nMov PA\nClose #1',
        [],
    ),
    "a component of nothing": ("M_Out(1)=PA.X", ["MB113 1:10"]),
    "only declared": ("Def Inte MA\nM_Out(1)=MA", ["MB113 2:10"]),
    "a name in a text": ('C1$="MA"\nPrint #1,C1$', ["MB711 2:1"]),
    "a position by its number": ("Mov P1", ["MB104 1:5"]),
    "a position that is there": ("Mov P1\n" + taught("P1"), []),
    "a joint variable": ("Mov J1", ["MB104 1:5"]),
    "one of a table": (
        "1 Mvs P1\n2 Mvs P2\n3 Mvs P9\n" + taught("P1", "P2"),
        ["MB104 3:7"],
    ),
    "an empty line of a position": (
        "Mov P1\nMov P2\nP1=(,,,,,)(,)\n" + taught("P2"),
        ["MB104 1:5"],
    ),
    "an external variable": ("M_Out(1)=M_ABC", ["MB114 1:10"]),
    "an external variable that is set": ("M_ABC=1\nM_Out(1)=M_ABC", []),
    "a slip in a status variable": ("M_Out(1)=M_Tiemr(1)", ["MB609 1:10"]),
    "an array without Dim": ("M1=2\nP(M1)=P_Curr\nMov P(M1)", []),
    "an array that nothing fills": ("M1=2\nMov P(M1)", ["MB119 2:5"]),
    "an array with Dim": ("Dim P(5)\nM1=2\nMov P(M1)", []),
    "two lines of one position": (
        "Mov P1\nMov PA\n" + taught("P1", "PA", "PA"),
        ["MB112 5:1"],
    ),
    "two rows of one position": (
        "Mov P1\nMov P2\n" + taught("P1", "P2", "P1"),
        ["MB112 5:1"],
    ),
    "a row and a line": (
        "Mov P1\nMov P2\n" + taught("P1", "P2") + "\nM9=1\n" + taught("P2"),
        ["MB112 6:1"],
    ),
}


@pytest.mark.parametrize(("text", "expected"), LINES.values(), ids=LINES)
def test_lines_and_names(text: str, expected: list[str]) -> None:
    assert found(5, text) == expected


STEPS: dict[str, Row] = {
    "a jump without line": ("10 IF M_IN(1)=1 THEN 200", ["MB102 1:22"]),
    "a jump to a line": ("10 DLY 1\n20 GOTO 10", []),
    "a line twice": ("10 DLY 1\n10 DLY 2", ["MB108 2:1"]),
    "lines that descend": ("20 DLY 1\n10 END", ["MB108 2:1"]),
    "moves that descend": (
        "20 MOV P1\n30 MOV P1\n25 MOV P1\n" + taught("P1"),
        ["MB108 3:1"],
    ),
    "a line above 32767": ("32768 END", ["MB109 1:1"]),
    "moves above 32767": ("32766 MOV P1\n32769 MOV P1\n" + taught("P1"), ["MB109 2:1"]),
    "the last line": ("32767 END", []),
    "a line without number": ("10 DLY 1\nEND", ["MB110 2:1"]),
    "a comment without number": ("10 DLY 1\n' done\n20 END", ["MB110 2:1"]),
    "an empty line without number": ("10 DLY 1\n\n20 END", []),
    "no line with a number": ("' heading\nDLY 1\nEND", ["MB110 2:1"]),
    "a name of 9": ("10 MABCDEFGH=1", ["MB106 1:4"]),
    "a name of 8": ("10 MABCDEFG=1", []),
    "a label of 9": ("10 *ABCDEFGHI\n20 GOTO *ABCDEFGHI", ["MB106 1:4"]),
    "a label with _": ("10 *A_B\n20 GOTO *A_B", ["MB117 1:4"]),
    "a shared label": ("10 *L_B\n20 GOTO *L_B", []),
    "a step of 128": ("10 ' " + "x" * 123, ["MB107 1:4"]),
    "a step of 127": ("10 ' " + "x" * 122, []),
}


@pytest.mark.parametrize(("text", "expected"), STEPS.values(), ids=STEPS)
def test_steps_of_the_oldest_version(text: str, expected: list[str]) -> None:
    assert found(4, text) == expected


BLOCKS: dict[str, Row] = {
    "For without Next": ("For M1=1 To 3\nDly 1", ["MB105 1:1"]),
    "Next without For": ("Dly 1\nNext", ["MB105 2:1"]),
    "While without WEnd": ("While M_In(1)=1", ["MB105 1:1"]),
    "If without EndIf": ("If M_In(1)=1 Then\nDly 1", ["MB105 1:1"]),
    "Select without End Select": ("Select M_In(1)\nCase 1\nDly 1", ["MB105 1:1"]),
    "Else without If": ("Else", ["MB105 1:1"]),
    "Case without Select": ("Case 1", ["MB105 1:1"]),
    "blocks that cross": (
        "For M1=1 To 3\nIf M_In(1)=1 Then\nNext\nEndIf",
        ["MB131 3:1"],
    ),
    "an inner block without end": (
        "For M1=1 To 3\nWhile M_In(1)=1\nDly 1\nNext",
        ["MB105 2:1"],
    ),
    "blocks in order": ("For M1=1 To 3\nIf M_In(1)=1 Then\nDly 1\nEndIf\nNext", []),
    "Next of two loops": ("For M1=1 To 3\nFor M2=1 To 3\nDly 1\nNext M2,M1", []),
    "Next of two loops in the wrong order": (
        "For M1=1 To 3\nFor M2=1 To 3\nDly 1\nNext M1,M2",
        ["MB146 4:6", "MB146 4:9"],
    ),
    "Next of another loop": ("For M1=1 To 3\nDly 1\nNext M2", ["MB146 3:6"]),
    "17 loops": (
        "\n".join(["While M_In(1)=1"] * 17 + ["WEnd"] * 17),
        ["MB132 17:1"],
    ),
    "16 loops": ("\n".join(["While M_In(1)=1"] * 16 + ["WEnd"] * 16), []),
    "9 branches": (
        "\n".join(["If M_In(1)=1 Then"] * 9 + ["EndIf"] * 9),
        ["MB132 9:1"],
    ),
    "8 branches": ("\n".join(["If M_In(1)=1 Then"] * 8 + ["EndIf"] * 8), []),
    "a Select in a Select": (
        "Select M_In(1)\nCase 1\nSelect M_In(2)\nCase 1\nDly 1\nEnd Select\nEnd Select",
        [],
    ),
    "one variable for two loops": (
        "For M1=1 To 3\nFor M1=1 To 3\nDly 1\nNext\nNext",
        ["MB145 2:5"],
    ),
    "a loop variable that is set": (
        "For M1=1 To 3\nIf M_In(1)=1 Then M1=3\nNext",
        ["MB144 2:19"],
    ),
    "a loop variable that is set behind": ("For M1=1 To 3\nDly 1\nNext\nM1=3", []),
    "Else behind Else": (
        "If M_In(1)=1 Then\nDly 1\nElse\nDly 2\nElse\nDly 3\nEndIf",
        ["MB147 5:1"],
    ),
    "Default twice": (
        "Select M_In(1)\nCase 1\nDly 1\nDefault\nDly 2\nDefault\nDly 3\nEnd Select",
        ["MB147 6:1"],
    ),
}


@pytest.mark.parametrize(("text", "expected"), BLOCKS.values(), ids=BLOCKS)
def test_blocks(text: str, expected: list[str]) -> None:
    assert found(5, text) == expected


WAYS: dict[str, Row] = {
    "into a loop": (
        "If M_In(1)=1 Then GoTo *X\nFor M1=1 To 3\n*X\nDly 1\nNext",
        ["MB134 1:24"],
    ),
    "within a loop": ("For M1=1 To 3\n*X\nIf M_In(1)=1 Then GoTo *X\nNext", []),
    "out of a loop": ("For M1=1 To 3\nIf M_In(1)=1 Then GoTo *X\nNext\n*X\nDly 1", []),
    "into a branch": (
        "If M_In(1)=1 Then\n*X\nDly 1\nEndIf\nIf M_In(2)=1 Then *X",
        ["MB134 5:19"],
    ),
    "into the other branch": (
        "If M_In(1)=1 Then\nDly 1\nElse\n*X\nDly 2\nIf M_In(3)=1 Then *X\nEndIf",
        [],
    ),
    "a subroutine": ("GoSub *S\nEnd\n*S\nDly 1\nReturn", []),
    "a subroutine that is run into": ("GoSub *S\n*S\nDly 1\nReturn", ["MB135 2:1"]),
    "a subroutine behind a way that may end": (
        "GoSub *S\nIf M_In(1)=1 Then End\n*S\nDly 1\nReturn",
        ["MB135 3:1"],
    ),
    "a subroutine behind branches that both leave": (
        "*A\nGoSub *S\nIf M_In(1)=1 Then *A Else *B\n*S\nDly 1\nReturn\n*B",
        [],
    ),
    "a jump into a subroutine": (
        "GoSub *S\nIf M_In(1)=1 Then GoTo *S\nEnd\n*S\nDly 1\nReturn",
        ["MB136 2:24"],
    ),
    "a subroutine that jumps to its own begin": (
        "GoSub *S\nEnd\n*S\nDly 1\nIf M_In(1)=1 Then GoTo *S\nReturn",
        [],
    ),
    "Return alone": ("Dly 1\nReturn", ["MB137 2:1"]),
    "no Return": ("GoSub *S\nEnd\n*S\nDly 1\nEnd", ["MB138 3:1"]),
    "a Return on one way": ("GoSub *S\nEnd\n*S\nIf M_In(1)=1 Then Return\nGoTo *S", []),
    "an interrupt with a plain Return": (
        "Def Act 1,M_In(1)=1 GoSub *S\nAct 1=1\nDly 9\nEnd\n*S\nDly 1\nReturn",
        ["MB139 7:1"],
    ),
    "an interrupt that returns": (
        "Def Act 1,M_In(1)=1 GoSub *S\nAct 1=1\nDly 9\nEnd\n*S\nDly 1\nReturn 1",
        [],
    ),
    "an interrupt that jumps away": (
        "Def Act 1,M_In(1)=1 GoTo *S\nAct 1=1\nDly 9\nEnd\n*S\nDly 1\nEnd",
        [],
    ),
    "a number behind Return": ("GoSub *S\nEnd\n*S\nDly 1\nReturn 1", ["MB140 5:1"]),
    "behind End": ("Dly 1\nEnd\nDly 2\nDly 3", ["MB141 3:1"]),
    "behind End at a label": ("*X\nIf M_In(1)=1 Then *Y\nEnd\n*Y\nDly 2\nGoTo *X", []),
    "behind an endless loop": ("While 1\nDly 1\nWEnd\nDly 2", ["MB141 4:1"]),
    "behind a loop that is left": (
        "While 1\nIf M_In(1)=1 Then\nBreak\nEndIf\nWEnd\nDly 2",
        [],
    ),
    "in front of the first Case": (
        "Select M_In(1)\nDly 1\nCase 1\nDly 2\nEnd Select",
        ["MB141 2:1"],
    ),
    "a habit of ends": ("*X\nDly 1\nGoTo *X\nEnd", []),
    "behind branches that both leave": (
        "*X\nIf M_In(1)=1 Then\nGoTo *X\nElse\nEnd\nEndIf\nDly 1",
        ["MB141 7:1"],
    ),
}


@pytest.mark.parametrize(("text", "expected"), WAYS.values(), ids=WAYS)
def test_ways_through_a_program(text: str, expected: list[str]) -> None:
    assert found(5, text) == expected


VALUES: dict[str, Row] = {
    "an override of 0": ("Ovrd 0", ["MB601 1:6"]),
    "an override of millimetres": ("Ovrd 500", ["MB601 1:6"]),
    "an override": ("Ovrd 100\nOvrd 50,30,20\nJOvrd 1", []),
    "no speed": ("Spd 0", ["MB601 1:5"]),
    "the fastest speed": ("Spd M_NSpd\nSpd 0.5", []),
    "a time before now": ("Dly -1", ["MB601 1:6"]),
    "a time too short": ("Dly 0.001", ["MB619 1:5"]),
    "no time, and a short one": ("Dly 0\nDly 0.01", []),
    "a pulse before now": ("M_Out(1)=1 Dly -0.5", ["MB601 1:17"]),
    "a pulse": ("M_Out(1)=1 Dly 0.5", []),
    "a corner of two": ("Cnt 2", ["MB601 1:5"]),
    "a hand of nine": ("HOpen 9", ["MB601 1:7"]),
    "hands": ("HOpen 1\nHClose 8", []),
    "an error of others": ("Error 8000", ["MB601 1:7"]),
    "own errors": ("If M_In(1)=1 Then Error 9000\nError 9299", []),
    "file 9": ('Open "COM1:" As #9\nClose #9', ["MB601 1:18", "MB601 2:8"]),
    "slot 33": ("XRst 33", ["MB601 1:6"]),
    "interrupt 9": (
        "Def Act 9,M_In(1)=1 GoTo *X\nAct 9=1\n*X\nAct 1=0",
        ["MB601 1:9", "MB708 4:1"],
    ),
    "pallet 9": (
        "Def Plt 9,P1,P2,P3,,3,4,1\n" + taught("P1", "P2", "P3"),
        ["MB601 1:9"],
    ),
    "timer 9": ("M_Timer(9)=0\nEnd", ["MB601 1:9"]),
    "a Type of 3": ("Mvs P1 Type 0,3\n" + taught("P1"), ["MB601 1:15"]),
    "a Type of 2": ("Mvs P1 Type 0,2\n" + taught("P1"), []),
    "a position with a gap": ("Mov P1\nP1=(1,,3,0,0,0)(7,0)", ["MB616 2:1"]),
    "a position of four axes": ("Mov P1\nP1=(1,2,3,,,90)(4,0)", []),
    "a distance without position": ("Mov ,50", ["MB617 1:1"]),
    "a distance along the tool": ("Mvs ,50", []),
    "a signal without number": ("M_Out(1)=M_In()", ["MB617 1:10"]),
    "a value among the steps": ("1 Dly 1\nM1=5\n2 M_Out(1)=M1", ["MB620 2:1"]),
    "a value behind the steps": ("1 Dly 1\n2 M_Out(1)=M1\nM1=5", []),
    "a step of nothing": ("1 Dly 1\n2\n3 Dly 1", ["MB618 2:1"]),
    "a step of a comment": ("1 Dly 1\n2 '\n3 Dly 1", []),
    "no argument": ("Ovrd", ["MB602 1:1"]),
    "an argument too many": ("Dly 1,2", ["MB602 1:1"]),
    "an arc of two points": ("Mvr P1,P2\n" + taught("P1", "P2"), ["MB602 1:1"]),
    "a function with too few": ("M_Out(1)=Dist(P1)\n" + taught("P1"), ["MB602 1:10"]),
    "a function with any number": ("M_Out(1)=Max(1,2,3,4)", []),
    "17 arguments": ('CallP "B",' + ",".join("1" * 17), ["MB602 1:1", "MB115 1:7"]),
    "a move to a number": ("M1=1\nMov M1", ["MB603 2:5"]),
    "a linear move to joints": ("Mvs J1\nJ1=(0,0,90,0,90,0)", ["MB603 1:5"]),
    "a move to joints": ("Mov J1\nJ1=(0,0,90,0,90,0)", []),
    "a move to a product": ("Mov P1*P2\n" + taught("P1", "P2"), []),
    "the length of a number": ("M_Out(1)=Len(5)", ["MB603 1:10"]),
    "a length": ('M_Out(1)=Len("5")', []),
    "a program by number": ("CallP 5", ["MB603 1:1"]),
    "a tool by number": ("Tool 1\nBase P_NBase", []),
    "a number for a position": ("P1=1\nMov P1", ["MB604 1:1"]),
    "a position for a number": ("M1=P_Curr", ["MB604 1:1"]),
    "joints for a position": ("P1=J_Curr\nMov P1", ["MB604 1:1"]),
    "joints for a position by a function": ("P1=JtoP(J_Curr)\nMov P1", []),
    "a constant for either": ("P1=(1,2,3,0,0,0)\nJ1=(1,2,3,0,0,0)\nMov P1\nMov J1", []),
    "flags for joints": ("J1=(1,2,3,0,0,0)(7,0)\nMov J1", ["MB604 1:1"]),
    "a number for a text": ("C1$=5", ["MB604 1:1"]),
    "a line of data of another type": ("Mov P1\nP1=5\nM1=5", ["MB604 2:1"]),
    "a text for a component": ('P1=P_Curr\nP1.X="5"\nMov P1', ["MB604 2:1"]),
    "a number by its declaration": ("Def Float PX\nPX=5\nM_Out(1)=PX", []),
    "a text by its declaration": ('Def Char MX\nMX="5"\nM_Out(1)=Len(MX)', []),
    "a text without mark": ('C1="5"', ["MB612 1:1"]),
    "a text with mark": ('C1$="5"', []),
    "a text plus a number": ('C1$="5"+5', ["MB605 1:1"]),
    "a text plus a text": ('C1$="5"+Str$(5)', []),
    "a text compared with a number": ('C1$="5"\nIf C1$=5 Then End', ["MB605 2:4"]),
    "a mark of another type": ('Def Inte MA\nMA$="5"\nEnd', ["MB606 2:1"]),
    "a mark of the same type": ("Def Inte MA\nMA%=5", []),
    "an input that is set": ("M_In(5)=1\nEnd", ["MB607 1:1"]),
    "an override that is set": ("M_Ovrd=50\nEnd", ["MB607 1:1"]),
    "a timer that is set": ("M_Timer(1)=0\nM_Out(5)=1\nEnd", []),
    "a timer with seconds": (
        "M_Timer(1)=0\n*W\nIf M_Timer(1)<5 Then *W",
        ["MB610 3:4"],
    ),
    "a timer with milliseconds": ("M_Timer(1)=0\n*W\nIf M_Timer(1)<5000 Then *W", []),
    "an angle in degrees": ("P1=P_Curr\nP1.C=90\nMov P1", ["MB611 2:1"]),
    "an angle in radian": ("P1=P_Curr\nP1.C=Rad(90)\nP1.X=90\nMov P1", []),
    "the sine of degrees": ("M_Out(1)=Sin(45)", ["MB611 1:10"]),
    "too large for 16 bits": ("Def Inte MA\nMA=40000\nMB%=1\nEnd", ["MB613 2:1"]),
    "just in 16 bits": ("Def Inte MA\nMA=32767\nMB%=&HFFFF\nEnd", []),
    "four dimensions": ("Dim MA(2,2,2,2)", ["MB614 1:5"]),
    "a dimension of 0": ("Dim MA(0)", ["MB614 1:5"]),
    "an element beyond the end": ("Dim MA(3)\nMA(4)=1\nEnd", ["MB614 2:1"]),
    "the last element": ("Dim MA(3,2)\nMA(3,2)=1\nEnd", []),
    "one subscript too many": ("Dim MA(3)\nMA(3,2)=1\nEnd", ["MB614 2:1"]),
}


@pytest.mark.parametrize(("text", "expected"), VALUES.values(), ids=VALUES)
def test_values_and_types(text: str, expected: list[str]) -> None:
    assert found(5, text) == expected


MOVES: dict[str, Row] = {
    "a position of zeros": ("Mov P1\nP1=(0,0,0,0,0,0)(0,0)", ["MB701 1:5"]),
    "a row of zeros": (
        "1 Mov P1\n2 Mov P2\nP1=(1,2,3,0,0,0)(7,0)\nP2=(0,0,0,0,0,0)(0,0)",
        ["MB701 2:7"],
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


@pytest.mark.parametrize(("text", "expected"), MOVES.values(), ids=MOVES)
def test_motion(text: str, expected: list[str]) -> None:
    assert found(5, text) == expected


OLDEST: dict[str, Row] = {
    "a block": (
        "IF M_IN(1)=1 THEN\nDLY 1\nELSE\nDLY 2\nENDIF",
        [
            "MB111 1:4",
            "MB111 3:4",
            "MB111 5:4",
        ],
    ),
    "a branch": ("*A\nIF M_IN(1)=1 THEN GOTO *A ELSE GOTO *B\n*B", []),
    "Break in a loop": ("WHILE M_IN(1)=1\nBREAK\nWEND", ["MB111 2:4"]),
    "Break in Select": ("SELECT M_IN(1)\nCASE 1\nBREAK\nEND SELECT", []),
    "Select in Select": (
        "SELECT M_IN(1)\nCASE 1\nSELECT M_IN(2)\nCASE 1\nDLY 1\nEND SELECT\nEND SELECT",
        ["MB133 3:4"],
    ),
    "a wide Wait": ("WAIT M_IN(1)=1 AND M_IN(2)=1", ["MB111 1:4"]),
    "a Wait": ("WAIT M_IN(1)=1", []),
    "a newer signal": ("M1=M_IN8(16)", ["MB111 1:7"]),
    "an older signal": ("M1=M_INB(16)", []),
    "a newer function": ("M1=ASIN(0.5)", ["MB111 1:7"]),
    "a newer statement": ("MVTUNE 2", ["MB111 1:4"]),
    "a function block": ("FUNCTION MAIN\nFEND", ["MB111 1:4", "MB111 2:4"]),
    "a constant": ("CONST MA=5", ["MB111 1:4"]),
    "a statement behind a label": ("*A:DLY 1\nGOTO *A", ["MB111 1:4"]),
    "a stored tool": ("TOOL 1", ["MB111 1:4"]),
    "a distance": ("FINE 0.1,P", ["MB111 1:4"]),
    "pulses": ("FINE 100", []),
    "through a singular point": ("MVS P_SAFE TYPE 0,2", ["MB111 1:15", "MB601 1:22"]),
    "eight programs deep": ('CALLP "B"', ["MB142 1:4"]),
}


@pytest.mark.parametrize(("text", "expected"), OLDEST.values(), ids=OLDEST)
def test_what_the_oldest_version_lacks(text: str, expected: list[str]) -> None:
    chain = [numbered(f'CALLP "{name}"') for name in "CDEFGHI"]
    assert found(4, numbered(text), *chain, numbered("END")) == expected


@pytest.mark.parametrize(
    ("version", "text", "expected"),
    [
        (5, "1 If M_In(1)=1 Then 2\n2 End", ["MB121 1:21"]),
        (5, "M_Out(1)=M_SfIArea(1)", ["MB111 1:10"]),
        (6, "M_Out(1)=M_SfIArea(1)", []),
        (5, '#Include "B"', ["MB111 1:2", "MB115 1:10"]),
        (6, '#Include "B"\nM_Out(1)=MX', ["MB115 1:10"]),
        (6, "Function Main\nDly 1\nFEnd", []),
        (6, "Function M% Add(ByVal MA,ByVal MB)\nAdd=MA+MB\nFEnd", []),
        (6, "Part(1)\nFunction Part(ByVal MA)\nM_Out(1)=MA\nFEnd", []),
        (6, "Part(1,2)\nFunction Part(ByVal MA)\nM_Out(1)=MA\nFEnd", ["MB602 1:1"]),
        (6, "Part(1)", ["MB122 1:1"]),
        (6, "Function Main\nGoTo *X\nFEnd\nFunction Part\n*X\nFEnd", ["MB101 2:6"]),
        (6, "Function Main\n*X\nFEnd\nFunction Part\n*X\nFEnd", []),
    ],
)
def test_newer_versions(version: int, text: str, expected: list[str]) -> None:
    assert found(version, text) == expected


# -------------------------------------------------------------------------------- several programs


@pytest.mark.parametrize(
    ("texts", "expected"),
    [
        (['CallP "B"'], ["MB115 1:7"]),
        (['CallP "B"', "Dly 1"], []),
        (['CallP "b"', "Dly 1"], []),
        (['XRun 2,"B"\nXLoad 3,"C"', "Dly 1"], ["MB115 2:9"]),
        (['CallP "B"', 'CallP "C"', 'CallP "A"'], ["MB143 1:1"]),
        (['CallP "B"', 'CallP "C"', "Dly 1"], []),
        (['XRun 2,"B"', "Mov P_Safe"], ["MB707 1:8"]),
        (['XRun 2,"B"', "GetM 1\nMov P_Safe"], []),
        (['XRun 1,"B"', "Mov P_Safe"], []),
        (["M_Out(1)=M_ABC", "M_ABC=1"], ["MB114 1:10"]),
        (["Print #1,5", 'Open "COM1:" As #1\nCallP "A"\nClose #1'], []),
    ],
)
def test_programs_together(texts: list[str], expected: list[str]) -> None:
    assert found(5, *texts) == expected


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("PICK2", []),
        ("pick", []),
        ("ABCDEFGHIJKL", []),
        ("ABCDEFGHIJKLM", ["MB118 None:None"]),
        ("PICK_2", ["MB118 None:None"]),
    ],
)
def test_names_of_programs(name: str, expected: list[str]) -> None:
    assert found(5, "Dly 1", first=name) == expected
    assert found(5, taught("P1"), first=name) == []


# --------------------------------------------------------------------------------------- advice


def test_what_nothing_uses() -> None:
    text = "*A\nM1=1\nM2=2\nMov P1\nM_Out(1)=M2\n" + taught("P1", "P2", "P3")
    assert found(5, text, quiet=()) == [
        "MB116 1:1",
        "MB116 2:1",
        "MB710 4:1",
        "MB116 7:1",
    ]


def test_what_is_used() -> None:
    text = "Tool P_NTool\n*A\nMov P1*P2\nFor M1=1 To 3\nNext\nGoTo *A\n" + taught("P1", "P2")
    assert found(5, text, quiet=()) == []


def test_advice_is_not_asked_about_what_was_compiled() -> None:
    text = "' robot-assistant: melfa-basic-5\nMov P1\n" + taught("P1", "P2")
    assert found(5, text, quiet=()) == []


@pytest.mark.parametrize("version", [4, 5, 6])
@pytest.mark.parametrize("sample", ["positioning.csv", "taught.toml", "plate.dxf"])
def test_what_is_compiled_breaks_no_rule(sample: str, version: int) -> None:
    name = f"melfa-basic-{version}"
    language = languages.get(name)
    compiled = assistant.compile(SAMPLES / sample, language=name, robot="rv-4frl")
    texts = [language.decode(data, file) for file, data in compiled.files.items()]
    assert texts
    assert language.check([language.parse(text) for text in texts]) == ()


@pytest.mark.parametrize("file", sorted((SAMPLES / "melfa").glob("*.prg")), ids=lambda f: f.stem)
def test_samples_break_no_rule(file: Path) -> None:
    language = languages.of_file(file, file.read_bytes())
    assert language is not None
    findings = language.check([language.parse(language.read(file))])
    assert {f.severity for f in findings} <= {Severity.INFO}


def test_positions_that_are_taught_on_the_controller() -> None:
    """A file without any positions may have them on the controller."""
    language = languages.get("melfa-basic-5")
    for lines, severity in (("", Severity.WARNING), (taught("P2"), Severity.ERROR)):
        tree = language.parse(f"Mov P1\n{lines}\n")
        assert [f.severity for f in language.check([tree]) if f.code == "MB104"] == [severity]


def test_a_tree_without_source_is_checked_as_well() -> None:
    language = languages.get("melfa-basic-5")
    tree = language.parse("Mov P1\nGoTo *X\n")
    bare = replace(tree, source=None)
    codes = {f.code for f in language.check([bare])}
    assert {"MB101", "MB104"} <= codes


def test_every_rule_is_listed_once() -> None:
    assert len({*RULES, *ADVICE}) == len(RULES) + len(ADVICE)


def test_long_programs_stay_in_columns() -> None:
    """Thousands of moves with one mistake each give a handful of findings."""
    count = 3000
    moves = "".join(f"{i} MVS P{i}\n" for i in range(1, count + 1))
    rows = "".join(
        f"P{i}=(+{i}.00,+0.00,+300.00,+180.00,+0.00,+180.00)({6 + i % 2},0)\n"
        for i in range(1, count + 1)
    )
    language = languages.get("melfa-basic-5")
    tree = language.parse(moves + rows)
    assert len(tree.items) == 2
    findings = language.check([tree])
    assert [f.code for f in findings if f.code not in QUIET] == ["MB702"] * 5
    assert "2994 more" in findings[-1].message + findings[-2].message
