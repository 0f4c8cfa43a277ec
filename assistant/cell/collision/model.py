"""The pairs of a scene that could touch, and their distances for rows of joints.

A row holds the joints of all robots of a scene, one after the other, in degrees (mm of an axis that
slides). `Carriers` are the frames that carry bodies: the world, and the links and flanges of
robots.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from itertools import product
from typing import Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats, Rows, norms
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Refused
from assistant.cell.collision.distances import Distances, bounding_box, coal_library
from assistant.cell.findings import CIRCULAR_PARENTS, NO_PARENT
from assistant.cell.scene import (
    FLANGE,
    WORLD,
    Body,
    Part,
    PlacedRobot,
    Scene,
    Shape,
    extent,
    farthest,
)
from assistant.program.geometry import Pose, Vector
from assistant.robots.robot import Robot


@dataclass(frozen=True, eq=False)
class Carriers:
    """Carriers of a scene, numbered: 0 the world, then base, links and flange of each robot.

    robots: in their order. first: of each the number of its base; its links follow.
    columns: of each the slice of its joints in a row.
    """

    robots: tuple[PlacedRobot, ...]

    @cached_property
    def first(self) -> tuple[int, ...]:
        sizes = [len(placed.robot.axes) + 2 for placed in self.robots]
        return tuple(1 + sum(sizes[:i]) for i in range(len(sizes)))

    @cached_property
    def columns(self) -> tuple[slice, ...]:
        ends = np.cumsum([len(placed.robot.axes) for placed in self.robots])
        return tuple(
            slice(end - len(p.robot.axes), end) for p, end in zip(self.robots, ends, strict=True)
        )

    @property
    def joints(self) -> int:
        """Number of joints in a row."""
        return sum(len(placed.robot.axes) for placed in self.robots)

    @cached_property
    def names(self) -> Mapping[str, int]:
        """Numbers of carriers by the names that bodies give as their parents."""
        found = {WORLD: 0}
        for placed, first in zip(self.robots, self.first, strict=True):
            own = ("base", *placed.robot.axes, FLANGE)
            found |= {f"{placed.name}.{name}": first + i for i, name in enumerate(own)}
            if len(self.robots) == 1:
                found |= {name: first + i for i, name in enumerate(own)}
        return found

    def at(self, rows: Floats) -> tuple[Floats, Floats]:
        """Rows (n, j) → origins (n, c, 3) mm, rotations (n, c, 3, 3) of carriers in the world."""
        n, count = len(rows), 1 + sum(len(p.robot.axes) + 2 for p in self.robots)
        origins, turns = np.zeros((n, count, 3)), np.empty((n, count, 3, 3))
        turns[:, 0] = np.eye(3)
        for placed, first, columns in zip(self.robots, self.first, self.columns, strict=True):
            o, t = placed.robot.link_frames(rows[:, columns])
            base = rotations.to_matrix(np.array(placed.base.quaternion))
            own = slice(first + 1, first + 1 + o.shape[1])
            origins[:, first], turns[:, first] = placed.base.position, base
            origins[:, own] = o @ base.T + np.array(placed.base.position)
            turns[:, own] = base @ t
        return origins, turns

    def moved_by(self, carrier: int) -> tuple[int, ...]:
        """Places in a row of the joints that move a carrier."""
        for first, columns, placed in zip(self.first, self.columns, self.robots, strict=True):
            axes = len(placed.robot.axes)
            if first < carrier <= first + axes + 1:
                return tuple(range(columns.start, columns.start + min(carrier - first, axes)))
        return ()

    def reaches(self, carrier: int, pose: Pose, shape: Shape) -> Floats:
        """(j,) how far a point of a carried shape moves at most for a radian (mm) of each joint.

        Joints are those of the chain, see `coupled`. pose: of the shape in the frame of the
        carrier. About the axis that carries it a point moves as far as it is from that line; about
        those before, no farther than the lengths between the axis and the shape add up to, however
        the joints between them turn.
        """
        out = np.zeros(self.joints)
        moving = self.moved_by(carrier)
        if not moving:
            return out
        at = next(i for i, s in enumerate(self.columns) if s.start <= moving[0] < s.stop)
        robot, start = self.robots[at].robot, self.columns[at].start
        if carrier - self.first[at] > len(robot.axes):
            pose = robot.arm.whole_chain.flange @ pose
        steps, own = link_lengths(robot), moving[-1] - start
        last = float(farthest(shape, np.array(pose.inverse().position)[None])[0])
        for place in moving:
            axis = place - start
            out[place] = 1.0 if robot.sliding[axis] else steps[axis + 1 : own + 1].sum() + last
        if not robot.sliding[own]:
            out[moving[-1]] = min(last, _from_axis(robot, own, pose, shape))
        return out

    def coupled(self, chain: Floats) -> Floats:
        """Convert displacements (j, ...) per joint of the chain to those per joint of rows."""
        out = chain.copy()
        for placed, columns in zip(self.robots, self.columns, strict=True):
            if placed.robot.coupling:  # J2 also turns what J3 turns
                second = columns.start + 1
                out[second] += abs(placed.robot.coupling) * chain[second + 1]
        return out


def _from_axis(robot: Robot, axis: int, pose: Pose, shape: Shape) -> float:
    """Mm that a point of a shape is away from the axis whose link carries it, at most."""
    along = np.array(robot.arm.whole_chain.joints[axis].axis)
    low, high = extent(shape)
    corners = np.array(list(product(*zip(low, high, strict=True))))
    placed = rotations.rotate(np.array(pose.quaternion), corners) + np.array(pose.position)
    return float(norms(np.cross(placed, along / np.linalg.norm(along))).max())


def link_lengths(robot: Robot) -> Floats:
    """(a + 1,) mm between the frames of links that follow each other, at most, base to flange."""
    chain = robot.arm.whole_chain
    poses = [*(joint.pose for joint in chain.joints), chain.flange]
    out = norms(np.array([pose.position for pose in poses]))
    for i, slides in enumerate(robot.sliding):
        if slides:  # the frame of the link slides away from its axis
            out[i] += np.abs(robot.limits[i] + robot.zero[i]).max()
    return np.asarray(out)


def carrier_of(scene: Scene, body: Body, carriers: Carriers) -> tuple[int, Pose]:
    """Return the carrier of a body, and the body's pose in the frame of the carrier.

    Raises Refused for a parent that is not in the scene, or that the body itself carries.
    """
    pose, parent, seen = body.pose, body.parent, {body.name}
    while parent not in carriers.names:
        if parent in seen:
            raise Refused(CIRCULAR_PARENTS(name=body.name, parent=parent), exit_status=2)
        seen.add(parent)
        if parent in scene.frames:
            return 0, scene.frames[parent] @ pose
        upper = scene.body(parent)
        if upper is None:
            known = _listed([*carriers.names, *scene.frames])
            raise Refused(NO_PARENT(name=body.name, parent=parent, known=known), exit_status=2)
        pose, parent = upper.pose @ pose, upper.parent
    return carriers.names[parent], pose


def _listed(names: Sequence[str]) -> str:
    return ", ".join(f"`{name}`" for name in names[:12])


_PAIRS_AT_ONCE: Final = 200_000
"""Rows times pairs whose bounds are worked out together."""
_FARTHEST: Final = 1e9
"""mm that no distance in a cell is larger than."""


@dataclass(frozen=True, eq=False)
class Item:
    """A part of a body: what carries it, its pose there, and the box around it.

    middle: (3,) of the box in the frame of the carrier. radius: mm of the sphere about it.
    """

    body: Body
    part: Part
    carrier: int
    pose: Pose
    middle: Floats
    half: Floats
    radius: float


@dataclass(frozen=True, slots=True)
class Contact:
    """Distance between two bodies.

    distance: mm, negative by the penetration depth as far as it is known. points: on the one and on
    the other, in the world. normal: from the one to the other.
    """

    one: str
    other: str
    distance: float
    points: tuple[Vector, Vector]
    normal: Vector


class Model:
    """A scene as pairs of items that could touch.

    Left out: what moves together, what may touch by the scene, and two bodies of the world.
    Raises Refused for a body whose parent is not there, and without coal for shapes whose distance
    has no closed form.
    """

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.carriers = Carriers(scene.robots)
        self.items = tuple(self._items())
        pairs = [
            (i, k)
            for i in range(len(self.items))
            for k in range(i + 1, len(self.items))
            if self._could_touch(self.items[i], self.items[k])
        ]
        self.one: Rows = np.array([i for i, _ in pairs], dtype=np.intp)
        self.other: Rows = np.array([k for _, k in pairs], dtype=np.intp)
        self.margins: Floats = np.array([self._margin(i, k) for i, k in pairs])
        self.distances = Distances([item.part.shape for item in self.items])
        if not self.distances.closed(self.one, self.other).all():
            coal_library()

    def __len__(self) -> int:
        """Return the number of pairs."""
        return len(self.one)

    def _items(self) -> Iterator[Item]:
        for body in self.scene.all_bodies():
            carrier, pose = carrier_of(self.scene, body, self.carriers)
            for part in body.parts:
                placed = pose @ part.pose
                box = bounding_box(part.shape)
                middle = placed @ Pose((box.middle[0], box.middle[1], box.middle[2]))
                yield Item(
                    body,
                    part,
                    carrier,
                    placed,
                    np.array(middle.position),
                    box.half,
                    box.radius,
                )

    def _could_touch(self, one: Item, other: Item) -> bool:
        """A flange moves with the last link, and a base does not move."""
        moves = [self.carriers.moved_by(item.carrier) for item in (one, other)]
        return moves[0] != moves[1] and not self.scene.may_touch(one.body.name, other.body.name)

    def _margin(self, one: int, other: int) -> float:
        said = (self.items[i].body.margin for i in (one, other))
        return max(self.scene.margin if margin is None else margin for margin in said)

    # ------------------------------------------------------------------------------- bounds

    @cached_property
    def leverage(self) -> Floats:
        """(j, p) mm that the items of a pair come nearer at most for a degree (mm) of each joint.

        Joints that move both the same way do not count.
        """
        reaches = np.array(
            [self.carriers.reaches(i.carrier, i.pose, i.part.shape) for i in self.items]
        ).reshape(len(self.items), self.carriers.joints)
        moving = np.zeros_like(reaches, dtype=bool)
        for number, item in enumerate(self.items):
            moving[number, list(self.carriers.moved_by(item.carrier))] = True
        both = moving[self.one] & moving[self.other]
        chain = np.where(both, 0.0, reaches[self.one] + reaches[self.other]).T
        total = self.carriers.coupled(chain)
        sliding = [placed.robot.sliding for placed in self.scene.robots]
        turning = ~np.concatenate(sliding) if sliding else np.zeros(0, dtype=bool)
        total[turning] = np.radians(total[turning])
        return np.asarray(total)

    def least(self, rows: Floats) -> Floats:
        """(n, p) mm that the items of each pair are apart at least, for rows (n, j) of joints."""
        row, pair = np.divmod(np.arange(len(rows) * len(self)), max(len(self), 1))
        return self.least_of(rows, row, pair).reshape(len(rows), len(self))

    def least_of(self, rows: Floats, row: Rows, pair: Rows) -> Floats:
        """(k,) mm that the items of pairs (k,) are apart at least, each for one of rows (n, j)."""
        origins, turns = self.carriers.at(rows)
        one, other = self.one[pair], self.other[pair]
        middle, box = self._boxes(origins, turns, row, one)
        middle_of, box_of = self._boxes(origins, turns, row, other)
        way = (middle_of - middle)[:, None]
        apart = [
            _beyond(way @ box_of, self._halves[other]) - self._radii[one],
            _beyond(way @ box, self._halves[one]) - self._radii[other],
        ]
        return np.asarray(np.maximum(*apart) - self._off[pair])

    def beyond(self, item: int, origins: Floats, turns: Floats, point: Floats) -> float:
        """Mm from a point (3,) of the world to the box around an item, 0 inside.

        origins (c, 3), turns (c, 3, 3): of the carriers.
        """
        row, one = np.zeros(1, dtype=np.intp), np.array([item])
        middle, box = self._boxes(origins[None], turns[None], row, one)
        return float(_beyond((point - middle)[:, None] @ box, self._halves[one])[0])

    def _boxes(
        self, origins: Floats, turns: Floats, row: Rows, item: Rows
    ) -> tuple[Floats, Floats]:
        """Middles (k, 3) and axes (k, 3, 3) of the boxes around items (k,) for rows (k,)."""
        count = len(self.items)
        if len(row) > len(origins) * count:  # of each item once, then
            rows, items = np.divmod(np.arange(len(origins) * count), count)
            middles, boxes = self._boxes(origins, turns, rows, items)
            return middles[row * count + item], boxes[row * count + item]
        carrier = self._carriers[item]
        frame = turns[row, carrier]
        middle = origins[row, carrier] + np.einsum("kpq,kq->kp", frame, self._middles[item])
        return middle, frame @ self._turns[item]

    @cached_property
    def _carriers(self) -> Rows:
        return np.array([item.carrier for item in self.items], dtype=np.intp)

    @cached_property
    def _positions(self) -> Floats:
        return np.array([item.pose.position for item in self.items]).reshape(-1, 3)

    @cached_property
    def _radii(self) -> Floats:
        return np.array([item.radius for item in self.items])

    @cached_property
    def _middles(self) -> Floats:
        return np.array([item.middle for item in self.items]).reshape(-1, 3)

    @cached_property
    def _halves(self) -> Floats:
        return np.array([item.half for item in self.items]).reshape(-1, 3)

    @cached_property
    def _turns(self) -> Floats:
        """(i, 3, 3) of items in the frames of what carries them."""
        q = np.array([item.pose.quaternion for item in self.items]).reshape(-1, 4)
        return rotations.to_matrix(q)

    # ---------------------------------------------------------------------------- distances

    def exact(self, rows: Floats, row: Rows, pair: Rows) -> Floats:
        """(k,) distances in mm of pairs (k,), each for one of rows (n, j) of joints, row (k,)."""
        origins, turns = self.carriers.at(rows)
        return self.exact_at(origins, turns, row, pair)

    def exact_at(self, origins: Floats, turns: Floats, row: Rows, pair: Rows) -> Floats:
        """Return `exact` for carriers in the form that `Carriers.at` returns."""
        one, other = self.one[pair], self.other[pair]
        ends = [self._placed(origins, turns, row, item) for item in (one, other)]
        found = self.distances.signed(one, other, *ends)
        # A library answers with the largest number, either way, where it finds no two points.
        return np.asarray(np.clip(found, -_FARTHEST, _FARTHEST) - self._off[pair])

    def _placed(
        self, origins: Floats, turns: Floats, row: Rows, item: Rows
    ) -> tuple[Floats, Floats]:
        """Places (k, 3) and turns (k, 3, 3) of items (k,) for rows (k,) of where carriers are."""
        carrier = self._carriers[item]
        frame = turns[row, carrier]
        place = origins[row, carrier] + np.einsum("kpq,kq->kp", frame, self._positions[item])
        return place, frame @ self._turns[item]

    @cached_property
    def _off(self) -> Floats:
        """(p,) mm that shapes of a pair may be nearer than they seem, as they were simplified."""
        off = np.array([getattr(item.part.shape, "off", 0.0) for item in self.items])
        return np.asarray(off[self.one] + off[self.other])

    def nearest(self, rows: Floats) -> tuple[Floats, Rows]:
        """Rows (n, j) → the least distance (n,) of any pair, inf without pairs, and which (n,)."""
        size = max(_PAIRS_AT_ONCE // max(len(self), 1), 1)
        blocks = [self._nearest(rows[i : i + size]) for i in range(0, max(len(rows), 1), size)]
        best, which = zip(*blocks, strict=True)
        return np.concatenate(best), np.concatenate(which)

    def _nearest(self, rows: Floats) -> tuple[Floats, Rows]:
        best = np.full(len(rows), np.inf)
        which = np.full(len(rows), -1)
        if not len(self) or not len(rows):
            return best, which
        least = self.least(rows)
        origins, turns = self.carriers.at(rows)
        order = np.argsort(least, axis=1)
        for place in range(len(self)):
            pair = order[:, place]
            open_ = np.flatnonzero(least[np.arange(len(rows)), pair] < best)
            if not len(open_):
                break
            found = self.exact_at(origins, turns, open_, pair[open_])
            nearer = found < best[open_]
            best[open_[nearer]], which[open_[nearer]] = found[nearer], pair[open_[nearer]]
        return best, which

    def contact(self, joints: Floats, pair: int) -> Contact:
        """Return the contact of a pair for joints (j,)."""
        origins, turns = self.carriers.at(joints[None])
        one, other = self.items[self.one[pair]], self.items[self.other[pair]]
        row = np.zeros(1, dtype=np.intp)
        numbers = int(self.one[pair]), int(self.other[pair])
        ends = [self._placed(origins, turns, row, np.array([number])) for number in numbers]
        found = self.distances.nearest(*numbers, *ends)
        return Contact(
            one.body.name,
            other.body.name,
            float(found.distance[0] - self._off[pair]),
            (_vector(found.one[0]), _vector(found.other[0])),
            _vector(found.normal[0]),
        )


def _beyond(points: Floats, half: Floats) -> Floats:
    """(k,) distances of points (k, 1, 3) from boxes with half edges (k, 3) about the origin."""
    return norms(np.maximum(np.abs(points[:, 0]) - half, 0.0))


def _vector(values: Floats) -> Vector:
    x, y, z = (float(v) + 0.0 for v in values)
    return x, y, z
