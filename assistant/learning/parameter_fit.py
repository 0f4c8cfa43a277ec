"""Fit the corrections of an arm to measured poses by robust least squares.

A measured point is base · flange(joints) · tool. Corrections are, in this order: of the base x, y,
z (mm along its own axes) and rotations about them (degrees); of the tool the same along its own
axes; of the arm those of its model.

Steps: Levenberg and Marquardt (Moré, 1978) with damping by the diagonal. Rows have the weights of
Tukey (biweight) until the outliers are known; then the others count fully, so that standard
deviations are true. Identification: columns of the Jacobian are taken by QR in an order of
preference, base and tool first; one that earlier ones explain is held (Everett and Hsu, 1988;
scaling of columns by Schröer et al., 1997). Alignment: with A the inverse rotation of the base,
A y + c - R t = p is linear in A, c and t, and needs no first guess. Poses held out of the fit show
over-fitting.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from typing import Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats, Rows, Truths, norms
from assistant.base.data_classes import dataclass
from assistant.learning.arm_models import ArmModel, Parameter, rotation_vectors
from assistant.learning.measured_poses import MeasuredPoses
from assistant.program.geometry import IDENTITY, Pose, Quaternion, Vector

_SHIFT_NAMES: Final = ("x", "y", "z")
_TURN_NAMES: Final = ("rx", "ry", "rz")


def _placement_parameters(what: str) -> tuple[Parameter, ...]:
    shifts = (Parameter(f"{what}.{name}", "mm") for name in _SHIFT_NAMES)
    return (*shifts, *(Parameter(f"{what}.{name}", "deg") for name in _TURN_NAMES))


BASE_PARAMETERS: Final = _placement_parameters("base")
_TOOL_PARAMETERS: Final = _placement_parameters("tool")
PLACEMENT_COUNT: Final = len(BASE_PARAMETERS) + len(_TOOL_PARAMETERS)


@dataclass(frozen=True, slots=True)
class KnownPlacement:
    """base: of the arm in the measuring frame. tool, turn: of what is measured, in the flange.
    None if they are sought.
    """

    base: Pose | None = None
    tool: Vector | None = None
    turn: Quaternion | None = None


@dataclass(frozen=True, slots=True, eq=False)
class FitState:
    """base: of the arm in the measuring frame. tool: what is measured, in the flange.
    values: (k,) corrections of the arm.
    """

    base: Pose
    tool: Pose
    values: Floats

    def moved(self, step: Floats) -> FitState:
        """Return the state with corrections (12 + k,) added, base and tool turned about their
        axes.
        """
        base, tool = _small_motion(step[:6]), _small_motion(step[6:PLACEMENT_COUNT])
        return FitState(self.base @ base, self.tool @ tool, self.values + step[PLACEMENT_COUNT:])


@dataclass(frozen=True)
class FitProblem:
    """point_noise: mm, one sigma along each axis, or a factor of the covariances where those are
    known. turn_noise: degrees about each axis.
    """

    model: ArmModel
    measured: MeasuredPoses
    point_noise: float = 1.0
    turn_noise: float = 0.1

    @property
    def parts(self) -> int:
        """Numbers that a row gives."""
        return 3 if self.measured.turns is None else 6

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        return (*BASE_PARAMETERS, *_TOOL_PARAMETERS, *self.model.parameters)

    @cached_property
    def whitening(self) -> Floats:
        """(n, 3, 3) by which errors of points are multiplied, mm to sigmas but for the factor."""
        if self.measured.covariances is None:
            return np.tile(np.eye(3), (len(self.measured), 1, 1))
        return np.asarray(np.linalg.inv(np.linalg.cholesky(self.measured.covariances)))

    def of(self, which: Rows) -> FitProblem:
        return replace(self, measured=self.measured.of(which))

    def start(self, base: Pose = IDENTITY, tool: Pose = IDENTITY) -> FitState:
        return FitState(base, tool, np.zeros(len(self.model.parameters)))

    def errors(self, state: FitState) -> tuple[Floats, Floats]:
        """(n, 3) mm and (n, 3) radians in the measuring frame, said less measured; of turns 0
        where none are measured.
        """
        p, r = self.model.flange(self.measured.joints, state.values)
        base = rotations.to_matrix(np.array(state.base.quaternion))
        tip = p + r @ np.array(state.tool.position)
        off = tip @ base.T + np.array(state.base.position) - self.measured.points
        if self.measured.turns is None:
            return off, np.zeros_like(off)
        said = base @ r @ rotations.to_matrix(np.array(state.tool.quaternion))
        seen = rotations.to_matrix(self.measured.turns)
        return off, rotation_vectors(said @ seen.transpose(0, 2, 1))

    def missing(self, state: FitState) -> Floats:
        """(n, parts) in sigmas."""
        off, turned = self.errors(state)
        white: Floats = np.einsum("nij,nj->ni", self.whitening, off) / self.point_noise
        if self.measured.turns is None:
            return white
        return np.hstack([white, turned / np.radians(self.turn_noise)])

    def slope(self, state: FitState, *, arm: bool = True) -> Floats:
        """(n, parts, 12 + k): change of `missing` by each correction. arm: whether those of the arm
        are wanted; 0 if not.
        """
        if arm:
            found = self.model.slopes(self.measured.joints, state.values)
            p, r, moved, turned = found.positions, found.rotations, found.moved, found.turned
        else:
            p, r = self.model.flange(self.measured.joints, state.values)
            moved = turned = np.zeros((len(p), 3, len(state.values)))
        base = rotations.to_matrix(np.array(state.base.quaternion))
        tool = rotations.to_matrix(np.array(state.tool.quaternion))
        lever = r @ np.array(state.tool.position)
        n, degree = len(p), np.radians(1.0)
        by = np.zeros((n, 6, PLACEMENT_COUNT + moved.shape[2]))
        by[:, :3, 0:3] = base
        by[:, :3, 3:6] = -base @ _cross_matrices(p + lever) * degree
        by[:, 3:, 3:6] = base * degree
        by[:, :3, 6:9] = base @ r @ tool
        by[:, 3:, 9:12] = base @ r @ tool * degree
        by[:, :3, PLACEMENT_COUNT:] = base @ (moved - _cross_matrices(lever) @ turned)
        by[:, 3:, PLACEMENT_COUNT:] = base @ turned
        by[:, :3] = self.whitening @ by[:, :3] / self.point_noise
        by[:, 3:] /= np.radians(self.turn_noise)
        return by[:, : self.parts]

    def wanted(self, known: KnownPlacement, *, arm: bool = True) -> Truths:
        """Return which (12 + k,) corrections are wanted. arm: True to include those of the arm."""
        out = np.full(len(self.parameters), arm)
        out[: len(BASE_PARAMETERS)] = known.base is None
        out[len(BASE_PARAMETERS) : len(BASE_PARAMETERS) + 3] = known.tool is None
        out[len(BASE_PARAMETERS) + 3 : PLACEMENT_COUNT] = (
            known.turn is None and self.measured.turns is not None
        )
        return out


def _small_motion(step: Floats) -> Pose:
    turn = step[3:]
    angle = float(np.linalg.norm(turn))
    axis = turn / angle if angle > 0.0 else np.array([0.0, 0.0, 1.0])
    return Pose.of(step[:3], rotations.canonical(rotations.about(axis, angle)))


def _cross_matrices(vectors: Floats) -> Floats:
    """(n, 3, 3) matrices by which a cross product with vectors (n, 3) is taken."""
    x, y, z = vectors.T
    none = np.zeros_like(x)
    rows = [[none, -z, y], [z, none, -x], [-y, x, none]]
    return np.moveaxis(np.array(rows), 2, 0)


_FIT_ROUNDS: Final = 60
_CONVERGED_SHARE: Final = 1e-9
"""Share of the cost by which a step must reduce it for the fit to continue."""
_ROUGHLY_CONVERGED_SHARE: Final = 1e-4
"""The same while rows are weighed anew, and for poses that are only predicted."""
_TUKEY_SIGMAS: Final = 6.0
"""Robust sigmas of a row from which on it counts nothing while the others are fitted."""
_OUTLIER_SIGMAS: Final = {3: 4.6, 6: 5.3}
"""Sigmas of rows of so many numbers from which on one does not belong: 1 in 10,000 (chi-square)."""
_MEDIAN_LENGTH: Final = {3: 1.538, 6: 2.313}
"""Median length of so many normal numbers (square root of the median of chi-square)."""
_LEAST_REDUNDANCY: Final = 0.1
"""Least share of redundancy that is assumed for a row beyond the other rows."""
_LEAST_NOISE: Final = 1e-9
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
    done: float = _CONVERGED_SHARE,
) -> FitState:
    """The state with the least squares of what is missing. weights: (n,) of the rows. done: part
    of the cost by which a step must make it less to go on.
    """
    state, root = start, np.sqrt(weights)[:, None]
    here = problem.missing(state) * root
    cost, damping = float((here**2).sum()), 1e-4
    for _ in range(_FIT_ROUNDS if free.any() else 0):
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


def _robust_least_squares(
    problem: FitProblem, start: FitState, free: Truths
) -> tuple[FitState, Truths]:
    """The state by the rows that belong together, and which (n,) those are."""
    state = start
    weights = _robust_weights(problem.missing(state), problem.parts, np.inf)
    for _ in range(12):
        before = weights
        state = least_squares(problem, state, free, weights, _ROUGHLY_CONVERGED_SHARE)
        weights = _robust_weights(problem.missing(state), problem.parts, _TUKEY_SIGMAS)
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
        state, used = _robust_least_squares(problem, start, free)
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
    scale = max(float(np.median(length)) / _MEDIAN_LENGTH[parts], 1e-12)
    if not np.isfinite(beyond):
        return np.asarray(1.0 / (1.0 + (length / (3.0 * scale)) ** 2))
    part = length / (beyond * scale)
    return np.asarray(np.where(part < 1.0, (1.0 - part**2) ** 2, 0.0))


def _inliers(problem: FitProblem, state: FitState, free: Truths, used: Truths) -> Truths:
    """True for each of (n,) rows whose error noise explains."""
    missing = problem.missing(state)
    slope = problem.slope(state, arm=bool(free[PLACEMENT_COUNT:].any()))[:, :, free]
    _, triangle = np.linalg.qr(slope[used].reshape(-1, slope.shape[2]))
    share = ((slope @ np.linalg.pinv(triangle)) ** 2).sum(axis=2)
    # A row that takes part pulls the fit to itself; of another the fit is uncertain as well.
    spread = np.where(used[:, None], np.maximum(1.0 - share, _LEAST_REDUNDANCY), 1.0 + share)
    length = np.linalg.norm(missing / np.sqrt(spread), axis=1)
    scale = max(float(np.median(length[used])) / _MEDIAN_LENGTH[problem.parts], _LEAST_NOISE)
    return np.asarray(length < _OUTLIER_SIGMAS[problem.parts] * scale)


def _leverage(slope: Floats) -> Floats:
    """(m,) share of each measured number in what is fitted to it."""
    q, _ = np.linalg.qr(slope)
    return np.asarray((q * q).sum(axis=1))


def _with_residual_noise(
    problem: FitProblem, state: FitState, used: Truths, slope: Floats
) -> FitProblem:
    """The problem with the noise that its residuals have, of points and turns apart."""
    missing = problem.missing(state)[used]
    over = 1.0 - _leverage(slope.reshape(-1, slope.shape[2])).reshape(missing.shape)
    point = np.sqrt((missing[:, :3] ** 2).sum() / max(over[:, :3].sum(), 1e-9))
    point_noise = max(problem.point_noise * float(point), _LEAST_NOISE)
    if problem.parts == 3:
        return replace(problem, point_noise=point_noise)
    turn = np.sqrt((missing[:, 3:] ** 2).sum() / max(over[:, 3:].sum(), 1e-9))
    turn_noise = max(problem.turn_noise * float(turn), _LEAST_NOISE)
    return replace(problem, point_noise=point_noise, turn_noise=turn_noise)


_DEPENDENT_SHARE: Final = 1e-5
"""Share of a column's length: if less remains beside the others, the column is a sum of them."""
MOST_SIGMA: Final = {"mm": 2.0, "deg": 1.0}
"""Standard deviation from which on a correction is held: errors of assembly are smaller."""
_MOST_PARTS: Final = 6
"""Largest number of parts of a sum in a report."""
_LEAST_PART: Final = 0.02
"""Share of a sum, by its effect on the points, from which on a part is reported."""


