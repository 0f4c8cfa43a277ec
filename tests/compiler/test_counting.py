"""Loops towards their end, with bounds that are worked out once, in MELFA-BASIC."""

from __future__ import annotations

from pathlib import Path

import pytest

from assistant import compile
from assistant.base.source_text import SourceText
from assistant.compiler.loader import parse_pseudo
from tests.compiler.same_motion import MELFA, moves_alike, translated

HEAD = """MODULE cell
PERS tooldata tG:=[TRUE,[[0,0,100],[1,0,0,0]],[1,[0,0,50],[1,0,0,0],0,0,0]];
CONST robtarget p10:=[[350,20,250],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
VAR num a:=5;
VAR num b:=2;
VAR num n:=0;
CONST num most:=3;
"""
STEP = "MoveL Offs(p10,i,0,0),v100,fine,tG;"
COUNT = "FUNC num count()\nn:=n+1;\nRETURN n;\nENDFUNC"
LOOPS = {
    "down": (f"FOR i FROM a TO b DO\n{STEP}\nENDFOR", "", 4),
    "up": (f"FOR i FROM b TO a DO\n{STEP}\nENDFOR", "", 4),
    "once": (f"b:=a;\nFOR i FROM a TO b DO\n{STEP}\nENDFOR", "", 1),
    "to a constant below": (f"FOR i FROM a TO most DO\n{STEP}\nENDFOR", "", 3),
    "bounds that change inside": (
        f"FOR i FROM b TO a DO\n{STEP}\na:=a-1;\nb:=b+1;\nENDFOR",
        "",
        4,
    ),
    "a bound that a call changes": (
        f"FOR i FROM 1 TO a DO\n{STEP}\nless;\nENDFOR",
        "PROC less()\na:=a-1;\nENDPROC",
        5,
    ),
    "a step that changes inside": (
        f"n:=1;\nFOR i FROM 1 TO 6 STEP n DO\n{STEP}\nn:=n+1;\nENDFOR",
        "",
        6,
    ),
    "bounds with side effects": (
        f"FOR i FROM count() TO 3*count()-5 DO\n{STEP}\nENDFOR\n"
        "MoveL Offs(p10,n,5,0),v100,fine,tG;",
        COUNT,
        2,
    ),
    "inside one another": (
        f"FOR i FROM a TO b DO\nFOR j FROM b TO i DO\nMoveL Offs(p10,i,j,0),v100,fine,tG;\n"
        f"ENDFOR\nENDFOR\nFOR i FROM b TO a DO\n{STEP}\nENDFOR",
        "",
        4 + 3 + 2 + 1 + 4,
    ),
}


@pytest.mark.parametrize("to", MELFA)
@pytest.mark.parametrize("case", LOOPS)
def test_a_loop_makes_the_turns_of_its_source(tmp_path: Path, case: str, to: str) -> None:
    body, more, moves = LOOPS[case]
    moves_alike(tmp_path, f"{HEAD}PROC main()\n{body}\nENDPROC\n{more}\nENDMODULE\n", to, moves)


def test_a_loop_inside_a_function_that_calls_itself(tmp_path: Path) -> None:
    again = f"PROC down(num k)\nFOR i FROM k TO b DO\n{STEP}\nIF k>3 down k-1;\nENDFOR\nENDPROC"
    text = f"{HEAD}PROC main()\ndown 4;\nENDPROC\n{again}\nENDMODULE\n"
    moves_alike(tmp_path, text, "melfa-basic-6", 3 + 3 * 2)
    assert not translated(tmp_path, text, "melfa-basic-5").ok  # variables are shared there


@pytest.mark.parametrize("to", MELFA)
def test_constant_bounds_need_no_variables(tmp_path: Path, to: str) -> None:
    body = f"FOR i FROM 5 TO most DO\n{STEP}\nENDFOR\nFOR i FROM 1 TO 3 DO\n{STEP}\nENDFOR"
    made = moves_alike(tmp_path, f"{HEAD}PROC main()\n{body}\nENDPROC\nENDMODULE\n", to, 6)
    assert "Step -1" in made or "STEP -1" in made
    assert "_BY" not in made.upper()


@pytest.mark.parametrize(("bounds", "said"), [("1 towards 7", "1 TO 7"), ("7 towards 1", "7 TO 1")])
def test_a_way_between_numbers_is_one_way_in_rapid(bounds: str, said: str) -> None:
    loop = f"  for i from {bounds}\n    v = i\n  end\n"
    text = f"program a\nvariable v number\nprocedure main\n{loop}end\n"
    made = compile(parse_pseudo(SourceText(text, "a.pseudo")), language="rapid")
    assert made.ok, made.findings
    assert f"FROM {said}".encode() in b"".join(made.files.values())
