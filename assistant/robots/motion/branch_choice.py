"""Choose the arm branches of a run among those that its rows allow, by joint travel.

Costs are seconds of the slowest axis at its full speed. A linear or circular move goes the short
way round from row to row; in a joint move, an axis that turns further than once takes the windings
that its limits allow the chains on both sides of the move. Singularities, unreachable rows and
broken chains cost extra.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import field
from typing import Final

import numpy as np
from numpy.typing import NDArray

from assistant.base.arrays import Floats, Ints, Rows, Singles, Truths
from assistant.base.data_classes import dataclass
from assistant.program.motion import UNSTATED, Kind
from assistant.robots.configurations import BACK
from assistant.robots.motion.between_targets import confirmed_crossings
from assistant.robots.motion.branch_sequence import (
    BRANCH_CHANGE_COST,
    LIMIT_CLEARANCE,
    BranchChains,
    BranchCosts,
    choose_branches,
)
from assistant.robots.motion.row_reach import RowSurvey
from assistant.robots.motion.run import Run, continued
from assistant.robots.motion.singularities import connected_branches, crossings, least_bends
from assistant.robots.robot import CHUNK, Robot

_NEAR_SINGULARITY: Final = 10.0
"""degrees of axis 5, or of the elbow from stretched or folded, within which a linear or circular
move is near the singularity there. (The singularity over axis 1 is the same in all branches.)"""
_SINGULARITY_COST: Final = 20.0
"""Seconds of joint travel that a chain may make instead of touching a singularity; less with the
square of the distance: a quarter at half of `_NEAR_SINGULARITY`."""
_WRIST_SINGULARITY_COST: Final = 1e3
"""Seconds instead of going straight through the wrist singularity, where a controller may stop."""
_WINDING_COST: Final = 1e5
"""Seconds instead of winding an axis back within a linear or circular move, which is no way."""
_BARRED_COST: Final = 10.0 * _WINDING_COST
"""Seconds instead of a way that a closer look has ruled out: of what winds back by its ends alone
the way may still be one."""
_WRIST_STRAIGHT: Final = 1e-4
"""degrees of axis 5 below which axis 4 stays where it was before."""
_SINGLE_PRECISION: Final = 1e-3
"""degrees; the columns are of single precision."""
_JOINT_MOVES_AT_ONCE: Final = 512
"""Chains whose joint moves are computed at once: 64 pairs of branches stay in the cache."""
_BRANCHES_ALIKE: Final = (4, 2, 2, 1, 1, 1)
"""Number of consecutive branches with the same angle of each axis, of an arm with a spherical
wrist.
"""
_FREE_RANGE: Final = 540.0
"""degrees between the limits of an axis from which on it can go the short way round between any
two angles within half a turn of its middle: one of the two can be wound towards the other."""
_TURNS_PER_DEGREE: Final = np.float32(1.0 / 360.0)

_Windings = tuple[NDArray[np.int8], NDArray[np.int8]]
StatedTurns = tuple[Rows, Rows, Ints]
"""Turns of an axis (k,) that rows state: their branches (k,), the rows (k,), and the turns beyond
what `Travel.joints` say there."""


@dataclass(frozen=True, slots=True)
class JointTravel:
    """The rows of a path in every branch.

    joints: (a, b, n), axes 1, 4 and 6 without a break within a chain. steps: (b, n) seconds from
    the row before, 0 at the first row of a chain. bent: (b / 2, n) the least angle in degrees on
    the way to a row between the arm and a singularity, the same for both branches of the wrist;
    None for an arm that no branch keeps off one. crossed: (b / 2, n) whether a row is reached
    through the wrist singularity.
    """

    run: Run
    robot: Robot
    joints: Singles
    steps: Singles | None
    bent: Singles | None
    crossed: Truths | None

    def costs(self, starts: Rows) -> BranchCosts:
        """Costs of the chains with these first rows."""
        count = len(self.run)
        chains = np.zeros((self.robot.branches, len(starts)))
        if self.steps is not None:
            chains += np.add.reduceat(self.steps, starts, axis=1, dtype=np.float64)
            chains -= self.steps[:, starts]  # what leads to the chain is no part of it
        lengths = np.diff(np.append(starts, count))
        moved = lengths > 1
        moved[0] |= bool(self.run.kinds[0] != Kind.JOINT)
        if self.bent is not None and moved.any():
            least = np.minimum.reduceat(self.bent, starts, axis=1)
            near = np.repeat(np.clip(1.0 - least / _NEAR_SINGULARITY, 0.0, 1.0), 2, axis=0)
            chains += np.where(moved, _SINGULARITY_COST * near * near, 0.0)
        if self.crossed is not None:
            often = np.add.reduceat(self.crossed, starts, axis=1, dtype=np.float64)
            chains += np.repeat(_WRIST_SINGULARITY_COST * often, 2, axis=0)
        windings: dict[int, _Windings | None] = {}
        for axis in self.robot.winding():
            span = np.ptp(self.robot.limits[axis])
            if len(starts) == count and span >= _FREE_RANGE:
                windings[axis] = None
            elif len(starts) < count or span >= 360.0:
                least_turns, most = self._windings(axis, starts)
                stuck = most < least_turns
                chains += np.where(stuck, _WINDING_COST, 0.0)
                if span >= 360.0:
                    windings[axis] = np.where(stuck, 0, least_turns), np.where(stuck, 0, most)
        ways = _ChainMoves(self, starts, np.append(starts[1:], count) - 1, windings)
        return BranchCosts(ways.first(), chains, ways.between)

    def chains(self, starts: Rows, within: Floats, stated: Sequence[StatedTurns]) -> BranchChains:
        """The chains with these first rows, of (b, c) seconds, infinite where one is not possible.

        stated: of each winding axis.
        """
        least, most = [], []
        for axis, (branch, row, turns) in zip(self.robot.winding(), stated, strict=True):
            fewest, greatest = (each.astype(np.int64) for each in self._windings(axis, starts))
            clear = self._windings(axis, starts, LIMIT_CLEARANCE)
            fewest, greatest = (
                np.where(clear[0] <= clear[1], *each)
                for each in zip(clear, (fewest, greatest), strict=True)
            )
            at = branch, np.searchsorted(starts, row, side="right") - 1
            fewest[at], greatest[at] = -1000, 1000
            np.maximum.at(fewest, at, turns)
            np.minimum.at(greatest, at, turns)
            stuck = greatest < fewest
            least.append(np.where(stuck, 0, fewest))
            most.append(np.where(stuck, 0, greatest))
        ends = np.append(starts[1:], len(self.run)) - 1
        firsts, lasts = self.joints[:, :, starts], self.joints[:, :, ends]
        opened = np.stack(least), np.stack(most)
        return BranchChains(self.run, self.robot, firsts, lasts, *opened, within)

    def _windings(self, axis: int, starts: Rows, inside: float = -_SINGLE_PRECISION) -> _Windings:
        """(b, c) the least and the greatest turns that all rows of a chain may be wound by, so
        many degrees inside the limits.
        """
        low, high = self.robot.limits[axis] + (inside, -inside)
        least = np.zeros((self.robot.branches, len(starts)), dtype=np.int8)
        most = np.zeros_like(least)
        for branch, angles in enumerate(self.joints[axis]):
            lows = highs = angles
            if len(starts) < len(angles):
                lows, highs = (f.reduceat(angles, starts) for f in (np.minimum, np.maximum))
            least[branch], most[branch] = _shifts((low, high), lows, highs)
        return least, most


@dataclass(frozen=True, slots=True)
class _ChainMoves:
    """Joint moves between chains.

    firsts, lasts: (c,) rows. windings: axis → least and most turns; None for one that can always
    go the short way round.
    """

    travel: JointTravel
    firsts: Rows
    lasts: Rows
    windings: dict[int, _Windings | None]

    def first(self) -> Floats:
        """(b,) seconds from where the arm is; `BRANCH_CHANGE_COST` more in another branch."""
        robot, before = self.travel.robot, self.travel.run.before
        seconds = np.zeros(robot.branches)
        for axis, speed in enumerate(robot.speeds):
            angles = self.travel.joints[axis, :, self.firsts[0]]
            off = angles - before[axis]
            if axis in self.windings:
                low, high = robot.limits[axis] + (-_SINGLE_PRECISION, _SINGLE_PRECISION)
                shifts = self.windings[axis] or _shifts(
                    (low, high), angles[:, None], angles[:, None]
                )
                least, most = (turns[:, 0] for turns in shifts)
                off = off + 360.0 * np.clip(np.rint(-off / 360.0), least, most)
            seconds = np.maximum(seconds, np.abs(off) / speed)
        seconds[np.arange(robot.branches) != robot.branch_of(robot.configuration(before))] += (
            BRANCH_CHANGE_COST
        )
        return seconds

    def between(self, chains: Rows) -> Singles:
        """(b, b, m) seconds from the chain before to each of m chains."""
        branches = self.travel.robot.branches
        out = np.zeros((branches, branches, len(chains)), dtype=np.float32)
        for start in range(0, len(chains), _JOINT_MOVES_AT_ONCE):
            part = slice(start, start + _JOINT_MOVES_AT_ONCE)
            for axis in range(len(self.travel.robot.axes)):
                self._axis(axis, chains[part], out[:, :, part])
        return out

    def _axis(self, axis: int, chains: Rows, out: Singles) -> None:
        """Raises what `between` gives to the seconds of one axis."""
        joints, speed = self.travel.joints[axis], self.travel.robot.speeds[axis]
        alike = _BRANCHES_ALIKE[axis] if self.travel.robot.arm.spherical else 1
        unit = np.float32(360.0 if axis in self.windings else speed)
        last = joints[::alike, self.lasts[chains - 1]] / unit
        first = joints[::alike, self.firsts[chains]] / unit
        step = first[None] - last[:, None]
        if axis in self.windings:
            turns = np.rint(step)
            known = self.windings[axis]
            if known is not None:
                least, most = (each[::alike] for each in known)
                np.maximum(turns, _apart(least[:, chains - 1], most[:, chains]), out=turns)
                np.minimum(turns, _apart(most[:, chains - 1], least[:, chains]), out=turns)
            step -= turns
            step *= np.float32(360.0 / speed)
        np.abs(step, out=step)
        some, m = len(step), len(chains)
        spread = out.reshape(some, alike, some, alike, m)
        np.maximum(spread, step[:, None, :, None], out=spread)


def _shifts(limits: tuple[float, float], lows: Singles, highs: Singles) -> tuple[Singles, Singles]:
    """The least and the greatest whole turns by which lows to highs are within limits, degrees."""
    low, high = limits
    least = np.ceil(np.float32(low / 360.0) - lows * _TURNS_PER_DEGREE)
    most = np.floor(np.float32(high / 360.0) - highs * _TURNS_PER_DEGREE)
    return np.clip(least, -100.0, 100.0), np.clip(most, -100.0, 100.0)


def _apart(of: NDArray[np.int8], to: NDArray[np.int8]) -> Singles:
    """(b, b, m) the first (b, m) less the second, each with each."""
    return np.asarray(of.astype(np.float32)[:, None] - to.astype(np.float32)[None])


def _joint_travel(
    run: Run,
    robot: Robot,
    joints: Singles,
    solved: Truths,
    starts: Rows,
    sheet: Rows | None,
    clear: Singles | None,
    crossed: Truths | None,
) -> JointTravel:
    """Travel along a run.

    joints: (a, b, n) of all branches, each axis nearest to the middle of its range; taken over
    and changed. solved: (n,) rows that have any. starts: (c,) first rows of the chains. sheet:
    see `connected_branches`. clear: (b / 2, n) sine of the least angle of axis 5 on the way to a
    row, taken over. crossed: (b / 2, n).
    """
    if not solved.all():
        held = _held(solved, starts)
        for each in joints.reshape(-1, len(run)):
            each[:] = each[held]
    steps = _unwound(robot, joints, starts, sheet)
    bent = None
    if clear is not None:
        bent = np.minimum(clear, np.float32(1.0), out=clear)
        np.degrees(np.arcsin(bent, out=bent), out=bent)
        elbow = _elbow(robot, joints)
        if elbow is not None:
            np.minimum(bent, elbow, out=bent)
        bent[:, ~solved] = 90.0
    return JointTravel(run, robot, joints, steps, bent, crossed)


def _held(solved: Truths, starts: Rows) -> Rows:
    """(n,) for each row itself, or where it has no joints the nearest row of its chain that has."""
    n = len(solved)
    row = np.arange(n)
    last = np.maximum.accumulate(np.where(solved, row, -1))
    following = np.minimum.accumulate(np.where(solved, row, n)[::-1])[::-1]
    start = np.repeat(starts, np.diff(np.append(starts, n)))
    held = np.where((last < start) & (following < n), following, last)
    return np.where(held < 0, row, held)


def _unwound(robot: Robot, joints: Singles, starts: Rows, sheet: Rows | None) -> Singles | None:
    """(b, n) seconds from row to row within chains, 0 at their first rows; None without others.

    joints (a, b, n) are put along the sheets and their axes 1, 4 and 6 unwound within each chain.
    """
    n = joints.shape[2]
    begins = np.zeros(n, dtype=bool)
    begins[starts] = True
    if begins.all():
        return None
    steps = np.zeros(joints.shape[1:], dtype=np.float32)
    turning = list(robot.winding())
    carry = np.zeros((len(turning), len(steps)))
    last = joints[:, :, :1].copy()
    for start in range(0, n, CHUNK):
        rows = slice(start, min(start + CHUNK, n))
        part = joints[:, :, rows]
        if sheet is not None:
            part[:] = np.take_along_axis(part, sheet[None][:, :, rows], axis=1)
        if robot.arm.spherical:
            _straighten(part, last, np.float32(robot.arm.rolls))
        starting = begins[rows]
        here = np.arange(len(starting))
        base = np.maximum.accumulate(np.where(starting, here, -1))
        step = np.diff(part, axis=2, prepend=last)
        step[:, :, starting] = 0.0
        last = part[:, :, -1:].copy()
        for i, axis in enumerate(turning):
            turns = np.rint(step[axis] * np.float32(1.0 / 360.0))
            step[axis] -= 360.0 * turns
            wound = np.cumsum(-turns, axis=1) + carry[i][:, None]
            wound -= np.where(base < 0, 0.0, wound[:, base])
            part[axis] += (360.0 * wound).astype(np.float32)
            carry[i] = wound[:, -1]
        np.abs(step, out=step)
        step *= (1.0 / robot.speeds).astype(np.float32)[:, None, None]
        np.max(step, axis=0, out=steps[:, rows])
    return steps


def _straighten(joints: Singles, before: Singles, rolls: np.float32) -> None:
    """Axes 4 and 6 in line: leaves axis 4 where it was and lets axis 6 do the turn.

    joints: (6, b, m). before: (6, b, 1), the row before these.
    """
    in_line = np.abs(joints[4]) < _WRIST_STRAIGHT
    for branch in np.flatnonzero(in_line.any(axis=1)):
        rows = in_line[branch]
        last = np.maximum.accumulate(np.where(rows, -1, np.arange(len(rows))))[rows]
        four, six = joints[3, branch], joints[5, branch]
        held = np.where(last < 0, before[3, branch], four[last])
        six[rows] -= rolls * (held - four[rows])
        four[rows] = held


def _elbow(robot: Robot, joints: Singles) -> Singles | None:
    """(b / 2, n) degrees of the elbow from stretched or folded; None where branches agree."""
    if robot.lengths.a1 == 0.0:
        return None
    axes = len(joints)
    tried = robot.arm.elbow(robot.chained(np.vstack([np.zeros(axes), np.eye(axes)])))
    if tried is None:
        return None
    # So much for each degree of a joint, whatever its zero, its sense and the coupling.
    slopes = np.degrees(tried[1:] - tried[0])
    bend = np.full_like(joints[0, ::2], np.degrees(tried[0]))
    for axis in np.flatnonzero(np.abs(slopes) > _SINGLE_PRECISION):
        bend += np.float32(slopes[axis]) * joints[axis, ::2]
    return np.asarray(np.abs(bend - 180.0 * np.rint(bend / 180.0)), dtype=np.float32)


@dataclass(frozen=True, slots=True)
class Choice:
    """branches: (n,) -1 where none is possible. broken: rows before which the branch changes
    although the move does not allow it. through: rows reached through the wrist singularity.
    """

    branches: Rows
    broken: Rows
    through: Rows


@dataclass(slots=True)
class Choices:
    """Branches to choose from.

    bound: (b, n) branches that rows allow and, if the run continues from the present position, the
    branch that the arm has there. starts: (c,) first rows of the chains. same: (b,) branches of the
    present position. sheet, crossed: see `singularities`, None if no singularity is crossed. All
    are by sheet instead of by branch if there are sheets. barred: paths that a closer check has
    ruled out, as sheet and row each.
    """

    starts: Rows
    bound: Truths
    same: Truths
    travel: JointTravel
    sheet: Rows | None
    crossed: Truths | None
    barred: set[tuple[int, int]] = field(default_factory=set)

    def best(self) -> Choice:
        return self._choice(*choose_branches(self.bound, self.starts, self._costs))

    def quickest(self, said: NDArray[np.integer]) -> Choice | None:
        """The best choice where joint moves take as long as the whole turns that there are ask
        for; `best` takes them as free. None if no branch goes all the way in some chain, or if
        there is too much to look at.

        said: (n, 6) configurations that rows state and can have, else UNSTATED.
        """
        bound = self.bound | ~self.bound.any(axis=0)
        possible = np.logical_and.reduceat(bound, self.starts, axis=1)
        if not possible.any(axis=0).all():
            return None
        within = np.where(possible, self._costs(self.starts).chains, np.inf)
        found = self.travel.chains(self.starts, within, self._stated(said)).quickest()
        if found is None:
            return None
        lengths = np.diff(np.append(self.starts, bound.shape[1]))
        return self._choice(np.repeat(found.branches, lengths), np.empty(0, np.intp))

    def _stated(self, said: NDArray[np.integer]) -> list[StatedTurns]:
        """Return the whole turns that rows state, for each winding axis."""
        robot = self.travel.robot
        row = np.flatnonzero(said[:, BACK] != UNSTATED)
        branch = robot.branch_of(said[row])
        if self.sheet is not None:
            branch = (self.sheet[:, row] == branch).argmax(axis=0)
        joints = self.travel.joints[:, branch, row].T.astype(np.float64)
        wanted, fits = robot.turned(joints, said[row])
        kept = fits.all(axis=1) & robot.inside(wanted)
        turns = np.round((wanted - joints) / 360.0).astype(np.int64)
        return [(branch[kept], row[kept], turns[kept, axis]) for axis in robot.winding()]

    def _choice(self, chosen: Rows, broken: Rows) -> Choice:
        row = np.arange(len(chosen))
        if chosen[0] >= 0 and not self.same[chosen[0]]:
            broken = np.append(0, broken)
        through = np.empty(0, np.intp)
        if self.sheet is not None and self.crossed is not None:
            chosen = np.where(chosen >= 0, self.sheet[chosen, row], -1)
            through = np.flatnonzero((chosen >= 0) & self.crossed[chosen // 2, row])
        return Choice(chosen, broken, through)

    def bar(self, choice: Choice, rows: Iterable[int]) -> bool:
        """Rules out the ways to some rows in the chosen branches; whether that says anything."""
        before = len(self.barred)
        for row in rows:
            branch = choice.branches[row]
            way = branch if self.sheet is None else (self.sheet[:, row] == branch).argmax()
            self.barred.add((int(way), int(row)))
        return len(self.barred) > before

    def _costs(self, starts: Rows) -> BranchCosts:
        costs = self.travel.costs(starts)
        for way, row in self.barred:
            costs.chains[way, np.searchsorted(starts, row, side="right") - 1] += _BARRED_COST
        return costs


def choices(run: Run, robot: Robot, survey: RowSurvey, every: Singles, own: Rows) -> Choices:
    """every: (a, b, n) joints, taken over. own: (n,) the branch that a row has to keep, or -1."""
    kept = own >= 0
    bound = survey.allowed & ~kept
    bound[own[kept], np.flatnonzero(kept)] = True
    sheet = crossed = clear = None
    if survey.bends is not None:
        crossed, clear = crossings(survey.bends, run.kinds), least_bends(survey.bends, run.kinds)
        crossed = confirmed_crossings(run, robot, survey.bends, crossed)
        survey.bends = None  # room for what comes
        if crossed.any():
            sheet = connected_branches(crossed)
            bound = np.take_along_axis(bound, sheet, axis=0)
    same = np.ones(robot.branches, bool)
    if continued(run):
        same = branches_at(run.before, robot)
    if (bound[:, 0] & same).any():
        bound[:, 0] &= same
    starts = chain_starts(run)
    solved = np.asarray(survey.allowed.any(axis=0))
    travel = _joint_travel(run, robot, every, solved, starts, sheet, clear, crossed)
    return Choices(starts, bound, same, travel, sheet, crossed)


def chain_starts(run: Run) -> Rows:
    first = run.kinds == Kind.JOINT
    first[:1] = True
    return np.flatnonzero(first)


def branches_at(joints: Floats, robot: Robot) -> Truths:
    """(b,) which branches joints (a,) belong to; several at a singularity."""
    p, q = robot.flange_poses(joints)
    found, _ = robot.solve(p, q)
    off = robot.wound(found[:, :, 0].T - joints)[:, list(robot.arm.compared)]
    return np.asarray((np.abs(off) < 0.1).all(axis=1))
