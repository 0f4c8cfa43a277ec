"""Calibrate an arm: from measured poses a corrected arm, its base and tool, and their deviations.

Measured poses are checked first: too few, all alike, or outside the limits. Where the nominal arm
misses the points by far, each usual mistake is tried: radians for degrees, another unit, mirrored
points, joints in another order or direction, quaternions with w last, another robot. A reading that
fits very much better is reported as the mistake.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import replace
from functools import cached_property
from typing import Any, Final

import numpy as np

from assistant import robots
from assistant.base import rotations
from assistant.base.arrays import Floats, Rows, Truths, norms
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused
from assistant.learning import rules
from assistant.learning.arm_models import EstimatedErrors, LengthsModel, Parameter, arm_model
from assistant.learning.measured_poses import MeasuredPoses
from assistant.learning.parameter_fit import (
    PLACEMENT_COUNT,
    FitProblem,
    FitState,
    HeldParameter,
    KnownPlacement,
    ParameterFit,
    Residual,
    align_placement,
    condition_number,
    fit_parameters,
    held_out_residual,
    identify_parameters,
    least_squares,
    residual_of_rows,
    rough_residual,
)
from assistant.program.geometry import Pose
from assistant.robots import Robot
from assistant.robots.arms import Placed, Serial

_SUSPICIOUS_MISS: Final = 0.005
"""Share of the reach: if the nominal arm misses the points by more, typical mistakes are tried."""
_MISTAKE_SHARE: Final = 0.25
"""Largest share of the miss that may remain for a mistake to count as its reason."""
_SUSPICIOUS_TURN: Final = 5.0
"""Degrees of the measured turns that no arm is off by."""
_LEAST_AXIS_RANGE: Final = 2.0
"""Degrees or mm by which some axis must move."""
_USEFUL_AXIS_RANGE: Final = 10.0
"""Degrees or mm that an axis should move by."""
_MISTAKEN_UNITS: Final = {"m": 1000.0, "cm": 10.0, "inches": 25.4}
_MIRRORED_Z: Final = np.array([1.0, 1.0, -1.0])


def _check_motion(robot: Robot, poses: MeasuredPoses) -> tuple[Diagnostic, ...]:
    """Findings of axes that hardly move; raises Refused for poses outside limits or all alike."""
    _check_limits(robot, poses)
    spans = np.ptp(poses.joints, axis=0) if len(poses) else np.zeros(len(robot.axes))
    if spans.max() < _LEAST_AXIS_RANGE:
        unit = "degrees"
        raise Refused(
            rules.POSES_ALIKE(path=poses.path, most=max(float(spans.max()), 0.01), unit=unit)
        )
    still = [
        axis for axis, span in zip(robot.axes, spans, strict=True) if span < _USEFUL_AXIS_RANGE
    ]
    if not still:
        return ()
    return (
        rules.AXES_HARDLY_MOVE(path=poses.path, axes=", ".join(still), least=_USEFUL_AXIS_RANGE),
    )


def _check_limits(robot: Robot, poses: MeasuredPoses) -> None:
    low, high = robot.limits.T
    outside = (poses.joints < low - 1e-3) | (poses.joints > high + 1e-3)
    findings = []
    for i in np.flatnonzero(outside.any(axis=0)):
        first, count = int(np.argmax(outside[:, i])), int(outside[:, i].sum())
        fields: dict[str, Any] = {
            "axis": robot.axes[i],
            "low": low[i],
            "high": high[i],
            "count": count,
        }
        value, row = float(poses.joints[first, i]), int(poses.rows[first])
        findings.append(
            rules.JOINTS_OUTSIDE_LIMITS(path=poses.path, row=row, value=value, **fields)
        )
    if findings:
        raise Refused(*findings)


def _check_reading(robot: Robot, poses: MeasuredPoses, known: KnownPlacement) -> None:
    """Raises Refused for poses that fit very much better if they are read otherwise."""
    points = replace(poses, turns=None)
    now = _point_miss(robot, points, known)
    if now > _SUSPICIOUS_MISS * robot.reach:
        tried = [
            (_point_miss(robot, other, known), what, cure)
            for other, what, cure in _other_readings(points, known, robot)
        ]
        then, what, cure = min(tried)
        if then < _MISTAKE_SHARE * now:
            told: dict[str, Any] = {"now": f"{now:.4g} mm", "then": f"{then:.4g} mm"}
            raise Refused(rules.MISREAD_POSES(path=poses.path, what=what, cure=cure, **told))
        _check_other_robots(robot, points, known, now)
    if poses.turns is not None:
        _check_turns(robot, poses, known)


def _other_readings(
    poses: MeasuredPoses, known: KnownPlacement, robot: Robot
) -> Iterator[tuple[MeasuredPoses, str, str]]:
    joints, points = poses.joints, poses.points
    turning = ~robot.sliding
    scaled = np.where(turning, np.degrees(joints), joints)
    yield replace(poses, joints=scaled), "the joints are radians", "name their columns `j1_rad` …"
    for unit, factor in _MISTAKEN_UNITS.items():
        column = {"inches": "in"}.get(unit, unit)
        cure = f"name the columns `x_{column}`, `y_{column}`, `z_{column}`"
        yield replace(poses, points=points * factor), f"the points are {unit}", cure
    mirrored = "the points are mirrored: two columns are swapped, or an axis counts the other way"
    cure = "bring the columns into the order of a right-handed frame"
    if known.base is None:
        yield replace(poses, points=points * _MIRRORED_Z), mirrored, cure
    else:
        for order in itertools.permutations(range(3)):
            if order != (0, 1, 2):
                what = f"the points are in the order {' '.join('xyz'[i] for i in order)}"
                swapped = points[:, list(order)]
                yield replace(poses, points=swapped), what, "swap their columns"
        for i in range(3):
            signs = np.where(np.arange(3) == i, -1.0, 1.0)
            what = f"{'xyz'[i]} counts the other way (mirrored)"
            yield replace(poses, points=points * signs), what, "turn its sign"
    for a, b in itertools.combinations(range(joints.shape[1]), 2):
        places = list(range(joints.shape[1]))
        places[a], places[b] = b, a
        what = f"{robot.axes[a]} and {robot.axes[b]} are swapped"
        yield replace(poses, joints=joints[:, places]), what, "swap their columns"
    for i, axis in enumerate(robot.axes):
        signs = np.where(np.arange(joints.shape[1]) == i, -1.0, 1.0)
        yield replace(poses, joints=joints * signs), f"{axis} counts the other way", "turn its sign"


def _check_other_robots(
    robot: Robot, poses: MeasuredPoses, known: KnownPlacement, now: float
) -> None:
    found: list[tuple[float, str]] = []
    for name in robots.names():
        other = robots.get(name)
        same = len(other.axes) == len(robot.axes) and (other.sliding == robot.sliding).all()
        if same and name != robot.name:
            found.append((_point_miss(other, poses, known), name))
    then, name = min(found, default=(np.inf, ""))
    if then < _MISTAKE_SHARE * now:
        fields: dict[str, Any] = {"robot": robot.name, "other": name, "now": now, "then": then}
        raise Refused(rules.OTHER_ROBOT(path=poses.path, **fields))


def _check_turns(robot: Robot, poses: MeasuredPoses, known: KnownPlacement) -> None:
    assert poses.turns is not None
    now = _turn_miss(robot, poses, known)
    if now < _SUSPICIOUS_TURN:
        return
    w_last = np.roll(poses.turns, 1, axis=1)
    others = [
        (w_last, "the quaternions have w last", "name their columns in the order of the file"),
        (rotations.conjugate(poses.turns), "the quaternions are turned back", "turn their sign"),
        (rotations.conjugate(w_last), "the quaternions are turned back and have w last", "do both"),
    ]
    tried = []
    for turns, what, cure in others:
        other = replace(poses, turns=rotations.canonical(turns))
        tried.append((_turn_miss(robot, other, known), what, cure))
    then, what, cure = min(tried)
    if then > _MISTAKE_SHARE * now:
        what, cure = "they are left out", "leave the columns out, or look at what is measured"
        then = 0.0
    told: dict[str, Any] = {"now": f"{now:.3g} degrees", "then": f"{then:.3g}"}
    raise Refused(rules.MISREAD_POSES(path=poses.path, what=what, cure=cure, **told))


def _point_miss(robot: Robot, poses: MeasuredPoses, known: KnownPlacement) -> float:
    """The mm by which the nominal arm misses the middle one of the points."""
    problem = FitProblem(LengthsModel(robot), poses)
    return rough_residual(problem, known)


def _turn_miss(robot: Robot, poses: MeasuredPoses, known: KnownPlacement) -> float:
    """Degrees, of the middle row, with base and tool by the points and the tool's turn by all."""
    points = FitProblem(LengthsModel(robot), replace(poses, turns=None))
    placed, _ = align_placement(points, known)
    whole = FitProblem(LengthsModel(robot), poses)
    wanted = replace(known, base=placed.base, tool=placed.tool.position)
    state, _ = align_placement(whole, wanted)
    _, turned = whole.errors(state)
    return float(np.degrees(np.median(np.linalg.norm(turned, axis=1))))


