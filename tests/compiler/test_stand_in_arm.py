"""Proof by motion of programs that read where their arm stands, though nobody has named one."""

from __future__ import annotations

import pytest

import assistant
from assistant.base.source_text import SourceText
from assistant.compiler.cell_defaults import with_neutral_cell
from assistant.compiler.loader import load_text
from assistant.compiler.motion_proof import MotionProof, Proving

HEAD = """MODULE Cell
CONST robtarget p10:=[[400,50,450],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
CONST robtarget pFar:=[[9400,50,450],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
VAR jointtarget j;
"""


def proven(body: str) -> MotionProof:
    text = f"{HEAD}PROC main()\n{body}\nENDPROC\nENDMODULE\n"
    loaded = with_neutral_cell(load_text(SourceText(text), language="rapid"))
    done = assistant.translate(loaded, to="melfa-basic-6", proving=Proving(seconds=5))
    assert done.motion is not None
    return done.motion


def codes(motion: MotionProof) -> list[str]:
    return [finding.code for finding in motion.findings]


@pytest.mark.parametrize("first", ["", "MoveAbsJ [[1,2,3,4,5,6],[9E9,9E9,9E9,9E9,9E9,9E9]],"])
def test_joints_are_known_without_an_arm(first: str) -> None:
    """At the start, and where a motion to joints has led."""
    move = f"{first}v200,fine,tool0;\n" if first else ""
    motion = proven(f"{move}j:=CJointT();\nj.robax.rax_1:=5;\nMoveAbsJ j,v200,fine,tool0;")
    assert motion.holds
    assert codes(motion) == []


def test_joints_at_a_position_are_those_of_an_arm_that_reaches_it() -> None:
    motion = proven("MoveL p10,v200,fine,tool0;\nj:=CJointT();\nMoveAbsJ j,v200,fine,tool0;")
    assert motion.holds
    assert codes(motion) == ["CO115"]
    assert motion.found is not None and motion.found.visits == 2


def test_no_arm_reaches_it() -> None:
    motion = proven("MoveL pFar,v200,fine,tool0;\nj:=CJointT();\nMoveAbsJ j,v200,fine,tool0;")
    assert codes(motion) == ["CO111"]
