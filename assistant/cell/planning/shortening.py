"""A way made shorter, with every new move proven."""

from __future__ import annotations

from typing import Final

import numpy as np

from assistant.base.arrays import Floats
from assistant.cell.planning.leaning import ConeMoves
from assistant.cell.planning.space import Space

SHORTCUT_ROUNDS: Final = 30
"""Rounds of random shortcuts."""
SHORTCUTS_AT_ONCE: Final = 8
"""Shortcuts that are tried together."""
CORNER_ROOM: Final = 4.0
"""mm beyond the margins that are left in a shortcut for its corners to be rounded in."""
NO_LENGTH: Final = 1e-12
"""seconds of a way that is none."""
PROGRAM_DIGITS: Final = 2
"""Of joints in degrees and mm between start and goal: with them every language says the same."""
LEAST_SAVING: Final = 1e-3
"""Of the length of a way, what a shortcut must save."""


def shorten_path(
    space: Space,
    rows: Floats,
    goals: Floats | None = None,
    *,
    rounds: int = SHORTCUT_ROUNDS,
    seed: int = 1,
) -> Floats:
    """A way through joints (n, a) without what can be left out, and with corners cut.

    Between two places of the way that are drawn at random the straight move is taken if it is
    free (Geraerts and Overmars, 2007), in each round the one that saves most. In a cone where none
    is, moves that are brought into it are tried. goals: (k, a) joints at which the way may end as
    well, such as other turns of an axis.
    """
    cone = space.cone
    leaning = None if cone is None else ConeMoves(space, cone, *space.robot.limits.T)
    rows = without_corners(space, _to_nearer_goal(space, rows, goals))
    draw = np.random.default_rng(seed)
    for _ in range(rounds):
        if len(rows) < 3:
            break
        shorter = _shortcut(space, leaning, rows, draw)
        rows = rows if shorter is None else shorter
        straighter = _straightened(space, rows, draw)
        rows = rows if straighter is None else straighter
    rows = without_corners(space, _to_nearer_goal(space, rows, goals))
    return _in_few_digits(space, rows)


def _in_few_digits(space: Space, rows: Floats) -> Floats:
    """The way with places that a program can state, if it is as free with them."""
    low, high = space.robot.limits.T
    stated = rows.copy()
    stated[1:-1] = np.clip(np.round(rows[1:-1], PROGRAM_DIGITS), low, high) + 0.0
    return stated if space.clear(stated[:-1], stated[1:]).all() else rows


def _to_nearer_goal(space: Space, rows: Floats, goals: Floats | None) -> Floats:
    """The way (n, a) with its end at another of goals (k, a), if that is shorter."""
    if goals is None or len(goals) < 2:
        return rows
    for change in (_with_turn_spread, _straight_to):
        shorter = change(space, rows, goals)
        rows = rows if shorter is None else shorter
    return rows


def _with_turn_spread(space: Space, rows: Floats, goals: Floats) -> Floats | None:
    """The way with what another goal differs by spread over all of it: a turn less of an axis."""
    lengths = space.length(rows[:-1], rows[1:])
    gone = np.concatenate([[0.0], np.cumsum(lengths)])
    part = gone / max(gone[-1], NO_LENGTH)
    ways = rows + part[:, None] * (goals - rows[-1])[:, None]
    ways[:, -1] = goals
    saved = gone[-1] - space.length(ways[:, :-1], ways[:, 1:]).sum(axis=1)
    for goal in np.argsort(-saved, kind="stable")[:SHORTCUTS_AT_ONCE]:
        way = ways[goal]
        if saved[goal] <= LEAST_SAVING * gone[-1]:
            break
        if space.robot.inside(way).all() and space.clear(way[:-1], way[1:], CORNER_ROOM).all():
            return np.asarray(way)
    return None


