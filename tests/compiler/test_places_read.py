"""The present position is read in the tool and frame that hold, in either language."""

from __future__ import annotations

from pathlib import Path

import pytest

from assistant import languages
from assistant.program import expressions as e
from assistant.program.program import Program
from assistant.program.rewriting import records
from tests.compiler.same_motion import MELFA, moves_alike, translated

HEAD = """MODULE cell
PERS tooldata tG:=[TRUE,[[0,0,100],[1,0,0,0]],[1,[0,0,50],[1,0,0,0],0,0,0]];
PERS tooldata tB:=[TRUE,[[10,-5,80],[0.92388,0,0,0.382683]],[1,[0,0,50],[1,0,0,0],0,0,0]];
PERS wobjdata wA:=[FALSE,TRUE,"",[[300,-110,100],[0.92388,0,0,0.382683]],[[0,0,0],[1,0,0,0]]];
CONST robtarget p10:=[[350,20,250],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
CONST robtarget p20:=[[50,60,120],[0,0.130526,0.991445,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
VAR robtarget pt;
VAR num n;
"""


def module(body: str, more: str = "") -> str:
    return f"{HEAD}PROC main()\n{body}\nENDPROC\n{more}\nENDMODULE\n"


def places(program: Program) -> list[tuple[str, str]]:
    found = [r for r in records(program.procedures) if isinstance(r, e.Here)]
    return sorted((here.tool, here.frame) for here in found)


def of_rapid(text: str) -> list[tuple[str, str]]:
    rapid = languages.get("rapid")
    return places(rapid.lift(rapid.parse(text)))


MOVES = {
    "in the tool of the move before": (
        "MoveL p10,v100,fine,tG;\npt:=CRobT();\nMoveL Offs(pt,0,0,30),v100,fine,tG;",
        2,
    ),
    "then moved with another tool": (
        "MoveL p10,v100,fine,tG;\npt:=CRobT();\nMoveL Offs(pt,0,0,-30),v100,fine,tool0;",
        2,
    ),
    "in a frame that no move had": (
        "MoveL p10,v100,fine,tG;\npt:=CRobT(\\Tool:=tG\\WObj:=wA);\n"
        "MoveL Offs(pt,0,0,30),v100,fine,tG\\WObj:=wA;\nMoveL p10,v100,fine,tG;",
        3,
    ),
    "in a tool alone, the frame is that of the move": (
        "MoveL p20,v100,fine,tG\\WObj:=wA;\npt:=CRobT(\\Tool:=tB);\n"
        "MoveL pt,v100,fine,tB\\WObj:=wA;",
        2,
    ),
    "within the move": (
        "MoveL p10,v100,fine,tG;\nMoveL Offs(CRobT(\\Tool:=tB\\WObj:=wA),0,0,9),v100,fine,tB;",
        2,
    ),
    "on both ways alike": (
        "MoveL p10,v100,fine,tG;\nIF n>3 THEN\nMoveL p10,v100,fine,tG;\nELSE\nn:=4;\nENDIF\n"
        "pt:=CRobT();\nMoveL Offs(pt,0,0,30),v100,fine,tG;",
        2,
    ),
    "in a loop": (
        "MoveL p10,v100,fine,tB;\nWHILE n<3 DO\npt:=CRobT();\nn:=n+1;\n"
        "MoveL Offs(pt,0,0,30),v100,fine,tB;\nENDWHILE",
        4,
    ),
}


@pytest.mark.parametrize("to", MELFA)
@pytest.mark.parametrize("case", MOVES)
def test_what_crobt_reads_is_where_melfa_reads(tmp_path: Path, case: str, to: str) -> None:
    body, moves = MOVES[case]
    moves_alike(tmp_path, module(body), to, moves)


@pytest.mark.parametrize("to", MELFA)
def test_a_subroutine_reads_in_the_tool_it_names_whatever_its_caller_had(
    tmp_path: Path, to: str
) -> None:
    body = "MoveL p10,v100,fine,tG;\nup;\nMoveL p10,v100,fine,tB;\nup;"
    up = "PROC up()\npt:=CRobT(\\Tool:=tG);\npt.trans.z:=pt.trans.z+50;\n"
    moves_alike(tmp_path, module(body, up + "MoveL pt,v100,fine,tG;\nENDPROC"), to, 4)


