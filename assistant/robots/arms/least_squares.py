"""Damped least squares over joints inside limits, many searches side by side."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import numpy as np

from assistant.base.arrays import Floats, Rows

Residuals = Callable[[Floats, Rows], Floats]
"""Joints (m, s, a) of s tries for each of m searches, and which ones (m,) → what is missing
(m, s, 6) to what is wanted."""

DIFFERENCE_STEP: Final = 1e-4
"""degrees of an axis over which the change of a pose is taken."""


def least_squares_joints(
    missing: Residuals, joints: Floats, low: Floats, high: Floats, rounds: int, enough: float = 0.0
) -> tuple[Floats, Floats]:
    """Joints (k, a), each nearer to what is wanted, step by step, and their costs (k,).

    low, high: (k, a) limits that they stay inside. enough: cost from which on one is done.
    """
    joints = joints.copy()
    k, count = joints.shape
    own = np.arange(count)
    here = _residuals_at(missing, joints, np.arange(k))
    damping, active = np.full(k, 1e-3), np.arange(k)[_cost(here) > enough]
    for _ in range(rounds):
        if not len(active):
            break
        j, r, l, h = joints[active], here[active], low[active], high[active]  # noqa: E741
        slope = (
            missing(j[:, None] + DIFFERENCE_STEP * np.eye(count), active) - r[:, None]
        ) / DIFFERENCE_STEP
        pull = -np.einsum("kai,ki->ka", slope, r)
        fixed = ((j <= l) & (pull < 0.0)) | ((j >= h) & (pull > 0.0))
        slope[fixed] = 0.0
        pull[fixed] = 0.0
        normal = slope @ slope.transpose(0, 2, 1)
        diagonal = normal[:, own, own]
        held = damping[active, None] * (diagonal + 1e-12)
        normal[:, own, own] += np.where(fixed, 1.0, held)
        step = np.linalg.solve(normal, pull[..., None])[..., 0]
        tried = np.clip(j + step, l, h)
        there = _residuals_at(missing, tried, active)
        gain = _cost(r) - _cost(there)
        better = gain > 0.0
        done = better & (gain < 1e-6 * _cost(r)) | (damping[active] > 1e9) | fixed.all(axis=1)
        joints[active] = np.where(better[:, None], tried, j)
        here[active] = np.where(better[:, None], there, r)
        less, more = np.maximum(damping[active] / 4.0, 1e-9), damping[active] * 8.0
        damping[active] = np.where(better, less, more)
        active = active[~done & (_cost(here[active]) > enough)]
    return joints, _cost(here)


def _residuals_at(missing: Residuals, joints: Floats, which: Rows) -> Floats:
    return missing(joints[:, None], which)[:, 0]


def _cost(missing: Floats) -> Floats:
    return np.asarray((missing * missing).sum(axis=-1))
