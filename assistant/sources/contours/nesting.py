"""Which contours lie inside others, seen along the tool: what is cut out has its holes first."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import groupby
from typing import Final

import numpy as np

from assistant.base.arrays import Truths
from assistant.program.geometry import Vector
from assistant.sources.contours.chaining import Contour
from assistant.sources.contours.curves import (
    Arc,
    FreeCurve,
    Line,
    Points,
    chorded,
    cross,
    points_at_parts,
)
from assistant.sources.contours.flat import chord_counts
from assistant.sources.contours.neighbours import along_morton_curve
from assistant.sources.contours.orientation import level_x_axis
from assistant.sources.contours.proximity import Indices

NO_HOLDER: Final = -1
HOLDER_BATCH: Final = 256
"""Contours whose holders are looked for at once."""
MOST_CROSSINGS: Final = 1 << 20
"""Sides of polygons times points that are looked at at once; bounds memory."""
PROBED_PARTS: Final = (0.17, 0.5, 0.83)
"""Parts of a contour's way that have to be inside, most of them: ends may touch the outline."""


def holders(contours: Sequence[Contour], direction: Vector, tolerance: float) -> list[int]:
    """For each contour the smallest closed one that it lies inside, or -1.

    direction: of the tool, along which it is seen. tolerance: mm that an arc may leave its
    chords. A contour that crosses another one is inside it if most of it is. Of n contours
    boxes are compared n by n in columns; polygons only where boxes hold each other.
    """
    if not any(c.closed for c in contours):
        return [NO_HOLDER] * len(contours)
    across = _view_axes(direction)
    outlines = [_polygon_outline(c, tolerance) @ across.T for c in contours]
    low, high = (np.array([f(o, axis=0) for o in outlines]) for f in (np.min, np.max))
    areas = np.array(
        [_polygon_area(o) if c.closed else 0.0 for o, c in zip(outlines, contours, strict=True)]
    )
    probes = np.array([_probe_points(o) for o in outlines])
    outer = np.flatnonzero(areas > tolerance**2)
    outer = outer[np.argsort(areas[outer], kind="stable")]
    found = np.full(len(contours), NO_HOLDER, dtype=np.intp)
    middle = np.pad((low + high) / 2.0, ((0, 0), (0, 1)))
    order = along_morton_curve(middle)
    for first in range(0, len(order), HOLDER_BATCH):
        inner = order[first : first + HOLDER_BATCH]
        near = (low[outer] <= high[inner].max(axis=0)) & (high[outer] >= low[inner].min(axis=0))
        may = outer[near.all(axis=1)]
        held = (
            (low[may] <= low[inner, None] + tolerance)
            & (high[may] >= high[inner, None] - tolerance)
        ).all(axis=2) & (areas[may] > areas[inner, None] + tolerance**2)
        for row, holder in _first_inside(held, may, probes[inner], outlines):
            found[inner[row]] = holder
    return [int(holder) for holder in found]


def _first_inside(
    held: Truths, may: Indices, probes: Points, outlines: Sequence[Points]
) -> Iterator[tuple[Indices, int]]:
    """Rows of probes (n, k, 2) with the first holder, in order of `may`, that is around them.

    held: (n, m), which of the holders `may` (m,) come into question; it is used up.
    """
    open_ = np.flatnonzero(held.any(axis=1))
    while open_.size:
        columns = held[open_].argmax(axis=1)
        held[open_, columns] = False
        settled = np.zeros(len(open_), dtype=bool)
        for column in np.unique(columns):
            of = np.flatnonzero(columns == column)
            inside = _are_inside(probes[open_[of]].reshape(-1, 2), outlines[may[column]])
            most = inside.reshape(len(of), -1).mean(axis=1) > 0.5
            settled[of[most]] = True
            if most.any():
                yield open_[of[most]], int(may[column])
        open_ = open_[~settled]
        open_ = open_[held[open_].any(axis=1)]


def _view_axes(direction: Vector) -> Points:
    """The two axes (2, 3) of the plane that the tool looks onto."""
    x = level_x_axis(direction)
    return np.stack([x, cross(np.asarray(direction, dtype=np.float64), x)])


def _polygon_outline(contour: Contour, tolerance: float) -> Points:
    """Corners (n, 3) of a polygon along the contour, its end left out if it is closed."""
    parts = []
    for is_free, group in groupby(contour.curves, key=lambda curve: isinstance(curve, FreeCurve)):
        if is_free:
            parts += [chorded(curve, tolerance)[:-1] for curve in group]
            continue
        pieces: list[Line | Arc] = list(group)  # type: ignore[arg-type]
        counts = chord_counts(pieces, tolerance)
        rows = np.repeat(np.arange(len(pieces)), counts)
        first = np.cumsum(counts) - counts
        parts.append(
            points_at_parts(pieces, rows, (np.arange(len(rows)) - first[rows]) / counts[rows])
        )
    return np.concatenate(parts if contour.closed else [*parts, [contour.end]])


def _polygon_area(outline: Points) -> float:
    """Of a polygon (n, 2), by the shoelace formula."""
    x, y = (outline - outline[0]).T
    return 0.5 * abs(float((x * np.roll(y, -1) - y * np.roll(x, -1)).sum()))


def _probe_points(outline: Points) -> Points:
    """Points (k, 2) between corners of an outline."""
    place = np.array(PROBED_PARTS) * (len(outline) - 1)
    row = np.minimum(place.astype(np.intp), max(len(outline) - 2, 0))
    after = np.minimum(row + 1, len(outline) - 1)
    part = (place - row)[:, None]
    return np.asarray((1.0 - part) * outline[row] + part * outline[after])


def _are_inside(points: Points, outline: Points) -> Truths:
    """Which points (n, 2) a closed polygon (m, 2) is around, by the parity of crossings."""
    (x0, y0), (x1, y1) = outline.T, np.roll(outline, -1, axis=0).T
    together = max(1, MOST_CROSSINGS // len(outline))
    found = np.empty(len(points), dtype=bool)
    for first in range(0, len(points), together):
        x, y = points[first : first + together, :, None].transpose(1, 0, 2)
        over = (y0 > y) != (y1 > y)
        left = ((x - x0) * (y1 - y0) < (x1 - x0) * (y - y0)) == (y1 > y0)
        found[first : first + together] = (over & left).sum(axis=1) % 2 == 1
    return found
