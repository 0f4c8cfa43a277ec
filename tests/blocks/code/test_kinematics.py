"""Generated kinematics against ours, over every robot of the catalogue and files of users'."""

from __future__ import annotations

import ctypes
import importlib.util
import subprocess
import sys
from collections.abc import Callable
from importlib.resources import files
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from assistant import robots
from assistant.base.diagnostics import Refused
from assistant.base.file_sets import write_files
from assistant.blocks.code import kinematics, safe_text, source_identifier
from assistant.robots import Robot, robot_file
from assistant.robots.arms import Placed
from assistant.robots.motion.singularities import distance_from_singularity
from tests.blocks.code.compiled import Library, compiled
from tests.robots.test_urdf import OFFSET, WRISTED

SAME = 1e-9
"""degrees and mm."""
COUNT = 60


def own(name: str, text: str) -> Robot:
    """A robot of the catalogue, its file changed."""
    file = files("assistant.robots").joinpath("catalogue", f"{name}.toml")
    return robot_file.read(file.read_text("utf-8").replace(*text.split(" → ")).encode(), "own.toml")


def tilted() -> Robot:
    """An arm whose file turns an axis the other way, on a base that leans."""
    text = WRISTED.replace('<axis xyz="0 1 0"/>', '<axis xyz="0 -1 0"/>', 1)
    origin = '<origin xyz="{}" rpy="{}"/>'
    upright = origin.format("0 0 0.3991", "0 0 0")
    leaning = origin.format("0.1 0 0.4", "0.3 -0.2 0.5")
    robot = robot_file.read(text.replace(upright, leaning).encode(), "own.urdf")
    assert isinstance(robot.arm, Placed) and robot.arm.base.quaternion[0] < 0.99
    return robot


def every_arm() -> list[Robot]:
    rod = own("irb1600-10-1.45", "repeatability_mm → coupling = -1.0\nrepeatability_mm")
    assert rod.coupling == -1.0
    return [*map(robots.get, robots.names()), rod, tilted()]


def joints_of(robot: Robot, count: int = COUNT, seed: int = 7) -> np.ndarray:
    """Joints anywhere inside the limits, away from singularities."""
    joints = np.random.default_rng(seed).uniform(*robot.limits.T, (4 * count, len(robot.axes)))
    return joints[distance_from_singularity(robot, joints) > 0.02][:count]


def differentiated(robot: Robot, joints: np.ndarray) -> np.ndarray:
    """(n, 6, a) by differences of forward kinematics, which share nothing with a Jacobian."""
    out, step = np.empty((len(joints), 6, joints.shape[1])), 1e-4
    for axis in range(joints.shape[1]):
        move = np.zeros(joints.shape[1])
        move[axis] = step
        (p, q), (r, s) = robot.fk(joints + move), robot.fk(joints - move)
        out[:, :3, axis] = (p - r) / (2.0 * step)
        w = np.sign(np.einsum("ij,ij->i", q, s))[:, None]
        turn = 2.0 * w * (s[:, :1] * q[:, 1:] - q[:, :1] * s[:, 1:] - np.cross(q[:, 1:], s[:, 1:]))
        out[:, 3:, axis] = np.degrees(turn) / (2.0 * step)
    return out


def agree(robot: Robot, forward: Callable, inverse: Callable, joints: np.ndarray) -> float:
    """The largest difference from ours, in degrees and mm, whole turns not left out."""
    p, q = robot.fk(joints)
    mine = forward(joints)
    configuration = robot.configuration(joints)
    assert np.array_equal(mine[2], configuration), robot.name
    assert np.abs(mine[3] - differentiated(robot, joints)).max() < 1e-3 * robot.reach / 1000.0
    found, valid = inverse(p, q)
    wanted, fits = robot.ik(p, q)
    assert np.array_equal(valid, fits), robot.name
    assert np.array_equal(np.isnan(found), np.isnan(wanted)), robot.name
    off = [np.abs(mine[0] - p), np.abs(mine[1] - q), np.nan_to_num(np.abs(found - wanted))]
    return float(max(part.max() for part in off))


