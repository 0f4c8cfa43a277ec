"""Doubts about a target: how far it is from what was learnt, by the units about its winner.

Pictures of a tool that is moved by some joints lie on a surface among all pictures, and the lattice
lies on it. A target that is far beside the surface was not seen of the tool: two cameras see two
things there, or one of them has moved.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from assistant.base.arrays import Floats, Rows, norms
from assistant.learning.maps.extended_map import ExtendedMap

FLAT_SURFACE: Final = 0.15
"""Distances between neighbours by which a target may be beside a surface that is not bent."""
NOISE_RATIO: Final = 3.0
"""Times what a unit misses by that it may be as well."""
MOST_BESIDE: Final = 0.75
"""By trial no target of a map that has learnt is farther beside."""
LEAST_GAP: Final = 1e-12


@dataclass(frozen=True, slots=True, eq=False)
class UnitSurroundings:
    """Of m units, in spreads. gap: (m,) mean distance from their neighbours. planes: (m, d, k) axes
    at right angles that span the surface there. bend: (m,) by how much neighbours leave it.
    """

    gap: Floats
    planes: Floats
    bend: Floats

    def beside(self, offsets: Floats) -> Floats:
        """(m,) how far offsets (m, d) from the units lead away from the surface."""
        along = np.einsum("mdk,md->mk", self.planes, offsets)
        return norms(offsets - np.einsum("mdk,mk->md", self.planes, along))


def unit_surroundings(net: ExtendedMap, units: Rows) -> UnitSurroundings:
    at = np.stack(np.unravel_index(units, net.shape))
    total, count = np.zeros(len(units)), np.zeros(len(units))
    along: list[Floats] = []
    bent: list[Floats] = []
    for axis, size in enumerate(net.shape):
        for step in (-1, 1):
            there = _shift_along_axis(at, axis, step, size)
            total += norms(_unit_places(net, there) - _unit_places(net, at))
            count += there[axis] != at[axis]
        inner = at.copy()
        inner[axis] = np.clip(at[axis], 1, max(size - 2, 1))
        low, high = (
            _unit_places(net, _shift_along_axis(inner, axis, step, size)) for step in (-1, 1)
        )
        along.append(high - low)
        bent.append(high + low - 2.0 * _unit_places(net, inner) if size > 2 else np.zeros_like(low))
    gap = np.maximum(total / count, LEAST_GAP)
    found = UnitSurroundings(gap, np.linalg.qr(np.stack(along, axis=2))[0], np.zeros(len(units)))
    bend = np.max([found.beside(one) for one in bent], axis=0)
    return UnitSurroundings(gap, found.planes, bend)


def distance_beside(
    net: ExtendedMap, units: Rows, offsets: Floats, about: UnitSurroundings
) -> Floats:
    """(m,) how far offsets from units lead away from what was learnt, above 1 too far; NaN of a
    unit that never won.
    """
    noise = net.missed[units] * net.scale.pixel
    allowed = FLAT_SURFACE + (about.bend + NOISE_RATIO * noise) / about.gap
    return np.asarray(about.beside(offsets) / about.gap / np.minimum(allowed, MOST_BESIDE))


def _shift_along_axis(at: Rows, axis: int, step: int, size: int) -> Rows:
    """Places one step along an axis, where the lattice goes on there."""
    there = at.copy()
    there[axis] = np.clip(at[axis] + step, 0, size - 1)
    return there


def _unit_places(net: ExtendedMap, at: Rows) -> Floats:
    return np.asarray(net.places[np.ravel_multi_index(tuple(at), net.shape)])
