"""Plan the motion through a straight piece of program: its speed profile along the course.

`Drive` states how fast the arm may turn, move and accelerate. Where the path q(s) is followed at
the speed v, the arm moves at q' v and accelerates by q' dv/dt + q'' v². In the rooms of knots q''
is constant and q' changes linearly from one step to the next; elsewhere q' is constant.

With w = v² an acceleration A over a section d allows w to grow by 2 A d: the largest w is a running
minimum, forwards and then backwards, which is exact in columns. In a bend the remaining
acceleration depends on w itself; it is computed for the highest w there, which is then lowered
towards the one that is reached, so that each pass is within bounds and faster than the last.
"""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from assistant.base.arrays import Floats, Rows, Truths, norms
from assistant.base.data_classes import dataclass
from assistant.program.motion import Kind
from assistant.robots.robot import Robot
from assistant.robots.timing.course import Course, Moves, course_of, knots_of, sums_by_move

TIME_TO_SPEED: Final = 0.1
"""seconds that an axis takes to its full speed where no source tells its acceleration.

No maker publishes it for the arms of the catalogue; of some, a published picking cycle tells
what it comes to with a light load (`python -m benchmarks.picking`). For the arms whose maker's
planner states accelerations they come to about half of that; an arm that carries its load needs
more.
"""


@dataclass(frozen=True, slots=True, eq=False)
class Drive:
    """speeds, accelerations: (a,) of the axes, a second and a second squared.

    tcp_speed: mm/s at most on lines and arcs. tcp_acceleration: mm/s² at most on them.
    Infinite where only the axes bound them.
    """

    speeds: Floats
    accelerations: Floats
    tcp_speed: float
    tcp_acceleration: float


def drive_of(
    robot: Robot, tcp_acceleration: float | None = None, load: float | None = None
) -> Drive:
    """Return the drive of a robot in the catalogue, with `TIME_TO_SPEED` for missing values.

    load: kg that it carries, None if not known. The robot's time to speed holds up to the load that
    it was fitted with; with more, an arm is never quicker than with less.
    """
    given, time = robot.accelerations, TIME_TO_SPEED
    if robot.time_to_speed is not None:
        light = load is not None and load <= robot.light
        time = robot.time_to_speed if light else max(robot.time_to_speed, TIME_TO_SPEED)
    return Drive(
        robot.speeds,
        robot.speeds / time if given is None else given,
        np.inf if robot.tcp_speed is None else robot.tcp_speed,
        np.inf if tcp_acceleration is None else tcp_acceleration,
    )


_UNBOUNDED_ACCELERATION: Final = 1e6
"""Acceleration (mm/s²) that stands for none that binds; keeps sums exact enough."""
_LEAST_MOTION: Final = 1e-6
"""mm/s and mm/s² of any motion."""
_LITTLE_CUT: Final = 1e-7
"""mm by which a corner shortens a way at least to count."""

_FIRST_PATH_ROW, _AXIS_ROW = 1, 4
"""Rows of `_Bounds.limits`: what it is bound by, from 1 on as in `Profile`; the last is an axis."""

_SpeedLimits = tuple[Floats, NDArray[np.uint8]]
"""(p,) the highest speeds and what makes them so, see `Profile`."""


