"""The rule of learning, beside the same in plain loops over plain numbers."""

from __future__ import annotations

import math

import numpy as np
import pytest

from assistant.base.arrays import Floats
from assistant.learning.extended_map import (
    LEAST_SHARE,
    ExtendedMap,
    LearningRates,
    MapTask,
    Neighbourhood,
    learn_trials,
    neighbour_pairs,
    random_map,
    try_targets,
)

SHAPE = (3, 4)
TASK = MapTask("plane", ("J1", "J2"), ("left", "right"), 1)
RANGES = np.array([[-90.0, 90.0], [0.0, 120.0]])


def plane(joints: Floats) -> Floats:
    """Two links in a plane, seen from two sides."""
    one, both = np.radians(joints[:, 0]), np.radians(joints.sum(axis=1))
    x, y = np.cos(one) + 0.8 * np.cos(both), np.sin(one) + 0.8 * np.sin(both)
    return 100.0 * np.stack([x, y, x + 0.3 * y, y - 0.2 * x], axis=1)


def net(shape: tuple[int, ...] = SHAPE) -> ExtendedMap:
    joints = np.random.default_rng(5).uniform(*RANGES.T, (200, 2))
    return random_map(TASK, shape, plane(joints), RANGES, seed=3)


def by_hand(one: ExtendedMap, target: Floats, pace: LearningRates) -> tuple[list, list]:
    """Places and answers after one target, in spreads, without any code of the map."""
    wanted = ((target - one.scale.middle) @ one.scale.frame).tolist()
    places = [row.tolist() for row in one.places]
    answers = [row.tolist() for row in one.answers]
    low, high = RANGES.T

    def joints_of(angles: list[float]) -> list[float]:
        wide = [(g * (h - b) + h + b) / 2 for g, b, h in zip(angles, low, high, strict=True)]
        return [min(max(v, b), h) for v, b, h in zip(wide, low, high, strict=True)]

    def angles_of(joints: list[float]) -> list[float]:
        return [(2 * v - h - b) / (h - b) for v, b, h in zip(joints, low, high, strict=True)]

    def seen(joints: list[float]) -> list[float]:
        return ((plane(np.array([joints]))[0] - one.scale.middle) @ one.scale.frame).tolist()

    def applied(answer: list[float], offset: list[float]) -> list[float]:
        return [sum(answer[2 + 4 * a + d] * offset[d] for d in range(4)) for a in range(2)]

    def minus(one: list[float], other: list[float]) -> list[float]:
        return [a - b for a, b in zip(one, other, strict=True)]

    def plus(one: list[float], other: list[float]) -> list[float]:
        return [a + b for a, b in zip(one, other, strict=True)]

    distances = [sum(v * v for v in minus(wanted, place)) for place in places]
    s = distances.index(min(distances))
    mine = list(answers[s])
    first = joints_of(plus(mine[:2], applied(mine, minus(wanted, places[s]))))
    v_first = seen(first)
    last = joints_of(plus(angles_of(first), applied(mine, minus(wanted, v_first))))
    v_last = seen(last)

    def share(r: int, width: float) -> float:
        rows = (r // 4 - s // 4) ** 2 + (r % 4 - s % 4) ** 2
        value = math.exp(-rows / (2 * width**2))
        return value if value >= LEAST_SHARE else 0.0

    for r, place in enumerate(places):
        step = [pace.place * share(r, pace.place_width) * v for v in minus(wanted, place)]
        answers[r][:2] = plus(answers[r][:2], applied(answers[r], step))
        places[r] = plus(place, step)
    moved, turned = minus(v_last, v_first), minus(angles_of(last), angles_of(first))
    now = answers[s]
    left = minus(turned, applied(now, moved))
    size = sum(v * v for v in moved)
    better = plus(now[:2], applied(now, minus(wanted, v_first)))
    better += [now[2 + 4 * a + d] + left[a] * moved[d] / size for a in range(2) for d in range(4)]
    for r, answer in enumerate(answers):
        part = pace.answer * share(r, pace.answer_width)
        answers[r] = [a + part * (b - a) for a, b in zip(answer, better, strict=True)]
    return places, answers


@pytest.mark.parametrize("width", [2.0, 0.6, 0.1])
def test_a_trial_changes_the_map_as_the_published_rule_says(width: float) -> None:
    one, pace = net(), LearningRates(0.4, width, 0.7, 0.8 * width)
    for target in plane(np.random.default_rng(8).uniform(*RANGES.T, (6, 2))):
        places, answers = by_hand(one, target, pace)
        learn_trials(one, target[None], try_targets(one, plane, target[None]), pace)
        assert np.abs(one.places - places).max() < 1e-9
        assert np.abs(one.answers - answers).max() < 1e-6


def test_targets_tried_together_teach_one_after_the_other() -> None:
    """Winners that differ and learn alone, by columns, and one of them twice."""
    targets = plane(np.random.default_rng(2).uniform(*RANGES.T, (5, 2)))
    for rows in (targets, np.concatenate([targets, targets[:1]])):
        together, alone = net(), net()
        pace = LearningRates(0.4, 0.1, 0.7, 0.1)
        done = try_targets(together, plane, rows)
        learn_trials(together, rows, done, pace)
        alone.learn_places(done.winners[:1], alone.scale.pictures(rows[:1]), pace)
        for at in range(1, len(rows)):
            winner = done.winners[at : at + 1]
            alone.learn_places(winner, alone.scale.pictures(rows[at : at + 1]), pace)
        assert np.abs(together.places - alone.places).max() < 1e-12
        assert together.wins.sum() == len(rows)


def test_a_trial_out_of_sight_teaches_only_where_targets_are() -> None:
    one = net()
    target = plane(np.array([[10.0, 60.0]]))
    places = one.places.copy()
    slopes = one.slopes.copy()
    blind = try_targets(one, lambda joints: np.full((len(joints), 4), np.nan), target)
    learn_trials(one, target, blind, LearningRates(0.4, 0.5, 0.7, 0.5))
    assert np.array_equal(one.slopes, slopes)
    assert not np.array_equal(one.places, places)
    assert np.isfinite(one.answers).all()
    assert not one.wins.any()


def test_a_neighbourhood_is_the_gaussian_around_each_unit() -> None:
    shape = (4, 5, 3)
    about = Neighbourhood(shape, 0.9)
    grid = np.stack(np.meshgrid(*map(np.arange, shape), indexing="ij"), axis=-1)
    for place in ((0, 0, 0), (2, 3, 1), (3, 4, 2)):
        whole = np.exp(-((grid - place) ** 2).sum(axis=-1) / (2 * 0.9**2))
        whole[whole < LEAST_SHARE] = 0.0
        box, shares = about.about(place)
        found = np.zeros(shape)
        found[box] = shares
        assert np.abs(found - whole).max() < 1e-15


def test_neighbours_of_a_lattice_are_paired_once() -> None:
    found = {tuple(pair) for pair in neighbour_pairs((2, 3)).tolist()}
    assert found == {(0, 1), (1, 2), (3, 4), (4, 5), (0, 3), (1, 4), (2, 5)}
