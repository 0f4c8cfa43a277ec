"""Chains of joints without a closed form: the numerical way back, along columns and programs."""

from __future__ import annotations

import sys
from dataclasses import replace

import numpy as np
import pytest

from assistant import compile, robots
from assistant.base import rotations
from assistant.base.diagnostics import Refused
from assistant.program.motion import UNSTATED, Path, Speed
from assistant.program.program import Procedure, Program
from assistant.program.statements import Follow
from assistant.robots import Robot, robot_file
from assistant.robots.arms import Link, Serial

OFFSET = (  # axes 2, 3 and 4 parallel, 4, 5 and 6 not through one point
    Link(d=89.2, alpha=np.pi / 2),
    Link(a=-425.0),
    Link(a=-392.0),
    Link(d=109.3, alpha=np.pi / 2),
    Link(d=94.75, alpha=-np.pi / 2),
    Link(d=82.5),
)


def toml(links, limits=(-180.0, 180.0), home=0.0, sliding=()) -> str:
    """A robot file of links, all axes with the same limits."""
    text = (
        'name = "own"\ntitle = "Own arm"\nmaker = "own"\ncontroller = "own"\n'
        'languages = ["rapid"]\narm = "serial"\nconfiguration = "quadrants"\n'
        'payload_kg = 5\nreach_mm = 900\nsource = "measured"\n'
    )
    for link in links:
        alpha, theta = np.degrees([link.alpha, link.theta]).tolist()
        text += f"[[links]]\na = {link.a}\nd = {link.d}\nalpha = {alpha}\ntheta = {theta}\n"
    for table, slides in (("axes_deg", False), ("axes_mm", True)):
        names = [f"J{i + 1}" for i in range(len(links)) if (i in sliding) == slides]
        if names:
            text += f"[{table}]\n"
        for name in names:
            text += (
                f"{name} = {{ limits = [{limits[0]}, {limits[1]}], speed = 90, home = {home} }}\n"
            )
    return text


def read(text: str) -> Robot:
    return robot_file.read(text.encode(), "own.toml")


def offset_arm() -> Robot:
    return read(toml(OFFSET))


def random_joints(n: int, seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).uniform(-180, 180, (n, 6))


def apart(left: np.ndarray, right: np.ndarray) -> np.ndarray:
    return np.abs((left - right + 180.0) % 360.0 - 180.0).max(axis=-1)


@pytest.mark.parametrize("name", ["rv-4frl", "rv-2aj", "rh-6frh5520", "irb1600-6-1.2"])
def test_links_say_the_same_as_the_closed_form(name: str) -> None:
    known = robots.get(name)
    sliding = tuple(np.flatnonzero(known.sliding).tolist())
    robot = read(toml(known.arm.links(), sliding=sliding))
    assert isinstance(robot.arm, Serial)
    values = np.random.default_rng(1).uniform(-3, 3, (50, len(known.axes)))
    p, q = robot.arm.fk(values)
    there, turned = known.arm.fk(values)
    assert p == pytest.approx(there, abs=1e-9)
    assert rotations.angle_between(q, turned).max() < 1e-5


def test_solutions_close_and_are_distinct_and_the_own_one_is_among_them() -> None:
    robot = offset_arm()
    joints = random_joints(20)
    poses = robot.fk(joints)
    found, valid = robot.ik(*poses)
    for branch in range(robot.branches):
        rows = valid[:, branch]
        p, q = robot.fk(found[rows, branch])
        assert p == pytest.approx(poses[0][rows], abs=1e-5)
        assert rotations.angle_between(q, poses[1][rows]).max(initial=0.0) < 1e-5
    best = np.where(valid, apart(found, joints[:, None]), np.inf).min(axis=1)
    assert np.mean(best < 1e-4) > 0.95
    assert valid.sum(axis=1).max() == 8
    for row, fits in zip(found, valid, strict=True):
        some = row[fits]
        off = apart(some[:, None], some[None]) + 360.0 * np.eye(len(some))
        assert off.min(initial=360.0) > 1e-3


def test_the_same_pose_always_gives_the_same_joints() -> None:
    poses = offset_arm().fk(random_joints(8, seed=2))
    one, other = offset_arm().ik(*poses)[0], offset_arm().ik(*poses)[0]
    assert np.array_equal(one, other, equal_nan=True)


def test_joints_come_back_by_the_signs_of_their_branch() -> None:
    robot = offset_arm()
    joints = random_joints(20, seed=3)
    back = robot.joints_of(*robot.fk(joints), robot.configuration(joints))
    solved = np.isfinite(back).all(axis=1)
    assert solved.mean() > 0.95
    assert np.abs(back - joints)[solved].max() < 1e-4


def line(robot: Robot, start, end, n: int = 20) -> Path:
    (p0, p1), (q0, _) = robot.fk([start, end])
    part = np.linspace(0, 1, n)[:, None]
    return Path.of("seam", p0 + part * (p1 - p0), np.tile(q0, (n, 1)), speeds=[Speed(50.0)])


def solve_program(robot: Robot, path: Path):
    return robots.solve_program(Program("p", (Procedure("main", (Follow(path),)),)), robot)


