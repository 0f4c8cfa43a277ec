"""Random movement that explores: where it goes, and what tells it of contacts."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np

from assistant.base.arrays import Floats
from assistant.base.diagnostics import Refused
from assistant.cell.collision.continuous import JointPath, hits
from assistant.cell.collision.model import Model
from assistant.cell.exploration.explorer import Explorer, Touch, touch_of
from assistant.cell.exploration.filling import STEP_IN_CELLS
from assistant.cell.exploration.rules import NOT_CLEAR
from assistant.cell.scene import PlacedRobot, Scene
from assistant.robots import Robot

TARGETS_PER_MOVE: Final = 6
"""Places that are drawn for each move; the one that tells most of new space is gone to."""
ROWS_BACK: Final = 2
"""Rows that it goes back from a contact."""

ContactIndicator = Callable[[Floats], tuple[int, Touch] | None]
"""Goes through rows (n, j) of joints in order: the first one with a contact, None for none."""


@dataclass(frozen=True, slots=True)
class Wandered:
    """moves: made; contacts: that ended one, and how many of these told no place; new: cells that
    were not free before; joints: (j,) where the robot stands.
    """

    moves: int
    contacts: int
    placeless: int
    new: int
    joints: Floats


def wander(
    explorer: Explorer,
    indicated: ContactIndicator,
    moves: int,
    *,
    seed: int = 0,
    start: Floats | None = None,
    within: Floats | None = None,
    tries: int = TARGETS_PER_MOVE,
) -> Wandered:
    """Straight moves of the joints to random places, each up to the first contact: a run each.

    start: (j,) joints of all robots of the scene, all at home if None. within: (a, 2) limits of the
    robot's joints, its own if None. Moves end before what the explorer's own scene says is touched,
    the robot itself among it. Raises Refused for a start that is in contact.
    """
    draw = np.random.default_rng(seed)
    ranges = ranges_of(explorer.placed.robot, within)
    known = Model(explorer.scene)
    at = np.array(explorer.home if start is None else start, dtype=np.float64)
    if indicated(at[None]) is not None or known.nearest(at[None])[0][0] <= 0.0:
        raise Refused(NOT_CLEAR(), exit_status=2)
    new = contacts = placeless = 0
    for _ in range(moves):
        targets = np.tile(at, (max(tries, 1), 1))
        targets[:, explorer.filler.columns] = drawn_in(ranges, len(targets), draw)
        rows = way_to(explorer, known, at, best_of(explorer, targets))
        found = indicated(rows)
        clear, touch = (rows, None) if found is None else (rows[: found[0]], found[1])
        new += explorer.gone(clear, touch)
        contacts += touch is not None
        placeless += touch is not None and touch.point is None
        if touch is None:
            at = rows[-1]
        elif len(clear):
            at = clear[max(len(clear) - 1 - ROWS_BACK, 0)]
    return Wandered(moves, contacts, placeless, new, at)


def ranges_of(robot: Robot, within: Floats | None = None) -> Floats:
    """Return the ranges (a, 2), degrees or mm, of targets: at most 360 degrees each way.

    within: (a, 2), None for the limits of the robot.
    """
    ranges = np.array(robot.limits if within is None else within, dtype=np.float64)
    turns = ~robot.sliding
    ranges[turns] = np.clip(ranges[turns], -360.0, 360.0)
    return ranges


def drawn_in(ranges: Floats, count: int, draw: np.random.Generator) -> Floats:
    """Return random joints (count, a) in ranges (a, 2)."""
    return draw.uniform(ranges[:, 0], ranges[:, 1], (count, len(ranges)))


def best_of(explorer: Explorer, targets: Floats) -> Floats:
    """Return the target (j,) of (n, j) at which the robot fills most cells that are not free."""
    scores = [explorer.occupancy.new_in(explorer.fills(row[None])) for row in targets]
    return np.asarray(targets[int(np.argmax(scores))])


def way_to(explorer: Explorer, known: Model, at: Floats, target: Floats) -> Floats:
    """Return rows of joints to a target, or to just before the first known contact."""
    step = target - at
    moved = float((np.abs(step) @ explorer.filler.lever()).max(initial=0.0))
    count = int(np.ceil(moved / (STEP_IN_CELLS * explorer.filler.size))) + 1
    part = np.linspace(0.0, 1.0, count + 1)
    found = hits(known, JointPath(np.stack([at, target])))
    if found:
        part = part[part < found[0].at - 1.0 / count]
    return np.asarray(at + np.append(0.0, part[1:])[:, None] * step)


def asked(touching: Callable[[Floats], Touch | None]) -> ContactIndicator:
    """What a callback tells that is asked at each row (j,): a key, a digital input, a camera."""

    def indicated(rows: Floats) -> tuple[int, Touch] | None:
        for n, row in enumerate(rows):
            touch = touching(row)
            if touch is not None:
                return n, touch
        return None

    return indicated


def in_scene(hidden: Scene, placed: PlacedRobot) -> ContactIndicator:
    """What a scene tells that the explorer does not know; placed: the robot that moves in it."""
    model = Model(hidden)

    def indicated(rows: Floats) -> tuple[int, Touch] | None:
        distance, pair = model.nearest(rows[:1])
        if len(rows) and distance[0] <= 0.0:
            contact = model.contact(rows[0], int(pair[0]))
            return 0, Touch(contact.points[1])
        found = hits(model, JointPath(rows))
        if not found:
            return None
        return int(np.ceil(found[0].at)), touch_of(model, found[0], placed)

    return indicated
