"""The speed along a course: as fast as allowed at every place, with accelerations in bounds."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from assistant.base.arrays import Floats, Rows
from assistant.robots.timing.bounds import Bounds
from assistant.robots.timing.course import Course, sums_by_move
from assistant.robots.timing.drive import Drive
from assistant.robots.timing.rows import Moves
from assistant.robots.timing.sections import AT_REST, EndSpeeds, sections_of

ACCELERATION, SPEED, ROTATION, ROBOT_SPEED, PERCENT, FIRST_AXIS = range(6)
"""What binds a move; from FIRST_AXIS on the axes."""
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


def profile_of(moves: Moves, course: Course, drive: Drive, ends: EndSpeeds = AT_REST) -> Profile:
    """The fastest motion along a course, with the speeds at its ends at most."""
    bounds = Bounds(moves, course, drive)
    sections = sections_of(bounds, ends)
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
