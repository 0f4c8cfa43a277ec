"""Arm guided cycle by cycle by setpoints of a model, within bounds of speed and region.

    cell = by_mxt("cell", "melfa://192.168.0.20", robot)
    arm = diagram.add(ExternalControl("arm", cell, robot))

A separate process sends the packets of each cycle and keeps the limits whatever the model does: it
brings the arm to rest when no setpoint follows, when the model ends, and when the controller falls
silent, which ends the run too.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from assistant.base.arrays import Floats
from assistant.base.diagnostics import Refused
from assistant.blocks.connections import Connection
from assistant.blocks.diagrams import Block, Port, closing_all
from assistant.blocks.library.ports import Connected, check_not_negative, joints_port
from assistant.blocks.rules import (
    ARM_OUTSIDE_BOUNDS,
    NOT_OPERATED,
    START_TOO_FAR,
    TARGET_NOT_FINITE,
    TWO_LEADERS,
)
from assistant.controllers import connect, setpoint_streams
from assistant.controllers.controller import Controller
from assistant.controllers.cyclic import Report, Settings, Timing
from assistant.controllers.cyclic.trajectory import braked
from assistant.controllers.setpoint_streams import CyclicCarrier
from assistant.controllers.trajectory_execution import LinkOptions, on_network
from assistant.program.geometry import IDENTITY
from assistant.program.se3 import AnyPose, pose_of
from assistant.robots.robot import Robot
from assistant.vision.servoing.bounds import Bounds, Guard

APPROACH: Final = 10.0
"""Degrees or mm that the first setpoint may be from where the arm stands."""
_LATE: Final = 0.01
"""Seconds that a setpoint may come late without the arm slowing down, and that it is behind."""
_HELD: Final = 1e-6
"""Degrees or mm from what is wanted beyond which a limit holds the arm back."""


class Led:
    """Arm under cyclic control. guard: its bounds. leader: the block that guides it, None at first.

    failed: whether the control ended on its own; its controller is stopped then.
    """

    def __init__(self, guard: Guard, carrier: CyclicCarrier) -> None:
        self.guard, self.carrier = guard, carrier
        self.leader: Block | None = None
        self.failed = False


def by_egm(
    name: str,
    host: str,
    robot: Robot,
    *,
    bounds: Bounds | None = None,
    tool: AnyPose = IDENTITY,
    port: int | None = None,
    cycle: float | None = None,
    settings: Settings | None = None,
) -> Connection[Led]:
    """An arm of an ABB controller, whose program comes and asks for joints (EGMActJoint).

    bounds: of speed and region, `Bounds()` if left out. tool: its tip in the frame of the flange,
    which stays in the box. port: of this computer, cycle: seconds; None for the usual.
    """

    @contextmanager
    def opening() -> Iterator[Led]:
        guard = Guard(robot, bounds or Bounds(), pose_of(tool, what="tool"))
        with setpoint_streams.by_egm(host, guard.arm(), port, cycle, settings) as carrier:
            yield Led(guard, carrier)

    return Connection(name, opening, moves=True)


def by_mxt(
    name: str,
    address: str,
    robot: Robot,
    *,
    bounds: Bounds | None = None,
    tool: AnyPose = IDENTITY,
    wishes: LinkOptions | None = None,
    servo: bool = True,
    timeout: float | None = None,
) -> Connection[Led]:
    """An arm of a CR controller by real-time external control; else as `by_egm`.

    The program that waits for its packets is on the controller meanwhile. servo: whether the servos
    are switched on before and off after. timeout: seconds to wait for an answer of the controller.
    """

    @contextmanager
    def opening() -> Iterator[Led]:
        guard = Guard(robot, bounds or Bounds(), pose_of(tool, what="tool"))
        wanted = wishes or LinkOptions()
        session = connect(address, timeout=timeout)
        if not isinstance(session, Controller):
            raise Refused(NOT_OPERATED(name=name, address=session.address), exit_status=2)
        on_network(session, wanted)
        with session, closing_all() as last:
            if servo:
                last.callback(session.motors, False)
                session.motors(True)
            led = None

            def stop_what_failed() -> None:
                if led is None or led.failed:
                    session.stop()

            last.callback(stop_what_failed)
            carrier = setpoint_streams.by_mxt(session, guard.arm(), wanted)
            led = Led(guard, last.enter_context(carrier))
            yield led

    return Connection(name, opening, moves=True)


class ExternalControl(Connected[Led]):
    """wanted joints, enable → measured joints, commanded joints, and the timing.

    While `enable` is above 0.5 the arm follows the setpoint: as fast as the setpoint changes, plus
    its lag, as fast as it can brake for, and never beyond the bounds of its connection; `limited`
    reports that these hold it back. Otherwise it comes to rest. cycles, late, worst, jitter: see
    `Timing`. approach: degrees or mm that the setpoint may be away when control is enabled.
    `report` and `summary` cover all cycles once the run has ended. Raises ValueError for an
    approach below 0.
    """

    def __init__(
        self,
        name: str,
        connection: Connection[Led],
        robot: Robot,
        *,
        approach: float = APPROACH,
        period: float | None = None,
    ) -> None:
        ports = [joints_port(robot), joints_port(robot, "commanded"), Port("limited")]
        ports += [Port("cycles"), Port("late"), Port("worst", unit="s"), Port("jitter", unit="s")]
        inputs = [joints_port(robot, "wanted"), Port("enable")]
        super().__init__(name, connection, inputs, ports, period)
        self.robot, self.moves = robot, connection.name
        self.approach = check_not_negative("approach", approach)
        self.report: Report | None = None

    @property
    def summary(self) -> str:
        """Return the timing in words, "" before a run has ended."""
        return "" if self.report is None else str(self.report)

    def begin(self) -> None:
        """Raises Refused for an arm that another block leads, and one outside of its bounds."""
        self.report = None
        super().begin()
        led = self.share
        if led.leader is not None:
            other, name = led.leader.name, self.connection.name
            raise Refused(TWO_LEADERS(block=self.name, other=other, name=name))
        led.leader = self
        self._told = led.carrier.joints()
        if what := led.guard.outside(self._told):
            raise Refused(ARM_OUTSIDE_BOUNDS(block=self.name, what=what))
        self._velocity = np.zeros(len(self._told))
        self._wanted: Floats | None = None
        self._before: float | None = None
        self._limited = False

    def end(self) -> None:
        led = self._share
        try:
            super().end()
        finally:
            if led is not None and led.leader is self:
                led.leader, self.report = None, led.carrier.leading.report

    def give(self, now: float, given: Sequence[Floats]) -> Sequence[ArrayLike]:
        """Raises Refused for a controller that is silent or has ended the control."""
        del now, given
        try:
            joints = self.share.carrier.joints()
        except Refused:
            self.share.failed = True
            raise
        timing = self.share.carrier.leading.timing()
        return [joints, self._told, [float(self._limited)], *_signals(timing)]

    def take(self, now: float, given: Sequence[Floats]) -> None:
        """The first moment is the beginning; each later one leads the arm on for a step."""
        wanted, going = given[0], bool(given[1][0] > 0.5)
        if going and not np.isfinite(wanted).all():
            raise Refused(TARGET_NOT_FINITE(block=self.name))
        before, self._before = self._before, now
        if going and self._wanted is None:
            self._check_near(wanted)
            self._wanted = wanted
        if before is not None:
            self._lead(wanted, going, now - before)
        self._wanted = wanted if going else None

    def _lead(self, wanted: Floats, going: bool, step: float) -> None:
        guard, velocity = self.share.guard, np.zeros(len(wanted))
        if going and self._wanted is not None:
            behind = self._wanted - self._told
            catch = zip(np.abs(behind).tolist(), guard.rises.tolist(), strict=True)
            most = np.array([braked(way, rise, step) for way, rise in catch])
            velocity = (wanted - self._wanted) / step + np.sign(behind) * most
        elif not self._velocity.any():
            self._limited = False
            return
        self._velocity = guard.limited(velocity, self._velocity, self._told, step)
        self._told = self._told + self._velocity * step
        self._limited = going and bool(np.abs(self._told - wanted).max() > _HELD)
        self.share.carrier.move(self._told, step + min(step, _LATE))

    def _check_near(self, wanted: Floats) -> None:
        away = np.abs(wanted - self._told)
        worst = int(np.argmax(away))
        if away[worst] > self.approach:
            where = {"axis": self.robot.axes[worst], "value": wanted[worst], "away": away[worst]}
            raise Refused(START_TOO_FAR(block=self.name, most=self.approach, **where))


def _signals(timing: Timing) -> list[ArrayLike]:
    return [[float(timing.cycles)], [float(timing.late)], [timing.longest], [timing.jitter]]
