"""Small steps as jogs: each ends before the next one begins."""

from __future__ import annotations

from types import TracebackType
from typing import Final, Self

import numpy as np

from assistant.base.arrays import Floats
from assistant.controllers.controller import JogsJoints
from assistant.controllers.leading.carrier import Arm

JOG_PERIOD: Final = 1.0
"""Seconds of a step at most: nothing is looked at meanwhile, but much of each is asking."""
LEAST_JOG: Final = 0.01
"""Degrees or mm of a step: places are written with two decimals."""


class JogCarrier:
    """controller: is connected, has its motors on, and jogs several joints at once."""

    waits = True

    def __init__(self, controller: JogsJoints, arm: Arm, period: float = JOG_PERIOD) -> None:
        self.period, self.speeds = period, arm.slow
        self._controller, self._arm = controller, arm

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Each step has ended before."""

    def joints(self) -> Floats:
        there = self._controller.position().joints
        return np.array([there[place] for place in self._arm.places], dtype=np.float64)

    def told(self) -> Floats:
        return self.joints()

    def move(self, to: Floats, seconds: float) -> None:  # noqa: ARG002 - the percentage tells
        if float(np.abs(to - self.joints()).max()) < LEAST_JOG:
            return
        goal = dict(zip(self._arm.axes, to.tolist(), strict=True))
        self._controller.jog_joints(goal, float(self._arm.percent))

    def rest(self) -> None:
        """It stands."""
