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
        ("WHILE a<1 DO a:=a+0.1;ENDWHILE", ["CO117"]),
        ("WHILE a<1.05 DO a:=a+0.1;ENDWHILE", []),
        ("WHILE 2>=a DO a:=a+0.5;ENDWHILE", []),
        ("a:=a-0.2;IF a=-1 b:=3;", ["CO117"]),
    ],
)
def test_a_bound_that_inexact_steps_meet_is_reported(
    tmp_path: Path, lines: str, codes: list[str]
) -> None:
    assert said(tmp_path, "m.mod", RAPID.format(lines), "melfa-basic-5")[1] == codes


@pytest.mark.parametrize(
    ("asked", "codes"),
    [
        ("M1<Rad(45)", ["CO117"]),
        ("Deg(M1)<45", ["CO117"]),
        ("45>Deg(M1)", ["CO117"]),
        ("Deg(M1)<47", []),
    ],
)
def test_steps_of_angles_are_inexact(tmp_path: Path, asked: str, codes: list[str]) -> None:
    lines = f"2 M1=0\n3 While {asked}\n4 M1=M1+Rad(5)\n5 WEnd"
    assert said(tmp_path, "a.prg", MELFA.format(lines), "rapid")[1] == codes
