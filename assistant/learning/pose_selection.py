"""Select poses to measure an arm in: D-optimal ones out of many, by exchange.

The determinant of the information matrix is maximised, of errors in units of assembly tolerances
(Fedorov, Theory of Optimal Experiments, 1972; of arms: Borm and Menq, Determination of optimal
measurement configurations for robot calibration based on observability measure, 1991).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from assistant.base.arrays import Floats, Rows, Truths
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Refused
from assistant.learning import rules
from assistant.learning.arm_models import EstimatedErrors, Parameter, arm_model
from assistant.learning.measured_poses import measured_from_columns
from assistant.learning.parameter_fit import (
    MOST_SIGMA,
    FitProblem,
    KnownPlacement,
    identify_parameters,
)
from assistant.program.geometry import Pose, Vector
from assistant.robots import Robot
from assistant.vision.cameras.camera import Camera

_CANDIDATES: Final = 800
_RANGE_SHARE: Final = 0.95
"""Share of the range of each axis that is used."""
_EXCHANGE_ROUNDS: Final = 3
"""Times that each pose is exchanged for the best other one at most."""
_PICTURE_MARGIN: Final = 10.0
"""Pixels from the edge of a picture."""


@dataclass(frozen=True, slots=True, eq=False)
class SuggestedPoses:
    """joints: (m, a) degrees or mm. points: (m, 3) mm of the tool point in the base. sigmas:
    standard deviations of the corrections that they would tell, for the noise that was given,
    and by_chance: those of as many random poses.
    """

    joints: Floats
    points: Floats
    parameters: tuple[Parameter, ...]
    sigmas: Floats
    by_chance: Floats


def suggest_poses(
    robot: Robot,
    count: int,
    *,
    estimate: EstimatedErrors = "lengths",
    tool: Vector = (0.0, 0.0, 0.0),
    known: KnownPlacement | None = None,
    box: Floats | None = None,
    cameras: Sequence[Camera] = (),
    noise: float = 0.05,
    seed: int = 0,
) -> SuggestedPoses:
    """Return poses for measuring an arm; the way to them is not checked for collisions.

    tool: mm, rough position of the point in the flange. box: (3, 2) mm of the base that contains
    the point. cameras: cameras in the base's frame; at least two of them see the point. noise: mm.
    Raises Refused if fewer poses are found.
    """
    known = known or KnownPlacement()
    joints, points = _random_candidates(robot, tool, box, cameras, seed)
    if len(joints) < count:
        where = " where two cameras see the point" if cameras else " in the box" * (box is not None)
        raise Refused(
            rules.TOO_FEW_CANDIDATES(found=len(joints), wanted=count, where=where), exit_status=2
        )
    problem = FitProblem(arm_model(robot, estimate), measured_from_columns(joints, points), noise)
    slope = problem.slope(problem.start(tool=Pose(tool)))
    wanted = problem.wanted(known)
    free, _ = identify_parameters(
        slope.reshape(-1, len(wanted)), problem.parameters, wanted, loose=False
    )
    parameters = tuple(problem.parameters[i] for i in np.flatnonzero(free))
    scale = np.array([MOST_SIGMA[one.unit] for one in parameters])
    rows = slope[:, :, free] * scale
    chosen = _exchange(rows, _greedy_selection(rows, count))
    first = np.arange(count)
    return SuggestedPoses(
        joints[chosen],
        points[chosen],
        parameters,
        _parameter_sigmas(rows[chosen]) * scale,
        _parameter_sigmas(rows[first]) * scale,
    )


def _random_candidates(
    robot: Robot, tool: Vector, box: Floats | None, cameras: Sequence[Camera], seed: int
) -> tuple[Floats, Floats]:
    """Random joints whose links stay above the floor, and the tool point where it may be."""
    middle, half = robot.limits.mean(axis=1), np.ptp(robot.limits, axis=1) / 2.0 * _RANGE_SHARE
    # Turns beyond half a circle tell nothing new and wind up cables.
    half = np.where(robot.sliding, half, np.minimum(half, 175.0))
    random = np.random.default_rng(seed)
    joints = random.uniform(middle - half, middle + half, (8 * _CANDIDATES, len(half)))
    joints = np.round(joints, 2)
    p, r = arm_model(robot, "zeros").flange(joints, np.zeros(len(robot.axes)))
    points = p + r @ np.array(tool)
    good: Truths = (robot.chain(joints)[:, 1:, 2] >= 0.0).all(axis=1) & (points[:, 2] >= 0.0)
    if box is not None:
        good &= ((points >= box[:, 0]) & (points <= box[:, 1])).all(axis=1)
    if cameras:
        views = [camera.within(camera.project(points), _PICTURE_MARGIN) for camera in cameras]
        good &= np.sum(views, axis=0) >= 2
    some = np.flatnonzero(good)[:_CANDIDATES]
    return joints[some], points[some]


def _greedy_selection(rows: Floats, count: int) -> Rows:
    """Places (count,) of poses, each the one that adds most to those before it."""
    information = np.eye(rows.shape[2]) * 1e-6
    chosen: list[int] = []
    for _ in range(count):
        gain = _determinant_gains(rows, np.asarray(np.linalg.inv(information)))
        gain[chosen] = -np.inf
        chosen.append(int(np.argmax(gain)))
        information = information + rows[chosen[-1]].T @ rows[chosen[-1]]
    return np.array(chosen)


def _exchange(rows: Floats, chosen: Rows) -> Rows:
    chosen = chosen.copy()
    ridge = np.eye(rows.shape[2]) * 1e-9
    for _ in range(_EXCHANGE_ROUNDS):
        changed = False
        for i in range(len(chosen)):
            others = np.delete(chosen, i)
            information = np.einsum("npk,npl->kl", rows[others], rows[others]) + ridge
            gain = _determinant_gains(rows, np.asarray(np.linalg.inv(information)))
            gain[others] = -np.inf
            best = int(np.argmax(gain))
            if gain[best] > gain[chosen[i]] + 1e-9:
                chosen[i], changed = best, True
        if not changed:
            break
    return chosen


def _determinant_gains(rows: Floats, inverse: Floats) -> Floats:
    """(n,) by how much the logarithm of the determinant grows with each pose."""
    inner = np.eye(rows.shape[1]) + rows @ inverse @ rows.transpose(0, 2, 1)
    return np.asarray(np.linalg.slogdet(inner)[1])


def _parameter_sigmas(rows: Floats) -> Floats:
    information = np.einsum("npk,npl->kl", rows, rows)
    return np.asarray(np.sqrt(np.diag(np.linalg.pinv(information, hermitian=True))))
