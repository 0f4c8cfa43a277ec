"""What controllers may work out differently is told of, unless a project says how they do."""

from __future__ import annotations

from pathlib import Path

import pytest

from assistant import translate

MELFA = "1 Dim MA(9)\n{}\n9 End\n"
RAPID = "MODULE m\nVAR num a;\nVAR num b;\nPROC main()\n{}\nENDPROC\nENDMODULE\n"


def said(folder: Path, name: str, text: str, to: str) -> tuple[str, list[str]]:
    file = folder / name
    file.write_text(text, encoding="utf-8")
    made = translate(file, to=to, language="melfa-basic-5" if name.endswith("prg") else None)
    written = "".join(data.decode() for data in made.files.values())
    return written, [f.code for f in made.findings if f.code.startswith("CO")]


@pytest.mark.parametrize(
    ("line", "wanted", "codes"),
    [
        ("2 M2=M1\\2", "M2:=Round(M1) DIV 2;", ["CO105", "CO105"]),
        ("2 M2=M1 Mod M_Inb(8)", "M2:=Round(M1) MOD gi_8_8;", ["CO105", "CO105"]),
        ("2 M1=MA(M2)", "M1:=MA{Round(M2)};", ["CO105"]),
        ("2 M1=0.5\n3 M2=MA(M1)", "M2:=MA{Round(M1)};", ["CO105"]),
        ("2 For M1=1 To 9\n3 M2=MA(M1)\n4 Next", "M2:=MA{M1};", []),
        ("2 M1%=M_DIn(6000)\n3 M2=MA(M1%)", "M2:=MA{M1};", ["CO105"]),
        ("2 M2=M_Inb(8)\\2", "M2:=gi_8_8 DIV 2;", []),
        ("2 M1=4\n3 M2=MA(M1-2) Mod 3", "M2:=Round(MA{M1-2}) MOD 3;", ["CO105", "CO105"]),
        ("2 M2=7.6\\2", "M2:=Round(7.6) DIV 2;", ["CO105"]),
    ],
)
def test_operands_and_subscripts_are_rounded_unless_they_are_whole(
    tmp_path: Path, line: str, wanted: str, codes: list[str]
) -> None:
    written, found = said(tmp_path, "a.prg", MELFA.format(line), "rapid")
    assert wanted in written
    assert found == codes


def test_a_remainder_below_0_is_told_of_in_either_direction(tmp_path: Path) -> None:
    assert said(tmp_path, "m.mod", RAPID.format("a:=-7;b:=a MOD 4;"), "melfa-basic-5")[1] == [
        "CO105"
    ]
    assert said(tmp_path, "m.mod", RAPID.format("a:=7;b:=a MOD 4;"), "melfa-basic-5")[1] == []


@pytest.mark.parametrize(
    ("value", "codes"), [("M_Inb(8)", []), ("Abs(M3)", []), ("M3", ["MB250"]), ("-1", ["MB250"])]
)
def test_bits_are_those_of_numbers_that_are_not_below_0(
    tmp_path: Path, value: str, codes: list[str]
) -> None:
    file = tmp_path / "a.prg"
    file.write_text(MELFA.format(f"2 M3=M_Inb(24)-1\n3 M1=(4 Or {value}) And 7"), encoding="utf-8")
    found = translate(file, to="rapid", language="melfa-basic-5").findings
    assert [f.code for f in found if f.code == "MB250"] == codes


def test_a_project_says_how_its_controllers_do_it(tmp_path: Path) -> None:
    settings = tmp_path / "assistant.toml"
    text = MELFA.format("2 M2=M_DIn(6000)\n3 M1=MA(M2)")
    settings.write_text('[rapid]\nhalves = "even"\n[melfa-basic]\nhalves = "even"\n')
    assert said(tmp_path, "a.prg", text, "rapid")[1] == []
    settings.write_text('[rapid]\nhalves = "even"\n[melfa-basic]\nhalves = "away"\n')
    assert said(tmp_path, "a.prg", text, "rapid") == ("", ["CO106"])
    settings.write_text('[melfa-basic]\nhalves = "up"\n')
    assert said(tmp_path, "a.prg", text, "rapid") == ("", ["CO106"])


