"""An arm, its own links, its base and its tool, with no cell file and no extra installed."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

from assistant import robots
from assistant.base import rotations
from assistant.cell.clearances import closeness
from assistant.cell.collision.continuous import JointPath, closest_approaches
from assistant.cell.collision.model import Model
from assistant.cell.link_bodies import arm_alone, place_robot, touching_links
from assistant.cell.scene import Body, Box, Capsule, Cylinder, Part, Scene, Sphere
from assistant.checks.clearances import clearances
from assistant.cli import main
from assistant.program.expressions import JointValue
from assistant.program.geometry import JointTarget, Pose, Tool
from assistant.program.motion import FINE, Speed
from assistant.program.program import Procedure, Program
from assistant.program.statements import Motion, MoveJoints
from assistant.robots import Robot
from assistant.robots.timing import simulate

NAMES = ("irb120-3-0.58", "irb1200-7-0.7", "rv-4frl", "rv-7frl", "irb2600-12-1.65")
PROGRAM = """\
program p for {robot}

procedure main
  move absolute joints {joints} speed maximum blend fine
end
"""


@pytest.fixture
def bare(monkeypatch: pytest.MonkeyPatch) -> None:
    """No library that an extra brings."""
    for name in ("coal", "trimesh"):
        monkeypatch.setitem(sys.modules, name, None)


def axis_points(robot: Robot, row: np.ndarray, part: Part, parent: str) -> np.ndarray:
    """(s, 3) points on the axis of a capsule of a link, by the frames of the arm alone."""
    origins, turns = robot.link_frames(row[None])
    assert isinstance(part.shape, Capsule)
    along = np.linspace(-0.5, 0.5, 40)[:, None] * [0.0, 0.0, part.shape.length]
    points = rotations.rotate(np.array(part.pose.quaternion), along) + part.pose.position
    carrier = parent.rpartition(".")[2]
    if carrier == "base":
        return np.asarray(points)
    number = robot.axes.index(carrier)
    return np.asarray(points @ turns[0, number].T + origins[0, number])


def deepest(robot: Robot, row: np.ndarray) -> float:
    """Mm that two links which could be apart are in each other, by samples of their axes."""
    scene, worst = arm_alone(robot), np.inf
    links = scene.robots[0].links
    for i, one in enumerate(links):
        for other in links[i + 1 :]:
            if scene.may_touch(one.name, other.name):
                continue
            for a in one.parts:
                for b in other.parts:
                    p, q = (axis_points(robot, row, x, y.parent) for x, y in ((a, one), (b, other)))
                    far = np.linalg.norm(p[:, None] - q[None], axis=2).min()
                    worst = min(worst, far - a.shape.radius - b.shape.radius)  # type: ignore[union-attr]
    return -float(worst)


def colliding(count: int, seed: int) -> list[tuple[Robot, np.ndarray]]:
    draw, found = np.random.default_rng(seed), []
    while len(found) < count:
        robot = robots.get(NAMES[len(found) % len(NAMES)])
        low, high = robot.limits.T
        row = np.round(draw.uniform(low, high), 3)
        if deepest(robot, row) > 20.0:
            found.append((robot, row))
    return found


def said_of(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    """Output of a command that exits with 1."""
    with pytest.raises(SystemExit) as ended:
        main(list(arguments))
    assert ended.value.code == 1
    said = capsys.readouterr()
    return said.out + said.err


def folds(robot: Robot, row: np.ndarray, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = folder / "p.pseudo"
    file.write_text(PROGRAM.format(robot=robot.name, joints=row.tolist()), encoding="utf-8")
    assert "CK421 error" in said_of(capsys, "check", str(file)), (robot.name, row)


@pytest.mark.usefixtures("bare")
def test_an_arm_that_touches_itself(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for robot, row in colliding(2, 1):
        folds(robot, row, tmp_path, capsys)


@pytest.mark.slow
@pytest.mark.usefixtures("bare")
def test_fifty_arms_that_touch_themselves(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for robot, row in colliding(50, 2):
        folds(robot, row, tmp_path, capsys)


@pytest.mark.usefixtures("bare")
@pytest.mark.parametrize("command", ["check", "compile", "simulate", "view"])
def test_every_command_looks_at_it(
    command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "p.pseudo"
    joints = [0, 120, 60, 0, 30, 0]
    file.write_text(PROGRAM.format(robot="irb1200-7-0.7", joints=joints), encoding="utf-8")
    more = {
        "compile": ["--language", "rapid", "-o", str(tmp_path / "out")],
        "view": ["--html", str(tmp_path / "page.html")],
    }
    assert "CK421" in said_of(capsys, command, str(file), *more.get(command, []))
    assert not (tmp_path / "out").exists()


def to_joints(robot: Robot, *rows: list[float], tool: Tool | None = None) -> Program:
    motion = Motion(Speed(200.0), FINE, tool="pin" if tool else "tool0")
    moves = tuple(MoveJoints(JointValue(JointTarget(tuple(row))), motion) for row in rows)
    tools = {"pin": tool} if tool else {}
    return Program("p", (Procedure("main", moves),), robot=robot.name, tools=tools)


def findings(program: Program, robot: Robot, scene: Scene | None = None) -> list[str]:
    solved = robots.solve_program(program, robot)
    return [f"{f.code} {f.severity.value} {f.message}" for f in clearances(solved, scene)]


@pytest.mark.usefixtures("bare")
def test_the_tool_of_the_program_touches_the_arm() -> None:
    robot = robots.get("irb1200-7-0.7")
    row = [0.0, 60.0, 40.0, 0.0, 110.0, 0.0]
    assert findings(to_joints(robot, row, tool=Tool(Pose((0.0, 0.0, 60.0)))), robot) == []
    found = findings(to_joints(robot, row, tool=Tool(Pose((0.0, 0.0, 450.0)))), robot)
    assert found[0].startswith("CK421 error `pin` touches `robot.base`")
    assert all("`pin`" in one for one in found)
    standing = Tool(Pose((0.0, 0.0, 450.0)), held=False)
    assert findings(to_joints(robot, row, tool=standing), robot) == []


def test_the_line_of_a_run_of_moves_is_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Of twelve like moves the seventh leads the wrist into the base."""
    at = [(400 + 5 * k, 30 * k, 300) for k in range(12)]
    at[6] = (100, 60, 60)
    rest = "[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"
    moves = [f"    MoveJ [[{x},{y},{z}],{rest},v200,fine,tool0;" for x, y, z in at]
    text = ["MODULE m", "  PROC main()", *moves, "  ENDPROC", "ENDMODULE", ""]
    (tmp_path / "m.mod").write_text("\n".join(text), encoding="utf-8")
    said = said_of(capsys, "check", str(tmp_path / "m.mod"), "-r", "irb1200-7-0.7")
    found = [line for line in said.splitlines() if line.startswith("CK421 error")]
    assert found
    assert {line.split("m.mod:")[1].split(":")[0] for line in found} <= {"9", "10"}