@dataclass(frozen=True, slots=True)
class HeldParameter:
    """A correction that the poses do not determine. parts: the corrections that have the same
    effect: name, amount and unit, mm or degrees, equal to one mm or degree of it. sigma: None if it
    is exactly such a sum, else its uncertainty if it were free.
    """

    parameter: Parameter
    parts: tuple[tuple[str, float, str], ...]
    sigma: float | None = None

    @property
    def reason(self) -> str:
        if self.sigma is not None:
            unit = self.parameter.unit
            return f"these poses would tell it to {self.sigma:.2g} {unit} only"
        if not self.parts:
            return "it changes nothing that is measured"
        few = self.parts[:_MOST_PARTS]
        said = " and ".join(f"{much:.3g} {unit} of {name}" for name, much, unit in few)
        more = len(self.parts) - len(few)
        rest = f" and a little of {more} more" if more else ""
        return f"1 {self.parameter.unit} of it looks like {said}{rest}"


def identify_parameters(
    slope: Floats, parameters: Sequence[Parameter], wanted: Truths, *, loose: bool
) -> tuple[Truths, tuple[HeldParameter, ...]]:
    """Return which (k,) corrections are free, and which of the wanted ones are held.

    slope: (m, k) in sigmas per mm or degree. loose: True to hold corrections as well that are less
    certain than any error of assembly; for base and tool, all that can be free are free.
    """
    free, held = np.zeros(len(parameters), dtype=bool), []
    basis: list[Floats] = []
    for i in map(int, np.flatnonzero(wanted)):
        column = slope[:, i]
        size = float(np.linalg.norm(column))
        rest = column.copy()
        for _ in range(2):  # once more, as what is left of a long column is rounding
            for one in basis:
                rest -= (rest @ one) * one
        left = float(np.linalg.norm(rest))
        parameter = parameters[i]
        if left <= _DEPENDENT_SHARE * size or size == 0.0:
            held.append(HeldParameter(parameter, _parts_of_sum(slope, parameters, free, i)))
            continue
        sigma = 1.0 / left
        if loose and i >= PLACEMENT_COUNT and sigma > MOST_SIGMA[parameter.unit]:
            held.append(HeldParameter(parameter, (), sigma))
            continue
        basis.append(rest / left)
        free[i] = True
    return free, tuple(held)


