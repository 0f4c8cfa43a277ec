"""From where a tool comes to a place: along itself where that is free, else from a free side."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from assistant import robots
from assistant.base import rotations
from assistant.base.arrays import Floats
from assistant.base.diagnostics import Severity
from assistant.cell.cell_file import read_scene
from assistant.cell.planning.approaches import CellSurroundings
from assistant.cell.planning.space import goal_joints
from assistant.program.geometry import Pose
from assistant.sources.process import ALONG_TOOL, travel_seconds

pytest.importorskip("coal")

TIP = Pose((0.0, 0.0, 100.0))
PLACE = Pose((420.0, 0.0, 300.0), (0.0, 1.0, 0.0, 0.0))
"""The tool points down, its x axis along that of the world and its y axis against it."""
WING = ((30.0, 0.0, 60.0), (80.0, 20.0, 4.0))
"""Middle and edges of a body that stands out from the tool, in the flange: at z 338 to 342."""
DISTANCE = 40.0


def around(folder: Path, **boxes: tuple[tuple[float, ...], tuple[float, ...]]) -> CellSurroundings:
    """An arm with the wing, among boxes of the world, each with its middle and edges."""
    text = '[robots.arm]\nrobot = "irb1200-7-0.7"\ntool = "wing"\n'
    for name, (middle, edges) in {"wing": WING, **boxes}.items():
        text += f"[bodies.{name}]\nbox = {list(edges)}\nposition = {list(middle)}\n"
    file = folder / "cell.toml"
    file.write_text(text)
    scene, findings = read_scene(file)
    assert not findings
    return CellSurroundings(scene, scene.robots[0])


def gaps(
    direction: tuple[float, ...], middle: tuple[float, ...], edges: tuple[float, ...]
) -> Floats:
    """Mm from the wing to a box at 401 places on the way from the place; boxes that overlap: 0.

    Nothing turns on the way, so that all edges keep along the axes of the world.
    """
    turn = np.diag([1.0, -1.0, -1.0])
    way = turn @ np.array(direction) * DISTANCE
    at = np.array(PLACE.position) + turn @ (np.array(WING[0]) - np.array(TIP.position))
    places = at + np.linspace(0.0, 1.0, 401)[:, None] * way
    apart = np.abs(places - middle) - (np.array(WING[1]) + edges) / 2.0
    return np.asarray(np.linalg.norm(np.maximum(apart, 0.0), axis=1))


def test_along_the_tool_where_nothing_is_in_the_way(tmp_path: Path) -> None:
    free = around(tmp_path, post=((420.0, 200.0, 300.0), (20.0, 20.0, 600.0)))
    found = free.way_in(PLACE, TIP, DISTANCE, "seam_start")
    assert found.direction == ALONG_TOOL
    assert found.findings == ()


@pytest.mark.parametrize("gap", [8.0, 3.0], ids=["beyond the margin", "within the margin"])
def test_aside_under_a_lip(tmp_path: Path, gap: float) -> None:
    lip = (490.0, 0.0, 342.0 + gap + 5.0), (60.0, 100.0, 10.0)
    found = around(tmp_path, lip=lip).way_in(PLACE, TIP, DISTANCE, "seam_start")
    assert gaps(ALONG_TOOL, *lip).min() == 0.0
    assert found.direction != ALONG_TOOL
    assert np.linalg.norm(found.direction) == pytest.approx(1.0, abs=1e-3)
    assert gaps(found.direction, *lip).min() > min(gap, 5.0) - 0.3
    (finding,) = found.findings
    assert (finding.code, finding.severity) == ("CK478", Severity.INFO)
    assert finding.place == "seam_start"
    assert "`wing`" in finding.message and "`lip`" in finding.message


def test_the_least_tilt_that_is_free_is_taken(tmp_path: Path) -> None:
    """At 30 degrees the wing is still under the lip when it is as high; at 45 it is beside it."""
    lip = (494.0, 0.0, 384.0), (52.0, 80.0, 10.0)
    found = around(tmp_path, lip=lip).way_in(PLACE, TIP, 60.0, "a")
    assert found.direction == (-0.707, 0.0, -0.707)


def test_no_way_in_is_an_error_with_what_is_in_the_way(tmp_path: Path) -> None:
    walls = {
        f"wall_{i}": ((450.0 + x, y, 340.0), edges)
        for i, (x, y, edges) in enumerate(
            [
                (47.0, 0.0, (2.0, 30.0, 30.0)),
                (-47.0, 0.0, (2.0, 30.0, 30.0)),
                (0.0, 17.0, (90.0, 2.0, 30.0)),
                (0.0, -17.0, (90.0, 2.0, 30.0)),
            ]
        )
    }
    roof = (480.0, 0.0, 352.0), (20.0, 24.0, 4.0)
    found = around(tmp_path, roof=roof, **walls).way_in(PLACE, TIP, DISTANCE, "seam_start")
    (finding,) = found.findings
    assert (finding.code, finding.severity) == ("CK479", Severity.ERROR)
    assert "40 mm" in finding.message and "`roof`" in finding.message


def test_a_place_in_contact_or_out_of_reach_is_left_to_who_checks_the_program(
    tmp_path: Path,
) -> None:
    block = around(tmp_path, block=((420.0, 0.0, 340.0), (50.0, 50.0, 50.0)))
    assert block.way_in(PLACE, TIP, DISTANCE, "a").findings == ()
    far = Pose((2000.0, 0.0, 300.0), PLACE.quaternion)
    assert block.way_in(far, TIP, DISTANCE, "a").findings == ()


@pytest.mark.parametrize("name", ["irb1200-7-0.7", "rv-2aj"])
def test_places_are_seconds_of_the_joints_that_hold_them(tmp_path: Path, name: str) -> None:
    file = tmp_path / "cell.toml"
    file.write_text(f'[robots.arm]\nrobot = "{name}"\n')
    scene, _ = read_scene(file)
    robot = robots.get(name)
    random = np.random.default_rng(4)
    points = np.array([300.0, 0.0, 230.0]) + random.uniform(-40, 40, (20, 3))
    turns = np.tile(PLACE.quaternion, (20, 1))
    places = CellSurroundings(scene, scene.robots[0]).places(points, turns, TIP)
    assert places is not None
    p, q = robot.fk(places * robot.speeds)
    tips = p + rotations.rotate(q, np.array(TIP.position))
    assert np.abs(tips - points).max() < 1e-6
    slowest = max(abs(places[0] - places[1]))
    assert travel_seconds(tuple(places[0]), tuple(places[1])) == pytest.approx(slowest)
    assert CellSurroundings(scene, scene.robots[0]).places(points + 5000.0, turns, TIP) is None


def test_aside_where_the_arm_cannot_go_along_the_tool(tmp_path: Path) -> None:
    file = tmp_path / "cell.toml"
    file.write_text('[robots.arm]\nrobot = "rv-2aj"\n')
    scene, _ = read_scene(file)
    place, tip = Pose((300.0, 0.0, 340.0), PLACE.quaternion), Pose((0.0, 0.0, 70.0))
    found = CellSurroundings(scene, scene.robots[0]).way_in(place, tip, DISTANCE, "high")
    (finding,) = found.findings
    assert (finding.code, finding.place) == ("CK477", "high")
    for direction, can in ((ALONG_TOOL, False), (found.direction, True)):
        x, y, z = (part * DISTANCE for part in direction)
        flange = place @ Pose((x, y, z)) @ tip.inverse()
        _, valid = robots.get("rv-2aj").ik([flange.position], [flange.quaternion])
        assert valid.any() == can


@pytest.mark.slow
def test_no_way_that_is_taken_touches_anything(tmp_path: Path) -> None:
    """Random boxes about the wing: the line keeps what is asked for, whatever it is."""
    random = np.random.default_rng(11)
    aside = 0
    for _ in range(60):
        boxes = {}
        for i in range(4):
            middle = np.array([450.0, 0.0, 345.0]) + random.uniform(-70, 70, 3)
            boxes[f"box_{i}"] = (tuple(middle.tolist()), tuple(random.uniform(4, 30, 3).tolist()))
        asked = around(tmp_path, **boxes)
        found = asked.way_in(PLACE, TIP, DISTANCE, "a")
        at_place = [gaps((0.0, 0.0, 0.0), *box).min() for box in boxes.values()]
        if min(at_place) == 0.0 or any(one.code == "CK479" for one in found.findings):
            continue
        aside += found.direction != ALONG_TOOL
        codes = [one.code for one in found.findings]
        assert (found.direction != ALONG_TOOL) == bool(codes)
        if min(gaps(found.direction, *box).min() for box in boxes.values()) == 0.0:
            assert found.direction == ALONG_TOOL  # the arm touches something at the place itself
            rows = goal_joints(asked.robot, PLACE, asked.robot.home, TIP)
            assert all(asked.space.distances(row).min() <= 0.0 for row in rows)
    assert aside > 5
