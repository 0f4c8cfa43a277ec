"""Connections that stream setpoints to an arm, and its measured status.

`led` sends an arm to setpoints over a data link or cycle by cycle; `measured` only reads.
"""

from __future__ import annotations

import dataclasses
import math
import threading
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager
from typing import ClassVar, Final, Protocol

import numpy as np

from assistant.base.arrays import Floats, number_within
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Refused
from assistant.blocks.connections import Connection
from assistant.blocks.diagrams import closing_all
from assistant.blocks.library.arms import tool_pose
from assistant.blocks.library.ports import pose_signal
from assistant.blocks.rules import NO_SETPOINT_MODE, NO_STATUS_STREAM, SETPOINTS_BEHIND
from assistant.compiler.taught_targets import own_joints
from assistant.controllers import Controller, connect
from assistant.controllers.mitsubishi.control_mode import Measuring, Status
from assistant.controllers.mitsubishi.cr import Cr
from assistant.controllers.mitsubishi.state import turn_of
from assistant.controllers.setpoint_streams import MODES, Arm, Carrier, DataLinkCarrier
from assistant.controllers.trajectory_execution import LinkOptions
from assistant.program.geometry import IDENTITY, Pose
from assistant.program.se3 import AnyPose, pose_of
from assistant.robots import Robot
from assistant.robots.timing import drive_of

_CONTINUOUS_MODES: Final = tuple(name for name, mode in MODES.items() if not mode.waits)
"""Ways of leading in which the arm does not stop at each step."""
_SPEED_SECONDS: Final = 0.1
"""Seconds of which a stream tells the mean speed; timers of controllers count milliseconds."""
_MOST_QUEUED: Final = 50
"""Setpoints that have not gone out yet."""


@dataclass(frozen=True, slots=True, eq=False)
class ArmStatus:
    """Status of an arm with a axes, as its controller reports it.

    seconds: on the controller's clock. pose: (7,) of its tool. joints: (a,) as measured. told: (a,)
    as commanded. speed: of the tool, mm/s. records: number received so far. NaN for values that the
    connection does not report.
    """

    seconds: float
    pose: Floats
    joints: Floats
    told: Floats
    speed: float = math.nan
    records: int = 0


class StatusSource(Protocol):
    """Connection that reports the position of the arm while it moves."""

    def measured(self) -> ArmStatus:
        """The latest; raises Refused if it is not known any more."""


class StatusStream:
    """The status on a data link. real_time: both sides end it for what does not come in time.

    Its speed comes from the positions of the last `_SPEED_SECONDS`: `M_RSPD(1)` is the speed of the
    program in slot 1, and single commands move the arm in the edit slot.
    """

    real_time: ClassVar[bool] = True

    def __init__(self, source: Measuring, robot: Robot) -> None:
        self._source, self._axes = source, robot.axes
        self._seen: deque[tuple[float, Floats]] = deque()

    def measured(self) -> ArmStatus:
        found = _arm_status(self._source.status, len(self._source.recording), self._axes)
        speed = self._speed(found.seconds, found.pose[:3])
        return dataclasses.replace(found, speed=speed)

    def _speed(self, seconds: float, place: Floats) -> float:
        """Return the mean speed of the tool in mm/s, NaN before there are two records."""
        seen = self._seen
        if not seen or seconds != seen[-1][0]:
            seen.append((seconds, place))
        while len(seen) > 2 and seconds - seen[1][0] >= _SPEED_SECONDS:
            seen.popleft()
        if len(seen) < 2:
            return math.nan
        times = np.array([when for when, _ in seen])
        steps = np.diff(np.array([where for _, where in seen]), axis=0)
        return float(np.linalg.norm(steps, axis=1).sum() / (times[-1] - times[0]))


class SetpointSender:
    """Sender that moves an arm to setpoints in a separate thread: blocks wait for nothing.

    Setpoints go out in order, as fast as the carrier accepts them. told: (a,) the last one, from
    which the next one is computed. real_time: as of `StatusStream`.
    """

    real_time: ClassVar[bool] = True

    def __init__(self, carrier: Carrier, arm: Arm) -> None:
        self.carrier, self.arm = carrier, arm
        self.told = carrier.told()
        self._waiting: deque[tuple[Floats, float]] = deque()
        self._failure: BaseException | None = None
        self._over = False
        self._news = threading.Condition()
        self._thread = threading.Thread(target=self._run, name="leader", daemon=True)
        self._thread.start()

    def to(self, joints: Floats, seconds: float) -> None:
        """Wants the arm at joints (a,) in so many seconds; raises what one before met."""
        with self._news:
            self.check()
            if len(self._waiting) >= _MOST_QUEUED:
                raise Refused(SETPOINTS_BEHIND(count=len(self._waiting)))
            self._waiting.append((joints, seconds))
            self.told = joints
            self._news.notify_all()

    def check(self) -> None:
        """Raises what a setpoint met on its way."""
        if self._failure is not None:
            raise self._failure

    def measured(self) -> ArmStatus:
        if isinstance(self.carrier, DataLinkCarrier):
            mode = self.carrier.mode
            return _arm_status(mode.status, len(mode.recording), self.arm.axes)
        joints = self.carrier.joints()
        pose = self.arm.pose_of(joints)
        shown = pose_signal(pose.position, pose.quaternion)
        return ArmStatus(math.nan, shown, joints, self.carrier.told())

    def close(self) -> None:
        """Discard setpoints that have not gone out; wait for the one in transit.

        Raises an error of a setpoint that no block has collected.
        """
        with self._news:
            self._over = True
            self._news.notify_all()
        self._thread.join()
        self.check()

    def _run(self) -> None:
        while (step := self._wanted()) is not None:
            try:
                self.carrier.move(*step)
            except BaseException as error:  # noqa: BLE001 - it is the blocks', which raise it
                self._failure = error
                return

    def _wanted(self) -> tuple[Floats, float] | None:
        with self._news:
            self._news.wait_for(lambda: self._over or self._waiting)
            return None if self._over else self._waiting.popleft()


