"""What other languages need not be told of a MELFA-BASIC program, and what may not be left out."""

from __future__ import annotations

from pathlib import Path

import pytest

from assistant.compiler.motion_proof import Proving
from assistant.compiler.translation import Translation, translate

PLACES = "P1=(400,0,400,180,0,180)(7,0)\nP2=(400,100,300,180,0,180)(7,0)\n"


def translated(body: str, tmp_path: Path, to: str = "rapid") -> Translation:
    source = tmp_path / "JOB.prg"
    source.write_text(f"Mvs P1\n{body}\nMvs P2\nEnd\n{PLACES}", encoding="utf-8")
    return translate(source, to=to, language="melfa-basic-5", proving=Proving(seconds=1))


@pytest.mark.parametrize(
    "statement",
    [
        "Servo On", "LoadSet 1,1", "Oadl On", "Fine 100", "Fine 0.5,P", "Prec On",
        "MvTune 2", "SpdOpt On", "ColChk On", "ColChk Off", "ColLvl 100,100", "CavChk Off",
        "Cmp Off",
    ],
)  # fmt: skip
def test_what_only_tunes_is_told_and_left_out(statement: str, tmp_path: Path) -> None:
    found = translated(statement, tmp_path)
    assert found.ok, found.findings
    assert found.motion is not None
    assert found.motion.holds
    (row,) = [row for row in found.rows if row.text == statement]
    assert row.level == "partial"
    assert [reason.code for reason in row.reasons] == ["MB254"]


def test_motors_that_are_switched_off_and_on(tmp_path: Path) -> None:
    found = translated("Servo Off\nDly 1\nServo On", tmp_path)
    assert found.ok, found.findings
    assert sum(finding.code == "MB254" for finding in found.findings) == 2


def test_the_number_of_an_error_is_shown_before_the_program_ends(tmp_path: Path) -> None:
    found = translated("If M_In(3)=0 Then Error 9101", tmp_path)
    assert found.motion is not None and found.motion.holds
    text = b"".join(found.files.values()).decode()
    lines = [line.strip() for line in text.splitlines()]
    assert lines[lines.index("EXIT;") - 1] == 'TPWrite "error 9101";'


@pytest.mark.parametrize(
    "body",
    [
        "Cmp Pos,&B011\nMvs P2\nCmp Off", "If M_In(3)=1 Then Cmp Tool,&B1\nCmp Off",
        "Fsc On,0,0,1\nMvs P2\nFsc Off", "Torq 2,50", "JRC +1,6",
    ],
)  # fmt: skip
def test_what_makes_the_arm_soft_is_not_left_out(body: str, tmp_path: Path) -> None:
    found = translated(body, tmp_path)
    assert not found.ok
    assert not found.files
    assert found.totals["not"] == body.count("\n") + 1 - body.count("Mvs")


def test_an_if_of_one_line_stays_where_its_command_goes(tmp_path: Path) -> None:
    found = translated("If M_In(3)=1 Then Servo On Else M_Out(4)=1", tmp_path)
    assert found.ok, found.findings
    assert found.motion is not None
    assert found.motion.holds


def test_the_language_itself_keeps_all(tmp_path: Path) -> None:
    found = translated("Servo On\nFine 100", tmp_path, "melfa-basic-6")
    (text,) = (data.decode() for data in found.files.values())
    assert "Servo On" in text
    assert "Fine 100" in text
