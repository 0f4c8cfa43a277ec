"""Locations of the bodies of a cell as targets of programs."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from assistant.base import rotations
from assistant.base.diagnostics import Refused
from assistant.compiler import check_files, compile

CELL = """
[robots.arm]
robot = "irb1200-7-0.7"
position = [100, -50, 20]
euler_zyx = [30, 0, 0]

[frames.bench]
position = [550, 100, 200]
euler_zyx = [0, 0, 10]

[bodies.table]
box = [20, 20, 10]
parent = "bench"
position = [10, 20, -5]

[bodies.part]
box = [10, 10, 10]
parent = "table"
position = [0, 0, 10]
euler_zyx = [90, 0, 0]

[bodies.part.locations.top]
position = [1, 2, 60]
euler_zyx = [0, 0, 180]

[bodies.part.locations.both]
position = [0, 0, 50]

[bodies.table.locations.both]
position = [0, 0, 60]
euler_zyx = [0, 0, 180]

[bodies.gun]
cylinder = [5, 30]
parent = "arm.flange"
position = [0, 0, 15]

[bodies.gun.locations.tip]
position = [0, 0, 15]
"""
PROGRAM = """program goes
frame plane user [400, 0, 0]
procedure main
{}
end
"""


def move(to: str, frame: str = "") -> str:
    return f"move linear {to} speed 100 mm/s blend fine{frame}"


def files(folder: Path, *moves: str, cell: str = CELL) -> tuple[Path, Path]:
    (folder / "cell.toml").write_text(cell)
    (folder / "goes.pseudo").write_text(PROGRAM.format("\n".join(moves)))
    return folder / "goes.pseudo", folder / "cell.toml"


def about(axis: int, degrees: float) -> np.ndarray:
    """(4, 4)."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    one, two = ((1, 2), (2, 0), (0, 1))[axis]
    out = np.eye(4)
    out[one, one] = out[two, two] = c
    out[two, one], out[one, two] = s, -s
    return out


def at(x: float, y: float, z: float) -> np.ndarray:
    out = np.eye(4)
    out[:3, 3] = x, y, z
    return out


BASE = at(100, -50, 20) @ about(2, 30)
TABLE = at(550, 100, 200) @ about(0, 10) @ at(10, 20, -5)
TOP = TABLE @ at(0, 0, 10) @ about(2, 90) @ at(1, 2, 60) @ about(0, 180)


def targets(text: str) -> dict[str, np.ndarray]:
    """(4, 4) of each robtarget of a module."""
    found = {}
    for name, place, turn in re.findall(r"robtarget (\w+):=\[\[([^]]*)\],\[([^]]*)\]", text):
        out = at(*map(float, place.split(",")))
        out[:3, :3] = rotations.to_matrix([float(word) for word in turn.split(",")])
        found[name] = out
    return found


def written(folder: Path, *moves: str) -> dict[str, np.ndarray]:
    program, cell = files(folder, *moves)
    done = compile(program, language="rapid", cell=cell)
    assert done.ok, done.findings
    (text,) = done.files.values()
    return targets(text.decode())


def test_a_location_is_a_target_in_the_base_of_its_robot(tmp_path: Path) -> None:
    found = written(tmp_path, move("top"), move("offset(top, 0, 0, -20)"), move("table_both"))
    assert found["top"] == pytest.approx(np.linalg.inv(BASE) @ TOP, abs=1e-3)
    expected = np.linalg.inv(BASE) @ TABLE @ at(0, 0, 60) @ about(0, 180)
    assert found["table_both"] == pytest.approx(expected, abs=1e-3)


def test_it_is_in_the_frame_of_the_moves(tmp_path: Path) -> None:
    found = written(tmp_path, move("TOP", " frame plane"))
    assert found["TOP"] == pytest.approx(np.linalg.inv(BASE @ at(400, 0, 0)) @ TOP, abs=1e-3)


def test_what_the_program_declares_is_its_own(tmp_path: Path) -> None:
    program, cell = files(tmp_path, move("top"))
    own = "target top [400, 0, 500] [0, 0, 1, 0]\nprocedure"
    program.write_text(program.read_text().replace("procedure", own, 1))
    done = compile(program, language="rapid", cell=cell)
    (text,) = done.files.values()
    assert targets(text.decode())["top"][:3, 3] == pytest.approx((400, 0, 500))


@pytest.mark.parametrize(
    ("moves", "words"),
    [
        ((move("both"),), ("`table`, `part`", "`table_both` or `part_both`")),
        ((move("tip"),), ("moves with an arm",)),
        ((move("top"), move("top", " frame plane")), ("in the base, frame `plane`",)),
    ],
)
def test_what_is_no_target_is_one_finding(
    tmp_path: Path, moves: tuple[str, ...], words: tuple[str, ...]
) -> None:
    program, cell = files(tmp_path, *moves)
    with pytest.raises(Refused) as refused:
        compile(program, language="rapid", cell=cell)
    (finding,) = refused.value.findings
    assert finding.code == "CO077"
    assert all(word in f"{finding.message} {finding.cure}" for word in words)
    checked = check_files([program], cell=cell)
    assert [one.code for one in checked.findings if one.severity.value == "error"] == ["CO077"]


def test_checks_of_a_cell_see_where_it_is(tmp_path: Path) -> None:
    """Once beside the part, once in it."""
    program, cell = files(tmp_path, move("top"))
    codes = [finding.code for finding in check_files([program], cell=cell).findings]
    assert "CK421" not in codes
    cell.write_text(CELL.replace("position = [1, 2, 60]", "position = [1, 2, -20]"))
    codes = [finding.code for finding in check_files([program], cell=cell).findings]
    assert "CK421" in codes


def test_ways_are_planned_to_it(tmp_path: Path) -> None:
    pytest.importorskip("ompl")
    program, cell = files(tmp_path, move("table_both"), "travel to top speed 100 mm/s blend fine")
    cell.write_text(CELL.replace("position = [1, 2, 60]", "position = [1, 2, 90]"))
    done = compile(program, language="rapid", cell=cell)
    assert done.ok, done.findings
