"""A simulated arm: it follows joints as fast as its axes may."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from assistant.base.arrays import Floats
from assistant.blocks.arm_motion import ArmMotion
from assistant.blocks.diagrams.block import Block, Port
from assistant.blocks.library.arrays import joints_port, pose_port
from assistant.blocks.library.kinematics import tool_pose
from assistant.program.geometry import IDENTITY, Pose
from assistant.robots.robot import Robot


class SimulatedArm(Block):
    """joints that are wanted → joints and pose of the tool where it is, whether a limit holds.

    Each axis goes towards what is wanted, at its top speed at most and inside its limits. rests:
    whether what is wanted is a place to come to rest at, by its accelerations; setpoints that move
    on are only followed. lag: seconds of the first order by which a joint follows, 0 for as fast as
    it may. start: joints at the beginning, the arm's home if left out. percent: of the axes'
    speeds.
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
        rests: bool = False,
    ) -> None:
        outputs = [joints_port(robot), pose_port(), Port("limited")]
        super().__init__(name, [joints_port(robot, "wanted")], outputs)
        self.robot, self.tool, self.rests = robot, tool, rests
        self._made = partial(ArmMotion.of, robot, start=start, lag=lag, percent=percent)
        self.begin()

    def begin(self) -> None:
        self._motion, self._before = self._made(), 0.0

    def give(self, now: float, given: Sequence[Floats]) -> Sequence[ArrayLike]:
        """Where it is by now, having gone towards what was wanted since the moment before."""
        del given
        step, self._before = now - self._before, now
        motion = self._motion
        if self.rests:
            motion.step(step)
            held = motion.at_speed
        else:
            held = motion.follow(step)
        place = tool_pose(self.robot, self.tool, motion.joints)
        return [motion.joints, place, [float(held.any() or motion.at_limit.any())]]

    def take(self, now: float, given: Sequence[Floats]) -> None:
        del now
        if not np.isfinite(given[0]).all():
            raise ValueError("joints that are wanted are no numbers")
        self._motion.towards(given[0])
