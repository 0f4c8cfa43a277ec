"""Blocks of arms: forward and inverse kinematics, the Jacobian, and a simulated arm.

The axes of a simulated arm move as fast as their limits allow; a first-order lag of the joints can
be added. `ArmMotion` is that motion without a diagram.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import ClassVar, Final, Self

import numpy as np
from numpy.typing import ArrayLike

from assistant.base.arrays import Floats, Truths, finite_row, number_within
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Refused
from assistant.blocks.diagrams import Block, Port
from assistant.blocks.library.ports import joints_port, pose_parts, pose_port, pose_signal
from assistant.blocks.rules import NO_START
from assistant.program.geometry import IDENTITY, Pose
from assistant.program.se3 import AnyPose, pose_of
from assistant.robots.robot import LIMIT_TOLERANCE, Robot, require_robot
from assistant.robots.timing import Drive, drive_of

NEAREST_BRANCH: Final = -1.0
"""A branch input that asks for the branch nearest to the joints of the step before."""


class ForwardKinematics(Block):
    """joints → pose of the tool in the base. tool: in the frame of the flange."""

    def __init__(self, name: str, robot: Robot, tool: AnyPose = IDENTITY) -> None:
        super().__init__(name, [joints_port(robot)], [pose_port()])
        self.robot, self.tool = robot, pose_of(tool, what="tool")

    def give(self, now: float, given: Sequence[Floats]) -> Sequence[ArrayLike]:
        del now
        return [tool_pose(self.robot, self.tool, given[0])]


class InverseKinematics(Block):
    """pose, branch → joints of that branch, whether there are any, all branches, which are valid.

    A branch is its number among those of `Robot.ik`, or `NEAREST_BRANCH`. Without a solution the
    joints of the step before stay, and `valid` is 0; before there were any, those of the arm's
    home. Axes that turn further than once go on from the step before as far as their limits allow.
    """

    def __init__(self, name: str, robot: Robot, tool: AnyPose = IDENTITY) -> None:
        require_robot(robot)
        count = robot.branches
        super().__init__(
            name,
            [pose_port(), Port("branch")],
            [
                joints_port(robot),
                Port("valid"),
                Port("all", count * len(robot.axes)),
                Port("which", count),
            ],
        )
        self.robot, self.flange = robot, pose_of(tool, what="tool").inverse()
        self._last = robot.home.copy()

    def begin(self) -> None:
        self._last = self.robot.home.copy()

    def give(self, now: float, given: Sequence[Floats]) -> Sequence[ArrayLike]:
        del now
        position, turn = pose_parts(given[0])
        flange = Pose.of(position[0], turn[0]) @ self.flange
        found, valid = self.robot.ik([flange.position], [flange.quaternion])
        joints, there = self._near(found[0]), valid[0]
        branch = given[1][0]
        if branch == NEAREST_BRANCH:
            away = np.where(there, np.abs(joints - self._last).max(axis=1), np.inf)
            chosen = int(np.argmin(away)) if there.any() else -1
        else:
            chosen = int(branch) if 0 <= branch < len(there) and there[int(branch)] else -1
        if chosen >= 0:
            self._last = joints[chosen]
        return [self._last, [float(chosen >= 0)], joints.ravel(), there.astype(float)]

    def _near(self, joints: Floats) -> Floats:
        """Joints (b, a) whose axes are turned as near as limits allow to the step before."""
        near = joints.copy()
        for axis in self.robot.winding():
            near[:, axis] += 360.0 * np.round((self._last[axis] - joints[:, axis]) / 360.0)
        return np.where(self.robot.inside(near)[:, None], near, joints)


class Jacobian(Block):
    """joints → 6 a numbers, row by row: mm and degrees of the tool by each joint, in the base.

    Rows: x, y, z, and the turn about x, y, z.
    """

    def __init__(self, name: str, robot: Robot, tool: AnyPose = IDENTITY) -> None:
        super().__init__(name, [joints_port(robot)], [Port("jacobian", 6 * len(robot.axes))])
        self.robot, self.tool = robot, pose_of(tool, what="tool")

    def give(self, now: float, given: Sequence[Floats]) -> Sequence[ArrayLike]:
        del now
        return [tool_jacobian(self.robot, given[0], self.tool).ravel()]


class Resolved(Block):
    """Resolved motion rate: joints, speed of the tool (6,) → speeds of the joints (a,).

    Least squares, damped near singularities (Nakamura and Hanafusa 1986). damping: least singular
    value of the Jacobian, in mm and degrees a degree, at which it begins.
    """

    direct: ClassVar[bool] = True

    def __init__(
        self, name: str, robot: Robot, tool: AnyPose = IDENTITY, *, damping: float = 0.05
    ) -> None:
        require_robot(robot)
        speeds = Port("speeds", len(robot.axes), "deg/s")
        super().__init__(name, [joints_port(robot), Port("speed", 6)], [speeds])
        self.robot, self.tool = robot, pose_of(tool, what="tool")
        self.damping = number_within(damping, f"damping of `{name}`", above=0.0)

    def give(self, now: float, given: Sequence[Floats]) -> Sequence[ArrayLike]:
        del now
        matrix = tool_jacobian(self.robot, given[0], self.tool)
        u, s, vt = np.linalg.svd(matrix, full_matrices=False)
        part = np.clip(s[-1] / self.damping, 0.0, 1.0)
        damped = (1.0 - part**2) * self.damping**2
        return [vt.T @ ((s / (s**2 + damped)) * (u.T @ given[1]))]


def tool_pose(robot: Robot, tool: Pose, joints: Floats) -> Floats:
    """(7,) pose of a tool in the base for joints (a,)."""
    p, q = robot.fk(joints)
    place = Pose.of(p[0], q[0]) @ tool
    return pose_signal(place.position, place.quaternion)


def tool_jacobian(robot: Robot, joints: Floats, tool: Pose = IDENTITY) -> Floats:
    """(6, a) mm and degrees of the tool, in the base, a degree (or mm) of each of joints (a,)."""
    return np.asarray(robot.jacobian(joints, unit="deg", tool=tool)[0])


@dataclass(slots=True)
class ArmMotion:
    """Each axis goes to its goal and to rest there as fast as speed and acceleration allow.

    In a step the goal stands still, and the motion is exact: steps of any length give the same.
    `follow` is for goals that move on at each step: no axis comes to rest for them.
    robot: whose limits and kinematics count. drive: how fast its axes are. lag: seconds of the
    first order by which a joint follows its motor, 0 for none.
    at, speed: (a,) of the motors. goal: (a,). joints: (a,).
    reachable: whether the last goal was inside all limits. at_limit: (a,) which were not.
    """

    robot: Robot
    drive: Drive
    lag: float
    at: Floats
    speed: Floats
    goal: Floats
    joints: Floats
    at_limit: Truths
    reachable: bool = True

    @classmethod
    def of(
        cls,
        robot: Robot,
        *,
        start: ArrayLike | None = None,
        lag: float = 0.0,
        percent: float = 100.0,
    ) -> Self:
        """An arm at rest, at joints (a,) or at home. percent: of the speeds of its axes.

        Raises Refused outside its limits.
        """
        lag = number_within(lag, "lag", least=0.0)
        percent = number_within(percent, "percent", above=0.0, most=100.0)
        at = np.array(finite_row(robot.home if start is None else start, "start"))
        if at.shape != robot.home.shape or not robot.inside(at):
            low, high = (", ".join(f"{one:g}" for one in row) for row in robot.limits.T)
            given = f"{np.round(at, 3).tolist()}"
            ranges, count = f"({low}) to ({high})", len(robot.axes)
            raise Refused(NO_START(robot=robot.name, given=given, count=count, ranges=ranges))
        drive = drive_of(robot)
        drive = replace(drive, speeds=drive.speeds * percent / 100.0)
        nothing = np.zeros_like(at)
        outside = np.zeros(len(at), dtype=bool)
        return cls(robot, drive, lag, at, nothing, at.copy(), at.copy(), outside)

    @property
    def at_speed(self) -> Truths:
        """(a,) which axes go at their top speed."""
        return np.asarray(np.abs(self.speed) >= self.drive.speeds * (1.0 - 1e-12))

    @property
    def pose(self) -> Floats:
        """(7,) position in mm and quaternion of the flange."""
        p, q = self.robot.fk(self.joints)
        return np.concatenate([p[0], q[0]])

    def towards(self, joints: ArrayLike) -> None:
        """Goes to joints (a,), inside the limits; an axis whose joint is NaN goes on as before."""
        wanted = np.asarray(joints, dtype=np.float64)
        inside = np.clip(wanted, *self.robot.limits.T)
        self.at_limit = ~(inside == wanted)
        self.reachable = not self.at_limit.any()
        self.goal = np.where(np.isnan(wanted), self.goal, inside)

    def towards_pose(self, pose: ArrayLike, branch: int = -1) -> None:
        """Goes to a pose (7,) of the flange in a branch of `Robot.ik`; -1 is the nearest one.

        Without a solution it goes on as before, and is not `reachable`.
        """
        wanted = np.asarray(pose, dtype=np.float64)
        found, valid = self.robot.ik(wanted[:3], wanted[3:])
        some = valid[0] if branch < 0 else valid[0] & (np.arange(self.robot.branches) == branch)
        self.at_limit, self.reachable = np.zeros(len(self.goal), dtype=bool), bool(some.any())
        if self.reachable:
            low, high = self.robot.limits.T
            joints = np.clip(self._unwound(found[0, some]), low, high)
            self.goal = joints[np.abs(joints - self.goal).max(axis=1).argmin()]

    def step(self, seconds: float) -> None:
        """Goes on for so long."""
        times, rises = self._phases()
        at, speed, left = self.at.copy(), self.speed.copy(), np.full(len(self.at), seconds)
        for t, rise in zip(times, rises, strict=True):
            t = np.minimum(t, left)
            self.joints = self._followed(at, speed, rise, t)
            at += speed * t + rise * t * t / 2.0
            speed += rise * t
            left -= t
        there = seconds >= times[0] + times[1] + times[2]
        at[there], speed[there] = self.goal[there], 0.0
        rest = self._followed(at, speed, np.zeros_like(at), left)
        self.joints = np.where(there, rest, self.joints) if self.lag > 0.0 else at.copy()
        self.at, self.speed = at, speed

    def follow(self, seconds: float) -> Truths:
        """Goes on towards a goal that moves, by the speeds alone; (a,) which axes these held."""
        gain = 1.0 if self.lag == 0.0 else 1.0 - np.exp(-seconds / self.lag)
        way, most = gain * (self.goal - self.joints), self.drive.speeds * seconds
        self.joints = self.joints + np.clip(way, -most, most)
        self.speed = (self.joints - self.at) / seconds if seconds > 0.0 else self.speed
        self.at = self.joints.copy()
        return np.asarray(np.abs(way) > most)

    def _phases(self) -> tuple[Floats, Floats]:
        """(3, a) seconds each and accelerations: up, steady, down."""
        top, rise, speed = self.drive.speeds, self.drive.accelerations, self.speed
        stop = speed * np.abs(speed) / (2.0 * rise)
        way = np.where(self.goal - self.at - stop < 0.0, -1.0, 1.0)
        ahead, along = way * (self.goal - self.at), way * speed
        peak = np.minimum(top, np.sqrt(np.maximum(0.0, rise * ahead + speed * speed / 2.0)))
        steady = ahead - (2.0 * peak * peak - speed * speed) / (2.0 * rise)
        with np.errstate(divide="ignore", invalid="ignore"):
            even = np.where(peak > 0.0, np.maximum(0.0, steady) / peak, 0.0)
        times = np.stack([np.maximum(0.0, (peak - along) / rise), even, peak / rise])
        return times, np.stack([way * rise, 0.0 * rise, -way * rise])

    def _followed(self, at: Floats, speed: Floats, rise: Floats, t: Floats) -> Floats:
        """The joints after a time (a,) in which the motors have a steady acceleration.

        lag · joint' + joint = motor, whose solution is a parabola and a part that fades.
        """
        if not self.lag > 0.0:
            return self.joints
        before = at - self.lag * speed + self.lag * self.lag * rise
        later, there = speed + rise * t, at + speed * t + rise * t * t / 2.0
        fading = (self.joints - before) * np.exp(-t / self.lag)
        return np.asarray(there - self.lag * later + self.lag * self.lag * rise + fading)

    def _unwound(self, joints: Floats) -> Floats:
        """Joints (b, a) turned by whole turns as near to the goal as the limits allow."""
        low, high = self.robot.limits.T
        low, high = low - LIMIT_TOLERANCE, high + LIMIT_TOLERANCE
        turned = joints + 360.0 * np.rint((self.goal - joints) / 360.0)
        turned = np.where(
            turned > high, turned - 360.0, np.where(turned < low, turned + 360.0, turned)
        )
        better = (turned >= low) & (turned <= high) & ~self.robot.sliding
        return np.asarray(np.where(better, turned, joints))


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
        tool: AnyPose = IDENTITY,
        start: ArrayLike | None = None,
        lag: float = 0.0,
        percent: float = 100.0,
        rests: bool = False,
    ) -> None:
        outputs = [joints_port(robot), pose_port(), Port("limited")]
        super().__init__(name, [joints_port(robot, "wanted")], outputs)
        self.robot, self.tool, self.rests = robot, pose_of(tool, what="tool"), rests
        self._made = partial(ArmMotion.of, robot, start=start, lag=lag, percent=percent)
        self.begin()

    def begin(self) -> None:
        self._motion, self._before = self._made(), 0.0

    def give(self, now: float, given: Sequence[Floats]) -> Sequence[ArrayLike]:
        """Return the state of the arm after its motion towards the setpoint in the last step."""
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
