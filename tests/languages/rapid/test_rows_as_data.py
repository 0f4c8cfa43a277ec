"""Many targets that stand below each other, which are read as columns, are data like any other."""

from __future__ import annotations

import pytest

import assistant
from assistant.base.source_text import SourceText
from assistant.compiler.loader import load_text
from assistant.compiler.motion_proof import Proving

COUNT = 40


def program(body: str) -> str:
    rest = "[0,0,1,0],[-1,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];"
    rows = [f"CONST robtarget p{n}:=[[{300 + n}.5,{-10 - n},450],{rest}" for n in range(COUNT)]
    declared = "\n".join(rows)
    return (
        f"MODULE M\n{declared}\nVAR pos at;\nVAR num n;\n"
        f"PROC main()\n{body}\nMoveL Offs(p1,n/10,0,at.z/10),v100,fine,tool0;\nENDPROC\nENDMODULE\n"
    )


@pytest.mark.parametrize(
    "body",
    [
        "at:=p7.trans;",
        "at:=p7.trans+P12.trans;",
        "n:=Distance(p7.trans,p31.trans);",
        "at:=p7.trans;\nn:=VectMagn(at);",
    ],
)
def test_their_parts_are_known(body: str) -> None:
    loaded = load_text(SourceText(program(body)), language="rapid")
    done = assistant.translate(loaded, to="melfa-basic-6", proving=Proving(seconds=2))
    assert [row.text for row in done.rows if row.level == "not"] == []
    assert done.motion is not None and done.motion.holds
    assert done.motion.found is not None and done.motion.found.visits == 1
