"""How fast an arm may turn, move and accelerate: what bounds its time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from assistant.base.arrays import Floats
from assistant.robots.robot import Robot

TIME_TO_SPEED: Final = 0.1
"""seconds that an axis takes to its full speed where no source tells its acceleration.

No maker publishes it for the arms of the catalogue; of some, a published picking cycle tells
what it comes to with a light load (`python -m benchmarks.picking`). For the arms whose maker's
planner states accelerations they come to about half of that; an arm that carries its load needs
more.
"""


@dataclass(frozen=True, slots=True, eq=False)
class Drive:
    """speeds, accelerations: (a,) of the axes, a second and a second squared.

    tcp_speed: mm/s at most on lines and arcs. tcp_acceleration: mm/s² at most on them.
    Infinite where only the axes bound them.
    """

    speeds: Floats
    accelerations: Floats
    tcp_speed: float
    tcp_acceleration: float


def drive_of(
    robot: Robot, tcp_acceleration: float | None = None, load: float | None = None
) -> Drive:
    """What the catalogue says of a robot, and `TIME_TO_SPEED` where it says nothing.

    load: kg that it carries, None if not known. A time to speed of the robot's own holds up to
    the load that it was fitted with; with more, an arm is never quicker than with less.
    """
    given, time = robot.accelerations, TIME_TO_SPEED
    if robot.time_to_speed is not None:
        light = load is not None and load <= robot.light
        time = robot.time_to_speed if light else max(robot.time_to_speed, TIME_TO_SPEED)
    return Drive(
        robot.speeds,
        robot.speeds / time if given is None else given,
        np.inf if robot.tcp_speed is None else robot.tcp_speed,
        np.inf if tcp_acceleration is None else tcp_acceleration,
    )
