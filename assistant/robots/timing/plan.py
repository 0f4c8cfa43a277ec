"""A plan: the motion through a straight piece of program, from rest to rest."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from assistant.robots.robot import Robot
from assistant.robots.run import Floats
from assistant.robots.timing.drive import Drive
from assistant.robots.timing.knots import Knots, knots_of
from assistant.robots.timing.profile import Profile, profile_of
from assistant.robots.timing.rows import Moves, Rows


@dataclass(frozen=True, slots=True, eq=False)
class Plan:
    """Moves with the knots of their way and the speed along it."""

    knots: Knots
    profile: Profile

    @property
    def seconds(self) -> float:
        return float(self.profile.times[-1])

    def at(self, times: Floats) -> Moment:
        """Where everything is at times (m,), seconds from the start of the plan."""
        profile, knots = self.profile, self.knots
        if not len(profile.step):
            still = np.zeros(len(times))
            rest = np.zeros((len(times), knots.joints.shape[1]))
            last = np.full(len(times), len(knots.joints) - 1)
            return Moment(
                knots.positions[last], knots.quaternions[last], knots.joints[last], still, rest
            )
        index = np.searchsorted(profile.times, times, side="right") - 1
        index = np.clip(index, 0, len(profile.step) - 1)
        gone = np.clip(times - profile.times[index], 0.0, None)
        part, speed = _within(profile, index, gone)
        step = profile.step[index]
        first, last = knots.quaternions[step], knots.quaternions[step + 1]
        last = np.where(np.einsum("ij,ij->i", first, last)[:, None] < 0.0, -last, last)
        q = first + part[:, None] * (last - first)
        swept = knots.joints[step + 1] - knots.joints[step]
        pace = speed / profile.distance[index]
        before = knots.positions[step]
        return Moment(
            before + part[:, None] * (knots.positions[step + 1] - before),
            q / np.linalg.norm(q, axis=1, keepdims=True),
            knots.joints[step] + part[:, None] * swept,
            pace * knots.length[step],
            pace[:, None] * swept,
        )


@dataclass(frozen=True, slots=True, eq=False)
class Moment:
    """positions (m, 3), quaternions (m, 4), joints (m, a), speeds (m,) mm/s of the tool,
    velocities (m, a) of the joints.
    """

    positions: Floats
    quaternions: Floats
    joints: Floats
    speeds: Floats
    velocities: Floats


def plan_of(moves: Moves, start: Floats, robot: Robot, drive: Drive) -> Plan:
    """The motion from joints (a,) through at least one move."""
    knots = knots_of(moves, start, robot)
    return Plan(knots, profile_of(moves, knots, drive))


def _within(profile: Profile, index: Rows, gone: Floats) -> tuple[Floats, Floats]:
    """Parts (m,) of steps that are done after so many seconds in them, and the speed then."""
    v0, v1 = profile.speed[index], profile.speed[index + 1]
    peak, rise, fall = profile.peak[index], profile.rise[index], profile.fall[index]
    distance = profile.distance[index]
    whole = profile.times[index + 1] - profile.times[index]
    up, down = (peak - v0) / rise, (peak - v1) / fall
    left = np.clip(whole - gone, 0.0, None)
    climbing, falling = gone < up, left < down
    speed = np.where(climbing, v0 + rise * gone, np.where(falling, v1 + fall * left, peak))
    start = (v0 + speed) / 2.0 * gone
    end = distance - (v1 + speed) / 2.0 * left
    middle = (v0 + peak) / 2.0 * up + peak * (gone - up)
    done = np.where(climbing, start, np.where(falling, end, middle))
    return np.clip(done / distance, 0.0, 1.0), speed
