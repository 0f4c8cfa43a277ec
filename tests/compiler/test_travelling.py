"""`travel to`: ways around what stands in the cell, from where the arm is then."""

from __future__ import annotations

import re
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from assistant import robots
from assistant.base.arrays import Floats
from assistant.base.rotations import to_matrix
from assistant.compiler import check_files, compile
from assistant.compiler.motion_proof import Proving

pytest.importorskip("ompl")
pytest.importorskip("coal")

CELL = Path("samples/cell/clamped.toml").resolve()
OPEN = Path("samples/cell/stand.toml").resolve()
"""The same without the clamp, which stands between `one` and `two`."""
ARM = robots.get("irb1200-7-0.7")
HEAD = """program around for irb1200-7-0.7
tool grip tip [0, 0, 58]
frame plate object [272, 0, 260]
target one [-10, -60, 15] [0, 0, 1, 0]
target two [-10, 40, 15] [0, 0, 1, 0]
target through [-10, -10, 15] [0, 0, 1, 0]
joints ready [0, 0, 0, 0, 90, 0]
signal part digital input 1
variable n number = 0
procedure main
move absolute ready speed maximum blend fine
"""
MOTION = "speed 500 mm/s blend fine tool grip frame plate"
ONE, TWO = f"travel to one {MOTION}", f"travel to two {MOTION}"


def written(folder: Path, *lines: str, more: str = "") -> Path:
    file = folder / "around.pseudo"
    file.write_text("\n".join([HEAD + lines[0], *lines[1:], "end", more]), encoding="utf-8")
    return file


def text_of(file: Path, cell: Path = CELL) -> str:
    done = compile(file, language="rapid", cell=cell)
    assert done.ok, [str(one) for one in done.findings]
    (text,) = done.files.values()
    return text.decode()


def codes(file: Path, cell: Path | None = CELL) -> list[str]:
    """Of the errors and of what is said of travels."""
    found = check_files([file], cell=cell).findings
    return sorted(one.code for one in found if one.code > "CK44" and one.code[:2] == "CK")


def rows_in(text: str) -> list[Floats]:
    """Joints of the absolute moves of a text, read by no parser of ours."""
    found = re.findall(r"MoveAbsJ \[\[([^\]]*)\]", text)
    return [np.array([float(value) for value in one.split(",")]) for one in found]


def nearest(rows: list[Floats]) -> float:
    """Mm between the gripper and the clamp on straight joint moves, by points of the gripper.

    The gripper is a cylinder of radius 12 and length 58, the clamp a box; both are those of the
    cell file.
    """
    steps = [a + np.linspace(0.0, 1.0, 400)[:, None] * (b - a) for a, b in pairwise(rows)]
    p, q = ARM.fk(np.concatenate(steps))
    along = np.linspace(0.0, 58.0, 30)
    middle = p[:, None] + along[:, None] * to_matrix(q)[:, None, :, 2]
    low, high = np.array([252.0, -20.0, 260.0]), np.array([272.0, 0.0, 305.0])
    return float(np.linalg.norm(middle - np.clip(middle, low, high), axis=2).min()) - 12.0


def test_a_way_leads_around_what_a_straight_move_hits(tmp_path: Path) -> None:
    text = text_of(written(tmp_path, ONE, TWO))
    rows = rows_in(text)
    straight = [rows[0], rows[-1]]
    assert nearest(straight) < 0.0 < nearest(rows)
    for row, y in ((rows[0], -60.0), (rows[-1], 40.0)):
        p, q = ARM.fk(row[None])
        tip = p[0] + to_matrix(q)[0] @ [0.0, 0.0, 58.0]
        assert np.allclose(tip, [262.0, y, 275.0], atol=1e-3)
    moves = len(rows) - 1
    assert f"! travel to two, line 13: {moves} planned moves" in text