class _Bounds:
    """Speed and acceleration bounds of s steps of a course.

    length, turn: (s,) mm and degrees of the tool for each mm of it. caps: (s,) the highest speeds
    with their reasons. straight: (s,) each, the most acceleration for the axes and for the tool
    where the path is straight; bends: (s + 1,) each, the part of it that the bend at a knot takes
    at a speed of 1. bend: the most of them.
    """

    def __init__(self, moves: Moves, course: Course, drive: Drive) -> None:
        self.moves, self.course, self.drive, self.row = moves, course, drive, course.row
        self.free = moves.kinds[self.row] == Kind.JOINT
        self.axes, self.tool = course.axes, course.tool
        self.length = course.knots.length[course.step] / course.distance
        self.turn = course.knots.turn[course.step] / course.distance
        self.tcp = np.where(course.loose, np.inf, drive.tcp_acceleration)
        self.up, self.down = moves.acceleration[self.row], moves.deceleration[self.row]
        self.caps = self._caps()
        self.straight, self.bends = [], []
        with np.errstate(divide="ignore", over="ignore"):
            self.straight.append((drive.accelerations[:, None] / np.abs(self.axes)).min(axis=0))
            turned = np.abs(np.diff(self.axes))
            turned /= drive.accelerations[:, None]
            self.bends.append(self._bend(turned.max(axis=0)))
            if np.isfinite(drive.tcp_acceleration):
                self.straight.append(self.tcp / self.length)
                bent = _column_norms(np.diff(self.tool)) / drive.tcp_acceleration
                bent[course.loose[:-1] | course.loose[1:]] = 0.0
                self.bends.append(self._bend(bent))
        self.bend = np.max(self.bends, axis=0)

    def accelerations(self, near: Floats | None = None) -> tuple[Floats, Floats]:
        """(s,) to more and to less speed, with what bends leave at speeds of squares near (s + 1,)
        at the knots; None for nothing that bends take.
        """
        most = np.full(len(self.row), _UNBOUNDED_ACCELERATION)
        for straight, bend in zip(self.straight, self.bends, strict=True):
            if near is None:
                most = np.minimum(most, straight)
            else:
                taken = bend * near
                left = 1.0 - np.maximum(taken[:-1], taken[1:])
                most = np.minimum(most, straight * left)
        return np.maximum(most * self.up, _LEAST_MOTION), np.maximum(
            most * self.down, _LEAST_MOTION
        )

    def limits(self, at: Any, axes: Floats, length: Floats, turn: Floats) -> Floats:
        """Return (5, p) the highest speeds, by the tool, its turn, the robot, percent and axes.

        at: steps (p,). axes: (a, p), length: (p,), turn: (p,) movement there for each mm.
        """
        moves, free, row = self.moves, self.free[at], self.row[at]
        override = moves.override[row]
        percent = np.where(free, moves.percent[row], np.nan)
        stated = np.isfinite(percent)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            tcp = np.where(stated, np.inf, moves.tcp[row] * override / length)
            turned = np.where(stated, np.inf, moves.rotation[row] * override / turn)
            most = np.where(free, np.inf, self.drive.tcp_speed / length)
            least = (self.drive.speeds[:, None] / axes).min(axis=0)
        share = np.where(stated, percent / 100.0 * override, np.inf)
        ways = np.stack([tcp, turned, most, least * share, least])
        ways[np.isnan(ways)] = np.inf
        return ways

    def least(self, ways: Floats, axes: Floats) -> _SpeedLimits:
        """The lowest of each column of `limits`."""
        why = ways.argmin(axis=0)
        caps = np.maximum(ways[why, np.arange(len(why))], _LEAST_MOTION)
        by_axis = np.flatnonzero(why == _AXIS_ROW)
        why += 1
        why[by_axis] += (axes[:, by_axis] / self.drive.speeds[:, None]).argmax(axis=0)
        return caps, why.astype(np.uint8)

    def saved(self) -> Floats:
        """(n,) mm that the ways of the moves are shorter for their corners."""
        course = self.course
        bends, rooms = np.diff(self.tool), course.room[1:-1]
        bent = np.einsum("ij,ij->j", bends, bends)
        sharp = course.corner[1:-1] & (np.diff(course.step) == 1) & (rooms * bent > _LITTLE_CUT)
        at = np.flatnonzero(sharp)  # steps before corners
        room, squared, rate, bend = rooms[at], bent[at], self.tool[:, at], bends[:, at]
        along = np.einsum("ij,ij->j", rate, bend)
        own = np.einsum("ij,ij->j", rate, rate)
        saved = np.zeros(len(self.moves))
        # In either half of a corner the rate goes from that of its step to the mean of both.
        for step, of_step, part in (
            (at, own, along),
            (at + 1, own + 2.0 * along + squared, -along - squared),
        ):
            begin, middle, end = (
                np.sqrt(np.maximum(of_step + 2.0 * t * part + t * t * squared, 0.0))
                for t in (0.0, 0.25, 0.5)
            )
            cut = room * (begin - (begin + 4.0 * middle + end) / 6.0)  # Simpson's rule
            saved += np.bincount(self.row[step], cut, len(saved))
        return saved

    def _caps(self) -> _SpeedLimits:
        axes = np.abs(self.axes)
        ways = self.limits(slice(None), axes, self.length, self.turn)
        line = self.free & ~self.course.inside
        if line.any():
            # Every axis turns at one pace: the slowest step holds for the whole move.
            starts = np.flatnonzero(np.concatenate([[True], np.diff(self.row) != 0]))
            lowest = np.minimum.reduceat(np.where(line, ways, np.inf), starts, axis=1)
            worst = np.repeat(lowest, np.diff(np.append(starts, len(self.row))), axis=1)
            ways = np.where(line, worst, ways)
        return self.least(ways, axes)

    def _bend(self, change: Floats) -> Floats:
        """(s + 1,) of changes (s - 1,) between the steps, each made in its room."""
        room, factor = self.course.room[1:-1], np.minimum(self.up, self.down)
        made = room > 0.0
        width = np.where(made, 2.0 * room * np.minimum(factor[:-1], factor[1:]), 1.0)
        bends = np.zeros(len(self.row) + 1)
        bends[1:-1] = np.where(made, change / width, 0.0)
        return bends


