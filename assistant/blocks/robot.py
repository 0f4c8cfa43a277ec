"""Blocks for bdsim, which finds them in this module: `BDSim(packages="assistant")`.

sim = BDSim(packages="assistant")
bd = sim.blockdiagram()
arm = bd.SIMARM(bd.clock(0.01), robots.get("rv-2aj"))

Signals are numbers as elsewhere: joints in degrees, poses as x, y, z in mm and a quaternion;
`POSETOSE3` and `SE3TOPOSE` convert to and from SE3 in metres. Blocks that move an arm run only by
`run_bdsim` or `run_paced` of `assistant.blocks.bdsim_adapter`, which receive the user's
confirmation.

bdsim's editor shows the contents of this module: parameters from the fields of the docstrings in
its format, icons of `Icons`, which `python -m docs.icons` draws, and ports by labels short enough
to leave room for the icons: q joints, T a pose, go start, b busy, n number of completed moves.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import numpy as np
from bdsim.block import FunctionBlock, SampledBlock
from spatialmath import SE3

from assistant.base import rotations
from assistant.blocks.bdsim_adapter import Direct, OfKind, Stepped
from assistant.blocks.library import arms, continuous_moves, sources, stopped_moves
from assistant.program.geometry import Pose

_METRE: Final = 1000.0


# ------------------------------------------------------------------- controller operation


class _Move(OfKind, Stepped):
    """Base of moves that are busy until the arm has stopped at its target."""

    nin = 2
    nout = 3
    inlabels: tuple[str, ...] = ("q", "go")
    outlabels = ("b", "n", "q")


class JointMovJoint(_Move, SampledBlock):
    """Joint motion to a joint target (J1 to J6 in degrees); busy until the arm has stopped there.

    While `start` is above 0.5 it moves to each new target. Its outputs are busy, the number of
    completed moves, and the joints where the arm stopped last.

    :param clock: at whose ticks it steps
    :type clock: Clock
    :param connection: given by `operated`
    :type connection: Connection
    :param robot: the arm that moves
    :type robot: Robot
    """

    kind = stopped_moves.JointMovJoint


class JointMovCart(_Move, SampledBlock):
    """To a pose, by the joints; as `JointMovJoint` else.

    A pose is six numbers, X, Y, Z in mm and A, B, C in degrees as the controller shows them (A and
    B of an arm of five axes), or seven, x, y, z in mm and a unit quaternion w, x, y, z.

    :param clock: at whose ticks it steps
    :type clock: Clock
    :param connection: given by `operated`
    :type connection: Connection
    :param robot: the arm that moves
    :type robot: Robot
    """

    kind = stopped_moves.JointMovCart
    inlabels = ("T", "go")


class LinMovJoint(_Move, SampledBlock):
    """To where joints bring the tool, on a line; as `JointMovJoint` else.

    :param clock: at whose ticks it steps
    :type clock: Clock
    :param connection: given by `operated`
    :type connection: Connection
    :param robot: the arm that moves
    :type robot: Robot
    """

    kind = stopped_moves.LinMovJoint


class LinMovCart(_Move, SampledBlock):
    """To a pose of six or seven numbers, as of `JointMovCart`, on a line.

    :param clock: at whose ticks it steps
    :type clock: Clock
    :param connection: given by `operated`
    :type connection: Connection
    :param robot: the arm that moves
    :type robot: Robot
    """

    kind = stopped_moves.LinMovCart
    inlabels = ("T", "go")


class CircularMov(_Move, SampledBlock):
    """To a pose, on an arc by way of another one, each as of `JointMovCart`.

    :param clock: at whose ticks it steps
    :type clock: Clock
    :param connection: given by `operated`
    :type connection: Connection
    :param robot: the arm that moves
    :type robot: Robot
    """

    kind = stopped_moves.CircularMov
    nin = 3
    inlabels = ("T", "T", "go")


# ---------------------------------------------------------------- measuring, and led steps


class Status(OfKind, Stepped, SampledBlock):
    """Continuous status of the arm over a data link; it moves nothing.

    Its outputs are the pose of the tool, the joints, the commanded joints, the speed of the tool in
    mm/s, the seconds of the controller's clock, and the records per second.

    :param clock: at whose ticks it steps
    :type clock: Clock
    :param connection: given by `measured` or `led`
    :type connection: Connection
    :param robot: the arm
    :type robot: Robot
    """

    kind = continuous_moves.Status
    nin = 0
    nout = 6
    outlabels = ("T", "q", "q*", "v", "t", "n/s")


class RelJoint(OfKind, Stepped, SampledBlock):
    """Relative joint step, at any time: the block waits for nothing, and the arm does not stop.

    While `go` is above 0.5 each tick commands a step from the last commanded position. Its outputs
    are these joints and the number of steps.

    :param clock: at whose ticks it steps
    :type clock: Clock
    :param connection: given by `led`
    :type connection: Connection
    :param robot: the arm that moves
    :type robot: Robot
    :param most: degrees or mm that an axis may go in a step
    :type most: float
    """

    kind = continuous_moves.RelJoint
    nin = 2
    nout = 2
    inlabels = ("dq", "go")
    outlabels = ("q*", "n")


class RelCart(OfKind, Stepped, SampledBlock):
    """Relative step of the tool; otherwise as `RelJoint`.

    A step is six numbers, x, y, z in mm and a turn about x, y, z in degrees, or seven, x, y, z in
    mm and the turn as a unit quaternion w, x, y, z.

    :param clock: at whose ticks it steps
    :type clock: Clock
    :param connection: given by `led`
    :type connection: Connection
    :param robot: the arm that moves
    :type robot: Robot
    :param tool: on the flange
    :type tool: Pose
    :param in_tool: whether steps are in the frame of the tool instead of the base
    :type in_tool: bool
    :param most: mm and degrees of a step
    :type most: tuple
    """

    kind = continuous_moves.RelCart
    nin = 2
    nout = 2
    inlabels = ("dT", "go")
    outlabels = ("q*", "n")


# -------------------------------------------------------------------- kinematics and arms


class ArmFK(OfKind, Direct, FunctionBlock):
    """joints → pose of the tool.

    :param robot: an arm
    :type robot: Robot
    :param tool: pose of the tool on the flange, none if left out
    :type tool: Pose
    """

    kind = arms.ForwardKinematics
    called = "fk"
    nin = 1
    nout = 1


class ArmIK(OfKind, Direct, FunctionBlock):
    """pose, branch → joints, whether there are any, all branches, which are valid.

    :param robot: an arm
    :type robot: Robot
    :param tool: pose of the tool on the flange, none if left out
    :type tool: Pose
    """

    kind = arms.InverseKinematics
    called = "ik"
    nin = 2
    nout = 4
    inlabels = ("T", "k")
    outlabels = ("q", "ok", "Q", "OK")


class ArmJacobian(OfKind, Direct, FunctionBlock):
    """joints → Jacobian, row by row.

    :param robot: an arm
    :type robot: Robot
    :param tool: pose of the tool on the flange, none if left out
    :type tool: Pose
    """

    kind = arms.Jacobian
    called = "jacobian"
    nin = 1
    nout = 1


class SimArm(OfKind, Stepped, SampledBlock):
    """joints that are wanted → joints, pose, whether a limit holds: a simulated arm.

    :param clock: at whose ticks it steps
    :type clock: Clock
    :param robot: an arm
    :type robot: Robot
    :param tool: pose of the tool on the flange, none if left out
    :type tool: Pose
    :param start: joints at the beginning in degrees, home if left out
    :type start: array_like
    :param lag: seconds of the first order by which joints follow, defaults to 0.0
    :type lag: float
    :param percent: of the speeds of the axes, defaults to 100.0
    :type percent: float
    :param rests: whether it comes to rest at each setpoint by its accelerations
    :type rests: bool
    """

    kind = arms.SimulatedArm
    called = "arm"
    nin = 1
    nout = 3
    inlabels = ("q",)
    outlabels = ("q", "T", "!")


# --------------------------------------------------------------------------------- sources


class MotionTable(OfKind, Direct, FunctionBlock):
    """Rows at times, in lines between them → their values, whether it is over.

    :param seconds: times that rise
    :type seconds: array_like
    :param rows: one for each time
    :type rows: array_like
    """

    kind = sources.Table
    called = "table"
    nin = 0
    nout = 2
    outlabels = ("y", "end")


class PoseLine(Direct, FunctionBlock):
    """From one pose to another on a line → pose, whether it is over.

    :param first: where it begins
    :type first: Pose
    :param last: where it ends
    :type last: Pose
    :param seconds: that it takes
    :type seconds: float
    """

    nin = 0
    nout = 2
    outlabels = ("T", "end")

    def __init__(
        self, first: Pose, last: Pose, seconds: float, name: str = "line", **blockargs: Any
    ) -> None:
        super().__init__(sources.PoseToPose(name, first, last, seconds), **blockargs)


class PoseToSE3(FunctionBlock):
    """pose → SE3 in metres."""

    nin = 1
    nout = 1

    def output(self, t: float, u: Sequence[Any], x: Any) -> list[Any]:
        del t, x
        matrix = np.eye(4)
        matrix[:3, :3] = rotations.to_matrix(rotations.canonical(u[0][3:]))
        matrix[:3, 3] = np.asarray(u[0][:3]) / _METRE
        return [SE3(matrix, check=False)]


class SE3ToPose(FunctionBlock):
    """SE3 in metres → pose."""

    nin = 1
    nout = 1

    def output(self, t: float, u: Sequence[Any], x: Any) -> list[Any]:
        del t, x
        matrix = np.asarray(u[0].A)
        turn = rotations.from_matrix(matrix[:3, :3])
        return [np.concatenate([_METRE * matrix[:3, 3], np.ravel(turn)])]
