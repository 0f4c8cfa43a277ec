"""Blocks that measure all the time and move on without stops: Status, RelJoint and RelCart.

They are those of Kohrt et al., A Robot Manipulator Communications and Control Framework, table IV:
Status by data link ("continuous measurement"), the others by data link control ("continuous, non
blocking").
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from assistant.base import rotations
from assistant.base.arrays import Floats
from assistant.base.diagnostics import Refused
from assistant.blocks.connections import Connection
from assistant.blocks.diagrams import Port
from assistant.blocks.library.arms import tool_jacobian, tool_pose
from assistant.blocks.library.ports import (
    Connected,
    check_not_negative,
    joints_port,
    pose_port,
    step_port,
    tool_step,
)
from assistant.blocks.rules import (
    NO_JOINTS_NEARBY,
    OUT_OF_LIMITS,
    STEP_TOO_FAR,
    STEP_TOO_FAST,
    TARGET_NOT_FINITE,
)
from assistant.blocks.setpoint_connections import SetpointSender, StatusSource
from assistant.program.geometry import IDENTITY, Pose
from assistant.program.se3 import AnyPose, pose_of
from assistant.robots.robot import Robot

_RATE_SECONDS: Final = 1.0
"""Seconds over which the rate of a measurement is computed."""
_NEWTON_ROUNDS: Final = 20
_POSITION_TOLERANCE: Final = 1e-6
"""mm that a tool may be beside its place: steps end there, not before."""
_LIMIT_TOLERANCE: Final = 0.02
"""Degrees or mm by which the reported position of an axis at its limit may exceed that limit."""
_SPEED_ROUNDING: Final = 1e-6
"""Part of a speed that two moments of a run make of it."""


class Status(Connected[StatusSource]):
    """→ pose of the tool, joints, commanded joints, speed, seconds, rate.

    The values that the controller reports at present, also while the arm moves. seconds: on the
    controller's clock; rate: records per second of it, 0 before there are two. It moves nothing.
    """

    def __init__(
        self,
        name: str,
        connection: Connection[StatusSource],
        robot: Robot,
        *,
        period: float | None = None,
    ) -> None:
        own = [pose_port(), joints_port(robot), joints_port(robot, "told")]
        more = [Port("speed", 1, "mm/s"), Port("seconds", 1, "s"), Port("rate")]
        super().__init__(name, connection, (), [*own, *more], period)

    def begin(self) -> None:
        self._seen: deque[tuple[float, int]] = deque()
        super().begin()

    def give(self, now: float, given: Sequence[Floats]) -> Sequence[ArrayLike]:
        """Raises Refused if the controller tells nothing any more."""
        del now, given
        found = self.share.measured()
        rate = self._rate(found.seconds, found.records)
        return [found.pose, found.joints, found.told, [found.speed], [found.seconds], [rate]]

    def _rate(self, seconds: float, records: int) -> float:
        seen = self._seen
        seen.append((seconds, records))
        while len(seen) > 2 and seconds - seen[1][0] >= _RATE_SECONDS:
            seen.popleft()
        passed = seconds - seen[0][0]
        return (records - seen[0][1]) / passed if passed > 0.0 else 0.0


class Relative(Connected[SetpointSender]):
    """by, go → commanded joints, number of steps commanded.

    While `go` is above 0.5, the arm moves a step further from its last commanded position; steps
    may arrive at any time, and the block waits for none. most: largest size of a step.
    """

    def __init__(
        self,
        name: str,
        connection: Connection[SetpointSender],
        robot: Robot,
        by: Port,
        period: float | None,
    ) -> None:
        outputs = [joints_port(robot, "told"), Port("steps")]
        super().__init__(name, connection, [by, Port("go")], outputs, period)
        self.robot, self.moves = robot, connection.name

    def begin(self) -> None:
        self._before, self._steps = math.nan, 0
        super().begin()

    def give(self, now: float, given: Sequence[Floats]) -> Sequence[ArrayLike]:
        """Raises Refused for a step that the controller refused or did not make."""
        del now, given
        self.share.check()
        return [self.share.told, [float(self._steps)]]

    def take(self, now: float, given: Sequence[Floats]) -> None:
        seconds, self._before = now - self._before, now
        by, go = given
        if not go[0] > 0.5 or not by.any():
            return
        if not np.isfinite(by).all():
            raise Refused(TARGET_NOT_FINITE(block=self.name))
        by = tool_step(self.name, by)
        if not by.any():
            return
        joints = self.stepped(self.share.told, by)
        self._check(joints, seconds)
        joints = np.clip(joints, *self.share.arm.limits.T)
        period = self.share.carrier.period
        self.share.to(joints, period if math.isnan(seconds) else seconds)
        self._steps += 1

    def stepped(self, joints: Floats, by: Floats) -> Floats:
        """(a,) joints after a step from others; raises Refused for none."""
        raise NotImplementedError

    def _small(self, step: float, most: float, unit: str) -> None:
        if step > most:
            raise Refused(STEP_TOO_FAR(block=self.name, step=step, unit=unit, most=most))

    def _check(self, joints: Floats, seconds: float) -> None:
        arm = self.share.arm
        for axis, value, (low, high) in zip(arm.axes, joints, arm.limits, strict=True):
            if not low - _LIMIT_TOLERANCE <= value <= high + _LIMIT_TOLERANCE:
                told = {"low": low, "high": high, "robot": self.robot.name, "value": value}
                raise Refused(OUT_OF_LIMITS(block=self.name, axis=int(axis[1:]), **told))
        if math.isnan(seconds):
            return
        speeds = np.abs(joints - self.share.told) / seconds
        fast = np.flatnonzero(speeds > arm.speeds * (1.0 + _SPEED_ROUNDING))
        if len(fast):
            told = {"axis": arm.axes[fast[0]], "speed": speeds[fast[0]]}
            raise Refused(STEP_TOO_FAST(block=self.name, most=arm.speeds[fast[0]], **told))


class RelJoint(Relative):
    """by: degrees (mm) of each axis. most: degrees or mm that an axis may move in a step.

    Raises ValueError for a `most` that is not a number, which would bound nothing.
    """

    def __init__(
        self,
        name: str,
        connection: Connection[SetpointSender],
        robot: Robot,
        *,
        most: float = 5.0,
        period: float | None = None,
    ) -> None:
        super().__init__(name, connection, robot, joints_port(robot, "by"), period)
        self.most = check_not_negative("most", most)

    def stepped(self, joints: Floats, by: Floats) -> Floats:
        self._small(float(np.abs(by).max()), self.most, "degrees or mm")
        return joints + by


class RelCart(Relative):
    """by: a step of six or seven numbers, in the base or in the tool's frame.

    Six: x, y, z in mm and a turn about x, y, z in degrees, the vector along the axis of the turn.
    Seven: x, y, z in mm and the turn as a unit quaternion w, x, y, z; 1, 0, 0, 0 turns nothing.

    The turn is about the place of the tool. An arm of fewer than six axes goes to the place, and
    turns as near to what is wanted as it can. most: mm and degrees of a step; see `RelJoint`.
    """

    def __init__(
        self,
        name: str,
        connection: Connection[SetpointSender],
        robot: Robot,
        *,
        tool: AnyPose = IDENTITY,
        in_tool: bool = False,
        most: tuple[float, float] = (20.0, 5.0),
        period: float | None = None,
    ) -> None:
        super().__init__(name, connection, robot, step_port("by"), period)
        self.tool, self.in_tool = pose_of(tool, what="tool"), in_tool
        self.most = check_not_negative("mm", most[0]), check_not_negative("degrees", most[1])

    def stepped(self, joints: Floats, by: Floats) -> Floats:
        way, turn = by[:3], by[3:]
        self._small(float(np.linalg.norm(way)), self.most[0], "mm")
        self._small(float(np.linalg.norm(turn)), self.most[1], "degrees")
        start = tool_pose(self.robot, self.tool, joints)
        if self.in_tool:
            way, turn = (rotations.rotate(start[3:], one) for one in (way, turn))
        goal = start.copy()
        goal[:3] += way
        if angle := float(np.linalg.norm(turn)):
            about = rotations.about((turn / angle).tolist(), angle)
            goal[3:] = rotations.multiply(about, start[3:])
        found = _nearby_joints(self.robot, self.tool, joints, goal)
        if found is None:
            x, y, z = goal[:3]
            point = f"({x:.1f}, {y:.1f}, {z:.1f}) mm"
            raise Refused(NO_JOINTS_NEARBY(block=self.name, point=point, robot=self.robot.name))
        return found


def _nearby_joints(robot: Robot, tool: Pose, joints: Floats, goal: Floats) -> Floats | None:
    """(a,) joints near to others that bring a tool to a pose (7,); None if none do.

    By Newton's method with the place first and the turn as far as the axes that are left allow
    (Nakamura, Hanafusa and Yoshikawa, Task-priority based redundancy control, 1987).
    """
    found = joints.copy()
    for _ in range(_NEWTON_ROUNDS):
        off = _pose_error(tool_pose(robot, tool, found), goal)
        matrix = tool_jacobian(robot, found, tool)
        first = np.linalg.pinv(matrix[:3])
        free = np.eye(len(found)) - first @ matrix[:3]
        change = first @ off[:3]
        rest = off[3:] - matrix[3:] @ change
        change = change + np.linalg.pinv(matrix[3:] @ free, rcond=1e-6) @ rest
        found = found + change
        if (
            np.abs(change).max() < _POSITION_TOLERANCE
            and np.linalg.norm(off[:3]) < _POSITION_TOLERANCE
        ):
            return found
    return None


def _pose_error(pose: Floats, goal: Floats) -> Floats:
    """(6,) mm and degrees from a pose to another one, in the base."""
    turn = np.degrees(rotations.turns(pose[3:], goal[3:]))
    return np.concatenate([goal[:3] - pose[:3], turn])
