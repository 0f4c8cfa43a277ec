"""Programs and a drawing in a cell, and what is asked of their scenes."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import pytest

from tests.cli.test_commands import SAMPLES
from tests.studio.serving import Answer, Page

PROGRAM = """\
MODULE Seam
  PERS tooldata torch:=[TRUE,[[0,0,80],[1,0,0,0]],[0.9,[0,0,50],[1,0,0,0],0,0,0]];
  PERS wobjdata part:=[FALSE,TRUE,"",[[300,-50,200],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];
  CONST robtarget home:=[[80,50,300],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]; ! it waits
  CONST robtarget left := [[20,0,50],[0,0,1,0],[-1,0,-1,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  CONST robtarget right:=[[120,0,50],[0,0,1,0],[-1,0,-1,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  PROC main()
    MoveJ home,v200,fine,torch\\WObj:=part;
    MoveL left,v100,fine,torch\\WObj:=part;
    MoveL right,v50,z5,torch\\WObj:=part;
    MoveL Offs(right,0,0,80),v50,z5,torch\\WObj:=part;
  ENDPROC
ENDMODULE
"""
CELL = """\
[robots.arm]
robot = "irb1200-7-0.7"
tool = "torch"

[bodies.torch]
cylinder = [10, 76]
position = [0, 0, 40]

[bodies.table]
box = [300, 300, 20]
position = [420, 0, 200]
"""
PROJECT = """\
[programs.seam]
source = "seam.mod"
robot = "irb1200-7-0.7"
cell = "cell.toml"

[programs.plate]
source = "ring.dxf"
robot = "irb1200-7-0.7"

[programs.numbered]
source = "numbered.mod"
robot = "irb1200-7-0.7"
"""
PSEUDO = """\
program places for irb1200-7-0.7

target above [400, 10, 350] [0, 0, 1, 0]
target  pick [400, 10, 250] [0, 0, 1, 0]  # the part

procedure main
  move joint above speed 200 mm/s blend fine
  move linear pick speed 100 mm/s blend fine
end
"""
MELFA = """\
10 ' Robot: RV-4FRL
20 Mov PHome
30 Mvs PNext ' on
40 End
PHome=(+320.00,+0.00,+400.00,+180.00,+0.00,+180.00)(7,0)
PNext=(+320.00,+40.00,+300.00,+180.00,+0.00,+180.00)(7,0)
"""
ROUND = """\
10 ' Robot: RV-4FRL
20 Mov P11
30 Mvs P12
40 Mvr P12,P13,P14 ' half a circle
50 Mvs P15
60 Mov P3
70 End
P3=(+320.00,+40.00,+300.00,+180.00,+0.00,+180.00)(7,0)
P11=(+320.00,+0.00,+300.00,+180.00,+0.00,+180.00)(7,0)
P12=(+320.00,+40.00,+300.00,+180.00,+0.00,+180.00)(7,0)
P13=(+340.00,+60.00,+300.00,+180.00,+0.00,+180.00)(7,0)
P14=(+360.00,+40.00,+300.00,+180.00,+0.00,+180.00)(7,0)
P15=(+320.00,+0.00,+300.00,+180.00,+0.00,+180.00)(7,0)
"""
"""A run of moves that ends where it begins, beside a position like one of it."""
NUMBERED = """\
MODULE numbered
  CONST robtarget seam_1 := [[420,0,300],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  CONST robtarget seam_2 := [[420,50,300],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  PROC main()
    MoveJ seam_1,v200,fine,tool0;
    MoveL seam_2,v50,fine,tool0;
  ENDPROC
ENDMODULE
"""


@pytest.fixture
def cell(folder: Path) -> Path:
    """A folder with programs of every kind."""
    (folder / "assistant.toml").write_text(PROJECT)
    (folder / "seam.mod").write_text(PROGRAM)
    (folder / "cell.toml").write_text(CELL)
    (folder / "places.pseudo").write_text(PSEUDO)
    (folder / "next.prg").write_text(MELFA)
    (folder / "round.prg").write_text(ROUND)
    (folder / "numbered.mod").write_text(NUMBERED)
    for name in ("taught.toml", "ring.dxf", "ring.process.toml"):
        shutil.copy(SAMPLES / name, folder)
    return folder


def codes(answer: Answer) -> list[str]:
    return [one["code"] for one in answer.value["findings"]]


def shown(page: Page, path: str) -> dict[str, Any]:
    answer = page.post("scene/show", path=path)
    assert answer.status == 200, answer.value
    value: dict[str, Any] = answer.value
    return value


def handle(scene: dict[str, Any], name: str) -> int:
    return next(i for i, one in enumerate(scene["handles"]) if one["name"] == name)


def moved(page: Page, scene: dict[str, Any], name: str, *place: float) -> Answer:
    at = handle(scene, name)
    return page.post("scene/moved", name=scene["name"], handle=at, position=list(place))


def edited(page: Page, scene: dict[str, Any], name: str, by: tuple[float, ...]) -> tuple[str, str]:
    """The file that is edited, and its text then."""
    at = handle(scene, name)
    place = [a + b for a, b in zip(scene["handles"][at]["position"], by, strict=True)]
    answer = page.post("scene/edit", name=scene["name"], handle=at, position=place)
    assert answer.status == 200, answer.value
    path = answer.value["path"]
    (one,) = answer.value["edits"]
    lines = page_text(page, path).split("\n")
    (first, begin), (last, end) = one["from"], one["to"]
    before, after = lines[first][:begin], lines[last][end:]
    lines[first : last + 1] = [before + one["text"] + after]
    return path, "\n".join(lines)


def page_text(page: Page, path: str) -> str:
    text: str = page.post("text/open_text", path=path).value["text"]
    return text
