"""Which points lie near each other, by a grid: O(n log n) time, no pair looked at in Python."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from assistant.sources.contours.curves import Points

Indices = NDArray[np.intp]

MOST_CELL_NEIGHBOURS: Final = 64
"""Neighbours a point is compared with in one grid cell; keeps crowds of points linear."""

CELL_KEY_PRIMES: Final = np.array([73856093, 19349663, 83492791], dtype=np.int64)
"""Weights of a cell's three indices in its key; a collision only costs a comparison."""

HALF_NEIGHBOURS: Final = np.array(
    [
        *[(0, 0, 1), (0, 1, -1), (0, 1, 0), (0, 1, 1)],
        *[(1, y, z) for y in (-1, 0, 1) for z in (-1, 0, 1)],
    ],
    dtype=np.int64,
)
"""One of each pair of opposite neighbours of a cell."""


def pairs_within(points: Points, distance: float) -> tuple[Indices, Indices, Points]:
    """Pairs i < j of points (n, 3) at most `distance` apart, and how far apart they are.

    Sorted by distance, then i, then j. Of more than `MOST_IN_CELL` points in one cube of
    that size not all pairs come, yet enough to reach each of the points from any other.
    """
    cells = np.floor(points / distance).astype(np.int64)
    keys = (cells * CELL_KEY_PRIMES).sum(axis=1)
    order = np.argsort(keys, kind="stable")
    ranked = keys[order]
    here = np.arange(len(points))
    found = [_expand(order, order, here + 1, np.searchsorted(ranked, ranked, "right"))]
    for offset in (HALF_NEIGHBOURS * CELL_KEY_PRIMES).sum(axis=1):
        wanted = ranked + offset
        first, last = (np.searchsorted(ranked, wanted, side) for side in ("left", "right"))
        found.append(_expand(order, order, first, last))
    one, two = (np.concatenate(column) for column in zip(*found, strict=True))
    apart = np.linalg.norm(points[one] - points[two], axis=1)
    near = (apart <= distance) & (one != two)
    low, high, apart = np.minimum(one, two)[near], np.maximum(one, two)[near], apart[near]
    ranks = np.lexsort((high, low, apart))
    return low[ranks], high[ranks], apart[ranks]


def clusters(count: int, one: Indices, two: Indices) -> Indices:
    """For each of `count` things the smallest one that pairs (one, two) connect it to."""
    root = list(range(count))

    def top(i: int) -> int:
        while root[i] != i:
            root[i] = root[root[i]]
            i = root[i]
        return i

    for a, b in zip(one.tolist(), two.tolist(), strict=True):
        low, high = sorted((top(a), top(b)))
        root[high] = low
    return np.array([top(i) for i in range(count)], dtype=np.intp)


def _expand(
    order: Indices, candidates: Indices, first: Indices, last: Indices
) -> tuple[Indices, Indices]:
    """Pairs of order[k] with each of candidates[first[k] : last[k]], the count bounded."""
    counts = np.clip(last - first, 0, MOST_CELL_NEIGHBOURS)
    starts = np.repeat(np.cumsum(counts) - counts, counts)
    within = np.arange(counts.sum()) - starts + np.repeat(first, counts)
    return np.repeat(order, counts), candidates[within]
