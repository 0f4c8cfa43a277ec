"""The arm branches that every row of a run allows, and the reason if it allows none.

Rows that need the rounding tolerance of their targets are few, so their joints are held in a table
(`RoundingTolerance`) beside the columns of all rows.
"""

from __future__ import annotations

from dataclasses import field, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from assistant.base.arrays import Floats, Rows, Singles, Truths, all_of, norms
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic
from assistant.program.geometry import Pose
from assistant.program.motion import Kind
from assistant.robots import findings as rules
from assistant.robots.arms.arm import CLOSING, MISS_TOLERANCE
from assistant.robots.motion.rounding_tolerance import (
    MOST_REGULAR_SHIFT,
    MOST_SHIFT,
    RoundedPoses,
    joints_within_rounding,
    looseness,
    roundings,
    split_wrist_roll,
)
from assistant.robots.motion.run import Run
from assistant.robots.motion.singularities import WRIST_PAIRS, directions
from assistant.robots.robot import CHUNK, IN_LINE, LIMIT_TOLERANCE, Robot

_MOST_BEYOND_REACH: Final = 0.2
"""mm that a pose may be out of reach by rounding at most."""
_AT_LIMIT_TOLERANCE: Final = 0.01
"""degrees or mm beyond a limit up to which a target is accepted at the limit, with a warning: its
printed decimals are no finer than that.
"""
_COARSE_ROUNDINGS: Final = 20.0
"""Roundings by which a target that is accepted at a limit may be missed."""
_STRAIGHT_WRIST_REST: Final = 2e-6
"""degrees of axis 5 that remain in a straight wrist, so that its branch can be determined."""


@dataclass(slots=True)
class RoundingTolerance:
    """Joints (m, a) deg that replace those of rows (m,) in branches (m,)."""

    rows: list[Rows] = field(default_factory=list)
    branches: list[Rows] = field(default_factory=list)
    joints: list[Floats] = field(default_factory=list)
    beyond: list[tuple[Rows, Rows, Floats]] = field(default_factory=list)
    """Rows (m,) that are accepted at a limit, their axes there, and how far they are beyond
    (m,).
    """

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
    wanted = _rounded_poses(run, robot, p, q, start + rows)
    place, turn = wanted.rounding.T
    lengths = robot.lengths
    lever = norms(wanted.arms) + abs(lengths.d6)
    tilt = (place + np.radians(turn) * lever) / np.hypot(lengths.a3, lengths.d4)
    line[:, rows] &= np.abs(joints[4][:, rows]) <= turn + np.degrees(tilt)
    branch, row = np.nonzero(line)
    four, five, six = joints[3:, branch, row]
    joints[4, branch, row] = np.where(
        np.abs(five) > _STRAIGHT_WRIST_REST, np.copysign(_STRAIGHT_WRIST_REST, five), five
    )
    low, high = robot.limits.T
    off = (four < low[3]) | (four > high[3]) | (six < low[5]) | (six > high[5])
    if off.any():
        limits = (np.broadcast_to(limit, (int(off.sum()), 6)) for limit in (low, high))
        roll = four[off] + robot.arm.rolls * six[off]
        new = split_wrist_roll(roll, four[off], (next(limits), next(limits)), robot.arm.rolls)
        joints[3, branch[off], row[off]], joints[5, branch[off], row[off]] = new
    return line


def _rounded_poses(run: Run, robot: Robot, p: Floats, q: Floats, rows: Rows) -> RoundedPoses:
    """Return the poses, with rounding, of some rows (k,) of a run, whose poses of the flange are
    (k, 3), (k, 4).
    """
    return RoundedPoses(p, q, run.mounting.arms(p, q, rows), roundings(robot, *run.targets(rows)))


