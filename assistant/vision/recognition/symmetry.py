"""In how many ways an outline can be turned and look the same."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Final

import numpy as np

from assistant.base.arrays import Floats
from assistant.vision.recognition.edges import sample_outline
from assistant.vision.recognition.judging import distances_to_ring
from assistant.vision.recognition.objects import Outline

MOST_SYMMETRY: Final = 24
"""Turns of a full one that are tried; what looks the same by `PRIMES` of them is a disc."""
DISC_SYMMETRIES: Final = (11, 13)
SAME_OFFSET: Final = 0.004
"""Part of its size by which a turned outline may be off itself."""

NEARLY_SAME_OFFSET: Final = 0.02
"""Part of its size by which it is off itself on average, where it looks nearly the same."""


def outline_centre(outline: Outline) -> Floats:
    """(2,) the centre of area of what the first ring goes round, about which it is turned."""
    x, y = (outline.rings[0] - outline.rings[0][0]).T
    cross = x * np.roll(y, -1) - y * np.roll(x, -1)
    moment = [((one + np.roll(one, -1)) * cross).sum() for one in (x, y)]
    return np.asarray(outline.rings[0][0] + np.array(moment) / (3.0 * cross.sum()))


def symmetry_of(outline: Outline) -> int:
    """The ways, 1 for none but itself, 0 for a disc, which can be turned by any angle."""
    if all(off.max() < SAME_OFFSET for off in _turned_offsets(outline, DISC_SYMMETRIES)):
        return 0
    ways = range(MOST_SYMMETRY, 1, -1)
    alike = (
        k
        for k, off in zip(ways, _turned_offsets(outline, ways), strict=True)
        if off.max() < SAME_OFFSET
    )
    return next(alike, 1)


def near_symmetry_of(outline: Outline) -> int:
    """In how many ways it looks nearly the same, but for something small; 1 for none."""
    ways = range(2, MOST_SYMMETRY + 1)
    means = [float(off.mean()) for off in _turned_offsets(outline, ways)]
    least = min(means)
    if least > NEARLY_SAME_OFFSET:
        return 1
    return max(
        k for k, off in zip(ways, means, strict=True) if off <= 1.5 * least + SAME_OFFSET / 2.0
    )


def _turned_offsets(outline: Outline, ways: Iterable[int]) -> Iterator[Floats]:
    """How far places (n,) on an outline are off it as it is turned, in parts of its size."""
    middle, size = outline_centre(outline), outline.diameter
    points = sample_outline(outline, size / 90.0).points[:, :2] - middle
    rings = [ring - middle for ring in outline.rings]
    for number in ways:
        turn = 2.0 * np.pi / number
        c, s = np.cos(turn), np.sin(turn)
        turned = points @ np.array([[c, s], [-s, c]])
        yield np.min([distances_to_ring(ring, turned) for ring in rings], axis=0) / size
