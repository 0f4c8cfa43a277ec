"""Trials: a target is shown, the arm moves twice, and the map learns from what was seen."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np

from assistant.base.arrays import Floats, Rows
from assistant.base.diagnostics import Refused
from assistant.learning.maps.extended_map import ExtendedMap, LearningRates
from assistant.learning.maps.rules import BAD_PICTURE_SHAPE

ArmFunction = Callable[[Floats], Floats]
"""Joints (n, a) to which an arm is moved one after the other → pixels (n, d) at which its tool is
seen there; a row that some camera does not see holds NaN."""
NEWEST_SHARE: Final = 0.1
"""Share of the newest trial in what a unit misses by."""


@dataclass(frozen=True, slots=True, eq=False)
class Trials:
    """What became of m targets: winners (m,), joints (m, a) and pixels (m, d) of both movements."""

    winners: Rows
    coarse: Floats
    coarse_seen: Floats
    fine: Floats
    fine_seen: Floats


def try_targets(
    net: ExtendedMap, arm: ArmFunction, targets: Floats, more: Floats | float = 0.0
) -> Trials:
    """Move the arm to targets (m, d) pixels, each by a coarse and a fine movement.

    more: (m, a) in angles of the map, added to the fine movements of an arm that tries others.
    Where the arm is out of sight after the coarse one it stays. Raises Refused for an arm that does
    not answer pixels (m, d).
    """
    scale = net.scale
    wanted = scale.pictures(targets)
    winners = net.winners(wanted)
    slopes = net.slopes[winners]
    coarse = scale.joints(net.angles[winners] + apply_slopes(slopes, wanted - net.places[winners]))
    coarse_seen = observe_arm(arm, coarse, targets.shape[1])
    off = np.nan_to_num(wanted - scale.pictures(coarse_seen))
    fine = scale.joints(scale.angles(coarse) + apply_slopes(slopes, off) + more)
    return Trials(winners, coarse, coarse_seen, fine, observe_arm(arm, fine, targets.shape[1]))


def learn_trials(net: ExtendedMap, targets: Floats, done: Trials, pace: LearningRates) -> None:
    """Learns from trials; from those that were out of sight only where targets are."""
    scale, winners = net.scale, done.winners
    wanted = scale.pictures(targets)
    net.learn_places(winners, wanted, pace)
    net.steps += len(winners)
    there = np.isfinite(done.coarse_seen).all(axis=1) & np.isfinite(done.fine_seen).all(axis=1)
    wanted, winners = wanted[there], winners[there]
    first, last = scale.pictures(done.coarse_seen[there]), scale.pictures(done.fine_seen[there])
    slopes, moved = net.slopes[winners], last - first
    turned = scale.angles(done.fine[there]) - scale.angles(done.coarse[there])
    angles = net.angles[winners] + apply_slopes(slopes, wanted - first)
    if net.task.free:
        pull = _null_motion(slopes, -net.angles[winners], net.task.determined)
        angles += POSTURE_PULL * pace.answer_width * pull
    missed = np.sqrt(((targets[there] - done.fine_seen[there]) ** 2).mean(axis=1))
    teach_units(net, winners, angles, turned, moved, missed, pace)


def teach_units(
    net: ExtendedMap,
    winners: Rows,
    angles: Floats,
    turned: Floats,
    moved: Floats,
    missed: Floats,
    pace: LearningRates,
) -> None:
    """Teach the units (m,) that won what their answers are.

    angles: (m, a) that θ becomes. turned, moved: a movement of the joints (m, a) and of the picture
    (m, d), by which A is corrected. missed: (m,) pixels by which the answers so far are off.
    """
    slopes, axes = net.slopes[winners], net.axes
    size = np.einsum("md,md->m", moved, moved) + max(
        (pace.noise * net.scale.pixel) ** 2, UNSEEN_MOVEMENT
    )
    wrong = (turned - apply_slopes(slopes, moved)) / size[:, None]
    right = slopes + wrong[:, :, None] * moved[:, None, :]
    corrected = right.reshape(len(winners), net.answers.shape[1] - axes)
    better = np.concatenate([angles, corrected], axis=1)
    net.learn_answers(winners, better, pace)
    before = net.missed[winners]
    lately = np.where(np.isfinite(before), before + NEWEST_SHARE * (missed - before), missed)
    net.missed[winners] = lately
    np.add.at(net.wins, winners, 1.0)


POSTURE_PULL: Final = 0.1
"""Share of the way to its preferred posture, times the width of learning, that a free arm takes in
each trial."""


def _null_motion(slopes: Floats, angles: Floats, count: int) -> Floats:
    """Return the part of angles (m, a) that does not change the picture.

    slopes: (m, a, d), whose `count` strongest directions matter: where A is the pseudoinverse of
    the Jacobian of the picture, all visible movements are among these.
    """
    strong = np.linalg.svd(slopes, full_matrices=False)[0][:, :, :count]
    seen = np.einsum("mat,mt->ma", strong, np.einsum("mat,ma->mt", strong, angles))
    return np.asarray(angles - seen)


UNSEEN_MOVEMENT: Final = 1e-12
"""Of squares of spreads: a movement that is no longer seen."""


def observe_arm(arm: ArmFunction, joints: Floats, count: int) -> Floats:
    """What an arm is seen at; raises Refused if that are no pixels (m, count)."""
    seen = np.asarray(arm(joints), dtype=np.float64)
    if seen.shape != (len(joints), count):
        raise Refused(
            BAD_PICTURE_SHAPE(shape=seen.shape, wanted=(len(joints), count)), exit_status=2
        )
    return seen


def apply_slopes(slopes: Floats, offsets: Floats) -> Floats:
    """(m, a, d) times (m, d)."""
    return np.asarray(np.matmul(slopes, offsets[..., None])[..., 0])