UP = "PROC up()\npt:=CRobT();\nMoveL Offs(pt,0,0,50),v100,fine,tG;\nENDPROC"
DIFFERENT = {
    "before the first move": ("pt:=CRobT();\nMoveL pt,v100,fine,tG;", "", 1),
    "the ways differ": (
        "MoveL p10,v100,fine,tG;\nIF n>3 MoveL p10,v100,fine,tB;\npt:=CRobT();\n"
        "MoveL pt,v100,fine,tG;",
        "",
        2,
    ),
    "the callers differ": ("MoveL p10,v100,fine,tG;\nup;\nMoveL p10,v100,fine,tB;\nup;", UP, 4),
    "a turn of the loop differs": (
        "MoveL p10,v100,fine,tG;\nWHILE n<2 DO\npt:=CRobT();\nn:=n+1;\n"
        "MoveL pt,v100,fine,tB;\nENDWHILE",
        "",
        3,
    ),
    "a jump leads there": (
        "MoveL p10,v100,fine,tG;\nagain:\npt:=CRobT();\nMoveL pt,v100,fine,tB;\nn:=n+1;\n"
        "IF n<3 GOTO again;",
        "",
        4,
    ),
}


@pytest.mark.parametrize("case", DIFFERENT)
def test_what_differs_with_the_way_is_noted_behind_the_moves(tmp_path: Path, case: str) -> None:
    body, more, moves = DIFFERENT[case]
    assert of_rapid(module(body, more)) == []
    moves_alike(tmp_path, module(body, more), "melfa-basic-5", moves)


def test_a_place_that_the_program_does_not_tell_is_an_error_with_its_cure(tmp_path: Path) -> None:
    text = module("MoveL p10,v100,fine,tG;\nelsewhere;\npt:=CRobT();\nMoveL pt,v100,fine,tG;")
    assert of_rapid(text) == []
    found = translated(tmp_path, text, "melfa-basic-5")
    assert not found.ok
    said = [f for f in found.findings if "CRobT" in f.message]
    assert said
    assert all(r"CRobT(\Tool:=tool0\WObj:=wobj0)" in f.cure for f in said)


def test_a_subroutine_reads_in_the_tool_that_all_its_callers_left() -> None:
    text = module("MoveL p10,v100,fine,tG;\nup;\nMoveL p20,v100,fine,tG\\WObj:=wA;\nup;", UP)
    assert of_rapid(text) == []  # the frames differ
    text = module("MoveL p10,v100,fine,tG;\nup;\nup;", UP)
    assert of_rapid(text) == [("tG", "base")]


def test_rapid_comes_back_with_the_place_that_it_left_out(tmp_path: Path) -> None:
    body = "MoveL p10,v100,fine,tG;\npt:=CRobT();\nMoveL pt,v100,fine,tG;"
    (tmp_path / "OTHER.mod").write_text(module(body), encoding="utf-8")
    rapid = languages.get("rapid")
    program = rapid.lift(rapid.parse(module(body)))
    built = rapid.build(rapid.adapt(program).program)
    assert "pt:=CRobT(\\Tool:=tG\\WObj:=wobj0);" in rapid.render(built)
    assert "pt:=CRobT();" in rapid.render(rapid.lower(program))


MELFA_HEAD = "1 Base P_NBase\n2 Spd 100\n"
DATA = """P1=(+350.00,+20.00,+250.00,+180.00,+0.00,+180.00)(7,0)
PT=(+0.00,+0.00,+100.00,+0.00,+0.00,+0.00)(0,0)
"""
OF_MELFA = {
    "the tool of the flange": ("Tool PT\nMvs P1\nTool P_NTool\nP9=P_Curr\nMvs P9", 2),
    "the tool that acts at once": ("Mvs P1\nTool PT\nP9=P_Curr\nMvs P9,-20", 2),
    "in a subroutine, by its caller": (
        "Tool PT\nMvs P1\nGoSub *A\nTool P_NTool\nGoSub *A\nEnd\n*A\nP9=P_Curr\nMvs P9,-20\nReturn",
        3,
    ),
    "along the tool": ("Tool PT\nMvs P1\nTool P_NTool\nMvs ,-20", 2),
}


@pytest.mark.parametrize("case", OF_MELFA)
def test_what_melfa_reads_is_where_crobt_reads(tmp_path: Path, case: str) -> None:
    lines, moves = OF_MELFA[case]
    end = "" if lines.endswith("Return") else "\nEnd"
    text = MELFA_HEAD + lines + end + "\n" + DATA
    numbered = [
        line if "=(" in line or line[0].isdigit() else f"{number} {line}"
        for number, line in enumerate(text.splitlines(), 1)
    ]
    made = moves_alike(tmp_path, "\n".join(numbered) + "\n", "rapid", moves)
    assert "CRobT()" not in made


@pytest.mark.parametrize("number", [0, 1])
def test_a_place_is_read_by_the_tool_of_the_way_that_was_taken(tmp_path: Path, number: int) -> None:
    text = f"M1={number}\nMvs P1\nTool PT\nIf M1=1 Then\nTool P_NTool\nEndIf\nP9=P_Curr\nMvs P9"
    lines = [f"{at} {line}" for at, line in enumerate([*text.splitlines(), "End"], 1)]
    made = moves_alike(tmp_path, "\n".join(lines) + "\n" + DATA, "rapid", 2)
    assert "CRobT(\\Tool:=current_tool" in made
