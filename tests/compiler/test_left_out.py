"""What other languages need not be told of a RAPID program, and what may not be left out."""

from __future__ import annotations

from pathlib import Path

import pytest

from assistant import languages, translate
from assistant.compiler.translation import Translation
from tests.compiler.test_places_read import HEAD

ARM = "rv-4frl"


def translated(body: str, tmp_path: Path, robot: str | None = None) -> Translation:
    source = tmp_path / "cell.mod"
    text = HEAD.replace("p20:=[[50", "p20:=[[350").replace("tB:", "tC:")
    source.write_text(f"{text}PROC main()\n{body}\nENDPROC\nENDMODULE\n", encoding="utf-8")
    return translate(source, to="melfa-basic-5", robot=robot)


MOVE = "MoveL p10,v100,fine,tG;"


@pytest.mark.parametrize(
    ("statement", "level"),
    [
        ("ConfJ\\On", "supported"),
        ("ConfL\\On", "supported"),
        ("SingArea\\Off", "supported"),
        ("GripLoad load0", "supported"),
        ("CornerPathWarning FALSE", "supported"),
        ("WaitRob\\InPos", "supported"),
        ("WaitRob\\ZeroSpeed", "supported"),
        ("WaitTime\\InPos,1", "supported"),
        ("MoveL p10,v100,fine\\Inpos:=inpos50,tG", "partial"),
        ("TPErase", "partial"),
        ("ConfL\\Off", "partial"),
        ("ConfJ\\Off", "partial"),
        ("SingArea\\Wrist", "partial"),
        ("SingArea\\LockAxis4", "partial"),
        ("SoftAct 3,50", "partial"),
        ("PathAccLim FALSE,FALSE", "partial"),
        ("WZBoxDef\\Inside,shape,low,high", "partial"),
        ("WZLimSup\\Stat,zone,shape", "partial"),
        ("WZDOSet\\Stat,zone\\Inside,shape,doIn,1", "not"),
        ("MoveL p10,v100,fine\\Inpos:=stoptime1_0,tG", "not"),
    ],
)
def test_an_instruction_has_a_level(statement: str, level: str, tmp_path: Path) -> None:
    found = translated(f"{MOVE}\n{statement};\n{MOVE}", tmp_path)
    assert {row.text: row.level for row in found.rows}[statement] == level
    assert found.ok is (level != "not")


CORNER = "MoveL p10,v100,z10,tG;"
IN_CORNER = {
    "one of two ways": f"{CORNER}\nIF n=0 WaitRob\\InPos;\nMoveL p20,v100,fine,tG;",
    "a turn of a loop": f"WHILE n<3 DO\nIF n=2 THEN\nWaitTime\\InPos,1;\nENDIF\nIncr n;\n{CORNER}\n"
    "ENDWHILE",
    "a routine": f"{CORNER}\nthere;\n{MOVE}\nthere;\nENDPROC\nPROC there()\nIF n=1 RETURN;\n"
    "WaitRob\\ZeroSpeed;",
}


@pytest.mark.parametrize("body", IN_CORNER.values(), ids=IN_CORNER.keys())
def test_a_move_stops_on_all_ways_where_the_program_waits_on_one(body: str, tmp_path: Path) -> None:
    found = translated(body, tmp_path)
    assert found.ok, found.findings
    assert "RA385" in [f.code for f in found.findings]
    assert b"Cnt 1" not in b"".join(found.files.values())


def test_a_wait_after_a_move_that_is_not_translated_costs_nothing_more(tmp_path: Path) -> None:
    """It is no statement that lacks an equivalent, and a draft tells what the move has to do."""
    found = translated("MoveL p10,v100\\T:=5,z10,tG;\nWaitRob\\InPos;", tmp_path)
    assert [f.code for f in found.findings].count("MB209") == 1
    assert not found.files
    (wait,) = (row for row in found.rows if row.text == "WaitRob\\InPos")
    assert (wait.level, [f.code for f in wait.reasons]) == ("partial", ["RA397"])
    known = translated(f"{CORNER}\nWaitRob\\InPos;\nMoveL p10,v100\\T:=5,z10,tG;", tmp_path)
    assert "RA397" not in [f.code for f in known.findings]


WAITING = {
    "behind the move": f"{CORNER}\n! there\nWaitRob\\InPos;\n{MOVE}",
    "in front of the next turn": f"WHILE n<3 DO\nWaitRob\\InPos;\nIncr n;\n{CORNER}\nENDWHILE",
    "in the next cycle": f"WaitRob\\InPos;\n{MOVE}\n{CORNER}",
    "on either way": f"IF n=0 THEN\n{CORNER}\nELSE\n{MOVE}\nENDIF\nWaitTime\\InPos,1;",
    "in a routine": f"{CORNER}\nthere;\n{MOVE}\nthere;\nENDPROC\nPROC there()\nWaitRob\\InPos;",
}


@pytest.mark.parametrize("body", WAITING.values(), ids=WAITING.keys())
def test_a_move_stops_where_the_program_always_waits_for_that(body: str, tmp_path: Path) -> None:
    found = translated(body, tmp_path)
    assert found.ok, found.findings
    (data,) = found.files.values()
    assert b"Cnt 0" in data
    assert b"Cnt 1" not in data


OTHER_BRANCH = "ConfL\\{}\nMoveJ p10,v100,fine,tG;\nMoveL pOther,v100,fine,tG;"


@pytest.mark.parametrize(("watched", "ok"), [("Off;", True), ("On;", False)])
def test_branches_of_straight_moves_are_open_where_nothing_watches_them(
    watched: str, ok: bool, tmp_path: Path
) -> None:
    source = tmp_path / "cell.mod"
    other = "[[350,60,250],[0,0,1,0],[0,0,0,1],[9E9,9E9,9E9,9E9,9E9,9E9]]"
    source.write_text(
        f"{HEAD}CONST robtarget pOther:={other};\nPROC main()\n"
        f"{OTHER_BRANCH.format(watched)}\nENDPROC\nENDMODULE\n",
        encoding="utf-8",
    )
    found = translate(source, to="melfa-basic-5", robot=ARM)
    assert found.ok is ok, found.findings


def test_rapid_keeps_what_others_are_not_told() -> None:
    rapid = languages.get("rapid")
    body = "ConfL\\Off;\nTPErase;\nMoveL p10,v100,z10\\Inpos:=inpos20,tG;\nWaitRob\\InPos;"
    text = f"{HEAD}PROC main()\n{body}\nENDPROC\nENDMODULE\n"
    program = rapid.lift(rapid.parse(text))
    written = rapid.render(rapid.build(rapid.adapt(program).program))
    assert rapid.lift(rapid.parse(written)).procedures == program.procedures
    assert "TPErase" in written
