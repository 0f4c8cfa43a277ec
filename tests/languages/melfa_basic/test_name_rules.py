"""Rules of lines, labels and names."""

from __future__ import annotations

from tests.languages.melfa_basic.ruled import Row, found, taught
from tests.tables import every_row

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
    "an external name of 41": (f"M_{'1' * 39}=1", ["MB106 1:1"]),
    "an external name of 40": (f"M_{'1' * 38}=1", []),
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


@every_row(("text", "expected"), LINES)
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
    "an external name of 9": ("10 M_BCDEFG=1\n20 M_BCDEFGH=1", ["MB106 2:4"]),
    "a label of 9": ("10 *ABCDEFGHI\n20 GOTO *ABCDEFGHI", ["MB106 1:4"]),
    "a label with _": ("10 *A_B\n20 GOTO *A_B", ["MB117 1:4"]),
    "a shared label": ("10 *L_B\n20 GOTO *L_B", []),
    "a step of 128": ("10 ' " + "x" * 123, ["MB107 1:4"]),
    "a step of 127": ("10 ' " + "x" * 122, []),
}


@every_row(("text", "expected"), STEPS)
def test_steps_of_the_oldest_version(text: str, expected: list[str]) -> None:
    assert found(4, text) == expected