def test_a_path_is_followed_without_a_jump_and_its_configurations_stay_open() -> None:
    robot = offset_arm()
    path = line(robot, [10, -60, 90, -40, 80, 20], [40, -70, 100, -40, 80, 20])
    done = solve_program(robot, path)
    assert [f.code for f in done.findings] == ["RB118"]
    (solved_run,) = done.solved_runs
    assert np.abs(np.diff(solved_run.joints, axis=0)).max() < 5.0
    positions, quaternions = robot.fk(solved_run.joints)
    assert positions == pytest.approx(path.positions, abs=1e-5)
    assert rotations.angle_between(quaternions, path.quaternions).max() < 1e-4
    out = done.program.procedures[0].body[0].path
    assert (out.configurations[:, 0] == UNSTATED).all()


def test_what_a_path_states_of_configurations_stays() -> None:
    robot = offset_arm()
    path = line(robot, [10, -60, 90, -40, 80, 20], [20, -60, 90, -40, 80, 20], n=5)
    stated = np.tile(np.array([1, 0, 1, 0, 0, 0], dtype=np.int8), (5, 1))
    done = solve_program(robot, replace(path, configurations=stated))
    assert [f.code for f in done.findings] == ["RB118"]
    out = done.program.procedures[0].body[0].path
    assert np.array_equal(out.configurations, stated)


def test_axes_wind_on_past_half_a_turn() -> None:
    """A tool that turns about itself by 300 degrees, in linear moves."""
    robot = read(toml(OFFSET, limits=(-360.0, 360.0)))
    joints = np.tile([10.0, -60, 90, -40, 80, 0], (31, 1))
    joints[:, 5] = np.linspace(-10, 290, 31)
    positions, quaternions = robot.fk(joints)
    path = Path.of("spin", positions, quaternions, speeds=[Speed(50.0)])
    (solved_run,) = solve_program(robot, path).solved_runs
    assert np.ptp(solved_run.joints[:, 5]) == pytest.approx(300, abs=1e-3)


def test_what_is_out_of_reach_is_told_of() -> None:
    robot = offset_arm()
    path = line(robot, [10, -60, 90, -40, 80, 20], [20, -60, 90, -40, 80, 20], n=4)
    path.positions[2] = (2000.0, 0.0, 300.0)
    (finding, _) = robot.check(Program("p", (Procedure("main", (Follow(path),)),)))
    assert finding.code == "RB117"
    assert "seam_3" in finding.message


GENERAL = (  # no two axes parallel or through one point: up to 16 solutions a pose
    Link(a=80.0, d=290.0, alpha=np.pi / 2),
    Link(a=420.0, d=10.0, alpha=0.6),
    Link(a=60.0, d=20.0, alpha=np.pi / 2),
    Link(a=20.0, d=350.0, alpha=-np.pi / 2),
    Link(a=30.0, d=10.0, alpha=np.pi / 2),
    Link(d=80.0),
)


def test_a_line_that_would_end_in_another_solution_is_told_of() -> None:
    robot = read(toml(GENERAL))
    ends = [
        [-124.8, -56.2, -73.4, 73.8, -42.3, -123.8],
        [-142.9, -80.4, -43.1, 48.6, -15.2, -118.4],
    ]
    positions, quaternions = robot.fk(ends)
    path = Path.of("far", positions, quaternions, speeds=[Speed(50.0)])
    (finding,) = [f for f in solve_program(robot, path).findings if f.severity == "error"]
    assert finding.code == "RB113"
    assert "jump by" in finding.message and "far_2" in finding.message


def test_a_program_for_a_chain_states_no_configuration_and_says_so() -> None:
    robot = offset_arm()
    path = line(robot, [10, -60, 90, -40, 80, 20], [20, -60, 90, -40, 80, 20], n=5)
    source = Program("part", (Procedure("main", (Follow(path),)),))
    done = compile(source, language="rapid", robot=robot)
    assert done.ok
    assert {"RB118", "RA303"} <= {finding.code for finding in done.findings}
    assert done.files["part.mod"].count(b",[0,0,0,0],") == 5


def test_without_roboticstoolbox_the_extra_is_named(monkeypatch) -> None:
    robot = offset_arm()
    pose = robot.fk([[10, -60, 90, -40, 80, 20]])  # the way there needs nothing
    monkeypatch.setitem(sys.modules, "roboticstoolbox", None)
    with pytest.raises(Refused) as refused:
        robot.ik(*pose)
    (finding,) = refused.value.findings
    assert finding.code == "RB003" and "[toolbox]" in finding.cure


@pytest.mark.parametrize(
    ("old", "new", "field"),
    [
        ("[[links]]\na = -425.0", "[[links]]\na = true", "links[2].a"),
        ("[[links]]\na = -425.0", "[[links]]\nb = 1\na = -425.0", "links[2].b"),
        ("J6 = {", "J7 = {", "axes_deg"),
        ('arm = "serial"', "", "links"),
        ('arm = "serial"', 'arm = "serial"\nlengths_mm = { d1 = 1 }', "lengths_mm"),
        ("reach_mm = 900", "reach_mm = 0", "reach_mm"),
    ],
)
def test_a_wrong_chain_is_told_of(old: str, new: str, field: str) -> None:
    text = toml(OFFSET)
    assert old in text
    with pytest.raises(Refused) as refused:
        read(text.replace(old, new))
    assert field in {finding.place for finding in refused.value.findings}


def test_a_chain_needs_links() -> None:
    with pytest.raises(Refused) as refused:
        read(toml(()))
    assert "links" in {finding.place for finding in refused.value.findings}