def _take_rounded_rows(
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
    joints (a, b, m), changed in place as well. reached: (b, m) within reach but for
    `_MOST_BEYOND_REACH`.
    """
    p, q, joints = given
    low, high = robot.limits.T

    def settle(row: Rows, branch: Rows, box: tuple[Floats, Floats], coarser: float = 1.0) -> Rows:
        wanted = _rounded_poses(run, robot, p[row], q[row], start + row)
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
    wanted = _rounded_poses(run, robot, p[row], q[row], start + row)
    some = worst <= wanted.play * loose
    branch, row = branch[some], row[some]
    if len(row):
        settle(row, branch, _box(robot, row))
    branch, row, beyond = whole
    meant = np.where(own[row] >= 0, own[row] == branch, ~np.asarray(allowed.any(axis=0))[row])
    some = np.flatnonzero(
        (beyond.max(axis=1) <= _AT_LIMIT_TOLERANCE) & meant & ~allowed[branch, row]
    )
    branch, row, beyond = branch[some], row[some], beyond[some]
    if len(row):
        off = roundings(robot, *run.targets(start + row))[:, 0]
        printed = np.flatnonzero(off > CLOSING)
        branch, row, beyond = branch[printed], row[printed], beyond[printed]
    if len(row):
        met = settle(row, branch, _box(robot, row), _COARSE_ROUNDINGS)
        axis = beyond[met].argmax(axis=1)
        slack.beyond.append((start + row[met], axis, beyond[met, axis]))


def _box(robot: Robot, rows: Rows) -> tuple[Floats, Floats]:
    low, high = robot.limits.T
    return np.tile(low, (len(rows), 1)), np.tile(high, (len(rows), 1))


_MOST_NEAREST: Final = 3
"""Findings of a program that state the nearest pose that the robot can take instead."""


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
class NearestPoseCures:
    """The nearest poses that a robot can take, which take long to find, for the first findings.

    left: poses that are still looked for. told: pose, tip and whether the orientation is kept →
    what was found.
    """

    robot: Robot
    left: int = _MOST_NEAREST
    told: dict[tuple[Pose, Pose, bool], str] = field(default_factory=dict)

    def nearest(self, run: Run, row: int, *, keep: bool = False) -> str:
        """Return the text that a cure adds: the nearest reachable pose of the tip in the robot's
        base.
        """
        from assistant.robots.arms.nearest_pose import nearest_pose_text

        tip = run.mounting.tip(row)
        p, q = run.flange(np.array([row]))
        wanted = Pose.of(p[0], q[0]) @ tip
        key = wanted, tip, keep
        if key not in self.told:
            if not self.left:
                return ""
            self.left -= 1
            self.told[key] = nearest_pose_text(self.robot, wanted, tip, keep=keep)
        return f"; the nearest pose that it can take is {self.told[key]}"


@dataclass(slots=True)
class RowSurvey:
    """Result of a first check of every row.

    allowed: (b, n) branches inside reach and limits. bends: see `singularities.directions`; None
    for a run that needs none. slack: the joints of rows that are allowed by rounding alone.
    """

    allowed: Truths
    bends: Singles | None = None
    slack: RoundingTolerance = field(default_factory=RoundingTolerance)
    no_number: list[Rows] = field(default_factory=list)
    reach: _Worst = field(default_factory=_Worst)
    plane: _Worst = field(default_factory=_Worst)
    limits: _Worst = field(default_factory=_Worst)

    def findings(self, run: Run, robot: Robot, cures: NearestPoseCures) -> list[Diagnostic]:
        out = []
        if self.no_number:
            out.append(rules.NO_NUMBER(about=run.what(np.concatenate(self.no_number))))
        if self.reach.rows and not robot.arm.named:
            out.append(
                rules.UNSOLVED(
                    about=run.what(self.reach.all()),
                    robot=robot.title,
                    worst=self.reach.value,
                    where=run.label(self.reach.row),
                    nearest=cures.nearest(run, self.reach.row, keep=True),
                )
            )
        elif self.reach.rows:
            far = bool(self.reach.fields["far"])
            need = robot.reach + self.reach.value
            cure = f"move the work piece or the robot, or take one that reaches {need:.0f} mm"
            out.append(
                rules.OUT_OF_REACH(
                    about=run.what(self.reach.all()),
                    robot=robot.title,
                    worst=distance_text(self.reach.value),
                    side="too far out" if far else "too near to the arm",
                    where=run.label(self.reach.row),
                    cure=(cure if far else "move the work piece away from the arm")
                    + cures.nearest(run, self.reach.row, keep=True),
                )
            )
        if self.plane.rows:
            about, where = run.what(self.plane.all()), run.label(self.plane.row)
            worst = self.plane.value
            if robot.five_axis:
                nearest = cures.nearest(run, self.plane.row)
                finding = rules.NOT_IN_PLANE(about=about, worst=worst, where=where, nearest=nearest)
            else:
                finding = rules.TILTED(about=about, worst=worst, where=where, robot=robot.title)
            out.append(finding)
        if self.slack.beyond:
            rows, axes, over = (
                np.concatenate(columns) for columns in zip(*self.slack.beyond, strict=True)
            )
            at = int(over.argmax()) if len(over) else 0
            if len(over):
                axis = int(axes[at])
                out.append(
                    rules.AT_LIMIT(
                        about=run.what(np.unique(rows)),
                        axis=robot.axes[axis],
                        unit=robot.units[axis],
                        over=float(over[at]),
                        where=run.label(int(rows[at])),
                    )
                )
        if self.limits.rows:
            axis, value = int(self.limits.fields["axis"]), float(self.limits.fields["angle"])  # type: ignore[call-overload,arg-type]
            low, high = robot.limits[axis]
            out.append(
                rules.OUTSIDE_LIMITS(
                    about=run.what(self.limits.all()),
                    robot=robot.title,
                    axis=robot.axes[axis],
                    unit=robot.units[axis],
                    value=value,
                    limit=low if value < low else high,
                    where=run.label(self.limits.row),
                    nearest=cures.nearest(run, self.limits.row),
                    turn=_turn_of_tool(run, self.limits.row, axis == len(robot.axes) - 1),
                )
            )
        return out


def _turn_of_tool(run: Run, row: int, last: bool) -> str:
    """Return the change of a tool's orientation that may help an axis. last: it is the last one.

    A turn about the axis of the flange, where the tool has the same, moves the last axis alone.
    """
    mounting = run.mounting
    tip = mounting.tip(row)
    aligned = max(map(abs, tip.position[:2])) < 1e-6 and max(map(abs, tip.quaternion[1:3])) < 1e-9
    if aligned and not last and mounting.tools[mounting.tool[row]].held:
        return "tilt the tool"
    return "turn the tool about its axis"


def survey_rows(run: Run, robot: Robot, own: Rows) -> tuple[RowSurvey, Singles]:
    """A survey, and the joints (a, b, n) of every branch; of one not allowed they mean nothing.

    own: (n,) the branch that a row states, or -1.
    """
    shape = (robot.branches, len(run))
    every = np.empty((len(robot.axes), *shape), dtype=np.float32)
    survey = RowSurvey(np.zeros(shape, dtype=bool))
    if robot.arm.spherical and (run.kinds != Kind.JOINT).any():
        survey.bends = np.zeros((WRIST_PAIRS, 2, len(run)), dtype=np.float32)
    low, high = (limit[:, None, None] for limit in robot.limits.T)
    for start in range(0, len(run), CHUNK):
        rows = slice(start, min(start + CHUNK, len(run)))
        p, q, finite = finite_poses(run, rows)
        joints, excess = robot.solve(p, q)
        if robot.arm.spherical:
            straighten_wrists(run, robot, joints, start)
        beyond = low - joints
        np.maximum(beyond, joints - high, out=beyond)
        reached = excess < CLOSING / 2.0
        allowed = reached & (beyond <= LIMIT_TOLERANCE).all(axis=0) & finite
        missed = robot.arm.miss(robot.chained(joints[:, 0].T), q)
        allowed &= missed <= MISS_TOLERANCE
        if robot.arm.named:
            able = (excess < _MOST_BEYOND_REACH) & finite & (missed <= MISS_TOLERANCE)
            _take_rounded_rows(
                run, robot, survey.slack, own[rows], start, (p, q, joints), able, allowed
            )
        survey.allowed[:, rows] = allowed
        every[:, :, rows] = joints
        if survey.bends is not None:
            survey.bends[:, :, rows] = directions(joints)
        bad = np.flatnonzero(~allowed.any(axis=0))
        if not len(bad):
            continue
        if not finite.all():
            survey.no_number.append(start + np.flatnonzero(~finite))
        bad = bad[finite[bad]]
        least = excess[:, bad].min(axis=0)
        far = bad[least >= CLOSING / 2.0]
        survey.reach.add(
            start + far,
            least[least >= CLOSING / 2.0],
            far=robot.arm.too_far(p[far], q[far]),
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
    return survey, every


def distance_text(millimetres: float) -> str:
    """A distance that is not 0, in as many decimals as show it."""
    return f"{millimetres:.1f}" if millimetres >= 0.1 else f"{millimetres:.2g}"


def finite_poses(run: Run, rows: slice | Rows) -> tuple[Floats, Floats, Truths]:
    """Return the poses of the flange; those that are not finite are replaced and marked False."""
    p, q = run.flange(rows)
    finite = np.asarray(all_of(np.isfinite(p)) & all_of(np.isfinite(q)))
    if not finite.all():
        p = np.where(finite[:, None], p, 0.0)
        q = np.where(finite[:, None], q, (1.0, 0.0, 0.0, 0.0))
    return p, q, finite
