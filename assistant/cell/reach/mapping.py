"""Which part of a region an arm reaches with which directions of its tool: a map in columns."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats, Truths, evenly_spaced
from assistant.cell.planning.space import Space
from assistant.cell.reach.holding import Postures, best_postures, nearest_bodies
from assistant.cell.reach.region import Directions
from assistant.cell.scene import PlacedRobot, Scene
from assistant.program.geometry import IDENTITY, Pose

MOST_ASKED: Final = 200
"""Places at which it is told what is too near."""


@dataclass(frozen=True, slots=True, eq=False)
class ReachMap:
    """A map of n points and d directions.

    points: (n, 3) mm of the world. reached, touching: (n, d), see `Held`; touching is inside the
    limits, but not without coming too near to something. room: (n, d) 0 to 1, NaN where it is not
    reached. limits, away, clearance: (n, d) what it is the least of. joints: (n, d, a). nearest:
    of two bodies, of how many of `touching`, at most `ASKED`, they keep least of their margin.
    """

    points: Floats
    directions: Directions
    reached: Truths
    touching: Truths
    room: Floats
    limits: Floats
    away: Floats
    clearance: Floats
    joints: Floats
    nearest: Mapping[tuple[str, str], int]

    @property
    def share(self) -> Floats:
        """(n,) of the directions that are reached."""
        return np.asarray(self.reached.mean(axis=1))


def reach_map(
    scene: Scene,
    placed: PlacedRobot,
    points: Floats,
    directions: Directions,
    *,
    tip: Pose = IDENTITY,
    bodies: bool = True,
    margin: float | None = None,
) -> ReachMap:
    """What a robot of a scene reaches of points (n, 3) mm of the world.

    directions: of the tip, in the world. tip: in the flange. bodies: whether anything may be
    touched; False for reach and limits alone, which needs no library for collisions. margin: mm,
    None for those of the scene. Other robots stand at home.
    """
    space = Space(scene, placed, margin=margin, tool=tip) if bodies else None
    into = placed.base.inverse()
    there = rotations.rotate(np.array(into.quaternion), points) + np.array(into.position)
    columns: list[Postures] = []
    for quaternions in directions.quaternions:
        own = rotations.multiply(np.array(into.quaternion), quaternions)
        columns.append(best_postures(placed.robot, there, own, space, tip))

    def together(name: str) -> Floats:
        some = [getattr(column, name) for column in columns]
        return np.stack(some, axis=1)

    reached = np.stack([column.reached for column in columns], axis=1)
    touching = np.stack([column.touching for column in columns], axis=1)
    return ReachMap(
        points,
        directions,
        reached,
        touching,
        room=together("room"),
        limits=together("limits"),
        away=together("away"),
        clearance=together("clearance"),
        joints=together("joints"),
        nearest=_in_the_way(space, columns),
    )


def _in_the_way(space: Space | None, columns: Sequence[Postures]) -> Mapping[tuple[str, str], int]:
    """Bodies that keep the arm from places, the most common first; places are taken evenly."""
    rows = np.concatenate([column.joints[column.touching] for column in columns])
    if space is None or not len(rows):
        return {}
    some = evenly_spaced(len(rows), MOST_ASKED)
    return dict(Counter(nearest_bodies(space, row) for row in rows[some]).most_common())