def test_capsules_that_hardly_overlap_are_a_warning() -> None:
    """Nobody has measured them, and they are thicker than the castings."""
    robot = robots.get("irb1200-7-0.7")
    angles = [10.0, 14.0, 16.6, 16.8, 17.0, 17.2, 22.0]
    deep = [deepest(robot, np.array([0.0, 100.0, j3, 0.0, 30.0, 0.0])) for j3 in angles]
    for j3, mm in zip(angles, deep, strict=True):
        found = findings(to_joints(robot, [0.0, 100.0, j3, 0.0, 30.0, 0.0]), robot)
        if 0.5 < mm < 3.0:
            assert [one.split()[1] for one in found] == ["warning"]
        if mm > 25.0:
            assert "error" in [one.split()[1] for one in found]
        if mm < -0.5:
            assert found == []
    assert min(deep) < -0.5
    assert max(deep) > 25.0
    assert any(0.5 < mm < 3.0 for mm in deep)


# ------------------------------------------------------------------------------ in a cell


def pin_in_block(
    row: list[float], turned: float, aside: tuple[float, float, float] = (0.0, 0.0, 0.0)
) -> list[str]:
    """Return the findings of an arm that turns its first axis by some degrees, with a pin on its
    flange in a cube of 30 mm. aside: of the middle of the cube from that of the pin, mm.
    """
    robot = robots.get("irb1200-7-0.7")
    arm = place_robot("arm", robot)
    pin = Body("pin", (Part(Sphere(5.0)),), Pose((0.0, 0.0, 60.0)), parent="arm.flange")
    p, q = robot.fk(np.array([row]))
    tip = p[0] + rotations.rotate(q[0], np.array([0.0, 0.0, 60.0])) + np.array(aside)
    block = Body("block", (Part(Box((30.0, 30.0, 30.0))),), Pose.of(tip, (1.0, 0.0, 0.0, 0.0)))
    scene = Scene((pin, block), (arm,), allowed=touching_links(arm), margin=10.0)
    return findings(to_joints(robot, row, [row[0] + turned, *row[1:]]), robot, scene)


def test_a_statement_that_starts_in_contact() -> None:
    into, out = [
        one
        for one in pin_in_block([0.0, 20.0, 10.0, 0.0, 60.0, 0.0], turned=20.0)
        if "`pin`" in one
    ]
    assert into.startswith("CK421 error `pin` touches `block`")
    assert out.startswith("CK421 error `pin` starts in contact with `block`")
    assert "20 mm deep" in into
    assert "20 mm deep" in out


@pytest.mark.parametrize(
    ("aside", "out"),
    [
        ((-10.0, 0.0, 0.0), "(1.00, 0.00, 0.00)"),
        ((0.0, 10.0, 0.0), "(0.00, -1.00, 0.00)"),
        ((0.0, 0.0, -10.0), "(0.00, 0.00, 1.00)"),
    ],
)
def test_the_shortest_way_out_is_that_of_the_first_body(
    aside: tuple[float, float, float], out: str
) -> None:
    found = [
        one
        for one in pin_in_block([0.0, 20.0, 10.0, 0.0, 60.0, 0.0], turned=1.0, aside=aside)
        if "`pin` starts" in one
    ]
    assert f"the shortest way out for `pin` is along {out}" in found[0]


