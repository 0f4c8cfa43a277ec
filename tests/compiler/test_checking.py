"""Checking: what several parts of a check find is told of once."""

from __future__ import annotations

from pathlib import Path

import pytest

from assistant.compiler import check_files

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
