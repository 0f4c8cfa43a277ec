"""Train a map: on targets that an arm tries, or on recorded joints and pictures.

Errors are measured on the way by goals that are not learnt from. Of a recording every row teaches
the unit nearest to its picture; a row with a near picture stands for the second movement of a
trial.
"""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats, Ints, evenly_spaced, norms
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Refused
from assistant.learning.extended_map import (
    JOINTS_OF_POINTS,
    ArmFunction,
    Cooling,
    ExtendedMap,
    LearningRates,
    apply_slopes,
    first_cooling,
    learn_trials,
    random_map,
    teach_units,
    try_targets,
)
from assistant.learning.observed_arm import Goals, ObservedArm, Space, point_slopes
from assistant.learning.proposals import RANGE_TOLERANCE
from assistant.learning.rules import BAD_LATTICE, FEW_POINTS, FEW_ROWS, TOOL_RARELY_SEEN

_TARGETS_AT_ONCE: Final = 16
"""Targets that are tried before their results are learnt: a computed arm gets all of them in one
call.
"""
_SCALE_SAMPLES: Final = 1000
"""Pictures by which a map that begins is scaled."""
TEST_GOALS: Final = 500
"""Goals by which errors are measured."""
_LEAST_SEEN_SHARE: Final = 0.5
"""Share of them that the cameras must see."""
_CHECKED_POSTURES: Final = 50
"""Places at which it is asked whether the seen points tell the joints."""
_LEAST_MM_PER_DEGREE: Final = 0.01
"""Mm a degree of what moves the seen points least."""
MOST_UNITS: Final = 50_000
_USUAL_LATTICES: Final[dict[int, tuple[int, ...]]] = {
    1: (30,),
    2: (16, 16),
    3: (7, 12, 4),
    4: (6, 7, 6, 4),
    5: (6, 8, 4, 4, 4),
    6: (4, 5, 4, 4, 4, 4),
}
"""Usual lattice by the count of numbers that describe a target; the one for three is from the
published experiment.
"""
MEASURED_STEPS: Final = (300, 1_000, 3_000, 6_000, 10_000, 20_000, 30_000, 40_000)
"""Steps at which errors are measured."""
_RANDOM_MOVEMENT: Final = 0.3
"""One sigma of the random movements of a free arm, in half ranges of the joints and widths of
learning: they show which joints move the picture."""


@dataclass(frozen=True, slots=True)
class MapErrors:
    """After so many steps, means and the worst: mm of the tool's first point, degrees of its whole
    orientation (NaN where only a place is wanted). pixels: seen, root mean square. coarse: mm of
    the coarse movement alone. seconds: spent on learning until then.
    """

    steps: int
    mm: float
    worst_mm: float
    degrees: float
    worst_degrees: float
    pixels: float
    coarse: float
    seconds: float = 0.0


@dataclass(frozen=True, slots=True)
class TrainingPlan:
    """steps: of the run. at_once: see `_TARGETS_AT_ONCE`. marks: steps of the map at which `watch`
    is called beside the last one. seed: of the targets.
    """

    steps: int
    cooling: Cooling
    at_once: int = _TARGETS_AT_ONCE
    marks: tuple[int, ...] = MEASURED_STEPS
    seed: int = 0


def start_map(
    arm: ObservedArm, space: Space, ranges: Floats, dimensions: int, seed: int = 0
) -> ExtendedMap:
    """A map that has learnt nothing, of the usual size for targets of so many dimensions."""
    return start_map_with_shape(_USUAL_LATTICES.get(dimensions, ()), arm, space, ranges, seed)


def start_map_with_shape(
    shape: tuple[int, ...], arm: ObservedArm, space: Space, ranges: Floats, seed: int = 0
) -> ExtendedMap:
    """The same on a lattice of this shape; raises Refused for what no map learns."""
    if not 1 <= len(shape) <= 6 or min(shape) < 2 or np.prod(shape) > MOST_UNITS:
        units = int(np.prod(shape))
        finding = BAD_LATTICE(units=units, dimensions=len(shape), most=MOST_UNITS)
        raise Refused(finding, exit_status=2)
    _check_determined(arm, ranges)
    sample = space.draw(arm, _SCALE_SAMPLES, np.random.default_rng(seed)).pixels
    sample = sample[np.isfinite(sample).all(axis=1)]
    if len(sample) < _LEAST_SEEN_SHARE * _SCALE_SAMPLES:
        raise Refused(TOOL_RARELY_SEEN(seen=len(sample), total=_SCALE_SAMPLES), exit_status=1)
    return random_map(arm.task, shape, sample, ranges, seed)


