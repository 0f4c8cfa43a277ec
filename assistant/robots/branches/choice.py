"""The arm branches that a run is followed in, out of all that its rows allow."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from assistant.base.arrays import Floats, Rows, Singles, Truths
from assistant.program.motion import UNSTATED, Kind
from assistant.robots.branches.cheapest import BranchCosts, choose_branches
from assistant.robots.branches.costs import BARRED_COST, JointTravel, StatedTurns, joint_travel
from assistant.robots.branches.row_reach import RowSurvey
from assistant.robots.configurations import BACK
from assistant.robots.motion.between_targets import confirmed_crossings
from assistant.robots.motion.run import Run, continued
from assistant.robots.motion.wrist import connected_branches, crossings, least_bends
from assistant.robots.robot import Robot


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
    """What there is to choose from.

    bound: (b, n) what rows allow and, where the run goes on from where the arm is, the branch
    that it has there. starts: (c,) first rows of the chains. same: (b,) branches of where the
    arm is. sheet, crossed: see `wrist`, None where nothing is crossed. All are by sheet instead
    of by branch where there are sheets. barred: ways that a closer look has ruled out, as sheet
    and row each.
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
        """Of each winding axis the whole turns that rows state."""
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
            costs.chains[way, np.searchsorted(starts, row, side="right") - 1] += BARRED_COST
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
    travel = joint_travel(run, robot, every, solved, starts, sheet, clear, crossed)
    return Choices(starts, bound, same, travel, sheet, crossed)


def chain_starts(run: Run) -> Rows:
    first = run.kinds == Kind.JOINT
    first[:1] = True
    return np.flatnonzero(first)


def branches_at(joints: Floats, robot: Robot) -> Truths:
    """(b,) which branches joints (a,) belong to; several at a singularity."""
    p, q = robot.fk(joints)
    found, _ = robot.solve(p, q)
    off = robot.wound(found[:, :, 0].T - joints)[:, list(robot.arm.compared)]
    return np.asarray((np.abs(off) < 0.1).all(axis=1))