@pytest.mark.parametrize(
    ("lines", "codes"),
    [
        ("FOR i FROM 0 TO 1 STEP 0.1 DO b:=b+1;ENDFOR", ["CO117"]),
        ("FOR i FROM 3 TO a STEP -0.3 DO b:=b+1;ENDFOR", ["CO117"]),
        ("FOR i FROM 0 TO 1 STEP 0.25 DO b:=b+1;ENDFOR", []),
        ("FOR i FROM 0 TO 1.05 STEP 0.1 DO b:=b+1;ENDFOR", []),
        ("FOR i FROM 1 TO 7 STEP 2 DO b:=b+1;ENDFOR", []),
        ("FOR i FROM 0 TO 1000000000 STEP 0.1 DO b:=b+1;ENDFOR", ["CO117"]),
        ("FOR i FROM 0 TO 1E308 STEP 0.1 DO b:=b+1;ENDFOR", []),
        ("WHILE a<1 DO a:=a+0.1;ENDWHILE", ["CO117"]),
        ("WHILE a<1.05 DO a:=a+0.1;ENDWHILE", []),
        ("WHILE 2>=a DO a:=a+0.5;ENDWHILE", []),
        ("a:=a-0.2;IF a=-1 b:=3;", ["CO117"]),
        ("c{2}:=c{2}+0.1;IF c{2}=1 b:=3;", ["CO117"]),
        ("c{2}:=c{2}+0.1;IF c{1}=1 b:=3;", []),
        ("b:=0.1;WHILE a<1 DO a:=a+b;ENDWHILE", ["CO117"]),
        ("b:=0.1;WHILE a<1.05 DO a:=a+b;ENDWHILE", []),
        ("b:=0.5;WHILE a<1 DO a:=a+b;ENDWHILE", []),
        ("b:=1/10;WHILE a<1 DO a:=b+a;ENDWHILE", ["CO117"]),
        ("b:=0.1;WHILE a<1 DO a:=a+2*b;ENDWHILE", ["CO117"]),
        ("b:=0.3;FOR i FROM 3 TO 0 STEP -b DO a:=1;ENDFOR", ["CO117"]),
        ("b:=0.3;FOR i FROM 3 TO 0.2 STEP -b DO a:=1;ENDFOR", []),
        ("b:=3;b:=b*5;WHILE a<90 DO a:=a+b*pi/180;ENDWHILE", []),
        ("b:=5;WHILE a<pi/4 DO a:=a+b*pi/180;ENDWHILE", ["CO117"]),
        ("a:=0.05;WHILE a<1.05 DO a:=a+0.1;ENDWHILE", ["CO117"]),
        ("a:=0.05;WHILE a<1 DO a:=a+0.1;ENDWHILE", []),
        ("b:=1;WHILE a<b DO a:=a+0.1;ENDWHILE", ["CO117"]),
        ("q.trans.x:=0;WHILE q.trans.x<1 DO q.trans.x:=q.trans.x+0.1;ENDWHILE", ["CO117"]),
    ],
)
def test_a_bound_that_inexact_steps_meet_is_reported(
    tmp_path: Path, lines: str, codes: list[str]
) -> None:
    text = RAPID.format(lines).replace("PROC main", "VAR num c{2};\nPROC main")
    assert said(tmp_path, "m.mod", text, "melfa-basic-5")[1] == codes


@pytest.mark.parametrize(
    ("asked", "codes"),
    [
        ("M1<Rad(45)", ["CO117"]),
        ("Deg(M1)<45", ["CO117"]),
        ("45>Deg(M1)", ["CO117"]),
        ("Deg(M1)<47", []),
        ("M1<M2", ["CO117"]),
        ("Deg(M1)<M3", ["CO117"]),
    ],
)
def test_steps_of_angles_are_inexact(tmp_path: Path, asked: str, codes: list[str]) -> None:
    lines = f"2 M1=0\n3 M2=Rad(45)\n4 M3=45\n5 While {asked}\n6 M1=M1+Rad(5)\n7 WEnd"
    assert said(tmp_path, "a.prg", MELFA.format(lines), "rapid")[1] == codes


