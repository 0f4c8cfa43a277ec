"""Rules of values, types and arguments, and of what a version lacks."""

from __future__ import annotations

from tests.languages.melfa_basic.ruled import Row, found, numbered, taught
from tests.tables import every_row

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
    "camera 9": ('NVRun #9,"JOB"', ["MB601 1:8"]),
    "cameras": ('NVOpen "COM2:" As #1\nNVRun #1,"JOB"\nEBRead #1,,MA\nM_Out(1)=MA\nNVClose #1', []),
    "a line where none is": ("Dly #1", ["MB603 1:1"]),
    "a label where none is": ("Dly *X\n*X", ["MB603 1:1", "MB138 2:1"]),
    "a label of a tracked move": (
        "TrkMv On,P1,*X\nTrkMv Off\nEnd\n*X\nReturn 1\n" + taught("P1"),
        [],
    ),
    "a label that is not there": ("TrkMv On,P1,*X\n" + taught("P1"), ["MB101 1:13"]),
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
    "a position with a gap": ("M1=P1.X\nP1=(1,,3,0,0,0)(7,0)", ["MB616 2:1"]),
    "a pose with a gap": ("Mov P1\nP1=(1,,3,0,0,0)(7,0)", ["MB622 2:1"]),
    "a pose without its end": ("Mov P1\nP1=(1,2,3)(7,0)", ["MB622 2:1"]),
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
    "17 arguments": ('CallP "B",' + ",".join("1" * 17), ["MB602 1:1", "MB123 1:7"]),
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
    "a spline by its number": ("MvSpl 1,50,2\nEMvSpl 3,20,10\nEnd", []),
    "one subscript too many": ("Dim MA(3)\nMA(3,2)=1\nEnd", ["MB614 2:1"]),
}


@every_row(("text", "expected"), VALUES)
def test_values_and_types(text: str, expected: list[str]) -> None:
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


@every_row(("text", "expected"), OLDEST)
def test_what_the_oldest_version_lacks(text: str, expected: list[str]) -> None:
    chain = [numbered(f'CALLP "{name}"') for name in "CDEFGHI"]
    assert found(4, numbered(text), *chain, numbered("END")) == expected


@every_row(
    ("version", "text", "expected"),
    [
        (5, "1 If M_In(1)=1 Then 2\n2 End", ["MB121 1:21"]),
        (5, "M_Out(1)=M_SfIArea(1)", ["MB111 1:10"]),
        (6, "M_Out(1)=M_SfIArea(1)", []),
        (5, '#Include "B"', ["MB111 1:2", "MB115 1:10"]),
        (6, '#Include "B"\nM_Out(1)=MX', ["MB115 1:10"]),
        (6, '#Include "B"\nPA=Found(1)\nMov PA', ["MB115 1:10"]),
        (6, '#Include "B"\nTable=Found(1)\nMov Table', ["MB115 1:10"]),
        (6, '#Include "B"\nP1=M1+1\nMov P1', ["MB115 1:10", "MB604 2:1"]),
        (6, "PA=Found(1)\nMov PA", ["MB604 1:1", "MB119 1:4"]),
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
