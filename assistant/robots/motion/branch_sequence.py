"""The cheapest sequence of arm branches and whole turns along a run.

A chain is a joint move and the linear and circular moves after it. These cannot change the branch,
and their axes move without a break, so all rows of a chain have one branch and one count of whole
turns; a joint move may change both. The sequence is found by dynamic programming over chains and
branches: no other choice has a smaller sum of the costs of the chains and of the joint moves
between them.

States of branches and turns are many, so the branches are chosen first, as if an axis could turn
the shorter way at each joint move that its limits allow (see `branch_choice`). If the result does
turn the shorter way everywhere, no other is quicker; if not, branches and turns are chosen
together.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Sequence
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from assistant.base.arrays import Floats, Ints, Rows, Singles, Truths
from assistant.base.data_classes import dataclass
from assistant.robots.motion.run import Run, continued
from assistant.robots.robot import CHUNK, Robot

BRANCH_CHANGE_COST: Final = 0.5
"""Seconds of joint travel that a change of branch at a joint move must save to be worth it."""
BROKEN_CHAIN_COST: Final = 1e6
"""Cost of a change of branch where no joint move allows it: more than any path takes."""
_CHAINS_AT_ONCE: Final = 16384
"""Chains that are processed together."""
_FEW_CHAINS: Final = 64
"""Chains up to which one after the other is faster than side by side."""
_MANY_BRANCHES: Final = 12
"""Branches from which on it is so for any number of chains."""


@dataclass(frozen=True, slots=True)
class BranchCosts:
    """Costs of branches, in seconds.

    first: (b,) to the first chain from the position of the arm. chains: (b, c) within each chain.
    between: chains (m,), without the first → (b, b, m) from a branch of the chain before to a
    branch of it.
    """

    first: Floats
    chains: Floats
    between: Callable[[Rows], NDArray[np.floating]]


class Branches(NamedTuple):
    """chosen: (n,) branch, -1 where none is possible. broken: rows before which the branch
    would have to change although the move does not allow it.
    """

    chosen: Rows
    broken: Rows


def choose_branches(
    allowed: Truths, starts: Rows, costs: Callable[[Rows], BranchCosts]
) -> Branches:
    """Branches for a path.

    allowed: (b, n) which branches a row can have. starts: (c,) first rows of the chains,
    the first being 0. costs: first rows of chains → what they cost. Changes of branch within a
    chain are as few as can be; at a joint move one has to save more than `BRANCH_CHANGE_COST`.
    """
    n = allowed.shape[1]
    none = ~allowed.any(axis=0)
    open_ = allowed | none
    by_chain = np.logical_and.reduceat(open_, starts, axis=1)
    failing = ~by_chain.any(axis=0)
    used = starts
    if failing.any():
        inside = np.repeat(failing, np.diff(np.append(starts, n)))
        inside[starts] = True
        used = np.flatnonzero(inside)
        by_chain = np.logical_and.reduceat(open_, used, axis=1)
    if (by_chain.sum(axis=0) == 1).all():
        way = by_chain.argmax(axis=0)
    else:
        change = np.full(len(used), BRANCH_CHANGE_COST)
        change[~np.isin(used, starts, assume_unique=True)] = BROKEN_CHAIN_COST
        way = cheapest_branches(by_chain, costs(used), change)
    chosen = np.repeat(way, np.diff(np.append(used, n)))
    broken = np.empty(0, np.intp)
    if failing.any():
        solved = np.flatnonzero(~none)
        changes = solved[1:][np.diff(chosen[solved]) != 0]
        chain = np.searchsorted(starts, np.arange(n), side="right")
        previous = solved[np.searchsorted(solved, changes) - 1]
        broken = changes[chain[changes] == chain[previous]]
    chosen[none] = -1
    return Branches(chosen, broken)


def cheapest_branches(possible: Truths, costs: BranchCosts, change: Floats | None = None) -> Rows:
    """Return (c,) the branch of each chain with the smallest sum of costs.

    possible: (b, c). change: (c,) cost, in addition to the travel, of a branch other than that of
    the chain before; None if `costs` include it. A block of chains is cut into sections that are
    processed side by side: first from every branch at the start of each, then from the true costs
    of each start.
    """
    branches, count = possible.shape
    costs_so_far = np.where(possible[:, 0], costs.first + costs.chains[:, 0], np.inf)
    back: list[NDArray[np.uint16]] = []
    for block in _blocks(branches, count):
        steps = _chain_steps(block, possible, costs, change)
        starts = _starts(steps, costs_so_far)
        pointers, ends = _followed(steps, starts)
        back.append(pointers)
        costs_so_far = ends[:, -1] - ends[:, -1].min()
    at = int(costs_so_far.argmin())
    way = np.empty(count, dtype=np.intp)
    for block, pointers in zip(reversed([*_blocks(branches, count)]), reversed(back), strict=True):
        before, within = _traced(pointers, at)
        way[block] = within[: len(block)]
        at = before
    way[0] = at
    return way


def _blocks(branches: int, count: int) -> Iterator[Rows]:
    """The chains but the first, which nothing leads to within the path."""
    size = max(_CHAINS_AT_ONCE // max(branches // 8, 1) ** 2, 1)
    for start in range(1, count, size):
        yield np.arange(start, min(start + size, count))


def _chain_steps(
    block: Rows, possible: Truths, costs: BranchCosts, change: Floats | None
) -> Singles:
    """(steps, b, b, sections) what leads from one chain to the next; what is filled up costs
    nothing and leads nowhere else.
    """
    branches, m = len(possible), len(block)
    sections = 1 if m <= _FEW_CHAINS or branches > _MANY_BRANCHES else int(np.sqrt(m))
    length = -(-m // sections)
    order = np.arange(sections * length).reshape(sections, length).T
    filled = order >= m
    chains = block[np.minimum(order, m - 1)]
    flat = chains.ravel()
    table = costs.between(flat).astype(np.float32, copy=False)
    table += np.where(possible[:, flat], costs.chains[:, flat], np.inf).astype(np.float32)
    other = ~np.eye(branches, dtype=bool)
    if change is not None:
        added = change[flat].astype(np.float32)
        for one, two in np.argwhere(other):
            table[one, two] += added
    if filled.any():
        table[:, :, filled.ravel()] = np.where(other, np.inf, 0.0)[:, :, None]
    steps = table.reshape(branches, branches, length, sections)
    return np.ascontiguousarray(steps.transpose(2, 0, 1, 3))


def _starts(steps: Singles, before: Floats) -> Floats:
    """(b, sections) what it costs to come to the start of each section of a block."""
    length, branches, _, sections = steps.shape
    out = np.empty((branches, sections))
    out[:, 0] = before
    if sections == 1:
        return out
    through = steps[0].copy()
    for t in range(1, length):
        best = through[:, :1] + steps[t][0]
        for branch in range(1, branches):
            np.minimum(best, through[:, branch, None] + steps[t][branch], out=best)
        through = best
    for section in range(1, sections):
        out[:, section] = (out[:, section - 1, None] + through[:, :, section - 1]).min(axis=0)
    return out


def _followed(steps: Singles, starts: Floats) -> tuple[NDArray[np.uint16], Floats]:
    """(steps, b, sections) from which branch one comes best, and (b, sections) what it costs."""
    pointers = np.empty((len(steps), *starts.shape), dtype=np.uint16)
    for t, step in enumerate(steps):
        ways = starts[:, None] + step
        pointers[t] = ways.argmin(axis=0)
        starts = ways.min(axis=0)
    return pointers, starts


def _traced(pointers: NDArray[np.uint16], at: int) -> tuple[int, Rows]:
    """The branch before a block and those of its chains, which end in branch `at`."""
    length, branches, sections = pointers.shape
    here = np.repeat(np.arange(branches)[:, None], sections, axis=1)
    column = np.arange(sections)
    all_ = np.empty(pointers.shape, dtype=np.uint16)
    for t in range(length - 1, -1, -1):
        all_[t] = here
        here = pointers[t][here, column]
    way = np.empty((sections, length), dtype=np.intp)
    for section in range(sections - 1, -1, -1):
        way[section] = all_[:, at, section]
        at = int(here[at, section])
    return at, way.ravel()


@dataclass(frozen=True, slots=True)
class TurnedAxis:
    """angles: (n,) deg inside the limits where that can be. broken: rows before which the
    axis would have to be wound back although the move does not allow it. sweep: least and greatest
    deg without winding back, from the start to the end of the first chain with such a row; None if
    rows state their turns.
    """

    angles: Floats
    broken: Rows
    sweep: tuple[float, float] | None = None


@dataclass(frozen=True, slots=True)
class AxisBetweenTargets:
    """Motion of one axis on the path to each of n rows; see `MotionBetweenTargets`."""

    winding: Ints
    below: Floats
    above: Floats


def add_whole_turns(
    angles: Floats,
    limits: tuple[float, float],
    starts: Rows,
    near: float,
    stated: Ints | None = None,
    way: AxisBetweenTargets | None = None,
) -> TurnedAxis:
    """Adds whole turns to angles (n,) deg, so that chains are unbroken and inside the limits.

    angles: nearest to the middle of the limits; NaN where there is no solution.
    starts: (c,) first rows of the chains, the first being 0. near: deg, where the axis is
    before the path. stated: (n,) turns that a row must have, FREE where it states none.
    way: the turns that the axis makes on its way to a row, and how far it goes there.
    """
    wrapped = _filled_by_chain(angles, starts)
    if not len(wrapped):
        return TurnedAxis(angles.copy(), np.empty(0, np.intp))
    step = _turn_steps(wrapped, way)
    turns = np.cumsum(step)
    whole = _by_chain(angles, wrapped, turns, starts[:1], limits, stated, way)
    first = round((near - wrapped[0]) / 360.0)
    if whole.possible[0] and (whole.clear or len(starts) == 1):
        return TurnedAxis(angles + 360.0 * (whole.follow(first) + turns), np.empty(0, np.intp))
    chains = _by_chain(angles, wrapped, turns, starts, limits, stated, way)
    failing = ~chains.possible
    broken, sweep = np.empty(0, np.intp), None
    if failing.any():
        if stated is None:
            least, most = (float(ends[failing.argmax()]) for ends in chains.sweeps)
            sweep = least, most
        inside = np.repeat(failing, np.diff(np.append(starts, len(wrapped))))
        inside[starts] = True
        chains = _by_chain(angles, wrapped, turns, np.flatnonzero(inside), limits, stated, way)
    chosen = chains.follow(first)
    count = chosen[chains.of_row] + turns - turns[chains.starts][chains.of_row]
    out = angles + 360.0 * count
    if failing.any():
        unmet = np.flatnonzero(np.diff(count, prepend=count[0]) != step)
        broken = np.setdiff1d(unmet, starts)
    return TurnedAxis(out, broken, sweep)


class OpenTurns(NamedTuple):
    """least, most: (c,) turns that a chain may be wound by; the first is more where none are.
    within: (n,) turns of a row beyond those of its chain. of_row: (n,) chain of each row.
    """

    least: Ints
    most: Ints
    within: Ints
    of_row: Rows


def open_turns(
    angles: Floats,
    limits: tuple[float, float],
    starts: Rows,
    stated: Ints | None = None,
    way: AxisBetweenTargets | None = None,
) -> OpenTurns:
    """Return the whole turns to choose from; `add_whole_turns` chooses from the same."""
    wrapped = _filled_by_chain(angles, starts)
    turns = np.cumsum(_turn_steps(wrapped, way))
    chains = _by_chain(angles, wrapped, turns, starts, limits, stated, way)
    within = turns - turns[starts][chains.of_row]
    return OpenTurns(chains.least, chains.most, within, chains.of_row)


LIMIT_CLEARANCE: Final = 1.0
"""degrees that an axis keeps from its limits where another count of turns can: a controller
reads a target rounded, and near a singularity that turns the wrist."""
_LIMIT_ROUNDING: Final = 1e-6
"""degrees by which an angle may pass a limit."""
TURNS_NOT_STATED: Final = np.iinfo(np.int64).min
"""Value in `stated` for a row that does not state its turns."""


def filled_forward(angles: Floats) -> Floats:
    """NaN rows take the value of the row before, leading ones that of the first after; else 0."""
    known = np.isfinite(angles)
    if known.all():
        return angles
    if not known.any():
        return np.zeros_like(angles)
    last = np.maximum.accumulate(np.where(known, np.arange(len(angles)), -1))
    return np.asarray(angles[np.where(last < 0, known.argmax(), last)])


def _turn_steps(wrapped: Floats, way: AxisBetweenTargets | None) -> Ints:
    """(n,) by how many turns each row is beyond the one before, going to it the short way."""
    step = np.zeros(len(wrapped), dtype=np.int64)
    step[1:] = -np.round(np.diff(wrapped) / 360.0)
    if way is not None:
        step += way.winding
    return step


def _filled_by_chain(angles: Floats, starts: Rows) -> Floats:
    """NaN rows take the value before them, at the start of a chain the one after them.

    So a chain is counted from its own first angle, not from the last of the chain before.
    """
    known = np.isfinite(angles)
    if known.all() or not known.any():
        return filled_forward(angles)
    row, n = np.arange(len(angles)), len(angles)
    last = np.maximum.accumulate(np.where(known, row, -1))
    following = np.minimum.accumulate(np.where(known, row, n)[::-1])[::-1]
    start = np.repeat(starts, np.diff(np.append(starts, n)))
    own = np.where((last < start) & (following < n), following, last)
    return np.asarray(angles[own])


@dataclass(frozen=True, slots=True)
class _AxisChains:
    """Chains of one axis. starts: (c,) rows. of_row: (n,) chain of each row. offsets: (c,) turns at
    the starts. least, most: (c,) turns with which every row of the chain is inside, and clear of
    the limits if any turns allow it; the first is greater if no turns fit. clear: whether all of
    them are that. lowest, highest: turns with which an angle of half a turn about the middle can be
    inside. sweeps: least and greatest deg (c,) of each chain.
    """

    starts: Rows
    of_row: Rows
    offsets: Ints
    least: Ints
    most: Ints
    clear: bool
    lowest: int
    highest: int
    sweeps: tuple[Floats, Floats]

    @property
    def possible(self) -> Truths:
        return np.asarray(self.least <= self.most)

    def follow(self, first: int) -> Ints:
        """(c,) turns at the start of each chain: unbroken where possible, else the nearest."""
        count = len(self.starts)
        moves = np.diff(self.offsets, prepend=self.offsets[:1])
        # Sections of the chains side by side, each from every count of turns before it, which
        # are the lowest to the highest and, of the first section, `first`.
        sections = max(int(np.sqrt(count)), 1)
        length = -(-count // sections)
        shape, filled = (sections, length), length * sections - count
        steps = np.append(moves, np.zeros(filled, np.int64)).reshape(shape)
        least, most = (
            np.append(np.where(self.possible, each, end), np.full(filled, end)).reshape(shape)
            for each, end in ((self.least, self.lowest), (self.most, self.highest))
        )
        at = np.tile(np.arange(self.lowest, self.highest + 1), (sections, 1))
        at[0] = first
        ways = np.empty((length, *at.shape), dtype=np.int64)
        for t in range(length):
            ways[t] = at = np.clip(at + steps[:, t, None], least[:, t, None], most[:, t, None])
        out = np.empty(shape, dtype=np.int64)
        came = 0
        for section in range(sections):
            out[section] = ways[:, section, came]
            came = int(out[section, -1]) - self.lowest
        return out.ravel()[:count]


def _by_chain(
    angles: Floats,
    wrapped: Floats,
    turns: Ints,
    starts: Rows,
    limits: tuple[float, float],
    stated: Ints | None,
    way: AxisBetweenTargets | None,
) -> _AxisChains:
    low, high = limits
    n, middle = len(wrapped), (low + high) / 2.0
    of_row = np.zeros(n, dtype=np.intp)
    of_row[starts[1:]] = 1
    of_row = np.cumsum(of_row)
    relative = turns - turns[starts][of_row]
    unwound = angles + 360.0 * relative
    lows, highs = np.fmin.reduceat(unwound, starts), np.fmax.reduceat(unwound, starts)
    least_on_way, most_on_way = lows, highs
    if way is not None:
        inner = np.ones(n, dtype=bool)
        inner[starts] = False  # what leads to a chain is no part of it
        least_on_way = np.fmin.reduceat(unwound + np.where(inner, way.below, 0.0), starts)
        most_on_way = np.fmax.reduceat(unwound + np.where(inner, way.above, 0.0), starts)
    lowest = int(np.ceil((low - middle - 180.0) / 360.0))
    highest = int(np.floor((high - middle + 180.0) / 360.0))
    fewest, greatest = np.full(len(starts), lowest), np.full(len(starts), highest)
    if stated is not None:
        wanted = np.where(stated == TURNS_NOT_STATED, 0, stated - relative)
        smallest = np.minimum.reduceat(
            np.where(stated == TURNS_NOT_STATED, 1 << 40, wanted), starts
        )
        largest = np.maximum.reduceat(
            np.where(stated == TURNS_NOT_STATED, -(1 << 40), wanted), starts
        )
        # All that a chain states has to be the same.
        fewest, greatest = np.maximum(fewest, largest), np.minimum(greatest, smallest)
    # From the best to what has to do: clear of the limits, inside them, inside at the rows alone.
    least, most = np.ones(len(starts), np.int64), np.zeros(len(starts), np.int64)
    clear = False
    for bottom, top, inside in (
        (least_on_way, most_on_way, LIMIT_CLEARANCE),
        (least_on_way, most_on_way, -_LIMIT_ROUNDING),
        (lows, highs, -_LIMIT_ROUNDING),
    ):
        # A chain without any solution (NaN) allows everything.
        first = np.fmax(np.ceil((low + inside - bottom) / 360.0), fewest).astype(np.int64)
        last = np.fmin(np.floor((high - inside - top) / 360.0), greatest).astype(np.int64)
        open_ = least > most
        least, most = np.where(open_, first, least), np.where(open_, last, most)
        if inside == LIMIT_CLEARANCE:
            clear = bool((first <= last).all())
    sweeps = least_on_way, most_on_way
    return _AxisChains(starts, of_row, turns[starts], least, most, clear, lowest, highest, sweeps)


TurnCounts = NDArray[np.int64]

_OTHER_AXES_SHARE: Final = 1e-4
"""Share of the time of every axis that counts beside that of the slowest: of ways that take the
same time the one on which the others turn the least."""
_LEAST_SAVING: Final = 1e-6
"""Seconds by which a joint move is quicker that is worth a look: no rounding."""
_MOST_STATES: Final = 256
"""Largest number of states of a chain that are examined one by one."""
_STATE_PAIRS_AT_ONCE: Final = 32768
"""Pairs of states whose joint moves are computed at once: they stay in the cache."""


def may_be_quicker(run: Run, robot: Robot, joints: Floats, starts: Rows) -> bool:
    """True if a joint move to the chains with these first rows (c,) would take less time with other
    whole turns of joints (n, a) deg, whether they are possible or not.

    False if rows have no joints: that is reported elsewhere, and the rest is not a program.
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
    return bool((seconds > least + _LEAST_SAVING).any())


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
    within: (b, c) seconds that a chain costs alone; infinite if it is not possible.
    """

    run: Run
    robot: Robot
    firsts: NDArray[np.floating]
    lasts: NDArray[np.floating]
    least: TurnCounts
    most: TurnCounts
    within: Floats

    def quickest(self) -> Quickest | None:
        """Return the choice that takes the least time; None if there are too many states to
        examine.
        """
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
    if slots.prod() * len(chains.within) > _MOST_STATES**2:
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
    if count > _MOST_STATES:
        return None
    branches, turns, there = (
        np.concatenate([_padded_states(each, count) for each in column], axis=-1)
        for column in zip(*found, strict=True)
    )
    return _States(chains, branches.astype(np.uint8), turns.astype(np.int8), there.astype(bool))


def _padded_states(states: TurnCounts | Rows | Truths, count: int) -> NDArray[np.int8]:
    """Pad (..., s, m) states with empty ones to `count`."""
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
        """Return (s, c) seconds of each chain alone."""
        return self.chains.within[self.branches, np.arange(self.there.shape[1])]

    def start(self) -> Floats:
        """(s,) seconds to the first chain from where the arm is."""
        run, robot = self.chains.run, self.chains.robot
        step = np.abs(self._joints(self.chains.firsts, np.arange(1))[:, :, 0].T - run.before)
        each = step / robot.speeds
        seconds = np.asarray(each.max(axis=1) + _OTHER_AXES_SHARE * each.sum(axis=1))
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
        for part in _parts(len(chains), max(_STATE_PAIRS_AT_ONCE // states**2, 1)):
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
            every *= np.float32(_OTHER_AXES_SHARE)
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
