"""What the arm does between the ends of linear and circular moves.

A short step of the joints is as good as straight. Where a move turns an axis further than that,
the joints at places on its way are computed, the more the further.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np

from assistant.base.arrays import Floats, Rows, Truths, max_abs, norms
from assistant.checks.moves import Moves
from assistant.robots import Robot
from assistant.robots.arms.arm import CLOSING
from assistant.robots.motion.along import joints_along
from assistant.robots.motion.densities import Peaks
from assistant.robots.motion.wrist import THROUGH
from assistant.robots.robot import CHUNK, IN_LINE

BENT: Final = float(np.sin(np.radians(IN_LINE)))
"""Sine of axis 5 below which axes 4 and 6 mean nothing by themselves."""


@dataclass(frozen=True, slots=True)
class Extremes:
    """Of m moves, each (m,); infinite where an arm has no such thing.

    wrist: least angle of axis 5 on the way, degrees. elbow: least angle between the upper arm
    and the line from axis 3 to the wrist centre, degrees. shoulder: least distance of the wrist
    centre from axis 1, mm. crossed: whether the move goes straight through the singularity of
    the wrist. by_ends: whether its ends alone show that, which is what finding RB115 tells.
    seconds: the least that the joint speeds allow. axis: which joint that is.
    """

    wrist: Floats
    elbow: Floats
    shoulder: Floats
    crossed: Truths
    by_ends: Truths
    seconds: Floats
    axis: Rows


def extremes_of(moves: Moves) -> Extremes:
    m = len(moves)
    far = np.full(m, np.inf)
    never = np.zeros(m, dtype=bool)
    nothing = np.zeros(m, dtype=np.intp)
    extremes = Extremes(far, far.copy(), far.copy(), never, never.copy(), np.zeros(m), nothing)
    uneven = [np.empty(0, np.intp)]
    for at, joints in _pieces(moves, extremes):
        uneven.append(at[_update_extremes(moves.robot, extremes, at, joints)])
    again = np.concatenate(uneven)
    parts = min(Peaks.MOST_PARTS, _most_places(moves.robot) // max(len(again), 1))
    if parts > Peaks.PARTS[-1][1]:
        _clear_ends(extremes, again)
        extremes.crossed[again] = extremes.by_ends[again]
        for at, joints in _sampled(moves, again, parts):
            _update_extremes(moves.robot, extremes, at, joints)
            if moves.robot.arm.named:
                _peak(moves, extremes, at, joints)
    return extremes


def _peak(moves: Moves, extremes: Extremes, at: Rows, joints: Floats) -> None:
    """Looks closer where some moves (k,) need the most time, as their joints (k, p, a) show.

    Between the places beside the fastest step, then again beside the fastest one there.
    """
    robot = moves.robot
    branches = robot.branch_of(robot.configuration(joints[:, -1]))
    begin, width = np.zeros(len(at)), np.ones(len(at))
    for _ in range(Peaks.CLOSER):
        if not len(at):
            return
        steps = joints.shape[1] - 1
        place = _steps(robot, joints).max(axis=2).argmax(axis=1)
        first, last = np.maximum(place - 1, 0), np.minimum(place + 2, steps)
        begin, width = begin + width * first / steps, width * (last - first) / steps
        part = begin[:, None] + width[:, None] * np.linspace(0.0, 1.0, Peaks.CLOSER_PARTS + 1)
        p, q = moves.poses_at(at, part)
        joints, excess = joints_along(robot, joints[:, 0], branches, (p, q))
        reached = (excess < CLOSING / 2.0).all(axis=1)
        needed = _steps(robot, joints).max(axis=1) * Peaks.CLOSER_PARTS / width[:, None]
        axis = needed.argmax(axis=1)
        seconds = np.where(reached, needed[np.arange(len(at)), axis], 0.0)
        before = extremes.seconds[at]
        more = seconds > before
        extremes.axis[at[more]], extremes.seconds[at[more]] = axis[more], seconds[more]
        on = seconds > Peaks.FASTER * before
        at, branches, joints = at[on], branches[on], joints[on]
        begin, width = begin[on], width[on]


def _steps(robot: Robot, joints: Floats) -> Floats:
    """(k, p - 1, a) seconds at full speed between places on ways, joints (k, p, a).

    Beside a straight wrist axes 4 and 6 mean nothing by themselves.
    """
    step = np.abs(robot.wound(np.diff(joints, axis=1)))
    if robot.arm.spherical:
        small = np.abs(np.sin(np.radians(joints[..., 4] + robot.zero[4]))) < BENT
        either = (small[:, :-1] | small[:, 1:])[..., None]
        step[..., [3, 5]] = np.where(either, 0.0, step[..., [3, 5]])
    return np.asarray(step / robot.speeds)


def _pieces(moves: Moves, extremes: Extremes) -> Iterator[tuple[Rows, Floats]]:
    """Moves (k,) with their joints (k, parts + 1, a) deg from the start to the end."""
    wide = np.zeros(len(moves))
    for start in range(0, len(moves), CHUNK):
        at = np.arange(start, min(start + CHUNK, len(moves)))
        ends = np.stack([moves.joints[moves.starts[at] + 1], moves.joints[moves.rows[at] + 1]], 1)
        step = max_abs(np.diff(ends, axis=1)[:, 0])
        bent = moves.vias[at] >= 0
        if bent.any():
            via = moves.joints[moves.vias[at] + 1]
            off = np.abs(via[:, None] - ends).max(axis=(1, 2))
            step = np.where(bent & np.isfinite(off), np.maximum(step, off), step)
        wide[at] = step
        yield at, ends
    _crossed_at_targets(moves, extremes)
    extremes.by_ends[:] = extremes.crossed
    wanted = np.flatnonzero((wide > Peaks.STRAIGHT) & ~extremes.crossed)
    _clear_ends(extremes, wanted)  # ends so far apart tell nothing of the way
    if moves.robot.arm.named:
        wanted = wanted[_same_branch(moves, wanted)]
    counts = np.array([parts for _, parts in Peaks.PARTS])
    parts = counts[np.searchsorted([most for most, _ in Peaks.PARTS], wide[wanted])]
    many = parts.sum()
    most = _most_places(moves.robot)
    if many > most:
        parts = np.maximum(parts * most // many, Peaks.LEAST_PARTS)
    for one in np.unique(parts):
        yield from _sampled(moves, wanted[parts == one], int(one))


def _most_places(robot: Robot) -> int:
    return Peaks.MOST_PLACES if robot.arm.named else Peaks.MOST_FOLLOWED


def _crossed_at_targets(moves: Moves, extremes: Extremes) -> None:
    """Adds the moves to and from a target in line at which the wrist bends to the other side."""
    if not moves.robot.arm.spherical or len(moves) < 2:
        return
    first, last = moves.starts + 1, moves.rows + 1
    five = np.radians(moves.joints[:, 4])
    in_line = np.flatnonzero(
        (np.abs(np.sin(five[last[:-1]])) < BENT) & (moves.rows[:-1] == moves.starts[1:])
    )
    bends = []
    for place in (first[in_line], last[in_line + 1]):
        four = np.radians(moves.joints[place, 3])
        bends.append(np.sin(five[place]) * np.stack([np.cos(four), np.sin(four)]))
    through = in_line[(bends[0] * bends[1]).sum(axis=0) < 0.0]
    extremes.crossed[through] = extremes.crossed[through + 1] = True


def _clear_ends(extremes: Extremes, moves: Rows) -> None:
    """What the ends of moves have shown."""
    for least in (extremes.wrist, extremes.elbow, extremes.shoulder):
        least[moves] = np.inf
    extremes.seconds[moves] = 0.0


def _same_branch(moves: Moves, rows: Rows) -> Truths:
    """Whether both ends of some moves belong to one arm branch."""
    first, last = (
        moves.robot.branch_of(moves.robot.configuration(moves.joints[place[rows] + 1]))
        for place in (moves.starts, moves.rows)
    )
    return np.asarray(first == last)


def _sampled(moves: Moves, rows: Rows, parts: int) -> Iterator[tuple[Rows, Floats]]:
    """Moves (k,) of those in some rows with their joints (k, parts + 1, a) deg, but for moves
    that leave the reach of the branch that they end in.
    """
    robot = moves.robot
    branches = robot.branch_of(robot.configuration(moves.joints[moves.rows[rows] + 1]))
    many = max(CHUNK // parts, 1)
    for branch in np.unique(branches):
        own = rows[branches == branch]
        for start in range(0, len(own), many):
            at = own[start : start + many]
            first = moves.joints[moves.starts[at] + 1]
            last = moves.joints[moves.rows[at] + 1]
            p, q = moves.poses(at, parts)
            between, excess = joints_along(robot, first, np.full(len(at), branch), (p, q))
            inside = (excess < CLOSING / 2.0).all(axis=1)
            joints = np.concatenate([first[:, None], between, last[:, None]], axis=1)
            yield at[inside], joints[inside]


def _update_extremes(robot: Robot, extremes: Extremes, at: Rows, joints: Floats) -> Truths:
    """Takes down what some of the moves come to; which of them are uneven (k,).

    joints: (k, parts + 1, a) deg.
    """
    k, places, axes = joints.shape
    step = np.abs(robot.wound(np.diff(joints, axis=1)))
    if places == 2:  # a whole turn within one short move is none
        step = np.abs(np.diff(joints, axis=1))
    chain = robot.chained(joints.reshape(-1, axes))
    if robot.arm.spherical:
        sine = np.sin(chain[:, 4])
        bend = (sine[:, None] * np.stack([np.cos(chain[:, 3]), np.sin(chain[:, 3])], 1)).reshape(
            k, places, 2
        )
        nearest = _past_nothing(bend)
        opposite = np.einsum("kpi,kpi->kp", bend[:, :-1], bend[:, 1:]) < 0.0
        extremes.crossed[at] |= (opposite & (nearest < THROUGH)).any(axis=1)
        least = np.degrees(np.arcsin(np.minimum(nearest, 1.0))).min(axis=1)
        extremes.wrist[at] = np.minimum(extremes.wrist[at], least)
        small = np.abs(sine).reshape(k, places) < BENT
        step[..., [3, 5]] = np.where(
            (small[:, :-1] | small[:, 1:])[..., None], 0.0, step[..., [3, 5]]
        )
    elbow = robot.arm.elbow(chain)
    if elbow is not None:
        angle = _within_a_turn(elbow).reshape(k, places)
        first, last = angle[:, :-1], angle[:, 1:]
        stretched = (first * last < 0.0) & (np.abs(last - first) < np.pi)
        least = np.where(stretched.any(axis=1), 0.0, np.inf)
        least = np.minimum(least, np.degrees(np.abs(angle)).min(axis=1))
        extremes.elbow[at] = np.minimum(extremes.elbow[at], least)
    ahead = robot.arm.wrist(chain)
    if ahead is not None:
        wrist = ahead[:, None] * np.stack([np.cos(chain[:, 0]), np.sin(chain[:, 0])], axis=1)
        least = _past_nothing(wrist.reshape(k, places, 2)).min(axis=1)
        extremes.shoulder[at] = np.minimum(extremes.shoulder[at], least)
    needed = step.max(axis=1) * (places - 1) / robot.speeds
    axis = needed.argmax(axis=1)
    seconds = needed[np.arange(k), axis]
    more = seconds > extremes.seconds[at]
    extremes.axis[at[more]] = axis[more]
    extremes.seconds[at[more]] = seconds[more]
    mean = (step.sum(axis=1) / robot.speeds)[np.arange(k), axis]
    return np.asarray((seconds > Peaks.UNEVEN * mean) & (places > 2))


def _past_nothing(points: Floats) -> Floats:
    """How near the straight lines between points (k, p, 2) come to the origin: (k, p - 1)."""
    first, extremes = points[:, :-1], np.diff(points, axis=1)
    squared = np.einsum("kpi,kpi->kp", extremes, extremes)
    part = -np.einsum("kpi,kpi->kp", first, extremes) / np.where(squared > 0.0, squared, 1.0)
    part = np.clip(part, 0.0, 1.0)[..., None]
    return np.asarray(norms(first + part * extremes))


def _within_a_turn(radians: Floats) -> Floats:
    return np.asarray(radians - 2.0 * np.pi * np.round(radians / (2.0 * np.pi)))
