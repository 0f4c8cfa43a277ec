"""The border to roboticstoolbox, which counts in metres and radians.

The package is an extra and is imported when it is used.
"""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from assistant.base.diagnostics import Refused, error
from assistant.robots.arms.placed import Placed
from assistant.robots.arms.serial import Serial

if TYPE_CHECKING:
    from roboticstoolbox import DHRobot
    from roboticstoolbox import Robot as ToolboxRobot

    from assistant.robots.robot import Robot

NEEDS_TOOLBOX: Final = error(
    "RB003",
    "{purpose} needs roboticstoolbox, which is not installed",
    "install it with `pip install 'robot-assistant[toolbox]'`",
)
COUPLED: Final = error(
    "RB009",
    "a robot of roboticstoolbox has no joint that turns with another, as J3 of {robot} does",
    "take the robot without `coupling`, and add its share of J2 to J3",
)
TOOLBOX_METRE: Final = 1000.0
"""mm."""


def toolbox_library(purpose: str) -> Any:
    """The module `roboticstoolbox`; raises Refused, naming the extra, if it is missing."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            import roboticstoolbox
    except ImportError:
        raise Refused(NEEDS_TOOLBOX(purpose=purpose), exit_status=2) from None
    return roboticstoolbox


def to_rtb(robot: Robot) -> DHRobot | ToolboxRobot:
    """See `Robot.to_rtb`."""
    if robot.coupling:
        raise Refused(COUPLED(robot=robot.name))
    toolbox = toolbox_library("a robot of roboticstoolbox")
    zero = np.where(robot.sliding, robot.zero / TOOLBOX_METRE, np.radians(robot.zero))
    limits = robot.limits * np.where(robot.sliding, 1.0 / TOOLBOX_METRE, np.radians(1.0))[:, None]
    links = robot.arm.links()
    if not links:
        arm = robot.arm.chain if isinstance(robot.arm, Placed) else robot.arm
        assert isinstance(arm, Serial)
        name = {"name": robot.title, "manufacturer": robot.maker}
        return toolbox.Robot(arm.chain.elementary(zero, limits), **name)
    rows = []
    for link, at, qlim in zip(links, zero, limits, strict=True):
        a, d = link.a / TOOLBOX_METRE, link.d / TOOLBOX_METRE
        if link.sliding:
            row = toolbox.PrismaticDH(
                theta=link.theta, a=a, alpha=link.alpha, offset=d + at, qlim=qlim
            )
        else:
            row = toolbox.RevoluteDH(d=d, a=a, alpha=link.alpha, offset=link.theta + at, qlim=qlim)
        rows.append(row)
    return toolbox.DHRobot(rows, name=robot.title, manufacturer=robot.maker)
