"""How fast an arm may turn, move and accelerate: what bounds its time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from assistant.robots.robot import Robot

Floats = NDArray[np.float64]

TIME_TO_SPEED: Final = 0.1
"""seconds that an axis takes to its full speed where no source tells its acceleration.

No maker publishes it for the arms of the catalogue. For the arms whose maker's planner states
accelerations they come to about half of that; an arm that carries its load needs more.
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


def drive_of(robot: Robot, tcp_acceleration: float | None = None) -> Drive:
    """What the catalogue says of a robot, and `TIME_TO_SPEED` where it says nothing."""
    given = robot.accelerations
    return Drive(
        robot.speeds,
        robot.speeds / TIME_TO_SPEED if given is None else given,
        np.inf if robot.tcp_speed is None else robot.tcp_speed,
        np.inf if tcp_acceleration is None else tcp_acceleration,
    )
