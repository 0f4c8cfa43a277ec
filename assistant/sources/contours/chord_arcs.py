"""Arcs that a drawing holds as chains of chords.

Many programs export circles and arcs as polylines of short sides. Where the corners of such a chain
are on a circle, and the middles of its sides within the tolerance of it, one arc takes the place of
the chain: its path is smoother, and it is one move.

A chain is tried at each corner with its next four sides, all of them at once in columns; only where
these fit is it made as long as it still fits.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Final

import numpy as np

from assistant.base.arrays import Floats, Truths
from assistant.base.data_classes import dataclass
from assistant.sources.contours.curves import Arc, Points, circle_through, cross, vector

_FEWEST_SIDES: Final = 4
"""Sides of a chain, at least: three corners are on a circle always."""
_WIDEST_STEP: Final = np.radians(30.0)
"""Turn from side to side, at most; what turns by more was drawn with corners."""
_LEAST_SWEEP: Final = np.radians(15.0)
_MOST_SWEEP: Final = np.radians(300.0)
"""Sweep of an arc whose ends stay apart, so that three points determine its circle."""
_LARGEST_RADIUS: Final = 10_000.0
"""mm; a flatter arc is a measured line."""


@dataclass(frozen=True, slots=True)
class ChordArc:
    """An arc for the sides between two corners. first, last: these, rows of the points. deviation:
    mm between arc and sides at most.
    """

    first: int
    last: int
    arc: Arc
    deviation: float


def arcs_of_chords(
    points: Points, corner: float, side: float, *, around: bool, movable: Callable[[Arc], bool]
) -> Iterator[ChordArc]:
    """Yield the arcs that take the place of sides of a polyline (n, 3), in order.

    corner, side: mm that corners, and middles of sides, may be off. around: the last point is the
    first. movable: True for arcs that are one move as they are.
    """
    n = len(points)
    if n <= _FEWEST_SIDES or side <= 0.0 or corner <= 0.0:
        return
    if around and (ring := _ring(points, corner, side)) is not None and movable(ring.arc):
        yield ring
        return
    starts = _possible_starts(points, corner, side)
    begins, ends = np.flatnonzero(starts), np.flatnonzero(~np.append(starts, False))
    at = 0
    while (row := int(np.searchsorted(begins, at))) < len(begins):
        at = int(begins[row])
        # No chain goes on beyond corners that are on no arc with their neighbours.
        reach = int(ends[np.searchsorted(ends, at)]) + _FEWEST_SIDES - 1
        last, sweep, off = _longest(points[at : min(reach, n - 1) + 1], corner, side)
        found = None
        if sweep >= _LEAST_SWEEP:
            middle, end = vector(points[at + last // 2]), vector(points[at + last])
            found = Arc.through(vector(points[at]), middle, end)
        if found is not None and movable(found):
            yield ChordArc(at, at + last, found, off)
        at += max(last, 1)


def _ring(points: Points, corner: float, side: float) -> ChordArc | None:
    """Return the circle that a closed polyline is, None for any other."""
    n = len(points) - 1
    a, b, c = (vector(points[k]) for k in (0, n // 3, 2 * n // 3))
    circle = circle_through(a, b, c)
    if circle is None:
        return None
    arc = Arc.about(*circle, a, 360.0)
    centre, normal = np.array(circle)
    arms = points - centre
    if arc.radius > _LARGEST_RADIUS or not _fit(arms[None], normal, arc.radius, corner, side)[0]:
        return None
    if not np.isclose(_steps(arms, normal).sum(), 2.0 * np.pi):
        return None  # it goes round more than once
    off = (_off(one, normal, arc.radius).max() for one in (arms, _middles(arms)))
    return ChordArc(0, n, arc, float(max(off)))


def _possible_starts(points: Points, corner: float, side: float) -> Truths:
    """Return a flag for each corner (n - 4,): True if it and the next four are on an arc."""
    windows = np.lib.stride_tricks.sliding_window_view(points, _FEWEST_SIDES + 1, axis=0)
    windows = windows.transpose(0, 2, 1)
    middle = _FEWEST_SIDES // 2
    centre, normal, radius = _circles(windows[:, 0], windows[:, middle], windows[:, -1])
    return _fit(windows - centre[:, None], normal, radius, corner, side)


def _longest(points: Points, corner: float, side: float) -> tuple[int, float, float]:
    """Return the last corner of the longest chain from the first one, its sweep in radians and the
    mm that it is off.

    The length is doubled as long as it fits, and then found between.
    """

    def tried(last: int) -> tuple[float, float] | None:
        begin, *others = (vector(points[k]) for k in (0, last // 2, last))
        circle = circle_through(begin, *others)
        if circle is None:
            return None
        radius = math.dist(begin, circle[0])
        centre, normal = np.array(circle)
        # Most chains that are too long fail at a corner already.
        arms = points[: last + 1] - centre
        if (corners := _off(arms, normal, radius).max()) > corner:
            return None
        if (middles := _off(_middles(arms), normal, radius).max()) > side:
            return None
        steps = _steps(arms, normal)
        sweep = float(steps.sum())
        if steps.min() <= 0.0 or steps.max() > _WIDEST_STEP or sweep > _MOST_SWEEP:
            return None
        return sweep, float(max(corners, middles))

    fits, fails = 0, len(points)
    best = (0.0, 0.0)
    size = _FEWEST_SIDES
    while size < fails:
        if (found := tried(size)) is None:
            fails = size
            break
        fits, best = size, found
        if size == len(points) - 1:
            break
        size = min(2 * size, len(points) - 1)
    while fails - fits > 1 and fits:
        half = (fits + fails) // 2
        if half >= len(points):
            break
        if (found := tried(half)) is None:
            fails = half
        else:
            fits, best = half, found
    return fits, *best


def _circles(a: Points, b: Points, c: Points) -> tuple[Floats, Floats, Floats]:
    """Return centres (k, 3), normals (k, 3) and radii (k,) of circles through three points each;
    not a number for points on a line.
    """
    u, v = b - a, c - a
    w = cross(u, v)
    square = (w * w).sum(axis=1)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        square = np.where(square > 0.0, square, np.nan)
        uu, vv = (u * u).sum(axis=1), (v * v).sum(axis=1)
        out = cross(uu[:, None] * v - vv[:, None] * u, w)
        arm = out / (2.0 * square[:, None])
        return a + arm, w / np.sqrt(square)[:, None], np.linalg.norm(arm, axis=1)


def _middles(arms: Points) -> Points:
    """Return the middles of the sides of chains (…, m, 3), (…, m - 1, 3)."""
    return 0.5 * (arms[..., 1:, :] + arms[..., :-1, :])


def _off(arms: Points, normal: Floats, radius: Floats | float) -> Floats:
    """Return how far points (…, m, 3), seen from the centres of circles, are off these, (…, m)."""
    height = np.einsum("...mc,...c->...m", arms, normal)
    square = np.einsum("...mc,...mc->...m", arms, arms) - height * height
    beside = np.sqrt(np.maximum(square, 0.0)) - np.asarray(radius)[..., None]
    return np.asarray(np.hypot(beside, height))


def _steps(arms: Points, normal: Floats) -> Floats:
    """Return the angles of the sides of chains (…, m, 3) at the centres of circles, (…, m - 1) in
    radians.
    """
    before, after = arms[..., :-1, :], arms[..., 1:, :]
    sine = np.einsum("...mc,...c->...m", cross(before, after), normal)
    return np.asarray(np.arctan2(sine, np.einsum("...mc,...mc->...m", before, after)))


def _fit(
    arms: Points, normal: Floats, radius: Floats | float, corner: float, side: float
) -> Truths:
    """Return a flag for each chain (k, m, 3): True if an arc may take its place."""
    with np.errstate(invalid="ignore"):  # points on a line have no circle
        steps = _steps(arms, normal)
        fits = (_off(arms, normal, radius) <= corner).all(axis=1)
        fits &= (_off(_middles(arms), normal, radius) <= side).all(axis=1)
        return np.asarray(fits & ((steps > 0.0) & (steps <= _WIDEST_STEP)).all(axis=1))
