"""A drawing with bodies and locations becomes a program that goes around the bodies.

What was written is read again, and its tool is measured against the bodies by closed forms.
"""

from __future__ import annotations

import runpy
from collections.abc import Callable
from pathlib import Path

import ezdxf
import numpy as np
import pytest

from assistant import robots
from assistant.base import rotations
from assistant.base.arrays import Floats
from assistant.base.diagnostics import Refused
from assistant.cell.drawing_bodies import read_drawing
from assistant.compiler import check_files, compile, load
from assistant.compiler.compilation import Compiled
from assistant.robots.timing import simulate
from assistant.robots.timing.uninterrupted_moves import stretches_of
from tests.cell.exact import segment_box

pytest.importorskip("coal")

CELL = Path(__file__).parents[2] / "samples" / "cell"
DRAWING = CELL / "station.dxf"
LANGUAGES = {"rv-2aj": "melfa-basic-4", "irb1200-7-0.7": "rapid"}

TIP = 70.0
TOOL = {"holder": (0.0, 40.0, 14.0), "needle": (40.0, 67.0, 3.0)}
"""From, to and radius: mm from the flange on."""
BOXES = {
    "wall": ((220, -6, 200), (365, 6, 300)),
    "part 1": ((245, 75, 200), (335, 155, 230)),
    "boss 1": ((278, 103, 230), (302, 127, 255)),
    "part 2": ((250, -160, 200), (330, -70, 230)),
    "boss 2": ((278, -127, 230), (302, -103, 255)),
    "bench": ((160, -230, 180), (430, 230, 200)),
}
POST = (335.0, 42.0, 275.0, 14.0)
"""x, y, the top, radius."""
MARGIN = 2.0


def made(robot: str, **given: object) -> Compiled:
    cell = CELL / f"station-{robot}.toml"
    return compile(DRAWING, language=LANGUAGES[robot], cell=cell, **given)  # type: ignore[arg-type]


def codes(findings: object) -> list[str]:
    return [one.code for one in findings]  # type: ignore[attr-defined]


def test_the_drawing_is_what_its_script_draws(tmp_path: Path) -> None:
    document = runpy.run_path(str(CELL / "station.py"))["station"]()
    document.saveas(tmp_path / "station.dxf")
    drawn, kept = read_drawing(tmp_path / "station.dxf"), read_drawing(DRAWING)
    assert {b.name for b in kept.bodies} == {"PART_1", "PART_2", "POST", "WALL", "BENCH"}
    for one, other in zip(drawn.bodies, kept.bodies, strict=True):
        assert (one.name, one.pose, dict(one.locations)) == (
            other.name,
            other.pose,
            dict(other.locations),
        )
    places = {name for body in kept.bodies for name in body.locations}
    assert places == {"LOOK_1", "LOOK_2", "post_top"}


def test_without_planned_ways_the_tool_hits_the_bodies(tmp_path: Path) -> None:
    text = (CELL / "station.process.toml").read_text("utf-8")
    straight = tmp_path / "straight.process.toml"
    straight.write_text(text.replace('kind = "travel"', 'kind = "joint"'))
    cell = CELL / "station-irb1200-7-0.7.toml"
    found = check_files([DRAWING], cell=cell, process=straight).findings
    hit = " ".join(one.message for one in found if one.code == "CK421")
    assert "`WALL`" in hit
    assert "`POST`" in hit or "`PART_1`" in hit


@pytest.mark.slow
@pytest.mark.parametrize("robot", LANGUAGES)
def test_the_program_goes_around_the_bodies(robot: str, tmp_path: Path) -> None:
    pytest.importorskip("ompl")
    compiled = made(robot)
    assert compiled.ok, [one.message for one in compiled.findings if one.severity == "error"]
    assert compiled.proof.holds
    assert not {"CK421", "CK422", "CK424"} & set(codes(compiled.findings))
    rows, tips = written_way(robot, compiled, tmp_path)
    assert tips[:, 1].min() < -140.0 and tips[:, 1].max() > 140.0  # on both sides of the wall
    for name, box in BOXES.items():
        least = nearest(robot, rows, lambda a, b, box=box: beside_box(a, b, box))  # type: ignore[misc]
        assert least > MARGIN - 0.2, name
    assert nearest(robot, rows, beside_post) > MARGIN - 0.2


