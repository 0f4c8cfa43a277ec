"""Translation with no arm named: nothing checks reach, limits and configurations."""

from __future__ import annotations

from pathlib import Path

import pytest

import assistant
from assistant.cli import main
from assistant.compiler import Translation

POSE = "[[400,50,450],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"
IN_RAPID = f"""MODULE Cell
CONST robtarget p10:={POSE};
PROC main()
MoveL p10,v200,fine,tool0;
MoveL Offs(p10,0,0,50),v200,fine,tool0;
ENDPROC
ENDMODULE
"""
IN_MELFA = "10 Spd 50\n20 Mvs P1\n30 End\nP1=(+400.00,+50.00,+450.00,+180.00,+0.00,+180.00)(7,0)\n"
STILL = "MODULE Cell\nPROC main()\nWaitTime 1;\nENDPROC\nENDMODULE\n"


def translated(folder: Path, name: str, text: str, to: str, **options: str) -> Translation:
    file = folder / name
    file.write_text(text)
    return assistant.translate(file, to=to, **options)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("name", "text", "to", "moves"),
    [
        ("a.mod", IN_RAPID, "melfa-basic-6", "the 2 moves are"),
        ("a.prg", IN_MELFA, "rapid", "the 1 move is"),
    ],
)
def test_it_is_reported_in_every_language(
    tmp_path: Path, name: str, text: str, to: str, moves: str
) -> None:
    done = translated(tmp_path, name, text, to)
    (finding,) = (one for one in done.whole if one.code == "CO017")
    assert done.armless and moves in finding.message and "--robot" in finding.cure


def test_a_named_arm_or_no_move_to_a_pose_needs_none(tmp_path: Path) -> None:
    assert not translated(tmp_path, "a.mod", IN_RAPID, "melfa-basic-6", robot="rv-4frl").armless
    assert not translated(tmp_path, "a.mod", STILL, "melfa-basic-6").armless
    # A sister dialect runs on the same arms and keeps the targets.
    assert not translated(tmp_path, "a.prg", IN_MELFA, "melfa-basic-5").armless


def test_the_first_lines_of_the_answer_tell(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "a.mod"
    file.write_text(IN_RAPID)
    with pytest.raises(SystemExit) as ended:
        main(["translate", str(file), "--to", "melfa-basic-6", "-o", str(tmp_path / "out")])
    first, second, *_ = capsys.readouterr().out.splitlines()
    assert not ended.value.code
    assert "100 % translated" in first and "reach, limits and configurations" in first
    assert "--robot NAME" in second