def _column_norms(vectors: Floats) -> Floats:
    """(c, n) → (n,)."""
    return np.asarray(np.sqrt(np.einsum("ij,ij->j", vectors, vectors)))


_LITTLE_BEND: Final = 0.02
"""Largest part of an acceleration that a bend may take without a separate section."""
_MOST_BEND: Final = 0.999
"""Part of an acceleration that a bend takes at most; the rest changes the speed."""
_SPEED_PASSES: Final = 3
"""Times that the speeds are computed where there are bends."""

EndSpeeds = tuple[float, float]
"""Speeds at the start and the end of a course."""
_AT_REST: Final[EndSpeeds] = (0.0, 0.0)


@dataclass(slots=True, eq=False)
class _Sections:
    """p sections of s steps.

    step, offset, distance: (p,) see `Profile`. caps, why: (p,) the highest speeds and what makes
    them so. most: (p + 1,) the highest w between them. rise, fall: (p,) accelerations.
    bends: those in bends.
    """

    step: Rows
    offset: Floats
    distance: Floats
    caps: Floats
    why: NDArray[np.uint8]
    most: Floats
    rise: Floats
    fall: Floats
    bends: _Bends | None = None

    def fastest(self) -> tuple[Floats, Floats]:
        """(p + 1,) the largest w between the sections, and (p,) its peaks in them."""
        ceiling, bends = self.caps**2, self.bends
        if bends is None:
            return _section_speeds(self.most, ceiling, self.rise, self.fall, self.distance)
        for _ in range(_SPEED_PASSES):
            at = bends.at
            ceiling[at] = bends.highest
            self.rise[at], self.fall[at] = bends.accelerations()
            w, peak = _section_speeds(self.most, ceiling, self.rise, self.fall, self.distance)
            bends.highest = (bends.highest + peak[at]) / 2.0
        return w, peak


