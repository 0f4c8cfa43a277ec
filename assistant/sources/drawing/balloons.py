"""Find balloons in a drawing: circles around a text at the end of a line, as on axes of a grid.

A circle of the work may have a text in it as well, and centre lines run through it. A balloon
stands at the end of a line that is drafting by its name or line type and that points at its centre
from outside, nothing else is in it, and there are several of its size.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from typing import Final

import numpy as np

from assistant.base.arrays import Floats
from assistant.program.geometry import Pose
from assistant.sources.contours.curves import Arc, Curve, Line, sample

_FEWEST: Final = 2
"""Balloons of one size, at least."""
_SIZE_PART: Final = 0.001
"""Relative difference between radii of one size."""
_TOUCH_PART: Final = 0.05
"""Distance by the radius within which a line ends on the circle and points at its centre."""
_LEAST_LENGTH_PART: Final = 0.5
"""Length of the line by the radius, at least."""


def find_balloons(
    curves: Sequence[Curve], aside: Sequence[Curve], texts: Floats, back: Pose
) -> list[frozenset[int]]:
    """Return the rows of circles of `curves` that are balloons, those of one size together.

    aside: curves that are drafting by their names. texts: (n, 2) positions of texts, mm in the
    drawing's world. back: from the frame of the curves to that world.
    """
    circles = [
        (row, curve) for row, curve in enumerate(curves) if isinstance(curve, Arc) and curve.closed
    ]
    lines = [curve for curve in aside if isinstance(curve, Line)]
    if len(circles) < _FEWEST or not len(texts) or not lines:
        return []
    ends = back.moved(np.array([(line.start, line.end) for line in lines]).reshape(-1, 3))
    ends = ends[:, :2].reshape(-1, 2, 2)
    points = back.moved(sample(curves, (0.0, 0.5, 1.0)).reshape(-1, 3))[:, :2]
    points = points.reshape(len(curves), -1, 2)
    sizes: dict[int, set[int]] = defaultdict(set)
    for row, circle in circles:
        centre = back.moved(np.array([circle.centre]))[0, :2]
        radius = circle.radius
        if not (np.linalg.norm(texts - centre, axis=1) < radius).any():
            continue
        inner = np.linalg.norm(points - centre, axis=2) < (1.0 - _TOUCH_PART) * radius
        if not inner.any() and _is_pointed_at(centre, radius, ends):
            sizes[round(float(np.log(radius)) / _SIZE_PART)].add(row)
    return [frozenset(rows) for rows in sizes.values() if len(rows) >= _FEWEST]


def _is_pointed_at(centre: Floats, radius: float, ends: Floats) -> bool:
    """True if one of the lines (n, 2, 2) ends on a circle and points at its centre from outside."""
    for near, far in ((ends[:, 0], ends[:, 1]), (ends[:, 1], ends[:, 0])):
        out, along = near - centre, far - near
        length = np.linalg.norm(along, axis=1)
        on = np.abs(np.linalg.norm(out, axis=1) - radius) <= _TOUCH_PART * radius
        on &= length >= _LEAST_LENGTH_PART * radius
        out, along = out[on], along[on]
        beside = np.abs(out[:, 0] * along[:, 1] - out[:, 1] * along[:, 0]) / length[on]
        outward = (out * along).sum(axis=1) > 0.0
        if bool((outward & (beside <= _TOUCH_PART * radius)).any()):
            return True
    return False
