"""The arm of a controller that is led from outside: what is commanded, filtered and fed back."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from assistant.base.arrays import Floats
from assistant.base.rotations import from_euler, to_euler

if TYPE_CHECKING:
    from assistant.robots import Robot

PULSES: Final = 100.0
"""Pulses of a motor to a degree (or mm) of its axis: no maker publishes them, any number serves."""
LIMIT_ROUNDING: Final = 1e-3
"""Part of a step, and degrees, that single precision may add."""
SERVO_TIME: Final = 0.5
"""Part of the way to its command that an arm goes in a cycle: it is some two cycles behind."""
SPEED: Final = 2130
BEYOND: Final = 2160
BELOW: Final = 2170
"""Errors; the number of the axis is added (error list BFP-A8871)."""
NO_SOLUTION: Final = 2802
"""A pose that the arm cannot take, at those flags."""


class Refusal(Exception):
    """A command that the controller answers with an error; `number` of it."""

    def __init__(self, number: int) -> None:
        super().__init__(str(number))
        self.number = number


class MxtArm:
    """Joints (a,) in degrees, of axes that slide in mm.

    places: (a,) where each axis stands in a packet: J5 of an arm without J4 is still the fifth.
    joints: where it stands. cycle: seconds. filter_ms: time constant of the received command.
    servo: part of the way to its command that it goes in a cycle, 0 for an arm that is stuck.
    """

    def __init__(
        self,
        robot: Robot,
        joints: Floats,
        cycle: float,
        filter_ms: float = 0.0,
        servo: float = SERVO_TIME,
    ) -> None:
        self.robot, self.cycle = robot, cycle
        self.commanded = np.array(joints, dtype=np.float64)
        self.filtered = self.commanded.copy()
        self.fed_back = self.commanded.copy()
        self._servo = servo
        self._part = cycle / (cycle + filter_ms / 1e3)
        self._turning = ~np.asarray(robot.sliding)
        self.places = np.array(robot.places)

    def command(self, joints: Floats) -> None:
        """Takes a command; raises Refusal if it is out of range or too far for one cycle."""
        low, high = self.robot.limits.T
        for axis in map(int, np.flatnonzero(joints > high + LIMIT_ROUNDING)):
            raise Refusal(BEYOND + self._number(axis))
        for axis in map(int, np.flatnonzero(joints < low - LIMIT_ROUNDING)):
            raise Refusal(BELOW + self._number(axis))
        filtered = self.filtered + self._part * (joints - self.filtered)
        most = self.robot.speeds * self.cycle * (1.0 + LIMIT_ROUNDING) + LIMIT_ROUNDING
        for axis in map(int, np.flatnonzero(np.abs(filtered - self.filtered) > most)):
            raise Refusal(SPEED + self._number(axis))
        self.commanded, self.filtered = joints, filtered

    def follow(self) -> None:
        """One cycle of the servos."""
        self.fed_back = self.fed_back + self._servo * (self.filtered - self.fed_back)

    def rest(self) -> None:
        """One cycle without a command: the position is held."""
        self.filtered = self.filtered + self._part * (self.commanded - self.filtered)
        self.follow()

    def _number(self, axis: int) -> int:
        return int(self.places[axis]) + 1

    def radians(self, joints: Floats) -> Floats:
        return np.where(self._turning, np.radians(joints), joints)

    def degrees(self, values: Floats) -> Floats:
        return np.where(self._turning, np.degrees(values), values)

    def pose(self, joints: Floats) -> Floats:
        """(6,) x, y, z in mm and a, b, c in radians of the flange."""
        place, turn = self.robot.fk(joints[None])
        return np.concatenate([place[0], np.radians(to_euler(turn[0], "ZYX")[::-1])])

    def joints_at(self, pose: Floats) -> Floats:
        """The joints (a,) at a pose (6,), nearest to where it is; raises Refusal if there are none.

        The flags are not looked at: a step within a cycle leads to no other branch of the arm.
        """
        turn = from_euler(np.degrees(pose[3:6])[None, ::-1], "ZYX")
        found, valid = self.robot.ik(pose[None, :3], turn)
        if not valid.any():
            raise Refusal(NO_SOLUTION)
        solutions = found[0][valid[0]]
        turns = np.round((self.commanded - solutions) / 360.0) * 360.0
        near = np.where(self._turning, solutions + turns, solutions)
        away = np.abs(near - self.commanded).max(axis=1)
        return np.asarray(near[int(np.argmin(away))])
