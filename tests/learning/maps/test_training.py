"""Whole trainings: what a map comes to on the arms of the experiments, and after a link changes."""

from __future__ import annotations

import numpy as np
import pytest

from assistant.learning.experiments import five_joints, six_joints, three_joints
from assistant.learning.map_training import (
    draw_test_goals,
    goals_with_noise,
    measure_errors,
    train_and_measure,
    usual_plan,
)

NOISE = 0.2
MARKS = (1_000, 3_000, 10_000, 20_000, 30_000)


def told(name, made, steps, tell):
    """Errors after all steps; the curve is told, with those of noisy pictures beside them."""
    net, tests = made.start(), draw_test_goals(made.arm, made.space)
    curve = train_and_measure(net, made.arm, made.space, usual_plan(steps, marks=MARKS), tests)
    noisy = measure_errors(net, made.arm.noisy(NOISE, 5), goals_with_noise(tests, NOISE))
    for one in (*curve, noisy):
        turns = "" if np.isnan(one.degrees) else f", {one.degrees:.3f} and {one.worst_degrees:.2f}"
        seen = f" with {NOISE:g} px of noise" if one is noisy else ""
        tell(
            f"{name} after {one.steps:,} steps{seen}: {one.mm:.3f} mm in the mean, "
            f"{one.worst_mm:.2f} at worst ({100 * one.mm / tests.diagonal:.3f}% of the "
            f"workspace){turns and turns + ' degrees'}"
        )
    return net, tests, curve[-1]


@pytest.mark.slow
def test_three_joints_are_learnt_in_30_000_steps_and_again_when_a_link_is_longer(tell) -> None:
    made = three_joints()
    net, tests, found = told("three joints", made, 30_000, tell)
    assert found.mm <= 0.0005 * tests.diagonal

    longer = made.arm.longer("a2", 1.1)
    asked = draw_test_goals(longer, made.space)
    first = measure_errors(net, longer, asked)
    again = train_and_measure(net, longer, made.space, usual_plan(10_000), asked)[-1]
    tell(
        f"a link 10% longer: {first.mm:.2f} mm ({first.coarse:.1f} mm before the correction), "
        f"{again.mm:.3f} mm ({again.coarse:.2f}) after {again.steps - first.steps:,} steps more"
    )
    assert again.mm < 0.1 * first.mm and again.mm <= 0.001 * tests.diagonal


@pytest.mark.slow
def test_all_joints_of_an_arm_of_five_axes_are_learnt_in_40_000_steps(tell) -> None:
    _, _, found = told("five joints", five_joints(), 40_000, tell)
    assert found.mm <= 1.0 and found.degrees <= 0.5


@pytest.mark.slow
def test_an_arm_of_six_axes_learns_a_tool_that_is_held_by_a_rule(tell) -> None:
    _, tests, found = told("six joints, tool down", six_joints(), 40_000, tell)
    assert found.mm <= 0.005 * tests.diagonal and found.degrees <= 0.5
