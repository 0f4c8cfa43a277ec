"""Stretches of moves that the arm goes through without a stop of the program, as ways of joints."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import accumulate
from typing import Final

import numpy as np

from assistant.base.arrays import Floats, Rows, Truths
from assistant.robots.timing.exact import CourseJoints
from assistant.robots.timing.pieces import Segment
from assistant.robots.timing.plan import CoursePlaces, Plan

BEND_PARTS: Final = 4
"""Parts that each half of a bend is looked at in."""
LINE_SAFETY: Final = 1.5
"""By how much more than its second difference tells a joint may be off the line between knots."""


@dataclass(frozen=True, slots=True, eq=False)
class MovesWithoutStop:
    """Moves that were timed together. skipped: of them that were not, as nobody knows where they
    start. start: seconds from the start of the procedure, at most.
    """

    pieces: tuple[Segment, ...]
    skipped: int
    start: float
    plan: Plan
    _ends: Sequence[int] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        ends = list(accumulate(len(piece.moves) for piece in self.pieces))
        object.__setattr__(self, "_ends", ends)

    def piece_of(self, row: int) -> tuple[Segment, int]:
        """The statement that a move of the plan belongs to, and which of its rows it is."""
        at = row + self.skipped
        number = bisect_right(self._ends, at)
        if number >= len(self.pieces):
            raise IndexError(row)
        piece = self.pieces[number]
        return piece, at - (self._ends[number] - len(piece.moves))


@dataclass(frozen=True, slots=True, eq=False)
class Stretches:
    """A plan as straight stretches of the joints.

    joints: (n, a). slack: (n - 1, a) how far a joint may be from the line of its stretch. times:
    (n,) seconds from the start of the plan. row: (n - 1,) the move that a stretch belongs to.
    places: (n,) mm along the course. exact: the joints in between; None without a way.
    """

    joints: Floats
    slack: Floats
    times: Floats
    row: Rows
    places: Floats
    exact: CourseJoints | None = None

    def part(self, first: int, last: int) -> Stretches:
        """The stretches from one number up to another one."""
        return Stretches(
            self.joints[first : last + 1],
            self.slack[first:last],
            self.times[first : last + 1],
            self.row[first:last],
            self.places[first : last + 1],
            self.exact,
        )

    def between(self, stretch: Rows, part: Floats) -> tuple[Floats, Truths]:
        """Joints (k, a) at parts (k,) of stretches (k,), and (k,) whether they are exact."""
        first, last = self.joints[stretch], self.joints[stretch + 1]
        near = first + part[:, None] * (last - first)
        if self.exact is None:
            return near, np.zeros(len(near), dtype=bool)
        place = self.places[stretch]
        return self.exact.joints(place + part * (self.places[stretch + 1] - place), near)


def stretches_of(plan: Plan) -> Stretches:
    """The way of a plan, corners and all, cut so finely that its slack is small."""
    course = plan.course
    count, knots = len(course.distance), course.knots.joints
    if not count:
        nothing = np.zeros((0, knots.shape[1]))
        none = np.zeros(0, dtype=np.intp)
        return Stretches(knots[:1], nothing, np.zeros(1), none, np.zeros(1))
    step, gone = _cuts(course.distance, course.room)
    d = course.distance[step]
    joints, _ = CoursePlaces(course, step, gone).of(knots)
    ends = np.append(gone[1:], 0.0)
    ends = np.where(np.append(step[1:] != step[:-1], True), d, ends)
    middle, _ = CoursePlaces(course, step, (gone + ends) / 2.0).of(knots)
    last, _ = CoursePlaces(course, step[-1:], d[-1:]).of(knots)
    joints = np.concatenate([joints, last])
    bend = np.abs(middle - (joints[1:] + joints[:-1]) / 2.0)
    between = _between_knots(plan)[course.step[step]]
    slack = bend + np.where(course.straight[step, None], 0.0, between)
    begins = np.concatenate([[0.0], np.cumsum(course.distance)[:-1]])
    places = np.append(begins[step] + gone, course.distance.sum())
    # Without a closed form joints are too slow to solve wherever a search asks for them.
    exact = CourseJoints(course) if course.robot.arm.named else None
    return Stretches(joints, slack, plan.passing(places), course.row[step], places, exact)


def _cuts(distance: Floats, room: Floats) -> tuple[Rows, Floats]:
    """Steps (s,) with their rooms (s + 1,) → step (n,) and place in it (n,) of each cut."""
    part = np.arange(BEND_PARTS) / BEND_PARTS
    behind, before = room[:-1, None] * part, distance[:, None] - room[1:, None] * (1.0 - part)
    between = room[:-1, None]
    places = np.concatenate([behind, between, before], axis=1)
    step = np.repeat(np.arange(len(distance)), places.shape[1])
    gone = np.clip(places, 0.0, distance[:, None]).reshape(-1)
    new = np.append(True, (np.diff(gone) > 1e-9) | (np.diff(step) > 0))
    inside = new & (gone < distance[step] - 1e-9)
    return step[inside], gone[inside]


def _between_knots(plan: Plan) -> Floats:
    """(k, a) how far a joint is from the line between two knots of a line or an arc.

    An eighth of the second difference, which is what a parabola through the knots is off. It means
    nothing in a joint move, whose knots lie on that line, but at unequal distances near a corner.
    """
    knots = plan.course.knots
    step = np.diff(knots.joints, axis=0)
    off = np.zeros_like(step)
    same = np.diff(knots.row) == 0
    second = np.abs(np.diff(step, axis=0)) * same[:, None] * LINE_SAFETY / 8.0
    off[1:] = second
    off[:-1] = np.maximum(off[:-1], second)
    return off
