"""Joint moves that state their time take it: judged by the interpreter and the catalogue."""

from __future__ import annotations

import numpy as np
import pytest

from assistant import languages, robots
from assistant.base.source_text import SourceText
from assistant.compiler.loader import load_text
from assistant.compiler.translation import translate
from assistant.program.geometry import Pose
from assistant.virtual import melfa
from assistant.virtual.events import Moved

ARM = "rv-4frl"
START = Pose((400.0, 0.0, 600.0), (0.0, 0.0, 1.0, 0.0))
PROGRAM = r"""MODULE timed
CONST jointtarget first:=[[0,10,80,0,60,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
CONST jointtarget second:=[[30,20,70,5,60,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
CONST jointtarget third:=[[30,20,70,5,60,170],[9E9,9E9,9E9,9E9,9E9,9E9]];
VAR num seconds:=1.5;
PROC main()
MoveAbsJ first,v100,fine,tool0;
MoveAbsJ second,v1000\T:=2,z10,tool0;
MoveAbsJ third,v10\T:=seconds,z10,tool0;
MoveAbsJ first,v100,z10,tool0;
MoveAbsJ second,v1000\T:=4,fine,tool0;
MoveAbsJ first,v1000\T:=0,fine,tool0;
MoveAbsJ second,v1000\T:=5000,fine,tool0;
ENDPROC
ENDMODULE
"""
TIMES = (None, 2.0, 1.5, None, 4.0, 0.0, 5000.0)


def moved() -> list[Moved]:
    loaded = load_text(SourceText(PROGRAM, "timed.mod"), robot=robots.get(ARM), language="rapid")
    done = translate(loaded, to="melfa-basic-6", robot=ARM, from_robot=ARM)
    assert done.ok and not done.totals["not"], done.compiled.findings
    (text,) = done.compiled.files.values()
    tree = languages.get("melfa-basic-6").parse(text.decode("ascii"))
    run = melfa.run(tree, robot=robots.get(ARM), start=START)
    return [event for event in run.events if isinstance(event, Moved)]


@pytest.mark.slow
def test_each_takes_its_time() -> None:
    moves = moved()[: len(TIMES)]
    speeds = robots.get(ARM).speeds
    for before, move, seconds in zip(moves, moves[1:], TIMES[1:], strict=False):
        assert move.joints is not None and before.joints is not None and move.percent is not None
        way = np.abs(np.subtract(move.joints, before.joints))
        share = max(way / speeds) * 100.0
        if seconds is not None:
            wanted = min(100.0, max(1.0, share / max(seconds, 0.001)))
            assert move.percent == pytest.approx(wanted, rel=1e-3)
