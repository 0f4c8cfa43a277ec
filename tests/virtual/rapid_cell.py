"""A small cell in RAPID, and what programs in it do."""

from __future__ import annotations

import pytest

from assistant import languages
from assistant.program.geometry import Pose
from assistant.virtual.events import Moved, Run, Said
from assistant.virtual.rapid import run

HEAD = """MODULE Cell
PERS tooldata tGrip:=[TRUE,[[0,0,100],[1,0,0,0]],[1,[0,0,50],[1,0,0,0],0,0,0]];
TASK PERS tooldata tSide:=[TRUE,[[20,0,50],[0.707107,0,0.707107,0]],[1,[0,0,50],[1,0,0,0],0,0,0]];
PERS tooldata tRoom:=[FALSE,[[600,0,400],[1,0,0,0]],[1,[0,0,50],[1,0,0,0],0,0,0]];
PERS wobjdata wTable:=[FALSE,TRUE,"",[[400,50,100],[0.707107,0,0,0.707107]],[[10,0,0],[1,0,0,0]]];
PERS wobjdata wPart:=[TRUE,TRUE,"",[[0,0,30],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];
CONST robtarget p10:=[[350,20,300],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
CONST robtarget p20:=[[10,20,30],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
CONST jointtarget jHome:=[[0,-20,20,0,90,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
"""


def ran(main: str, more: str = "", data: str = "", **given: object) -> Run:
    """The run of a `main` in a small cell, with more routines and data of the module."""
    text = f"{HEAD}{data}\nPROC main()\n{main}\nENDPROC\n{more}\nENDMODULE\n"
    tree = languages.get("rapid").parse(text)
    assert tree.findings == ()
    return run(tree, **given)  # type: ignore[arg-type]


def said(main: str, more: str = "", data: str = "", **given: object) -> list[str]:
    """What a program writes that comes to its end."""
    found = ran(main, more, data, **given)
    assert (found.ended, found.message) == ("end", "")
    return [event.text for event in found.events if isinstance(event, Said)]


def flanges(main: str, more: str = "", data: str = "", **given: object) -> list[Pose | None]:
    found = ran(main, more, data, **given)
    assert (found.ended, found.message) == ("end", "")
    return [event.flange for event in found.events if isinstance(event, Moved)]


def values(*expressions: str, data: str = "", more: str = "") -> list[str]:
    lines = "\n".join(f'TPWrite ""\\Num:={expression};' for expression in expressions)
    return said(lines, more, data)


def truths(*expressions: str, data: str = "") -> list[str]:
    return said("\n".join(f'TPWrite ""\\Bool:={e};' for e in expressions), data=data)


def near(pose: Pose | None, position: tuple[float, ...], quaternion: tuple[float, ...]) -> None:
    assert pose is not None
    assert pose.position == pytest.approx(position, abs=1e-3)
    assert pose.quaternion == pytest.approx(quaternion, abs=1e-5)
