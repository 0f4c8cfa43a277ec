"""Every statement and literal in the spellings that people and tools use."""

from __future__ import annotations

import pytest

from assistant import languages
from assistant.languages.melfa_basic.tree import syntax as s
from tests.tables import every_row

FIVE = languages.get("melfa-basic-5")


def read(text: str) -> s.Line:
    tree = FIVE.parse(text)
    assert not tree.findings, tree.findings
    assert FIVE.render(tree) == text
    (line,) = tree.items
    assert isinstance(line, s.Line)
    return line


LINES = """\
10 MVS,-100
10 PRINT#1
10 Print #1,M1;C1$,
10 Input#2 ,M1,P1.X
10 MXT1,0
10 While(1)
10 Dly(0.5)
10 If(M1=1)Then*A
10 If M1>10 Then 200
10 GOTO 100
10 GoSub *L_1
10 If M1=1 Then GoTo *A Else Return 1
10 If M1=1 GoTo *A Else *B
10 If M1 Then If M2 Then M3=1 Else M3=2
10 ElseIf M1=2 Then
10 Else If M1=2 Then
10 END IF
10 On M1 GoTo *A,,*C
10 On M1 GoSub 100,200
10 On Com(1) GoSub *A
10 Com(1) Off
10 Com Stop
10 Select Case M1
10 Case 1 To 3,Is >= 7
10 End Select
10 CNT 1,
10 Accel ,,50
10 Mov (Plt 1,M2) Type 0,1 Wth M_Out(1)=1 Dly 0.2
10 Mvs P1*(0,0,-50,0,0,0) WthIf M_In(1)=1 And M_In(2)=0,Skip
10 Mvs P1 WthIf M_In(1)=1,Hlt
10 Mvr P1,P2,P3,Type 0,1
10 Mov P(M1+1),-50
10 Mov SetPos(1,2,3)
10 P1=(1.5,-2,,,,+90)(7,&H00F00000)
10 P1=(,)
10 P1=(100,200,300,0,90)(6,0)
10 P1=( 1 , 2 , 3 ) ( , )
10 J1=(0,10,80,0,90,0)
10 M1=&HFF+&B1010*1.5E-3-0.0#+100%
10 M_20#=M1&+M2!
10 P1.X=P2(3).J1
10 M1=-2^-2 Mod 3 \\ 4
10 M1=Not M2 And(M3 Or M4)Xor M5
10 If M1>=2 And M2=<3 Or M3><4 Then Hlt
10 C1$="it's"+Left$(C2$,2)
10 Def Io PORT=Byte,16,&H0F
10 Def Act 1,M_In(1)=1 GoSub *A,S
10 Act 1=1
10 ACT1=1
10 Def Plt 1,P1,P2,P3,,4,3,1
10 Def FNMAVE(M1,M2)=(M1+M2)/2
10 Def Inte N_A%,B
10 Def Arch 1,5,5,20,20
10 Dim P(10),M1#(2,3),C1$(5)
10 Const Def Inte Y = 10
10 Static Def Pos P1
10 #Include "TOOLS"
10 Function V Main()
10 Function M% Sum(ByVal A%, ByRef P1(), B)
10 Exit Function
10 Weld(P1, 2)
10 FPrm P1,M1
10 CallP "SUB",P1,M1
10 Open "ENET:192.168.0.1" For Input As 1
10 Close #1,#2
10 NVOpen "COM2:" As #1
10 NVOpen CLINE$ As 2
10 NVClose
10 NVClose #1,#2
10 NVLoad #1,"PARTS"
10 NVRun #1, "PARTS"
10 NVPst #1,"PARTS","E76","J81","L84",1,10
10 NVIn #M1,"PARTS","E76","J81","L84",0,10
10 NVTrg #1,10,MENC1,,MENC2
10 EBRead #1,,MNUM,PVS1,PVS2
10 EBWrite #1,"Job.Robot.X",M1
10 V3Open "COM2:" As #1
10 TrkMv On,PX1,*S1
10 TrkMv Off
10 Cmp Pos,&B011011
10 Fine 0.5,P
10 XRun 2,"SUB",1
10 Reset Err
10 Error 9100
10 Wait (M_In(1)=1 And M2<6) Or M_In(2)=1
10 *LOOP:M1=M1+1
10*LOOP'again
*LOOP Rem again
10 RelM Rem release
10 REM
10'
10 ' 20 MOV P1
10\tHClose\t1\t'x
""".replace("\\\\", "\\").splitlines()


@every_row("line", LINES)
def test_lines_are_read_and_kept(line: str) -> None:
    read(line)


@every_row(
    ("line", "statement"),
    [
        ("GOTO 100", s.Jump("GoTo", s.Target(100))),
        ("If M1 Then 200", s.If(s.Variable("M1"), s.Target(200))),
        ("If(M1)Then*A", s.If(s.Variable("M1"), s.Target("A"))),
        ("END IF", s.Command("EndIf")),
        ("End Select", s.Command("End Select")),
        ("Servo On", s.Command("Servo", (s.Word("On"),))),
        ("CNT 1,", s.Command("Cnt", (s.Number(1), None))),
        ("MXT1,0", s.Command("Mxt", (s.Number(1), s.Number(0)))),
        ("ACT1=1", s.Assign(s.Variable("ACT1"), s.Number(1))),
        ("M1=P1.x", s.Assign(s.Variable("M1"), s.Variable("P1", component="X"))),
        ("P1=P2*P3", s.Assign(s.Variable("P1"), s.Binary("*", s.Variable("P2"), s.Variable("P3")))),
        ("M1=M2-1", s.Assign(s.Variable("M1"), s.Binary("-", s.Variable("M2"), s.Number(1)))),
        ("Tool (0,0,5)", s.Command("Tool", (s.Constant((0.0, 0.0, 5.0)),))),
    ],
)
def test_what_lines_say(line: str, statement: s.Statement) -> None:
    assert read(f"10 {line}").statement == statement
    assert read(f"10  {line.upper()}  ").statement == statement or "." in line


@pytest.mark.parametrize("text", ["M1 =\t5", "M1=5 ", "\tM1=5'x", "m1=5 rem y", "M1=5.0"])
def test_blanks_comments_and_case_change_nothing(text: str) -> None:
    found = read("10 " + text).statement
    assert isinstance(found, s.Assign)
    assert (found.target.key, found.value) == ("M1", s.Number(5))


def test_code_and_variable_lines_in_one_file() -> None:
    text = (
        "10 Mov P1 'go\n"
        "20 M1=3\n"
        "P1=(+1.00,+2.00,+3.00,+180.00,+0.00,+180.00)(7,0)\n"
        "phome=(+1.00,+2.00,+3.00,+180.00,+0.00,+180.00)(7,0)\n"
        "PCAL(1)=(+1.00,+2.00,+3.00,+0.00,+0.00,+0.00)(,)\n"
        "J1=(+0.00,+10.00,+80.00,+0.00,+90.00,+0.00)\n"
        "M1=+5\n"
        "N2%=&H1F\n"
        'C1$="text"\n'
    )
    tree = FIVE.parse(text)
    assert not tree.findings
    assert FIVE.render(tree) == text
    assert [type(item) for item in tree.items] == [s.Line] * 2 + [s.Data] * 7


def test_steps_are_told_from_code() -> None:
    assert read("32767 End").number == 32767
    assert read("  5 End").number == 5
    assert read("End").number is None
    assert read("10*A").label == "A"
    assert read("10 * A : Mov P1") == s.Line(10, "A", s.Motion("Mov", (s.Variable("P1"),)))
