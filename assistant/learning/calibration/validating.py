"""Residuals, and those of poses that took no part in the fit, by which over-fitting is seen."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from assistant.base.arrays import Floats, Rows, Truths, norms
from assistant.learning.calibration.fitting import ROUGHLY_CONVERGED_SHARE, least_squares
from assistant.learning.calibration.problem import FitProblem, FitState

FOLDS: Final = 5
SAME_POSE: Final = 0.5
"""Degrees or mm of joints within which a pose is the same."""
FEW_POSES: Final = 15
"""Poses below which each is held out by itself."""


@dataclass(frozen=True, slots=True)
class Residual:
    """point: mm, root mean square. worst: mm. turn: degrees, None where no turns are measured."""

    point: float
    worst: float
    turn: float | None = None

    @staticmethod
    def of(points: Floats, turns: Floats | None) -> Residual:
        """Of errors (n, 3) mm and (n, 3) radians."""
        off = norms(points)
        turn = None if turns is None else float(np.degrees(np.sqrt((norms(turns) ** 2).mean())))
        return Residual(float(np.sqrt((off**2).mean())), float(off.max()), turn)


def residual_of_rows(problem: FitProblem, state: FitState, rows: Rows) -> Residual:
    some = problem.of(rows)
    points, turns = some.errors(state)
    return Residual.of(points, None if some.measured.turns is None else turns)


def distinct_poses(joints: Floats) -> Rows:
    """(n,) numbers of joints (n, a): the same for a pose that was measured several times."""
    numbers = np.full(len(joints), -1, dtype=np.intp)
    count = 0
    while (new := np.flatnonzero(numbers < 0)).size:
        near = np.abs(joints[new] - joints[new[0]]).max(axis=1) <= SAME_POSE
        numbers[new[near]] = count
        count += 1
    return numbers


def held_out_residual(problem: FitProblem, state: FitState, free: Truths, rows: Rows) -> Residual:
    """Of each of some rows by a fit of the other poses, that begins at a state."""
    alike = distinct_poses(problem.measured.joints[rows])
    many = int(alike.max()) + 1
    order = np.random.default_rng(0).permutation(many)
    points, turns = [], []
    for poses in np.array_split(order, FOLDS if many >= FEW_POSES else many):
        fold = rows[np.isin(alike, poses)]
        others = problem.of(np.setdiff1d(rows, fold))
        found = least_squares(
            others, state, free, np.ones(len(others.measured)), ROUGHLY_CONVERGED_SHARE
        )
        off, turned = problem.of(fold).errors(found)
        points.append(off)
        turns.append(turned)
    told = None if problem.measured.turns is None else np.vstack(turns)
    return Residual.of(np.vstack(points), told)
