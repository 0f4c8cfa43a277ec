"""Where the base stands and where the tool point is, for an arm as its file says it.

A point is measured at base · (p + R t). With A the turned back base this is A y + c - R t = p,
linear in A, c and t, so that no first guess is needed; least squares from there.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats, Truths, norms
from assistant.learning.calibration.fitting import robust_least_squares
from assistant.learning.calibration.identifying import identify_parameters
from assistant.learning.calibration.problem import FitProblem, FitState, KnownPlacement
from assistant.program.geometry import IDENTITY, Pose, Quaternion

ALIGNMENT_ROUNDS: Final = 8
"""Of weighing the linear equations anew, so that a few wild rows do not decide."""


def align_placement(problem: FitProblem, known: KnownPlacement) -> tuple[FitState, Truths]:
    """The best base and tool with all corrections of the arm 0, and the rows (n,) that fit them."""
    wanted = problem.wanted(known, arm=False)
    best: tuple[float, FitState, Truths] | None = None
    for start in _start_states(problem, known):
        slope = problem.slope(start, arm=False).reshape(-1, len(wanted))
        free, _ = identify_parameters(slope, problem.parameters, wanted, loose=False)
        state, used = robust_least_squares(problem, start, free) if free.any() else (start, None)
        off = np.linalg.norm(problem.missing(state), axis=1)
        used = np.ones(len(off), dtype=bool) if used is None else used
        middle = float(np.median(off))
        if best is None or middle < best[0]:
            best = (middle, state, used)
    assert best is not None
    return best[1], best[2]


def rough_residual(problem: FitProblem, known: KnownPlacement) -> float:
    """The mm, of the middle row, by the linear equations alone: to compare how poses are read."""
    starts = _start_states(problem, known)
    return min(float(np.median(norms(problem.errors(start)[0]))) for start in starts)


def root_mean_square(problem: FitProblem, state: FitState, used: Truths | None = None) -> float:
    """The mm between said and measured points."""
    off, _ = problem.errors(state)
    rows = off if used is None else off[used]
    return float(np.sqrt((rows**2).sum(axis=1).mean()))


def _start_states(problem: FitProblem, known: KnownPlacement) -> list[FitState]:
    none = np.zeros(len(problem.model.parameters))
    p, r = problem.model.flange(problem.measured.joints, none)
    y = problem.measured.points
    found = []
    if known.base is not None:
        a, b, c = (float(v) for v in _middle_tool(p, r, known.base, y))
        found.append((known.base, known.tool or (a, b, c)))
    elif known.tool is not None:
        found.append((_pose_onto(p + r @ np.array(known.tool), y), known.tool))
    else:
        turn, tip = _linear_alignment(p, r, y)
        a, b, c = (float(v) for v in tip)
        found.append((_pose_onto(p + r @ tip, y, turn), (a, b, c)))
        found.append((_pose_onto(p, y), (0.0, 0.0, 0.0)))
    return [
        FitState(base, Pose(tool, _tool_turn(problem, r, base, known)), none)
        for base, tool in found
    ]


def _tool_turn(problem: FitProblem, r: Floats, base: Pose, known: KnownPlacement) -> Quaternion:
    """How the tool is turned by the measured turns."""
    if known.turn is not None or problem.measured.turns is None:
        return known.turn or IDENTITY.quaternion
    own = rotations.to_matrix(np.array(base.quaternion))
    seen = rotations.to_matrix(problem.measured.turns)
    total = (r.transpose(0, 2, 1) @ own.T @ seen).sum(axis=0)
    return Pose.of(np.zeros(3), rotations.from_matrix(_nearest_rotation(total))).quaternion


def _middle_tool(p: Floats, r: Floats, base: Pose, y: Floats) -> Floats:
    back = base.inverse().moved(y)
    return np.asarray(np.median(np.einsum("nji,nj->ni", r, back - p), axis=0))


def _linear_alignment(p: Floats, r: Floats, y: Floats) -> tuple[Floats, Floats]:
    """The base's turn (3, 3) and the tool point (3,)."""
    n = len(p)
    middle, size = y.mean(axis=0), max(float(np.abs(y - y.mean(axis=0)).max()), 1e-9)
    scaled = (y - middle) / size
    rows = np.zeros((n, 3, 15))
    for i in range(3):
        rows[:, i, 3 * i : 3 * i + 3] = scaled
    rows[:, :, 9:12] = np.eye(3)
    rows[:, :, 12:] = -r / size
    weights = np.ones(n)
    for _ in range(ALIGNMENT_ROUNDS):
        root = np.sqrt(weights)[:, None]
        found = np.linalg.lstsq(
            (rows * root[..., None]).reshape(-1, 15), (p * root).ravel(), rcond=1e-9
        )[0]
        off = np.linalg.norm(rows @ found - p, axis=1)
        weights = 1.0 / (1.0 + (off / (3.0 * max(float(np.median(off)), 1e-9))) ** 2)
    return _nearest_rotation(np.asarray(found[:9].reshape(3, 3))).T, np.asarray(found[12:] / size)


def _pose_onto(p: Floats, y: Floats, turn: Floats | None = None) -> Pose:
    """The pose that takes points p to y; turn: of it, if that is known (Kabsch, 1976, if not)."""
    from_, to = np.median(p, axis=0), np.median(y, axis=0)
    if turn is None:
        turn = _nearest_rotation((y - to).T @ (p - from_))
    at = np.median(y - p @ turn.T, axis=0)
    return Pose.of(at, rotations.from_matrix(turn))


def _nearest_rotation(matrix: Floats) -> Floats:
    """The rotation nearest to a matrix (3, 3)."""
    u, _, v = np.linalg.svd(matrix)
    sign = np.sign(np.linalg.det(u @ v)) or 1.0
    return np.asarray(u @ np.diag([1.0, 1.0, sign]) @ v)
