"""Least squares by Levenberg and Marquardt over the corrections of an arm, robust to bad rows.

Moré, The Levenberg-Marquardt algorithm: implementation and theory, 1978, for the damping by the
diagonal; weights of rows are those of Tukey (biweight) until those that do not belong are known,
and then the rest counts in full, so that standard deviations mean what they say.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from assistant.base.arrays import Floats, Truths
from assistant.learning.calibration.problem import PLACEMENT_COUNT, FitProblem, FitState

FIT_ROUNDS: Final = 60
CONVERGED_SHARE: Final = 1e-9
"""Of the cost, by which a step must make it less to go on."""
ROUGHLY_CONVERGED_SHARE: Final = 1e-4
"""The same while rows are weighed anew, and for poses that are only predicted."""
TUKEY_SIGMAS: Final = 6.0
"""Robust sigmas of a row from which on it counts nothing while the others are fitted."""
OUTLIER_SIGMAS: Final = {3: 4.6, 6: 5.3}
"""Sigmas of rows of so many numbers from which on one does not belong: 1 in 10,000 (chi-square)."""
MEDIAN_LENGTH: Final = {3: 1.538, 6: 2.313}
"""Median length of so many normal numbers (square root of the median of chi-square)."""
LEAST_REDUNDANCY: Final = 0.1
"""Share of itself that a row is taken to say at least beyond what the others do."""
LEAST_NOISE: Final = 1e-9
"""mm and degrees below which noise is rounding."""


@dataclass(frozen=True, slots=True, eq=False)
class ParameterFit:
    """state: the best one. used: (n,) rows that count. slope: (m · parts, k) of the free
    corrections, in sigmas, at the end. problem: with the noise that the rows turned out to have.
    """

    problem: FitProblem
    state: FitState
    used: Truths
    free: Truths
    slope: Floats

    @property
    def freedom(self) -> int:
        """Numbers measured beyond those that are fitted."""
        return int(self.slope.shape[0] - self.slope.shape[1])

    @property
    def covariance(self) -> Floats:
        """(k, k) of the free corrections, mm and degrees."""
        _, triangle = np.linalg.qr(self.slope)
        inverse = np.linalg.solve(triangle, np.eye(len(triangle)))
        return np.asarray(inverse @ inverse.T)


def least_squares(
    problem: FitProblem,
    start: FitState,
    free: Truths,
    weights: Floats,
    done: float = CONVERGED_SHARE,
) -> FitState:
    """The state with the least squares of what is missing. weights: (n,) of the rows. done: part
    of the cost by which a step must make it less to go on.
    """
    state, root = start, np.sqrt(weights)[:, None]
    here = problem.missing(state) * root
    cost, damping = float((here**2).sum()), 1e-4
    for _ in range(FIT_ROUNDS if free.any() else 0):
        whole = problem.slope(state, arm=bool(free[PLACEMENT_COUNT:].any()))
        slope = (whole[:, :, free] * root[..., None]).reshape(-1, free.sum())
        sizes = np.linalg.norm(slope, axis=0)
        sizes[sizes == 0.0] = 1.0
        better = False
        while damping < 1e8 and not better:
            stacked = np.vstack([slope / sizes, np.sqrt(damping) * np.eye(len(sizes))])
            wanted = np.concatenate([-here.ravel(), np.zeros(len(sizes))])
            step = np.zeros(len(free))
            step[free] = np.linalg.lstsq(stacked, wanted, rcond=None)[0] / sizes
            tried = state.moved(step)
            there = problem.missing(tried) * root
            less = cost - float((there**2).sum())
            better = less > 0.0
            damping = max(damping / 10.0, 1e-12) if better else damping * 10.0
        if not better:
            break
        state, here, cost = tried, there, cost - less
        if less < done * (cost + 1e-12):
            break
    return state


def robust_least_squares(
    problem: FitProblem, start: FitState, free: Truths
) -> tuple[FitState, Truths]:
    """The state by the rows that belong together, and which (n,) those are."""
    state = start
    weights = _robust_weights(problem.missing(state), problem.parts, np.inf)
    for _ in range(12):
        before = weights
        state = least_squares(problem, state, free, weights, ROUGHLY_CONVERGED_SHARE)
        weights = _robust_weights(problem.missing(state), problem.parts, TUKEY_SIGMAS)
        if np.abs(weights - before).max() < 1e-2:
            break
    used = weights > 0.0
    for _ in range(10):
        state = least_squares(problem, state, free, used.astype(np.float64))
        again = _inliers(problem, state, free, used)
        if (again == used).all():
            break
        used = again
    return state, used


def fit_parameters(
    problem: FitProblem, start: FitState, free: Truths, *, known: bool = False
) -> ParameterFit:
    """The best state with the noise of its rows. known: whether that of the problem is stated."""
    for _ in range(4):
        state, used = robust_least_squares(problem, start, free)
        slope = problem.of(np.flatnonzero(used)).slope(state)[:, :, free]
        if known:
            break
        before, problem = problem, _with_residual_noise(problem, state, used, slope)
        start = state
        if abs(np.log(problem.turn_noise / before.turn_noise)) < 0.01 and problem.parts == 6:
            break
        if problem.parts == 3:
            break
    slope = problem.of(np.flatnonzero(used)).slope(state)[:, :, free]
    return ParameterFit(problem, state, used, free, slope.reshape(-1, int(free.sum())))


def _robust_weights(missing: Floats, parts: int, beyond: float) -> Floats:
    """(n,) of Tukey; the scale is the median of the rows. Without an end, those of Cauchy."""
    length = np.linalg.norm(missing, axis=1)
    scale = max(float(np.median(length)) / MEDIAN_LENGTH[parts], 1e-12)
    if not np.isfinite(beyond):
        return np.asarray(1.0 / (1.0 + (length / (3.0 * scale)) ** 2))
    part = length / (beyond * scale)
    return np.asarray(np.where(part < 1.0, (1.0 - part**2) ** 2, 0.0))


def _inliers(problem: FitProblem, state: FitState, free: Truths, used: Truths) -> Truths:
    """(n,) rows that are no farther off than noise explains."""
    missing = problem.missing(state)
    slope = problem.slope(state, arm=bool(free[PLACEMENT_COUNT:].any()))[:, :, free]
    _, triangle = np.linalg.qr(slope[used].reshape(-1, slope.shape[2]))
    share = ((slope @ np.linalg.pinv(triangle)) ** 2).sum(axis=2)
    # A row that takes part pulls the fit to itself; of another the fit is uncertain as well.
    spread = np.where(used[:, None], np.maximum(1.0 - share, LEAST_REDUNDANCY), 1.0 + share)
    length = np.linalg.norm(missing / np.sqrt(spread), axis=1)
    scale = max(float(np.median(length[used])) / MEDIAN_LENGTH[problem.parts], LEAST_NOISE)
    return np.asarray(length < OUTLIER_SIGMAS[problem.parts] * scale)


def leverage(slope: Floats) -> Floats:
    """(m,) share of each measured number in what is fitted to it."""
    q, _ = np.linalg.qr(slope)
    return np.asarray((q * q).sum(axis=1))


def _with_residual_noise(
    problem: FitProblem, state: FitState, used: Truths, slope: Floats
) -> FitProblem:
    """The problem with the noise that its residuals have, of points and turns apart."""
    missing = problem.missing(state)[used]
    over = 1.0 - leverage(slope.reshape(-1, slope.shape[2])).reshape(missing.shape)
    point = np.sqrt((missing[:, :3] ** 2).sum() / max(over[:, :3].sum(), 1e-9))
    point_noise = max(problem.point_noise * float(point), LEAST_NOISE)
    if problem.parts == 3:
        return replace(problem, point_noise=point_noise)
    turn = np.sqrt((missing[:, 3:] ** 2).sum() / max(over[:, 3:].sum(), 1e-9))
    turn_noise = max(problem.turn_noise * float(turn), LEAST_NOISE)
    return replace(problem, point_noise=point_noise, turn_noise=turn_noise)
