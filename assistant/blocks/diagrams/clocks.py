"""Clocks of a run: as fast as it goes, or in real time with late steps counted."""

from __future__ import annotations

import math
import time
from typing import Final, Protocol

SPIN_SECONDS: Final = 2e-4
"""Seconds before a moment from which on it is waited for without sleeping."""


class RunClock(Protocol):
    """What the steps of a run wait for."""

    def begin(self) -> None:
        """The first step is next, at 0 s."""

    def reach(self, moment: float) -> float:
        """Comes back at a moment of the run; how many seconds after it."""


class Simulated:
    """Time passes as fast as the blocks allow."""

    def begin(self) -> None: ...

    def reach(self, moment: float) -> float:
        del moment
        return 0.0


class RealTime:
    """Time passes as it does. A step that comes late is made at once, and none is left out.

    pace: seconds of the run in each real one: that of a virtual controller which the run leads.
    Raises ValueError for one that is none.
    """

    def __init__(self, pace: float = 1.0) -> None:
        if not 0.0 < pace < math.inf:
            raise ValueError(f"a pace is a number of seconds above 0, not {pace!r}")
        self.pace, self._began = pace, 0.0

    def begin(self) -> None:
        self._began = time.monotonic()

    def reach(self, moment: float) -> float:
        due = self._began + moment / self.pace
        while (rest := due - time.monotonic()) > 0.0:
            if rest > SPIN_SECONDS:
                time.sleep(rest - SPIN_SECONDS)
        return -rest * self.pace
