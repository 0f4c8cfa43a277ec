"""Joints and configurations for a run of moves, and what of it the robot cannot do.

Two passes over the columns, a chunk at a time: the first finds which arm branches every
row allows, then a branch is chosen for each row, and the second computes its joints.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import NDArray

from assistant.program.diagnostics import Diagnostic, Severity
from assistant.program.path import UNSTATED, Kind, configuration_of
from assistant.robots import findings as rules
from assistant.robots.branches import choose
from assistant.robots.configurations import BACK, QUADRANTS
from assistant.robots.five_axis import MISS_TOLERANCE
from assistant.robots.five_axis import fk as five_fk
from assistant.robots.robot import CHUNK, CLOSING, LIMIT_TOLERANCE, Robot
from assistant.robots.run import Run
from assistant.robots.turns import FREE, filled, turn

Floats = NDArray[np.float64]
Truths = NDArray[np.bool_]
Rows = NDArray[np.intp]

SAMPLES: Final = 2048
"""Rows of a path over which the joint travel of equally good branches is compared."""
STRAIGHT: Final = 1e-4
"""degrees of axis 5 below which axis 4 stays where it was before."""


@dataclass(frozen=True, slots=True)
class Solved:
    """joints: (n, a) deg, NaN where there are none. configurations: (n, 6), as stated, else
    those of the joints, UNSTATED where there are none.
    """

    joints: Floats
    configurations: NDArray[np.int8]
    findings: tuple[Diagnostic, ...]


def solve(run: Run, robot: Robot) -> Solved:
    """Chooses the configurations that a run of at least one move leaves open.

    What cannot be done is reported; of rows that state their branches themselves a change
    of branch is a warning only: their controller may have been told to allow it.
    """
    n = len(run)
    stated = np.asarray(run.configurations[:, BACK] != UNSTATED)
    survey = _survey(run, robot)
    own = np.where(stated, robot.branch_of(run.configurations), -1)
    kept = stated & survey.allowed[own, np.arange(n)]
    bound = survey.allowed & ~kept
    bound[own[kept], np.flatnonzero(kept)] = True
    starts = _chain_starts(run)
    cost = _cost(run, robot, bound)
    continued = run.joined and run.kinds[0] != Kind.JOINT
    same = _branches_at(run.before, robot) if continued else np.ones(robot.branches, bool)
    if (bound[:, 0] & same).any():
        bound[:, 0] &= same
    branches = choose(bound, starts, cost)
    joints = _joints(run, robot, branches.chosen)
    said = np.where(kept[:, None], run.configurations, UNSTATED)
    joints, wound, off = _turned(run, robot, joints, starts, said)
    found = robot.configuration(np.nan_to_num(joints))
    solved = np.isfinite(joints).all(axis=1)
    fill = ~stated & solved
    configurations = np.where(fill[:, None], found, run.configurations)
    report = [
        *survey.findings(run, robot),
        *_not_as_stated(run, robot, np.flatnonzero(stated & ~kept & solved), found),
        *_other_quadrant(run, robot, off, found),
    ]
    broken = branches.broken
    if branches.chosen[0] >= 0 and not same[branches.chosen[0]]:
        broken = np.append(0, broken)
    for rows, severity in ((broken[~kept[broken]], None), (broken[kept[broken]], Severity.WARNING)):
        if len(rows):
            place = run.what(rows)
            report.append(rules.BRANCH_CHANGE(place=place, robot=robot.title, severity=severity))
    for axis, rows in wound:
        if continued and abs(joints[0, axis] - run.before[axis]) > 180.0:
            rows = np.append(0, rows)
        rest = np.setdiff1d(rows, broken)
        if len(rest):
            low, high = robot.limits[axis]
            name = robot.axes[axis]
            report.append(rules.WOUND_UP(place=run.what(rest), axis=name, low=low, high=high))
    return Solved(joints, configurations, tuple(report))


@dataclass(slots=True)
class _Worst:
    """Rows with one kind of fault, and the worst of them."""

    rows: list[Rows] = field(default_factory=list)
    value: float = -1.0
    row: int = -1
    fields: dict[str, object] = field(default_factory=dict)

    def add(self, rows: Rows, values: Floats, **columns: NDArray[np.generic]) -> None:
        if not len(rows):
            return
        self.rows.append(rows)
        at = int(np.argmax(values))
        if values[at] > self.value:
            self.value, self.row = float(values[at]), int(rows[at])
            self.fields = {name: column[at].item() for name, column in columns.items()}

    def all(self) -> Rows:
        return np.concatenate(self.rows) if self.rows else np.empty(0, np.intp)


@dataclass(slots=True)
class _Survey:
    """What a first look at every row says. allowed: (b, n) branches inside reach and limits."""

    allowed: Truths
    no_number: list[Rows] = field(default_factory=list)
    reach: _Worst = field(default_factory=_Worst)
    plane: _Worst = field(default_factory=_Worst)
    limits: _Worst = field(default_factory=_Worst)

    def findings(self, run: Run, robot: Robot) -> list[Diagnostic]:
        out = []
        if self.no_number:
            out.append(rules.NO_NUMBER(place=run.what(np.concatenate(self.no_number))))
        if self.reach.rows:
            far = bool(self.reach.fields["far"])
            need = robot.reach + self.reach.value
            cure = f"move the work piece or the robot, or take one that reaches {need:.0f} mm"
            out.append(
                rules.OUT_OF_REACH(
                    place=run.what(self.reach.all()),
                    robot=robot.title,
                    worst=self.reach.value,
                    side="too far out" if far else "too near to the arm",
                    where=run.label(self.reach.row),
                    cure=cure if far else "move the work piece away from the arm",
                )
            )
        if self.plane.rows:
            out.append(
                rules.NOT_IN_PLANE(
                    place=run.what(self.plane.all()),
                    worst=self.plane.value,
                    where=run.label(self.plane.row),
                )
            )
        if self.limits.rows:
            axis, value = int(self.limits.fields["axis"]), float(self.limits.fields["angle"])  # type: ignore[call-overload,arg-type]
            low, high = robot.limits[axis]
            out.append(
                rules.OUTSIDE_LIMITS(
                    place=run.what(self.limits.all()),
                    robot=robot.title,
                    axis=robot.axes[axis],
                    value=value,
                    limit=low if value < low else high,
                    where=run.label(self.limits.row),
                )
            )
        return out


def _survey(run: Run, robot: Robot) -> _Survey:
    survey = _Survey(np.zeros((robot.branches, len(run)), dtype=bool))
    low, high = (limit[:, None, None] for limit in robot.limits.T)
    for start in range(0, len(run), CHUNK):
        rows = slice(start, min(start + CHUNK, len(run)))
        p, q, finite = _finite(run, rows)
        joints, excess = robot.solve(p, q)
        beyond = np.maximum(low - joints, joints - high)
        reached = excess < CLOSING / 2.0
        allowed = reached & (beyond <= LIMIT_TOLERANCE).all(axis=0) & finite
        missed = _miss(robot, joints, q)
        allowed &= missed <= MISS_TOLERANCE
        survey.allowed[:, rows] = allowed
        bad = np.flatnonzero(~allowed.any(axis=0))
        if not len(bad):
            continue
        if not finite.all():
            survey.no_number.append(start + np.flatnonzero(~finite))
        bad = bad[finite[bad]]
        least = excess[:, bad].min(axis=0)
        far = bad[least >= CLOSING / 2.0]
        beyond_reach = np.hypot(robot.lengths.a3, robot.lengths.d4) + robot.lengths.a2
        survey.reach.add(
            start + far,
            least[least >= CLOSING / 2.0],
            far=_span(robot, p[far], q[far]) > beyond_reach,
        )
        near = bad[least < CLOSING / 2.0]
        aside = near[missed[near] > MISS_TOLERANCE]
        survey.plane.add(start + aside, missed[aside])
        stuck = near[missed[near] <= MISS_TOLERANCE]
        over = np.where(reached[:, stuck], beyond[:, :, stuck], np.inf)  # (a, b, m)
        branch = over.max(axis=0).argmin(axis=0)
        each = np.arange(len(stuck))
        axis = over[:, branch, each].argmax(axis=0)
        survey.limits.add(
            start + stuck,
            over[axis, branch, each],
            axis=axis,
            angle=joints[axis, branch, stuck],
        )
    return survey


def _finite(run: Run, rows: slice | Rows) -> tuple[Floats, Floats, Truths]:
    """Poses of the flange; those that are no number are replaced and marked False."""
    p, q = run.flange(rows)
    finite = np.asarray(np.isfinite(p).all(axis=1) & np.isfinite(q).all(axis=1))
    if not finite.all():
        p = np.where(finite[:, None], p, 0.0)
        q = np.where(finite[:, None], q, (1.0, 0.0, 0.0, 0.0))
    return p, q, finite


def _miss(robot: Robot, joints: Floats, quaternions: Floats) -> Floats:
    """(n,) degrees by which the nearest pose of a five-axis arm is turned; else 0."""
    if not robot.five_axis:
        return np.zeros(len(quaternions))
    _, q = five_fk(robot.lengths, np.radians(joints[:, 0].T + robot.zero))
    same = np.abs(np.einsum("ij,ij->i", q, quaternions))
    return np.asarray(2.0 * np.degrees(np.arccos(np.clip(same, 0.0, 1.0))))


def _span(robot: Robot, p: Floats, q: Floats) -> Floats:
    """Mm from axis 2 to the wrist centre, by the shorter way round axis 1."""
    w, x, y, z = q.T
    axis = np.stack(
        [2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)], axis=-1
    )
    wrist = p - robot.lengths.d6 * axis
    r = np.hypot(wrist[:, 0], wrist[:, 1]) - robot.lengths.a1
    return np.hypot(r, wrist[:, 2] - robot.lengths.d1)


def _branches_at(joints: Floats, robot: Robot) -> Truths:
    """(b,) which branches joints (a,) belong to; several at a singularity."""
    p, q = robot.fk(joints)
    found, _ = robot.solve(p, q)
    # Axis 5 instead of 4 and 6, which mean nothing by themselves where it is 0.
    compared = [i for i, axis in enumerate(robot.axes) if axis in ("J1", "J2", "J3", "J5")]
    off = found[compared, :, 0] - joints[compared, None]
    return np.asarray((np.abs(off - 360.0 * np.round(off / 360.0)) < 0.1).all(axis=0))


def _chain_starts(run: Run) -> Rows:
    first = run.kinds == Kind.JOINT
    first[:1] = True
    return np.flatnonzero(first)


def _cost(run: Run, robot: Robot, allowed: Truths) -> Floats:
    """(b,) seconds that the axes need to the first row and, sampled, along the path."""
    n = len(run)
    rows = np.unique(np.linspace(0, n - 1, min(n, SAMPLES)).astype(np.intp))
    p, q, _ = _finite(run, rows)
    joints, _ = robot.solve(p, q)
    speeds = robot.speeds[:, None, None]
    step = np.abs(np.diff(joints, axis=2, prepend=run.before[:, None, None] + joints[:, :, :1] * 0))
    turning = (robot.limits[:, 1] - robot.limits[:, 0] >= 360.0)[:, None, None]
    step = np.where(turning, np.minimum(step % 360.0, -step % 360.0), step)
    seconds = (step / speeds).max(axis=0)
    return np.asarray(np.where(allowed[:, rows], seconds, 0.0).sum(axis=1))


def _joints(run: Run, robot: Robot, branch: Rows) -> Floats:
    """(n, a) deg of the chosen branch, each axis nearest to the middle of its range."""
    out = np.full((len(run), len(robot.axes)), np.nan)
    for start in range(0, len(run), CHUNK):
        rows = slice(start, min(start + CHUNK, len(run)))
        p, q, _ = _finite(run, rows)
        chosen = branch[rows]
        solved = chosen >= 0
        if not solved.any():
            continue
        needed = tuple(int(b) for b in np.unique(chosen[solved]))
        found, _ = robot.solve(p, q, needed)
        at = np.searchsorted(needed, np.where(solved, chosen, needed[0]))
        joints = np.ascontiguousarray(found[:, at, np.arange(len(p))].T)
        joints[~(solved & robot.closes(joints, p, q))] = np.nan
        out[rows] = joints
    return out


def _turned(
    run: Run, robot: Robot, joints: Floats, starts: Rows, said: NDArray[np.integer]
) -> tuple[Floats, list[tuple[int, Rows]], Rows]:
    """Joints with their whole turns.

    With them, by axis, the rows before which it would be wound back, and the rows that
    state a quadrant (or turn) which their axes cannot have.
    """
    stated = said[:, BACK] != UNSTATED
    out = joints.copy()
    if not robot.five_axis:
        _straighten(out, float(run.before[3]), float(robot.limits[5].mean()))
    off = np.empty(0, np.intp)
    wanted: Floats | None = None
    free = ~stated
    if stated.any():
        wanted, fits = robot.turned(out, said)
        kept = stated & fits.all(axis=1) & robot.inside(wanted)
        off = np.flatnonzero(stated & ~kept & np.isfinite(out).all(axis=1) & run.exact_rows)
        free = ~kept
    wound = []
    for _, axis in robot.turning():
        angles = out[:, axis]
        turns = None
        if wanted is not None:
            whole = np.round((wanted[:, axis] - angles) / 360.0)
            turns = np.where(free, 0.0, whole).astype(np.int64)
            turns[free] = FREE
        low, high = (float(limit) for limit in robot.limits[axis])
        result = turn(angles, (low, high), starts, float(run.before[axis]), turns)
        out[:, axis] = result.angles
        wound.append((axis, result.broken))
    return out, wound, off


def _straighten(joints: Floats, before: float, middle: float) -> None:
    """Axes 4 and 6 in line: leaves axis 4 where it was and lets axis 6 do the turn, nearest to
    the middle of its range.
    """
    straight = np.abs(joints[:, 4]) < STRAIGHT
    if not straight.any():
        return
    four = np.where(straight, np.nan, joints[:, 3])
    held = filled(four) if np.isfinite(four).any() else np.full(len(four), before)
    moved = held - joints[:, 3]
    joints[straight, 3] = held[straight]
    six = joints[straight, 5] - moved[straight]
    joints[straight, 5] = six - 360.0 * np.round((six - middle) / 360.0)


def _not_as_stated(run: Run, robot: Robot, rows: Rows, found: NDArray[np.int8]) -> list[Diagnostic]:
    if not len(rows):
        return []
    row = int(rows[0])
    return [
        rules.NOT_AS_STATED(
            place=run.what(rows),
            robot=robot.title,
            where=run.label(row),
            stated=described(run.configurations[row]),
            cure=f"{described(found[row])} would work there; state it, or state none",
        )
    ]


def _other_quadrant(
    run: Run, robot: Robot, rows: Rows, found: NDArray[np.int8]
) -> list[Diagnostic]:
    if not len(rows):
        return []
    row = int(rows[0])
    return [
        rules.OTHER_QUADRANT(
            place=run.what(rows),
            robot=robot.title,
            where=run.label(row),
            stated=_quadrants(run.configurations[row]),
            found=_quadrants(found[row]),
        )
    ]


def described(row: NDArray[np.integer]) -> str:
    """A configuration in words."""
    c = configuration_of(row.astype(np.int8))
    if c is None:
        return "none"
    words = (
        "back" if c.back else "front",
        "elbow down" if c.down else "elbow up",
        "flip" if c.flip else "no flip",
    )
    return f"{', '.join(words)}, quadrants {_quadrants(row)}"


def _quadrants(row: NDArray[np.integer]) -> str:
    return " ".join(str(int(q)) for q in row[QUADRANTS])
