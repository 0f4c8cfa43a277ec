"""A robot that gathers knowledge of the space around it by moving, also at random."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import numpy as np

from assistant.base.arrays import Floats, Ints
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused
from assistant.cell.clearances import robot_of, way_of
from assistant.cell.collision.continuous import Hit, JointPath, hits
from assistant.cell.collision.model import Model
from assistant.cell.exploration.filled_cells import STEP_IN_CELLS, Filler
from assistant.cell.exploration.occupancy import Occupancy, cells_at, keys_of
from assistant.cell.findings import NOT_CLEAR
from assistant.cell.scene import PlacedRobot, Scene
from assistant.program.geometry import Pose, Vector
from assistant.robots import Robot
from assistant.robots.timing import Simulation
from assistant.robots.timing.uninterrupted_moves import stretches_of

CELL_SIZE: Final = 10.0
"""mm of a cell, where nobody says another."""


@dataclass(frozen=True, slots=True)
class Touch:
    """A contact. point: mm in the world, on the touched object; None if only a signal reported the
    contact: then no cell is marked, as the contact may be anywhere on the robot.
    """

    point: Vector | None = None


class Explorer:
    """A robot of a scene, and the map of the space that it has explored.

    scene: the robots with their bodies, tools among them; the map is of space that these fill,
    which may be rounder than the arm by at most `thinner` mm, see `thinner_shape`. findings: bodies
    that explore nothing. Raises Refused for a robot that is not in the scene, an invalid size, or a
    map of another robot.
    """

    def __init__(
        self,
        scene: Scene,
        name: str | None = None,
        size: float = CELL_SIZE,
        known: Occupancy | None = None,
        thinner: float = 0.0,
    ) -> None:
        self.filler = Filler(scene, name, size if known is None else known.size)
        self.scene, self.thinner = scene, thinner
        fresh = Occupancy.unknown(self.filler.size, self.placed.robot.name)
        self.occupancy = fresh if known is None else fresh.merged(known)

    @property
    def placed(self) -> PlacedRobot:
        return self.filler.placed

    @property
    def findings(self) -> tuple[Diagnostic, ...]:
        return tuple(self.filler.findings)

    @property
    def home(self) -> Floats:
        """(j,) all robots of the scene at home."""
        return np.concatenate([placed.robot.home for placed in self.scene.robots])

    def fills(self, rows: Floats, off: Floats | None = None) -> Ints:
        """Keys of the cells that the robot fills at rows (n, j) of the joints of all robots.

        off: (n, j) how far each joint may be from its row.
        """
        less = np.full((len(rows), len(self.filler.parts)), self.thinner)
        if off is not None:
            less += np.abs(off) @ self.filler.lever()
        return self.filler.keys(rows, less if less.any() else None)

    def gone(self, rows: Floats, touch: Touch | None = None, off: Floats | None = None) -> int:
        """One run: rows (n, j) at which there was no contact, and the one that ended it.

        Gives the number of cells that were not free before. For `off` see `fills`. Only the rows
        themselves count, as between them nobody was asked: give them densely.
        """
        filled = self.fills(rows, off)
        new = self.occupancy.new_in(filled)
        self.occupancy = self.occupancy.with_run(filled, self.marked(touch))
        return new

    def marked(self, touch: Touch | None) -> Ints:
        """Keys of the cell of a contact."""
        if touch is None or touch.point is None:
            return np.zeros(0, dtype=np.int64)
        point = (self.placed.base.inverse() @ Pose(touch.point)).position
        return keys_of(cells_at(np.array([point]), self.filler.size))

    def ran(
        self, simulation: Simulation, until: float | None = None, hidden: Scene | None = None
    ) -> int:
        """A run of a program; gives the number of cells that were not free before.

        until: seconds from the start of its procedure at which it was stopped by a contact; None
        if it ran to its end. hidden: instead, the scene that it ran in, which says where it touched
        something. Raises LookupError if the scene has no robot that the program is for.
        """
        placed = robot_of(self.scene, simulation.robot, self.placed.name)
        model = None if hidden is None else Model(hidden)
        rows, offs, touch = [self.home[None][:0]], [self.home[None][:0]], None
        for passed in simulation.passed:
            stretches = stretches_of(passed.plan)
            way = way_of(self.scene, placed, stretches)
            end = float(len(way.rows) - 1)
            if until is not None:
                times = passed.start + stretches.times
                end = float(np.searchsorted(times, until) - 1)
                if end < 0:
                    break
            found = hits(model, way) if model is not None else []
            if found:
                end = min(end, found[0].at)
            some, off = self._between(way, end)
            rows.append(some)
            offs.append(off)
            if model is not None and found:
                touch = _touch_of(model, found[0], placed)
                break
        return self.gone(np.concatenate(rows), touch, np.concatenate(offs))

    def _between(self, way: JointPath, end: float) -> tuple[Floats, Floats]:
        """Rows of a way before a place of it, so many that no body is missed, and how far off."""
        step = np.diff(way.rows, axis=0)
        slack = np.zeros_like(step) if way.slack is None else np.abs(way.slack)
        moved = (np.abs(step) @ self.filler.lever()).max(axis=1, initial=0.0)
        parts = np.maximum(np.ceil(moved / (STEP_IN_CELLS * self.filler.size)), 1.0).astype(np.intp)
        stretch = np.repeat(np.arange(len(step)), parts)
        begins = np.repeat(np.cumsum(parts) - parts, parts)
        part = (np.arange(len(stretch)) - begins) / parts[stretch]
        at_joint = np.maximum(slack, np.concatenate([slack[:1], slack[:-1]]))
        off = np.where((part == 0.0)[:, None], at_joint[stretch], slack[stretch])
        rows = way.rows[stretch] + part[:, None] * step[stretch]
        before = stretch + part < end
        if end >= len(step):  # with the end of the way
            last = slack[-1:] if len(slack) else np.zeros_like(way.rows[-1:])
            return np.concatenate([rows, way.rows[-1:]]), np.concatenate([off, last])
        return rows[before], off[before]


def _touch_of(model: Model, hit: Hit, placed: PlacedRobot) -> Touch:
    """Return the contact of a hit, at the point on the object that the robot does not carry."""
    contact = model.contact(hit.joints, hit.pair)
    bodies = [model.items[int(i[hit.pair])] for i in (model.one, model.other)]
    number = model.scene.robots.index(next(p for p in model.scene.robots if p.name == placed.name))
    own = set(range(*model.carriers.columns[number].indices(model.carriers.joints)))
    moved = [bool(own & set(model.carriers.moved_by(item.carrier))) for item in bodies]
    return Touch() if all(moved) else Touch(contact.points[moved.index(False)])


_TARGETS_PER_MOVE: Final = 6
"""Number of targets drawn for each move; the arm moves to the one that adds most new space."""
_ROWS_BACK: Final = 2
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
    tries: int = _TARGETS_PER_MOVE,
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
            at = clear[max(len(clear) - 1 - _ROWS_BACK, 0)]
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
    """Return an indicator that calls back at each row (j,): a key, a digital input, a camera."""

    def indicated(rows: Floats) -> tuple[int, Touch] | None:
        for n, row in enumerate(rows):
            touch = touching(row)
            if touch is not None:
                return n, touch
        return None

    return indicated


def in_scene(hidden: Scene, placed: PlacedRobot) -> ContactIndicator:
    """Return an indicator of contacts with a scene that the explorer does not have; placed: the
    robot that moves in it.
    """
    model = Model(hidden)

    def indicated(rows: Floats) -> tuple[int, Touch] | None:
        distance, pair = model.nearest(rows[:1])
        if len(rows) and distance[0] <= 0.0:
            contact = model.contact(rows[0], int(pair[0]))
            return 0, Touch(contact.points[1])
        found = hits(model, JointPath(rows))
        if not found:
            return None
        return int(np.ceil(found[0].at)), _touch_of(model, found[0], placed)

    return indicated
