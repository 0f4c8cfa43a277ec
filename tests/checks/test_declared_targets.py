"""Moves to targets that are no constants: what is checked, and what is said of the others."""

from __future__ import annotations

from pathlib import Path

import pytest

from assistant.base.diagnostics import Diagnostic
from assistant.compiler import check_files

NEAR, FAR = 400, 2000
REST = "400],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"
BENT = "[[0,0,0,0,{},0],[9E9,9E9,9E9,9E9,9E9,9E9]]"


def target(x: float) -> str:
    return f"[[{x},0,{REST}"


def checked(folder: Path, *data: str, body: str, more: str = "") -> list[Diagnostic]:
    file = folder / "m.mod"
    lines = ["MODULE m", *data, "PROC main()", body, "ENDPROC", more, "ENDMODULE", ""]
    file.write_text("\n".join(lines), encoding="ascii")
    return [
        one
        for one in check_files([file], robot="irb120-3-0.58").findings
        if one.code.startswith("RB")
    ]


def codes(found: list[Diagnostic]) -> set[str]:
    return {one.code for one in found}


@pytest.mark.parametrize("word", ["CONST", "VAR", "PERS", "LOCAL PERS", "TASK PERS"])
@pytest.mark.parametrize(
    ("kind", "declaration", "move", "code"),
    [
        ("robtarget", "p1:={}", "MoveJ p1", "RB102"),
        ("robtarget", "p1:={}", "MoveL Offs(p1,0,0,50)", "RB102"),
        ("robtarget", "p1{{2}}:=[{},{}]", "MoveJ p1{{2}}", "RB102"),
        ("jointtarget", "p1:={}", "MoveAbsJ p1", "RB109"),
        ("jointtarget", "p1{{2}}:=[{},{}]", "MoveAbsJ p1{{2}}", "RB109"),
    ],
)
def test_a_target_that_nothing_changes_is_checked_by_its_declaration(
    word: str, kind: str, declaration: str, move: str, code: str, tmp_path: Path
) -> None:
    good, bad = (
        (target(NEAR), target(FAR)) if kind == "robtarget" else (BENT.format(0), BENT.format(500))
    )
    body = f"{move.format()},v100,fine,tool0;"
    for value, expected in ((bad, {code}), (good, set())):
        values = (good, value) if "{}]" in declaration else (value,)
        data = f"{word} {kind} {declaration.format(*values)};"
        assert codes(checked(tmp_path, data, body=body)) == expected


@pytest.mark.parametrize("word", ["CONST", "VAR", "PERS"])
def test_so_is_one_with_a_shift_that_nothing_changes(word: str, tmp_path: Path) -> None:
    data = f"CONST robtarget p1:={target(NEAR)};", f"{word} num far:=2000;"
    assert codes(checked(tmp_path, *data, body="MoveJ Offs(p1,far,0,0),v100,fine,tool0;")) == {
        "RB102"
    }


CHANGES = {
    "assigned": ("p1:=CRobT();", ""),
    "a component assigned": ("p1.trans.x:=1;", ""),
    "in another routine": ("teach;", "PROC teach()\np1:=CRobT();\nENDPROC"),
    "by a parameter": ("teach p1;", "PROC teach(INOUT robtarget p)\np:=CRobT();\nENDPROC"),
    "by a search": ("SearchL\\Stop,di1,p1,p0,v100,tool0;", ""),
    "by its name": ('SetDataVal "p1",p0;', ""),
    "by what is not there": ("elsewhere p1;", ""),
    "in a trap": ("", "TRAP t\np1:=CRobT();\nENDTRAP"),
}


@pytest.mark.parametrize("change", CHANGES)
@pytest.mark.parametrize("word", ["VAR", "PERS"])
def test_one_that_may_change_is_reported_as_not_checked(
    word: str, change: str, tmp_path: Path
) -> None:
    before, more = CHANGES[change]
    data = f"{word} robtarget p1:={target(FAR)};", f"CONST robtarget p0:={target(NEAR)};"
    body = f"MoveJ p0,v100,fine,tool0;\n{before}\nMoveJ p1,v100,fine,tool0;"
    found = checked(tmp_path, *data, body=body, more=more)
    (told,) = (one for one in found if one.code == "RB128")
    assert "1 of 2 moves leads" in told.message and "p1" in str(told)
    assert "RB102" not in codes(found)


def test_moves_that_are_not_checked_are_reported_once(tmp_path: Path) -> None:
    data = "VAR robtarget p1;", "VAR jointtarget j1;"
    moves = "MoveJ p1,v100,fine,tool0;\nMoveAbsJ j1,v100,fine,tool0;\n" * 20
    (told,) = checked(tmp_path, *data, body=moves)
    assert told.code == "RB128" and "40 of 40 moves lead " in told.message


@pytest.mark.parametrize("word", ["VAR", "PERS"])
def test_a_parameter_or_local_one_hides_the_declared_one(word: str, tmp_path: Path) -> None:
    data = f"{word} robtarget p1:={target(FAR)};", f"CONST robtarget p0:={target(NEAR)};"
    go = "PROC go(robtarget p1)\nMoveJ p1,v100,fine,tool0;\nENDPROC"
    assert codes(checked(tmp_path, *data, body="go p0;", more=go)) == {"RB128"}
    own = f"PROC go()\nVAR robtarget p1:={target(NEAR)};\nMoveJ p1,v100,fine,tool0;\nENDPROC"
    assert codes(checked(tmp_path, *data, body="go;", more=own)) == set()


def test_a_condition_is_not_decided_by_persistent_data(tmp_path: Path) -> None:
    data = "PERS bool on:=FALSE;", f"PERS robtarget p1:={target(FAR)};"
    body = "IF on THEN\nMoveJ p1,v100,fine,tool0;\nENDIF"
    assert codes(checked(tmp_path, *data, body=body)) == {"RB102"}
