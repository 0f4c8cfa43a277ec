"""Near neighbours of many points in O(n log n), some of them missed for the speed of it."""

from __future__ import annotations

from typing import Final

import numpy as np

from assistant.base.arrays import Rows
from assistant.sources.contours.curves import Points

MORTON_BITS: Final = 20
"""Of each coordinate in a Morton key; three make 60."""
MORTON_SHIFTS: Final = (0.0, 0.236, 0.618)
"""Parts of the extent that the curve is moved by, so that no border is one in all of them."""
CANDIDATES_EACH_WAY: Final = 5
"""Points before and after on the curve that count as candidates."""

BIT_SPREAD: Final = (
    (32, 0x001F00000000FFFF),
    (16, 0x001F0000FF0000FF),
    (8, 0x100F00F00F00F00F),
    (4, 0x10C30C30C30C30C3),
    (2, 0x1249249249249249),
)
"""Shifts and masks that put two zero bits behind each of 21 bits."""


def near_owners(points: Points, owners: Rows, most: int) -> list[list[int]]:
    """For each owner of points (m, 3) up to `most` others, the nearest first.

    owners: (m,), 0 to n - 1 and each of them there. Candidates are the neighbours along
    Morton curves (G. M. Morton, 1966) through the points.
    """
    pairs = []
    for shift in MORTON_SHIFTS:
        order = along_morton_curve(points, shift)
        pairs += [np.stack([order[:-n], order[n:]]) for n in range(1, CANDIDATES_EACH_WAY + 1)]
    one, two = np.concatenate(pairs, axis=1)
    apart = np.linalg.norm(points[one] - points[two], axis=1)
    a, b = owners[np.r_[one, two]], owners[np.r_[two, one]]
    order = np.lexsort((b, np.r_[apart, apart], a))
    lists: list[list[int]] = [[] for _ in range(int(owners.max(initial=-1)) + 1)]
    for owner, other in zip(a[order].tolist(), b[order].tolist(), strict=True):
        mine = lists[owner]
        if len(mine) < most and owner != other and other not in mine:
            mine.append(other)
    return lists


def along_morton_curve(points: Points, shift: float = 0.0) -> Rows:
    """The points (m, 3) in the order of a Morton curve."""
    if not len(points):
        return np.empty(0, dtype=np.intp)
    low = points.min(axis=0)
    extent = max(float((points.max(axis=0) - low).max()), 1e-9)
    cells = ((points - low) / extent + shift) / (1.0 + max(MORTON_SHIFTS)) * (2**MORTON_BITS - 1)
    bits = cells.astype(np.uint64)
    for by, mask in BIT_SPREAD:
        bits = (bits | (bits << np.uint64(by))) & np.uint64(mask)
    x, y, z = bits.T
    return np.argsort(x | (y << np.uint64(1)) | (z << np.uint64(2)), kind="stable")