_LEAST_MEASUREMENTS: Final = 1.5
"""Numbers measured for each parameter, at least."""
_MOST_OUTLIERS: Final = 0.3
"""Largest share of rows that may not fit the others."""
_LARGE_CORRECTIONS: Final = {"mm": 10.0, "deg": 5.0}
"""Corrections above these values exceed errors of assembly."""
_OVER_FIT_RATIO: Final = 2.0
"""Ratio of the residual of held-out poses to that of the fit above which over-fitting is
reported.
"""
_FREE_CHAIN_SHARE: Final = 0.75
"""Largest share of the remaining error that a free chain may leave to be reported as better."""
_MOST_MISS: Final = 0.25
"""Largest share of the reach by which the nominal arm may miss the median point."""
_MOVED_STATISTIC: Final = 22.0
"""Two-sample statistic that chance reaches in about one of a thousand sets of poses."""
_LEAST_VARIANCE: Final = 1e-12
"""mm², so that points without any noise have a covariance."""
_MOST_NOISE_RATIO: Final = 1.3
"""Times the stated noise that the residual may be."""


@dataclass(frozen=True, slots=True)
class Correction:
    """value: mm or degrees to be added to the nominal value. sigma: its standard deviation."""

    parameter: Parameter
    value: float
    sigma: float

    @property
    def corrected(self) -> float:
        return self.parameter.nominal + self.value


