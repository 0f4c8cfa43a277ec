"""Comments of every module and every called program are in what is written."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import pytest

import assistant
from assistant.cli import main

RAPID = {
    "cell.mod": """! above the first module 1
MODULE cell
  ! head of the first 2
  CONST num nMost:=4; ! behind data 3
  ! above main 4
  PROC main()
    ! in main 5
    Pick; ! behind a call 6
    ! last of main 7
  ENDPROC
  ! behind main 8
ENDMODULE
! below the first module 9
""",
    "pick.mod": """! above the second module 10
! guard 3 must be closed 11

MODULE pick
  ! head of the second 12
  ! and its next line 13
  VAR num n:=0;
  ! above a routine 14
  PROC Pick()
    ! inside 15
    n:=n+nMost; ! behind a statement 16
  ENDPROC
  ! between routines 17
  PROC Other()
    IF n>2 THEN
      ! in a branch 18
      n:=0;
    ENDIF
  ENDPROC
  ! at the end 19
ENDMODULE
! below the second module 20
""",
}
PLACE = "P1=(+340.00,+10.00,+310.00,+180.00,+0.00,+180.00)(7,0)\n"
MELFA = {
    "CELL.mb5": "1 ' head of the first 1\n2 ' guard 3 must be closed 2\n3 Tool P_NTool\n"
    "4 Base P_NBase\n5 Spd 100 ' behind a setting 3\n6 Cnt 0\n7 ' above a call 4\n"
    "8 CallP \"PICK\" ' behind a call 5\n9 GoSub *S\n10 End ' behind the end 6\n11 ' between 7\n"
    "12 *S ' behind a label 8\n13 M_Out(3)=1\n14 Return ' behind a return 9\n" + PLACE,
    "PICK.mb5": "1 ' head of the second 10\n2 ' nobody inside 11\n3 Tool P_NTool\n4 Base P_NBase\n"
    "5 Spd 80\n6 Cnt 0\n7 ' inside 12\n8 Mvs P1 ' behind a move 13\n9 End ' behind its end 14\n"
    + PLACE,
}  # fmt: skip


@pytest.mark.parametrize(
    ("files", "to"), [(RAPID, "melfa-basic-6"), (RAPID, "melfa-basic-4"), (MELFA, "rapid")]
)
def test_no_comment_is_lost(files: dict[str, str], to: str, tmp_path: Path) -> None:
    for name, text in files.items():
        (tmp_path / "in").mkdir(exist_ok=True)
        (tmp_path / "in" / name).write_text(text, encoding="ascii")
    with pytest.raises(SystemExit) as ended:
        main(["translate", str(tmp_path / "in"), "--to", to, "-o", str(tmp_path / "out")])
    assert ended.value.code == 0
    written = "\n".join(
        file.read_text("utf-8") for file in (tmp_path / "out").iterdir() if file.is_file()
    )
    mark = "!" if to == "rapid" else "'"
    comments = " ".join(re.findall(rf"{mark}.*", written)).lower()
    said = re.findall(r"[!'] *([a-z].*? \d+)$", "\n".join(files.values()), re.MULTILINE)
    assert len(said) == len({text.split()[-1] for text in said}) >= 14
    assert [text for text in said if text not in comments] == []


BESIDE = """\
MODULE part
  VAR num n:=0;
  PROC main()
    IF n=1 n:=2; ! short
    IF n=1 THEN ! if
      n:=3; ! then
    ELSE ! else
      n:=4; ! otherwise
    ENDIF ! end of if
    IF n=1 GOTO over; ! jump
    IF n=1 Sub; ! call
    WHILE n=5 DO ! while
      WHILE n=6 DO
        IF n=1 RETURN; ! back
      ENDWHILE
    ENDWHILE ! end of while
    over: ! label
    TEST n
    CASE 1: ! case
      WHILE n=7 DO ! inner
        n:=8;
      ENDWHILE
    ENDTEST ! end of test
  ENDPROC
  PROC Sub()
    FOR i FROM 1 TO 2 DO ! for
      n:=n+i; ! sum
    ENDFOR ! end of for
  ENDPROC
ENDMODULE
"""


@pytest.mark.parametrize("language", ["melfa-basic-4", "melfa-basic-5", "melfa-basic-6"])
def test_comments_beside_blocks_stay_with_them(tmp_path: Path, language: str) -> None:
    file = tmp_path / "part.mod"
    file.write_text(BESIDE, encoding="utf-8")
    done = assistant.translate(file, to=language)
    assert done.ok, done.findings
    (text,) = (data.decode().replace("\r\n", "\n") for data in done.files.values())
    for comment in re.findall("! (.*)", BESIDE):
        assert text.count(f"' {comment}\n") == 1


def test_a_comment_beside_a_choice_is_not_that_of_a_loop_in_it() -> None:
    """Version 4 has no word for the choice itself, so that a loop may have the first such word."""
    language = assistant.languages.get("melfa-basic-4")
    text = "10 IF M_IN(7)=0 THEN M_OUT(5)=1 ELSE M_OUTB(16)=M10 ' beside\n20 END\n"
    program = replace(language.lift(language.parse(text)), origin=None)
    made = assistant.compile(program, language=language.name)
    assert made.ok, made.findings
    (written,) = (data.decode().replace("\r\n", "\n") for data in made.files.values())
    assert re.search(r"^\d+ ' beside\n\d+ IF M_IN\(7\)=0 ", written, re.MULTILINE)
