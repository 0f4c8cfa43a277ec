"""Lattices of units: which are near to which, and how much they learn with one of them."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final

import numpy as np

from assistant.base.arrays import Floats, Rows

LEAST_SHARE: Final = 2e-3
"""Shares of a Gaussian below which a unit learns nothing from its neighbour."""
WIDEST_GAUSSIAN: Final = 1e3
"""Units; a wider Gaussian is flat over every lattice."""

LatticeBox = tuple[slice, ...]
"""A part of a lattice."""


@dataclass(slots=True, eq=False)
class Neighbourhood:
    """A Gaussian over a lattice, cut off where it is below `LEAST`.

    Made once for many winners: what is about each of them is a part of one array of shares.
    """

    shape: tuple[int, ...]
    width: float
    reaches: tuple[int, ...] = field(init=False)
    shares: Floats = field(init=False)

    def __post_init__(self) -> None:
        width = min(self.width, WIDEST_GAUSSIAN)
        reach = int(width * np.sqrt(-2.0 * np.log(LEAST_SHARE)))
        self.reaches = tuple(min(reach, count - 1) for count in self.shape)
        self.shares = np.ones(())
        for reach in self.reaches:
            away = np.arange(-reach, reach + 1)
            line = np.exp(-(away**2) / (2.0 * width**2)) if reach else np.ones(1)
            self.shares = self.shares[..., None] * line
        self.shares[self.shares < LEAST_SHARE] = 0.0

    @property
    def alone(self) -> bool:
        """Whether the winner has no neighbours any more."""
        return not any(self.reaches)

    def about(self, place: tuple[int, ...]) -> tuple[LatticeBox, Floats]:
        """The box of units near to one, and their shares."""
        box, part = [], []
        for at, reach, count in zip(place, self.reaches, self.shape, strict=True):
            low, high = max(at - reach, 0), min(at + reach + 1, count)
            box.append(slice(low, high))
            part.append(slice(low - at + reach, high - at + reach))
        return tuple(box), self.shares[tuple(part)]


def neighbour_pairs(shape: tuple[int, ...]) -> Rows:
    """(m, 2) units that are neighbours in a lattice, each pair once."""
    numbers = np.arange(int(np.prod(shape))).reshape(shape)
    found = [np.zeros((0, 2), dtype=np.intp)]
    for axis, count in enumerate(shape):
        first = np.take(numbers, np.arange(count - 1), axis).ravel()
        last = np.take(numbers, np.arange(1, count), axis).ravel()
        found.append(np.column_stack([first, last]))
    return np.concatenate(found)
