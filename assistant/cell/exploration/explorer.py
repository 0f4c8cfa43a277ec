"""A robot that gathers knowledge of the space about it by moving in it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from assistant.base.arrays import Floats, Ints
from assistant.base.diagnostics import Diagnostic
from assistant.cell.clearances import robot_of, way_of
from assistant.cell.collision.continuous import Hit, JointPath, hits
from assistant.cell.collision.model import Model
from assistant.cell.exploration.filling import STEP_IN_CELLS, Filler
from assistant.cell.exploration.occupancy import Occupancy, cells_at, keys_of
from assistant.cell.scene import PlacedRobot, Scene
from assistant.program.geometry import Pose, Vector
from assistant.robots.timing import Simulation
from assistant.robots.timing.passed import stretches_of

CELL_SIZE: Final = 10.0
"""mm of a cell, where nobody says another."""


@dataclass(frozen=True, slots=True)
class Touch:
    """A contact. point: mm in the world, on what was touched; None where only a signal told of it:
    then nothing is marked, as it may be anywhere on the robot.
    """

    point: Vector | None = None


class Explorer:
    """A robot of a scene, and the map of what it knows.

    scene: the robots with their bodies, tools among them; the map is of space that these fill, so
    where they are rounder than the arm is, `thinner` tells by how many mm at most.
    findings: bodies that explore nothing. Raises Refused for a robot that the scene has not, a size
    that is none, or a map of another robot.
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
                touch = touch_of(model, found[0], placed)
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


def touch_of(model: Model, hit: Hit, placed: PlacedRobot) -> Touch:
    """Where a robot touched what is not itself, of a hit."""
    contact = model.contact(hit.joints, hit.pair)
    bodies = [model.items[int(i[hit.pair])] for i in (model.one, model.other)]
    number = model.scene.robots.index(next(p for p in model.scene.robots if p.name == placed.name))
    own = set(range(*model.carriers.columns[number].indices(model.carriers.joints)))
    moved = [bool(own & set(model.carriers.moved_by(item.carrier))) for item in bodies]
    return Touch() if all(moved) else Touch(contact.points[moved.index(False)])