def _sections_of(bounds: _Bounds, ends: EndSpeeds = _AT_REST) -> _Sections:
    """The sections of a course, with the speeds and accelerations that they allow."""
    room, d, bend = bounds.course.room, bounds.course.distance, bounds.bend
    caps, why = bounds.caps
    with np.errstate(divide="ignore", over="ignore"):
        knots = np.where(room > 0.0, _MOST_BEND / bend, 0.0)
    if len(d):
        knots[0], knots[-1] = ends[0] ** 2, ends[1] ** 2
    # Nothing is faster than this: as if bends took nothing of an acceleration.
    rise, fall = bounds.accelerations()
    w, peak = _section_speeds(knots, caps**2, rise, fall, d)
    near, quickest = _more(peak, peak), _more(rise, fall)
    near = np.minimum(near, w + 2.0 * room * quickest)
    split = bend * near > _LITTLE_BEND
    knots[split] = np.inf
    whole = ~split[1:-1] & (room[1:-1] > 0.0)
    accelerations = bounds.accelerations(np.where(split, 0.0, near))
    caps, rise, fall = (_beside(one, whole) for one in (caps, *accelerations))
    if not split.any():
        step = np.arange(len(d))
        return _Sections(step, np.zeros(len(d)), d, caps, why, knots, rise, fall)
    own = np.where(split, room, 0.0)
    middle = d - own[:-1] - own[1:]
    parts = np.stack([own[:-1], np.where(middle > 1e-9 * d, middle, 0.0), own[1:]], axis=1)
    step, which = np.nonzero(parts)
    begin = np.stack([np.zeros(len(d)), own[:-1], d - own[1:]], axis=1)
    first = np.diff(step, prepend=-1) > 0
    most = np.append(np.where(first, knots[step], np.inf), knots[-1])
    at = np.flatnonzero(which != 1)
    bends = _Bends(bounds, at, step[at], which[at] == 2, near)
    caps, why = caps[step], why[step]
    caps[at], why[at] = bends.limits
    bends.highest = np.minimum(bends.highest, caps[at] ** 2)
    offset, distance = begin[step, which], parts[step, which]
    return _Sections(step, offset, distance, caps, why, most, rise[step], fall[step], bends)


def _more(after: Floats, before: Floats) -> Floats:
    """(s + 1,) at each knot the larger of what is in the steps (s,) after and before it."""
    most = np.append(after, 0.0)
    np.maximum(most[1:], before, out=most[1:])
    return most


def _beside(most: Floats, whole: Truths) -> Floats:
    """(s,) the most of speed or acceleration also in the bends at both ends of each step.

    whole: (s - 1,) bends in which the rates of the axes and the tool are, in the middle, the mean
    of both steps, so that what they ask of their bounds is the mean at most.
    """
    asked = 1.0 / most
    mean = np.where(whole, (asked[1:] + asked[:-1]) / 2.0, 0.0)
    asked[1:] = np.maximum(asked[1:], mean)
    asked[:-1] = np.maximum(asked[:-1], mean)
    return np.asarray(1.0 / asked)