def condition_number(slope: Floats) -> float:
    """Return the condition number of the Jacobian (m, k) with columns of equal length: 1 if no
    corrections are mixed.
    """
    if not slope.shape[1]:
        return 1.0
    return float(np.linalg.cond(slope / np.linalg.norm(slope, axis=0)))


def _parts_of_sum(
    slope: Floats, parameters: Sequence[Parameter], free: Truths, at: int
) -> tuple[tuple[str, float, str], ...]:
    columns = np.flatnonzero(free)
    if not len(columns):
        return ()
    much = np.linalg.lstsq(slope[:, columns], slope[:, at], rcond=None)[0]
    effect = np.abs(much) * np.linalg.norm(slope[:, columns], axis=0)
    order = [i for i in np.argsort(-effect) if effect[i] > _LEAST_PART * effect.max() > 0.0]
    return tuple(
        (parameters[columns[i]].name, float(much[i]), parameters[columns[i]].unit) for i in order
    )


_ALIGNMENT_ROUNDS: Final = 8
"""Rounds of reweighting the linear equations, so that a few wild rows do not decide."""


def align_placement(problem: FitProblem, known: KnownPlacement) -> tuple[FitState, Truths]:
    """The best base and tool with all corrections of the arm 0, and the rows (n,) that fit them."""
    wanted = problem.wanted(known, arm=False)
    best: tuple[float, FitState, Truths] | None = None
    for start in _start_states(problem, known):
        slope = problem.slope(start, arm=False).reshape(-1, len(wanted))
        free, _ = identify_parameters(slope, problem.parameters, wanted, loose=False)
        state, used = _robust_least_squares(problem, start, free) if free.any() else (start, None)
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
    """Return the rotation of the tool from the measured turns."""
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
    for _ in range(_ALIGNMENT_ROUNDS):
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


