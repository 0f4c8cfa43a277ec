"""Bodies that a program takes, carries and lets go, known by their heights."""

from __future__ import annotations

from pathlib import Path

import pytest

from assistant.base.diagnostics import Refused
from assistant.cell.cell_file import read_scene
from assistant.compiler import check_files

PICK = """
program pick
signal grip digital output 3
target over [400, -150, 500] [0, 0, 1, 0]
target at [400, -150, 400] [0, 0, 1, 0]
target beside [400, 150, 500] [0, 0, 1, 0]
target down [400, 150, 400] [0, 0, 1, 0]
procedure main
  move linear over speed 200 mm/s blend fine
  move linear at speed 200 mm/s blend fine
  set grip = 1
  move linear over speed 200 mm/s blend fine
  move linear beside speed 200 mm/s blend fine
  move linear down speed 200 mm/s blend fine
  set grip = 0
  move linear beside speed 200 mm/s blend fine
  move linear over speed 200 mm/s blend fine
end
"""
CELL = """
[robots.arm]
robot = "irb1200-7-0.7"
tool = "finger"

[bodies.finger]
cylinder = [5, 60]
position = [0, 0, 30]

[bodies.part]
cylinder = [20, 100]
position = [400, -150, 288]
taken = {grip = 1}
released = {grip = 0}

[bodies.wall]
box = [200, 10, 340]
position = [400, 0, 170]
"""
"""The finger ends 2 mm above the part. The wall is 340 mm high: the finger alone goes over it, at
440 mm, the part below it, down to 338 mm, does not.
"""


def codes(folder: Path, program: str = PICK, cell: str = CELL) -> list[tuple[str, int | None]]:
    files = folder / "pick.pseudo", folder / "cell.toml"
    for file, text in zip(files, (program, cell), strict=True):
        file.write_text(text, encoding="utf-8")
    found = check_files([files[0]], cell=files[1]).findings
    return [(one.code, one.line) for one in found if one.code.startswith("CK42")]


def test_what_is_carried_touches_what_the_tool_alone_does_not(tmp_path: Path) -> None:
    low = CELL.replace("340]", "320]").replace("170]", "160]")
    assert ("CK421", 13) in codes(tmp_path)
    assert "CK421" not in [code for code, _ in codes(tmp_path, cell=low)]


def test_what_was_let_go_stays_there(tmp_path: Path) -> None:
    # on the way back over the wall the part is beside it
    lines = [line for code, line in codes(tmp_path) if code == "CK421"]
    assert lines == [13]
    # and the finger that comes down once more meets it where it was left
    again = PICK.replace("  move linear over speed 200 mm/s blend fine\nend", LOWER)
    found = codes(tmp_path, again, CELL.replace("340]", "300]").replace("170]", "150]"))
    assert ("CK421", 17) in found


LOWER = """  move linear relative(down, 0, 0, 30) speed 200 mm/s blend fine
end"""


def test_without_outputs_it_is_not_carried(tmp_path: Path) -> None:
    assert "CK421" not in [
        code for code, _ in codes(tmp_path, PICK.replace("  set grip = 1\n", ""))
    ]


def test_what_is_out_of_reach_is_not_taken_and_told(tmp_path: Path) -> None:
    away = CELL.replace("-150, 288", "-150, 258")
    assert [code for code, _ in codes(tmp_path, cell=away)] == ["CK426"]


def test_hands_take_as_outputs_do(tmp_path: Path) -> None:
    program = PICK.replace("set grip = 1", "close hand 1").replace("set grip = 0", "open hand 1")
    cell = CELL.replace("{grip = 1}", '{"hand 1" = 1}').replace("{grip = 0}", '{"hand 1" = 0}')
    assert ("CK421", 13) in codes(tmp_path, program, cell)


def test_a_branch_that_may_take_leaves_it_open(tmp_path: Path) -> None:
    program = PICK.replace("signal grip", "signal ready digital input 1\nsignal grip").replace(
        "  set grip = 1\n", "  if ready = 1\n    set grip = 1\n  end\n"
    )
    assert "CK424" in [code for code, _ in codes(tmp_path, program)]


def test_a_table_of_two_outputs_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "cell.toml"
    file.write_text(CELL.replace("{grip = 1}", "{grip = 1, other = 1}"), encoding="utf-8")
    with pytest.raises(Refused) as refused:
        read_scene(file)
    assert [one.code for one in refused.value.findings] == ["CT303"]
