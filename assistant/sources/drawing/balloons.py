"""Find balloons in a drawing: circles around a text at the end of a line, as on axes of a grid.

A circle of the work may have a text in it as well, and centre lines run through it. A balloon
stands at the end of a line that is drafting by its name or line type and that points at its centre
from outside, nothing else is in it, and there are several of its size. Lines from two directions
are the centre marks of a round plate.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from typing import Final, cast

import numpy as np
from numpy.typing import NDArray

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
_ONE_WAY: Final = 0.9
"""Least cosine between lines that come from one direction."""


def find_balloons(
    curves: Sequence[Curve], aside: Sequence[Curve], texts: Floats, back: Pose
) -> list[frozenset[int]]:
    """Return the rows of circles of `curves` that are balloons, those of one size together.

    aside: curves that are drafting by their names. texts: (n, 2) positions of texts, mm in the
    drawing's world. back: from the frame of the curves to that world.
    """
    rows = [row for row, curve in enumerate(curves) if isinstance(curve, Arc) and curve.closed]
    lines = [curve for curve in aside if isinstance(curve, Line)]
    if len(rows) < _FEWEST or not len(texts) or not lines:
        return []
    circles = [cast("Arc", curves[row]) for row in rows]
    centres = back.moved(np.array([circle.centre for circle in circles]))[:, :2]
    radii = np.array([circle.radius for circle in circles])
    drafted = np.array([(line.start, line.end) for line in lines]).reshape(-1, 3)
    ends = back.moved(drafted)[:, :2].reshape(-1, 2, 2)
    drawn = back.moved(sample(curves, (0.0, 0.5, 1.0)).reshape(-1, 3))[:, :2]
    labelled = np.unique(_near(centres, texts, radii)[0])
    centres, radii = centres[labelled], radii[labelled]
    pointed_at = _are_pointed_at(centres, radii, ends)
    pointed_at[_near(centres, drawn, (1.0 - _TOUCH_PART) * radii)[0]] = False
    sizes: dict[int, set[int]] = defaultdict(set)
    for at in np.flatnonzero(pointed_at).tolist():
        sizes[round(float(np.log(radii[at])) / _SIZE_PART)].add(rows[labelled[at]])
    return [frozenset(each) for each in sizes.values() if len(each) >= _FEWEST]


def _near(centres: Floats, points: Floats, reach: Floats) -> NDArray[np.intp]:
    """Return the pairs (2, p) of circles and of points (n, 2) that are within a reach (m,)."""
    import shapely

    finite = np.flatnonzero(np.isfinite(points).all(axis=1))
    tree = shapely.STRtree(shapely.points(points[finite]))
    circle, point = tree.query(shapely.points(centres), predicate="dwithin", distance=reach)
    return np.stack([circle, finite[point]])


def _are_pointed_at(centres: Floats, radii: Floats, ends: Floats) -> NDArray[np.bool_]:
    """Return a flag for each circle: True if one of the lines (n, 2, 2) ends on it and points at
    its centre from outside, and none does from another direction.
    """
    circles, ways = [], []
    for near, far in ((ends[:, 0], ends[:, 1]), (ends[:, 1], ends[:, 0])):
        circle, line = _near(centres, near, (1.0 + _TOUCH_PART) * radii)
        radius, out, along = radii[circle], near[line] - centres[circle], far[line] - near[line]
        length = np.linalg.norm(along, axis=1)
        beside = np.abs(out[:, 0] * along[:, 1] - out[:, 1] * along[:, 0])
        pointing = np.abs(np.linalg.norm(out, axis=1) - radius) <= _TOUCH_PART * radius
        pointing &= length >= _LEAST_LENGTH_PART * radius
        pointing &= (beside <= _TOUCH_PART * radius * length) & ((out * along).sum(axis=1) > 0.0)
        circles.append(circle[pointing])
        ways.append(along[pointing] / length[pointing, None])
    circle, way = np.concatenate(circles), np.concatenate(ways)
    found = np.zeros(len(centres), dtype=bool)
    first = np.zeros((len(centres), 2))
    found[circle], first[circle] = True, way
    apart = (first[circle] * way).sum(axis=1) < _ONE_WAY
    found[circle[apart]] = False
    return found
