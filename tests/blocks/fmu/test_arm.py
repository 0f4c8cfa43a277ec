"""The FMU of a simulated arm beside the arm of the library, in fmpy and in a C program."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from assistant import robots
from assistant.blocks.fmu import arm_model
from assistant.blocks.library.arms import ArmMotion
from assistant.program.expressions import JointValue
from assistant.program.geometry import JointTarget
from assistant.program.motion import FINE, Speed
from assistant.program.program import Procedure, Program
from assistant.program.statements import Motion, MoveJoints
from assistant.robots import Robot, solve_program
from assistant.robots.timing import simulate
from tests.blocks.fmu.hosting import Hosted

SAME = 1e-9
POSE = ("x", "y", "z", "qw", "qx", "qy", "qz")


def inputs_of(robot: Robot) -> list[str]:
    wanted = [*robot.axes, *POSE]
    return [*(f"{name}_wanted" for name in wanted), "by_pose", "branch"]


def told(robot: Robot, count: int, seed: int = 4) -> np.ndarray:
    """Joints that stay for a while, some outside the limits, some of no number; then poses."""
    random = np.random.default_rng(seed)
    low, high = robot.limits.T
    stays = max(count // 12, 1)
    joints = random.uniform(low * 1.1, high * 1.1, (count // stays + 1, len(low))).repeat(stays, 0)
    joints = joints[:count]
    joints[random.random(joints.shape) < 0.02] = np.nan
    inside = random.uniform(low, high, (count // stays + 1, len(low)))
    poses = np.hstack(robot.fk(inside)).repeat(stays, 0)[:count]
    poses[count // 2 : count // 2 + 9, :3] *= 9.0
    by_pose = (np.arange(count) >= count // 3) * 1.0
    branch = np.where(np.arange(count) < count * 2 // 3, -1.0, 1.0)
    return np.column_stack([joints, poses, by_pose, branch])


def ours(robot: Robot, rows: np.ndarray, step: float, lag: float) -> np.ndarray:
    """The outputs of the library in the order of the model's."""
    arm, n = ArmMotion.of(robot, lag=lag), len(robot.axes)
    found = [state(arm)]
    for row in rows:
        if row[-2]:
            arm.towards_pose(row[n : n + 7], int(row[-1]))
        else:
            arm.towards(row[:n])
        arm.step(step)
        found.append(state(arm))
    return np.array(found)


def state(arm: ArmMotion) -> np.ndarray:
    configuration = arm.robot.configuration(arm.joints)[0]
    flags = [[arm.reachable], arm.at_limit, arm.at_speed]
    return np.concatenate(
        [arm.joints, arm.speed, arm.pose, configuration, *flags], dtype=np.float64
    )


@pytest.mark.parametrize(
    ("name", "lag"),
    [("rv-2aj", 0.0), ("rh-6frh5520", 0.05), ("rv-4frl", 0.0)]
    + [pytest.param(name, 0.03, marks=pytest.mark.slow) for name in robots.names()],
)
def test_the_outputs_are_those_of_the_library(
    name: str, lag: float, tmp_path: Path, tell: Callable[[str], None]
) -> None:
    robot = robots.get(name)
    hosted, rows = Hosted(arm_model(robot, lag=lag), tmp_path), told(robot, 240)
    wanted = ours(robot, rows, 0.0071, lag)
    repeats = 0 if lag == 0.03 else 40_000
    found, speed = hosted.run(inputs_of(robot), rows, 0.0071, repeats=repeats)
    assert np.abs(found - wanted).max() < SAME
    assert len({*wanted[:, -1 - 2 * len(robot.axes)]}) == 2  # what cannot be reached was among it
    assert wanted[:, len(robot.axes) : 2 * len(robot.axes)].any()
    if speed is not None:
        tell(
            f"FMU arm {name}: {speed.steps:,.0f} steps/s in C, {speed.nanoseconds:,.0f} ns a step, "
            f"{speed.bytes} bytes an instance, {speed.peak} KiB the process at most, "
            f"the file {hosted.size // 1024} KiB"
        )


def test_fmpy_gives_the_same(tmp_path: Path, tell: Callable[[str], None]) -> None:
    robot = robots.get("rv-4frl")
    hosted, rows = Hosted(arm_model(robot), tmp_path), told(robot, 150)
    rows[np.isnan(rows)] = 0.0
    begin = time.perf_counter()
    found = hosted.in_fmpy(inputs_of(robot), rows, 0.01)
    seconds = time.perf_counter() - begin
    assert np.abs(found - ours(robot, rows, 0.01, 0.0)).max() < SAME
    tell(f"FMU arm rv-4frl: {len(rows) / seconds:,.0f} steps/s in fmpy, unpacking included")


