"""Arcs that start where the motion before ends: its position is named, or read where it stands."""

from __future__ import annotations

import re

import pytest

from assistant import compare
from assistant.base.diagnostics import Severity
from assistant.base.source_text import SourceText
from assistant.compiler import Translation
from assistant.compiler.loader import load_text

from .proven import SIX, crossed, moves_the_same

HEAD = """MODULE Rim
PERS tooldata tSpin:=[TRUE,[[0,0,100],[1,0,0,0]],[1,[0,0,50],[1,0,0,0],0,0,0]];
PERS tooldata tOther:=[TRUE,[[0,0,90],[1,0,0,0]],[1,[0,0,50],[1,0,0,0],0,0,0]];
CONST robtarget pHole:=[[350,20,200],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
VAR robtarget p3;
CONST jointtarget jPark:=[[0,-10,20,0,60,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
VAR num r;
PROC main()
r:=20;
p3:=Offs(pHole,-20,0,0);
"""
CIRCLE = """MoveL Offs(pHole,r,0,0),v50,fine,tSpin;
MoveC Offs(pHole,0,r,0),p3,v20,z1,tSpin;
{between}
MoveC Offs(pHole,0,-r,0),Offs(pHole,r,0,0),v20,fine,tSpin;
"""


def translated(body: str, more: str = "") -> Translation:
    module = f"{HEAD}{body}\nENDPROC\n{more}\nENDMODULE\n"
    return crossed(module, robot="rv-4frl", from_robot="irb1200-7-0.7")


def text_of(done: Translation) -> str:
    (data,) = (data for name, data in done.files.items() if name.endswith(".prg"))
    return data.decode()


def starts(done: Translation) -> list[str]:
    """The start of each arc."""
    return re.findall(r"Mvr (.+?),[^,]+,[^,]+\n", text_of(done))


@pytest.mark.parametrize(
    "between", ["", "r:=20;", "! text", "WaitTime 0.1;", "r:=r+0*pHole.trans.x;"]
)
def test_the_end_of_the_arc_before_is_named(between: str) -> None:
    done = translated(CIRCLE.format(between=between))
    assert moves_the_same(done) == 3
    assert starts(done)[1] == "p3"
    assert "P_Curr" not in text_of(done)


@pytest.mark.parametrize(
    ("line", "start"),
    [
        ("MoveL Offs(p3,r,0,0),v50,z5,tSpin;", "Pat_1"),
        ("MoveL Offs(p3,0,0,10),v50,z5,tSpin;", "p3+(0,0,10,0,0,0)"),
        ("MoveL RelTool(p3,0,0,-10),v50,z5,tSpin;", "p3*(0,0,-10,0,0,0)"),
        ("MoveL RelTool(p3,5,0,0\\Rz:=10),v50,z5,tSpin;", "p3*(5,0,0,0,0,10)"),
    ],
)
def test_a_target_that_is_worked_out_is_named(line: str, start: str) -> None:
    done = translated(f"{line}\nMoveC Offs(pHole,0,r,5),Offs(pHole,-r,0,0),v20,fine,tSpin;")
    assert moves_the_same(done) == 2
    assert starts(done) == [start]


@pytest.mark.parametrize(
    "between",
    [
        "p3:=Offs(p3,0,0,0);",
        "p3.trans.z:=p3.trans.z+0*r;",
        "again;",
        "IF r<0 THEN p3:=pHole; ENDIF",
    ],
)
def test_an_arc_in_a_corner_whose_start_may_have_changed_is_not_written(between: str) -> None:
    done = translated(CIRCLE.format(between=between), "PROC again()\np3:=Offs(p3,0,0,0);\nENDPROC")
    assert "MB209" in {f.code for f in done.findings if f.severity is Severity.ERROR}
    assert not done.files


@pytest.mark.parametrize(
    "before",
    [
        "MoveAbsJ jPark,v50,fine,tSpin;\nIF r>0 THEN\nr:=20;\nENDIF",
        "MoveL p3,v50,fine,tOther;",
        "MoveL p3,v50,fine,tSpin;\np3:=Offs(p3,0,0,0);\nWaitTime 0.1;",
    ],
)
def test_a_start_that_is_not_known_is_read_where_the_arm_stands(before: str) -> None:
    corner = "MoveL pHole,v50,z5,tSpin;"
    done = translated(
        f"{corner}\n{before}\nMoveC Offs(pHole,0,r,5),Offs(pHole,-r,0,40),v20,fine,tSpin;"
    )
    assert moves_the_same(done) == 3
    assert starts(done) == ["PSTART"]
    assert "' note: PSTART is the present position" in text_of(done)
    assert "MB217" in {f.code for f in done.findings}


CORNER = "Mvr p3,"
MUTATIONS = {
    "read in the corner": "PSTART=P_Curr\nMvr PSTART,",
    "read in the corner and copied": "P9=P_Curr\nP8=P9\nMvr P8,",
    "a millimetre back": "Mvs p3+(0,1,0,0,0,0)\nMvr p3,",
    "read and gone to": "P9=P_Curr\nMvs P9\nMvr p3,",
    "along the arc": "Mvr p3+(0.05,-1,0,0,0,0),",
    "off the arc": "Mvr p3+(-0.2,0,0,0,0,0),",
}


@pytest.mark.parametrize("name", MUTATIONS)
def test_the_proof_sees_a_way_back_to_the_start_of_an_arc(name: str) -> None:
    done = translated(CIRCLE.format(between=""))
    text = re.sub(r"(?m)^\d+ +", "", text_of(done))
    assert text.count(CORNER) == 1
    module = load_text(SourceText(text_of_source()), language="rapid")

    def compared(melfa: str) -> bool:
        other = load_text(SourceText(melfa), language=SIX)
        return compare(module, other, robot="rv-4frl").equal

    assert compared(text)
    assert not compared(text.replace(CORNER, MUTATIONS[name]))


def text_of_source() -> str:
    return f"{HEAD}{CIRCLE.format(between='')}\nENDPROC\nENDMODULE\n"
