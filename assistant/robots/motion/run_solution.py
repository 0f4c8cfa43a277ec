"""Joints and configurations of a run of moves, with findings for what the robot cannot do.

Two passes over the columns, a chunk at a time: the first finds which arm branches every row allows,
then a branch is chosen for each row, and the second computes its joints.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from assistant.base import rotations
from assistant.base.arrays import Floats, Rows, Truths, all_of, any_of
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Severity
from assistant.program.motion import UNSTATED
from assistant.robots import findings as rules
from assistant.robots.arms.arm import CLOSING
from assistant.robots.configurations import BACK, QUADRANTS
from assistant.robots.motion.between_targets import MotionBetweenTargets, motion_between_targets
from assistant.robots.motion.branch_choice import Choice, Choices, chain_starts, choices
from assistant.robots.motion.branch_sequence import (
    LIMIT_CLEARANCE,
    TURNS_NOT_STATED,
    add_whole_turns,
    filled_forward,
    may_be_quicker,
    open_turns,
    quickest_turns,
)
from assistant.robots.motion.rounding_tolerance import split_wrist_roll
from assistant.robots.motion.row_reach import (
    NearestPoseCures,
    RoundingTolerance,
    finite_poses,
    straighten_wrists,
    survey_rows,
)
from assistant.robots.motion.run import Run, continued
from assistant.robots.robot import CHUNK, IN_LINE, LIMIT_TOLERANCE, Robot

_MOST_ROWS_RETRIED: Final = 20_000
"""Rows of a run up to which other branches are tried, where one fails between the rows or turns
have to be longer than they could be."""


_Sweep = tuple[float, float] | None
"""Least and greatest deg of an axis along linear moves; None if it is not known."""


@dataclass(frozen=True, slots=True)
class RunSolution:
    """Solution of a run. joints: (n, a) deg, NaN if missing. configurations: (n, 6), as stated,
    else those of the joints, UNSTATED if missing.
    """

    joints: Floats
    configurations: NDArray[np.int8]
    findings: tuple[Diagnostic, ...]


def solve_run(
    run: Run, robot: Robot, cures: NearestPoseCures, theirs: Truths | None = None
) -> RunSolution:
    """Choose the configurations that a run of at least one move leaves open.

    Moves that cannot be done are reported; for rows that state their branches a change of branch is
    only a warning: their controller may be configured to allow it. theirs: (n,) rows that state
    them, if configurations have other sources as well; None: all that have one.
    """
    stated = np.asarray(run.configurations[:, BACK] != UNSTATED) & robot.arm.named
    own = np.where(stated, robot.branch_of(run.configurations), -1)
    survey, every = survey_rows(run, robot, own)
    kept = stated & survey.allowed[own, np.arange(len(run))]
    plan = choices(run, robot, survey, every, np.where(kept, own, -1))
    first, slack = plan.best(), survey.slack
    others = plan if len(run) <= _MOST_ROWS_RETRIED else None
    del every, plan  # of long runs the largest columns
    report = survey.findings(run, robot, cures)
    said = np.where(kept[:, None], run.configurations, UNSTATED)
    given = _RunProblem(said, slack, look=not report)
    done = _best(run, robot, first, others, given)
    report += done.findings
    joints, broken = done.joints, done.choice.broken
    found = robot.configuration(np.nan_to_num(joints))
    solved = all_of(np.isfinite(joints))
    fill = ~stated & solved & robot.arm.named
    configurations = np.where(fill[:, None], found, run.configurations)
    report += _not_as_stated(run, robot, np.flatnonzero(stated & ~kept & solved), found)
    report += _other_quadrant(run, robot, done.off, found)
    free = (kept if theirs is None else kept & theirs)[broken]
    for rows, severity in ((broken[~free], None), (broken[free], Severity.WARNING)):
        if len(rows):
            report.append(_branch_change(run, robot, rows, joints, severity))
    if not robot.arm.named:
        report.append(rules.UNNAMED(robot=robot.title))
    if len(done.choice.through):
        through = run.what(done.choice.through)
        report.append(rules.THROUGH_WRIST(about=through, robot=robot.title))
    report += [_wound_up(run, robot, *one) for one in done.wound if len(one[1])]
    return RunSolution(joints, configurations, tuple(report))


@dataclass(frozen=True, slots=True)
class _Attempt:
    """A choice of branches with the results of a closer check.

    joints: (n, a) deg. wound: by axis, the rows before which it would be wound back, and its sweep
    along the moves there. off: rows that
    state a quadrant (or turn) which their axes cannot have. bad: rows that have no path to them in
    the chosen branch. longer: whether a joint move takes longer than in the short direction.
    """

    choice: Choice
    joints: Floats
    wound: list[tuple[int, Rows, _Sweep]]
    off: Rows
    bad: Rows
    longer: bool
    findings: tuple[Diagnostic, ...]


@dataclass(frozen=True, slots=True)
class _RunProblem:
    """Inputs with which every choice of branches is tried.

    said: (n, 6) configurations that rows state and can have, else UNSTATED. slack: see `RowSurvey`.
    look: True to check the motion between the rows.
    """

    said: NDArray[np.integer]
    slack: RoundingTolerance
    look: bool


def _best(
    run: Run, robot: Robot, choice: Choice, others: Choices | None, given: _RunProblem
) -> _Attempt:
    """The choice with the fewest rows to which there is no way, the cheapest of these.

    A choice knows the rows, not what is between them: what turns out to be no way is ruled out
    and the next choice out of others tried. Nor does it know what whole turns cost, which counts
    where joint moves are not all as short as they could be.
    """
    best = last = _attempt(run, robot, choice, given)
    for _ in range(robot.branches):
        if others is None or not len(last.bad) or len(last.choice.broken):
            break
        if not others.bar(last.choice, last.bad):
            break
        last = _attempt(run, robot, others.best(), given)
        if len(last.bad) < len(best.bad) and not len(last.choice.broken):
            best = last
    if others is None or len(best.bad) or len(best.choice.broken) or not best.longer:
        return best
    quickest = others.quickest(given.said)
    if quickest is None or np.array_equal(quickest.branches, best.choice.branches):
        return best
    last = _attempt(run, robot, quickest, given)
    worse = len(last.bad) or len(last.choice.broken) or last.findings
    return best if worse else last


def _attempt(run: Run, robot: Robot, choice: Choice, given: _RunProblem) -> _Attempt:
    findings: list[Diagnostic] = []
    joints, straight = _joints(run, robot, choice.branches, given.slack)
    lost = np.flatnonzero((choice.branches >= 0) & any_of(np.isnan(joints)))
    if len(lost):
        where = run.label(int(lost[0]))
        findings.append(rules.NOT_CLOSED(about=run.what(lost), robot=robot.title, where=where))
    way = None
    if given.look and not findings and not len(choice.broken):
        way = motion_between_targets(run, robot, joints, choice.branches)
    joints, unmet, off = _turned(run, robot, joints, straight, given.said, way)
    bad = np.empty(0, np.intp)
    if way is not None:
        bad, faults = way.faults(run, robot, joints)
        findings += faults
    wound = []
    for axis, rows, sweep in unmet:
        if continued(run) and abs(joints[0, axis] - run.before[axis]) > 180.0:
            rows, sweep = np.append(0, rows), None
        wound.append((axis, np.setdiff1d(rows, choice.broken), sweep))
    bad = np.unique(np.concatenate([bad, *(rows for _, rows, _ in wound)]))
    longer = may_be_quicker(run, robot, joints, chain_starts(run))
    return _Attempt(choice, joints, wound, off, bad, longer, tuple(findings))


def _joints(
    run: Run, robot: Robot, branch: Rows, slack: RoundingTolerance
) -> tuple[Floats, Truths]:
    """(n, a) deg of the chosen branch, each axis nearest to the middle of its range, but for rows
    that are settled otherwise; and in which rows (n,) the wrist is straight.
    """
    out = np.full((len(run), len(robot.axes)), np.nan)
    line = np.zeros(len(run), dtype=bool)
    for start in range(0, len(run), CHUNK):
        rows = slice(start, min(start + CHUNK, len(run)))
        p, q, _ = finite_poses(run, rows)
        chosen = branch[rows]
        solved = chosen >= 0
        if not solved.any():
            continue
        needed = tuple(int(b) for b in np.unique(chosen[solved]))
        found, _ = robot.solve(p, q, needed)
        at = np.searchsorted(needed, np.where(solved, chosen, needed[0]))
        joints = np.ascontiguousarray(found[:, at, np.arange(len(p))].T)
        joints[~(solved & robot.closes(joints, p, q))] = np.nan
        if robot.arm.spherical:
            line[rows] = straighten_wrists(run, robot, joints.T[:, None], start)[0]
        out[rows] = joints
    slack.put(out, branch)
    return out, line


def _turned(
    run: Run,
    robot: Robot,
    joints: Floats,
    straight: Truths,
    said: NDArray[np.integer],
    way: MotionBetweenTargets | None,
) -> tuple[Floats, list[tuple[int, Rows, _Sweep]], Rows]:
    """Joints with their whole turns.

    With them, by axis, the rows before which it would be wound back with its sweep, and the rows
    that state a quadrant (or turn) which their axes cannot have.
    """
    stated = said[:, BACK] != UNSTATED
    out = joints.copy()
    if straight.any():
        _hold(out, straight, float(run.before[3]), robot, np.where(stated[:, None], said, UNSTATED))
    off = np.empty(0, np.intp)
    wanted: Floats | None = None
    free = ~stated
    if stated.any():
        wanted, fits = robot.turned(out, said)
        if robot.arm.spherical:  # their sum counts, which any quadrants of both may have
            fits[np.abs(out[:, 4]) < IN_LINE, 1:] = True
        kept = stated & fits.all(axis=1) & robot.inside(wanted)
        off = np.flatnonzero(stated & ~kept & np.isfinite(out).all(axis=1) & run.exact_rows)
        free = ~kept
    wound, options = [], []
    starts, plain = chain_starts(run), out.copy()
    for axis in robot.winding():
        angles = plain[:, axis]
        turns = None
        if wanted is not None:
            whole = np.round((wanted[:, axis] - angles) / 360.0)
            turns = np.where(free, 0.0, whole).astype(np.int64)
            turns[free] = TURNS_NOT_STATED
        low, high = (float(limit) for limit in robot.limits[axis])
        near = float(run.before[axis])
        moving = way.of(axis, len(out)) if way is not None and len(way.rows) else None
        result = add_whole_turns(angles, (low, high), starts, near, turns, moving)
        out[:, axis] = result.angles
        wound.append((axis, result.broken, result.sweep))
        options.append((angles, (low, high), starts, turns, moving))
    if not any(len(rows) for _, rows, _ in wound) and may_be_quicker(run, robot, out, starts):
        quicker = quickest_turns(run, robot, plain, starts, [open_turns(*each) for each in options])
        out = out if quicker is None else quicker
    return out, wound, off


def _hold(
    joints: Floats, straight: Truths, before: float, robot: Robot, said: NDArray[np.integer]
) -> None:
    """Hold axis 4 where axes 4 and 6 are in line, as far as limits and stated configurations allow,
    and let axis 6 do the turn, nearest to the middle of its range.
    """
    four = np.where(straight, np.nan, joints[:, 3])
    rows = np.flatnonzero(straight)
    held = filled_forward(four)[rows] if np.isfinite(four).any() else np.full(len(rows), before)
    stated = said[rows, BACK] != UNSTATED
    low, high = (np.tile(limit, (len(rows), 1)) for limit in robot.limits.T)
    if stated.any():
        low[stated], high[stated] = robot.ranges(said[rows[stated]])
    roll = joints[rows, 3] + robot.arm.rolls * joints[rows, 5]
    new = joints[rows].copy()
    new[:, 3], new[:, 5] = split_wrist_roll(roll, held, (low, high), robot.arm.rolls)
    inside = ((new >= low - LIMIT_TOLERANCE) & (new <= high + LIMIT_TOLERANCE))[:, 3::2].all(axis=1)
    for axis in (3, 5):
        middle = float(robot.limits[axis].mean())
        new[:, axis] -= 360.0 * np.round((new[:, axis] - middle) / 360.0)
    joints[rows[inside]] = new[inside]


def _wound_up(run: Run, robot: Robot, axis: int, rows: Rows, sweep: _Sweep) -> Diagnostic:
    """Return the finding about an axis that would be wound back, with a computed cure."""
    low, high = robot.limits[axis].tolist()
    name, more = robot.axes[axis], ""
    if sweep is not None and sweep[1] - sweep[0] > high - low - 2.0 * LIMIT_CLEARANCE:
        more = f" where {name} is near a limit: the moves turn it by {sweep[1] - sweep[0]:.0f}"
        more += f" degrees in all, and it has {high - low:.0f}"
    elif sweep is not None:
        more = _turn_cure(run, robot, axis, int(rows[0]), sweep)
    return rules.WOUND_UP(about=run.what(rows), axis=name, low=low, high=high, more=more)


def _turn_cure(run: Run, robot: Robot, axis: int, row: int, sweep: tuple[float, float]) -> str:
    """Return by how much a turn of the work or of the tool brings an axis inside its limits; empty
    for an axis that neither turns alone.
    """
    tool = run.mounting.tools[run.mounting.tool[row]]
    frame = run.mounting.frames[run.mounting.frame[row]]
    if not tool.held or frame.held or frame.mechanism:
        return ""
    low, high = robot.limits[axis].tolist()
    whole = 360.0 * np.arange(-3, 4)
    least, most = low - sweep[0] + LIMIT_CLEARANCE, high - sweep[1] - LIMIT_CLEARANCE
    shifts = np.clip(0.0, least + whole, most + whole)
    shift = float(shifts[np.abs(shifts).argmin()])
    degrees = math.copysign(math.ceil(abs(shift)), shift)
    # Bent, as axes that are in line only when the arm is straight turn about different lines.
    ends = np.full((2, len(robot.axes)), _BENT)
    ends[1, axis] += 1.0
    (p, moved), (q, turned) = robot.flange_poses(ends)
    back = rotations.conjugate(q)
    in_base, in_flange = rotations.multiply(turned, back), rotations.multiply(back, turned)
    if _is_about_z(in_base) and np.allclose(rotations.rotate(in_base, p), moved, atol=1e-6):
        angle = degrees * np.sign(in_base[0] * in_base[3])
        return f", or turn the work piece by {angle:.0f} degrees about z of the robot's base"
    if _is_about_z(in_flange) and np.allclose(p, moved, atol=1e-6):
        angle = -degrees * np.sign(in_flange[0] * in_flange[3])
        return f", or mount the tool turned by {angle:.0f} degrees about z of the flange"
    return ""


_BENT: Final = 20.0
"""Degrees of each axis, or millimetres, of an arm with no two axes in line."""


def _is_about_z(quaternion: Floats) -> bool:
    return bool(np.abs(quaternion[1:3]).max() < 1e-9)


def _branch_change(
    run: Run, robot: Robot, rows: Rows, joints: Floats, severity: Severity | None
) -> Diagnostic:
    """Return the finding why the first of some rows cannot have the branch of the row before it."""
    row = int(rows[0])
    solved = np.flatnonzero(np.isfinite(joints[:row]).all(axis=1))
    last = joints[solved[-1]] if len(solved) else run.before
    before = robot.configuration(last)
    branch = int(robot.branch_of(before)[0])
    p, q, _ = finite_poses(run, slice(row, row + 1))
    found, excess = robot.solve(p, q, (branch,))
    angles = found[:, 0, 0]
    low, high = robot.limits.T
    beyond = np.maximum(low - angles, angles - high)
    axis = int(beyond.argmax())
    if excess[0, 0] >= CLOSING / 2.0:
        reason = f"is {excess[0, 0]:.1f} mm short of it"
    elif beyond[axis] > LIMIT_TOLERANCE:
        limit = low[axis] if angles[axis] < low[axis] else high[axis]
        value = f"{angles[axis]:.2f} {robot.units[axis]}"
        reason = f"would have {robot.axes[axis]} at {value}, limit {limit:g}"
    else:
        reason = "is not what is stated or what the rest of the path allows"
    return rules.BRANCH_CHANGE(
        about=run.what(rows),
        severity=severity,
        robot=robot.title,
        branch=robot.arm.words(before[0, : QUADRANTS.start]),
        reason=reason,
        where=run.label(row),
    )


def _not_as_stated(run: Run, robot: Robot, rows: Rows, found: NDArray[np.int8]) -> list[Diagnostic]:
    if not len(rows):
        return []
    row = int(rows[0])
    return [
        rules.NOT_AS_STATED(
            about=run.what(rows),
            robot=robot.title,
            where=run.label(row),
            stated=_described(run.configurations[row], robot),
            cure=f"{_described(found[row], robot)} would work there; state it, or state none",
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
            about=run.what(rows),
            robot=robot.title,
            where=run.label(row),
            # A turn that does not fit can only be one beyond the limits.
            severity=Severity.ERROR if robot.counts == "turns" else None,
            counts=robot.counts,
            stated=_counted(run.configurations[row], robot),
            found=_counted(found[row], robot),
        )
    ]


def _described(row: NDArray[np.integer], robot: Robot) -> str:
    """A configuration in words."""
    return f"{robot.arm.words(row[: QUADRANTS.start])}, {robot.counts} {_counted(row, robot)}"


def _counted(row: NDArray[np.integer], robot: Robot) -> str:
    """Quadrants, or for a maker that counts only those, whole turns of axes 1, 4 and 6."""
    quadrants = [int(q) for q in row[QUADRANTS]]
    counts = quadrants if robot.counts == "quadrants" else [(q + 2) // 4 for q in quadrants]
    return " ".join(str(count) for count in counts)
