"""`show`: a program on its way into a language, pass after pass."""

from __future__ import annotations

import pytest

from tests.cli.test_commands import run

MODULE = """MODULE Cell
 CONST robtarget p10:=[[350,0,400],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
 PROC main()
  FOR i FROM 1 TO 3 DO
   MoveL Offs(p10,10*i,0,0),v100,fine,tool0;
  ENDFOR
  done 7;
 ENDPROC
 PROC done(num count)
  TPWrite "done"\\Num:=count;
 ENDPROC
ENDMODULE
"""


@pytest.fixture
def module(tmp_path):
    file = tmp_path / "cell.mod"
    file.write_text(MODULE)
    return file


def test_a_program_as_a_language_will_say_it(capsys, module):
    status, plain, _ = run(capsys, "show", module)
    assert status == 0 and "call done(7)" in plain and "offset(p10, 10 * i, 0, 0)" in plain
    status, said, _ = run(capsys, "show", module, "--to", "melfa-basic-5")
    assert status == 0 and "call done\n" in said and "offset(" not in said


def test_a_program_after_each_pass(capsys, module):
    to = ("--to", "melfa-basic-5", "--after")
    _, before, _ = run(capsys, "show", module, *to, "without-recursion")
    _, parameters, _ = run(capsys, "show", module, *to, "with-sayable-procedures")
    _, targets, _ = run(capsys, "show", module, *to, "with-computed-targets")
    assert "call done(7)" in before and "offset(p10" in before
    assert "call done\n" in parameters and "offset(p10" in parameters
    assert "call done\n" in targets and "offset(p10" not in targets


def test_a_pass_that_is_not_there_is_told_with_those_that_are(capsys, module):
    status, out, err = run(capsys, "show", module, "--to", "rapid", "--after", "with-nothing")
    assert (status, out) == (2, "") and "CL012" in err and "`counted-loops`" in err
    status, out, err = run(capsys, "show", module, "--after", "split")
    assert (status, out) == (2, "") and "CL013" in err and "--to" in err


def test_what_the_pseudo_text_cannot_say_is_told_at_its_line(capsys, tmp_path):
    file = tmp_path / "deep.mb5"
    lines = ["Mov P1", *["If M1=1 Then"] * 60, "Hlt", *["EndIf"] * 60, "End"]
    file.write_text("\n".join(lines))
    status, _, err = run(capsys, "show", file)
    assert status == 1 and f"PS105 error {file}:52:1: the block" in err
