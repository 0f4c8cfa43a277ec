"""Branches and whole turns of a run, chosen together: the joint moves that take the least time.

What a chain (a joint move and the linear and circular moves after it) may be in is a state: a
branch, and how many turns each axis is wound by. The cheapest way through the states of all
chains is found by dynamic programming, as of branches alone; see `branches`.

States are many and looking at all takes long, so the branches are chosen first, as if an axis
could turn the shorter way at every joint move that its limits allow it at (see `travel`). Where
joints come of that which turn the shorter way indeed, no others are quicker.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from assistant.base.arrays import Floats, Rows, Singles, Truths
from assistant.robots.branches.cheapest import (
    BRANCH_CHANGE_COST,
    BROKEN_CHAIN_COST,
    BranchCosts,
    cheapest_branches,
)
from assistant.robots.branches.turns import OpenTurns
from assistant.robots.motion.run import Run, continued
from assistant.robots.robot import CHUNK, Robot

TurnCounts = NDArray[np.int64]

OTHER_AXES_SHARE: Final = 1e-4
"""Share of the time of every axis that counts beside that of the slowest: of ways that take the
same time the one on which the others turn the least."""
LEAST_SAVING: Final = 1e-6
"""Seconds by which a joint move is quicker that is worth a look: no rounding."""
MOST_STATES: Final = 256
"""States of a chain up to which they are looked at one by one."""
STATE_PAIRS_AT_ONCE: Final = 32768
"""Pairs of states whose joint moves are computed at once: they stay in the cache."""


def may_be_quicker(run: Run, robot: Robot, joints: Floats, starts: Rows) -> bool:
    """Whether a joint move to the chains with these first rows (c,) would take less time with
    other whole turns of joints (n, a) deg, be they possible or not.

    Not so where rows have no joints: that is told of, and what is left is no program.
    """
    if not np.isfinite(joints).all():
        return False
    step = np.diff(joints[starts], axis=0, prepend=run.before[None])
    step[1:] = joints[starts[1:]] - joints[starts[1:] - 1]
    if continued(run):
        step = step[1:]
    turning = np.isin(np.arange(len(robot.axes)), robot.winding())
    turning &= np.ptp(robot.limits, axis=1) >= 360.0
    short = np.where(turning, robot.wound(step), step)
    seconds, least = ((np.abs(each) / robot.speeds).max(axis=1) for each in (step, short))
    return bool((seconds > least + LEAST_SAVING).any())


def quickest_turns(
    run: Run, robot: Robot, joints: Floats, starts: Rows, turns: Sequence[OpenTurns]
) -> Floats | None:
    """Joints (n, a) deg in their branches, with the turns of the winding axes with which the
    joint moves take the least time; None if that is too much to look at.

    joints: (n, a) with any turns. turns: what each winding axis is open to.
    """
    winding = list(robot.winding())
    unwound = joints.copy()
    for axis, each in zip(winding, turns, strict=True):
        unwound[:, axis] += 360.0 * each.within
    ends = np.append(starts[1:], len(joints)) - 1
    least, most = (np.stack([each[i] for each in turns])[:, None] for i in range(2))
    firsts, lasts = (unwound[rows].T[:, None] for rows in (starts, ends))
    within = np.zeros((1, len(starts)))
    found = BranchChains(run, robot, firsts, lasts, least, most, within).quickest()
    if found is None:
        return None
    for axis, each, count in zip(winding, turns, found.turns, strict=True):
        unwound[:, axis] += 360.0 * count[each.of_row]
    return unwound


class Quickest(NamedTuple):
    """branches: (c,) of each chain. turns: (w, c) that each winding axis is wound by there."""

    branches: Rows
    turns: TurnCounts


@dataclass(frozen=True, slots=True)
class BranchChains:
    """c chains of a run in b branches.

    firsts, lasts: (a, b, c) deg at their first and last rows, each axis unwound within the chain.
    least, most: (w, b, c) turns by which all rows of a chain may be wound on, of the winding axes.
    within: (b, c) seconds that a chain costs by itself; infinite where it is not possible.
    """

    run: Run
    robot: Robot
    firsts: NDArray[np.floating]
    lasts: NDArray[np.floating]
    least: TurnCounts
    most: TurnCounts
    within: Floats

    def quickest(self) -> Quickest | None:
        """What takes the least time; None if that is too much to look at."""
        states = _states_of(self)
        if states is None:
            return None
        way = cheapest_branches(
            states.there, BranchCosts(states.start(), states.within(), states.between)
        )
        chain = np.arange(len(way))
        return Quickest(
            states.branches[way, chain].astype(np.intp),
            states.turns[:, way, chain].astype(np.int64),
        )


def _states_of(chains: BranchChains) -> _States | None:
    widths = chains.most - chains.least + 1
    widths[:, ~np.isfinite(chains.within)] = 0
    slots = widths.max(axis=(1, 2))
    if slots.prod() * len(chains.within) > MOST_STATES**2:
        return None
    every = np.array([*itertools.product(*(range(slot) for slot in slots))], dtype=np.int64)
    found = []
    for part in _parts(widths.shape[2], CHUNK // 8):
        there = (every.T[:, None, :, None] < widths[:, :, None, part]).all(axis=0)  # (b, k, m)
        there = there.reshape(-1, there.shape[2])
        order = np.argsort(~there, axis=0, kind="stable")[: there.sum(axis=0).max()]
        branch, slot = np.divmod(order, len(every))
        least = chains.least[:, :, part][:, branch, np.arange(order.shape[1])]
        found.append((branch, least + every.T[:, slot], np.take_along_axis(there, order, axis=0)))
    count = max(len(branch) for branch, _, _ in found)
    if count > MOST_STATES:
        return None
    branches, turns, there = (
        np.concatenate([_padded_states(each, count) for each in column], axis=-1)
        for column in zip(*found, strict=True)
    )
    return _States(chains, branches.astype(np.uint8), turns.astype(np.int8), there.astype(bool))


def _padded_states(states: TurnCounts | Rows | Truths, count: int) -> NDArray[np.int8]:
    """(..., s, m) states with more that are none, `count` of them."""
    out = np.zeros((*states.shape[:-2], count, states.shape[-1]), dtype=np.int8)
    out[..., : states.shape[-2], :] = states
    return out


@dataclass(frozen=True, slots=True)
class _States:
    """branches: (s, c). turns: (w, s, c). there: (s, c) False for what is no state."""

    chains: BranchChains
    branches: NDArray[np.uint8]
    turns: NDArray[np.int8]
    there: Truths

    def within(self) -> Floats:
        """(s, c) seconds of each chain by itself."""
        return self.chains.within[self.branches, np.arange(self.there.shape[1])]

    def start(self) -> Floats:
        """(s,) seconds to the first chain from where the arm is."""
        run, robot = self.chains.run, self.chains.robot
        step = np.abs(self._joints(self.chains.firsts, np.arange(1))[:, :, 0].T - run.before)
        each = step / robot.speeds
        seconds = np.asarray(each.max(axis=1) + OTHER_AXES_SHARE * each.sum(axis=1))
        if self._branched:
            own = robot.branch_of(robot.configuration(run.before))
            seconds += np.where(self.branches[:, 0] == own, 0.0, BRANCH_CHANGE_COST)
        if continued(run):  # no joint move: wound back it would be broken
            seconds += BROKEN_CHAIN_COST * (step[:, list(robot.winding())] > 180.0).any(axis=1)
        return seconds

    def between(self, chains: Rows) -> Singles:
        """(s, s, m) seconds from each state of the chain before to each of m chains."""
        states = len(self.branches)
        out = np.empty((states, states, len(chains)), dtype=np.float32)
        unit = (1.0 / self.chains.robot.speeds).astype(np.float32)[:, None, None]
        for part in _parts(len(chains), max(STATE_PAIRS_AT_ONCE // states**2, 1)):
            here = chains[part]
            slowest = np.zeros((states, states, len(here)), dtype=np.float32)
            every = np.zeros_like(slowest)
            last = unit * self._joints(self.chains.lasts, here - 1)
            first = unit * self._joints(self.chains.firsts, here)
            for of, to in zip(last, first, strict=True):
                step = to[None] - of[:, None]
                np.abs(step, out=step)
                np.maximum(slowest, step, out=slowest)
                every += step
            every *= np.float32(OTHER_AXES_SHARE)
            slowest += every
            if self._branched:
                other = self.branches[:, None, here - 1] != self.branches[None, :, here]
                slowest += np.float32(BRANCH_CHANGE_COST) * other
            out[:, :, part] = slowest
        return out

    @property
    def _branched(self) -> bool:
        return len(self.chains.within) > 1

    def _joints(self, ends: NDArray[np.floating], chains: Rows) -> Singles:
        """(a, s, m) deg at one end of m chains in each of their states."""
        out = ends[:, self.branches[:, chains], chains].astype(np.float32)
        winding = list(self.chains.robot.winding())
        out[winding] += np.float32(360.0) * self.turns[:, :, chains]
        return out


def _parts(count: int, size: int) -> Iterator[slice]:
    for start in range(0, count, size):
        yield slice(start, min(start + size, count))
