"""The joint space of one robot of a cell: free positions, free straight moves, and goals.

A straight move is divided until each part is proven: nothing comes nearer on a part than in its
middle, less what it can move from there to an end (`Model.leverage`). A move that is not proven in
parts in which nothing moves more than `_FINEST` counts as not free. A pose of the tool has a goal
for each arm branch, with every whole turn of the axes inside their limits.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from itertools import product
from typing import Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats, Rows, Truths
from assistant.base.data_classes import dataclass
from assistant.cell.collision.continuous import RESOLUTION, Hit, JointPath, hits
from assistant.cell.collision.model import Contact, Model
from assistant.cell.scene import PlacedRobot, Scene
from assistant.program.geometry import IDENTITY, Pose, Vector
from assistant.robots.robot import Robot
from assistant.robots.timing.uninterrupted_moves import Stretches

_FINEST: Final = 0.1
"""Largest movement in mm of any body in the shortest part of a move that is examined."""
_COARSEST: Final = 120.0
"""mm that anything moves in the parts that a move is cut into at first."""
_MOST_PARTS: Final = 64
"""Parts that a move is cut into at first, at most."""
_COARSEST_TURN: Final = 10.0
"""degrees that the tool turns in the parts that a move is cut into at first for its tilt."""
_FINEST_TURN: Final = 0.05
"""Turn of the tool in degrees in the shortest part of a move whose tilt is examined."""


@dataclass(frozen=True, slots=True)
class Cone:
    """Limit of the tilt of the tool: one of its axes by at most `angle` degrees from a direction.

    direction: in the base of the robot. axis: in the frame of the tip, z by default; both of any
    length but 0.
    """

    direction: Vector
    angle: float
    axis: Vector = (0.0, 0.0, 1.0)

    def axes(self, quaternions: Floats) -> Floats:
        """(n, 3) where the axes of tools (n, 4) point to, of length 1."""
        axis = np.array(self.axis, dtype=np.float64)
        return np.asarray(rotations.to_matrix(quaternions) @ (axis / np.linalg.norm(axis)))

    def tilt(self, quaternions: Floats) -> Floats:
        """(n,) degrees by which the axes of tools (n, 4) are tilted."""
        direction, axes = np.array(self.direction, dtype=np.float64), self.axes(quaternions)
        along, across = axes @ direction, np.linalg.norm(np.cross(axes, direction), axis=1)
        return np.asarray(np.degrees(np.arctan2(across, along)))


class Space:
    """A robot of a scene that moves while all others stand.

    others: (a,) joints by the names of other robots; those that it does not name stand at home.
    margin: mm that is kept everywhere, None for the margins of the scene. tool: the tip in the
    flange, whose tilt the cone is about.
    """

    def __init__(
        self,
        scene: Scene,
        placed: PlacedRobot,
        *,
        others: Mapping[str, Floats] | None = None,
        margin: float | None = None,
        cone: Cone | None = None,
        tool: Pose = IDENTITY,
    ) -> None:
        self.model, self.placed, self.robot = Model(scene), placed, placed.robot
        self.cone, self.tool = cone, tool
        at = next(i for i, one in enumerate(scene.robots) if one is placed)
        self.columns = self.model.carriers.columns[at]
        where = others or {}
        still = [np.asarray(where.get(p.name, p.robot.home), np.float64) for p in scene.robots]
        self._still = np.concatenate(still)
        self.moved: Truths = np.asarray((self.model.leverage[self.columns] > 0.0).any(axis=0))
        margins = self.model.margins if margin is None else np.full(len(self.model), margin)
        self.margins: Floats = np.where(self.moved, margins, -np.inf)
        self.asked = 0

    @cached_property
    def weights(self) -> Floats:
        """(a,) seconds that an axis takes for a degree (mm): moves are as long as they last."""
        return np.asarray(1.0 / self.robot.speeds)

    @cached_property
    def turning(self) -> Floats:
        """(a,) degrees that the tool turns at most with a degree of each axis, 0 if it slides."""
        out = np.where(self.robot.sliding, 0.0, 1.0)
        if self.robot.coupling:
            out[1] += abs(self.robot.coupling)
        return out

    def length(self, one: Floats, other: Floats) -> Floats:
        """Joints (…, a) → (…) how far apart they are, in seconds of the axes together."""
        return np.asarray(np.linalg.norm((other - one) * self.weights, axis=-1))

    def all_joints(self, rows: Floats) -> Floats:
        """Joints (n, a) of the robot → (n, j) of all robots."""
        out = np.tile(self._still, (len(rows), 1))
        out[:, self.columns] = rows
        return out

    def tip(self, rows: Floats) -> tuple[Floats, Floats]:
        """Joints (n, a) → the tool in the base: positions (n, 3) mm, quaternions (n, 4)."""
        p, q = self.robot.flange_poses(rows)
        turn = rotations.to_matrix(q)
        turned = rotations.multiply(q, np.array(self.tool.quaternion))
        return p + turn @ np.array(self.tool.position), turned

    def distances(self, row: Floats) -> Floats:
        """(p,) mm of every pair with the robot at joints (a,); inf of those it does not move."""
        out = np.full(len(self.model), np.inf)
        pairs = np.flatnonzero(self.moved)
        if len(pairs):
            none = np.zeros(len(pairs), dtype=np.intp)
            out[pairs] = self.model.exact(self.all_joints(row[None]), none, pairs)
        return out

    def contact(self, row: Floats, pair: int) -> Contact:
        return self.model.contact(self.all_joints(row[None])[0], pair)

    def hits(self, rows: Floats) -> list[Hit]:
        """Return the hits on the path through joints (n, a) closer than the margins, by
        `continuous`.
        """
        return hits(self.model, JointPath(self.all_joints(rows)), self.margins)

    def free(self, rows: Floats) -> Truths:
        """(n,) whether the places of joints (n, a) are inside the limits, tilt and margins."""
        return np.asarray(self.robot.inside(rows) & self.clear(rows, rows))

    def way(self, stretches: Stretches) -> JointPath:
        """The way of a plan of the robot, as `hits` takes it."""
        slack = np.zeros((len(stretches.slack), len(self._still)))
        slack[:, self.columns] = stretches.slack

        def curve(stretch: Rows, part: Floats) -> tuple[Floats, Truths]:
            joints, exact = stretches.between(stretch, part)
            return self.all_joints(joints), exact

        return JointPath(self.all_joints(stretches.joints), slack, curve)

    def clear(self, starts: Floats, ends: Floats, room: float = 0.0) -> Truths:
        """(n,) whether the straight moves from joints (n, a) to (n, a) keep margins and tilt.

        room: mm that is kept beyond the margins; with some, the tool keeps off the edge of its cone
        as well.
        """
        out = np.ones(len(starts), dtype=bool)
        self.asked += len(starts)
        if self.cone is not None:
            off = min(_CONE_EDGE, self.cone.angle / 5.0) if room else 0.0
            out = self.upright(starts, ends, TILT_TOLERANCE - off)
        if len(self.model):
            some = np.flatnonzero(out)
            out[some] = self.apart(starts[some], ends[some], room)
        return out

    def apart(self, starts: Floats, ends: Floats, room: float = 0.0) -> Truths:
        """(n,) whether the straight moves from joints (n, a) to (n, a) keep the margins."""
        out = np.ones(len(starts), dtype=bool)
        lever = self.model.leverage[self.columns]
        limit = (
            self.margins + RESOLUTION + room
        )  # what `hits` calls clear is that much farther away
        step = ends - starts
        whole = np.abs(step) @ lever  # (n, p) mm
        most = whole.max(axis=1, initial=0.0, where=self.moved)
        parts = np.clip(np.ceil(most / _COARSEST), 1, _MOST_PARTS).astype(np.intp)
        edge, half, middle = _halves(parts)
        while len(edge):
            rows = self.all_joints(starts[edge] + middle[:, None] * step[edge])
            moved = whole[edge] * half[:, None]
            k, pair = np.nonzero(self.model.least(rows) <= limit + moved)
            apart = self.model.exact(rows, k, pair)
            out[edge[k[apart <= limit[pair]]]] = False
            near = apart <= limit[pair] + moved[k, pair]
            out[edge[k[near & (moved[k, pair] <= _FINEST / 2.0)]]] = False
            again = np.unique(k[near])
            again = again[out[edge[again]]]
            edge, half = np.repeat(edge[again], 2), np.repeat(half[again] / 2.0, 2)
            middle = np.repeat(middle[again], 2) + half * np.tile([-1.0, 1.0], len(again))
        return out

    def tilt(self, rows: Floats) -> Floats:
        """(n,) degrees by which the tool is tilted from the cone's direction; 0 without one."""
        return np.zeros(len(rows)) if self.cone is None else self.cone.tilt(self.tip(rows)[1])

    def upright(
        self, starts: Floats, ends: Floats, beyond: float | None = None, slack: Floats | None = None
    ) -> Truths:
        """Return (n,) whether the tool stays in the cone: it tilts by no more than it turns.

        beyond: degrees by which it may be tilted further, `TILT_TOLERANCE` by default. slack: (n,
        a) how far the joints may be from a straight move.
        """
        if self.cone is None:
            return np.ones(len(starts), dtype=bool)
        most = self.cone.angle + (TILT_TOLERANCE if beyond is None else beyond)
        off = np.zeros(len(starts)) if slack is None else slack @ self.turning
        out = np.ones(len(starts), dtype=bool)
        step = ends - starts
        whole = np.abs(step) @ self.turning
        parts = np.clip(np.ceil(whole / _COARSEST_TURN), 1, _MOST_PARTS).astype(np.intp)
        edge, half, middle = _halves(parts)
        while len(edge):
            tilt = self.tilt(starts[edge] + middle[:, None] * step[edge])
            turned = whole[edge] * half
            out[edge[tilt + off[edge] > most]] = False
            near = tilt + off[edge] + turned > most
            out[edge[near & (turned <= _FINEST_TURN)]] = False
            again = np.flatnonzero(near & out[edge])
            edge, half = np.repeat(edge[again], 2), np.repeat(half[again] / 2.0, 2)
            middle = np.repeat(middle[again], 2) + half * np.tile([-1.0, 1.0], len(again))
        return out


