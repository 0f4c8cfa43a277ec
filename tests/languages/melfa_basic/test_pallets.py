"""Pallets whose corners stay: arrays of targets, in this and other languages."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from assistant import languages
from assistant.compiler.motion_proof import Proving
from assistant.compiler.translation import translate
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.program import Program
from tests.tables import every_row

from .lifting import lifted, opaque

CORNERS = """PS=(100,0,300,180,0,180)(7,0)
PA=(190,30,300,180,0,180)(7,0)
PB=(80,60,330,180,0,180)(7,0)
PD=(200,80,330,180,0,180)(7,0)
PT=(200,80,330,180,10,180)(7,0)
PF=(200,80,330,180,0,180)(6,0)
"""
S, A, B, D = np.array([[100, 0, 300], [190, 30, 300], [80, 60, 330], [200, 80, 330]], float)


def read(definition: str, more: str = "Mov (Plt 1,3)\n") -> Program:
    return lifted(f"{definition}\n{more}Hlt\n", positions=CORNERS)


def points(program: Program) -> np.ndarray:
    variable = program.variables["pallet_1"]
    assert isinstance(variable.initial, e.Aggregate)
    targets = [item.target for item in variable.initial.items if isinstance(item, e.TargetValue)]
    assert variable.size == (len(targets),)
    # tool down, X forward: half a turn about X, then about Z
    turned = {tuple(np.abs(np.round(t.pose.quaternion, 9))) for t in targets}
    assert turned == {(0.0, 0.0, 1.0, 0.0)}
    return np.array([t.pose.position for t in targets])


def test_rows_of_the_same_way() -> None:
    program = read("Def Plt 1,PS,PA,PB,,4,3,2")
    wanted = [S + (A - S) * i / 3 + (B - S) * j / 2 for j in range(3) for i in range(4)]
    assert np.allclose(points(program), wanted, atol=1e-9)
    assert opaque(program) == []
    comment, move = program.procedures[0].body[:2]
    assert isinstance(comment, p.Comment) and isinstance(move, p.Move)
    assert comment.text.startswith("pallet_1: the 4 by 3 places between PS, PA and PB;")
    assert move.target == e.Index(e.Name("pallet_1"), (e.Number(3),))


def test_every_other_row_runs_back() -> None:
    wanted = [S, (S + A) / 2, A, A + B - S, B + (A - S) / 2, B]
    assert np.allclose(points(read("Def Plt 1,PS,PA,PB,,3,2,1")), wanted, atol=1e-9)


def test_a_fourth_corner() -> None:
    made = points(read("Def Plt 1,PS,PA,PB,PD,3,3,2"))
    wanted = [S, (S + A) / 2, A, (S + B) / 2, (S + A + B + D) / 4, (A + D) / 2, B, (B + D) / 2, D]
    assert np.allclose(made, wanted, atol=1e-9)


def test_an_arc_has_points_at_equal_angles() -> None:
    made = points(read("Def Plt 1,PS,PA,PB,,5,0,3"))
    assert np.allclose(made[[0, -1]], [S, B], atol=1e-9)
    steps = np.linalg.norm(np.diff(made, axis=0), axis=1)
    assert np.allclose(steps, steps[0], atol=1e-9)
    normal = np.cross(A - S, B - S)
    assert np.allclose((made - S) @ normal, 0, atol=1e-6)  # in the plane of the three
    away = np.linalg.norm(made - A, axis=1)
    assert away.min() < steps[0]  # and past the one between


def test_an_arc_through_places_on_a_line(tmp_path) -> None:  # type: ignore[no-untyped-def]
    source = tmp_path / "JOB.prg"
    source.write_text(
        "1 Def Plt 1,PS,PM,PE,,5,0,3\n2 Mvs (Plt 1,2)\n3 End\nPS=(300,0,300,180,0,180)(7,0)\n"
        "PM=(310,0,300,180,0,180)(7,0)\nPE=(340,0,300,180,0,180)(7,0)\n"
    )
    made = translate(source, to="rapid", language="melfa-basic-5", proving=Proving())
    assert made.ok
    assert np.allclose(points(made.compiled.source)[1], (310, 0, 300), atol=1e-9)
    assert "MB255" in {finding.code for finding in made.findings}


@pytest.mark.parametrize(
    ("first", "direction", "told"),
    [
        ("PA=P_Curr", 2, True),
        ("PA=PS*PB", 2, True),
        ("PQ=PS/PB\nPA=PQ", 2, True),
        ("PA=Inv(PB)", 2, True),
        ("PA=P_Curr", 12, False),  # keeps the angles of the start
        ("PA=PS*2", 2, False),
        ("PA=PD\nPA.C=170", 2, False),
        ("PQ=P_Curr\nPA=PD", 2, False),
    ],
)
def test_angles_that_are_worked_out_have_an_open_sign(
    tmp_path: Path, first: str, direction: int, told: bool
) -> None:
    source = tmp_path / "JOB.prg"
    text = f"Mvs PS\n{first}\nDef Plt 1,PS,PA,PB,,4,3,{direction}\nMvs (Plt 1,2)\nEnd\n{CORNERS}"
    source.write_text(text)
    made = translate(source, to="rapid", language="melfa-basic-5")
    assert ("MB259" in {finding.code for finding in made.findings}) is told


@pytest.mark.parametrize("direction", [11, 12])
def test_postures_of_the_start(direction: int) -> None:
    alike = read(f"Def Plt 1,PS,PA,PB,,4,3,{direction - 10}")
    fixed = read(f"Def Plt 1,PS,PA,PB,,4,3,{direction}")
    assert np.allclose(points(fixed), points(alike), atol=1e-9)


@every_row(
    ("definition", "more"),
    [
        ("Def Plt 1,PS,PA,PB,,4,3,4", ""),  # no direction
        ("Def Plt 1,PS,PA,PT,,4,3,3", ""),  # turns
        ("Def Plt 1,PS,PA,PB,PT,4,3,2", ""),  # turns
        ("Def Plt 1,PS,PA,PB,,40,30,2", ""),
        ("Def Plt 1,PS,PA,PB,,MQ,3,2", ""),
        ("Def Plt 1,PS,PA,PB,,4,3,2", "PB.X=3\n"),
        ("Def Plt 1,PS,PA,PB,,4,3,2", "Def Plt 1,PS,PA,PB,,5,3,2\n"),
        ("Def Plt 1,PS,PA,P_B,,4,3,2", ""),
    ],
)
def test_others_stay_with_their_definition(definition: str, more: str) -> None:
    program = read(definition, more + "Mov (Plt 1,3)\n")
    assert opaque(program)[0] == definition
    assert "pallet_1" not in program.variables


def test_a_text_keeps_the_definition_that_it_needs() -> None:
    definition = "Def Plt 1,PS,PA,PB,,4,3,2"
    program = read(definition, "Mvs (Plt 1,4) WthIf M_In(5)=1,Hlt\nMov (Plt 1,3)\n")
    assert opaque(program)[0] == definition
    assert "Mov (Plt 1,3)" in opaque(program)


@pytest.mark.parametrize("level", [4, 5, 6])
def test_to_rapid_and_back(level: int) -> None:
    rapid, melfa = languages.get("rapid"), languages.get(f"melfa-basic-{level}")
    program = lifted(
        "Def Plt 1,PS,PA,PB,,4,3,2\nFor MK=1 To 12\nMov (Plt 1,MK)\nP9=(Plt 1,MK)\nNext MK\n",
        level,
        CORNERS,
    )
    text = rapid.render(rapid.build(rapid.adapt(program).program))
    assert "CONST robtarget pallet_1{12}:=" in text
    assert "MoveJ pallet_1{MK}" in text
    again = rapid.lift(rapid.parse(text))
    assert np.allclose(points(again), points(program), atol=1e-3)
    back = melfa.render(melfa.build(melfa.adapt(again).program))
    element = "\nPALLET1(12)=(+170.00,+90.00,+330.00,+180.00,+0.00,+180.00)(7,0)"
    assert element in back.upper().replace("PALLET_", "PALLET")


def test_a_translated_file_is_proven(tmp_path) -> None:  # type: ignore[no-untyped-def]
    source = tmp_path / "JOB.prg"
    corners = re.sub(r"=\((\d+)", lambda x: f"=({int(x[1]) + 300}", CORNERS)
    source.write_text("1 Def Plt 1,PS,PA,PB,,4,3,2\n2 Mov (Plt 1,5)\n3 End\n" + corners)
    made = translate(source, to="rapid", robot="irb1200-7-0.7", language="melfa-basic-5")
    assert made.ok
    assert made.totals["not"] == 0
