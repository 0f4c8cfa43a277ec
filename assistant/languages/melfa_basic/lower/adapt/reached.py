"""Poses that an arm of five axes reaches, and how it takes them."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from assistant.program.arrays import Floats, Truths
from assistant.robots.configurations import BACK

MISS: Final = 0.05
"""degrees by which an orientation may leave what five axes reach."""
SAME: Final = 1e-6
"""degrees below which it is reached as it is."""
VERTICAL: Final = 1e-4
"""Sine of the tool's tilt below which it counts as straight up or down."""


def over_the_back(
    positions: Floats,
    quaternions: Floats,
    configurations: NDArray[np.int8],
) -> Truths:
    """Which poses a five-axis arm takes over its back with a tool that is not vertical (n,).

    Their A and B depend on axis 1, which no source says of this branch; straight down both
    branches show the same.
    """
    from assistant.robots.arms import five_axis

    tilt = five_axis.to_ab(positions, quaternions)[:, 1]
    tilted = np.abs(np.sin(np.radians(tilt))) > VERTICAL
    return np.asarray((configurations[:, BACK] == 1) & tilted)
