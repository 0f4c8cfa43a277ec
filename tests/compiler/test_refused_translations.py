"""Translations that are not written: the answer tells why where it says so."""

from __future__ import annotations

from pathlib import Path

import pytest

import assistant
from assistant.compiler import Translation
from assistant.report.translation import share_in_words

TEXT = """MODULE Cell
CONST robtarget p10:=[[400,50,450],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
CONST robtarget pFar:=[[2400,50,450],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
PROC main()
MoveL p10,v200,fine,tool0;
{call}
ENDPROC
PROC rTest()
MoveL pFar,v200,fine,tool0;
ENDPROC
ENDMODULE
"""


def translated(folder: Path, call: str, far: str = "2400") -> Translation:
    file = folder / "cell.mod"
    file.write_text(TEXT.format(call=call).replace("2400", far))
    return assistant.translate(file, to="melfa-basic-6", robot="rv-4frl")


@pytest.mark.parametrize("call", ["", "rTest;"])
def test_the_reason_and_its_routine_are_in_the_first_line(tmp_path: Path, call: str) -> None:
    done = translated(tmp_path, call)
    said = share_in_words(done)
    assert not done.files
    assert "nothing is written: RB102 in `rTest`" in said
    assert ("nothing calls `rTest`" in said) is (not call)


def test_what_is_written_needs_no_reason(tmp_path: Path) -> None:
    done = translated(tmp_path, "", far="420")
    assert done.files and not done.refusal
    assert "nothing" not in share_in_words(done)
