"""Calibration: out of measured poses a corrected arm, its base, its tool, and how sure they are."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Final

import numpy as np

from assistant.base.arrays import Floats, Rows, Truths, norms
from assistant.base.diagnostics import Diagnostic, Refused
from assistant.learning.calibration import rules
from assistant.learning.calibration.aligning import aligned
from assistant.learning.calibration.chain_model import model_of
from assistant.learning.calibration.doubts import DOUBTED, moving, read_rightly
from assistant.learning.calibration.fitting import Fit, fit, least_squares
from assistant.learning.calibration.identifying import Held, condition, told_apart
from assistant.learning.calibration.measured import Measured
from assistant.learning.calibration.models import Estimate, LengthsModel, Parameter
from assistant.learning.calibration.problem import PLACED, Known, Problem, State
from assistant.learning.calibration.validating import Residual, held_out, residual
from assistant.program.geometry import Pose
from assistant.robots import Robot
from assistant.robots.arms import Placed, Serial

FEWEST: Final = 1.5
"""Numbers measured for each parameter, at least."""
MOST_OUT: Final = 0.3
"""Of the rows, that may not fit the others."""
BIG: Final = {"mm": 10.0, "deg": 5.0}
"""What is more than errors of assembly."""
OVER: Final = 2.0
"""Times the residual of the fit from which on that of poses held out tells of over-fitting."""
LESS: Final = 0.75
"""Of what remains, that a free chain leaves at most to be worth telling."""
FAR: Final = 0.25
"""Of the reach, that the nominal arm may miss the middle one of the points by."""
SURE: Final = 22.0
"""Of the statistic of two samples, that chance gives one set of poses in some thousand."""
TINY: Final = 1e-12
"""mm², so that points without any noise have a covariance."""
TOGETHER: Final = 0.9
"""Correlation from which on errors of two corrections are told to go together."""
NOISE: Final = 1.3
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
    """What measured poses tell of an arm.

    fit: the fit. start: base and tool of the nominal arm. before, after: residuals of the poses
    that count, with base and tool fitted in both. out_before, out: of each pose by a fit of others.
    held: corrections that the poses do not tell, or only in sums. findings: what is to be known.
    """

    robot: Robot
    estimate: Estimate
    known: Known
    measured: Measured
    fit: Fit
    start: State
    before: Residual
    after: Residual
    out_before: Residual
    out: Residual
    held: tuple[Held, ...]
    findings: tuple[Diagnostic, ...]

    @property
    def base(self) -> Pose:
        """Of the corrected arm, in the measuring frame."""
        return self.fit.state.base

    @property
    def tool(self) -> Pose:
        """What was measured, in the flange of the corrected arm."""
        return self.fit.state.tool

    @property
    def noise(self) -> tuple[float, float | None]:
        """Of a point along each axis, mm, and of a turn about each, degrees: one sigma."""
        one = self.fit.problem
        return one.point_noise, None if one.measured.turns is None else one.turn_noise

    @cached_property
    def condition(self) -> float:
        """Of the Jacobian with columns of one length."""
        return condition(self.fit.slope)

    @cached_property
    def corrections(self) -> tuple[Correction, ...]:
        """Those of the arm that are told."""
        free, sigma = np.flatnonzero(self.fit.free), self.sigmas
        return tuple(
            Correction(
                self.fit.problem.parameters[at],
                float(self.fit.state.values[at - PLACED]),
                float(sigma[at]),
            )
            for at in map(int, free)
            if at >= PLACED
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
    measured: Measured,
    *,
    estimate: Estimate = "lengths",
    known: Known | None = None,
    noise: float | None = None,
) -> Calibration:
    """The errors of an arm by measured poses of its tool.

    estimate: zeros of the axes alone; with the lengths that a robot file says; or a free chain, in
    which every axis may lie anywhere. known: of base and tool, what is not to be estimated. noise:
    mm along each axis, one sigma; by the residuals if it is not stated. Raises Refused for poses
    that tell nothing or are read wrongly.
    """
    known = known or Known()
    _sayable(robot, estimate)
    findings = [*measured.findings]
    problem = Problem(model_of(robot, estimate), measured, *(() if noise is None else (noise,)))
    _enough(problem, known)
    findings += moving(robot, measured)
    read_rightly(robot, measured, known)
    start, _ = aligned(problem, known)
    _near(problem, start)
    found, held = _fitted(problem, start, known, stated=noise is not None)
    findings += _fitting(found, robot)
    rows = np.flatnonzero(found.used)
    one, placed = found.problem, found.problem.wanted(known, arm=False) & found.free
    again = replace(start, values=np.zeros_like(start.values))
    out_before = held_out(one, again, placed, rows)
    out = held_out(one, found.state, found.free, rows)
    done = Calibration(
        robot,
        estimate,
        known,
        measured,
        found,
        start,
        residual(one, _replaced(one, again, placed, rows), rows),
        residual(one, found.state, rows),
        out_before,
        out,
        held,
        (),
    )
    findings += _told(done, noise)
    return replace(done, findings=tuple(findings))


def _sayable(robot: Robot, estimate: Estimate) -> None:
    if estimate == "lengths" and not LengthsModel(robot).names:
        raise Refused(rules.NOT_SAID(robot=robot.name), exit_status=2)
    if robot.coupling and estimate == "chain":
        raise Refused(rules.COUPLED(robot=robot.name), exit_status=2)


def _enough(problem: Problem, known: Known) -> None:
    count = int(problem.wanted(known).sum())
    needed = int(np.ceil(FEWEST * count / problem.parts))
    if len(problem.measured) < needed:
        fields: dict[str, Any] = {
            "count": len(problem.measured),
            "parameters": count,
            "needed": needed,
        }
        raise Refused(rules.TOO_FEW(path=problem.measured.path, **fields))


def _near(problem: Problem, start: State) -> None:
    """Raises Refused for poses that the nominal arm misses by more than any small error."""
    left, robot = float(np.median(norms(problem.errors(start)[0]))), problem.model.robot
    if left > FAR * robot.reach:
        raise Refused(rules.NO_FIT(path=problem.measured.path, robot=robot.name, left=left))


def _fitted(
    problem: Problem, start: State, known: Known, *, stated: bool
) -> tuple[Fit, tuple[Held, ...]]:
    """The fit with what the poses tell apart; first all that can be, then all that is worth it."""
    wanted = problem.wanted(known)
    slope = problem.slope(start)
    free, held = told_apart(_rows(slope), problem.parameters, wanted, loose=False)
    found = fit(problem, start, free, known=stated)
    slope = found.problem.of(np.flatnonzero(found.used)).slope(found.state)
    kept, held = told_apart(_rows(slope), problem.parameters, wanted, loose=True)
    if (kept == free).all():
        return found, held
    return fit(found.problem, start, kept, known=stated), held


def _rows(slope: Floats) -> Floats:
    return slope.reshape(-1, slope.shape[2])


def _replaced(problem: Problem, state: State, placed: Truths, rows: Rows) -> State:
    """The nominal arm with base and tool by the rows that count."""
    some = problem.of(rows)
    return least_squares(some, state, placed, np.ones(len(rows)))


def _fitting(found: Fit, robot: Robot) -> list[Diagnostic]:
    """Findings of rows that do not fit; raises Refused where too little does."""
    poses = found.problem.measured
    points, turns = found.problem.errors(found.state)
    off = norms(points)
    left = float(np.median(off))
    if left > DOUBTED * robot.reach:
        raise Refused(rules.NO_FIT(path=poses.path, robot=robot.name, left=left))
    out = np.flatnonzero(~found.used)
    if len(out) > MOST_OUT * len(poses):
        raise Refused(rules.TOO_MANY_OUTLIERS(path=poses.path, count=len(out), total=len(poses)))
    findings = []
    for at in out:
        turn = "" if poses.turns is None else f" and {np.degrees(norms(turns[at])):.3g} degrees"
        row, mm = int(poses.rows[at]), float(off[at])
        findings.append(rules.OUTLIERS(path=poses.path, row=row, mm=mm, turn=turn))
    return findings


def _told(done: Calibration, noise: float | None) -> list[Diagnostic]:
    path, findings = done.measured.path, list[Diagnostic]()
    fields: dict[str, Any]
    for one in done.held:
        fields = {"name": one.parameter.name, "unit": one.parameter.unit, "reason": one.reason}
        findings.append(rules.HELD(path=path, value=one.parameter.nominal, **fields))
    for correction in done.corrections:
        unit, value = correction.parameter.unit, correction.value
        if abs(value) > BIG[unit]:
            name = correction.parameter.name
            findings.append(rules.LARGE(path=path, name=name, value=value, unit=unit))
    if done.out.point > OVER * done.after.point:
        fields = {"out": done.out.point, "inside": done.after.point}
        findings.append(rules.OVER_FITTED(path=path, **fields))
    if done.out.point > done.out_before.point:
        fields = {"after": done.out.point, "before": done.out_before.point}
        findings.append(rules.NO_GAIN(path=path, **fields))
    findings += _moved(done)
    if noise is not None:
        missing = done.fit.problem.missing(done.fit.state)[done.fit.used]
        ratio = float(np.sqrt((missing**2).sum() / max(done.fit.freedom, 1)))
        if ratio > NOISE:
            findings.append(rules.NOISY(path=path, ratio=ratio))
    return [*findings, *_remaining(done)]


def _moved(done: Calibration) -> list[Diagnostic]:
    """Whether the points of later rows are off those of earlier ones, by the best place to part
    them (Hotelling's two samples).
    """
    problem, used = done.fit.problem, np.flatnonzero(done.fit.used)
    off = problem.of(used).errors(done.fit.state)[0]
    count = np.arange(1, len(off))[:, None]
    early, total = np.cumsum(off, axis=0)[:-1], off.sum(axis=0)
    apart = early / count - (total - early) / (len(off) - count)
    weight = (count * (len(off) - count) / len(off))[:, 0]
    inverse = np.linalg.inv(np.cov(off.T) + np.eye(3) * TINY)
    square = weight * np.einsum("ni,ij,nj->n", apart, inverse, apart)
    at = int(np.argmax(square))
    if square[at] < SURE:
        return []
    row, mm = int(done.measured.rows[used[at + 1]]), float(np.linalg.norm(apart[at]))
    return [rules.MOVED(path=done.measured.path, row=row, mm=mm)]


def _remaining(done: Calibration) -> list[Diagnostic]:
    """What a free chain would explain beyond the lengths of a robot file."""
    if done.estimate == "chain":
        numerical = isinstance(done.robot.arm, Placed | Serial)
        five = "" if len(done.robot.axes) > 5 else ", and its axes are named J1 to J5"
        return [] if numerical else [rules.NUMERICAL(names=five)]
    problem = replace(done.fit.problem, model=model_of(done.robot, "chain"))
    rows = np.flatnonzero(done.fit.used)
    wanted = problem.wanted(done.known)
    if done.robot.coupling or len(rows) * problem.parts < FEWEST * wanted.sum():
        return []
    some = problem.of(rows)
    state = State(done.base, done.tool, np.zeros(len(problem.model.parameters)))
    free, _ = told_apart(_rows(some.slope(state)), problem.parameters, wanted, loose=True)
    chained = held_out(problem, state, free, rows)
    if chained.point > LESS * done.out.point:
        return []
    path = done.measured.path
    return [rules.REMAINS(path=path, left=done.out.point, free=chained.point)]
