"""Two programs in one folder that declare the same names: each is checked by its own."""

from __future__ import annotations

from pathlib import Path

import pytest

from assistant.compiler import check_files

TARGET = "CONST robtarget p1:=[[{x},0,{z}],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];"
MODULE = """MODULE {name}
  {target}
  PROC main()
    weld;
  ENDPROC
  PROC weld()
    MoveJ p1,v100,fine,tool0;{more}
  ENDPROC
ENDMODULE
"""
MORE = "\n    MoveL p1,v100,fine,tool0;\n    MoveL Offs(p1,0,0,{far}),v100,fine,tool0;"
TOGETHER = {"RA212", "RA201"}
"""Codes of findings on programs that cannot be one task."""


def findings(paths: list[Path]) -> list[tuple[str, str | None, int | None]]:
    found = check_files(paths, robot="irb120-3-0.58").findings
    return [(one.code, one.path, one.line) for one in found if one.code not in TOGETHER]


@pytest.mark.parametrize(("x", "far"), [(400, 50), (2000, 50), (400, 1500)])
def test_what_is_found_in_a_folder_is_what_is_found_in_each_file(
    tmp_path: Path, x: int, far: int
) -> None:
    for name, place, more in (("one", 350, ""), ("two", x, MORE.format(far=far))):
        target = TARGET.format(x=place, z=400)
        text = MODULE.format(name=name, target=target, more=more)
        (tmp_path / f"{name}.mod").write_text(text, encoding="ascii")
    apart = [one for name in ("one", "two") for one in findings([tmp_path / f"{name}.mod"])]
    assert sorted(findings([tmp_path])) == sorted(apart)
    out_of_reach = [(path, line) for code, path, line in apart if code == "RB102"]
    assert bool(out_of_reach) == (x > 1000 or far > 1000)
    assert all(path and path.endswith("two.mod") for path, _ in out_of_reach)
