"""The arm branch of every row of a path: the cheapest way through all of them.

A linear or circular move cannot change the branch, so all rows of a chain (a joint move
and the linear and circular moves after it) have one. Which one each chain has is found by
dynamic programming over chains and branches: no other choice has a smaller sum of what the
chains and the joint moves between them cost.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from assistant.base.arrays import Floats, Rows, Singles, Truths

BRANCH_CHANGE_COST: Final = 0.5
"""Seconds of joint travel that a change of branch at a joint move must save to be worth it."""
BROKEN_CHAIN_COST: Final = 1e6
"""What a change of branch where no joint move allows it counts: more than any path takes."""
CHAINS_AT_ONCE: Final = 16384
"""Chains that are looked at together."""
FEW_CHAINS: Final = 64
"""Chains up to which one after the other is faster than side by side."""
MANY_BRANCHES: Final = 12
"""Branches from which on it is so for any number of chains."""


@dataclass(frozen=True, slots=True)
class BranchCosts:
    """What branches cost, in seconds.

    first: (b,) to the first chain from where the arm is. chains: (b, c) within each chain.
    between: chains (m,), none of them the first → (b, b, m) from a branch of the chain before
    to a branch of it.
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
    chain are as few as can be; at a joint move one has to save more than `CHANGE`.
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
    """(c,) the branch of each chain with the smallest sum of costs.

    possible: (b, c). change: (c,) what a branch other than that of the chain before costs
    beside the travel; None where `costs` say that themselves. A block of chains is cut into
    sections that are looked at side by side: first from every branch at the start of each, then
    from what each start really costs.
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
    size = max(CHAINS_AT_ONCE // max(branches // 8, 1) ** 2, 1)
    for start in range(1, count, size):
        yield np.arange(start, min(start + size, count))


def _chain_steps(
    block: Rows, possible: Truths, costs: BranchCosts, change: Floats | None
) -> Singles:
    """(steps, b, b, sections) what leads from one chain to the next; what is filled up costs
    nothing and leads nowhere else.
    """
    branches, m = len(possible), len(block)
    sections = 1 if m <= FEW_CHAINS or branches > MANY_BRANCHES else int(np.sqrt(m))
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
