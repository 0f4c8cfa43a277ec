"""Rows of a run that can be had because their targets are rounded.

Beside the joints of what is printed stand those of what was meant (see `settling`), for the rows
that need them: few, so that they are kept as a table.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np

from assistant.base.arrays import Floats, Rows, Truths, norms
from assistant.robots.arms.arm import CLOSING
from assistant.robots.branches.rounding import roundings
from assistant.robots.branches.within_rounding import (
    MOST_REGULAR_SHIFT,
    MOST_SHIFT,
    RoundedPoses,
    joints_within_rounding,
    looseness,
    split_wrist_roll,
)
from assistant.robots.motion.run import Run
from assistant.robots.robot import IN_LINE, Robot

MOST_BEYOND_REACH: Final = 0.2
"""mm that a pose may be out of reach by rounding at most."""
AT_LIMIT_TOLERANCE: Final = 0.01
"""degrees or mm beyond a limit up to which a target is taken at the limit, with a warning: its
printed decimals are no finer than that."""
COARSE_ROUNDINGS: Final = 20.0
"""Roundings by which a target that is taken at a limit may be missed."""
STRAIGHT_WRIST_REST: Final = 2e-6
"""degrees of axis 5 that are left of a straight wrist, so that its branch can be told."""


@dataclass(slots=True)
class RoundingTolerance:
    """Joints (m, a) deg that are taken for rows (m,) in branches (m,)."""

    rows: list[Rows] = field(default_factory=list)
    branches: list[Rows] = field(default_factory=list)
    joints: list[Floats] = field(default_factory=list)
    beyond: list[tuple[Rows, Rows, Floats]] = field(default_factory=list)
    """Rows (m,) that are taken at a limit, their axes there, and how far they are beyond (m,)."""

    def add(self, rows: Rows, branches: Rows, joints: Floats) -> None:
        self.rows.append(rows)
        self.branches.append(branches)
        self.joints.append(joints)

    def put(self, joints: Floats, branches: Rows) -> None:
        """Writes into joints (n, a) those of the rows that have their branch of branches (n,)."""
        for rows, own, angles in zip(self.rows, self.branches, self.joints, strict=True):
            chosen = branches[rows] == own
            joints[rows[chosen]] = angles[chosen]


def straighten_wrists(run: Run, robot: Robot, joints: Floats, start: int) -> Truths:
    """Which joints (a, b, m) of rows from `start` on have a straight wrist within the rounding of
    their targets (b, m). It is made straight, in place, and axes 4 and 6, which mean nothing by
    themselves there, inside their limits.
    """
    with np.errstate(invalid="ignore"):
        line = np.asarray(np.abs(joints[4]) < IN_LINE)
    rows = np.flatnonzero(line.any(axis=0))
    if not len(rows):
        return line
    p, q = run.flange(start + rows)
    wanted = rounded_poses(run, robot, p, q, start + rows)
    place, turn = wanted.rounding.T
    lengths = robot.lengths
    lever = norms(wanted.arms) + abs(lengths.d6)
    tilt = (place + np.radians(turn) * lever) / np.hypot(lengths.a3, lengths.d4)
    line[:, rows] &= np.abs(joints[4][:, rows]) <= turn + np.degrees(tilt)
    branch, row = np.nonzero(line)
    four, five, six = joints[3:, branch, row]
    joints[4, branch, row] = np.where(
        np.abs(five) > STRAIGHT_WRIST_REST, np.copysign(STRAIGHT_WRIST_REST, five), five
    )
    low, high = robot.limits.T
    off = (four < low[3]) | (four > high[3]) | (six < low[5]) | (six > high[5])
    if off.any():
        limits = (np.broadcast_to(limit, (int(off.sum()), 6)) for limit in (low, high))
        roll = four[off] + robot.arm.rolls * six[off]
        new = split_wrist_roll(roll, four[off], (next(limits), next(limits)), robot.arm.rolls)
        joints[3, branch[off], row[off]], joints[5, branch[off], row[off]] = new
    return line


def rounded_poses(run: Run, robot: Robot, p: Floats, q: Floats, rows: Rows) -> RoundedPoses:
    """What some rows (k,) of a run want, whose poses of the flange are (k, 3), (k, 4)."""
    return RoundedPoses(p, q, run.mounting.arms(p, q, rows), roundings(robot, *run.targets(rows)))


def take_rounded_rows(
    run: Run,
    robot: Robot,
    slack: RoundingTolerance,
    own: Rows,
    start: int,
    given: tuple[Floats, Floats, Floats],
    reached: Truths,
    allowed: Truths,
) -> None:
    """Adds what can be had by rounding to what is allowed (b, m), for the rows from `start` on.

    own: (m,) the branch that a row states, or -1. given: poses of the flange (m, 3), (m, 4) and
    joints (a, b, m), changed in place as well. reached: (b, m) within reach but for `SHORT`.
    """
    p, q, joints = given
    low, high = robot.limits.T

    def settle(row: Rows, branch: Rows, box: tuple[Floats, Floats], coarser: float = 1.0) -> Rows:
        wanted = rounded_poses(run, robot, p[row], q[row], start + row)
        wanted = replace(wanted, rounding=wanted.rounding * coarser)
        found, met = joints_within_rounding(robot, wanted, branch, joints[:, branch, row].T, box)
        joints[:, branch[met], row[met]] = found[met].T
        allowed[branch[met], row[met]] = True
        slack.add(start + row[met], branch[met], found[met])
        return np.flatnonzero(met)

    stated = np.flatnonzero((own >= 0) & reached[own, np.arange(len(own))])
    if len(stated):
        said = run.configurations[start + stated]
        mine = joints[:, own[stated], stated].T
        turned, fits = robot.turned(mine, said)
        good = allowed[own[stated], stated] & fits.all(axis=1) & robot.inside(turned)
        row = stated[~good]
        if len(row):
            settle(row, own[row], robot.ranges(said[~good]))
    near = (joints >= low[:, None, None] - MOST_SHIFT).all(axis=0)
    near &= (joints <= high[:, None, None] + MOST_SHIFT).all(axis=0)
    if robot.arm.spherical:
        near |= np.abs(joints[4]) < MOST_SHIFT
    branch, row = np.nonzero(near & reached & ~allowed)
    if not len(row):
        return
    angles = joints[:, branch, row].T
    beyond = np.maximum(low - angles, angles - high)
    if robot.arm.spherical:
        beyond[np.abs(angles[:, 4]) < MOST_SHIFT, 3::2] = 0.0
    loose = looseness(robot, angles)
    worst = beyond.max(axis=1)
    whole = branch, row, beyond
    some = worst <= np.minimum(MOST_REGULAR_SHIFT * loose, MOST_SHIFT)
    branch, row, worst, loose = (each[some] for each in (branch, row, worst, loose))
    wanted = rounded_poses(run, robot, p[row], q[row], start + row)
    some = worst <= wanted.play * loose
    branch, row = branch[some], row[some]
    if len(row):
        settle(row, branch, _box(robot, row))
    branch, row, beyond = whole
    meant = np.where(own[row] >= 0, own[row] == branch, ~np.asarray(allowed.any(axis=0))[row])
    some = np.flatnonzero(
        (beyond.max(axis=1) <= AT_LIMIT_TOLERANCE) & meant & ~allowed[branch, row]
    )
    branch, row, beyond = branch[some], row[some], beyond[some]
    if len(row):
        off = roundings(robot, *run.targets(start + row))[:, 0]
        printed = np.flatnonzero(off > CLOSING)
        branch, row, beyond = branch[printed], row[printed], beyond[printed]
    if len(row):
        met = settle(row, branch, _box(robot, row), COARSE_ROUNDINGS)
        axis = beyond[met].argmax(axis=1)
        slack.beyond.append((start + row[met], axis, beyond[met, axis]))


def _box(robot: Robot, rows: Rows) -> tuple[Floats, Floats]:
    low, high = robot.limits.T
    return np.tile(low, (len(rows), 1)), np.tile(high, (len(rows), 1))
