"""The blocks for bdsim, which finds them here: `BDSim(packages="assistant")`.

sim = BDSim(packages="assistant")
bd = sim.blockdiagram()
arm = bd.SIMARM(bd.clock(0.01), robots.get("rv-2aj"))

Signals are numbers as elsewhere: joints in degrees, poses as x, y, z in mm and a quaternion;
`POSETOSE3` and `SE3TOPOSE` are for what takes and gives SE3 in metres. What moves an arm runs only
by `run_bdsim` or `run_paced` of `assistant.blocks.running_bdsim`, which are told that it was
confirmed.

Its editor shows what stands here: parameters by the fields of the docstrings in its own form, icons
of `Icons`, which `python -m docs.icons` draws, ports by labels that are short enough to leave room
for these: q joints, T a pose, go start, b busy, n how many moves are done.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextvars import ContextVar
from typing import Any, ClassVar, Final

import numpy as np
from bdsim.block import FunctionBlock, SampledBlock
from bdsim.components import Clock
from spatialmath import SE3

from assistant.blocks.connections import Connection, Operator
from assistant.blocks.diagrams.block import Block
from assistant.blocks.diagrams.running import check_confirmed, named, outputs
from assistant.blocks.library import arms, kinematics, moving, sources
from assistant.program import rotations
from assistant.program.arrays import Floats
from assistant.program.diagnostics import Refused
from assistant.program.geometry import IDENTITY, Pose
from assistant.robots.robot import Robot

CONFIRMED: Final[ContextVar[frozenset[str]]] = ContextVar("confirmed", default=frozenset())
"""Names of the controllers whose arms may be moved by the run that begins."""
METRE: Final = 1000.0
NEAR: Final = 1e-6
"""Part of a period by which a moment may be beside a tick, as it is added up."""


class _Adapted:
    """What a block of ours is to bdsim; its class of bdsim stands behind this one."""

    def __init__(self, inner: Block, **blockargs: Any) -> None:
        self._inner = inner
        super().__init__(  # type: ignore[call-arg]
            nin=len(inner.inputs),
            nout=len(inner.outputs),
            inames=[port.name for port in inner.inputs] or None,
            onames=[f"{port.name}_" for port in inner.outputs] or None,
            name=inner.name,
            **blockargs,
        )

    def _raise_runtime_error(self, operation: str, err: Exception, **more: Any) -> None:
        """A Refused as it is; of others bdsim prints much, and ends with an error of its own."""
        if isinstance(err, Refused):
            raise err
        super()._raise_runtime_error(operation, err, **more)  # type: ignore[misc]

    def _given(self, values: Sequence[Any]) -> list[Floats]:
        ports = self._inner.inputs
        arrays = [np.atleast_1d(np.asarray(value, dtype=np.float64)).ravel() for value in values]
        wrong = [p.name for p, a in zip(ports, arrays, strict=True) if a.shape != (p.size,)]
        if wrong:
            raise ValueError(f"`{self._inner.name}` is given another size at {', '.join(wrong)}")
        return arrays

    def _shown(self, values: Sequence[Floats]) -> list[Any]:
        """Single numbers as such, as bdsim's own blocks give them."""
        return [float(one[0]) if one.shape == (1,) else one for one in values]


class _Direct(_Adapted):
    """A function of the signals of the moment."""

    def output(self, t: float, u: Sequence[Any], x: Any) -> list[Any]:
        del x
        with named(self._inner, t):
            return self._shown(outputs(self._inner, t, self._given(u)))


class _Stepped(_Adapted):
    """A block that steps with a clock. Until a run begins it gives zeros."""

    def __init__(self, inner: Block, clock: Clock, **blockargs: Any) -> None:
        super().__init__(inner, clock=clock, ndstates=1, **blockargs)
        self._begun = self._open = False
        self._at: float | None = None
        self._taken: float | None = None
        self._shows = self._shown([np.zeros(port.size) for port in inner.outputs])

    def start(self, simstate: Any) -> None:
        """Raises Refused for an arm that nobody confirmed to move."""
        super().start(simstate)  # type: ignore[misc]
        check_confirmed([self._inner], CONFIRMED.get())
        self._open = True
        with named(self._inner, 0.0):
            self._inner.begin()
        self._begun, self._at, self._taken = True, None, None

    def output(self, t: float, u: Sequence[Any], x: Any) -> list[Any]:
        """What it gives at a moment is worked out once, however often bdsim asks."""
        del u, x
        if self._begun and t != self._at:
            self._at = t
            self._shows = self._shown(outputs(self._inner, t, ()))
        return self._shows

    def next(self, t: float, u: Sequence[Any], x: Floats) -> Floats:
        """At the tick of any clock bdsim asks all blocks: here that of its own counts, and once."""
        clock: Clock = self._clock  # type: ignore[attr-defined]
        ticks = (t - clock.offset) / clock.T
        if t != self._taken and abs(ticks - round(ticks)) < NEAR:
            self._taken = t
            with named(self._inner, t):
                self._inner.take(t, self._given(u))
        return x

    def done(self, **arguments: Any) -> None:
        super().done(**arguments)  # type: ignore[misc]
        if self._open:  # also if its begin failed half way
            self._begun = self._open = False
            self._inner.end()


# ------------------------------------------------------------------- controller operation