def _halves(parts: Rows) -> tuple[Rows, Floats, Floats]:
    """Moves cut into parts (n,): for each part its move, half its share of that, and its middle."""
    edge = np.repeat(np.arange(len(parts)), parts)
    first = np.repeat(np.cumsum(parts) - parts, parts)
    half = 0.5 / parts[edge]
    return edge, half, (2.0 * (np.arange(len(edge)) - first) + 1.0) * half


_CONE_EDGE: Final = 1.0
"""degrees inside the edge of a cone, at most a fifth of it, that leave room for corners."""
TILT_TOLERANCE: Final = 0.1
"""degrees that a tool may be tilted beyond its cone: targets at its edge are rounded."""


_MOST_GOALS: Final = 64
"""Ways that are tried, of those nearest to where the arm comes from."""
_SAME_JOINTS: Final = 1e-3
"""degrees (mm) by which two ways differ at least."""


def goal_joints(robot: Robot, pose: Pose, near: Floats, tool: Pose = IDENTITY) -> Floats:
    """Return the joints (k, a) that hold the tip of a tool at a pose, inside the limits, the
    nearest first.

    pose: in the base of the robot. near: (a,) joints from which the arm starts. tool: the tip in
    the flange. Each further turn of an axis that its limits allow is a separate solution.
    """
    flange = pose @ tool.inverse()
    joints, valid = robot.ik([flange.position], [flange.quaternion])
    found: list[Floats] = []
    for row in joints[0][valid[0]]:
        found += _with_whole_turns(robot, row)
    some = np.array(found).reshape(-1, len(robot.axes))
    order = np.argsort(np.linalg.norm((some - near) / robot.speeds, axis=1), kind="stable")
    out: list[Floats] = []
    for row in some[order]:
        if all(np.abs(row - other).max() > _SAME_JOINTS for other in out):
            out.append(row)
    return np.array(out[:_MOST_GOALS]).reshape(-1, len(robot.axes))


def _with_whole_turns(robot: Robot, row: Floats) -> list[Floats]:
    """A row of joints with every whole turn of its axes that is inside the limits."""
    low, high = robot.limits.T
    turns = []
    for axis in range(len(row)):
        if robot.sliding[axis] or axis not in robot.winding():
            turns.append([0.0])
            continue
        # Axes without an end are turned once at most.
        least = max(-1.0, np.ceil((low[axis] - row[axis]) / 360.0 - 1e-9))
        most = min(1.0, np.floor((high[axis] - row[axis]) / 360.0 + 1e-9))
        turns.append([360.0 * k for k in np.arange(least, most + 0.5)])
    rows = [row + np.array(turn) for turn in product(*turns)]
    return [one for one in rows if bool(robot.inside(one))]
