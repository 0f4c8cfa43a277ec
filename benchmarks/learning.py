"""What a learned map is worth beside what one would take today: `--only learning`.

One arm, one pair of cameras, the same targets: the map after so many steps; a calibrated pair of
cameras with the kinematics of the robot file; planes through the nearest of as many pictures as the
map has made movements. Each corrects once by what it sees.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence

from assistant.learning.experiments import (
    CalibratedBaseline,
    Experiment,
    baseline_errors,
    five_joints,
    nearest_baseline,
    three_joints,
)
from assistant.learning.map_training import (
    MapErrors,
    draw_test_goals,
    goals_with_noise,
    measure_errors,
    train_and_measure,
    usual_plan,
)
from assistant.learning.observed_arm import Goals

STEPS = (1_000, 10_000, 30_000)
NOISE = 0.2
"""Pixels, with which everything is measured a second time; nothing learns from it."""
EXPERIMENTS = {
    "RV-2AJ, 3 joints, a point seen by two cameras": three_joints,
    "RV-2AJ, 5 joints, two points seen by two cameras": five_joints,
}


def report(steps: Sequence[int] = STEPS) -> None:
    for title, experiment in EXPERIMENTS.items():
        made = experiment()
        tests = draw_test_goals(made.arm, made.space)
        print(f"\n{title}; targets within {tests.diagonal:.0f} mm\n")
        head = f"{'steps':>8}{'a second':>10}{'mean mm':>10}{'worst mm':>10}{'degrees':>10}"
        print(f"{'':<36}{head}{f'mm, {NOISE:g} px':>13}")
        for name, count, rate, found, noisy in rows(made, tests, steps):
            turn = "" if made.dimensions == 3 else f"{found.degrees:.3f}"
            shown = f"{found.mm:>10.3f}{found.worst_mm:>10.2f}{turn:>10}{noisy.mm:>13.3f}"
            print(f"{name:<36}{count:>8,}{rate:>10,.0f}{shown}", flush=True)


def rows(
    made: Experiment, tests: Goals, steps: Sequence[int]
) -> Iterator[tuple[str, int, float, MapErrors, MapErrors]]:
    """Name, steps or pictures, how many of them or of targets a second, errors without and with
    noise.
    """
    blurred, seen = made.arm.noisy(NOISE, 5), goals_with_noise(tests, NOISE)
    net = made.start()
    noisy: list[MapErrors] = []
    plan = usual_plan(max(steps), marks=steps)
    curve = train_and_measure(
        *(net, made.arm, made.space, plan, tests),
        watch=lambda _: noisy.append(measure_errors(net, blurred, seen)),
    )
    for found, worse in zip(curve, noisy, strict=True):
        yield "learned map, steps", found.steps, found.steps / found.seconds, found, worse
    calibrated = CalibratedBaseline(made.arm, made.ranges)
    rivals = [("calibrated pair, targets", len(tests.pixels), calibrated, 0.0)]
    for count in steps:
        began = time.perf_counter()
        nearest = nearest_baseline(made.arm, made.ranges, 2 * count, tests)
        rivals.append(
            ("nearest pictures, pictures", 2 * count, nearest, time.perf_counter() - began)
        )
    for name, count, rival, before in rivals:
        began = time.perf_counter()
        found = baseline_errors(rival, made.arm, tests)
        spent = before or time.perf_counter() - began
        yield name, count, count / spent, found, baseline_errors(rival, blurred, seen)


if __name__ == "__main__":
    report()