class _Move(_Stepped):
    """Busy until the arm stands where it was told to go."""

    nin = 2
    nout = 3
    inlabels: tuple[str, ...] = ("q", "go")
    outlabels = ("b", "n", "q")
    kind: ClassVar[type[moving.Move]]

    def __init__(
        self,
        clock: Clock,
        connection: Connection[Operator],
        robot: Robot,
        name: str,
        **blockargs: Any,
    ) -> None:
        super().__init__(self.kind(name, connection, robot), clock, **blockargs)


class JointMovJoint(_Move, SampledBlock):
    """To joints (J1 to J6 in degrees), by the joints; busy until the arm stands there.

    While `start` is above 0.5 it moves to each new target. It gives whether it is busy, how many
    moves are done, and the joints where the arm stood last.

    :param clock: at whose ticks it steps
    :type clock: Clock
    :param connection: given by `operated`
    :type connection: Connection
    :param robot: the arm that moves
    :type robot: Robot
    """

    kind = moving.JointMovJoint


class JointMovCart(_Move, SampledBlock):
    """To a pose (X, Y, Z in mm, A, B, C in degrees), by the joints; as `JointMovJoint` else.

    :param clock: at whose ticks it steps
    :type clock: Clock
    :param connection: given by `operated`
    :type connection: Connection
    :param robot: the arm that moves
    :type robot: Robot
    """

    kind = moving.JointMovCart
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

    kind = moving.LinMovJoint


class LinMovCart(_Move, SampledBlock):
    """To a pose (X, Y, Z in mm, A, B, C in degrees), on a line; as `JointMovJoint` else.

    :param clock: at whose ticks it steps
    :type clock: Clock
    :param connection: given by `operated`
    :type connection: Connection
    :param robot: the arm that moves
    :type robot: Robot
    """

    kind = moving.LinMovCart
    inlabels = ("T", "go")


class CircularMov(_Move, SampledBlock):
    """To a pose, on an arc by way of another one; as `JointMovJoint` else.

    :param clock: at whose ticks it steps
    :type clock: Clock
    :param connection: given by `operated`
    :type connection: Connection
    :param robot: the arm that moves
    :type robot: Robot
    """

    kind = moving.CircularMov
    nin = 3
    inlabels = ("T", "T", "go")


# -------------------------------------------------------------------- kinematics and arms


class ArmFK(_Direct, FunctionBlock):
    """joints → pose of the tool.

    :param robot: an arm
    :type robot: Robot
    :param tool: pose of the tool on the flange, none if left out
    :type tool: Pose
    """

    nin = 1
    nout = 1

    def __init__(
        self, robot: Robot, tool: Pose | None = None, name: str = "fk", **blockargs: Any
    ) -> None:
        super().__init__(kinematics.ForwardKinematics(name, robot, tool or IDENTITY), **blockargs)


class ArmIK(_Direct, FunctionBlock):
    """pose, branch → joints, whether there are any, all branches, which are valid.

    :param robot: an arm
    :type robot: Robot
    :param tool: pose of the tool on the flange, none if left out
    :type tool: Pose
    """

    nin = 2
    nout = 4
    inlabels = ("T", "k")
    outlabels = ("q", "ok", "Q", "OK")

    def __init__(
        self, robot: Robot, tool: Pose | None = None, name: str = "ik", **blockargs: Any
    ) -> None:
        super().__init__(kinematics.InverseKinematics(name, robot, tool or IDENTITY), **blockargs)


class ArmJacobian(_Direct, FunctionBlock):
    """joints → Jacobian, row by row.

    :param robot: an arm
    :type robot: Robot
    :param tool: pose of the tool on the flange, none if left out
    :type tool: Pose
    """

    nin = 1
    nout = 1

    def __init__(
        self, robot: Robot, tool: Pose | None = None, name: str = "jacobian", **blockargs: Any
    ) -> None:
        super().__init__(kinematics.Jacobian(name, robot, tool or IDENTITY), **blockargs)


class SimArm(_Stepped, SampledBlock):
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

    nin = 1
    nout = 3
    inlabels = ("q",)
    outlabels = ("q", "T", "!")

    def __init__(
        self,
        clock: Clock,
        robot: Robot,
        *,
        name: str = "arm",
        tool: Pose | None = None,
        start: Any = None,
        lag: float = 0.0,
        percent: float = 100.0,
        rests: bool = False,
        **blockargs: Any,
    ) -> None:
        how = {"start": start, "lag": lag, "percent": percent, "rests": rests}
        inner = arms.SimulatedArm(name, robot, tool=tool or IDENTITY, **how)
        super().__init__(inner, clock, **blockargs)


# --------------------------------------------------------------------------------- sources


class MotionTable(_Direct, FunctionBlock):
    """Rows at times, in lines between them → their values, whether it is over.

    :param seconds: times that rise
    :type seconds: array_like
    :param rows: one for each time
    :type rows: array_like
    """

    nin = 0
    nout = 2
    outlabels = ("y", "end")

    def __init__(self, seconds: Any, rows: Any, name: str = "table", **blockargs: Any) -> None:
        super().__init__(sources.Table(name, seconds, rows), **blockargs)


class PoseLine(_Direct, FunctionBlock):
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
        matrix[:3, 3] = np.asarray(u[0][:3]) / METRE
        return [SE3(matrix, check=False)]


class SE3ToPose(FunctionBlock):
    """SE3 in metres → pose."""

    nin = 1
    nout = 1

    def output(self, t: float, u: Sequence[Any], x: Any) -> list[Any]:
        del t, x
        matrix = np.asarray(u[0].A)
        turn = rotations.from_matrix(matrix[:3, :3])
        return [np.concatenate([METRE * matrix[:3, 3], np.ravel(turn)])]