def _straight_to(space: Space, rows: Floats, goals: Floats) -> Floats | None:
    """The way that goes straight to another goal from one of its places."""
    left = np.cumsum(space.length(rows[:-1], rows[1:])[::-1])[::-1]
    saved = left[:, None] - space.length(rows[:-1, None], goals)
    place, goal = np.divmod(
        np.argsort(-saved, axis=None, kind="stable")[:SHORTCUTS_AT_ONCE], len(goals)
    )
    some = saved[place, goal] > LEAST_SAVING * left[0]
    place, goal = place[some], goal[some]
    free = np.flatnonzero(space.clear(rows[place], goals[goal], CORNER_ROOM))
    if not len(free):
        return None
    best = int(free[0])
    return np.concatenate([rows[: place[best] + 1], goals[goal[best]][None]])


def _straightened(space: Space, rows: Floats, draw: np.random.Generator) -> Floats | None:
    """The way with an axis that goes straight between two of its places while others go as before.

    Axes turn back and forth on the way of a tree; a shortcut of all of them may not be free.
    """
    first, last = np.sort(draw.choice(len(rows), 2, replace=False))
    axis = int(draw.integers(rows.shape[1]))
    if last - first < 2:
        return None
    old = rows[first : last + 1]
    gone = np.concatenate([[0.0], np.cumsum(space.length(old[:-1], old[1:]))])
    new = old.copy()
    new[:, axis] = old[0, axis] + gone / max(gone[-1], NO_LENGTH) * (old[-1, axis] - old[0, axis])
    length = space.length(new[:-1], new[1:]).sum()
    whole = space.length(rows[:-1], rows[1:]).sum()
    if (
        gone[-1] - length <= LEAST_SAVING * whole
        or not space.clear(new[:-1], new[1:], CORNER_ROOM).all()
    ):
        return None
    return np.concatenate([rows[:first], new, rows[last + 1 :]])


def without_corners(space: Space, rows: Floats) -> Floats:
    """From each place on straight to the last one that can be reached so."""
    kept, at = [0], 0
    while at < len(rows) - 1:
        later = np.arange(at + 1, len(rows))
        clear = space.clear(np.repeat(rows[at][None], len(later), axis=0), rows[later])
        clear[0] = True  # of the way itself
        at = int(later[np.flatnonzero(clear)[-1]])
        kept.append(at)
    return rows[kept]


def _shortcut(
    space: Space, leaning: ConeMoves | None, rows: Floats, draw: np.random.Generator
) -> Floats | None:
    """The way with the best of some shortcuts, None if none is free."""
    lengths = space.length(rows[:-1], rows[1:])
    gone = np.concatenate([[0.0], np.cumsum(lengths)])
    places = np.sort(draw.uniform(0.0, gone[-1], (SHORTCUTS_AT_ONCE, 2)), axis=1)
    legs = np.clip(np.searchsorted(gone, places, side="right") - 1, 0, len(lengths) - 1)
    part = (places - gone[legs]) / np.where(lengths[legs] > 0.0, lengths[legs], 1.0)
    ends = rows[legs] + part[..., None] * (rows[legs + 1] - rows[legs])
    saved = places[:, 1] - places[:, 0] - space.length(ends[:, 0], ends[:, 1])
    some = np.flatnonzero((legs[:, 0] < legs[:, 1]) & (saved > LEAST_SAVING * gone[-1]))
    free = some[space.clear(ends[some, 0], ends[some, 1], CORNER_ROOM)]
    if len(free):
        best = int(free[int(np.argmax(saved[free]))])
        between = ends[best]
    elif leaning is not None and len(some):  # no straight move stays in the cone: several may
        best = int(some[int(np.argmax(saved[some]))])
        between = leaning.clear_chain(*ends[best])
        length = float(space.length(between[:-1], between[1:]).sum())
        apart = float(places[best, 1] - places[best, 0])
        if (
            not np.array_equal(between[-1], ends[best, 1])
            or apart - length <= LEAST_SAVING * gone[-1]
        ):
            return None
    else:
        return None
    first, last = legs[best]
    return np.concatenate([rows[: first + 1], between, rows[last + 1 :]])
