"""The blocks for bdsim that measure and lead without stops; `robot` holds the others.

arm = led("cell", "melfa://192.168.0.20", robots.get("rv-2aj"))
bd.RELJOINT(bd.clock(0.1), arm, robots.get("rv-2aj"), "rel")
"""

from __future__ import annotations

from typing import Any

from bdsim.block import SampledBlock
from bdsim.components import Clock

from assistant.blocks.connections import Connection
from assistant.blocks.leading import Leader, Measures
from assistant.blocks.library import leading
from assistant.blocks.library.adapted import Stepped
from assistant.program.geometry import IDENTITY, Pose
from assistant.robots.robot import Robot


class Status(Stepped, SampledBlock):
    """Where the arm is by data link, all the time; it moves nothing.

    It gives the pose of the tool, the joints, the joints that are asked for, the speed of the tool
    in mm/s, the seconds of the controller's clock, and how many records a second come.

    :param clock: at whose ticks it steps
    :type clock: Clock
    :param connection: given by `measured` or `led`
    :type connection: Connection
    :param robot: the arm
    :type robot: Robot
    """

    nin = 0
    nout = 6
    outlabels = ("T", "q", "q*", "v", "t", "n/s")

    def __init__(
        self,
        clock: Clock,
        connection: Connection[Measures],
        robot: Robot,
        name: str,
        **blockargs: Any,
    ) -> None:
        super().__init__(leading.Status(name, connection, robot), clock, **blockargs)


class RelJoint(Stepped, SampledBlock):
    """On by a step of the joints, at any time: it waits for nothing, and the arm does not stop.

    While `go` is above 0.5 each tick is a step from where the arm was told to be last. It gives
    these joints, and how many steps were told.

    :param clock: at whose ticks it steps
    :type clock: Clock
    :param connection: given by `led`
    :type connection: Connection
    :param robot: the arm that moves
    :type robot: Robot
    :param most: degrees or mm that an axis may go in a step
    :type most: float
    """

    nin = 2
    nout = 2
    inlabels = ("dq", "go")
    outlabels = ("q*", "n")

    def __init__(
        self,
        clock: Clock,
        connection: Connection[Leader],
        robot: Robot,
        name: str,
        *,
        most: float = 5.0,
        **blockargs: Any,
    ) -> None:
        inner = leading.RelJoint(name, connection, robot, most=most)
        super().__init__(inner, clock, **blockargs)


class RelCart(Stepped, SampledBlock):
    """On by a step of the tool (mm, and a turn in degrees about x, y, z); as `RelJoint` else.

    :param clock: at whose ticks it steps
    :type clock: Clock
    :param connection: given by `led`
    :type connection: Connection
    :param robot: the arm that moves
    :type robot: Robot
    :param tool: on the flange
    :type tool: Pose
    :param in_tool: whether steps are told in the frame of the tool, and else in the base
    :type in_tool: bool
    :param most: mm and degrees of a step
    :type most: tuple
    """

    nin = 2
    nout = 2
    inlabels = ("dT", "go")
    outlabels = ("q*", "n")

    def __init__(
        self,
        clock: Clock,
        connection: Connection[Leader],
        robot: Robot,
        name: str,
        *,
        tool: Pose = IDENTITY,
        in_tool: bool = False,
        most: tuple[float, float] = (20.0, 5.0),
        **blockargs: Any,
    ) -> None:
        inner = leading.RelCart(name, connection, robot, tool=tool, in_tool=in_tool, most=most)
        super().__init__(inner, clock, **blockargs)
