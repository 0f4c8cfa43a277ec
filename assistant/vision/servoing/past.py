"""Where an arm was a moment ago: pictures are of the time in which they were taken."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from assistant.base.arrays import Floats

MOMENTS_KEPT: Final = 200
"""Moments that are remembered, of which each picture takes two."""


@dataclass(slots=True)
class JointHistory:
    """Moments (seconds of any clock, joints (a,)), one after the other."""

    _moments: deque[tuple[float, Floats]] = field(
        default_factory=lambda: deque(maxlen=MOMENTS_KEPT)
    )

    def add(self, seconds: float, joints: Floats) -> None:
        """seconds: none before those of the last moment."""
        self._moments.append((seconds, joints))

    def at(self, seconds: float) -> Floats:
        """(a,) joints at a time, in a line between the moments around it; those of the nearest
        moment for what was before all of them, or behind.
        """
        times = np.array([moment[0] for moment in self._moments])
        after = int(np.searchsorted(times, seconds))
        if after in (0, len(times)):
            return self._moments[min(after, len(times) - 1)][1]
        (early, before), (late, behind) = self._moments[after - 1], self._moments[after]
        share = (seconds - early) / (late - early)
        return np.asarray(before + share * (behind - before))