@pytest.mark.slow
def test_the_budget_for_compiling_grows_with_the_travels(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("ompl")
    # A tenth of the fixed part is less than the ways of this drawing take to plan.
    monkeypatch.setenv("ROBOT_ASSISTANT_BUDGET", "0.1")
    assert made("irb1200-7-0.7").ok


@pytest.mark.slow
@pytest.mark.parametrize("robot", LANGUAGES)
def test_the_same_drawing_gives_the_same_bytes(robot: str) -> None:
    pytest.importorskip("ompl")
    assert made(robot).files == made(robot).files


def written_way(robot: str, compiled: Compiled, folder: Path) -> tuple[Floats, Floats]:
    """Joints (n, a) along what the written program does, 2 mm of the tip apart, and tips (n, 3)."""
    for name, data in compiled.files.items():
        (folder / name).write_bytes(data)
    arm = robots.get(robot)
    program = load(folder / next(iter(compiled.files)), robot=arm).program
    solved = robots.solve_program(program, arm)
    ways = [stretches_of(passed.plan).joints for passed in simulate(solved).passed]
    knots = np.concatenate(ways)
    gone = np.linalg.norm(np.diff(at(robot, knots, TIP), axis=0), axis=1)
    along = np.concatenate([[0.0], np.cumsum(gone + 1e-6)])
    places = np.arange(0.0, along[-1], 2.0)
    joints = np.stack([np.interp(places, along, column) for column in knots.T], axis=1)
    return joints, at(robot, joints, TIP)


def at(robot: str, rows: Floats, along: float) -> Floats:
    """(n, 3) mm, points of the tool's axis that far from the flange."""
    p, q = robots.get(robot).fk(rows)
    return np.asarray(p + rotations.rotate(q, np.array([0.0, 0.0, along])))


def nearest(robot: str, rows: Floats, beside: Callable[[Floats, Floats], float]) -> float:
    """Mm that the parts of the tool keep from a body at least, by capsules in them.

    beside: of a segment, mm from its body.
    """
    least = np.inf
    for first, last, radius in TOOL.values():
        ends = at(robot, rows, first + radius), at(robot, rows, last - radius)
        least = min(least, *(beside(a, b) - radius for a, b in zip(*ends, strict=True)))
    return float(least)


def beside_box(a: Floats, b: Floats, box: tuple[tuple[int, ...], tuple[int, ...]]) -> float:
    low, high = np.array(box, dtype=float)
    middle, half = (low + high) / 2.0, (high - low) / 2.0
    if np.linalg.norm((a + b) / 2.0 - middle) > np.linalg.norm(half) + 60.0:
        return 40.0
    return segment_box(a - middle, b - middle, half)


def beside_post(a: Floats, b: Floats) -> float:
    """By points of the segment, a mm apart."""
    x, y, top, radius = POST
    points = a + np.linspace(0.0, 1.0, 30)[:, None] * (b - a)
    across = np.maximum(np.hypot(points[:, 0] - x, points[:, 1] - y) - radius, 0.0)
    above = np.maximum(points[:, 2] - top, 0.0)
    return float(np.hypot(across, above).min())


PLACED = "\n[placement]\nposition = [0, 0, 0]\n"
UNDER = """
[robots.arm]
robot = "irb1200-7-0.7"
tool = "wing"
[bodies.wing]                     # stands out from the tool, at z 338 to 342
box = [80, 20, 4]
position = [30, 0, 60]
[bodies.lip]                      # over the end of the wing
box = [60, 150, 10]
position = [490, -20, 355]
"""
ABOVE = """
[motion]
kind = "travel"
tool = "nozzle"
[tools.nozzle]
tip = [0, 0, 100]
[layers.GLUE]
approach = 40
retract = 40
"""


@pytest.fixture
def under(tmp_path: Path) -> Path:
    """The drawing of a line under a lip, beside its cell and its process file."""
    document = ezdxf.new("R2000", units=4)
    document.modelspace().add_line((420, 0, 300), (420, -30, 300), dxfattribs={"layer": "GLUE"})
    document.saveas(tmp_path / "under.dxf")
    (tmp_path / "under.process.toml").write_text(ABOVE + PLACED)
    (tmp_path / "cell.toml").write_text(UNDER)
    return tmp_path / "under.dxf"


@pytest.mark.slow
def test_the_tool_comes_from_aside_where_its_axis_is_not_free(under: Path) -> None:
    pytest.importorskip("ompl")
    compiled = compile(under, language="rapid", cell=under.with_name("cell.toml"))
    assert compiled.ok
    (said,) = (one for one in compiled.findings if one.code == "CK478")
    assert "`wing`" in said.message and "`lip`" in said.message
    assert "glue_1_start" in (said.place or "") and "glue_1_end" in (said.place or "")
    assert not {"CK421", "CK422"} & set(codes(compiled.findings))
    text = next(iter(compiled.files.values()))
    assert b"RelTool(glue_1_end," in text and b"RelTool(glue_1_end,0,0,-40)" not in text


@pytest.mark.slow
def test_nothing_is_made_where_no_way_in_is_free(under: Path) -> None:
    cell = under.with_name("cell.toml")
    walls = [(47, 0, 2, 30), (-47, 0, 2, 30), (0, 17, 90, 2), (0, -47, 90, 2)]
    text = UNDER
    for i, (x, y, dx, dy) in enumerate(walls):
        text += f"[bodies.wall_{i}]\nbox = [{dx}, {dy}, 30]\nposition = [{450 + x}, {y}, 340]\n"
    cell.write_text(text)
    with pytest.raises(Refused) as refused:
        compile(under, language="rapid", cell=cell)
    assert "CK479" in codes(refused.value.findings)
