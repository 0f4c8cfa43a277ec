"""Corner rounding of paths that state none: no stop at a target, and the way kept all the same."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from assistant.base.arrays import Floats, Truths
from assistant.program.motion import Kind

ROUNDING_RADII: Final = np.array([0.01, 0.02, 0.05, 0.1, 0.3, 1.0, 5.0, 10.0, 20.0, 50.0])
"""mm; a few for all rows, as each is a declaration. Controllers have many of them built in."""


def rounding_radii(
    positions: Floats, kinds: NDArray[np.uint8], whole: Truths, tolerance: float
) -> Floats:
    """How far (n,) each corner may be rounded, in mm, one of `SIZES` or 0 for a stop.

    positions: (n, 3) mm. kinds: (n,). whole: (n - 1,), whether rows i and i + 1 are in one frame
    with one tool. The rounded way lies between the corner and the chord between the points where
    it leaves and comes back, which is r·sin(turn / 2) off the corner: that stays within the
    tolerance. So does half of r²/R where an arc of radius R runs into the corner. No
    corner takes more than half of the way to a neighbour. Moves of joints count as lines. The
    first and the last row, and those without a way on a side, are stops.
    """
    n = len(positions)
    found = np.zeros(n)
    if n < 3:
        return found
    step = np.diff(positions, axis=0)
    way = np.sqrt(np.einsum("ij,ij->i", step, step))
    inner = np.where(whole, way, 0.0)
    leaving = arriving = step / np.where(way > 0.0, way, 1.0)[:, None]
    bend = np.full(n - 1, np.inf)
    via = np.flatnonzero(kinds[:-1] == Kind.VIA)
    via = via[via > 0]
    if via.size:
        leaving, arriving = leaving.copy(), arriving.copy()
        start, middle, end = (positions[via + k] for k in (-1, 0, 1))
        leaving[via - 1], bend[via - 1] = _arc_tangents(start, middle, end)
        back, bend[via] = _arc_tangents(end, middle, start)
        arriving[via] = -back
    cosine = np.einsum("ij,ij->i", arriving[:-1], leaving[1:])
    half = np.sqrt(np.clip((1.0 - cosine) / 2.0, 0.0, 1.0))  # sin(turn / 2)
    with np.errstate(divide="ignore"):
        most = np.minimum(tolerance / half, np.minimum(inner[:-1], inner[1:]) / 2.0)
    most = np.minimum(most, np.sqrt(2.0 * tolerance * np.minimum(bend[:-1], bend[1:])))
    place = np.searchsorted(ROUNDING_RADII, most * (1.0 + 1e-9), "right")
    found[1:-1] = np.where(place > 0, ROUNDING_RADII[np.maximum(place - 1, 0)], 0.0)
    found[kinds == Kind.VIA] = 0.0  # a point on the way, no corner
    return found


def _arc_tangents(start: Floats, via: Floats, end: Floats) -> tuple[Floats, Floats]:
    """Unit directions (m, 3) in which arcs leave their start, and their radii (m,).

    An inversion about the start makes a line of the circle, which runs along the tangent. Floats
    on one line are an arc without bend; two that coincide have no direction.
    """
    to_via, to_end = via - start, end - start
    with np.errstate(divide="ignore", invalid="ignore"):
        one = to_via / (to_via**2).sum(axis=1, keepdims=True)
        two = to_end / (to_end**2).sum(axis=1, keepdims=True)
        size = np.linalg.norm(one - two, axis=1, keepdims=True)
        direction = np.nan_to_num((one - two) / size)
        sides = np.linalg.norm(np.stack([to_via, to_end, end - via]), axis=2).prod(axis=0)
        area = np.linalg.norm(np.cross(to_via, to_end), axis=1)
        radius = np.where(area > 0.0, sides / (2.0 * area), np.inf)
    return direction, radius