@pytest.mark.slow
def test_the_c_of_every_arm_agrees_with_ours(tmp_path: Path, tell: Callable[[str], None]) -> None:
    arms = every_arm()
    prefixes = [f"r{i}_{source_identifier(robot.name)}" for i, robot in enumerate(arms)]
    sources = []
    for robot, prefix in zip(arms, prefixes, strict=True):
        stem = source_identifier(robot.name)
        given = kinematics(robot, "c")
        for end in (".h", ".c"):  # a prefix each, as two arms have one name
            text = given[f"{stem}{end}"].decode().replace(f"{stem}.h", f"{prefix}.h")
            text = text.replace(f"{stem}_", f"{prefix}_").replace(stem.upper(), prefix.upper())
            (tmp_path / f"{prefix}{end}").write_text(text)
        sources.append(tmp_path / f"{prefix}.c")
    library = ctypes.CDLL(compiled(sources, tmp_path / "arms.so", "-O0", "-fPIC", "-shared"))
    worst = 0.0
    for robot, prefix in zip(arms, prefixes, strict=True):
        one = Library(library, prefix, robot)
        worst = max(worst, agree(robot, one.forward, one.inverse, joints_of(robot)))
    tell(f"generated C of {len(arms)} arms: off by {worst:.2g} degrees or mm at most")
    assert worst < SAME


def module(file: Path) -> ModuleType:
    spec = importlib.util.spec_from_file_location(f"generated_{file.stem}", file)
    assert spec is not None and spec.loader is not None
    found = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(found)
    return found