@dataclass(frozen=True, eq=False)
class Calibration:
    """Result of a calibration of an arm with measured poses.

    fit: the fit. start: base and tool of the nominal arm. before, after: residuals of the used
    poses, with base and tool fitted in both. out_before, out: residuals of each pose by a fit of
    other poses. held: corrections that the poses do not determine, or only in sums. findings:
    warnings and remarks about the result.
    """

    robot: Robot
    estimate: EstimatedErrors
    known: KnownPlacement
    measured: MeasuredPoses
    fit: ParameterFit
    start: FitState
    before: Residual
    after: Residual
    out_before: Residual
    out: Residual
    held: tuple[HeldParameter, ...]
    findings: tuple[Diagnostic, ...]

    @property
    def base(self) -> Pose:
        """Base of the corrected arm, in the measuring frame."""
        return self.fit.state.base

    @property
    def tool(self) -> Pose:
        """Measured tool, in the flange of the corrected arm."""
        return self.fit.state.tool

    @property
    def noise(self) -> tuple[float, float | None]:
        """Noise of a point along each axis, mm, and of a turn about each axis, degrees: one
        sigma.
        """
        one = self.fit.problem
        return one.point_noise, None if one.measured.turns is None else one.turn_noise

    @cached_property
    def condition(self) -> float:
        """Condition number of the Jacobian with columns of equal length."""
        return condition_number(self.fit.slope)

    @cached_property
    def corrections(self) -> tuple[Correction, ...]:
        """Corrections of the arm that the poses determine."""
        free, sigma = np.flatnonzero(self.fit.free), self.sigmas
        return tuple(
            Correction(
                self.fit.problem.parameters[at],
                float(self.fit.state.values[at - PLACEMENT_COUNT]),
                float(sigma[at]),
            )
            for at in map(int, free)
            if at >= PLACEMENT_COUNT
        )

    @cached_property
    def sigmas(self) -> Floats:
        """(12 + k,) standard deviations of all corrections; NaN for what is not fitted."""
        out = np.full(len(self.fit.free), np.nan)
        out[self.fit.free] = np.sqrt(np.diag(self.fit.covariance))
        return out

    @cached_property
    def alike(self) -> tuple[tuple[str, str, float], ...]:
        """Pairs of corrections whose errors go together, with their correlation, worst first."""
        free = np.flatnonzero(self.fit.free)
        covariance = self.fit.covariance
        sigma = np.sqrt(np.diag(covariance))
        rho = covariance / np.outer(sigma, sigma)
        first, second = np.triu_indices(len(free), 1)
        order = [
            i
            for i in np.argsort(-np.abs(rho[first, second]))
            if abs(rho[first[i], second[i]]) > 0.9
        ]
        names = [one.name for one in self.fit.problem.parameters]
        return tuple(
            (names[free[first[i]]], names[free[second[i]]], float(rho[first[i], second[i]]))
            for i in order
        )


