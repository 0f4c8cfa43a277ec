"""Data that cannot be used: frames without a place, numbers that no controller holds."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from assistant import languages
from assistant.base.diagnostics import Refused
from assistant.compiler import compile, translate
from assistant.languages.language_types import Frames

PLACE = "[[500,0,500],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"
PARTS = "[[0,0,100],[1,0,0,0]],[[0,0,0],[1,0,0,0]]"
FRAMES = {
    "undeclared": "",
    "held by the robot": f'PERS wobjdata w:=[TRUE,TRUE,"",{PARTS}];',
    "moved by a unit": f'PERS wobjdata w:=[FALSE,FALSE,"STN1",{PARTS}];',
    "without a value": "VAR wobjdata w;",
    "a number": "PERS num w:=3;",
}
MOVES = {
    "a move": f"MoveL {PLACE},v100,fine,tool0\\WObj:=w;",
    "an arc": f"MoveL p,v100,fine,tool0\\WObj:=w;\nMoveC p,{PLACE},v100,z10,tool0\\WObj:=w;",
    "many moves": "\n".join(["MoveL p,v100,z10,tool0\\WObj:=w;"] * 9),
}
"""Frames that a target cannot be multiplied by, and what uses them."""


@pytest.mark.parametrize("frames", ["product"])
@pytest.mark.parametrize("moves", MOVES.values(), ids=MOVES)
@pytest.mark.parametrize("declared", FRAMES.values(), ids=FRAMES)
def test_a_frame_that_cannot_be_used_is_told_of(
    tmp_path: Path, declared: str, moves: str, frames: Frames
) -> None:
    body = f"CONST robtarget p:={PLACE};\nPROC main()\n{moves}\nENDPROC\n"
    file = tmp_path / "cell.mod"
    file.write_text(f"MODULE m\n{declared}\n{body}ENDMODULE\n", encoding="utf-8")
    found = translate(file, to="melfa-basic-6", frames=frames)
    assert not found.ok
    assert not found.files
    moved = [row for row in found.rows if row.text.startswith("Move")]
    assert {row.level for row in moved} == {"not"}
    drafted = translate(file, to="melfa-basic-6", frames=frames, draft=True)
    assert drafted.draft
    text = b"".join(drafted.files.values()).decode("ascii")
    assert not re.search(r"^\d+ (Mov|Mvs|Mvr)", text, re.MULTILINE)


LARGE = {
    "too many digits": "1" + "0" * 400,
    "digits that Python does not convert": "9" * 5000,
    "an exponent": "1e400",
}


@pytest.mark.parametrize("line", ["if a > {}\nend", "a = {}", "wait {} s", "message {}"])
@pytest.mark.parametrize("number", LARGE.values(), ids=LARGE)
def test_a_number_beyond_any_float_is_refused_in_a_pseudo_program(
    tmp_path: Path, number: str, line: str
) -> None:
    file = tmp_path / "a.pseudo"
    text = f"program a\nvariable a number\nprocedure main\n{line.format(number)}\nend\n"
    file.write_text(text, encoding="utf-8")
    for language in languages.names():
        with pytest.raises(Refused) as refused:
            compile(file, language=language)
        (finding,) = refused.value.findings
        assert (finding.code, finding.line) == ("PS301", 4)


@pytest.mark.parametrize("number", ["1e400", "0x" + "F" * 400, "0d" + "9" * 5000])
@pytest.mark.parametrize(
    "line",
    [
        "VAR num n:={};",
        "VAR num n{{{}}};",
        "CONST num n:=-{};",
        "PROC main()\nWaitTime {};\nENDPROC",
        "PROC main()\nFOR i FROM 1 TO {} DO\nWaitTime i;\nENDFOR\nENDPROC",
        f"CONST robtarget p:={PLACE.replace('500', '{}', 1)};",
    ],
)
def test_a_number_beyond_any_dnum_is_told_of_in_rapid(
    tmp_path: Path, number: str, line: str
) -> None:
    file = tmp_path / "a.mod"
    file.write_text(f"MODULE m\n{line.format(number)}\nENDMODULE\n", encoding="utf-8")
    rapid = languages.get("rapid")
    tree = rapid.parse(file.read_text(encoding="utf-8"))
    found = [f for f in rapid.check([tree]) if f.code == "RA230"]
    assert [f.line for f in found] == [2 + ("\n" in line)]
    assert rapid.render(tree) == file.read_text(encoding="utf-8")
    assert rapid.parse(rapid.format(tree)) == tree
    for to in ("melfa-basic-5", "rapid"):
        translate(file, to=to)


@pytest.mark.parametrize(
    ("line", "level"),
    [
        ("M1=&H" + "F" * 400, 5),
        ("M1=&B" + "1" * 2000, 6),
        ("P1=(1,2,3,4,5,6)(7," + "1" * 30 + ")", 5),
        ("P1=(1,2,3,4,5,6)(7,9999999999)", 4),
    ],
)
def test_a_number_that_no_variable_holds_is_told_of_in_melfa_basic(line: str, level: int) -> None:
    language = languages.get(f"melfa-basic-{level}")
    for text in (f"10 {line}\r\n20 END\r\n", *([line + "\r\n"] * line.startswith("P"))):
        tree = language.parse(text)
        assert ["a number is too large" in f.message for f in tree.findings] == [True]
        language.lift(tree)


def test_flags_of_a_table_are_no_larger_than_those_of_a_line() -> None:
    language = languages.get("melfa-basic-5")
    rows = [f"P{n}=(+1.00,+2.00,+3.00,+4.00,+5.00,+6.00)(7,{{}})\n" for n in range(1, 40)]
    tree = language.parse("1 End\n" + "".join(rows).format(*[0] * 30, 4294967296, *[0] * 8))
    assert [(f.line, "too large" in f.message) for f in tree.findings] == [(32, True)]
    assert not language.parse("1 End\n" + "".join(rows).format(*[4294967295] * 39)).findings


@pytest.mark.parametrize("places", ["1e400", "9" * 30, "1e9"])
def test_more_decimals_than_a_number_has_take_no_time(tmp_path: Path, places: str) -> None:
    file = tmp_path / "a.mod"
    body = f"VAR num n;\nVAR string t;\nPROC main()\nt:=NumToStr(n,{places});\nENDPROC"
    file.write_text(f"MODULE m\n{body}\nENDMODULE\n", encoding="utf-8")
    rows = translate(file, to="melfa-basic-6").rows
    (row,) = [row for row in rows if "NumToStr" in row.text]
    assert "MB231" in [f.code for f in row.reasons]