def columns(one: ModuleType) -> tuple[Callable, Callable]:
    """The functions of a generated module, over columns."""

    def forward(joints: np.ndarray) -> tuple[np.ndarray, ...]:
        poses = [one.fk(row) for row in joints.tolist()]
        shapes = [one.configuration(row) for row in joints.tolist()]
        rates = [one.jacobian(row) for row in joints.tolist()]
        p, q = (np.array(part) for part in zip(*poses, strict=True))
        return p, q, np.array(shapes), np.array(rates)

    def inverse(p: np.ndarray, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        found = [one.ik(*pose) for pose in zip(p.tolist(), q.tolist(), strict=True)]
        joints = [[branch for branch, _ in row] for row in found]
        return np.array(joints), np.array([[valid for _, valid in row] for row in found])

    return forward, inverse


@pytest.mark.parametrize("name", ["irb1200-7-0.7", "rv-2aj"])
def test_a_pose_that_is_none_is_reached_by_no_branch(name: str, tmp_path: Path) -> None:
    robot = robots.get(name)
    for file, data in kinematics(robot, "python").items():
        (tmp_path / file).write_bytes(data)
    (source,) = [f for f in tmp_path.glob("*.py") if not f.stem.endswith("_check")]
    one = module(source)
    up, nan, inf = (1.0, 0.0, 0.0, 0.0), float("nan"), float("inf")
    for position, quaternion in (
        ((300.0, 0.0, 400.0), (0.0, 0.0, 0.0, 0.0)),
        ((300.0, 0.0, 400.0), (nan, 0.0, 0.0, 1.0)),
        ((300.0, 0.0, 400.0), (inf, 0.0, 0.0, 1.0)),
        ((nan, 0.0, 400.0), up),
        ((300.0, -inf, 400.0), up),
    ):
        found = one.ik(position, quaternion)
        assert len(found) == robot.branches
        assert all(np.isnan(joints).all() and not valid for joints, valid in found)


def test_the_python_of_every_arm_agrees_with_ours(
    tmp_path: Path, tell: Callable[[str], None]
) -> None:
    worst, arms = 0.0, every_arm()
    for robot in arms:
        name = f"{source_identifier(robot.name)}.py"
        (tmp_path / name).write_bytes(kinematics(robot, "python")[name])
        one = columns(module(tmp_path / name))
        worst = max(worst, agree(robot, *one, joints_of(robot, 12)))
    tell(f"generated Python of {len(arms)} arms: off by {worst:.2g} degrees or mm at most")
    assert worst < SAME


@pytest.mark.parametrize("name", ["rv-2aj", "rh-6frh5520", "irb1200-7-0.7"])
def test_the_checks_that_go_with_the_source_pass(tmp_path: Path, name: str) -> None:
    robot, stem = robots.get(name), source_identifier(name)
    write_files({**kinematics(robot, "c"), **kinematics(robot, "python")}, tmp_path)
    sources = [tmp_path / f"{stem}.c", tmp_path / f"{stem}_check.c"]
    program = compiled(sources, tmp_path / "tried")
    for command in ([str(program)], [sys.executable, "-I", f"{stem}_check.py"]):
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
        assert done.returncode == 0, done.stdout + done.stderr
        assert done.stdout.startswith("200 rows, largest difference ")


def test_a_table_that_is_wrong_fails_the_check(tmp_path: Path) -> None:
    robot = robots.get("rv-2aj")
    write_files(kinematics(robot, "c"), tmp_path)
    table = tmp_path / "rv_2aj_vectors.csv"
    head, *rows = table.read_text().splitlines()
    first = rows[0].split(",")
    first[5] = repr(float(first[5]) + 2e-9)
    table.write_text("\n".join([head, ",".join(first), *rows[1:], ""]))
    program = compiled([tmp_path / "rv_2aj.c", tmp_path / "rv_2aj_check.c"], tmp_path / "tried")
    done = subprocess.run([str(program)], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 1 and "largest difference 2e-09" in done.stdout


def test_what_no_arm_reaches_is_valid_in_no_branch(tmp_path: Path) -> None:
    for name in ("rv-2aj", "rh-6frh5520", "irb1200-7-0.7"):
        robot, stem = robots.get(name), source_identifier(name)
        write_files(kinematics(robot, "c"), tmp_path)
        made = compiled([tmp_path / f"{stem}.c"], tmp_path / f"{stem}.so", "-fPIC", "-shared")
        one = Library(ctypes.CDLL(made), stem, robot)
        far = np.array([[5000.0, 0.0, 300.0], [np.nan, 0.0, 300.0], [400.0, 0.0, 300.0]])
        q = np.array([[1.0, 0, 0, 0], [1.0, 0, 0, 0], [0.0, 0, 0, 0]])
        joints, valid = one.inverse(far, q)
        assert not valid.any() and np.isnan(joints).all()


def test_an_arm_without_a_closed_form_is_refused() -> None:
    robot = robot_file.read(OFFSET.encode(), "own.urdf")
    with pytest.raises(Refused) as refused:
        kinematics(robot, "c")
    assert [one.code for one in refused.value.findings] == ["BL301"]


@pytest.mark.parametrize(
    ("text", "name"),
    [
        ("RV-2AJ", "rv_2aj"),
        ("6-axis", "arm_6_axis"),
        ("class", "class_arm"),
        ("math", "math_arm"),
        ("../../etc/passwd", "etc_passwd"),
        ("", "arm"),
        ("Ж", "arm"),
        ("x" * 200, "x" * 40),
    ],
)
def test_names_of_users_become_names_of_sources(text: str, name: str) -> None:
    assert source_identifier(text) == name


def test_a_title_cannot_leave_its_comment(tmp_path: Path) -> None:
    title = '*/ int x = 1; /* \\\\n \\"\\"\\" *//**/ import os'
    robot = own("rv-2aj", f'title = "Mitsubishi RV-2AJ" → title = "{title}"')
    assert '"""' in robot.title and "*/" in robot.title
    assert safe_text(robot.title) == "/ int x 1 / n / / import os"
    write_files({**kinematics(robot, "c"), **kinematics(robot, "python")}, tmp_path)
    compiled([tmp_path / "rv_2aj.c"], tmp_path / "arm.so", "-fPIC", "-shared")
    assert module(tmp_path / "rv_2aj.py").AXES == 5


def test_the_same_robot_gives_the_same_bytes() -> None:
    robot = robots.get("rv-4frl")
    assert kinematics(robot, "c") == kinematics(robot, "c")
