"""Which pairs could come near each other on which stretches of a way: all others are left out.

Joints of a group of stretches lie in a box of joints. From its middle a pair comes nearer by no
more than half of the edges of that box times its levers, so that one bound clears the whole group;
a group that is not clear is looked at in parts.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from assistant.cell.collision.model import Model
from assistant.program.arrays import Floats, Rows

GROUPS: Final = (64, 16, 4, 1)
"""Stretches of a group, each size a part of the one before it."""
BLOCK: Final = 100_000
"""Pairs of groups and items that are looked at together."""


def near(model: Model, rows: Floats, slack: Floats | None, limit: Floats) -> tuple[Rows, Rows]:
    """Stretches (k,) of rows (n + 1, j) and pairs (k,) that may be nearer there than limit (p,) mm.

    slack: (n, j) how far a joint may be from the line of its stretch, no less than 0.
    """
    low, high = np.minimum(rows[:-1], rows[1:]), np.maximum(rows[:-1], rows[1:])
    if slack is not None:
        low, high = low - slack, high + slack
    first = next((i for i, size in enumerate(GROUPS) if size <= len(low)), len(GROUPS) - 1)
    count = -(-len(low) // GROUPS[first])
    group = np.repeat(np.arange(count), len(model))
    pair = np.tile(np.arange(len(model)), count)
    for i, size in enumerate(GROUPS[first:], first):
        starts = np.arange(0, len(low), size)
        lowest, highest = np.minimum.reduceat(low, starts), np.maximum.reduceat(high, starts)
        open_ = _open(model, lowest, highest, group, pair, limit)
        group, pair = group[open_], pair[open_]
        if size > 1:
            parts = size // GROUPS[i + 1]
            group = (group[:, None] * parts + np.arange(parts)).reshape(-1)
            pair = np.repeat(pair, parts)
            inside = group * GROUPS[i + 1] < len(low)
            group, pair = group[inside], pair[inside]
    order = np.lexsort((pair, group))
    return group[order], pair[order]


def _open(model: Model, low: Floats, high: Floats, group: Rows, pair: Rows, limit: Floats) -> Rows:
    """Which of groups (k,) with pairs (k,) are not clear; low, high: (g, j) joints of groups."""
    middle, half = (low + high) / 2.0, (high - low) / 2.0
    found = [np.zeros(0, dtype=np.intp)]
    for start in range(0, len(group), BLOCK):
        g, p = group[start : start + BLOCK], pair[start : start + BLOCK]
        used, where = np.unique(g, return_inverse=True)
        least = model.least_of(middle[used], where, p)
        least -= np.einsum("kj,kj->k", half[g], model.leverage.T[p])
        found.append(start + np.flatnonzero(least <= limit[p]))
    return np.concatenate(found)