@pytest.mark.slow
def test_what_is_written_moves_as_the_planned_program(tmp_path: Path) -> None:
    """By virtual controllers, which run both; loops and branches around the ways as well."""
    lines = ["while part = 1", ONE, TWO, "move absolute ready speed maximum blend fine", "end"]
    file = written(tmp_path, *lines, f"travel to ready {MOTION}")
    done = compile(file, language="rapid", cell=CELL, proving=Proving())
    assert done.motion is not None
    assert done.motion.holds
    assert done.files


@pytest.mark.slow
def test_the_same_program_gives_the_same_text(tmp_path: Path) -> None:
    file = written(tmp_path, ONE, TWO)
    assert text_of(file) == text_of(file)


@pytest.mark.parametrize(
    ("lines", "found"),
    [
        ([ONE, TWO], []),
        (["move joint one " + MOTION, TWO], []),
        # Where the arm is then: on all ways that lead there.
        (["if part = 1", f"move linear two {MOTION}", "end", ONE], ["CK472"]),
        (["if part = 1", ONE, "else", ONE, "end", TWO], []),
        (["while part = 1", ONE, TWO, "end"], ["CK472"]),
        (["while part = 1", ONE, TWO, "move absolute ready speed maximum blend fine", "end"], []),
        (["for i from 1 to 3", ONE, TWO, "end"], ["CK472"]),
        (["call there", TWO, "call there"], ["CK472"]),
        (["call there", TWO], []),
        (["label again", ONE, "goto again"], ["CK471"]),
        (["if part = 1", "goto on", "end", f"move joint two {MOTION}", "label on", ONE], ["CK471"]),
        ([f"move linear two {MOTION} until part = 1", ONE], ["CK471"]),
        (["interrupt hand when part = 1 calls there", "interrupt hand on", TWO], ["CK471"]),
        (["call there", "interrupt hand when part = 1 calls there", "interrupt hand on",
          "wait 1 s"], ["CK471"]),
        (["call there", "call aside", "end", "procedure aside", TWO, "if part = 1", "call aside",
          "end"], ["CK471"]),
        # Where it leads.
        (["plate = base", ONE], ["CK473"]),
        (["grip = tool0", ONE], ["CK473"]),
        ([f"travel to offset(one, 0, 0, n) {MOTION}"], []),
        (["for n from 0 to 2", f"travel to offset(one, 0, 0, n) {MOTION}",
          "move absolute ready speed maximum blend fine", "end"], ["CK472"]),
        ([f"travel to offset(one, 0, 0, part) {MOTION}"], ["CK473"]),
        (["return", ONE], ["CK474"]),
        (["travel to ready " + MOTION, f"move linear two {MOTION}"], []),
        # What it names.
        ([f"travel to nowhere {MOTION}"], ["CK495"]),
        ([ONE.replace("tool grip", "tool grap")], ["CK495"]),
        ([ONE.replace("frame plate", "frame plait")], ["CK495"]),
        ([f"{ONE} tilt n deg"], ["CK496"]),
        ([f"{ONE} search 0 s"], ["CK496"]),
        ([f"travel to target [-10, -60, 15] [0, 0, 1, 0] external [5] {MOTION}"], ["CK475"]),
    ],
)  # fmt: skip
def test_ways_are_planned_from_one_known_place(
    tmp_path: Path, lines: list[str], found: list[str]
) -> None:
    there = ["procedure there", ONE, "end"] if any("there" in line for line in lines) else []
    assert codes(written(tmp_path, *lines, more="\n".join(there)), OPEN) == found


def test_a_target_in_a_body_is_told(tmp_path: Path) -> None:
    assert codes(written(tmp_path, f"travel to through {MOTION}")) == ["CK444"]


def test_what_goes_wrong_is_told_at_the_line_and_nothing_is_written(tmp_path: Path) -> None:
    file = written(tmp_path, ONE, f"travel to target [2000, 0, 0] [0, 0, 1, 0] {MOTION}")
    done = compile(file, language="rapid", cell=CELL)
    (found,) = [one for one in done.findings if one.severity.value == "error"]
    assert (found.line, done.files) == (13, {})
    (told,) = check_files([written(tmp_path, ONE)]).findings
    assert (told.code, told.line) == ("CK470", 12)
    assert "--cell" in told.cure
    done = compile(file, language="rapid")
    assert not done.files