def _check_determined(arm: ObservedArm, ranges: Floats) -> None:
    """Raises Refused where some joints move without any of the points that are seen."""
    count, needed = len(arm.points), len(arm.moves)
    joints = np.random.default_rng(0).uniform(
        ranges[:, 0], ranges[:, 1], (_CHECKED_POSTURES, needed)
    )
    slopes = point_slopes(arm, joints)
    wanted = arm.task.determined if arm.free else needed
    least = np.linalg.svd(slopes, compute_uv=False)[:, wanted - 1 : wanted]
    if wanted > JOINTS_OF_POINTS.get(count, 6) or float(np.median(least)) < _LEAST_MM_PER_DEGREE:
        points = f"{count} point" if count == 1 else f"{count} points"
        raise Refused(FEW_POINTS(points=points, needed=needed), exit_status=2)


def train_map(
    net: ExtendedMap,
    arm: ArmFunction,
    targets: Floats,
    plan: TrainingPlan,
    watch: Callable[[float], None] = lambda _: None,
) -> float:
    """Learns from targets (m, d) pixels, round after round, until the steps of the plan are done.

    Targets that some camera does not see are passed over. `watch` is called with the seconds that
    were spent on learning, the arm and its pictures included, but not what it does itself. Gives
    them all. Raises Refused where none of the targets is seen.
    """
    there = targets[np.isfinite(targets).all(axis=1)]
    if not len(there):
        raise Refused(TOOL_RARELY_SEEN(seen=0, total=len(targets)), exit_status=1)
    done, spent = 0, 0.0
    draw = np.random.default_rng(plan.seed + 6)
    while done < plan.steps:
        began = time.perf_counter()
        rows = np.arange(done, min(done + plan.at_once, plan.steps)) % len(there)
        pace, before = plan.cooling.at(done), net.steps
        more = (
            draw.normal(0.0, _RANDOM_MOVEMENT * pace.answer_width, (len(rows), net.axes))
            if net.task.free
            else 0.0
        )
        learn_trials(net, there[rows], try_targets(net, arm, there[rows], more), pace)
        done += len(rows)
        spent += time.perf_counter() - began
        if done == plan.steps or any(before < mark <= net.steps for mark in plan.marks):
            watch(spent)
    return spent


def train_and_measure(
    net: ExtendedMap,
    arm: ObservedArm,
    space: Space,
    plan: TrainingPlan,
    tests: Goals | None = None,
    watch: Callable[[MapErrors], None] = lambda _: None,
) -> tuple[MapErrors, ...]:
    """Train with random goals, and measure the errors by the truth.

    tests: goals that measure the errors; random ones if None. watch: called with each of the errors
    that the function returns.
    """
    goals = space.draw(arm, plan.steps, np.random.default_rng(plan.seed + 1))
    asked = tests or draw_test_goals(arm, space, plan.seed)
    curve: list[MapErrors] = []

    def look(seconds: float) -> None:
        curve.append(measure_errors(net, arm, asked, seconds))
        watch(curve[-1])

    train_map(net, arm, goals.pixels, plan, look)
    return tuple(curve)


def draw_test_goals(arm: ObservedArm, space: Space, seed: int = 0) -> Goals:
    """500 goals that are not learnt from, as they are without noise; fewer where some are hidden.

    Raises Refused where all of them are.
    """
    goals = space.draw(arm.noisy(0.0), TEST_GOALS, np.random.default_rng(seed + 2))
    there = np.isfinite(goals.pixels).all(axis=1)
    if not there.any():
        raise Refused(TOOL_RARELY_SEEN(seen=0, total=TEST_GOALS), exit_status=1)
    turns = None if goals.turns is None else goals.turns[there]
    return Goals(goals.pixels[there], goals.points[there], turns)


def goals_with_noise(goals: Goals, noise: float, seed: int = 0) -> Goals:
    """The same goals as cameras with a noise of so many pixels see them."""
    draw = np.random.default_rng(seed + 4)
    return replace(goals, pixels=goals.pixels + draw.normal(0.0, noise, goals.pixels.shape))


