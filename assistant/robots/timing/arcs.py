"""Arcs in columns: a move to a via point and the one after it lie on one circle."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from assistant.program.path import Kind
from assistant.robots.run import Floats

Rows = NDArray[np.intp]


@dataclass(frozen=True, slots=True, eq=False)
class Arcs:
    """m moves on circles, two of each arc: up to its via point, and on to its end.

    rows: (m,) of the moves, ascending. lengths: (m,) mm. angles: (m,) deg of the circle.
    centres, across, along: (m, 3) mm; a point at an angle is centre + cos · across + sin · along,
    counted from the start of the arc. first: (m,) deg where the move begins.
    """

    rows: Rows
    lengths: Floats
    angles: Floats
    centres: Floats
    across: Floats
    along: Floats
    first: Floats

    def points(self, rows: Rows, part: Floats) -> Floats:
        """(k, 3) mm, each at a part (k,) of the move in a row (k,)."""
        at = np.searchsorted(self.rows, rows)
        angle = np.radians(self.first[at] + part * self.angles[at])[:, None]
        return np.asarray(
            self.centres[at] + np.cos(angle) * self.across[at] + np.sin(angle) * self.along[at]
        )


def arcs_of(kinds: NDArray[np.uint8], starts: Floats, ends: Floats) -> Arcs | None:
    """The arcs among n moves with their starts and ends (n, 3); those that are none go straight."""
    vias = np.flatnonzero((kinds[:-1] == Kind.VIA) & (kinds[1:] == Kind.END))
    if not len(vias):
        return None
    a, b = ends[vias] - starts[vias], ends[vias + 1] - starts[vias]
    normal = np.cross(a, b)
    square = np.einsum("ij,ij->i", normal, normal)
    sizes = np.einsum("ij,ij->i", a, a) * np.einsum("ij,ij->i", b, b)
    round_ = square > 1e-12 * sizes
    vias, a, b, normal, square = (x[round_] for x in (vias, a, b, normal, square))
    if not len(vias):
        return None
    aa, bb = np.einsum("ij,ij->i", a, a)[:, None], np.einsum("ij,ij->i", b, b)[:, None]
    centre = starts[vias] + np.cross(aa * b - bb * a, normal) / (2.0 * square[:, None])
    across = starts[vias] - centre
    along = np.cross(normal / np.sqrt(square)[:, None], across)
    angles = []
    for point in (a, b):
        away = starts[vias] + point - centre
        angle = np.degrees(
            np.arctan2(np.einsum("ij,ij->i", away, along), np.einsum("ij,ij->i", away, across))
        )
        angles.append(angle % 360.0)
    via, end = angles
    radius = np.linalg.norm(across, axis=1)
    both = np.concatenate([vias, vias + 1])
    order = np.argsort(both)
    swept = np.concatenate([via, end - via])[order]
    return Arcs(
        both[order],
        np.radians(swept) * np.concatenate([radius, radius])[order],
        swept,
        np.concatenate([centre, centre])[order],
        np.concatenate([across, across])[order],
        np.concatenate([along, along])[order],
        np.concatenate([np.zeros(len(via)), via])[order],
    )
