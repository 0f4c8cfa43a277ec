"""Learning from recordings: where an arm was, and what the cameras saw of it there."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Final

import numpy as np

from assistant.learning.maps.extended_map import ExtendedMap, Pace
from assistant.learning.maps.goals import Goals
from assistant.learning.maps.rules import FEW_ROWS
from assistant.learning.maps.seen_arm import SeenArm
from assistant.learning.maps.training import Plan
from assistant.learning.maps.trials import LATELY, TINY, times
from assistant.program.arrays import Floats, Ints, evenly
from assistant.program.diagnostics import Refused

LEAST: Final = 100
"""Rows that tell anything of the joints."""
MOST: Final = 3000
"""Rows that are learnt from, evenly chosen."""
TESTED: Final = 5
"""Each so many-th row is kept to measure by, and not learnt from."""
NEAR: Final = 24
"""Rows of the nearest pictures, one of which is the other movement of a row."""


def split(arm: SeenArm, joints: Floats) -> tuple[Floats, Goals]:
    """Joints (m, a) to learn from, and goals to measure by, of recorded joints (n, a).

    Rows that repeat the one before them, as of an arm that stands, count once. Raises Refused for
    too few.
    """
    moved = np.append(True, (np.abs(np.diff(joints, axis=0)) > 0.0).any(axis=1))
    rows = joints[moved]
    if len(rows) < LEAST:
        raise Refused(FEW_ROWS(count=len(rows), least=LEAST), exit_status=1)
    rows = rows[np.asarray(evenly(len(rows), min(MOST, len(rows))))]
    kept = np.arange(len(rows)) % TESTED == 0
    points, turns = arm.tool(rows[kept])
    pixels = arm.noisy(0.0).seen(points)
    there = np.isfinite(pixels).all(axis=1)
    goals = Goals(pixels[there], points[there], None if arm.free else turns[there])
    return rows[~kept], goals


def train_recorded(
    net: ExtendedMap,
    joints: Floats,
    pixels: Floats,
    plan: Plan,
    watch: Callable[[float], None] = lambda _: None,
) -> None:
    """Learns from joints (n, a) and the pixels (n, d) that the cameras saw there, row after row.

    Each row tells θ of the unit that its picture is nearest to, and with another row of a near
    picture A, as the two movements of a trial do. `watch`: see `train`.
    """
    there = np.isfinite(pixels).all(axis=1)
    scale = net.scale
    pictures, angles = scale.pictures(pixels[there]), scale.angles(joints[there])
    near = _nearest(pictures)
    draw = np.random.default_rng(plan.seed + 7)
    done, spent = 0, 0.0
    while done < plan.steps:
        began = time.perf_counter()
        count = min(plan.at_once, plan.steps - done)
        rows = draw.integers(len(pictures), size=count)
        others = near[rows, draw.integers(near.shape[1], size=count)]
        before = net.steps
        _learn(net, pictures, angles, rows, others, plan.cooling.at(done))
        done += count
        spent += time.perf_counter() - began
        if done == plan.steps or any(before < mark <= net.steps for mark in plan.marks):
            watch(spent)


def _learn(
    net: ExtendedMap,
    pictures: Floats,
    angles: Floats,
    rows: Ints,
    others: Ints,
    pace: Pace,
) -> None:
    seen, axes = pictures[rows], net.axes
    winners = net.winners(seen)
    net.learn_places(winners, seen, pace)
    net.steps += len(rows)
    slopes = net.slopes[winners]
    answered = net.angles[winners] + times(slopes, seen - net.places[winners])
    moved, turned = seen - pictures[others], angles[rows] - angles[others]
    size = np.einsum("md,md->m", moved, moved) + max((pace.noise * net.scale.pixel) ** 2, TINY)
    wrong = (turned - times(slopes, moved)) / size[:, None]
    better = np.empty((len(rows), net.answers.shape[1]))
    better[:, :axes] = angles[rows] - times(slopes, seen - net.places[winners])
    right = slopes + wrong[:, :, None] * moved[:, None, :]
    better[:, axes:] = right.reshape(better[:, axes:].shape)
    net.learn_answers(winners, better, pace)
    off = times(np.asarray(np.linalg.pinv(slopes), dtype=np.float64), answered - angles[rows])
    missed = np.sqrt((net.scale.pixels(off) - net.scale.pixels(0.0 * off)) ** 2).mean(axis=1)
    before = net.missed[winners]
    net.missed[winners] = np.where(np.isfinite(before), before + LATELY * (missed - before), missed)
    np.add.at(net.wins, winners, 1.0)


def _nearest(pictures: Floats) -> Ints:
    """(n, k) the rows of the nearest other pictures."""
    squares = (pictures**2).sum(axis=1)
    away = squares[:, None] + squares - 2.0 * pictures @ pictures.T
    np.fill_diagonal(away, np.inf)
    count = min(NEAR, len(pictures) - 1)
    return np.asarray(np.argpartition(away, count - 1, axis=1)[:, :count])
