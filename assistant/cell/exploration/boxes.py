"""Cells as few large boxes."""

from __future__ import annotations

import itertools

import numpy as np

from assistant.program.arrays import Ints, Truths


def boxes_of(cells: Truths) -> Ints:
    """(k, 2, 3) first and last-but-one-after cells of boxes that hold the true cells (x, y, z).

    Runs along one axis, runs of like runs along the next, and of these along the last; of the six
    orders of axes the one with the fewest boxes.
    """
    return min((_along(cells, order) for order in itertools.permutations(range(3))), key=len)


def _along(cells: Truths, order: tuple[int, ...]) -> Ints:
    turned = np.moveaxis(cells, order, (0, 1, 2))
    edges = np.diff(np.pad(turned.astype(np.int8), ((0, 0), (0, 0), (1, 1))), axis=2)
    starts, stops = np.argwhere(edges == 1), np.argwhere(edges == -1)[:, 2]
    first = starts
    last = np.column_stack([starts[:, :2] + 1, stops])
    for axis in (1, 0):
        first, last = _joined(first, last, axis)
    out = np.empty((len(first), 2, 3), dtype=np.int64)
    out[:, 0, list(order)], out[:, 1, list(order)] = first, last
    return out


def _joined(first: Ints, last: Ints, axis: int) -> tuple[Ints, Ints]:
    """Boxes that follow each other along an axis and are alike across it, as one."""
    if not len(first):
        return first, last
    others = [k for k in range(3) if k != axis]
    across = np.column_stack([first[:, others], last[:, others]])
    order = np.lexsort((first[:, axis], *across.T))
    first, last, across = first[order], last[order], across[order]
    new = np.append(
        True, (across[1:] != across[:-1]).any(axis=1) | (first[1:, axis] != last[:-1, axis])
    )
    begins = np.flatnonzero(new)
    ends = np.append(begins[1:], len(first)) - 1
    out = last[begins].copy()
    out[:, axis] = last[ends, axis]
    return first[begins], out
