"""Zones: how far around its target each move may leave its path, as it can be there."""

from __future__ import annotations

from typing import Final

import numpy as np

from assistant.base.arrays import Floats
from assistant.cell.scene import PlacedRobot
from assistant.program.motion import Kind
from assistant.robots.timing import Simulation
from assistant.robots.timing.course import join_moves, sums_by_move
from assistant.robots.timing.uninterrupted_moves import MovesWithoutStop
from assistant.view.stages import motion_stages

MOST_ZONE_STAGES: Final = 1_000
"""Stretches of moves that are looked at."""
SMALLEST_ZONE: Final = 0.05
"""mm below which a zone is none to be seen."""


def zones_of(simulation: Simulation, placed: PlacedRobot, until: float) -> Floats:
    """(z, 4) centres in the world and radii, mm, of the way that is played until so many
    seconds, each place once.

    A zone reaches to the middle of the moves before and after it at most, and where a program
    waits there is none. Of a tool that the arm does not carry none is told.
    """
    found: dict[int, MovesWithoutStop] = {}
    for number, (_, passed) in enumerate(motion_stages(simulation, until)):
        if number >= MOST_ZONE_STAGES:
            break
        found[id(passed)] = passed
    parts = [_move_zones(passed) for passed in found.values()]
    every = np.concatenate([np.zeros((0, 4)), *parts])
    _, first = np.unique(every.round(2), axis=0, return_index=True)
    every = every[np.sort(first)]
    every[:, :3] = placed.base.moved(every[:, :3])
    return every


def _move_zones(passed: MovesWithoutStop) -> Floats:
    moves = join_moves([piece.moves for piece in passed.pieces]).rest(passed.skipped)
    knots = passed.plan.course.knots
    half = sums_by_move(knots.row, knots.length, len(moves)) / 2.0
    entry = np.minimum(moves.entry[:-1], half[:-1])
    radius = np.minimum(entry, np.minimum(moves.leaving[:-1], half[1:]))
    mounts = moves.mounts
    held = np.array([one.tool.held and not one.frame.held for one in mounts])[moves.mount]
    tool = np.array([[m.tool for m in mounts].index(one.tool) for one in mounts])[moves.mount]
    through = moves.kinds[:-1] == Kind.VIA
    seen = (radius > SMALLEST_ZONE) & ~through & (tool[:-1] == tool[1:]) & held[:-1]
    return np.asarray(np.column_stack([moves.positions[:-1], radius])[seen])