def test_a_state_is_gone_back_to(tmp_path: Path) -> None:
    fmpy = pytest.importorskip("fmpy", reason="fmpy comes with the extra `test`")
    from fmpy.fmi2 import FMU2Slave

    robot = robots.get("rv-2aj")
    hosted = Hosted(arm_model(robot), tmp_path)
    described = fmpy.read_model_description(str(hosted.file))
    of = {one.name: one.valueReference for one in described.modelVariables}
    unpacked = str(hosted.folder / "unpacked")
    one = FMU2Slave(
        guid=described.guid,
        unzipDirectory=unpacked,
        modelIdentifier=described.coSimulation.modelIdentifier,
    )
    one.instantiate()
    one.setupExperiment()
    one.enterInitializationMode()
    one.setReal([of["J1_start"]], [10.0])
    assert one.getReal([of["J1"]]) == [10.0]  # outputs follow what is set before the first step
    one.exitInitializationMode()
    one.setReal([of["J1_wanted"]], [60.0])
    one.doStep(0.0, 0.1)
    kept, there = one.getFMUState(), one.getReal([of["J1"], of["J1_speed"]])
    bytes_ = one.serializeFMUState(kept)
    one.doStep(0.1, 0.1)
    later = one.getReal([of["J1"]])
    assert later != there[:1]
    one.setFMUState(one.deSerializeFMUstate(bytes_))
    assert one.getReal([of["J1"], of["J1_speed"]]) == there
    one.doStep(0.1, 0.1)
    assert one.getReal([of["J1"]]) == later
    for refused in (
        lambda: one.setReal([of["J1"]], [1.0]),  # an output
        lambda: one.setReal([of["J1_start"]], [1.0]),  # a parameter, too late
        lambda: one.getReal([10_000]),
        lambda: one.doStep(0.2, -0.1),
    ):
        with pytest.raises(Exception, match=r"fmi2Error|status 3"):
            refused()
    one.terminate()
    one.reset()
    one.setupExperiment()
    one.enterInitializationMode()
    one.exitInitializationMode()
    assert one.getReal([of["J1"]]) == [0.0]
    one.terminate()
    one.freeInstance()


WRONG = (
    {"J1_start": 500.0},
    {"J2_speed_limit": 0.0},
    {"J3_acceleration_limit": -1.0},
    {"time_constant": -0.1},
    {"J1_lower_limit": 10.0, "J1_upper_limit": -10.0},
)


def test_parameters_that_fit_no_arm_are_refused(tmp_path: Path) -> None:
    robot = robots.get("rv-2aj")
    hosted = Hosted(arm_model(robot), tmp_path)
    for wrong in WRONG:
        with pytest.raises(AssertionError, match="logStatusError"):
            hosted.run(inputs_of(robot), told(robot, 12), 0.01, wrong)


def test_another_guid_is_refused(tmp_path: Path) -> None:
    robot = robots.get("rv-2aj")
    hosted = Hosted(arm_model(robot), tmp_path)
    hosted.model = arm_model(robots.get("rv-4frl"))
    with pytest.raises(AssertionError, match="GUID"):
        hosted.run(["branch"], np.zeros((1, 1)), 0.01)


def test_an_axis_takes_as_long_as_the_simulation_of_a_program_says() -> None:
    robot = robots.get("rv-2aj")
    far, short = np.array([100.0, 0, 90.0, 90.0, 0]), np.array([5.0, 0, 90.0, 90.0, 0])
    for goal in (far, short):
        move = MoveJoints(
            JointValue(JointTarget(tuple(goal))), Motion(Speed(5000.0, joint=100.0), FINE)
        )
        program = Program("one", (Procedure("main", (move,)),))
        seconds = simulate(solve_program(program, robot)).seconds
        arm = ArmMotion.of(robot)
        arm.towards(goal)
        arm.step(seconds * 0.999)
        assert not np.array_equal(arm.joints, goal) and arm.joints == pytest.approx(goal, abs=0.01)
        arm.step(seconds * 0.001 + 1e-9)
        assert np.array_equal(arm.joints, goal)


def test_many_short_steps_are_one_long_one() -> None:
    robot = robots.get("irb1200-7-0.7")
    goals = [np.array([60.0, -30, 20, 90, 50, 170]), np.array([-20.0, 10, 0, -90, -50, 0])]
    long, short = (ArmMotion.of(robot, lag=0.08) for _ in range(2))
    for goal in goals:
        long.towards(goal)
        short.towards(goal)
        long.step(0.113)
        for _ in range(113):
            short.step(0.001)
        assert np.abs(long.joints - short.joints).max() < SAME
        assert np.abs(long.speed - short.speed).max() < 1e-7


def test_the_first_order_is_that_of_its_equation() -> None:
    """lag · joint' = motor - joint, by the trapezoidal rule in short steps."""
    robot, lag, step = robots.get("rv-2aj"), 0.06, 1e-4
    arm = ArmMotion.of(robot, lag=lag)
    arm.towards([40.0, 0, 90, 90, 0])
    joint = arm.joints[0]
    for _ in range(3_000):
        before = arm.at[0]
        arm.step(step)
        part = step / lag / 2.0
        joint = (joint * (1.0 - part) + part * (before + arm.at[0])) / (1.0 + part)
    assert 20.0 < arm.joints[0] < 39.5
    assert arm.joints[0] == pytest.approx(joint, abs=1e-4)


def test_no_step_is_faster_than_its_axis_allows() -> None:
    robot, step = robots.get("irb1200-7-0.7"), 0.004
    arm, rows = ArmMotion.of(robot), told(robot, 600)
    places, speeds = [arm.joints], [arm.speed]
    for row in rows:
        arm.towards(row[:6])
        arm.step(step)
        places.append(arm.joints)
        speeds.append(arm.speed)
    moved = np.abs(np.diff(places, axis=0)) / step
    assert (moved <= arm.drive.speeds * (1.0 + 1e-9)).all()
    assert (np.abs(np.diff(speeds, axis=0)) <= arm.drive.accelerations * step * (1.0 + 1e-9)).all()
    assert robot.inside(np.array(places)).all()
    assert (moved.max(axis=0) > 0.9 * arm.drive.speeds).any()
