"""What the arm does between the targets of linear and circular moves.

The angles at both ends of a move do not tell how often an axis turned on the way, nor
whether the way leaves the reach of the arm; poses on it do.
"""

from __future__ import annotations

import numpy as np

from assistant.base.arrays import Floats, Ints, Rows, Singles, Truths
from assistant.robots.motion.densities import TurnSampling
from assistant.robots.motion.on_the_way import MoveSampler
from assistant.robots.motion.run import Run
from assistant.robots.motion.ways import MotionBetweenTargets
from assistant.robots.motion.wrist import (
    EVEN,
    WRIST_PAIRS,
    bends_to,
    may_pass_through,
    passes_through,
)
from assistant.robots.robot import CHUNK, Robot


def motion_between_targets(
    run: Run, robot: Robot, joints: Floats, branch: Rows
) -> MotionBetweenTargets:
    """Looks at the linear and circular moves of a run whose joints (n, a) deg are up to whole
    turns.

    branch: (n,) of each row, -1 where there is none.
    """
    look = MoveSampler(run, robot, joints)
    axes = len(robot.axes)
    parts = [MotionBetweenTargets(np.empty(0, np.intp), *_empty_columns(axes), np.empty(0), ())]
    for rows, samples in look.rows(branch):
        one = int(branch[rows[0]])
        part = np.arange(1, samples + 1) / (samples + 1)
        way = look.way(rows, part, one)
        fine = way.doubtful(robot) & robot.arm.named
        parts.append(look.seen(rows[~fine], way.of(~fine)))
        dense = np.arange(1, TurnSampling.FINE) / TurnSampling.FINE
        many = max(CHUNK // TurnSampling.FINE, 1)
        for start in range(0, int(fine.sum()), many):
            at = rows[fine][start : start + many]
            way = look.way(at, dense, one)
            leaping = np.asarray(way.leaps().any(axis=1))
            looked = [(at[~leaping], dense, way.of(~leaping))]
            looked += [look.closer(at[i : i + 1], dense, one) for i in np.flatnonzero(leaping)]
            for some, part, way in looked:
                seen = look.seen(some, way)
                look.peaks(part, way, one, seen)
                parts.append(seen)
    out = MotionBetweenTargets(
        np.concatenate([each.rows for each in parts]),
        np.concatenate([each.winding for each in parts]),
        np.concatenate([each.below for each in parts]),
        np.concatenate([each.above for each in parts]),
        np.concatenate([each.short for each in parts]),
        tuple(jump for each in parts for jump in each.jumps),
    )
    out.winding[out.rows == 0] = 0  # the whole run starts with the turns that suit it best
    return out


def _empty_columns(axes: int) -> tuple[Ints, Floats, Floats]:
    return np.empty((0, axes), np.int64), np.empty((0, axes)), np.empty((0, axes))


def confirmed_crossings(run: Run, robot: Robot, bends: Singles, crossed: Truths) -> Truths:
    """Which moves go through the singularity of the wrist (4, n), of those that do by their ends.

    bends: see `wrist.directions`. Where the ends are far apart, poses between them tell.
    """
    out = crossed.copy()
    apart = np.hypot(*np.diff(bends, axis=2, prepend=bends[:, :, :1]).swapaxes(0, 1)) > EVEN
    look = MoveSampler(run, robot, np.empty((0, len(robot.axes))))
    rows = np.flatnonzero(crossed.any(axis=0) & look.same)
    rows = rows[rows > 0]
    apart[:, rows] |= look.far(rows)
    rows = rows[(crossed & apart)[:, rows].any(axis=0)]
    part = np.arange(1, TurnSampling.FINE) / TurnSampling.FINE
    for start in range(0, len(rows), max(CHUNK // TurnSampling.FINE, 1)):
        here = rows[start : start + max(CHUNK // TurnSampling.FINE, 1)]
        for pair in range(WRIST_PAIRS):
            every = np.broadcast_to(part, (len(here), len(part)))
            found, _ = look.on_the_way(here, every, 2 * pair)
            between = bends_to(found[..., 3], found[..., 4])  # (2, k, p)
            ends = np.stack([bends[pair][:, here - 1], bends[pair][:, here]], axis=2)
            way = np.concatenate([ends[..., :1], between, ends[..., 1:]], axis=2)
            goes = np.asarray(passes_through(way).any(axis=1))
            unsure = may_pass_through(way).any(axis=1)
            for i in np.flatnonzero(unsure & crossed[pair, here] & apart[pair, here]):
                goes[i] = look.crosses(here[i : i + 1], part, pair, ends[:, i])
            out[pair, here] &= goes | ~apart[pair, here]
    return out
