"""What of a cell stands in something else of it that does not move either."""

from __future__ import annotations

from collections.abc import Container, Iterator
from typing import Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats
from assistant.cell.collision.continuous import RESOLUTION
from assistant.cell.collision.distances import Distances
from assistant.cell.collision.model import Item, Model
from assistant.cell.exploration.depths import thinner_shape
from assistant.cell.shapes import Mesh

UNKNOWN_DEPTH: Final = -1.0
"""mm that stand for a depth that is not known."""

OverlapDepths = dict[tuple[str, str], float]
"""Names of what is moved and of what it stands in → mm that they are apart, below 0."""


def overlap_depths(model: Model, moved: Container[str]) -> OverlapDepths:
    """How deep things of the world that are moved, by the names of their bodies, stand in others.

    Two that may touch by the scene are left out.
    """
    still = [item for item in model.items if not model.carriers.moved_by(item.carrier)]
    rows = np.concatenate([placed.robot.home for placed in model.scene.robots])[None]
    origins, turns = model.carriers.at(rows)
    found: OverlapDepths = {}
    for i, k in _pairs(model, still, moved):
        at = [(turns[0, j.carrier], origins[0, j.carrier]) for j in (still[i], still[k])]
        if _between_spheres(still[i], still[k], at) > 0.0:
            continue
        apart = _item_distance(still[i], still[k], at)
        names = still[i].body.name, still[k].body.name
        if apart < found.get(names, 0.0):
            found[names] = apart
    return found


def _item_distance(one: Item, other: Item, at: list[tuple[Floats, Floats]]) -> float:
    """Mm between two items, below 0 by how deep they are in each other.

    Of a mesh only that there is contact is known: it is `IN` if something that is thinner by
    `RESOLUTION` has it too, or lies inside. Two meshes that touch are in each other.
    """
    ends = [
        (
            (origin + turn @ np.array(item.pose.position))[None],
            (turn @ rotations.to_matrix(np.array(item.pose.quaternion)))[None],
        )
        for item, (turn, origin) in zip((one, other), at, strict=True)
    ]
    shapes = [one.part.shape, other.part.shape]
    first, second = np.array([0]), np.array([1])
    found = float(Distances(shapes).signed(first, second, *ends)[0])
    meshes = [isinstance(shape, Mesh) for shape in shapes]
    if not any(meshes):
        return found
    if found <= 0.0 and not all(meshes):
        plain = meshes.index(False)
        shapes[plain] = thinner_shape(shapes[plain], RESOLUTION)
        found = float(Distances(shapes).signed(first, second, *ends)[0])
    return UNKNOWN_DEPTH if found <= 0.0 else 0.0


def deeper_overlap(now: OverlapDepths, before: OverlapDepths) -> tuple[str, str] | None:
    """Two that are deeper in each other than before, None if there are none."""
    for names, apart in now.items():
        if apart < before.get(names, 0.0) - RESOLUTION:
            return names
    return None


def _pairs(model: Model, still: list[Item], moved: Container[str]) -> Iterator[tuple[int, int]]:
    for i, one in enumerate(still):
        for k, other in enumerate(still):
            names = one.body.name, other.body.name
            if names[0] in moved and names[1] not in moved and not model.scene.may_touch(*names):
                yield i, k


def _between_spheres(one: Item, other: Item, at: list[tuple[Floats, Floats]]) -> float:
    """Mm between the spheres about two items."""
    middles = [
        origin + turn @ item.middle for item, (turn, origin) in zip((one, other), at, strict=True)
    ]
    return float(np.linalg.norm(middles[0] - middles[1])) - one.radius - other.radius
