"""Cells as few large boxes, and their surface as few triangles."""

from __future__ import annotations

import itertools

import numpy as np

from assistant.base.arrays import Ints, Truths


def boxes_of(cells: Truths) -> Ints:
    """(k, 2, 3) first and last-but-one-after cells of boxes that hold the true cells (x, y, z).

    Runs along one axis, runs of like runs along the next, and of these along the last; of the six
    orders of axes the one with the fewest boxes.
    """
    return min((_along(cells, order) for order in itertools.permutations(range(3))), key=len)


def surface_of(cells: Truths) -> tuple[Ints, Ints]:
    """The surface of the true cells (x, y, z): corners (n, 3) and triangles (m, 3) of their rows.

    Each rectangle of faces that lie in one plane has corners of its own and two triangles, which
    are counter-clockwise as seen from outside.
    """
    padded = np.pad(cells, 1).astype(np.int8)
    rectangles = [np.zeros((0, 4, 3), dtype=np.int64)]
    for axis in range(3):
        inner = tuple(slice(None) if k == axis else slice(1, -1) for k in range(3))
        steps = np.diff(padded, axis=axis)[inner]  # at the plane before cell i: 1 where it begins
        for side in (1, -1):
            corners = _rectangles(steps == side, axis)
            # The first edge is along the next axis, the other along the one after that.
            rectangles.append(corners if side == -1 else corners[:, ::-1])
    corners = np.concatenate(rectangles)
    first = 4 * np.arange(len(corners))[:, None]
    triangles = np.concatenate([first + np.array(half) for half in ((0, 1, 2), (0, 2, 3))])
    return corners.reshape(-1, 3), triangles


def _rectangles(faces: Truths, axis: int) -> Ints:
    """(k, 4, 3) corners of rectangles of true faces in planes across an axis, counter-clockwise as
    seen from where the axis leads.
    """
    one, other = (axis + 1) % 3, (axis + 2) % 3
    first, last = min(
        (_runs(faces, (axis, *order), (1,)) for order in ((one, other), (other, one))),
        key=lambda found: len(found[0]),
    )
    out = np.empty((len(first), 4, 3), dtype=np.int64)
    out[:, :, axis] = first[:, None, axis]
    out[:, [0, 3], one], out[:, [1, 2], one] = first[:, None, one], last[:, None, one]
    out[:, [0, 1], other], out[:, [2, 3], other] = first[:, None, other], last[:, None, other]
    return out


def _along(cells: Truths, order: tuple[int, ...]) -> Ints:
    return np.stack(_runs(cells, order, (1, 0)), axis=1)


def _runs(cells: Truths, order: tuple[int, ...], joined: tuple[int, ...]) -> tuple[Ints, Ints]:
    """(k, 3) first and last-but-one-after cells of runs along the last of an order of the axes.

    joined: places in that order of the axes along which like runs become one.
    """
    turned = np.moveaxis(cells, order, (0, 1, 2))
    edges = np.diff(np.pad(turned.astype(np.int8), ((0, 0), (0, 0), (1, 1))), axis=2)
    first, stops = np.argwhere(edges == 1), np.argwhere(edges == -1)[:, 2]
    last = np.column_stack([first[:, :2] + 1, stops])
    for axis in joined:
        first, last = _joined(first, last, axis)
    back = list(np.argsort(order))
    return first[:, back], last[:, back]


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
