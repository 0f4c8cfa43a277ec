"""Loops towards their end, with bounds that are worked out once, in MELFA-BASIC."""

from __future__ import annotations

from pathlib import Path

import pytest

from assistant import compile, translate
from assistant.base.source_text import SourceText
from assistant.compiler.loader import parse_pseudo
from assistant.compiler.motion_proof import Proving
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


@pytest.mark.parametrize(
    ("bounds", "wanted"),
    [
        ("1 TO most", "For MI=1 To MOST\n"),
        ("0 TO most-1", "For MI=0 To MOST-1\n"),
        ("most TO 1", "For MI=MOST To 1 Step -1\n"),
        ("most*2 TO most+4", "For MI=MOST*2 To MOST+4\n"),
    ],
)
def test_bounds_of_constants_need_no_choice_of_direction(
    tmp_path: Path, bounds: str, wanted: str
) -> None:
    source = tmp_path / "m.mod"
    body = f"PROC main()\nFOR i FROM {bounds} DO\n{STEP}\nENDFOR\nENDPROC\nENDMODULE\n"
    source.write_text(HEAD + body)
    made = translate(source, to="melfa-basic-5", proving=Proving())
    assert made.motion is not None and made.motion.holds
    text = b"".join(made.files.values()).decode().replace("\r", "")
    assert wanted in text and "MIBY" not in text


@pytest.mark.parametrize(
    ("after", "declared"), [("", False), ("If M1>3 Then Mvs P1", True), ("M1=0", True)]
)
def test_a_variable_that_only_loops_count_is_declared_by_them(
    tmp_path: Path, after: str, declared: bool
) -> None:
    source = tmp_path / "A.prg"
    place = "P1=(400,0,300,180,0,180)(7,0)\n"
    source.write_text(f"For M1=1 To 3\nMvs P1,-10*M1\nNext M1\n{after}\nMvs P1\nEnd\n{place}")
    made = translate(source, to="rapid", language="melfa-basic-5", proving=Proving())
    assert made.motion is not None and made.motion.holds
    assert (b"VAR num M1;" in b"".join(made.files.values())) is declared