def measure_errors(
    net: ExtendedMap, arm: ObservedArm, goals: Goals, seconds: float = 0.0
) -> MapErrors:
    """By the truth, after one coarse and one fine movement to each goal."""
    done = try_targets(net, arm, goals.pixels)
    points, turns = arm.tool(done.fine)
    off = norms(points[:, 0] - goals.points[:, 0])
    coarse = norms(arm.tool(done.coarse)[0][:, 0] - goals.points[:, 0])
    turned = np.array([np.nan])
    if goals.turns is not None:
        turned = rotations.angle_between(turns, goals.turns)
    pixels = np.sqrt(np.nanmean((done.fine_seen - goals.pixels) ** 2))
    means = float(off.mean()), float(off.max()), float(turned.mean()), float(turned.max())
    return MapErrors(net.steps, *means, float(pixels), float(coarse.mean()), seconds)


@dataclass(frozen=True, slots=True)
class RangeOverrun:
    """Goals for which one of both movements would leave the ranges of the joints.

    share: of all goals. worst_mm: of the first point there. rest_mm: the worst of all others.
    where: the axes that leave their ranges, with the ends, the most frequent first.
    """

    share: float
    worst_mm: float
    rest_mm: float
    where: str


def measure_overrun(net: ExtendedMap, arm: ObservedArm, goals: Goals) -> RangeOverrun:
    """By the truth, see `RangeOverrun`: the joint stays at its end, and the movement falls short.

    A free arm has many postures for a place. Targets are drawn inside the ranges, but the posture
    nearest to the middle may be outside of them: the lines of the map lead there.
    """
    done, scale = try_targets(net, arm, goals.pixels), net.scale
    slopes, wanted = net.slopes[done.winners], scale.pictures(goals.pixels)
    off = np.nan_to_num(wanted - scale.pictures(done.coarse_seen))
    first = net.angles[done.winners] + apply_slopes(slopes, wanted - net.places[done.winners])
    second = scale.angles(done.coarse) + apply_slopes(slopes, off)
    each = np.stack([scale.clipped(first), scale.clipped(second)]) / (scale.high - scale.low)
    over = np.where(np.abs(each[0]) > np.abs(each[1]), *each)
    left = np.abs(over).max(axis=1) > RANGE_TOLERANCE
    mm = norms(arm.tool(done.fine)[0][:, 0] - goals.points[:, 0])
    axes = np.abs(over[left]).argmax(axis=1)
    ends = Counter(
        f"{net.task.axes[axis]} {'above' if row[axis] > 0.0 else 'below'} "
        f"{(scale.high if row[axis] > 0.0 else scale.low)[axis]:g}"
        for axis, row in zip(axes, over[left], strict=True)
    )
    where = ", ".join(end for end, _ in ends.most_common(3))
    return RangeOverrun(
        float(left.mean()),
        float(mm[left].max(initial=0.0)),
        float(mm[~left].max(initial=0.0)),
        where,
    )


def usual_plan(
    steps: int, noise: float = 0.0, seed: int = 0, marks: Iterable[int] = MEASURED_STEPS
) -> TrainingPlan:
    """The plan of a map that begins."""
    return TrainingPlan(steps, first_cooling(steps, noise), marks=tuple(marks), seed=seed)


_FEWEST_RECORDED_ROWS: Final = 100
"""Fewest rows to learn from."""
_MOST_RECORDED_ROWS: Final = 3000
"""Most rows that are used, evenly chosen."""
_TEST_STRIDE: Final = 5
"""Every fifth row is kept to measure by, and not learnt from."""
_NEAR_PICTURES: Final = 24
"""Rows of the nearest pictures, one of which is the other movement of a row."""


def split_recording(arm: ObservedArm, joints: Floats) -> tuple[Floats, Goals]:
    """Divide recorded joints (n, a) into joints (m, a) to learn from and goals to measure by.

    Rows that repeat the one before them, of an arm that stands still, count once. Raises Refused
    for fewer than LEAST rows.
    """
    moved = np.append(True, (np.abs(np.diff(joints, axis=0)) > 0.0).any(axis=1))
    rows = joints[moved]
    if len(rows) < _FEWEST_RECORDED_ROWS:
        raise Refused(FEW_ROWS(count=len(rows), least=_FEWEST_RECORDED_ROWS), exit_status=1)
    rows = rows[np.asarray(evenly_spaced(len(rows), min(_MOST_RECORDED_ROWS, len(rows))))]
    kept = np.arange(len(rows)) % _TEST_STRIDE == 0
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
    picture A, as the two movements of a trial do. `watch`: see `train_map`.
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
    count = min(_NEAR_PICTURES, len(pictures) - 1)
    return np.asarray(np.argpartition(away, count - 1, axis=1)[:, :count])