def test_what_is_not_known_of_a_way_is_no_contact() -> None:
    """Joints that may be off their line, by more than is left of the room."""
    robot = robots.get("irb1200-7-0.7")
    scene = arm_alone(robot)
    model = Model(scene)
    rows = np.array([[0.0, 20.0, 10.0, 0.0, 60.0, 0.0], [5.0, 20.0, 10.0, 0.0, 60.0, 0.0]])
    far = model.exact(rows, np.zeros(len(model), np.intp), np.arange(len(model)))
    pair, slack = int(far.argmin()), np.array([[0.0, 0.0, 200.0, 0.0, 0.0, 0.0]])
    (one,) = [
        found
        for found in closest_approaches(
            model, JointPath(rows, slack), np.zeros(len(model)), np.zeros(1, np.intp)
        )
        if found.pair == pair
    ]
    assert one.distance == pytest.approx(far[pair], abs=0.1)
    assert one.bound < 0.0
    assert not one.exact


def test_a_search_that_is_cut_short_gives_a_bound(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("assistant.cell.collision.continuous.MOST_DISTANCES", 50)
    robot = robots.get("irb1200-7-0.7")
    arm = place_robot("arm", robot)
    wall = Body("wall", (Part(Box((10.0, 900.0, 900.0))),), Pose((700.0, 0.0, 500.0)))
    pin = Body("pin", (Part(Sphere(5.0)),), Pose((0.0, 0.0, 60.0)), parent="arm.flange")
    scene = Scene((pin, wall), (arm,), allowed=touching_links(arm), margin=300.0)
    rows = [[-60.0, 20.0, 10.0, 0.0, 60.0, 0.0], [60.0, 25.0, 10.0, 0.0, 60.0, 0.0]]
    solved = robots.solve_program(to_joints(robot, *rows), robot)
    found = [c for c in closeness(simulate(solved), scene) if c.contact.one == "pin"]
    assert any(not one.exact and one.bound < one.least for one in found)
    said = [f.message for f in clearances(solved, scene) if "`pin`" in f.message]
    assert any("mm or less (more than" in message for message in said)


# --------------------------------------------------------------------------------- SCARAs


def horizontal() -> list[str]:
    return [name for name in robots.names() if len(robots.get(name).axes) == 4]


@pytest.mark.parametrize("name", horizontal())
def test_a_scara_has_a_column_two_links_and_a_quill(name: str) -> None:
    robot = robots.get(name)
    links = {body.name: body for body in place_robot("arm", robot).links}
    assert set(links) == {"arm.base", "arm.J1", "arm.J2", "arm.J4"}
    home = to_joints(robot, [0.0, 0.0, float(robot.limits[2].max()), 0.0])
    low = to_joints(robot, [0.0, 0.0, float(robot.limits[2].min()), 0.0])
    reach, top = robot.reach, float(robot.limits[2].max())
    table = Body("table", (Part(Box((2000.0, 2000.0, 40.0))),), Pose((0.0, 0.0, -21.0)))
    arm = place_robot("arm", robot)
    own = touching_links(arm)
    for program in (home, low):
        scene = Scene((table,), (arm,), allowed=own, margin=0.5)
        assert findings(program, robot, scene) == []
        assert findings(program, robot) == []
    post = Part(Capsule(20.0, 400.0))
    for at, z, met in (
        (0.5 * reach, top + 60.0, True),  # in the swing of the links
        (0.5 * reach, top - 400.0, False),  # below them
        (reach, top + 60.0, True),  # where the quill is
        (reach + 150.0, top + 60.0, False),
    ):
        turned = rotations.from_euler(np.array([0.0, 0.0, 0.0]))
        body = Body("post", (post,), Pose.of((0.0, at, z), np.asarray(turned).reshape(4)))
        swing = to_joints(
            robot, [0.0, 0.0, top, 0.0], [min(100.0, robot.limits[0, 1]), 0.0, top, 0.0]
        )
        found = findings(swing, robot, Scene((body,), (arm,), allowed=own, margin=0.0))
        assert bool(found) == met, (at, z, found)


def test_a_post_of_any_shape_is_met_by_a_scara() -> None:
    robot = robots.get(horizontal()[0])
    arm, top = place_robot("arm", robot), float(robot.limits[2].max())
    post = Body("post", (Part(Cylinder(30.0, 900.0)),), Pose((0.0, 0.4 * robot.reach, 550.0)))
    program = to_joints(robot, [0.0, 0.0, top, 0.0], [100.0, 0.0, top, 0.0])
    found = findings(
        program, robot, Scene((post,), (arm,), allowed=touching_links(arm), margin=5.0)
    )
    assert any("`post` touches `arm.J1`" in one for one in found)