def calibrate(
    robot: Robot,
    measured: MeasuredPoses,
    *,
    estimate: EstimatedErrors = "lengths",
    known: KnownPlacement | None = None,
    noise: float | None = None,
) -> Calibration:
    """The errors of an arm by measured poses of its tool.

    estimate: zeros of the axes alone; with the lengths that a robot file says; or a free chain, in
    which every axis may lie anywhere. known: of base and tool, what is not to be estimated. noise:
    mm along each axis, one sigma; by the residuals if it is not stated. Raises Refused for poses
    that tell nothing or are read wrongly.
    """
    known = known or KnownPlacement()
    _check_estimate(robot, estimate)
    findings = [*measured.findings]
    problem = FitProblem(arm_model(robot, estimate), measured, *(() if noise is None else (noise,)))
    _check_measurements(problem, known)
    findings += _check_motion(robot, measured)
    _check_reading(robot, measured, known)
    start, _ = align_placement(problem, known)
    _check_miss(problem, start)
    found, held = _fit_identified(problem, start, known, stated=noise is not None)
    findings += _outlier_findings(found, robot)
    rows = np.flatnonzero(found.used)
    one, placed = found.problem, found.problem.wanted(known, arm=False) & found.free
    again = replace(start, values=np.zeros_like(start.values))
    out_before = held_out_residual(one, again, placed, rows)
    out = held_out_residual(one, found.state, found.free, rows)
    done = Calibration(
        robot,
        estimate,
        known,
        measured,
        found,
        start,
        residual_of_rows(one, _realigned(one, again, placed, rows), rows),
        residual_of_rows(one, found.state, rows),
        out_before,
        out,
        held,
        (),
    )
    findings += _calibration_findings(done, noise)
    return replace(done, findings=tuple(findings))


def _check_estimate(robot: Robot, estimate: EstimatedErrors) -> None:
    if estimate == "lengths" and not LengthsModel(robot).names:
        raise Refused(rules.NO_FILE_LENGTHS(robot=robot.name), exit_status=2)
    if robot.coupling and estimate == "chain":
        raise Refused(rules.COUPLED_AXIS(robot=robot.name), exit_status=2)


def _check_measurements(problem: FitProblem, known: KnownPlacement) -> None:
    count = int(problem.wanted(known).sum())
    needed = int(np.ceil(_LEAST_MEASUREMENTS * count / problem.parts))
    if len(problem.measured) < needed:
        fields: dict[str, Any] = {
            "count": len(problem.measured),
            "parameters": count,
            "needed": needed,
        }
        raise Refused(rules.TOO_FEW_POSES(path=problem.measured.path, **fields))


def _check_miss(problem: FitProblem, start: FitState) -> None:
    """Raises Refused for poses that the nominal arm misses by more than any small error."""
    left, robot = float(np.median(norms(problem.errors(start)[0]))), problem.model.robot
    if left > _MOST_MISS * robot.reach:
        raise Refused(
            rules.NO_SMALL_ERRORS(path=problem.measured.path, robot=robot.name, left=left)
        )


def _fit_identified(
    problem: FitProblem, start: FitState, known: KnownPlacement, *, stated: bool
) -> tuple[ParameterFit, tuple[HeldParameter, ...]]:
    """The fit with what the poses tell apart; first all that can be, then all that is worth it."""
    wanted = problem.wanted(known)
    slope = problem.slope(start)
    free, held = identify_parameters(_fit_rows(slope), problem.parameters, wanted, loose=False)
    found = fit_parameters(problem, start, free, known=stated)
    slope = found.problem.of(np.flatnonzero(found.used)).slope(found.state)
    kept, held = identify_parameters(_fit_rows(slope), problem.parameters, wanted, loose=True)
    if (kept == free).all():
        return found, held
    return fit_parameters(found.problem, start, kept, known=stated), held


def _fit_rows(slope: Floats) -> Floats:
    return slope.reshape(-1, slope.shape[2])


def _realigned(problem: FitProblem, state: FitState, placed: Truths, rows: Rows) -> FitState:
    """The nominal arm with base and tool by the rows that count."""
    some = problem.of(rows)
    return least_squares(some, state, placed, np.ones(len(rows)))


