"""A plan: the motion through a straight piece of program, from rest to rest unless stated."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from assistant.base.arrays import Floats, Rows, norms
from assistant.robots.robot import Robot
from assistant.robots.timing.course import Course, course_of
from assistant.robots.timing.drive import Drive
from assistant.robots.timing.knots import knots_of
from assistant.robots.timing.profile import Profile, profile_of
from assistant.robots.timing.rows import Moves
from assistant.robots.timing.sections import AT_REST, EndSpeeds


@dataclass(frozen=True, slots=True, eq=False)
class Plan:
    """Moves with the course through them and the speed along it."""

    course: Course
    profile: Profile

    @property
    def seconds(self) -> float:
        return float(self.profile.times[-1])

    def passing(self, places: Floats) -> Floats:
        """When places (m,) along the course are come to, seconds from the start of the plan."""
        profile = self.profile
        if not len(profile.step):
            return np.zeros(len(places))
        ends = np.cumsum(profile.distance)
        index = np.clip(np.searchsorted(ends, places), 0, len(ends) - 1)
        d = np.clip(places - (ends - profile.distance)[index], 0.0, profile.distance[index])
        v0, v1 = profile.speed[index], profile.speed[index + 1]
        peak, rise, fall = profile.peak[index], profile.rise[index], profile.fall[index]
        left = profile.distance[index] - d
        climb, drop = (peak**2 - v0**2) / (2.0 * rise), (peak**2 - v1**2) / (2.0 * fall)
        up = (np.sqrt(v0**2 + 2.0 * rise * np.minimum(d, climb)) - v0) / rise
        down = (np.sqrt(v1**2 + 2.0 * fall * np.minimum(left, drop)) - v1) / fall
        even = np.maximum(d - climb, 0.0) / np.maximum(peak, 1e-300)
        behind = profile.times[index + 1] - down
        return np.asarray(np.where(left < drop, behind, profile.times[index] + up + even))

    def place(self, seconds: float) -> tuple[float, float]:
        """How far along the course the arm is, and how fast it goes along it."""
        profile = self.profile
        if not len(profile.step):
            return 0.0, 0.0
        index = np.searchsorted(profile.times, [seconds], side="right") - 1
        index = np.clip(index, 0, len(profile.step) - 1)
        gone = np.clip([seconds] - profile.times[index], 0.0, None)
        done, speed = _within(profile, index, gone)
        return float(profile.distance[: index[0]].sum() + done[0]), float(speed[0])

    def at(self, times: Floats) -> Moment:
        """Where everything is at times (m,), seconds from the start of the plan."""
        profile, knots = self.profile, self.course.knots
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
        done, speed = _within(profile, index, gone)
        place = CoursePlaces(self.course, profile.step[index], profile.offset[index] + done)
        joints, rate = place.of(knots.joints)
        positions, way = place.of(knots.positions, joined=False)
        q, _ = place.of(knots.quaternions, joined=False)
        return Moment(
            positions,
            q / norms(q)[:, None],
            joints,
            speed * norms(way) * place.stretched(),
            speed[:, None] * rate,
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


def plan_of(
    moves: Moves, start: Floats, robot: Robot, drive: Drive, ends: EndSpeeds = AT_REST
) -> Plan:
    """The motion from joints (a,) through at least one move.

    ends: mm/s along the course (degrees/s on the spot) at its start and its end, at most; infinite
    for as fast as the rest allows.
    """
    course = course_of(moves, knots_of(moves, start, robot), robot)
    return Plan(course, profile_of(moves, course, drive, ends))


class CoursePlaces:
    """Places on a course. step: (m,) of it. gone: (m,) how far in it."""

    def __init__(self, course: Course, step: Rows, gone: Floats) -> None:
        self.course, self.step, self.gone = course, step, gone
        left = np.maximum(course.distance[step] - gone, 0.0)  # rounding leads no step further
        behind = gone < course.room[step]  # in the bend where the step begins
        before = ~behind & (left < course.room[step + 1])
        self.other = np.where(behind, step - 1, np.where(before, step + 1, step))
        self.room = np.where(behind, course.room[step], course.room[step + 1])
        inner = self.room - np.where(behind, gone, left)
        bent = behind | before
        self.share = np.where(bent, inner / np.where(bent, 2.0 * self.room, 1.0), 0.0)[:, None]
        self.side = np.where(behind, -1.0, 1.0)[:, None]

    def of(self, values: Floats, *, joined: bool = True) -> tuple[Floats, Floats]:
        """Values (m, ...) between those of the knots, and their change for each mm of the course.

        joined: whether they go on from step to step where the tool changes.
        """
        course, step = self.course, self.course.step[self.step]
        own = _rates(course, values, self.step)
        toward = _rates(course, values, self.other) - own
        if not joined:
            toward[np.abs(course.step[self.other] - step) > 1] = 0.0
        at = values[step] + own * self.gone[:, None]
        bent = self.side * toward * self.share**2 * self.room[:, None]
        return at + bent, own + self.share * toward

    def stretched(self) -> Floats:
        """(m,) length of the way by that of the line between the knots."""
        knots, step = self.course.knots, self.course.step[self.step]
        line = norms(knots.positions[step + 1] - knots.positions[step])
        return np.where(line > 0.0, knots.length[step] / np.where(line > 0.0, line, 1.0), 1.0)


def _rates(course: Course, values: Floats, at: Rows) -> Floats:
    step = course.step[at]
    return np.asarray((values[step + 1] - values[step]) / course.distance[at][:, None])


def _within(profile: Profile, index: Rows, gone: Floats) -> tuple[Floats, Floats]:
    """How far (m,) in sections the arm is after so many seconds in them, and the speed then."""
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
    return np.clip(done, 0.0, distance), speed