class _Bends:
    """b halves of bends.

    at: (b,) sections. highest: (b,) the highest w in them. limits: their highest speeds.
    """

    def __init__(self, bounds: _Bounds, at: Rows, step: Rows, ends: Truths, near: Floats) -> None:
        """step: (b,) that each is in; ends: (b,) whether at its end. near: (s + 1,) highest w."""
        self.bounds, self.at, self.step = bounds, at, step
        knot = step + ends
        room = bounds.course.room[knot]
        self.tcp = np.maximum(bounds.tcp[knot - 1], bounds.tcp[knot])
        self.rates = []  # of the axes and of the tool: in the middle, at the border, and the bend
        for rates in (bounds.axes, bounds.tool):
            before, behind = rates[:, knot - 1], rates[:, knot]
            bend = (behind - before) / (2.0 * room)
            self.rates.append(((before + behind) / 2.0, rates[:, step], bend))
        axes, tool = self.rates
        steepest = np.maximum(np.abs(axes[0]), np.abs(axes[1]))
        longest = bounds.length[step]
        longest = np.maximum(
            longest, longest * _column_norms(tool[0]) / np.maximum(_column_norms(tool[1]), 1e-300)
        )
        turn = np.maximum(bounds.turn[knot - 1], bounds.turn[knot])
        self.limits = bounds.least(bounds.limits(step, steepest, longest, turn), steepest)
        self.highest = np.minimum(near[knot], _MOST_BEND / bounds.bend[knot])

    def accelerations(self) -> tuple[Floats, Floats]:
        """Return (b,) the acceleration and the deceleration that hold for every w up to the
        highest.

        The demand on an axis is linear in its rate and in w, so that only the ends need to be
        checked.
        """
        bounds, w = self.bounds, self.highest
        up, down = bounds.up[self.step], bounds.down[self.step]
        most = bounds.drive.accelerations[:, None]
        middle, border, bend = self.rates[0]
        rise = fall = np.full(len(w), np.inf)
        with np.errstate(divide="ignore", over="ignore"):
            for rate in (middle, border):
                pushed = np.sign(rate) * bend * w
                size = np.abs(rate)
                more = (most * up - np.maximum(pushed, 0.0)) / size
                less = (most * down + np.minimum(pushed, 0.0)) / size
                rise, fall = np.minimum(rise, more.min(axis=0)), np.minimum(fall, less.min(axis=0))
        if np.isfinite(bounds.drive.tcp_acceleration):
            more, less = self._of_tool(up, down)
            rise, fall = np.minimum(rise, more), np.minimum(fall, less)
        return np.clip(rise, _LEAST_MOTION, _UNBOUNDED_ACCELERATION), np.clip(
            fall, _LEAST_MOTION, _UNBOUNDED_ACCELERATION
        )

    def _of_tool(self, up: Floats, down: Floats) -> tuple[Floats, Floats]:
        """(b,) each, that keep the acceleration of the tool, a vector, below its most."""
        w, most = self.highest, self.tcp
        middle, border, bend = self.rates[1]
        rise = fall = np.full(len(w), np.inf)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            for rate in (middle, border):
                size = _column_norms(rate)
                along = np.einsum("ij,ij->j", rate, bend) * w / size
                across = (_column_norms(bend) * w) ** 2 - along**2
                for sign, factor in ((1.0, up), (-1.0, down)):
                    left = np.sqrt(np.maximum((most * factor) ** 2 - across, 0.0))
                    least = np.minimum(left - sign * along, most * factor) / size
                    least[~np.isfinite(least)] = np.inf
                    if sign > 0.0:
                        rise = np.minimum(rise, least)
                    else:
                        fall = np.minimum(fall, least)
        return rise, fall


def _section_speeds(
    most: Floats, ceiling: Floats, rise: Floats, fall: Floats, d: Floats
) -> tuple[Floats, Floats]:
    """(p + 1,) the largest w between sections and (p,) its peaks, below most and ceiling."""
    lid = most.copy()
    np.minimum(lid[:-1], ceiling, out=lid[:-1])
    np.minimum(lid[1:], ceiling, out=lid[1:])
    w = _largest(lid, 2.0 * rise * d, 2.0 * fall * d)
    top = (fall * w[:-1] + rise * w[1:] + 2.0 * rise * fall * d) / (rise + fall)
    return w, np.maximum(np.minimum(top, ceiling), np.maximum(w[:-1], w[1:]))


def _largest(most: Floats, rises: Floats, falls: Floats) -> Floats:
    """(p + 1,) the largest w below `most` that grows by `rises` and shrinks by `falls` a step."""
    w = most
    for steps in (rises, falls[::-1]):
        grown = np.zeros(len(most))
        np.cumsum(steps, out=grown[1:])
        w = np.minimum(np.minimum.accumulate(w - grown) + grown, w)[::-1]
    return np.asarray(np.maximum(w, 0.0))


_ACCELERATION, SPEED, _ROTATION, _ROBOT_SPEED, PERCENT, FIRST_AXIS = range(6)
"""Limits that bind a move; from FIRST_AXIS on the axes."""
BINDING_WORDS: Final = ("acceleration", "speed", "reorientation", "speed of the robot", "percent")


