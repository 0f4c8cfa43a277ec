"""What a program tells and asks a person, in a language without a display: messages and inputs."""

from __future__ import annotations

from pathlib import Path

import pytest

from assistant import languages
from assistant.base.source_text import SourceText
from assistant.compiler.motion_proof import Proving
from assistant.compiler.translation import Translation, translate
from assistant.virtual.melfa.code import branches

PROGRAM = r"""MODULE m
VAR num x;
PERS num r{{3}}:=[1,1,1];
CONST robtarget p1:=[[400,0,400],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
PROC main()
  x:=0;
  MoveL p1,v100,fine,tool0;
  {}
  MoveL Offs(p1,x,0,r{{2}}),v100,fine,tool0;
ENDPROC
ENDMODULE
"""
KEYS = "\n".join(
    f'[signals.operator_key_{n}]\ndirection = "input"\nnumber = {19 + n}' for n in range(1, 6)
)
CELL = (
    KEYS
    + """
[signals.operator_entered]
direction = "input"
number = 30
[signals.operator_number]
kind = "group"
direction = "input"
number = 32
bits = 4
"""
)


def translated(tmp_path: Path, statement: str, cell: str = CELL) -> Translation:
    (tmp_path / "m.mod").write_text(PROGRAM.format(statement), "latin-1")
    (tmp_path / "cell.toml").write_text(cell, "utf-8")
    how = Proving(runs=3, seconds=5.0)
    process = tmp_path / "cell.toml"
    return translate(tmp_path / "m.mod", to="melfa-basic-6", process=process, proving=how)


def lines(done: Translation) -> list[str]:
    """Statements of the written program without their numbers."""
    (text,) = done.files.values()
    return [line.partition(" ")[2].strip() for line in text.decode("utf-8").splitlines()]


QUESTIONS = {
    "keys": r'TPReadFK x,"Which?","A",stEmpty,"C",stEmpty,"";',
    "one key": r'TPReadFK x,"Go on?",stEmpty,stEmpty,stEmpty,stEmpty,"OK";',
    "a number": r'TPReadNum r{2},"How far?";',
    "a number of a range": r'x:=UINumEntry(\Header:="m"\MinValue:=1\MaxValue:=5\AsInteger);',
    "a box": r'UIMsgBox "Part in?"\MsgLine2:="Press";',
    "a box with a result": r'UIMsgBox "Again?"\Buttons:=btnYesNo\Result:=x;',
    "a box as a function": r'x:=UIMessageBox(\Message:="m"\BtnArray:=["left","right"]);',
    "places without a button": r'x:=UIMessageBox(\MsgArray:=["m"]\BtnArray:=[stEmpty,"A","","B"]);',
    "what a button is": r'UIMsgBox "?"\Buttons:=btnYesNo\Result:=x; IF x=resNo x:=20;',
}


@pytest.mark.parametrize("question", QUESTIONS.values(), ids=QUESTIONS)
def test_a_question_is_answered_by_inputs_and_both_sides_do_the_same(
    tmp_path: Path, question: str
) -> None:
    done = translated(tmp_path, question)
    assert done.ok and done.motion is not None and done.motion.holds, done.findings
    assert "RA331" in {f.code for f in done.findings}
    assert done.totals["not"] == 0
    found = done.motion.found
    assert found is not None and found.visits > 1


def test_the_key_that_is_pressed_is_the_answer(tmp_path: Path) -> None:
    said = lines(translated(tmp_path, QUESTIONS["keys"]))
    said = [line.partition(" ' operator_key")[0] for line in said]  # without the names of the keys
    wait = said.index("Wait M_In(20)=1 Or M_In(22)=1")
    assert [line.upper() for line in said[wait + 1 : wait + 6]] == [
        "IF M_IN(20)=1 THEN",
        "MX=1",
        "ELSEIF M_IN(22)=1 THEN",
        "MX=3",
        "ENDIF",
    ]
    assert "Wait M_In(20)=0 And M_In(22)=0 ' message: Which? [1: A] [3: C]" in said[:wait]


@pytest.mark.parametrize(
    ("asked", "ways"),
    [
        (("M_In(1)=1", "M_In(2)=1"), 2),
        (("M_In(1)=1", "M_In(3)=1"), 3),
        (("M_In(1)=1",), 2),
    ],
)
def test_a_key_let_go_between_two_statements_is_no_branch(
    asked: tuple[str, ...], ways: int
) -> None:
    first, *others = asked
    more = "".join(f"ElseIf {one} Then\nM1=2\n" for one in others)
    text = f"Wait M_In(1)=1 Or M_In(2)=1\nIf {first} Then\nM1=1\n{more}EndIf\nEnd\n"
    tree = languages.get("melfa-basic-6").parse(SourceText(text, "A.prg"))
    assert len(branches([tree])) == ways


@pytest.mark.parametrize(
    "statement",
    [
        r'TPReadNum x,"How many?"\MaxTime:=5;',
        r'x:=UINumEntry(\Message:="m"\MaxTime:=5\BreakFlag:=x);',
        r'TPReadFK x,"Which?","A"\DIBreak:=di1,stEmpty,stEmpty,stEmpty,stEmpty;',
    ],
)
def test_a_question_that_ends_by_itself_is_not_said(tmp_path: Path, statement: str) -> None:
    done = translated(tmp_path, statement)
    assert not done.ok and not done.files


def test_without_inputs_no_question_is_said(tmp_path: Path) -> None:
    done = translated(tmp_path, QUESTIONS["a number"], KEYS)
    assert not done.files
    (row,) = (one for one in done.rows if one.text.startswith("TPReadNum"))
    assert row.level == "not"
    missing = {f.missing for f in row.reasons if f.code == "MB201"}
    assert missing == {"operator_entered", "operator_number"}


MESSAGES = {
    r'TPWrite "is "\Bool:=TRUE;': ("MB211", "' message: is ..."),
    r'TPWrite "at "\Pos:=p1.trans;': ("MB211", "' message: at ..."),
    r'ErrWrite\W,"Head","why"\RL2:="more";': ("MB211", "' message: Head; why; more"),
    r"Stop\NoRegain;": ("RA306", "Hlt"),
    "Break;": ("RA306", "Hlt"),
}


@pytest.mark.parametrize("statement", MESSAGES)
def test_what_only_tells_people_is_partly_said(tmp_path: Path, statement: str) -> None:
    done = translated(tmp_path, statement)
    code, line = MESSAGES[statement]
    assert done.ok and done.motion is not None and done.motion.holds, done.findings
    assert code in {f.code for f in done.findings} and line in lines(done)
