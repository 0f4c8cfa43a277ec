"""Checking: what several parts of a check find is told of once."""

from __future__ import annotations

from pathlib import Path

import pytest

from assistant.base.source_text import SourceText
from assistant.compiler import check_files, compile
from assistant.compiler.checker import check_text

ARC = """MODULE arc
  CONST robtarget p1:=[[350,0,400],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  CONST robtarget p2:=[[400,50,400],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  PROC main()
    MoveL p1, v100, fine, tool0;
    MoveC p2, p1, v100, fine, tool0;
  ENDPROC
ENDMODULE
"""
MVR = """1 Tool P_NTool
2 Mov P1
3 Mvr P1,P2,P1
4 End
P1=(350,0,400,180,0,180)(7,0)
P2=(400,50,400,180,0,180)(7,0)
"""


@pytest.mark.parametrize(
    ("name", "text", "code"), [("a.mod", ARC, "RA459"), ("A.prg", MVR, "MB703")]
)
def test_an_arc_is_told_of_once(tmp_path: Path, name: str, text: str, code: str) -> None:
    file = tmp_path / name
    file.write_text(text, encoding="utf-8")
    checked = check_files([file])
    assert [finding.code for finding in checked.findings] == [code]


PSEUDO = """program cell

tool torch tip [0, 0, 100]

target high [350, 0, 400] [0, 0, 1, 0]

procedure main
  move linear high speed 100 mm/s blend fine tool torch
end
"""
MODULE = """MODULE cell
  PERS tooldata torch:=[TRUE,[[0,0,100],[1,0,0,0]],[1,[0,0,50],[1,0,0,0],0,0,0]];
  PROC main()
    MoveL [[350,0,400],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]], v100, fine, torch;
  ENDPROC
ENDMODULE
"""


@pytest.mark.parametrize(("name", "text"), [("a.pseudo", PSEUDO), ("a.mod", MODULE)])
def test_what_changes_nothing_in_a_program_is_told(tmp_path: Path, name: str, text: str) -> None:
    file, cell = tmp_path / name, tmp_path / "cell.process.toml"
    file.write_text(text, encoding="utf-8")
    cell.write_text('robot = "irb1200-7-0.7"\n[motion]\nspeed = 5\n', encoding="utf-8")
    for found in (
        check_files([file], unit="in", process=cell),
        check_text(
            SourceText(text),
            unit="in",
            process=cell,
            language="rapid" if name.endswith("mod") else None,
        ),
    ):
        told = {f.code: f.message for f in found.findings}
        assert {"SR003", "CO009"} <= told.keys()
        assert "`motion`" in told["CO009"] and "`robot`" in told["CO009"]
    assert check_files([file], unit="parsec").unreadable


@pytest.mark.parametrize(("name", "text"), [("a.pseudo", PSEUDO), ("a.mod", MODULE)])
def test_a_program_is_checked_with_the_tools_of_its_cell(
    tmp_path: Path, name: str, text: str
) -> None:
    file, cell = tmp_path / name, tmp_path / "cell.process.toml"
    file.write_text(text, encoding="utf-8")
    cell.write_text("[tools.torch]\ntip = [0, 0, 900]\n", encoding="utf-8")
    robot = "irb1200-7-0.7"
    assert "RB102" not in {f.code for f in check_files([file], robot=robot).findings}
    found = check_files([file], robot=robot, process=cell).findings
    assert "RB102" in {f.code for f in found}
    compiled = compile(file, language="rapid", robot=robot, process=cell)
    assert "RB102" in {f.code for f in compiled.findings}
