"""Arms whose errors are known come back from measured poses, each as well as it is said to."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from assistant import robots
from assistant.base import rotations
from assistant.learning.arm_calibration import calibrate
from assistant.learning.calibration_output import corrected_files
from assistant.learning.measured_poses import measured_from_columns
from assistant.learning.parameter_fit import KnownPlacement
from assistant.program.geometry import IDENTITY
from tests.learning.calibration.truth import (
    NOMINAL,
    Truth,
    drawn,
    joints_of,
    points_of,
    quaternions_of,
)

ARMS = tuple(NOMINAL)
BOTH = [ARMS[0], pytest.param(ARMS[1], marks=pytest.mark.slow)]
NOISE = 0.05


def off(robot, truth):
    """Name of each correction of an arm → what it truly is, in mm or degrees."""
    zeros = dict(zip((f"{axis}.zero" for axis in robot.axes), truth.zeros, strict=False))
    return {**truth.lengths, **zeros}


def sigmas_off(done, truth):
    """By how many of its standard deviations each correction is wrong."""
    true = off(done.robot, truth)
    return {
        one.parameter.name: (one.value - true[one.parameter.name]) / one.sigma
        for one in done.corrections
    }


def codes(done):
    return [finding.code for finding in done.findings]


def chi_square(done, truth):
    """Square of what the corrections of the arm are wrong by, in what is told, a number each."""
    free = np.flatnonzero(done.fit.free)
    own = [i for i, at in enumerate(free) if at >= 12]
    true = off(done.robot, truth)
    wrong = np.array([one.value - true[one.parameter.name] for one in done.corrections])
    covariance = done.fit.covariance[np.ix_(own, own)]
    return wrong @ np.linalg.solve(covariance, wrong) / len(wrong)


@pytest.mark.parametrize("name", ARMS)
def test_forty_poses_tell_zeros_and_lengths(name, tell):
    robot, truth, joints = robots.get(name), drawn(name, 3), joints_of(name, 40, 3)
    done = calibrate(robot, measured_from_columns(joints, points_of(truth, joints, NOISE)))
    wrong = sigmas_off(done, truth)
    assert max(map(abs, wrong.values())) < 4.0
    assert done.before.point > 2.0
    assert done.out.point < 2.0 * NOISE * np.sqrt(3.0)
    assert done.noise[0] == pytest.approx(NOISE, rel=0.25)
    worst = max(wrong, key=lambda key: abs(wrong[key]))
    tell(
        f"calibration of {name}, 40 poses, {NOISE} mm: residual {done.before.point:.2f} mm before, "
        f"{done.after.point:.3f} after; held out {done.out_before.point:.2f} and "
        f"{done.out.point:.3f}; "
        f"{worst} is off most of {len(wrong)}, {abs(wrong[worst]):.1f} sigmas"
    )


@pytest.mark.parametrize("name", BOTH)
def test_what_only_sums_tell_is_held_and_said(name):
    robot, truth, joints = robots.get(name), drawn(name, 4), joints_of(name, 40, 4)
    done = calibrate(robot, measured_from_columns(joints, points_of(truth, joints)))
    said = {one.parameter.name: one for one in done.held}
    assert set(said) == {"d1", "d6", "J1.zero", "J6.zero"}
    assert said["d1"].reason == "1 mm of it looks like 1 mm of base.z"
    assert said["d6"].reason == "1 mm of it looks like 1 mm of tool.z"
    assert said["J1.zero"].reason == "1 deg of it looks like 1 deg of base.rz"
    assert codes(done).count("LN112") == 4


@pytest.mark.parametrize("name", BOTH)
def test_sums_are_told_apart_where_base_and_tool_are_known(name):
    robot, joints = robots.get(name), joints_of(name, 40, 5)
    tool = np.eye(4)
    tool[:3, 3] = (40.0, -25.0, 90.0)
    truth = replace(drawn(name, 5), base=np.eye(4), tool=tool)
    known = KnownPlacement(IDENTITY, (40.0, -25.0, 90.0))
    done = calibrate(robot, measured_from_columns(joints, points_of(truth, joints)), known=known)
    wrong = sigmas_off(done, truth)
    assert {"d1", "d6", "J1.zero", "J6.zero"} <= set(wrong)
    assert not done.held
    assert max(map(abs, wrong.values())) < 4.0


@pytest.mark.slow
@pytest.mark.parametrize("name", ARMS)
def test_the_base_and_the_tool_come_back(name):
    robot, joints = robots.get(name), joints_of(name, 60, 6)
    truth = replace(drawn(name, 6), lengths={}, zeros=np.zeros(6))
    poses = measured_from_columns(
        joints, points_of(truth, joints), quaternions_of(truth, joints, 0.01)
    )
    done = calibrate(robot, poses)
    for pose, true in ((done.base, truth.base), (done.tool, truth.tool)):
        turn = rotations.to_matrix(np.array(pose.quaternion))
        assert np.abs(np.array(pose.position) - true[:3, 3]).max() < 0.15
        assert np.abs(turn - true[:3, :3]).max() < 3e-4
    assert done.after.turn is not None
    assert done.after.turn < 0.03


@pytest.mark.parametrize("name", BOTH)
def test_rows_that_do_not_fit_are_told_and_left_out(name):
    robot, truth, joints = robots.get(name), drawn(name, 7), joints_of(name, 40, 7)
    points = points_of(truth, joints)
    points[4] += (1.0, 0.0, 0.0)
    points[11] += (0.0, -3.0, 20.0)
    points[30] = (0.0, 5000.0, 0.0)
    done = calibrate(robot, measured_from_columns(joints, points))
    assert np.flatnonzero(~done.fit.used).tolist() == [4, 11, 30]
    told = [one.message for one in done.findings if one.code == "LN110"]
    assert [text.split()[1] for text in told] == ["5", "12", "31"]
    assert max(map(abs, sigmas_off(done, truth).values())) < 4.0


@pytest.mark.parametrize("name", BOTH)
def test_axes_that_are_not_parallel_are_told_and_a_chain_has_them(name, tell):
    robot, joints = robots.get(name), joints_of(name, 60, 8)
    truth = drawn(name, 8, tilts=0.2)
    poses = measured_from_columns(joints, points_of(truth, joints, NOISE))
    plain = calibrate(robot, poses)
    assert "LN116" in codes(plain)
    chain = calibrate(robot, poses, estimate="chain")
    assert chain.out.point < 2.0 * NOISE * np.sqrt(3.0)
    assert chain.out.point < 0.6 * plain.out.point
    tell(
        f"axes of {name} tilted by up to 0.2 degrees: held out {plain.out.point:.3f} mm with "
        f"lengths, {chain.out.point:.3f} mm with a chain"
    )


@pytest.mark.parametrize(
    "estimate", ["lengths", "chain", pytest.param("zeros", marks=pytest.mark.slow)]
)
@pytest.mark.parametrize("name", BOTH)
def test_the_corrected_file_reads_back_and_agrees_with_the_true_arm(name, estimate, tmp_path):
    robot, joints = robots.get(name), joints_of(name, 60, 9)
    truth = drawn(name, 9, tilts=0.1 if estimate == "chain" else 0.0)
    if estimate == "zeros":
        truth = replace(truth, lengths={})
    done = calibrate(
        robot, measured_from_columns(joints, points_of(truth, joints)), estimate=estimate
    )
    for file, data in corrected_files(done, "mine").items():
        (tmp_path / file).write_bytes(data)
    corrected = robots.load(tmp_path / "mine.toml")
    assert corrected.limits == pytest.approx(robot.limits)
    other = joints_of(name, 200, 10)
    p, q = corrected.fk(other)
    told, turns = done.fit.problem.model.flange(other, done.fit.state.values)
    assert np.abs(p - told).max() < 1e-6
    assert np.abs(rotations.to_matrix(q) - turns).max() < 1e-8
    tips = done.base.moved(p + rotations.rotate(q, np.array(done.tool.position)))
    assert np.linalg.norm(tips - truth.measured(other)[:, :3, 3], axis=1).max() < 0.2


def test_a_scara_has_its_two_lengths_corrected():
    robot, random = robots.get("rh-6frh5520"), np.random.default_rng(1)
    low, high = robot.limits.T
    joints = random.uniform(low * 0.9 + high * 0.1, high * 0.9 + low * 0.1, (40, 4))
    l1, l2 = robot.arm.l1 + 0.8, robot.arm.l2 - 1.1
    first, second = np.radians(joints[:, 0] + robot.zero[0]), np.radians(joints[:, 1] + 0.3)
    second = second + np.radians(robot.zero[1])
    x = l1 * np.cos(first) + l2 * np.cos(first + second)
    y = l1 * np.sin(first) + l2 * np.sin(first + second)
    z = robot.fk(joints)[0][:, 2]
    points = np.stack([x, y, z], axis=1) + random.normal(0.0, NOISE, (40, 3))
    done = calibrate(
        robot, measured_from_columns(joints, points), known=KnownPlacement(tool=(0.0, 0.0, 0.0))
    )
    found = {one.parameter.name: one for one in done.corrections}
    for name, true in {"l1": 0.8, "l2": -1.1, "J2.zero": 0.3}.items():
        assert abs(found[name].value - true) < 4.0 * found[name].sigma


def test_few_poses_for_many_parameters_are_seen_by_those_held_out():
    robot, truth, joints = robots.get("rv-2aj"), drawn("rv-2aj", 2), joints_of("rv-2aj", 13, 2)
    done = calibrate(
        robot, measured_from_columns(joints, points_of(truth, joints)), estimate="chain"
    )
    assert "LN114" in codes(done)
    assert done.out.point > 2.0 * done.after.point


def test_poses_that_were_measured_several_times_do_not_stand_for_others():
    """What is held out is no second look at a pose of the fit."""
    robot, truth, joints = robots.get("rv-2aj"), drawn("rv-2aj", 2), joints_of("rv-2aj", 10, 2)
    again = np.repeat(joints, 4, axis=0)
    again += np.random.default_rng(3).uniform(-0.02, 0.02, again.shape)
    done = calibrate(robot, measured_from_columns(again, points_of(truth, again)), estimate="chain")
    assert "LN114" in codes(done)
    assert done.out.point > 2.0 * done.after.point


def test_an_arm_without_errors_is_not_made_better():
    robot, joints = robots.get("rv-2aj"), joints_of("rv-2aj", 40, 1)
    done = calibrate(robot, measured_from_columns(joints, points_of(Truth("rv-2aj"), joints, 0.3)))
    assert "LN115" in codes(done)


def test_an_axis_that_stands_still_is_told_with_what_it_hides():
    robot, truth, joints = robots.get("irb1200-5-0.9"), drawn("irb1200-5-0.9", 3), None
    joints = joints_of("irb1200-5-0.9", 40, 3)
    joints[:, 3:] = (10.0, 40.0, 20.0)
    done = calibrate(robot, measured_from_columns(joints, points_of(truth, joints)))
    assert "LN105" in codes(done)
    assert {"d4", "J4.zero", "J5.zero"} <= {one.parameter.name for one in done.held}


def test_noise_that_is_stated_is_compared_with_the_residual():
    robot, truth, joints = robots.get("rv-2aj"), drawn("rv-2aj", 3), joints_of("rv-2aj", 40, 3)
    poses = measured_from_columns(joints, points_of(truth, joints, 0.2))
    assert "LN120" in codes(calibrate(robot, poses, noise=0.05))
    assert "LN120" not in codes(calibrate(robot, poses, noise=0.2))


def test_zeros_that_are_lost_by_far_are_told_as_too_large():
    robot, joints = robots.get("rv-2aj"), joints_of("rv-2aj", 40, 3)
    truth = Truth("rv-2aj", zeros=np.array([0.0, 0.0, 9.0, 0.0, 0.0, 0.0]))
    done = calibrate(robot, measured_from_columns(joints, points_of(truth, joints)))
    assert "LN113" in codes(done)
    (found,) = (one.value for one in done.corrections if one.parameter.name == "J3.zero")
    assert found == pytest.approx(9.0, abs=0.05)


@pytest.mark.slow
@pytest.mark.parametrize("turns", [False, True])
@pytest.mark.parametrize("name", ARMS)
def test_standard_deviations_are_honest_over_a_hundred_arms(name, turns, tell):
    robot, squares, wrong = robots.get(name), [], []
    for seed in range(100):
        truth, joints = drawn(name, seed), joints_of(name, 40, 1000 + seed)
        points = points_of(truth, joints, NOISE, 2000 + seed)
        quaternions = quaternions_of(truth, joints, 0.02, 3000 + seed) if turns else None
        done = calibrate(robot, measured_from_columns(joints, points, quaternions))
        squares.append(chi_square(done, truth))
        wrong += sigmas_off(done, truth).values()
    mean, spread = float(np.mean(squares)), float(np.std(wrong))
    tell(
        f"100 arms like {name}{' with turns' * turns}: chi-square {mean:.3f} a parameter, errors "
        f"of {spread:.3f} sigmas, {np.mean(np.abs(wrong) < 2.0):.1%} within two, worst "
        f"{np.abs(wrong).max():.1f}"
    )
    assert 0.85 < mean < 1.2
    assert 0.92 < spread < 1.1
    assert np.abs(wrong).max() < 5.0
