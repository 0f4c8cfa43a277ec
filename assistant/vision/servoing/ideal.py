"""An arm that is where it is told to be, in a time that nobody waits for: to try laws."""

from __future__ import annotations

from types import TracebackType
from typing import Self

import numpy as np

from assistant.base.arrays import Floats
from assistant.vision.servoing.synthetic import Clock


class SteppedClock(Clock):
    """A clock that only waiting moves on."""

    __slots__ = ("now",)

    def __init__(self) -> None:
        super().__init__()
        self.now = 0.0

    def __call__(self) -> float:
        return self.now

    def wait(self, seconds: float) -> None:
        self.now += max(0.0, seconds)


class IdealArm:
    """A `Carrier`. at: (a,) where it was told to be last. speeds: (a,) that steps may have. clock:
    by which it gets there in the time of a step, None for at once.

    rows: where it was told to be, one after the other. rested: how often it was brought to rest.
    """

    waits = False

    def __init__(
        self, at: Floats, speeds: Floats, period: float = 0.02, clock: Clock | None = None
    ) -> None:
        self.at, self.speeds, self.period = np.array(at, dtype=np.float64), speeds, period
        self.rows: list[Floats] = [self.at]
        self.rested = 0
        self._clock, self._left = clock, self.at
        self._since, self._takes = 0.0, 0.0

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Nothing is open."""

    def joints(self) -> Floats:
        if self._clock is None or self._takes <= 0.0:
            return self.at
        share = float(np.clip((self._clock() - self._since) / self._takes, 0.0, 1.0))
        return np.asarray(self._left + share * (self.at - self._left))

    def told(self) -> Floats:
        return self.at

    def move(self, to: Floats, seconds: float) -> None:
        if self._clock is not None:
            self._left, self._since, self._takes = self.joints(), self._clock(), seconds
        self.at = np.array(to)
        self.rows.append(self.at)

    def rest(self) -> None:
        """It stands where it is."""
        self.at, self._takes = self.joints(), 0.0
        self.rested += 1
