"""An arm that goes where it is told: limits of its axes, first order of its joints."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from assistant.base.arrays import Floats, Truths
from assistant.robots import Robot
from assistant.robots.robot import LIMIT_TOLERANCE
from assistant.robots.timing import Drive, drive_of


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

        Raises ValueError outside its limits.
        """
        at = np.array(robot.home if start is None else start, dtype=np.float64)
        if at.shape != robot.home.shape or not robot.inside(at) or not lag >= 0.0:
            raise ValueError(
                f"{len(robot.axes)} joints at the start are inside the limits of {robot.name}, "
                "and the lag is not below 0"
            )
        if not 0.0 < percent <= 100.0:
            raise ValueError("a percentage is above 0 and at most 100")
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
