"""Cells that lie entirely inside the bodies that a robot moves, and depths inside shapes."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import product
from typing import Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats, Ints, Truths, norms
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused
from assistant.cell.collision.distances import (
    bounding_box,
    coal_geometry,
    coal_library,
    distance_request,
    points_inside,
)
from assistant.cell.collision.model import Carriers, carrier_of
from assistant.cell.exploration.occupancy import keys_of
from assistant.cell.findings import NO_EXPLORING_ROBOT, OPEN_BODY, TOO_COARSE, TOO_FINE
from assistant.cell.scene import (
    Body,
    Box,
    Capsule,
    Convex,
    Cylinder,
    Mesh,
    Part,
    PlacedRobot,
    Scene,
    Shape,
    Sphere,
    extent,
)
from assistant.program.geometry import Pose

DepthFunction = Callable[[Floats, Floats, Floats], Floats]
"""Coordinates x, y, z of places in the frame of a shape → mm to its surface, below 0 outside."""

_LEAST_LEFT: Final = 0.01
"""mm that a shape keeps of itself, however much thinner it is made."""
_VOXELS: Final = 3000
"""Places in the box about a mesh that its depth is worked out at."""
_POINT_RADIUS: Final = 1e-3
"""mm: the radius of a ball that stands for a point."""


@dataclass(frozen=True, slots=True)
class SolidDepth:
    """depth: of a convex shape exactly, else at least. convex: whether it is; deepest: its largest
    depth.
    """

    depth: DepthFunction
    convex: bool
    deepest: float


def solid_depth(shape: Shape) -> SolidDepth | None:
    """None for a mesh that is open."""
    match shape:
        case Sphere(radius=r):
            return SolidDepth(lambda x, y, z: r - np.sqrt(x * x + y * y + z * z), True, r)
        case Capsule(radius=r, length=length):
            return SolidDepth(lambda x, y, z: _capsule(r, length, x, y, z), True, r)
        case Cylinder(radius=r, length=length):
            deepest = min(r, length / 2.0)
            return SolidDepth(
                lambda x, y, z: np.minimum(r - np.hypot(x, y), length / 2.0 - np.abs(z)),
                True,
                deepest,
            )
        case Box(size=(a, b, c)):
            return SolidDepth(
                lambda x, y, z: np.minimum(
                    np.minimum(a / 2.0 - np.abs(x), b / 2.0 - np.abs(y)), c / 2.0 - np.abs(z)
                ),
                True,
                min(a, b, c) / 2.0,
            )
        case Convex():
            planes = _planes(shape)
            return SolidDepth(lambda x, y, z: _behind(planes, x, y, z), True, _middle(planes)[1])
    return _of_mesh(shape) if shape.solid else None


def _capsule(radius: float, length: float, x: Floats, y: Floats, z: Floats) -> Floats:
    beyond = np.maximum(np.abs(z) - length / 2.0, 0.0)
    return np.asarray(radius - np.sqrt(x * x + y * y + beyond * beyond))


def _planes(shape: Convex) -> Floats:
    """Return the (k, 4) outward unit normals of the faces, and the distance of the origin on the
    inner side of each face.
    """
    from scipy.spatial import ConvexHull  # type: ignore[import-untyped]

    found = np.unique(np.round(ConvexHull(shape.points).equations, 12), axis=0)
    return np.column_stack([found[:, :3], -found[:, 3]])


def _behind(planes: Floats, x: Floats, y: Floats, z: Floats) -> Floats:
    out = np.full(np.broadcast_shapes(x.shape, y.shape, z.shape), np.inf)
    for a, b, c, far in planes.tolist():
        np.minimum(out, far - (a * x + b * y + c * z), out=out)
    return out


def _middle(planes: Floats) -> tuple[Floats, float]:
    """The middle and the radius of the largest ball behind all planes, a linear program."""
    from scipy.optimize import linprog  # type: ignore[import-untyped]

    sides = np.column_stack([planes[:, :3], np.ones(len(planes))])
    bounds = [(None, None)] * 3 + [(0.0, None)]
    found = linprog([0.0, 0.0, 0.0, -1.0], sides, planes[:, 3], bounds=bounds).x
    return found[:3], float(found[3])


def _of_mesh(mesh: Mesh) -> SolidDepth:
    """At least how deep, from places of a grid: a place is no less deep than another one less the
    way between them.
    """
    low, high = extent(mesh)
    edge = max(float((np.prod(high - low) / _VOXELS) ** (1.0 / 3.0)), 1e-6)
    shape = np.maximum(np.ceil((high - low) / edge), 1).astype(np.intp)
    indices = np.stack(np.meshgrid(*map(np.arange, shape), indexing="ij"), axis=-1).reshape(-1, 3)
    places = low + (indices + 0.5) * edge
    known = (_from_surface(mesh, places) - mesh.off) * _inside(mesh, places)
    known = known.reshape(tuple(shape))

    def depth(x: Floats, y: Floats, z: Floats) -> Floats:
        points = np.stack(np.broadcast_arrays(x, y, z), axis=-1)
        cell = np.clip(((points - low) / edge).astype(np.intp), 0, shape - 1)
        away = norms(points - (low + (cell + 0.5) * edge))
        return np.asarray(known[cell[..., 0], cell[..., 1], cell[..., 2]] - away)

    return SolidDepth(depth, False, float(known.max()))


def _from_surface(mesh: Mesh, points: Floats) -> Floats:
    coal = coal_library()
    surface, ball, result, wanted = (
        coal_geometry(mesh),
        coal.Sphere(_POINT_RADIUS),
        None,
        distance_request(),
    )
    still = coal.Transform3s()
    out = np.empty(len(points))
    for n, point in enumerate(points):
        result = coal.DistanceResult()
        at = coal.Transform3s(np.eye(3), point)
        out[n] = max(coal.distance(surface, still, ball, at, wanted, result), 0.0)
    return out


def _inside(mesh: Mesh, points: Floats) -> Truths:
    return np.asarray(points_inside(mesh, points), dtype=np.bool_)


def thinner_shape(shape: Shape, by: float) -> Shape:
    """Return a shape that is `by` mm thinner all round, but at least `_LEAST_LEFT` thick.

    A mesh is replaced by its convex hull, which is larger than the mesh.
    """
    match shape:
        case Sphere(radius=r):
            return Sphere(max(r - by, _LEAST_LEFT))
        case Capsule(radius=r, length=length):
            return Capsule(max(r - by, _LEAST_LEFT), length)
        case Cylinder(radius=r, length=length):
            return Cylinder(max(r - by, _LEAST_LEFT), max(length - 2.0 * by, 2.0 * _LEAST_LEFT))
        case Box(size=(a, b, c)):
            least = 2.0 * _LEAST_LEFT
            return Box((max(a - 2 * by, least), max(b - 2 * by, least), max(c - 2 * by, least)))
        case Convex():
            return _thinner_hull(shape, by)
    return shape if by <= shape.off else _thinner_hull(Convex(shape.points), by - shape.off)


def _thinner_hull(shape: Convex, by: float) -> Convex:
    from scipy.spatial import HalfspaceIntersection

    planes = _planes(shape)
    middle, deepest = _middle(planes)
    by = min(by, deepest - _LEAST_LEFT)
    if by <= 0.0:
        return shape
    sides = np.column_stack([planes[:, :3], by - planes[:, 3]])
    return Convex(HalfspaceIntersection(sides, middle).intersections)


STEP_IN_CELLS: Final = 0.5
"""Largest movement of a body between two poses that are checked, in sizes of a cell."""
MOST_CELLS: Final = 1 << 28
"""Cells of the box about all that a run fills: a byte each."""
HALF_DIAGONAL: Final = 3.0**0.5 / 2.0
"""Sizes of a cell from its middle to its corners."""
_DEPTH_ROUNDING: Final = 1e-9
"""mm that a cell is deeper inside than rounding could take away."""
_CELL_CORNERS: Final = np.array(list(product((-0.5, 0.5), repeat=3)))


@dataclass(frozen=True, eq=False)
class _MovedPart:
    """A part that a robot moves: link: the frame of `Robot.link_frames` it is carried by; pose: in
    that; low, high: (3,) of the box about it, in its own frame.
    """

    body: Body
    part: Part
    link: int
    pose: Pose
    solid: SolidDepth
    low: Floats
    high: Floats


class Filler:
    """The moved bodies of a robot of a scene, and the cells of `size` mm that they fill.

    findings: bodies that fill nothing. Raises Refused if the scene has no such robot.
    """

    def __init__(self, scene: Scene, name: str | None, size: float) -> None:
        self.scene, self.size = scene, size
        self.placed = robot_named(scene, name)
        self.carriers = Carriers(scene.robots)
        number = scene.robots.index(self.placed)
        self.columns, self._first = self.carriers.columns[number], self.carriers.first[number]
        self.findings: list[Diagnostic] = []
        self.parts = tuple(self._parts())

    def moved(self) -> Iterator[tuple[Body, Part, int, Pose]]:
        """Parts of the bodies that the robot moves, with their links and their poses there."""
        last = self._first + len(self.placed.robot.axes) + 1
        for body in self.scene.all_bodies():
            carrier, pose = carrier_of(self.scene, body, self.carriers)
            if self._first < carrier <= last:
                for part in body.parts:
                    yield body, part, carrier - self._first - 1, pose @ part.pose

    def _parts(self) -> Iterator[_MovedPart]:
        for body, part, link, pose in self.moved():
            solid = solid_depth(part.shape)
            if solid is None:
                self.findings.append(OPEN_BODY(name=body.name))
                continue
            if solid.deepest < HALF_DIAGONAL * self.size:
                better = solid.deepest / HALF_DIAGONAL
                self.findings.append(TOO_COARSE(name=body.name, size=self.size, better=better))
            low, high = _box(part.shape)
            yield _MovedPart(body, part, link, pose, solid, low, high)

    def lever(self) -> Floats:
        """(j, i) mm that a part moves at most for a degree (mm) of each joint of the scene."""
        reaches = [
            self.carriers.reaches(self._first + 1 + part.link, part.pose, part.part.shape)
            for part in self.parts
        ]
        chain = np.array(reaches).reshape(len(self.parts), self.carriers.joints).T
        turning = np.concatenate([~placed.robot.sliding for placed in self.scene.robots])
        chain[turning] = np.radians(chain[turning])
        return self.carriers.coupled(chain)

    def keys(self, rows: Floats, thinner: Floats | None = None) -> Ints:
        """Keys of the cells that lie wholly inside a part at one of rows (n, j) of joints.

        thinner: (n, i) mm that each of `parts` is taken smaller all round; None for not at all.
        Raises Refused for more cells than `MOST_CELLS`.
        """
        if not len(rows) or not len(self.parts):
            return np.zeros(0, dtype=np.int64)
        origins, turns = self.placed.robot.link_frames(rows[:, self.columns])
        places = [self._placed(part, origins, turns) for part in self.parts]
        boxes = [_bounds(part, *place) for part, place in zip(self.parts, places, strict=True)]
        low = np.floor(np.min([b[0].min(axis=0) for b in boxes], axis=0) / self.size)
        high = np.ceil(np.max([b[1].max(axis=0) for b in boxes], axis=0) / self.size)
        count = int(np.prod(high - low))
        if count > MOST_CELLS:
            raise Refused(TOO_FINE(size=self.size, count=count, most=MOST_CELLS), exit_status=2)
        first = low.astype(np.int64)
        marks = np.zeros(tuple((high - low).astype(np.intp)), dtype=np.bool_)
        for i, (part, (at, turn), box) in enumerate(zip(self.parts, places, boxes, strict=True)):
            less = np.zeros(len(rows)) if thinner is None else thinner[:, i]
            for n in self._looked(part, at, turn):
                self._mark(marks, first, part, at[n], turn[n], box[0][n], box[1][n], float(less[n]))
        return keys_of(np.argwhere(marks) + first)

    def inside(self, body: Body, pose: Pose) -> Ints:
        """Return the keys of the cells that lie completely inside a body at a pose in the base.

        Open meshes have none.
        """
        found = [np.zeros(0, dtype=np.int64)]
        for part in body.parts:
            solid = solid_depth(part.shape)
            if solid is not None:
                still = _MovedPart(body, part, 0, pose @ part.pose, solid, *_box(part.shape))
                found.append(self._still(still))
        return np.unique(np.concatenate(found))

    def _still(self, part: _MovedPart) -> Ints:
        """Return the keys of the cells inside one part, whose pose is in the base; see `inside`."""
        at = np.array([part.pose.position])
        turn = rotations.to_matrix(np.array([part.pose.quaternion]))
        low, high = _bounds(part, at, turn)
        first = np.floor(low[0] / self.size).astype(np.int64)
        count = np.ceil(high[0] / self.size).astype(np.int64) - first
        if int(np.prod(count)) > MOST_CELLS:
            raise Refused(TOO_FINE(size=self.size, count=int(np.prod(count)), most=MOST_CELLS))
        marks = np.zeros(tuple(count), dtype=np.bool_)
        self._mark(marks, first, part, at[0], turn[0], low[0], high[0], 0.0)
        return keys_of(np.argwhere(marks) + first)

    def _placed(self, part: _MovedPart, origins: Floats, turns: Floats) -> tuple[Floats, Floats]:
        """(n, 3) where the frame of a part is in the base, and (n, 3, 3) how it is turned."""
        turn = turns[:, part.link]
        own = rotations.to_matrix(np.array(part.pose.quaternion))
        return origins[:, part.link] + turn @ np.array(part.pose.position), turn @ own

    def _looked(self, part: _MovedPart, at: Floats, turn: Floats) -> Ints:
        """Rows at which a part has moved by `STEP_IN_CELLS` since the last one, the first and the
        last.
        """
        corners = (part.low + part.high) / 2.0 + _CELL_CORNERS * (part.high - part.low)
        there = at[:, None] + np.einsum("npq,cq->ncp", turn, corners)
        gone = np.concatenate([[0.0], norms(np.diff(there, axis=0)).max(axis=1).cumsum()])
        steps = np.floor(gone / (STEP_IN_CELLS * self.size) + _DEPTH_ROUNDING)
        new = np.append(True, np.diff(steps) > 0)
        new[-1] = True
        return np.flatnonzero(new)

    def _mark(
        self,
        marks: Truths,
        first: Ints,
        part: _MovedPart,
        at: Floats,
        turn: Floats,
        low: Floats,
        high: Floats,
        thinner: float,
    ) -> None:
        """Marks the cells (from `first` on) that are wholly inside a part at a place."""
        size = self.size
        start = np.floor(low / size).astype(np.int64) - first
        stop = np.ceil(high / size).astype(np.int64) - first
        axes = [(np.arange(start[k], stop[k]) + first[k] + 0.5) * size - at[k] for k in range(3)]
        x, y, z = axes[0][:, None, None], axes[1][None, :, None], axes[2][None, None, :]
        own = [turn[0, k] * x + turn[1, k] * y + turn[2, k] * z for k in range(3)]
        depth = part.solid.depth(own[0], own[1], own[2]) - thinner
        window = marks[start[0] : stop[0], start[1] : stop[1], start[2] : stop[2]]
        sure = depth >= HALF_DIAGONAL * size + _DEPTH_ROUNDING
        window |= sure
        if part.solid.convex:  # it is in it if its corners are
            open_ = np.nonzero((depth >= size / 2.0) & ~sure & ~window)
            offsets = (_CELL_CORNERS * size) @ turn
            corners = [own[k][open_][:, None] + offsets[:, k] for k in range(3)]
            deep = part.solid.depth(*corners) - thinner
            window[open_] = deep.min(axis=1) >= _DEPTH_ROUNDING if len(open_[0]) else False


def robot_named(scene: Scene, name: str | None) -> PlacedRobot:
    """A robot of a scene, or its only one. Raises Refused."""
    found = [placed for placed in scene.robots if name is None or placed.name == name]
    if len(found) != 1:
        names = ", ".join(placed.name for placed in scene.robots) or "(none)"
        raise Refused(NO_EXPLORING_ROBOT(name=name or "", names=names), exit_status=2)
    return found[0]


def _box(shape: Shape) -> tuple[Floats, Floats]:
    box = bounding_box(shape)
    return box.middle - box.half, box.middle + box.half


def _bounds(part: _MovedPart, at: Floats, turn: Floats) -> tuple[Floats, Floats]:
    """(n, 3) lowest and highest coordinates of a part in the base; of a capsule without its box."""
    half, middle = (part.high - part.low) / 2.0, (part.low + part.high) / 2.0
    about = at + turn @ middle
    if isinstance(part.part.shape, Capsule):
        shape = part.part.shape
        reach = np.abs(turn[:, :, 2]) * shape.length / 2.0 + shape.radius
    else:
        reach = np.abs(turn) @ half
    return about - reach, about + reach
