"""Arcs that are told by a point of the other side, or by their centre."""

from __future__ import annotations

import math

import numpy as np
import pytest

from assistant import languages
from assistant.compiler.translation import translate
from assistant.languages.melfa_basic.lift import paths
from assistant.program import expressions as e
from assistant.program import statements as p

from .lifting import lifted, opaque

POINTS = """PS=(400,0,300,180,0,180)(7,0)
PE=(300,100,300,180,0,180)(7,0)
PC=(300,0,300,180,0,180)(7,0)
PF=(200,0,300,180,0,180)(7,0)
PN=(380,60,300,180,0,180)(7,0)
PL=(500,-100,300,180,0,180)(7,0)
PO=(300,100.02,300,180,0,180)(7,0)
"""
HALF = 100 * math.sqrt(0.5)
NEAR, FAR = (300 + HALF, HALF, 300.0), (300 - HALF, -HALF, 300.0)


@pytest.mark.parametrize(
    ("line", "middle"),
    [("Mvr3 PS,PE,PC", NEAR), ("Mvr2 PS,PE,PF", NEAR), ("Mvr2 PS,PE,PN", FAR)],
)
def test_the_point_between(line: str, middle: tuple[float, ...]) -> None:
    program = lifted(f"Mov PS\n{line}\nHlt\n", positions=POINTS)
    arc = program.procedures[0].body[1]
    assert isinstance(arc, p.MoveCircular)
    assert isinstance(arc.via, e.TargetValue)
    assert np.allclose(arc.via.target.pose.position, middle, atol=1e-9)
    assert arc.target == e.Name("PE")


def test_points_on_a_line() -> None:
    program = lifted("Mov PS\nMvr2 PS,PE,PL\nHlt\n", positions=POINTS)
    move = program.procedures[0].body[1]
    assert isinstance(move, p.Move)
    assert (move.kind, move.target) == ("linear", e.Name("PE"))


@pytest.mark.parametrize(
    "line",
    [
        "Mvr3 PS,PO,PC",  # other radii
        "Mvr3 PS,PF,PC",  # half a turn
        "Mvr3 PS,PE,PC Type 1,0",
        "Mvr3 PS,PE,PM",
        "Mvr2 PS,PE,P_N",
        "Mvc PS,PE,PF",
    ],
)
def test_others_stay(line: str) -> None:
    program = lifted(f"PM=PC\nMov PS\n{line}\nHlt\n", positions=POINTS)
    assert opaque(program) == [line]


@pytest.mark.parametrize("level", [4, 5, 6])
def test_back_from_rapid(level: int) -> None:
    rapid, melfa = languages.get("rapid"), languages.get(f"melfa-basic-{level}")
    program = lifted("Mov PS\nMvr3 PS,PE,PC\nHlt\n", level, POINTS)
    text = rapid.render(rapid.build(rapid.adapt(program).program))
    assert "MoveC [[370.7107,70.7107,300]," in text
    back = melfa.adapt(rapid.lift(rapid.parse(text))).program
    assert "MVR " in melfa.render(melfa.build(back)).upper()


def test_a_translated_file_is_proven(tmp_path) -> None:  # type: ignore[no-untyped-def]
    source = tmp_path / "JOB.prg"
    source.write_text("1 Mov PS\n2 Mvr2 PS,PE,PN\n3 End\n" + POINTS)
    made = translate(source, to="rapid", robot="irb1200-7-0.7", language="melfa-basic-5")
    assert made.ok
    assert made.totals["not"] == 0


def test_a_path_may_begin_with_an_arc_from_elsewhere(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(paths, "MOST_TAUGHT", 1)  # of a long run of positions
    points = "P2=(380,60,430,180,0,180)(7,0)\nP3=(400,120,450,180,0,180)(7,0)\n"
    points += "P4=(360,-80,440,180,0,150)(7,0)\n"  # what the path is written with comes behind it
    language = languages.get("melfa-basic-5")
    text = f"1 Dim PA(2)\n2 PA(1)=P1\n3 Mvs P1\n4 Mvr P1,P2,P3\n{points}"
    program = language.lift(language.parse(text))
    assert any(isinstance(node, p.Follow) for node in program.statements())
    adapted = language.adapt(program).program
    back = language.lift(language.parse(language.render(language.build(adapted))))
    assert back.procedures == adapted.procedures
