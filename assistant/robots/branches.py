"""The arm branch of every row of a path.

A linear or circular move cannot change the branch, so all rows of a chain (a joint move
and the linear and circular moves after it) have one; between chains the branch changes as
seldom as can be.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Truths = NDArray[np.bool_]
Rows = NDArray[np.intp]


@dataclass(frozen=True, slots=True)
class Branches:
    """chosen: (n,) branch, -1 where none is possible. broken: rows before which the branch
    would have to change although the move does not allow it.
    """

    chosen: Rows
    broken: Rows


def choose(allowed: Truths, starts: Rows, cost: NDArray[np.float64]) -> Branches:
    """Branches for a path.

    allowed: (b, n) which branches a row can have. starts: (c,) first rows of the chains,
    the first being 0. cost: (b,), the cheapest of equally good branches is taken.
    """
    n = allowed.shape[1]
    order = np.argsort(cost, kind="stable")
    sorted_ = allowed[order]
    none = ~sorted_.any(axis=0)
    open_ = sorted_ | none
    by_chain = np.logical_and.reduceat(open_, starts, axis=1)
    failing = ~by_chain.any(axis=0)
    broken = np.empty(0, np.intp)
    used = starts
    if failing.any():
        inside = np.repeat(failing, np.diff(np.append(starts, n)))
        inside[starts] = True
        used = np.flatnonzero(inside)
        by_chain = np.logical_and.reduceat(open_, used, axis=1)
    chosen = np.repeat(order[_longest(by_chain)], np.diff(np.append(used, n)))
    if failing.any():
        solved = np.flatnonzero(~none)
        changes = solved[1:][np.diff(chosen[solved]) != 0]
        chain = np.searchsorted(starts, np.arange(n), side="right")
        previous = solved[np.searchsorted(solved, changes) - 1]
        broken = changes[chain[changes] == chain[previous]]
    chosen[none] = -1
    return Branches(chosen, broken)


def _longest(allowed: Truths) -> Rows:
    """(c,) for each chain a row of allowed (b, c) that holds, changing as seldom as possible.

    From each change on, the branch that holds longest: no other choice needs fewer changes.
    """
    count = allowed.shape[1]
    whole = allowed.all(axis=1)
    if whole.any():
        return np.full(count, whole.argmax(), dtype=np.intp)
    stop = np.where(allowed, np.int32(count), np.arange(count, dtype=np.int32))
    ends = np.minimum.accumulate(stop[:, ::-1], axis=1)[:, ::-1]
    best, end = ends.argmax(axis=0), ends.max(axis=0)
    chosen = np.empty(count, dtype=np.intp)
    at = 0
    while at < count:
        until = int(end[at])
        chosen[at:until] = best[at]
        at = until
    return chosen