ANGLES_OF_MELFA = """1 Dim MA(9)
2 P2=P_Curr
3 {}
8 Mvs P1
9 End
P1=(+400.00,+0.00,+400.00,+180.00,+0.00,+90.00)(7,0)
"""


@pytest.mark.parametrize(
    ("line", "codes"),
    [
        ("M1=Int(Deg(Atn(1)))", ["CO127"]),
        ("M1=Fix(Deg(P1.C))", ["CO127"]),
        ("M2=Deg(P1.C)\n4 M3=M2+1\n5 M1=Int(M3)", ["CO127"]),
        ("M5=Rad(30)\n4 M1=Int(2*Sin(M5))", ["CO127"]),
        ("If Deg(P1.C)=90 Then M1=3", ["CO127"]),
        ("If P2.C<>P1.C Then M1=3", ["CO127"]),
        ("M1=0.5236\n4 If M1=Rad(30) Then M2=3", ["CO127"]),
        ("M1=Rad(30)\n4 If M1=Rad(30) Then M2=3", []),
        ("M1=Rad(30)\n4 If M1=0 Then M2=3", []),
        ("Select Deg(P1.C)\n4 Case 90\n5 M1=1\n6 Break\n7 End Select", ["CO127"]),
        ("For M1=1 To Deg(P1.C)/30\n4 M2=M2+1\n5 Next", ["CO127"]),
        ("Wait Deg(P2.C)=90", ["CO127"]),
        ("M1=Int(P1.X)", []),
        ("M1=Int(M2)\n4 M2=Rad(10)\n5 P1.C=M2", []),
        ("P1.C=Rad(10)\n4 M1=Int(P1.X)", []),
        ("P1.X=10*Cos(Rad(30))\n4 M1=Int(P1.X)", ["CO127"]),
    ],
)
def test_converted_angles_at_an_edge_are_reported(
    tmp_path: Path, line: str, codes: list[str]
) -> None:
    found = said(tmp_path, "a.prg", ANGLES_OF_MELFA.format(line), "rapid")[1]
    assert [code for code in found if code == "CO127"] == codes


@pytest.mark.parametrize(
    ("lines", "codes"),
    [
        ("b:=Trunc(ATan(1));", ["CO127"]),
        ("a:=ATan(1);b:=a DIV 45;", ["CO127"]),
        ("a:=ATan(1);b:=a MOD 45;", ["CO127"]),
        ("a:=ATan(1);IF a=45 b:=2;", ["CO127"]),
        ("a:=EulerZYX(\\Z,q.rot);TEST a CASE 180: b:=4;DEFAULT: b:=5;ENDTEST", ["CO127"]),
        ("a:=Sin(b);WaitUntil a=1;", ["CO127"]),
        ("a:=half(10);b:=Trunc(a);", ["CO127"]),
        ("a:=5;IF a=5 b:=1;", []),
        ("a:=ATan(1);IF a>40 b:=1;", []),
        ("a:=Trunc(b);IF a=45 a:=ATan(b);", ["CO127"]),
        ("b:=3;IF b=3 a:=ATan(b);", []),
    ],
)
def test_angles_of_functions_at_an_edge_are_reported(
    tmp_path: Path, lines: str, codes: list[str]
) -> None:
    pose = "[[400,0,400],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"
    text = RAPID.format(lines).replace(
        "PROC main",
        f"CONST robtarget q:={pose};\nFUNC num half(num x)\nRETURN Sin(x)/2;\nENDFUNC\nPROC main",
    )
    found = said(tmp_path, "m.mod", text, "melfa-basic-6")[1]
    assert [code for code in found if code == "CO127"] == codes