def led(
    name: str,
    address: str,
    robot: Robot,
    *,
    by: str = "data-link",
    percent: float = 10.0,
    tool: AnyPose = IDENTITY,
    wishes: LinkOptions | None = None,
    servo: bool = True,
    timeout: float = 10.0,
) -> Connection[SetpointSender]:
    """An arm that blocks lead, without stops between their setpoints.

    address: of the controller, or its name in the project. by: one of `_CONTINUOUS_MODES`.
    percent: of the speeds of its axes, which no setpoint may exceed. tool: on the flange. wishes:
    lines and ports, None for the usual ones. servo: whether the servos are switched on before and
    off after. Raises Refused for another way.
    """
    if by not in _CONTINUOUS_MODES:
        raise Refused(
            NO_SETPOINT_MODE(name=name, by=by, known=", ".join(_CONTINUOUS_MODES)), exit_status=2
        )
    arm, mode, given = (
        _arm_at_percent(robot, percent, pose_of(tool)),
        MODES[by],
        wishes or LinkOptions(),
    )

    @contextmanager
    def opening() -> Iterator[SetpointSender]:
        with connect(address, timeout=timeout) as session:
            mode.check(session, given)
            near, switched = robot.home, None
            if isinstance(session, Controller):
                near = np.array(own_joints(session.position(), robot))
                switched = session if servo and mode.operates else None
            with closing_all() as last:
                if switched:
                    last.callback(switched.motors, False)
                    switched.motors(True)
                leader = SetpointSender(
                    last.enter_context(mode.make(session, arm, given, near)), arm
                )
                last.callback(leader.close)
                yield leader

    return Connection(name, opening, moves=True)


def measured(
    name: str,
    line: str,
    robot: Robot,
    *,
    address: str | None = None,
    replace: bool = False,
    timeout: float = 10.0,
) -> Connection[StatusStream]:
    """A data link that tells where an arm is, and moves nothing.

    line: what leads to COM2 of the program. address: of the controller, on which the program is
    installed and started; None if it runs there. replace: another program of its name there.
    """

    @contextmanager
    def opening() -> Iterator[StatusStream]:
        if address is None:
            with Measuring(None, line, timeout=timeout) as source:
                yield StatusStream(source, robot)
            return
        session = connect(address, timeout=timeout)
        if not isinstance(session, Cr):
            raise Refused(NO_STATUS_STREAM(name=name, address=session.address), exit_status=2)
        with session, Measuring(session, line, timeout=timeout, replace=replace) as source:
            yield StatusStream(source, robot)

    return Connection(name, opening)


def _arm_at_percent(robot: Robot, percent: float, tool: Pose = IDENTITY) -> Arm:
    """An arm whose axes go at a percentage of their speeds; raises Refused for none."""
    percent = number_within(percent, "percent", above=0.0, most=100.0)
    drive, share = drive_of(robot), percent / 100.0

    def pose_of(joints: Floats) -> Pose:
        found = tool_pose(robot, tool, joints)
        return Pose.of(found[:3], found[3:])

    return Arm(
        controller=robot.controller,
        axes=robot.axes,
        sliding=tuple(bool(slides) for slides in robot.sliding),
        limits=robot.limits,
        full=drive.speeds,
        speeds=share * drive.speeds,
        rises=drive.accelerations,
        share=share,
        pose_of=pose_of,
        joints_of=lambda pose, near: None,  # noqa: ARG005 - of ways that are told poses
    )


def _arm_status(status: Status, records: int, axes: tuple[str, ...]) -> ArmStatus:
    place, commanded = status.position.values, status.commanded.values
    pose = pose_signal(place[:3], turn_of(commanded, place, five_axes="J4" not in axes))
    columns = [int(axis[1:]) - 1 for axis in axes]
    joints, told = (np.array(one)[columns] for one in (status.feedback.values, commanded))
    return ArmStatus(status.seconds, pose, joints, told, status.speed, records)
