"""How near a program comes to the bodies of its cell, everywhere on its way."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np

from assistant.cell.collision.carriers import Carriers
from assistant.cell.collision.continuous import Hit, Way, hits
from assistant.cell.collision.model import Contact, Model
from assistant.cell.holding import Holding
from assistant.cell.scene import FLANGE, Placed, Scene
from assistant.program.arrays import Floats
from assistant.program.diagnostics import Span
from assistant.program.geometry import Pose
from assistant.robots.robot import Robot
from assistant.robots.timing import Carried, Simulation
from assistant.robots.timing.passed import Passed, Stretches, stretches_of

LOOKED: Final = 64
"""Places in a run of stretches at which the least distance of a pair is looked for."""


@dataclass(frozen=True, slots=True)
class Closeness:
    """A place where two bodies come too near to each other.

    procedure, number, row: the motion statement and its move. label: what it moves to. time:
    seconds from the start of the procedure. contact: there. least: mm at the nearest place after
    it. joints: (a,) of the robot there.
    """

    procedure: str
    number: int
    row: int
    label: str
    time: float
    contact: Contact
    least: float
    joints: Floats
    span: Span | None = None


def closeness(
    simulation: Simulation, scene: Scene, name: str | None = None, margin: float | None = None
) -> Iterator[Closeness]:
    """Where a program comes nearer than the margins to anything, in order of its ways.

    name: of the robot of the scene that runs it; the others stand at home. margin: mm, for all
    pairs, instead of those of the scene; 0 for contacts only.
    """
    models: dict[Carried | None, Model] = {}
    placed = robot_of(scene, simulation.robot, name)
    for passed in simulation.passed:
        for carried, stretches in carrying(passed):
            if carried not in models:
                now = carried.scene_now() if isinstance(carried, Holding) else scene
                models[carried] = Model(now)
            model = models[carried]
            margins = model.margins if margin is None else np.full(len(model), margin)
            way = Way(*rows_of(scene, placed, stretches))
            for hit in hits(model, way, margins):
                yield _closeness(simulation, model, passed, stretches, way, hit)


def carrying(passed: Passed) -> Iterator[tuple[Carried | None, Stretches]]:
    """The stretches of a plan, split where what the arm carries changes."""
    whole = stretches_of(passed.plan)
    kinds = list(dict.fromkeys(piece.carried for piece in passed.pieces))
    if len(kinds) == 1:
        yield kinds[0], whole
        return
    moves = [kinds.index(p.carried) for p in passed.pieces for _ in range(len(p.moves))]
    kind = np.array(moves[passed.skipped :])[whole.row]
    ends = [*(np.flatnonzero(np.diff(kind)) + 1).tolist(), len(kind)]
    for first, last in pairwise([0, *ends]):
        part = Stretches(
            whole.joints[first : last + 1],
            whole.slack[first:last],
            whole.times[first : last + 1],
            whole.row[first:last],
        )
        yield kinds[int(kind[first])] if first < len(kind) else kinds[0], part


def robot_of(scene: Scene, robot: Robot, name: str | None = None) -> Placed:
    """The robot of a scene that runs a program for a robot, the one that is named if any is.

    Raises LookupError if there is none, or if several are of that model and none is named.
    """
    name = name or scene.runs
    found = [
        placed
        for placed in scene.robots
        if placed.robot.name == robot.name and name in (None, placed.name)
    ]
    if len(found) != 1:
        raise LookupError(name or robot.name)
    return found[0]


def beyond_bodies(scene: Scene, placed: Placed, tip: Pose) -> float:
    """Mm from a tip in the flange frame to the boxes around what a robot carries there: 0 if it is
    in one of them.
    """
    model, carriers = Model(scene), Carriers(scene.robots)
    home = np.concatenate([one.robot.home for one in scene.robots])[None]
    flange = carriers.names[f"{placed.name}.{FLANGE}"]
    moved = carriers.moved_by(flange)
    origins, turns = carriers.at(home)
    point = origins[0, flange] + turns[0, flange] @ np.array(tip.position)
    gaps = [
        model.beyond(number, origins[0], turns[0], point)
        for number, item in enumerate(model.items)
        if carriers.moved_by(item.carrier) == moved
    ]
    return min(gaps, default=float(np.linalg.norm(tip.position)))


def rows_of(scene: Scene, placed: Placed, stretches: Stretches) -> tuple[Floats, Floats]:
    """Rows of the joints of all robots, of which one moves, with their slack."""
    rows, slack = [], []
    for one in scene.robots:
        still = np.tile(one.robot.home, (len(stretches.joints), 1))
        rows.append(stretches.joints if one is placed else still)
        slack.append(stretches.slack if one is placed else still[1:] * 0.0)
    return np.concatenate(rows, axis=1), np.concatenate(slack, axis=1)


def _closeness(
    simulation: Simulation, model: Model, passed: Passed, stretches: Stretches, way: Way, hit: Hit
) -> Closeness:
    at = min(int(hit.at), len(stretches.row) - 1)
    part = hit.at - at
    move = int(stretches.row[at])
    piece, row = passed.piece_of(move)
    time = float(stretches.times[at] * (1.0 - part) + stretches.times[at + 1] * part)
    return Closeness(
        piece.procedure,
        piece.number,
        row,
        simulation.labels.get((piece.procedure, piece.number), ""),
        passed.start + time,
        model.contact(hit.joints, hit.pair),
        _least(model, way, hit),
        hit.joints,
    )


def _least(model: Model, way: Way, hit: Hit) -> float:
    """Mm that the pair of a hit is apart at the nearest place of the stretches behind it."""
    if any(not model.items[int(i[hit.pair])].body.shown for i in (model.one, model.other)):
        return hit.distance  # how far into space that nobody knows says nothing
    first = int(hit.at)
    limit = model.margins[hit.pair]
    last = first + 1
    while last < len(way.rows) - 1 and last - first < LOOKED:
        if _distances(model, way.rows[last : last + 1], hit.pair)[0] > limit:
            break
        last += 1
    part = np.linspace(0.0, 1.0, LOOKED)[:, None]
    some = way.rows[first : last + 1]
    places = np.concatenate([a + part * (b - a) for a, b in pairwise(some)])
    return float(min(hit.distance, _distances(model, places, hit.pair).min()))


def _distances(model: Model, rows: Floats, pair: int) -> Floats:
    return model.exact(rows, np.arange(len(rows)), np.full(len(rows), pair))
