"""Learning from recordings: where an arm was, and what the cameras saw of it there."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Final

import numpy as np

from assistant.base.arrays import Floats, Ints, evenly_spaced
from assistant.base.diagnostics import Refused
from assistant.learning.maps.extended_map import ExtendedMap, LearningRates
from assistant.learning.maps.goals import Goals
from assistant.learning.maps.rules import FEW_ROWS
from assistant.learning.maps.seen_arm import ObservedArm
from assistant.learning.maps.training import TrainingPlan
from assistant.learning.maps.trials import apply_slopes, teach_units

FEWEST_RECORDED_ROWS: Final = 100
"""Fewest rows to learn from."""
MOST_RECORDED_ROWS: Final = 3000
"""Most rows that are used, evenly chosen."""
TEST_STRIDE: Final = 5
"""Every fifth row is kept to measure by, and not learnt from."""
NEAR_PICTURES: Final = 24
"""Rows of the nearest pictures, one of which is the other movement of a row."""


def split_recording(arm: ObservedArm, joints: Floats) -> tuple[Floats, Goals]:
    """Divide recorded joints (n, a) into joints (m, a) to learn from and goals to measure by.

    Rows that repeat the one before them, of an arm that stands still, count once. Raises Refused
    for fewer than LEAST rows.
    """
    moved = np.append(True, (np.abs(np.diff(joints, axis=0)) > 0.0).any(axis=1))
    rows = joints[moved]
    if len(rows) < FEWEST_RECORDED_ROWS:
        raise Refused(FEW_ROWS(count=len(rows), least=FEWEST_RECORDED_ROWS), exit_status=1)
    rows = rows[np.asarray(evenly_spaced(len(rows), min(MOST_RECORDED_ROWS, len(rows))))]
    kept = np.arange(len(rows)) % TEST_STRIDE == 0
    points, turns = arm.tool(rows[kept])
    pixels = arm.noisy(0.0).seen(points)
    there = np.isfinite(pixels).all(axis=1)
    goals = Goals(pixels[there], points[there], None if arm.free else turns[there])
    return rows[~kept], goals


def train_recorded(
    net: ExtendedMap,
    joints: Floats,
    pixels: Floats,
    plan: TrainingPlan,
    watch: Callable[[float], None] = lambda _: None,
) -> None:
    """Learn from joints (n, a) and the pixels (n, d) that the cameras saw there, row after row.

    Each row teaches θ of the unit that is nearest to its picture, and with another row of a near
    picture A, as the two movements of a trial do. `watch`: see `train`.
    """
    there = np.isfinite(pixels).all(axis=1)
    scale = net.scale
    pictures, angles = scale.pictures(pixels[there]), scale.angles(joints[there])
    near = _nearest_pictures(pictures)
    draw = np.random.default_rng(plan.seed + 7)
    done, spent = 0, 0.0
    while done < plan.steps:
        began = time.perf_counter()
        count = min(plan.at_once, plan.steps - done)
        rows = draw.integers(len(pictures), size=count)
        others = near[rows, draw.integers(near.shape[1], size=count)]
        before = net.steps
        _learn_rows(net, pictures, angles, rows, others, plan.cooling.at(done))
        done += count
        spent += time.perf_counter() - began
        if done == plan.steps or any(before < mark <= net.steps for mark in plan.marks):
            watch(spent)


def _learn_rows(
    net: ExtendedMap,
    pictures: Floats,
    angles: Floats,
    rows: Ints,
    others: Ints,
    pace: LearningRates,
) -> None:
    """Learn from rows (m,), each with another row (m,) as its second movement."""
    seen = pictures[rows]
    winners = net.winners(seen)
    net.learn_places(winners, seen, pace)
    net.steps += len(rows)
    slopes = net.slopes[winners]
    aside = apply_slopes(slopes, seen - net.places[winners])
    wrong = net.angles[winners] + aside - angles[rows]
    off = apply_slopes(np.asarray(np.linalg.pinv(slopes), dtype=np.float64), wrong)
    missed = np.sqrt(((net.scale.pixels(off) - net.scale.middle) ** 2).mean(axis=1))
    moved, turned = seen - pictures[others], angles[rows] - angles[others]
    teach_units(net, winners, angles[rows] - aside, turned, moved, missed, pace)


def _nearest_pictures(pictures: Floats) -> Ints:
    """Return the rows (n, k) of the nearest other pictures of each of (n, d)."""
    squares = (pictures**2).sum(axis=1)
    away = squares[:, None] + squares - 2.0 * pictures @ pictures.T
    np.fill_diagonal(away, np.inf)
    count = min(NEAR_PICTURES, len(pictures) - 1)
    return np.asarray(np.argpartition(away, count - 1, axis=1)[:, :count])
