"""Small steps as poses by files: each is a request, and its answer tells where the arm stands."""

from __future__ import annotations

from types import TracebackType
from typing import Final, Self

import numpy as np

from assistant.base.arrays import Floats
from assistant.base.diagnostics import Refused
from assistant.controllers.abb.exchange import PoseExchange
from assistant.controllers.controller import Programs
from assistant.controllers.leading import rules
from assistant.controllers.leading.carrier import Arm
from assistant.program.geometry import Pose

POSE_PERIOD: Final = 0.5
"""Seconds of a step at most: nothing is looked at meanwhile, but much of each are the files."""


class PoseCarrier:
    """The program of the exchange runs already, with the tool that `Arm.pose_of` has, in the base.

    Its speed is that of its module. begin: (a,) joints near to which the first pose is looked for:
    the answers tell no joints.
    """

    waits = True

    def __init__(
        self, programs: Programs, arm: Arm, begin: Floats, period: float = POSE_PERIOD
    ) -> None:
        self.period, self.speeds = period, arm.speeds
        self._arm, self._exchange, self._near = arm, PoseExchange(programs), begin
        self.begun = False

    @property
    def exchange(self) -> PoseExchange:
        """What the steps go by; its `recording` holds every answer."""
        return self._exchange

    def __enter__(self) -> Self:
        self._exchange.__enter__()
        self.begun = True
        self._take(self._exchange.current_pose().pose)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._exchange.__exit__(kind, error, trace)

    def joints(self) -> Floats:
        return self._near

    def told(self) -> Floats:
        return self._near

    def move(self, to: Floats, seconds: float) -> None:  # noqa: ARG002 - the module tells how fast
        self._near = np.array(to)
        self._take(self._exchange.move_to(self._arm.pose_of(to)).pose)

    def rest(self) -> None:
        """It stands."""

    def _take(self, pose: Pose) -> None:
        found = self._arm.joints_of(pose, self._near)
        if found is None:
            x, y, z = pose.position
            raise Refused(rules.NO_JOINTS(point=f"({x:.1f}, {y:.1f}, {z:.1f}) mm"))
        self._near = found
