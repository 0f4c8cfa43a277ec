"""Positions of labels in a picture where they cover neither lines nor each other."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from assistant.base.arrays import Floats

_DISTANCES: Final = (2.0, 5.0, 9.0, 14.0, 20.0, 28.0, 38.0, 50.0, 64.0)
"""Points between the anchor and the label that are tried, from the nearest on."""
_DIRECTIONS: Final = 16
_STEP: Final = 0.5
"""Points between the samples of a line, which is less than a cell of the grid."""
_LEAST_CORNERS: Final = 4
"""Points of a contour that encloses something, the first one twice."""
_GAP: Final = 1
"""Points that are kept free around a label."""

_Cells = NDArray[np.bool_]


def label_positions(
    anchors: Floats,
    sizes: Floats,
    homes: Sequence[Floats],
    lines: Sequence[Floats],
    low: Floats,
    high: Floats,
) -> Floats:
    """Return the centres (n, 2) of labels, each as near to its anchor as there is room.

    anchors, sizes: (n, 2). homes: (k, 2) each, contours that labels belong to; in a closed one its
    label is placed if there is room. lines: (m, 2) each, not to be covered. low, high: (2,) corners
    of the picture. All in typographic points. Where there is no room, the place that covers least.
    """
    shape = np.maximum(np.ceil(high - low).astype(int) + 1, 1)
    taken = np.zeros(shape, dtype=bool)
    for line in lines:
        _mark(taken, line - low)
    angles = np.radians(45.0) + np.arange(_DIRECTIONS) * 2.0 * np.pi / _DIRECTIONS
    directions = np.c_[np.cos(angles), np.sin(angles)]
    out = np.empty((len(anchors), 2))
    # Small contours have no other room than their own.
    for row in sorted(range(len(anchors)), key=lambda one: float(np.ptp(homes[one], axis=0).max())):
        anchor, half = anchors[row] - low, 0.5 * sizes[row] + _GAP
        # The box touches a circle about the anchor in each direction.
        reach = np.min(half / np.maximum(np.abs(directions), 1e-9), axis=1)
        centres = np.vstack([anchor + directions * (reach + d)[:, None] for d in _DISTANCES])
        at_home = _within(homes[row] - low, centres)
        best = _roomiest(taken, np.vstack([centres[at_home], centres[~at_home]]), half, anchor)
        (x, y), (right, top) = (best - half).astype(int), np.ceil(best + half).astype(int)
        taken[max(x, 0) : right, max(y, 0) : top] = True
        _mark(taken, np.array([anchor, best]))
        out[row] = best + low
    return out


def _roomiest(taken: _Cells, centres: Floats, half: Floats, otherwise: Floats) -> Floats:
    """Return the first of some centres (m, 2) of a box that covers nothing, else the one that
    covers least.
    """
    least, best = np.inf, otherwise
    for centre in centres:
        first, last = centre - half, centre + half
        if (first < 0.0).any() or (last >= taken.shape).any():
            continue
        (x, y), (right, top) = first.astype(int), np.ceil(last).astype(int)
        covered = int(taken[x:right, y:top].sum())
        if covered < least:
            least, best = covered, centre
        if not covered:
            break
    return best


def _within(home: Floats, points: Floats) -> NDArray[np.bool_]:
    """Return a flag for each point (m, 2): True if it is in a contour that is closed."""
    if len(home) < _LEAST_CORNERS or float(np.linalg.norm(home[0] - home[-1])) > _STEP:
        return np.zeros(len(points), dtype=bool)
    import shapely

    inside = shapely.contains_xy(shapely.Polygon(home), *points.T)
    return np.asarray(inside, dtype=bool)


def _mark(taken: _Cells, line: Floats) -> None:
    """Mark the cells that a line (m, 2) runs through."""
    line = line[np.isfinite(line).all(axis=1)]
    if not len(line):
        return
    way = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    along = np.linspace(0.0, way[-1], int(way[-1] / _STEP) + 2)
    cells = np.column_stack([np.interp(along, way, column) for column in line.T]).astype(int)
    inside = ((cells >= 0) & (cells < taken.shape)).all(axis=1)
    taken[tuple(cells[inside].T)] = True
