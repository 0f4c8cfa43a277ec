"""Proof by motion: places that only running tells, and that the named arm cannot take."""

from __future__ import annotations

from pathlib import Path

import assistant
from assistant.compiler import Translation
from assistant.compiler.motion_proof import Proving

HEAD = """MODULE Cell
CONST robtarget p10:=[[400,50,450],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
VAR num n:=0;
PROC main()
MoveJ p10,v200,fine,tool0;
"""
CELL = """joint_speed = 200

[signals.diFar]
kind = "digital"
direction = "input"
number = 3
"""


def proven(folder: Path, *lines: str, robot: str | None = "rv-4frl") -> Translation:
    file, cell = folder / "cell.mod", folder / "cell.toml"
    file.write_text(HEAD + "\n".join(lines) + "\nENDPROC\nENDMODULE\n")
    cell.write_text(CELL)
    proving = Proving(seconds=3)
    return assistant.translate(
        file, to="melfa-basic-6", robot=robot, cell=cell, proving=proving, draft=False
    )


STACK = ("FOR i FROM 1 TO 3 DO", "n:=n+{step};", "MoveL Offs(p10,0,0,n),v200,fine,tool0;", "ENDFOR")
FAR = ("IF diFar=1 THEN", "n:=900;", "ENDIF", "MoveL Offs(p10,n,0,0),v200,fine,tool0;")


def stack(step: int) -> list[str]:
    return [line.format(step=step) for line in STACK]


def test_a_computed_place_out_of_reach_is_an_error(tmp_path: Path) -> None:
    done = proven(tmp_path, *stack(400))
    (finding,) = (one for one in done.findings if one.code == "CO128")
    assert finding.severity == "error" and finding.line == 8
    assert "Z 850.0" in finding.message or "Z 1250.0" in finding.message
    assert done.motion is not None and not done.motion.holds
    assert not done.files


def test_the_inputs_that_lead_there_are_named(tmp_path: Path) -> None:
    done = proven(tmp_path, *FAR)
    (finding,) = (one for one in done.findings if one.code == "CO128")
    assert "diFar=1" in finding.message and "out of reach" in finding.message


def test_computed_places_within_reach_are_proven(tmp_path: Path) -> None:
    done = proven(tmp_path, *stack(20))
    assert done.motion is not None and done.motion.holds and done.files
    assert "CO128" not in {one.code for one in done.findings}


def test_without_an_arm_nothing_is_out_of_reach(tmp_path: Path) -> None:
    done = proven(tmp_path, *stack(400), robot=None)
    assert done.motion is not None and done.motion.holds and done.armless
