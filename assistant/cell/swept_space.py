"""The space that a program sweeps: grid cells that a part which the arm moves could enter.

No cell is missed: each part is tested at positions between which it moves by at most half a cell,
and counts as thicker by what it can move in between (`Carriers.reaches`). So cells that are only
nearly swept count as well, up to `BEYOND` sizes of a cell away.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats, Ints, Truths
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Refused
from assistant.cell.clearances import CarriedBodies, carried_stretches, rows_of
from assistant.cell.collision.model import Carriers, carrier_of
from assistant.cell.exploration.filled_cells import DepthFunction, solid_depth
from assistant.cell.findings import TOO_MANY_POINTS, WRONG_CELL_SIZE
from assistant.cell.scene import Convex, Mesh, Part, PlacedRobot, Scene, extent
from assistant.robots.timing import Simulation

MOST_CELLS: Final = 1 << 24
"""Cells of the box about all that is swept: a byte each for every body."""
_STEP_IN_CELLS: Final = 0.5
"""Largest movement of a part between two poses that are checked, in sizes of a cell."""
_HALF_DIAGONAL: Final = 3.0**0.5 / 2.0
"""Sizes of a cell from its middle to its corners."""
BEYOND: Final = 2.0 * _HALF_DIAGONAL + _STEP_IN_CELLS / 2.0


@dataclass(frozen=True, slots=True, eq=False)
class SweptSpace:
    """Cells of `size` mm; the cell (0, 0, 0) begins in the origin of the world.

    cells: (n, 3), in order. bodies: by name, (n,) whether it sweeps each of them.
    """

    size: float
    cells: Ints
    bodies: Mapping[str, Truths]

    @property
    def middles(self) -> Floats:
        """(n, 3) mm of the world."""
        return np.asarray((self.cells + 0.5) * self.size)

    def litres(self, name: str | None = None) -> float:
        """The volume of what a body sweeps, or all together."""
        count = len(self.cells) if name is None else int(self.bodies[name].sum())
        return count * self.size**3 / 1e6


@dataclass(frozen=True, slots=True, eq=False)
class _Places:
    """Sampled poses of a part: (k, 3), (k, 3, 3) in the world, and mm (k,) by which it is
    thicker.
    """

    body: str
    depth: DepthFunction
    low: Floats
    high: Floats
    origins: Floats
    turns: Floats
    thicker: Floats

    def bounds(self) -> tuple[Floats, Floats]:
        """(k, 3) lowest and highest coordinates."""
        half = np.abs(self.turns) @ ((self.high - self.low) / 2.0) + self.thicker[:, None]
        middle = self.origins + self.turns @ ((self.low + self.high) / 2.0)
        return middle - half, middle + half


def swept_space(
    simulation: Simulation, scene: Scene, placed: PlacedRobot, size: float
) -> SweptSpace:
    """Return the cells that the links of a robot, and the bodies it carries, sweep in all branches
    of a program.

    Other robots stand still. Raises Refused for an invalid size, or for more cells than
    `MOST_CELLS`.
    """
    if not (np.isfinite(size) and size > 0.0):
        raise Refused(WRONG_CELL_SIZE(size=f"{size:g}"), exit_status=2)
    found = list(_places(simulation, scene, placed, size))
    if not found:
        return SweptSpace(size, np.zeros((0, 3), dtype=np.int64), {})
    bounds = [places.bounds() for places in found]
    low = np.floor(np.min([b[0].min(axis=0) for b in bounds], axis=0) / size)
    high = np.ceil(np.max([b[1].max(axis=0) for b in bounds], axis=0) / size)
    count = float(np.prod(high - low))
    if count > MOST_CELLS:
        raise Refused(
            TOO_MANY_POINTS(count=int(count), what="cells", most=MOST_CELLS), exit_status=2
        )
    first, shape = low.astype(np.int64), tuple((high - low).astype(np.intp).tolist())
    marks: dict[str, Truths] = {}
    for places, (lowest, highest) in zip(found, bounds, strict=True):
        mark = marks.setdefault(places.body, np.zeros(shape, dtype=np.bool_))
        for k in range(len(places.origins)):
            _mark(mark, first, size, places, k, lowest[k], highest[k])
    every = np.any(list(marks.values()), axis=0)
    bodies = {name: mark[every] for name, mark in marks.items()}
    return SweptSpace(size, np.argwhere(every) + first, bodies)


def _mark(
    mark: Truths, first: Ints, size: float, places: _Places, k: int, low: Floats, high: Floats
) -> None:
    """Marks the cells that a part could enter near one place."""
    start = np.maximum(np.floor(low / size).astype(np.int64) - first, 0)
    stop = np.ceil(high / size).astype(np.int64) - first
    at, turn = places.origins[k], places.turns[k]
    axes = [(np.arange(start[i], stop[i]) + first[i] + 0.5) * size - at[i] for i in range(3)]
    x, y, z = axes[0][:, None, None], axes[1][None, :, None], axes[2][None, None, :]
    own = [turn[0, i] * x + turn[1, i] * y + turn[2, i] * z for i in range(3)]
    depth = places.depth(own[0], own[1], own[2])
    window = mark[start[0] : stop[0], start[1] : stop[1], start[2] : stop[2]]
    window |= depth >= -(_HALF_DIAGONAL * size + places.thicker[k])


def _places(
    simulation: Simulation, scene: Scene, placed: PlacedRobot, size: float
) -> Iterator[_Places]:
    at = scene.robots.index(placed)
    for passed in simulation.passed:
        for holding, stretches in carried_stretches(passed):
            now = holding.scene_now() if isinstance(holding, CarriedBodies) else scene
            carriers = Carriers(now.robots)
            rows, slack = rows_of(now, now.robots[at], stretches)
            for body in now.all_bodies():
                carrier, pose = carrier_of(now, body, carriers)
                moved = carriers.moved_by(carrier)
                if not moved or moved[0] != carriers.columns[at].start:
                    continue
                for part in body.parts:
                    turned = pose @ part.pose
                    lever = _lever(carriers, carriers.reaches(carrier, turned, part.shape))
                    way, thicker = _looked(rows, slack, lever, _STEP_IN_CELLS * size)
                    origins, turns = carriers.at(way)
                    turn = turns[:, carrier]
                    yield _Places(
                        body.name,
                        *_solid(part),
                        origins[:, carrier] + turn @ np.array(turned.position),
                        turn @ rotations.to_matrix(np.array(turned.quaternion)),
                        thicker,
                    )


def _lever(carriers: Carriers, reaches: Floats) -> Floats:
    """(j,) mm for a degree (mm) of each joint of the scene, of mm for a radian (mm)."""
    turning = np.concatenate([~placed.robot.sliding for placed in carriers.robots])
    return carriers.coupled(np.where(turning, np.radians(reaches), reaches))


def _looked(rows: Floats, slack: Floats, lever: Floats, step: float) -> tuple[Floats, Floats]:
    """Rows (k, j) on the way through rows (n, j), and mm (k,) that a part may be from its nearest.

    Each place of the way is within half a step of one of them, as far as the part can move.
    """
    moved = np.abs(np.diff(rows, axis=0)) @ lever
    gone = np.append(0.0, np.cumsum(moved))
    count = max(int(np.ceil(gone[-1] / step)), 1)
    wanted = (np.arange(count) + 0.5) * (gone[-1] / count)
    if len(rows) < 2:
        return rows[:1], np.zeros(1)
    stretch = np.clip(np.searchsorted(gone, wanted, side="right") - 1, 0, len(moved) - 1)
    part = (wanted - gone[stretch]) / np.where(moved[stretch] > 0.0, moved[stretch], 1.0)
    way = rows[stretch] + np.clip(part, 0.0, 1.0)[:, None] * (rows[stretch + 1] - rows[stretch])
    half = gone[-1] / count / 2.0
    begin = np.clip(np.searchsorted(gone, wanted - half, side="left") - 1, 0, len(moved) - 1)
    end = np.clip(np.searchsorted(gone, wanted + half, side="right"), begin + 1, len(moved))
    loose = np.append(np.abs(slack) @ lever, 0.0)
    most = np.maximum.reduceat(loose, np.stack([begin, end], axis=1).reshape(-1))[::2]
    return way, half + most


def _solid(part: Part) -> tuple[DepthFunction, Floats, Floats]:
    """Return a function for the depth of points in a part, at least the true depth, and the box
    around it.

    A mesh counts as its convex hull; a flat mesh as that box.
    """
    shape = part.shape
    low, high = extent(shape)
    if not isinstance(shape, Mesh):
        solid = solid_depth(shape)
        assert solid is not None  # only an open mesh has none
        return solid.depth, low, high
    low, high = low - shape.off, high + shape.off
    middle, half = (low + high) / 2.0, (high - low) / 2.0
    if np.linalg.matrix_rank(shape.points - shape.points.mean(axis=0), tol=1e-6) < 3:
        return _in_box(middle, half), low, high
    hull = solid_depth(Convex(shape.points))
    assert hull is not None
    depth = hull.depth
    return (lambda x, y, z: depth(x, y, z) + shape.off), low, high


def _in_box(middle: Floats, half: Floats) -> Callable[[Floats, Floats, Floats], Floats]:
    def depth(x: Floats, y: Floats, z: Floats) -> Floats:
        beside = (h - np.abs(v - m) for v, m, h in zip((x, y, z), middle, half, strict=True))
        first, second, third = beside
        return np.asarray(np.minimum(np.minimum(first, second), third))

    return depth
