"""Learning on arms of the catalogue, what cannot be learnt, and the two rivals."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest

from assistant import robots
from assistant.base import rotations
from assistant.base.diagnostics import Refused
from assistant.learning.experiments import (
    TOOL_POINTS,
    TOOL_TIP,
    CalibratedBaseline,
    baseline_errors,
    fit_rotations,
    five_joints,
    nearest_baseline,
    over_box,
    over_ranges,
    three_joints,
)
from assistant.learning.extended_map import try_targets
from assistant.learning.map_training import (
    TrainingPlan,
    draw_test_goals,
    measure_errors,
    measure_overrun,
    split_recording,
    start_map_with_shape,
    train_and_measure,
    train_map,
    train_recorded,
    usual_plan,
)
from assistant.learning.observed_arm import (
    InBox,
    check_box,
    check_ranges,
    observed_arm,
    pair_for,
    ranges_about_home,
    with_length,
)

RV2AJ = robots.get("rv-2aj")


def code(call, *arguments: object) -> str:
    with pytest.raises(Refused) as caught:
        call(*arguments)
    (finding,) = caught.value.findings
    return finding.code


def test_a_few_thousand_steps_teach_three_joints() -> None:
    made = three_joints()
    net = made.start(seed=1)
    plan = usual_plan(4000, seed=1, marks=(300,))
    early, late = train_and_measure(net, made.arm, made.space, plan)
    assert (early.steps, late.steps) == (304, 4000)
    assert late.mm < 3.0
    assert late.mm < 0.4 * early.mm
    assert np.isnan(late.degrees)


def test_the_same_seed_learns_the_same() -> None:
    made = three_joints()
    places = []
    for _ in range(2):
        net = made.start(seed=2)
        train_and_measure(net, made.arm, made.space, usual_plan(200, seed=2))
        places.append(net.places)
    assert np.array_equal(*places)


def test_limits_and_pictures_of_a_seen_arm_are_those_of_its_robot() -> None:
    made = five_joints()
    joints = np.random.default_rng(0).uniform(*made.ranges.T, (50, 5))
    points, turns = made.arm.tool(joints)
    flange, _ = RV2AJ.fk(joints)
    frames = rotations.to_matrix(turns)
    for i, point in enumerate(TOOL_POINTS[:2]):
        assert np.abs(points[:, i] - flange - frames @ np.array(point)).max() < 1e-9
    pixels = made.arm(joints).reshape(50, 2, 2, 2)
    for i in range(2):
        for k, camera in enumerate(made.arm.cameras):
            assert np.abs(pixels[:, i, k] - camera.project(points[:, i])).max() < 1e-9
    assert made.arm.task.seen == 8


def test_the_calibrated_pair_is_exact_without_noise() -> None:
    for made in (three_joints(), five_joints()):
        goals = made.space.draw(made.arm, 100, np.random.default_rng(7))
        found = baseline_errors(CalibratedBaseline(made.arm, made.ranges), made.arm, goals)
        assert found.coarse < 1e-6
        assert found.worst_mm < 1e-6


def test_the_calibrated_pair_solves_whole_poses_in_closed_form() -> None:
    made = over_box(
        observed_arm(robots.get("irb1200-5-0.9"), (), TOOL_POINTS),
        InBox(np.array([[400.0, 500.0], [-100.0, 100.0], [200.0, 300.0]]), "down", (-30.0, 30.0)),
    )
    goals = made.space.draw(made.arm, 100, np.random.default_rng(7))
    found = baseline_errors(CalibratedBaseline(made.arm, made.ranges), made.arm, goals)
    assert found.coarse < 1e-6
    assert found.worst_degrees < 1e-6
    axes = rotations.rotate(goals.turns, np.array([0.0, 0.0, 1.0]))
    assert np.abs(axes - [0.0, 0.0, -1.0]).max() < 1e-12


def test_the_calibrated_pair_corrects_a_link_that_is_longer() -> None:
    made = three_joints()
    arm = made.arm.longer("a2", 1.1)
    goals = made.space.draw(arm, 100, np.random.default_rng(7))
    found = baseline_errors(CalibratedBaseline(made.arm, made.ranges), arm, goals)
    assert found.coarse > 10.0
    assert found.mm < 0.2 * found.coarse


def test_planes_through_near_pictures_do_better_with_more_of_them() -> None:
    made = three_joints()
    joints = np.array([[-35.0, 35.0], [0.0, 70.0], [30.0, 110.0]])
    goals = made.space.draw(made.arm, 100, np.random.default_rng(7))
    few, many = (
        baseline_errors(nearest_baseline(made.arm, joints, count, goals), made.arm, goals).mm
        for count in (400, 8000)
    )
    assert many < few < 30.0


def test_rotations_are_fitted_to_points() -> None:
    draw = np.random.default_rng(6)
    turns = rotations.canonical(draw.normal(size=(20, 4)))
    points = np.array(TOOL_POINTS)
    found = rotations.rotate(turns[:, None], points) + draw.normal(size=(20, 1, 3))
    assert rotations.angle_between(fit_rotations(points, found), turns).max() < 1e-9


def test_what_cannot_be_learnt_is_refused() -> None:
    made = five_joints()
    one = replace(made.arm, points=made.arm.points[:1])
    assert code(start_map_with_shape, (4, 4, 4), one, made.space, made.ranges) == "LN009"
    for shape in ((), (4, 1), (300, 300), (2,) * 7):
        assert code(start_map_with_shape, shape, made.arm, made.space, made.ranges) == "LN010"
    aside = made.arm.watched(pair_for(np.array([[5e3, 5e3, 0.0], [5.1e3, 5e3, 1e2]])))
    assert code(start_map_with_shape, (4, 4, 4), aside, made.space, made.ranges) == "LN006"
    hidden = np.full((5, 8), np.nan)
    assert code(train_map, made.start(), made.arm, hidden, usual_plan(10)) == "LN006"
    ranges = made.ranges.copy()
    ranges[1] = [0.0, 121.0]
    assert code(check_ranges, RV2AJ, RV2AJ.axes, ranges) == "LN008"
    assert code(check_ranges, RV2AJ, RV2AJ.axes, ranges[:, ::-1]) == "LN008"
    assert code(check_box, np.array([[0.0, 1.0], [2.0, 1.0], [0.0, 1.0]])) == "LN015"
    assert code(check_box, np.array([[0.0, np.nan], [2.0, 1.0], [0.0, 1.0]])) == "LN015"
    assert code(observed_arm, RV2AJ, (), [TOOL_TIP], ("J1", "J4")) == "LN016"
    assert code(with_length, RV2AJ, "a1", 1.1) == "LN017"
    assert code(with_length, robots.get("rh-6frh5520"), "a2", 1.1) == "LN017"
    far = InBox(np.array([[800.0, 950.0], [-100.0, 100.0], [200.0, 300.0]]), "down", (-30.0, 30.0))
    assert (
        code(over_box, observed_arm(robots.get("irb1200-5-0.9"), (), TOOL_POINTS), far) == "LN007"
    )


@pytest.mark.parametrize("name", robots.names())
def test_every_arm_has_ranges_about_its_home(name: str) -> None:
    robot = robots.get(name)
    ranges = ranges_about_home(robot, robot.axes)
    assert check_ranges(robot, robot.axes, ranges) is ranges


def test_targets_that_are_hidden_are_passed_over() -> None:
    made = three_joints()
    net = made.start()
    targets = made.space.draw(made.arm, 64, np.random.default_rng(0)).pixels
    targets[::2] = np.nan
    train_map(net, made.arm, targets, TrainingPlan(100, usual_plan(100).cooling))
    assert net.steps == 100
    assert np.isfinite(net.places).all()


def test_one_point_in_two_cameras_moves_five_joints_of_a_free_arm() -> None:
    """Four numbers: the place is reached, and of all postures one near the middle of the ranges."""
    ranges = np.array([[-40.0, 40.0], [0.0, 40.0], [60.0, 100.0], [20.0, 60.0], [-30.0, 30.0]])
    arm = replace(observed_arm(RV2AJ, (), [(30.0, 0.0, 60.0)]), free=True)
    made = over_ranges(arm, ranges)
    assert made.arm.task.seen == 4 and made.dimensions == 3
    net = made.start(seed=1)
    tests = draw_test_goals(made.arm, made.space, 1)
    (*_, late) = train_and_measure(net, made.arm, made.space, usual_plan(5000, seed=1), tests)
    assert late.mm < 4.0 and np.isnan(late.degrees)
    beyond = measure_overrun(net, made.arm, tests)
    assert 0.0 < beyond.share < 0.2 and beyond.where.startswith("J")
    assert beyond.rest_mm < beyond.worst_mm == late.worst_mm
    joints = try_targets(net, made.arm, tests.pixels).fine
    middle, half = ranges.mean(axis=1), np.ptp(ranges, axis=1) / 2.0
    nearest = np.tile(middle, (len(joints), 1))
    for _ in range(40):  # the least squares of postures that hold the point, step by step
        here, _ = made.arm.tool(nearest)
        slopes = (
            np.stack(
                [
                    (made.arm.tool(nearest + step)[0] - here)[:, 0] / 1e-3
                    for step in 1e-3 * np.eye(5)
                ],
                axis=-1,
            )
            * half
        )
        inverse = np.linalg.pinv(slopes, rcond=1e-5)
        now = (nearest - middle) / half
        wanted = (tests.points - here)[:, 0] + np.einsum("mra,ma->mr", slopes, now)
        new = np.einsum("mar,mr->ma", inverse, wanted)
        nearest = middle + half * (now + 0.5 * (new - now))
    inside = (np.abs(nearest - middle) < half).all(axis=1)
    drawn = np.random.default_rng(0).uniform(*ranges.T, joints.shape)
    off = np.sqrt(((joints - nearest)[inside] ** 2).mean())
    assert inside.mean() > 0.8
    assert off < 0.4 * np.sqrt(((drawn - nearest)[inside] ** 2).mean())


def test_a_point_of_a_free_arm_must_tell_a_place() -> None:
    arm = replace(observed_arm(RV2AJ, (), [TOOL_TIP], ("J1",)), free=True)
    made = over_ranges(arm, np.array([[-40.0, 40.0]]))
    assert made.arm.task.determined == 1 and not made.arm.task.free
    still = replace(observed_arm(RV2AJ, (), [TOOL_TIP], ("J5", "J6")), free=True)
    assert code(over_ranges(still).start) == "LN009"


def test_recorded_moves_teach_five_joints() -> None:
    made = five_joints()
    ends = np.random.default_rng(0).uniform(*made.ranges.T, (80, 5))
    moves = [np.linspace(a, b, 25) for a, b in itertools.pairwise(ends)]
    rows, tests = split_recording(made.arm, np.concatenate(moves))
    net = start_map_with_shape((4, 5, 4, 4, 4), made.arm, made.space, made.ranges, 1)
    train_recorded(net, rows, made.arm(rows), usual_plan(4000, marks=()))
    found = measure_errors(net, made.arm, tests)
    assert found.mm < 2.0 and found.degrees < 1.0
    assert net.steps == 4000 and np.isfinite(net.missed[net.wins > 0]).all()
    assert code(split_recording, made.arm, np.concatenate(moves)[:50]) == "LN023"
    assert code(split_recording, made.arm, np.tile(ends[0], (500, 1))) == "LN023"
