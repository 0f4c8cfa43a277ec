"""Which pairs could come near each other on which stretches of a way: all others are left out.

Joints of a group of stretches lie in a box of joints. From its middle a pair comes nearer by no
more than half of the edges of that box times its levers, so that one bound clears the whole group;
a group that is not clear is looked at in parts.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np

from assistant.base.arrays import Floats, Rows
from assistant.cell.collision.model import Model

COARSE_GROUPS: Final = (4096, 1024, 256, 64)
FINE_GROUPS: Final = (16, 4, 1)
"""Stretches of a group, each size a part of the one before it."""
LEAST_MEASURED_GROUP: Final = 16
"""From groups of so many on, distances are looked at as well, which clear more than boxes do."""
GROUP_PAIRS_AT_ONCE: Final = 100_000
"""Pairs of groups and items that are looked at together."""


def near_pairs(
    model: Model, rows: Floats, slack: Floats | None, limit: Floats, together: int
) -> Iterator[tuple[Rows, Rows]]:
    """Stretches (k,) of rows (n + 1, j) and pairs (k,) that may be nearer there than limit (p,) mm.

    slack: (n, j) how far a joint may be from the line of its stretch, no less than 0. together:
    of one answer at most, unless a single group of the coarse ones has more.
    """
    low, high = np.minimum(rows[:-1], rows[1:]), np.maximum(rows[:-1], rows[1:])
    if slack is not None:
        low, high = low - slack, high + slack
    within = _Within(model, low, high, limit)
    count = -(-len(low) // COARSE_GROUPS[0])
    group = np.repeat(np.arange(count), len(model))
    pair = np.tile(np.arange(len(model)), count)
    group, pair = within.parts(group, pair, COARSE_GROUPS[0], COARSE_GROUPS)
    size = max(together // COARSE_GROUPS[-1], 1)
    for start in range(0, len(group), size):
        some = slice(start, start + size)
        yield within.parts(group[some], pair[some], COARSE_GROUPS[-1], FINE_GROUPS)


class _Within:
    """Boxes of joints from low to high (n, j), one for each stretch."""

    def __init__(self, model: Model, low: Floats, high: Floats, limit: Floats) -> None:
        self.model, self.low, self.high, self.limit = model, low, high, limit

    def parts(self, group: Rows, pair: Rows, size: int, sizes: Sequence[int]) -> tuple[Rows, Rows]:
        """Of groups (k,) of a size with pairs (k,) the groups of the last of sizes not clear."""
        for smaller in sizes:
            parts = size // smaller
            group = (group[:, None] * parts + np.arange(parts)).reshape(-1)
            pair = np.repeat(pair, parts)
            inside = group * smaller < len(self.low)
            group, pair = self._open(group[inside], pair[inside], smaller)
            size = smaller
        order = np.lexsort((pair, group))
        return group[order], pair[order]

    def _open(self, group: Rows, pair: Rows, size: int) -> tuple[Rows, Rows]:
        """What is not far away, of groups (k,) with pairs (k,)."""
        starts = np.arange(0, len(self.low), size)
        low = np.minimum.reduceat(self.low, starts)
        high = np.maximum.reduceat(self.high, starts)
        middle, half, leverage = (low + high) / 2.0, (high - low) / 2.0, self.model.leverage.T
        measures = [self.model.least_of, self.model.exact]
        for measure in measures[: 2 if size >= LEAST_MEASURED_GROUP else 1]:
            found = [np.zeros(0, dtype=np.intp)]
            for start in range(0, len(group), GROUP_PAIRS_AT_ONCE):
                g, p = (
                    group[start : start + GROUP_PAIRS_AT_ONCE],
                    pair[start : start + GROUP_PAIRS_AT_ONCE],
                )
                used, where = np.unique(g, return_inverse=True)
                least = measure(middle[used], where, p)
                least -= np.einsum("kj,kj->k", half[g], leverage[p])
                found.append(start + np.flatnonzero(least <= self.limit[p]))
            open_ = np.concatenate(found)
            group, pair = group[open_], pair[open_]
        return group, pair
