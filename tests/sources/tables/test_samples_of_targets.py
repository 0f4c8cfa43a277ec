"""The samples with targets: what they say, and that the robots they are for can do it."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path as FilePath

import numpy as np
import pytest

from assistant import robots, sources
from assistant.base import rotations
from assistant.program.expressions import Name
from assistant.program.geometry import Pose
from assistant.program.motion import Blend, Kind, Path, Speed
from assistant.program.statements import Follow, MoveJoints

SAMPLES = FilePath(__file__).parents[3] / "samples"
SINGULAR = 10.0
"""Degrees of axis 5 within which a straight line can make the wrist turn over."""


@pytest.fixture(scope="module")
def path() -> Path:
    reading = sources.read(SAMPLES / "positioning.csv")
    assert reading.findings == ()
    (statement,) = reading.program.procedures[0].body
    assert isinstance(statement, Follow)
    return statement.path


def test_the_positioning_experiment_is_a_straight_line_of_35_poses(path: Path) -> None:
    assert len(path) == 35
    assert path.kinds[0] == Kind.JOINT
    assert (path.kinds[1:] == Kind.LINEAR).all()
    assert (path.speeds, path.blends, path.tools) == (
        (Speed(150.0),), (Blend(100.0),), ("GRIPPER",)
    )  # fmt: skip
    start, end = path.positions[0], path.positions[-1]
    way = (path.positions - start) @ (end - start) / ((end - start) @ (end - start))
    assert np.abs(start + way[:, None] * (end - start) - path.positions).max() < 0.002
    turned = rotations.angle_between(path.quaternions[0], path.quaternions)
    assert np.abs(turned - 90.0 * way).max() < 0.001  # slerp goes along with the line
    steps = np.diff(way)
    assert np.abs(steps - steps[::-1]).max() < 1e-4  # trapezoidal: speeds up, goes on, slows down
    assert steps[0] < steps[5] < steps[17]


@pytest.mark.parametrize("name", ["irb1200-7-0.7", "rv-2aj"])
def test_both_robots_reach_it_on_one_branch(name: str, path: Path) -> None:
    tool = Pose((0.0, 0.0, 60.0)).inverse()
    flange = path.positions + rotations.rotate(path.quaternions, tool.position)
    robot = robots.get(name)
    joints, valid = robot.ik(flange, path.quaternions)
    whole = np.flatnonzero(valid.all(axis=0))
    assert len(whole)
    on = joints[:, whole[0]]
    assert np.abs(np.diff(on, axis=0)).max() < 5.0
    if not robot.five_axis:
        assert np.abs(on[:, 4]).min() > SINGULAR


def test_the_taught_sample_is_reached_by_the_robot_it_names() -> None:
    reading = sources.read(SAMPLES / "taught.toml")
    program = reading.program
    assert reading.findings == ()
    first = program.procedures[0].body[0]
    assert isinstance(first, MoveJoints)
    assert first.target == Name("home")
    assert list(program.targets) == ["above", "down", "corner", "edge_end", "away"]
    tip = program.tools["gripper"].tip.inverse()
    poses = [target.pose @ tip for target in program.targets.values()]
    robot = robots.get("irb1200-7-0.7")
    joints, valid = robot.ik(
        np.array([p.position for p in poses]), np.array([p.quaternion for p in poses])
    )
    whole = np.flatnonzero(valid.all(axis=0))
    assert len(whole)
    assert np.abs(joints[:, whole[0], 4]).min() > SINGULAR
    home = np.array(program.joint_targets["home"].joints)
    assert ((robot.limits[:, 0] <= home) & (home <= robot.limits[:, 1])).all()


def test_the_positioning_experiment_is_a_cartesian_trajectory_of_the_toolbox(path: Path) -> None:
    """`ctraj` from the first to the last pose, in metres, gives every row as it was rounded."""
    toolbox = pytest.importorskip("roboticstoolbox")
    from spatialmath import SE3, UnitQuaternion

    start = SE3(0.25, -0.08, 0.3) * SE3.RPY(180, 0, 60, unit="deg")
    end = SE3(0.3, 0.08, 0.24) * SE3.RPY(180, 0, 150, unit="deg")
    poses = toolbox.ctraj(start, end, 35)
    assert np.abs(1000.0 * poses.t - path.positions).max() < 0.0006  # mm, of three decimals
    turns = np.array([UnitQuaternion(one).A for one in poses])
    alike = np.abs(np.einsum("ij,ij->i", turns, path.quaternions))
    assert np.abs(alike - 1.0).max() < 1e-8


@pytest.mark.slow
def test_the_sample_of_a_trajectory_writes_both_programs_and_a_plot(tmp_path: FilePath) -> None:
    pytest.importorskip("roboticstoolbox")
    done = subprocess.run(
        [sys.executable, str(SAMPLES / "python" / "trajectory.py"), "positioning.png"],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(SAMPLES.parent)},
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert done.returncode == 0, done.stderr
    near = re.findall(r"(\S+) passes within (\S+) mm and (\S+) degrees", done.stdout)
    assert [robot for robot, *_ in near] == ["irb1200-7-0.7", "rv-2aj"]
    assert all(float(apart) < 1.0 and float(turned) < 1.0 for _, apart, turned in near)
    assert "MoveL" in (tmp_path / "positioning.mod").read_text("ascii")
    assert "MVS" in (tmp_path / "POSITIONING.prg").read_text("ascii")
    assert (tmp_path / "positioning.png").read_bytes().startswith(b"\x89PNG")