def _outlier_findings(found: ParameterFit, robot: Robot) -> list[Diagnostic]:
    """Findings of rows that do not fit; raises Refused where too little does."""
    poses = found.problem.measured
    points, turns = found.problem.errors(found.state)
    off = norms(points)
    left = float(np.median(off))
    if left > _SUSPICIOUS_MISS * robot.reach:
        raise Refused(rules.NO_SMALL_ERRORS(path=poses.path, robot=robot.name, left=left))
    out = np.flatnonzero(~found.used)
    if len(out) > _MOST_OUTLIERS * len(poses):
        raise Refused(rules.TOO_MANY_OUTLIERS(path=poses.path, count=len(out), total=len(poses)))
    findings = []
    for at in out:
        turn = "" if poses.turns is None else f" and {np.degrees(norms(turns[at])):.3g} degrees"
        row, mm = int(poses.rows[at]), float(off[at])
        findings.append(rules.OUTLIERS(path=poses.path, row=row, mm=mm, turn=turn))
    return findings


def _calibration_findings(done: Calibration, noise: float | None) -> list[Diagnostic]:
    path, findings = done.measured.path, list[Diagnostic]()
    fields: dict[str, Any]
    for one in done.held:
        fields = {"name": one.parameter.name, "unit": one.parameter.unit, "reason": one.reason}
        findings.append(rules.PARAMETER_HELD(path=path, value=one.parameter.nominal, **fields))
    for correction in done.corrections:
        unit, value = correction.parameter.unit, correction.value
        if abs(value) > _LARGE_CORRECTIONS[unit]:
            name = correction.parameter.name
            findings.append(rules.LARGE_CORRECTION(path=path, name=name, value=value, unit=unit))
    if done.out.point > _OVER_FIT_RATIO * done.after.point:
        fields = {"out": done.out.point, "inside": done.after.point}
        findings.append(rules.OVER_FITTED(path=path, **fields))
    if done.out.point > done.out_before.point:
        fields = {"after": done.out.point, "before": done.out_before.point}
        findings.append(rules.NO_GAIN(path=path, **fields))
    findings += _moved_findings(done)
    if noise is not None:
        missing = done.fit.problem.missing(done.fit.state)[done.fit.used]
        ratio = float(np.sqrt((missing**2).sum() / max(done.fit.freedom, 1)))
        if ratio > _MOST_NOISE_RATIO:
            findings.append(rules.RESIDUAL_ABOVE_NOISE(path=path, ratio=ratio))
    return [*findings, *_free_chain_findings(done)]


def _moved_findings(done: Calibration) -> list[Diagnostic]:
    """Report that the points of later rows are off those of earlier ones, at the best place to part
    them (Hotelling's two samples).
    """
    problem, used = done.fit.problem, np.flatnonzero(done.fit.used)
    off = problem.of(used).errors(done.fit.state)[0]
    count = np.arange(1, len(off))[:, None]
    early, total = np.cumsum(off, axis=0)[:-1], off.sum(axis=0)
    apart = early / count - (total - early) / (len(off) - count)
    weight = (count * (len(off) - count) / len(off))[:, 0]
    inverse = np.linalg.inv(np.cov(off.T) + np.eye(3) * _LEAST_VARIANCE)
    square = weight * np.einsum("ni,ij,nj->n", apart, inverse, apart)
    at = int(np.argmax(square))
    if square[at] < _MOVED_STATISTIC:
        return []
    row, mm = int(done.measured.rows[used[at + 1]]), float(np.linalg.norm(apart[at]))
    return [rules.POINTS_MOVED(path=done.measured.path, row=row, mm=mm)]


def _free_chain_findings(done: Calibration) -> list[Diagnostic]:
    """Report an error that a free chain explains beyond the lengths of a robot file."""
    if done.estimate == "chain":
        numerical = isinstance(done.robot.arm, Placed | Serial)
        five = "" if len(done.robot.axes) > 5 else ", and its axes are named J1 to J5"
        return [] if numerical else [rules.SOLVED_NUMERICALLY(names=five)]
    problem = replace(done.fit.problem, model=arm_model(done.robot, "chain"))
    rows = np.flatnonzero(done.fit.used)
    wanted = problem.wanted(done.known)
    if done.robot.coupling or len(rows) * problem.parts < _LEAST_MEASUREMENTS * wanted.sum():
        return []
    some = problem.of(rows)
    state = FitState(done.base, done.tool, np.zeros(len(problem.model.parameters)))
    free, _ = identify_parameters(
        _fit_rows(some.slope(state)), problem.parameters, wanted, loose=True
    )
    chained = held_out_residual(problem, state, free, rows)
    if chained.point > _FREE_CHAIN_SHARE * done.out.point:
        return []
    path = done.measured.path
    return [rules.FREE_CHAIN_FITS_BETTER(path=path, left=done.out.point, free=chained.point)]