_FOLDS: Final = 5
_SAME_POSE: Final = 0.5
"""Degrees or mm of joints within which a pose is the same."""
_FEW_POSES: Final = 15
"""Number of poses below which each pose is held out alone."""


@dataclass(frozen=True, slots=True)
class Residual:
    """point: mm, root mean square. worst: mm. turn: degrees, None where no turns are measured."""

    point: float
    worst: float
    turn: float | None = None

    @staticmethod
    def of(points: Floats, turns: Floats | None) -> Residual:
        """Return the residual of errors (n, 3) mm and (n, 3) radians."""
        off = norms(points)
        turn = None if turns is None else float(np.degrees(np.sqrt((norms(turns) ** 2).mean())))
        return Residual(float(np.sqrt((off**2).mean())), float(off.max()), turn)


def residual_of_rows(problem: FitProblem, state: FitState, rows: Rows) -> Residual:
    some = problem.of(rows)
    points, turns = some.errors(state)
    return Residual.of(points, None if some.measured.turns is None else turns)


def _distinct_poses(joints: Floats) -> Rows:
    """(n,) numbers of joints (n, a): the same for a pose that was measured several times."""
    numbers = np.full(len(joints), -1, dtype=np.intp)
    count = 0
    while (new := np.flatnonzero(numbers < 0)).size:
        near = np.abs(joints[new] - joints[new[0]]).max(axis=1) <= _SAME_POSE
        numbers[new[near]] = count
        count += 1
    return numbers


def held_out_residual(problem: FitProblem, state: FitState, free: Truths, rows: Rows) -> Residual:
    """Return the residual of some rows, each by a fit of the other poses that begins at a state."""
    alike = _distinct_poses(problem.measured.joints[rows])
    many = int(alike.max()) + 1
    order = np.random.default_rng(0).permutation(many)
    points, turns = [], []
    for poses in np.array_split(order, _FOLDS if many >= _FEW_POSES else many):
        fold = rows[np.isin(alike, poses)]
        others = problem.of(np.setdiff1d(rows, fold))
        found = least_squares(
            others, state, free, np.ones(len(others.measured)), _ROUGHLY_CONVERGED_SHARE
        )
        off, turned = problem.of(fold).errors(found)
        points.append(off)
        turns.append(turned)
    told = None if problem.measured.turns is None else np.vstack(turns)
    return Residual.of(np.vstack(points), told)
