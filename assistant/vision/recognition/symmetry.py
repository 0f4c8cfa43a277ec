"""In how many ways an outline can be turned and look the same."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import numpy as np

from assistant.program.arrays import Floats
from assistant.vision.recognition.edges import sampled
from assistant.vision.recognition.judging import to_ring
from assistant.vision.recognition.objects import Outline

MOST: Final = 24
"""Turns of a full one that are tried; what looks the same by `PRIMES` of them is a disc."""
PRIMES: Final = (11, 13)
ALIKE: Final = 0.004
"""Part of its size by which a turned outline may be off itself."""

NEARLY: Final = 0.02
"""Part of its size by which it is off itself on average, where it looks nearly the same."""


def middle_of(outline: Outline) -> Floats:
    """(2,) the centre of area of what the first ring goes round, about which it is turned."""
    x, y = (outline.rings[0] - outline.rings[0][0]).T
    cross = x * np.roll(y, -1) - y * np.roll(x, -1)
    moment = [((one + np.roll(one, -1)) * cross).sum() for one in (x, y)]
    return np.asarray(outline.rings[0][0] + np.array(moment) / (3.0 * cross.sum()))


def symmetry_of(outline: Outline) -> int:
    """The ways, 1 for none but itself, 0 for a disc, which can be turned by any angle."""
    return _ways(outline, lambda off: float(off.max()) < ALIKE)


def near_symmetry_of(outline: Outline) -> int:
    """In how many ways it looks nearly the same, but for something small."""
    return _ways(outline, lambda off: float(off.mean()) < NEARLY)


def _ways(outline: Outline, alike: Callable[[Floats], bool]) -> int:
    """alike: whether a turned outline is, by how far places on it are off, as parts of its size."""
    middle, size = middle_of(outline), outline.diameter
    points = sampled(outline, size / 90.0).points[:, :2] - middle
    rings = [ring - middle for ring in outline.rings]

    def same(ways: int) -> bool:
        turn = 2.0 * np.pi / ways
        c, s = np.cos(turn), np.sin(turn)
        turned = points @ np.array([[c, s], [-s, c]])
        off = np.min([to_ring(ring, turned) for ring in rings], axis=0)
        return alike(off / size)

    if all(same(ways) for ways in PRIMES):
        return 0
    return next((ways for ways in range(MOST, 1, -1) if same(ways)), 1)
