"""Trajectories at the cycle of a controller: no step beyond the limits, the curve as it was."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from spatialmath import SE3

from assistant import robots
from assistant.base.diagnostics import Refused
from assistant.base.rotations import angle_between
from assistant.controllers.cyclic import ArmLimits, Limits, Trajectory, resampled
from assistant.program.motion import Kind, Path, Speed
from tests.examples import drawn

SPEEDS = (420.0, 336.0, 250.0, 540.0, 623.0, 720.0)
RISES = (1400.0, 1100.0, 800.0, 1800.0, 2000.0, 2400.0)
LIMITS = Limits(SPEEDS, RISES)
CYCLES = st.sampled_from([64 / 9000, 0.0035, 0.004])
angle = st.floats(-170.0, 170.0, allow_nan=False).map(lambda v: round(v, 3))
joints = st.lists(st.tuples(*[angle] * 6), min_size=1, max_size=12)


def largest(rows, cycle):
    """Speeds and accelerations, as parts of the limits, of an arm that rests before and after."""
    at_rest = np.concatenate([rows[:1], rows, rows[-1:]])
    speeds = np.abs(np.diff(rows, axis=0)) / cycle / SPEEDS
    rises = np.abs(np.diff(at_rest, 2, axis=0)) / cycle**2 / RISES
    return speeds.max(initial=0.0), rises.max(initial=0.0)


@settings(deadline=None, max_examples=drawn(60))
@given(joints, CYCLES, st.one_of(st.none(), st.floats(0.001, 5.0)))
def test_no_step_exceeds_a_limit(points, cycle, each):
    times = None if each is None else np.arange(len(points)) * each
    rows = resampled(Trajectory.of_joints(points, times, unit="deg"), LIMITS, cycle)
    assert max(largest(rows, cycle)) <= 1.0
    assert np.allclose(rows[0], points[0])
    assert np.allclose(rows[-1], points[-1])
    assert rows.min() >= np.min(points) - 1e-9
    assert rows.max() <= np.max(points) + 1e-9
    if each is not None:
        assert len(rows) >= np.ceil(times[-1] / cycle - 1e-6)


def test_a_trajectory_that_keeps_the_limits_keeps_its_times():
    times = np.linspace(0.0, 4.0, 401)
    soft = (1 - np.cos(np.pi * times / 4.0)) / 2
    rows = resampled(
        Trajectory.of_joints(np.outer(soft, [30, 20, 10, 5, 5, 60]), times, unit="deg"),
        LIMITS,
        0.004,
    )
    at = np.arange(len(rows)) * 0.004
    assert at[-1] == pytest.approx(4.0, abs=0.05)
    assert np.abs(np.interp(at, times, soft) - rows[:, 0] / 30).max() < 0.02


def test_the_curve_is_gone_through_in_its_shape():
    turn = np.linspace(0.0, 2 * np.pi, 120)
    circle = np.column_stack([40 * np.cos(turn), 40 * np.sin(turn)])
    rows = resampled(
        Trajectory.of_joints(circle, unit="deg"), Limits((400.0, 400.0), (900.0, 900.0)), 0.0035
    )
    assert np.hypot(*rows.T) == pytest.approx(40.0, abs=0.05)


def test_poses_keep_the_speed_of_the_tool_and_of_its_turning():
    positions = [[400, 0, 300], [400, 200, 300], [300, 200, 350]]
    quaternions = [[0, 1, 0, 0], [0, -1, -1, 0], [0.1, 1, 1, 0.3]]
    rows = resampled(
        Trajectory.of_poses(positions, quaternions),
        Limits((250.0, 90.0), (800.0, 400.0)),
        64 / 9000,
    )
    assert np.linalg.norm(rows[:, 3:], axis=1) == pytest.approx(1.0)
    step = np.linalg.norm(np.diff(rows[:, :3], axis=0), axis=1) * 9000 / 64
    turning = angle_between(rows[1:, 3:], rows[:-1, 3:]) * 9000 / 64
    assert 200 < step.max() <= 250
    assert 60 < turning.max() <= 90
    assert np.allclose(rows[-1, :3], positions[-1])


def test_the_joints_of_an_arm_bound_the_speed_of_its_tool():
    arm = robots.get("rv-4frl")
    start, turn = arm.fk(arm.home[None])
    branch = int(np.nanargmin(np.abs(arm.ik(start, turn)[0][0] - arm.home).max(axis=1)))

    def solved(rows):
        return arm.ik(rows[:, :3], rows[:, 3:])[0][:, branch]

    positions = start + np.array([[0, 0, 0], [0, 120, 40], [-30, -120, 40]])
    poses = Trajectory.of_poses(positions, np.repeat(turn, 3, axis=0))
    fast = Limits((2000.0, 400.0), (20000.0, 4000.0))
    slow = (15.0, 15.0, 15.0, 30.0, 30.0, 30.0)
    bounded = Limits(fast.speeds, fast.accelerations, arm=ArmLimits(solved, slow))
    assert (
        np.abs(np.diff(solved(resampled(poses, fast, 0.0035)), axis=0)) > np.array(slow) * 0.0035
    ).any()
    steps = np.abs(np.diff(solved(resampled(poses, bounded, 0.0035)), axis=0))
    assert (steps <= np.array(slow) * 0.0035).all()


def test_a_path_of_lines_has_the_speeds_of_its_tool():
    path = Path.of(
        "seam",
        [[400, 0, 300], [400, 0, 300], [400, 100, 300], [450, 100, 300]],
        [[0, 1, 0, 0]] * 4,
        speeds=[Speed(50.0), Speed(10.0)],
        speed=[0, 0, 0, 1],
    )
    trajectory = Trajectory.of_path(path)
    assert trajectory.times.tolist() == [0.0, 2.0, 7.0]
    assert trajectory.rows[:, :3].tolist() == [[400, 0, 300], [400, 100, 300], [450, 100, 300]]


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"kinds": [Kind.LINEAR, Kind.JOINT]}, "no straight lines"),
        ({"frames": ["table"]}, "frames of its own"),
        ({"tools": ["a", "b"], "tool": [0, 1]}, "several tools"),
        ({"speeds": [Speed(np.inf)]}, "no number of mm/s"),
        ({"external": [[1.0] * 6] * 2}, "external axes"),
    ],
)
def test_a_path_that_is_more_than_poses_is_refused(changed, said):
    columns = {"speeds": [Speed(50.0)], **changed}
    path = Path.of("seam", [[400, 0, 300], [400, 90, 300]], [[0, 1, 0, 0]] * 2, **columns)
    with pytest.raises(Refused, match=said):
        Trajectory.of_path(path)


def led(rows, times=None):
    return resampled(Trajectory("joints", rows, times), Limits((100.0,)), 0.004)


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: Trajectory.of_joints([], unit="deg"), "shape"),
        (lambda: Trajectory.of_joints([[1.0, np.nan]], unit="deg"), "not finite"),
        (lambda: Trajectory.of_joints([[1.0], [2.0]], [0.0, 0.0], unit="deg"), "do not rise"),
        (lambda: Trajectory.of_joints([[1.0], [2.0]], [0.0], unit="deg"), "times of shape"),
        (lambda: Trajectory.of_joints([[1.0], [2.0, 3.0]], unit="deg"), "cannot be followed"),
        (lambda: Trajectory.of_poses([[0, 0, 0]], [[0, 0, 0, 0]]), "quaternion is 0"),
        (lambda: Trajectory.of_poses([[0, 0, 0]], [[1, 0, 0, 0]] * 2), "quaternions"),
        (lambda: Trajectory.of_joints([[1.0], [2.0]], [0.0, 1e-300], unit="deg"), "do not rise"),
        (lambda: led(np.full((2, 1), np.nan)), "not finite"),
        (lambda: led(np.ones((2, 1)), np.array([0.0, np.nan])), "do not rise"),
    ],
)
def test_a_trajectory_that_is_none_is_refused(make, said):
    """However it is made."""
    with pytest.raises(Refused, match=said) as refused:
        make()
    assert [one.code for one in refused.value.findings] == ["CN701"]


def test_the_unit_of_joints_is_asked_for():
    arm, scara = robots.get("irb1200-7-0.7"), robots.get("rh-6frh5520")
    radians = np.radians([[0, 10, 20, 30, 40, 50], [1, 2, 3, 4, 5, 6]])
    led = Trajectory.of_joints(radians, unit="rad", robot=arm)
    assert led.rows == pytest.approx(np.degrees(radians))
    slides = Trajectory.of_joints([[0.1, 0.2, 0.05, 0.0]], unit="rad", robot=scara)
    assert slides.rows[0] == pytest.approx([*np.degrees([0.1, 0.2]), 50.0, 0.0, 0.0, 0.0])
    five = robots.get("rv-2aj")
    led = Trajectory.of_joints([[1, 2, 3, 5, 6]], unit="deg", robot=five)
    assert led.rows.tolist() == [[1, 2, 3, 0, 5, 6]]
    limits = Limits.of_robot(five, 50.0)
    assert len(limits.speeds) == 6 and limits.speeds[4] == 0.5 * five.speeds[3]
    for code, settings_of in (
        ("CN705", {}),
        ("CN705", {"unit": "grad"}),
        ("CN706", {"unit": "rad"}),
        ("CN701", {"unit": "deg", "robot": scara}),
    ):
        with pytest.raises(Refused) as refused:
            Trajectory.of_joints(radians, **settings_of)
        assert [one.code for one in refused.value.findings] == [code]


def test_poses_of_every_form_are_a_trajectory():
    poses = [SE3(0.4, 0.0, z) * SE3.Rx(180, "deg") for z in (0.3, 0.4)]
    led = Trajectory.of_poses(poses, unit="m")
    assert led.rows == pytest.approx(np.array([[400, 0, z, 0, 1, 0, 0] for z in (300, 400)]))
    with pytest.raises(Refused, match="TB445"):
        Trajectory.of_poses(poses)


@pytest.mark.parametrize(
    ("limits", "cycle", "code"),
    [
        (Limits((100.0,)), 0.004, "CN702"),
        (Limits((100.0, 0.0)), 0.004, "CN702"),
        (Limits((100.0, 90.0), (1.0,)), 0.004, "CN702"),
        (Limits((100.0, 90.0), lowest=(0.0,)), 0.004, "CN702"),
        (Limits((100.0, 90.0), lowest=(-9.0, -5.0)), 0.004, "CN701"),
        (Limits((100.0, 90.0), highest=(9.0, 5.0)), 0.004, "CN701"),
        (Limits((100.0, 90.0), highest=(9.0, float("nan"))), 0.004, "CN701"),
        (Limits((100.0, 90.0)), 0.0, "CN704"),
        (Limits((1e-9, 1e-9)), 0.004, "CN701"),
    ],
)
def test_limits_that_cannot_hold_are_refused(limits, cycle, code):
    with pytest.raises(Refused) as refused:
        resampled(Trajectory.of_joints([[0.0, -10.0], [1.0, 10.0]], unit="deg"), limits, cycle)
    assert [one.code for one in refused.value.findings] == [code]


@pytest.mark.parametrize("wrong", [1j, np.complex64(1), "one", None])
def test_what_is_no_real_number_is_refused(wrong):
    for rows, times in (([[0.0, wrong]], None), ([[0.0], [1.0]], [0.0, wrong])):
        with pytest.raises(Refused) as refused:
            Trajectory.of_joints(np.array(rows) if times is None else rows, times, unit="deg")
        assert [one.code for one in refused.value.findings] == ["CN701"]
