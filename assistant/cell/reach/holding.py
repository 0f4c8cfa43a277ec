"""The best way to hold an arm at each of many poses: which branch, which turn of the tool.

Best is the way with the most room: the least of how far its axes are from their limits, the arm
from its singularities, and everything that it moves from everything else, each as a share of what
is enough (`ENOUGH_…`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats, Rows, Truths
from assistant.cell.planning.space import Space
from assistant.cell.reach.singularities import distance_from_singularity
from assistant.program.geometry import IDENTITY, Pose
from assistant.robots.robot import Robot

ENOUGH_LIMITS: Final = 0.1
"""Of the range of an axis between it and its nearer limit."""
ENOUGH_AWAY: Final = 0.1
"""See `singularities.away`: axis 5 of a wrist some 8 degrees from straight."""
ENOUGH_CLEAR: Final = 50.0
"""mm beyond the margins."""
POSES_AT_ONCE: Final = 40_000
"""Poses of the flange that are solved at once."""
PAIRS_AT_ONCE: Final = 400_000
"""Rows times pairs whose bounds are worked out at once."""


@dataclass(frozen=True, slots=True, eq=False)
class Postures:
    """How an arm is held at n places.

    joints: (n, a) of the best way; where it is only `touching`, of what would be it without bodies;
    NaN where there is none. turn: (n,) of the orientations of the place which it has, -1 for none.
    room: (n,) 0 to 1, NaN for none. limits: (n,) share of the range of the axis that is nearest to
    a limit; away: (n,) from singularities; clearance: (n,) mm beyond the margins, `ENOUGH_CLEAR`
    for all above, inf where no bodies are looked at. touching: (n,) whether it is reached inside
    the limits, but nowhere with the margins kept.
    """

    joints: Floats
    turn: Rows
    room: Floats
    limits: Floats
    away: Floats
    clearance: Floats
    touching: Truths

    @property
    def reached(self) -> Truths:
        """(n,) whether there is a way."""
        return np.asarray(self.turn >= 0)

    @staticmethod
    def joined(parts: list[Postures]) -> Postures:
        columns = (np.concatenate([getattr(p, name) for p in parts]) for name in Postures.__slots__)
        return Postures(*columns)


def best_postures(
    robot: Robot,
    positions: Floats,
    quaternions: Floats,
    space: Space | None = None,
    tip: Pose = IDENTITY,
) -> Postures:
    """The best ways to hold the tip of a tool at places.

    positions: (n, 3) mm of the tip, in the base of the robot. quaternions: (n, k, 4), of which one
    is enough, or (k, 4) for all places. space: in which nothing may come nearer than its margins,
    None for limits alone. tip: in the flange.
    """
    quaternions = np.asarray(quaternions, dtype=np.float64)
    if quaternions.ndim == 2:
        quaternions = np.broadcast_to(quaternions, (len(positions), *quaternions.shape))
    size = max(POSES_AT_ONCE // max(quaternions.shape[1], 1), 1)
    parts = [
        _best_postures(robot, positions[i : i + size], quaternions[i : i + size], space, tip)
        for i in range(0, max(len(positions), 1), size)
    ]
    return Postures.joined(parts)


def _best_postures(
    robot: Robot, positions: Floats, quaternions: Floats, space: Space | None, tip: Pose
) -> Postures:
    ways = _Candidates(robot, positions, quaternions, tip)
    n = len(positions)
    rows = np.arange(n)
    best, which, clear = np.full(n, -1.0), np.full(n, -1), np.full(n, np.nan)
    for place in range(ways.room.shape[1]):
        way = ways.order[:, place]
        most = ways.room[rows, way]
        open_ = np.flatnonzero(most > best)  # the ways are in order: no later one is better
        if not len(open_):
            break
        way, found = way[open_], np.full(len(open_), np.inf)
        if space is not None:
            found = clearances(space, ways.joints[open_, way])
        room = np.where(found > 0.0, np.minimum(most[open_], found / ENOUGH_CLEAR), -1.0)
        better = room > best[open_]
        rows_better = open_[better]
        best[rows_better], which[rows_better] = room[better], way[better]
        clear[rows_better] = found[better]
    none = which < 0

    def chosen(values: Floats) -> Floats:
        out: Floats = values[rows, which]
        out[none] = np.nan
        return out

    turn = np.where(none, -1, which // robot.branches)
    touching = none & (ways.room >= 0.0).any(axis=1)
    room = np.where(none, np.nan, best)
    limits, away_, joints = chosen(ways.limits), chosen(ways.away), chosen(ways.joints)
    joints[touching] = ways.joints[touching, ways.order[touching, 0]]
    return Postures(joints, turn, room, limits, away_, clear, touching)


class _Candidates:
    """All ways (n, k * b) to hold an arm at n places with k orientations in b branches.

    room: 0 to 1 without regard to bodies, -1 where there is none. order: from most to least of it.
    """

    def __init__(self, robot: Robot, positions: Floats, quaternions: Floats, tip: Pose) -> None:
        n, k = quaternions.shape[:2]
        back = tip.inverse()
        q = quaternions.reshape(-1, 4)
        p = np.repeat(positions, k, axis=0) + rotations.rotate(q, np.array(back.position))
        joints, valid = robot.ik(p, rotations.multiply(q, np.array(back.quaternion)))
        self.joints = joints.reshape(n, k * robot.branches, -1)
        valid = valid.reshape(n, -1)
        self.limits = np.where(valid, limit_shares(robot, self.joints), np.nan)
        self.away = np.full(valid.shape, np.nan)
        self.away[valid] = distance_from_singularity(robot, self.joints[valid], tip)
        least = np.minimum(self.limits / ENOUGH_LIMITS, self.away / ENOUGH_AWAY)
        self.room = np.where(valid, np.clip(least, 0.0, 1.0), -1.0)
        self.order = np.argsort(-self.room, axis=1, kind="stable")


def limit_shares(robot: Robot, joints: Floats) -> Floats:
    """(..., a) joints → (...) the least share of the range of an axis to its nearer limit."""
    low, high = robot.limits.T
    least = np.minimum(joints - low, high - joints)
    whole = np.broadcast_to(high - low, least.shape)
    near = np.where(np.isfinite(whole), least / np.where(np.isfinite(whole), whole, 1.0), 0.5)
    return np.asarray(np.maximum(near.min(axis=-1), 0.0))


def nearest_bodies(space: Space, row: Floats) -> tuple[str, str]:
    """The two bodies that keep least of their margin with the robot at joints (a,)."""
    model = space.model
    pair = int(np.argmin(space.distances(row) - space.margins))
    one, other = (model.items[i].body.name for i in (model.one[pair], model.other[pair]))
    return one, other


def clearances(space: Space, rows: Floats, most: float = ENOUGH_CLEAR) -> Floats:
    """(n, a) joints → (n,) mm that everything is apart beyond its margin, `most` for all above.

    Of two bodies of the robot itself it only counts whether they keep their margin: how far its
    links are apart says nothing of the room about it.
    """
    own = _own(space)
    size = max(PAIRS_AT_ONCE // max(len(space.model), 1), 1)
    parts = [_clearances(space, own, rows[i : i + size], most) for i in range(0, len(rows), size)]
    return np.concatenate(parts) if parts else np.zeros(0)


def _own(space: Space) -> Truths:
    """(p,) which pairs are of the robot alone: of its links, and of what they carry."""
    model = space.model
    at = model.scene.robots.index(space.placed)
    first = model.carriers.first[at]
    last = first + len(space.robot.axes) + 1
    carrier = np.array([item.carrier for item in model.items], dtype=np.intp)
    mine = (carrier >= first) & (carrier <= last)
    return np.asarray(mine[model.one] & mine[model.other])


def _clearances(space: Space, own: Truths, rows: Floats, most: float) -> Floats:
    joints = space.all_joints(rows)
    out = np.full(len(rows), most)
    bounds = space.model.least(joints) - space.margins
    near = np.where(space.moved, np.where(own, 0.0, most), -np.inf)
    row, pair = np.nonzero(bounds < near)
    if len(row):
        found = space.model.exact(joints, row, pair) - space.margins[pair]
        found[own[pair] & (found > 0.0)] = most
        np.minimum.at(out, row, found)
    return out
