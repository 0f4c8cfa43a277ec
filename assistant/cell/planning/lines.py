"""Straight lines of the tool in a way, where the arm can follow them and they stay clear.

A line is looked at as the controller goes it: solved and timed as a program of its own, which has
to keep the branch and the turns that it begins with and to end at the joints of the way.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Final

import numpy as np

from assistant.base.arrays import Floats, Truths
from assistant.cell.planning.moves import Route, check_route
from assistant.cell.planning.space import Space
from assistant.robots.configurations import QUADRANTS

JOINT_MOVE_PARTS: Final = 8
"""That a joint move is cut into, for lines."""
MOST_LINE_PARTS: Final = 32
"""Parts of a way of several moves, about."""
SHORTEST_LINE: Final = 1.0
"""mm that the tip goes at least on a line that is worth one."""


def goal_on_line(space: Space, start: Floats, goals: Floats) -> Floats | None:
    """The goal (a,), of goals (k, a) in order, to which a line from joints (a,) is free, if any."""
    for goal in goals:
        if line_is_clear(space, start, goal):
            return np.asarray(goal)
    return None


def with_lines(space: Space, rows: Floats) -> tuple[Floats, Truths]:
    """A way (n, a) with lines as long as they can be: rows (m, a), and for each move whether it is.

    Joint moves that stay in a branch are cut into `PARTS`, so that several lines may stand for one.
    From each place on a line goes as far as one is found that is clear; where none is, the joint
    move stays.
    """
    parts = int(np.clip(MOST_LINE_PARTS // (len(rows) - 1), 1, JOINT_MOVE_PARTS))
    moves = [_cut(space, one, other, parts) for one, other in pairwise(rows)]
    places = np.concatenate([rows[:1], *moves])
    move = np.repeat(np.arange(len(moves)), [len(part) for part in moves])  # to a place but one
    kept, linear, at = [0], list[bool](), 0
    while at < len(move):
        to = _farthest(space, places, at)
        same = bool(linear) and not linear[-1] and move[at] == move[at - 1]
        if to:
            kept.append(to)
            linear.append(True)
        elif same:  # on with the joint move that is under way
            kept[-1] = at + 1
        else:
            kept.append(at + 1)
            linear.append(False)
        at = kept[-1]
    return places[kept], np.array(linear)


def _farthest(space: Space, places: Floats, at: int) -> int:
    """The farthest of places (n, a) that a line from one of them reaches, 0 if none."""
    last = len(places) - 1
    while last > at:
        if line_is_clear(space, places[at], places[last]):
            return last
        last = at + (last - at) // 2
    return 0


def in_branch(space: Space, start: Floats, goals: Floats) -> Floats:
    """Of goals (k, a) those that the arm holds in the branch of joints (a,)."""
    shapes = space.robot.configuration(np.vstack([start, goals]))[:, : QUADRANTS.start]
    return np.asarray(goals[(shapes[1:] == shapes[0]).all(axis=1)])


def _cut(space: Space, start: Floats, end: Floats, parts: int) -> Floats:
    """(k, a) joints on a joint move, its end the last."""
    if not len(in_branch(space, start, end[None])):
        return end[None]
    rows = start + np.linspace(0.0, 1.0, parts + 1)[1:, None] * (end - start)
    rows[-1] = end
    return np.asarray(rows)


def line_is_clear(space: Space, start: Floats, end: Floats) -> bool:
    """Whether the tip can go straight from joints (a,) to joints (a,), with margins and tilt."""
    rows = np.stack([start, end])
    tips, _ = space.tip(rows)
    if np.linalg.norm(tips[1] - tips[0]) < SHORTEST_LINE:
        return False
    # The first move stands still: it tells the branch and the turns that the line begins with.
    route = Route(space.robot, rows[[0, 0, 1]], np.zeros(2), np.array([False, True]), space.tool)
    return check_route(space, route).good