def test_a_program_that_begins_with_a_travel_is_told_to_be_at_home(tmp_path: Path) -> None:
    file = written(tmp_path, ONE)
    file.write_text(file.read_text().replace("move absolute ready speed maximum blend fine\n", ""))
    assert codes(file) == ["CK476"]


HELD = """
[robots.arm]
robot = "irb1200-7-0.7"
tool = "grip"
[bodies.grip]
cylinder = [12, 58]
position = [0, 0, 29]
[bodies.part]
box = [20, 20, 120]
position = [262, -60, 211]
taken = {grab = 1}
released = {grab = 0}
[bodies.wall]
box = [20, 20, 40]
position = [262, -10, 195]
"""


def test_what_is_held_goes_along(tmp_path: Path) -> None:
    """The bare gripper passes over a wall that the part in it would hit."""
    cell = tmp_path / "cell.toml"
    cell.write_text(HELD, encoding="utf-8")
    grab = "signal grab digital output 1\nprocedure main"
    texts = []
    for lines in ([], ["set grab = true"]):
        file = written(tmp_path, f"move joint one {MOTION}", *lines, TWO)
        file.write_text(file.read_text().replace("procedure main", grab, 1))
        texts.append(text_of(file, cell))
    assert [len(rows_in(text)) > 2 for text in texts] == [False, True]


@pytest.mark.slow
def test_a_tool_that_is_to_stay_upright_does(tmp_path: Path) -> None:
    tilts = []
    for said in ("", " tilt 2 deg"):
        rows = rows_in(text_of(written(tmp_path, ONE, TWO + said)))
        steps = [a + np.linspace(0.0, 1.0, 200)[:, None] * (b - a) for a, b in pairwise(rows)]
        down = to_matrix(ARM.fk(np.concatenate(steps))[1])[:, 2, 2]
        tilts.append(float(np.degrees(np.arccos(np.clip(-down, -1.0, 1.0))).max()))
        assert nearest(rows) > 0.0
    assert tilts[1] < 2.2 < tilts[0]


WALLS = """
[robots.arm]
robot = "irb1200-7-0.7"
[bodies.left]
box = [1000, 10, 3000]
position = [450, 450, 0]
euler_zyx = [45, 0, 0]
[bodies.right]
box = [1000, 10, 3000]
position = [450, -450, 0]
euler_zyx = [-45, 0, 0]
[bodies.lid]
box = [2400, 2400, 10]
position = [0, 0, 700]
"""
LOW = "joints [0, 60, -30, 0, 60, 0]"


def test_where_no_way_is_found_the_nearest_approach_is_told(tmp_path: Path) -> None:
    """Between two walls that begin 136 mm from axis 1; the lid keeps the elbow below 700 mm, and so
    farther out than that.
    """
    cell = tmp_path / "cell.toml"
    cell.write_text(WALLS, encoding="utf-8")
    p, _ = ARM.fk([[90.0, 60.0, -30.0, 0.0, 60.0, 0.0]])
    x, y, z = p[0].round(6).tolist()
    low = f"move absolute {LOW} speed maximum blend fine"
    for target in (
        LOW.replace("[0,", "[90,", 1),
        f"target [{x:f}, {y:f}, {z:f}] [0, 0.70710678118, 0.70710678118, 0]",
    ):
        file = written(tmp_path, low, f"travel to {target} speed maximum blend fine search 0.1 s")
        done = compile(file, language="rapid", cell=cell)
        (found,) = [one for one in done.findings if one.severity.value == "error"]
        assert (found.code, found.line) == ("CK445", 13)
        assert "nearest approach" in found.message
        assert not done.files
