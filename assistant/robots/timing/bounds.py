"""What bounds the motion along a course: speeds of the tool and the axes, and accelerations.

Where the way q(s) is gone along at the speed v, the arm moves at q' v and accelerates by
q' dv/dt + q'' v². In the rooms of knots q'' is constant and q' goes from that of the one step to
that of the other; elsewhere q' is constant.
"""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from assistant.base.arrays import Floats
from assistant.program.motion import Kind
from assistant.robots.timing.course import Course
from assistant.robots.timing.drive import Drive
from assistant.robots.timing.rows import Moves

UNBOUNDED_ACCELERATION: Final = 1e6
"""Acceleration (mm/s²) that stands for none that binds; keeps sums exact enough."""
LEAST_MOTION: Final = 1e-6
"""mm/s and mm/s² of any motion."""
LITTLE_CUT: Final = 1e-7
"""mm by which a corner shortens a way at least to count."""

FIRST_PATH_ROW, AXIS_ROW = 1, 4
"""Rows of `Bounds.limits`: what it is bound by, from 1 on as in `profile`; the last is an axis."""

SpeedLimits = tuple[Floats, NDArray[np.uint8]]
"""(p,) the highest speeds and what makes them so, see `profile`."""


class Bounds:
    """Of s steps of a course.

    length, turn: (s,) mm and degrees of the tool for each mm of it. caps: (s,) the highest speeds
    with their reasons. straight: (s,) each, the most acceleration for the axes and for the tool
    where the way is straight; bends: (s + 1,) each, the part of it that the bend at a knot takes
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
                bent = column_norms(np.diff(self.tool)) / drive.tcp_acceleration
                bent[course.loose[:-1] | course.loose[1:]] = 0.0
                self.bends.append(self._bend(bent))
        self.bend = np.max(self.bends, axis=0)

    def accelerations(self, near: Floats | None = None) -> tuple[Floats, Floats]:
        """(s,) to more and to less speed, with what bends leave at speeds of squares near (s + 1,)
        at the knots; None for nothing that bends take.
        """
        most = np.full(len(self.row), UNBOUNDED_ACCELERATION)
        for straight, bend in zip(self.straight, self.bends, strict=True):
            if near is None:
                most = np.minimum(most, straight)
            else:
                taken = bend * near
                left = 1.0 - np.maximum(taken[:-1], taken[1:])
                most = np.minimum(most, straight * left)
        return np.maximum(most * self.up, LEAST_MOTION), np.maximum(most * self.down, LEAST_MOTION)

    def limits(self, at: Any, axes: Floats, length: Floats, turn: Floats) -> Floats:
        """(5, p) the highest speeds, by the tool, its turn, the robot, percent and axes.

        at: steps (p,). axes: (a, p), length: (p,), turn: (p,) what moves there for each mm.
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

    def least(self, ways: Floats, axes: Floats) -> SpeedLimits:
        """The lowest of each column of `limits`."""
        why = ways.argmin(axis=0)
        caps = np.maximum(ways[why, np.arange(len(why))], LEAST_MOTION)
        by_axis = np.flatnonzero(why == AXIS_ROW)
        why += 1
        why[by_axis] += (axes[:, by_axis] / self.drive.speeds[:, None]).argmax(axis=0)
        return caps, why.astype(np.uint8)

    def saved(self) -> Floats:
        """(n,) mm that the ways of the moves are shorter for their corners."""
        course = self.course
        bends, rooms = np.diff(self.tool), course.room[1:-1]
        bent = np.einsum("ij,ij->j", bends, bends)
        sharp = course.corner[1:-1] & (np.diff(course.step) == 1) & (rooms * bent > LITTLE_CUT)
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

    def _caps(self) -> SpeedLimits:
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


def column_norms(vectors: Floats) -> Floats:
    """(c, n) → (n,)."""
    return np.asarray(np.sqrt(np.einsum("ij,ij->j", vectors, vectors)))
