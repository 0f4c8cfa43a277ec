"""A simulated arm: it follows joints as fast as its axes may."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from assistant.blocks.diagrams.block import Block, Port
from assistant.blocks.library.arrays import joints_port, pose_port
from assistant.blocks.library.kinematics import tool_pose
from assistant.program.arrays import Floats
from assistant.program.geometry import IDENTITY, Pose
from assistant.robots.robot import Robot


class SimulatedArm(Block):
    """joints that are wanted → joints and pose of the tool where it is, whether a limit holds.

    Each axis goes towards what is wanted, at its top speed at most and inside its limits. lag:
    seconds of the first order by which a joint follows, 0 for as fast as it may. start: joints at
    the beginning, the arm's home if left out. percent: of the axes' speeds.
    """

    direct: ClassVar[bool] = False

    def __init__(
        self,
        name: str,
        robot: Robot,
        *,
        tool: Pose = IDENTITY,
        start: ArrayLike | None = None,
        lag: float = 0.0,
        percent: float = 100.0,
    ) -> None:
        outputs = [joints_port(robot), pose_port(), Port("limited")]
        super().__init__(name, [joints_port(robot, "wanted")], outputs)
        self.robot, self.tool, self.lag = robot, tool, lag
        self.start = robot.home.copy() if start is None else np.asarray(start, dtype=np.float64)
        if self.start.shape != robot.home.shape or not robot.inside(self.start):
            raise ValueError(f"{len(robot.axes)} joints inside the limits of {robot.name}")
        if not lag >= 0.0 or not 0.0 < percent <= 100.0:
            raise ValueError("lag is 0 s or more, percent above 0 and at most 100")
        self._speeds = robot.speeds * percent / 100.0
        self.begin()

    def begin(self) -> None:
        self._joints = self._wanted = self.start.copy()
        self._limited, self._before = False, 0.0

    def give(self, now: float, given: Sequence[Floats]) -> Sequence[ArrayLike]:
        """Where it is by now, having followed what was wanted since the moment before."""
        del given
        step, self._before = now - self._before, now
        gain = 1.0 if self.lag == 0.0 else 1.0 - np.exp(-step / self.lag)
        inside = np.clip(self._wanted, *self.robot.limits.T)
        way, most = gain * (inside - self._joints), self._speeds * step
        self._limited = bool((np.abs(way) > most).any() or (inside != self._wanted).any())
        self._joints = self._joints + np.clip(way, -most, most)
        place = tool_pose(self.robot, self.tool, self._joints)
        return [self._joints, place, [float(self._limited)]]

    def take(self, now: float, given: Sequence[Floats]) -> None:
        del now
        if not np.isfinite(given[0]).all():
            raise ValueError("joints that are wanted are no numbers")
        self._wanted = given[0]