@dataclass(frozen=True, slots=True, eq=False)
class Profile:
    """The motion along a course, in p sections of its steps.

    step: (p,) of the course. offset: (p,) where in it a section begins. distance: (p,) its length.
    speed: (p + 1,) between the sections, peak: (p,) in them. rise, fall: (p,) accelerations.
    times: (p + 1,) seconds from the start. binds: (n,) and seconds: (n,) of the moves.
    lengths: (n,) mm, turns: (n,) deg of the moves.
    """

    step: Rows
    offset: Floats
    distance: Floats
    speed: Floats
    peak: Floats
    rise: Floats
    fall: Floats
    times: Floats
    seconds: Floats
    lengths: Floats
    turns: Floats
    binds: NDArray[np.uint8]


def _profile_of(moves: Moves, course: Course, drive: Drive, ends: EndSpeeds = _AT_REST) -> Profile:
    """The fastest motion along a course, with the speeds at its ends at most."""
    bounds = _Bounds(moves, course, drive)
    sections = _sections_of(bounds, ends)
    v, peak = (np.sqrt(w) for w in sections.fastest())
    rise, fall, d = sections.rise, sections.fall, sections.distance
    up, down = (peak - v[:-1]) / rise, (peak - v[1:]) / fall
    cruise = d - (peak + v[:-1]) * up / 2.0 - (peak + v[1:]) * down / 2.0
    even = np.maximum(cruise, 0.0) / np.maximum(peak, 1e-300)
    seconds = up + down + even
    n, knots, row = len(moves), course.knots, course.row[sections.step]
    bound = np.where(peak >= 0.999 * sections.caps, even, 0.0)
    return Profile(
        sections.step,
        sections.offset,
        d,
        v,
        peak,
        rise,
        fall,
        np.concatenate([[0.0], np.cumsum(seconds)]),
        sums_by_move(row, seconds, n),
        sums_by_move(knots.row, knots.length, n) - bounds.saved(),
        sums_by_move(knots.row, knots.turn, n),
        _binding(row, bound, seconds, sections.why, n, len(drive.speeds)),
    )


def _binding(
    row: Rows, even: Floats, seconds: Floats, why: NDArray[np.uint8], n: int, axes: int
) -> NDArray[np.uint8]:
    """(n,) what the most time of each move is spent at."""
    width = FIRST_AXIS + axes
    spent = np.bincount(why.astype(np.intp) * n + row, even, n * width)
    spent[:n] += np.bincount(row, seconds - even, n)
    return np.asarray(spent.reshape(width, n).argmax(axis=0).astype(np.uint8))


@dataclass(frozen=True, slots=True, eq=False)
class Plan:
    """Moves with the course through them and the speed along it."""

    course: Course
    profile: Profile

    @property
    def seconds(self) -> float:
        return float(self.profile.times[-1])

    def passing(self, places: Floats) -> Floats:
        """Return the times at which positions (m,) along the course are passed, seconds from the
        start of the plan.
        """
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
        """Return how far along the course the arm is, and its speed along it."""
        profile = self.profile
        if not len(profile.step):
            return 0.0, 0.0
        index = np.searchsorted(profile.times, [seconds], side="right") - 1
        index = np.clip(index, 0, len(profile.step) - 1)
        gone = np.clip([seconds] - profile.times[index], 0.0, None)
        done, speed = _within(profile, index, gone)
        return float(profile.distance[: index[0]].sum() + done[0]), float(speed[0])

    def at(self, times: Floats) -> Moment:
        """Return the poses, joints and speeds at times (m,), seconds from the start of the plan."""
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
    moves: Moves, start: Floats, robot: Robot, drive: Drive, ends: EndSpeeds = _AT_REST
) -> Plan:
    """The motion from joints (a,) through at least one move.

    ends: mm/s along the course (degrees/s on the spot) at its start and its end, at most; infinite
    for as fast as the rest allows.
    """
    course = course_of(moves, knots_of(moves, start, robot), robot)
    return Plan(course, _profile_of(moves, course, drive, ends))


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
    """Return how far (m,) in sections the arm is after so many seconds in them, and its speed
    then.
    """
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
