"""Reach maps: the part of a region that an arm reaches, with given directions of its tool.

A region is a grid of points. At each pose the arm is held in the best way, which is the branch and
the turn of the tool with the most room: the least of the distance of its axes from their limits, of
the arm from its singularities, and of everything that it moves from everything else, each as a
share of what is enough (`ENOUGH_…`).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats, Rows, Truths, evenly_spaced
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Refused
from assistant.cell.findings import NO_DIRECTION, NO_REGION, NO_TURNS, TOO_MANY_POINTS
from assistant.cell.planning.space import Space
from assistant.cell.scene import PlacedRobot, Scene
from assistant.program.geometry import IDENTITY, Pose
from assistant.robots.arms.arm import rotation_from_z
from assistant.robots.motion.singularities import distance_from_singularity
from assistant.robots.robot import Robot

ENOUGH_LIMITS: Final = 0.1
"""Sufficient distance of an axis to its nearer limit, as a share of its range."""
ENOUGH_AWAY: Final = 0.1
"""See `distance_from_singularity`: axis 5 of a wrist some 8 degrees from straight."""
ENOUGH_CLEAR: Final = 50.0
"""mm beyond the margins."""
_POSES_AT_ONCE: Final = 40_000
"""Poses of the flange that are solved at once."""
_PAIRS_AT_ONCE: Final = 400_000
"""Rows times pairs whose bounds are worked out at once."""


@dataclass(frozen=True, slots=True, eq=False)
class Postures:
    """Postures of an arm at n positions.

    joints: (n, a) of the best solution; where the arm is only `touching`, of the best solution
    without bodies; NaN if there is no solution. turn: (n,) index of its orientation among those of
    the position, -1 if missing. room: (n,) 0 to 1, NaN if missing. limits: (n,) share of the range
    of the axis that is nearest to a limit; away: (n,) from singularities; clearance: (n,) mm beyond
    the margins, `ENOUGH_CLEAR` for all above, inf if no bodies are checked. touching: (n,) whether
    it is reached inside the limits, but nowhere with the margins kept.
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
    size = max(_POSES_AT_ONCE // max(quaternions.shape[1], 1), 1)
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
    """All solutions (n, k * b) of an arm at n positions with k orientations in b branches.

    room: 0 to 1 without regard to bodies, -1 if there is no solution. order: from most to least
    room.
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


def _nearest_bodies(space: Space, row: Floats) -> tuple[str, str]:
    """The two bodies that keep least of their margin with the robot at joints (a,)."""
    model = space.model
    pair = int(np.argmin(space.distances(row) - space.margins))
    one, other = (model.items[i].body.name for i in (model.one[pair], model.other[pair]))
    return one, other


def clearances(space: Space, rows: Floats, most: float = ENOUGH_CLEAR) -> Floats:
    """Return (n,) mm that everything is apart beyond its margin for (n, a) joints, `most` for all
    above.

    Two bodies of the robot itself count only if they do not keep their margin: the distance between
    its links does not describe the room around it.
    """
    own = _own(space)
    size = max(_PAIRS_AT_ONCE // max(len(space.model), 1), 1)
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


_MOST_POINTS: Final = 200_000
"""Largest number of points, or placements, that are examined."""
_MOST_TURNS: Final = 360
_CONE_DIRECTIONS: Final = 8
"""Directions about the middle of a cone."""
_NAMED_DIRECTIONS: Final = {"down": (0.0, 0.0, -1.0), "up": (0.0, 0.0, 1.0)}


@dataclass(frozen=True, slots=True)
class NumberRange:
    """Numbers from low to high: low, low + step … as far as high. step 0: low alone."""

    low: float
    high: float
    step: float

    def values(self) -> Floats:
        if self.step == 0.0:
            return np.array([self.low])
        return np.asarray(self.low + self.step * np.arange(self.count))

    @property
    def count(self) -> int:
        """A little rounding does not lose the last one."""
        return 1 if self.step == 0.0 else int((self.high - self.low) / self.step + 1e-9) + 1


def parse_range(text: str, what: str) -> NumberRange:
    """`LOW:HIGH:STEP`, or one number; raises Refused."""
    parts = text.split(":")
    try:
        numbers = [float(part) for part in parts]
    except ValueError:
        numbers = []
    if len(numbers) == 1 and np.isfinite(numbers).all():
        return NumberRange(numbers[0], numbers[0], 0.0)
    if len(numbers) == 3 and np.isfinite(numbers).all():
        low, high, step = numbers
        if high >= low and step > 0.0 and np.isfinite((high - low) / step):
            if (high - low) / step > _MOST_POINTS:
                raise Refused(
                    TOO_MANY_POINTS(
                        count=int((high - low) / step), what=f"steps of {what}", most=_MOST_POINTS
                    ),
                    exit_status=2,
                )
            return NumberRange(low, high, step)
    raise Refused(NO_REGION(what=f"no region with {what} = `{text}`"), exit_status=2)


def grid(ranges: Sequence[NumberRange]) -> Floats:
    """(n, c) the points of c ranges, the last one changing first. Raises Refused for too many."""
    count = int(np.prod([float(one.count) for one in ranges]))
    if count > _MOST_POINTS:
        raise Refused(TOO_MANY_POINTS(count=count, what="points", most=_MOST_POINTS), exit_status=2)
    axes = np.meshgrid(*(one.values() for one in ranges), indexing="ij")
    return np.stack([axis.reshape(-1) for axis in axes], axis=1)


@dataclass(frozen=True, slots=True, eq=False)
class Directions:
    """Directions (d, 3) of the z axis of a tool, each with t orientations (d, t, 4) about it."""

    names: tuple[str, ...]
    axes: Floats
    quaternions: Floats


def parse_directions(given: Sequence[str], turns: int) -> Directions:
    """Parse directions: `down`, `up`, `x,y,z`, or one of them with `/DEGREES`.

    turns: number of turns of the tool about each that are tried, from the shortest turn of the
    base's frame on. Raises Refused for an invalid direction.
    """
    check_turns(turns)
    names, axes = [], []
    for text in given:
        for name, axis in _cone(text):
            names.append(name)
            axes.append(axis)
    columns = np.array(axes).reshape(-1, 3)
    about = rotations.about([0.0, 0.0, 1.0], np.arange(turns) * (360.0 / turns))
    onto = [rotation_from_z((float(x), float(y), float(z))) for x, y, z in columns]
    turned = [rotations.canonical(rotations.multiply(np.array(one), about)) for one in onto]
    return Directions(tuple(names), columns, np.array(turned).reshape(len(columns), turns, 4))


def check_turns(turns: int) -> None:
    """Raise Refused for an invalid number of turns, or more than are tried."""
    if not 1 <= turns <= _MOST_TURNS:
        raise Refused(NO_TURNS(count=turns, most=_MOST_TURNS), exit_status=2)


def _cone(text: str) -> list[tuple[str, Floats]]:
    """The middle of a cone and, if it is one, `_CONE_DIRECTIONS` directions on it."""
    middle, slash, angle = text.strip().partition("/")
    axis = _axis(middle, text)
    if not slash:
        return [(middle, axis)]
    tilt = _numbers(angle, 1, text)[0]
    if not 0.0 < tilt <= 180.0:
        raise Refused(NO_DIRECTION(given=text), exit_status=2)
    x, y, z = axis.tolist()
    onto = np.array(rotation_from_z((x, y, z)))
    around = np.arange(_CONE_DIRECTIONS) * (360.0 / _CONE_DIRECTIONS)
    sine, cosine = np.sin(np.radians(tilt)), np.cos(np.radians(tilt))
    a = np.radians(around)
    circle = np.stack(
        [sine * np.cos(a), sine * np.sin(a), np.full(_CONE_DIRECTIONS, cosine)], axis=1
    )
    names = [f"{middle}/{tilt:g}@{one:g}" for one in around]
    return [(middle, axis), *zip(names, rotations.rotate(onto, circle), strict=True)]


def _axis(name: str, text: str) -> Floats:
    found = _NAMED_DIRECTIONS.get(name.strip())
    axis = np.array(found) if found else _numbers(name, 3, text)
    length = float(np.linalg.norm(axis))
    if not length > 0.0:
        raise Refused(NO_DIRECTION(given=text), exit_status=2)
    return axis / length


def _numbers(text: str, count: int, whole: str) -> Floats:
    try:
        values = np.array([float(part) for part in text.split(",")])
    except ValueError:
        values = np.zeros(0)
    if len(values) != count or not np.isfinite(values).all():
        raise Refused(NO_DIRECTION(given=whole), exit_status=2)
    return values


_MOST_ASKED: Final = 200
"""Largest number of positions for which the bodies that are too near are named."""


@dataclass(frozen=True, slots=True, eq=False)
class ReachMap:
    """A map of n points and d directions.

    points: (n, 3) mm of the world. reached, touching: (n, d), see `Postures`; touching is inside
    the limits, but not without coming too near to something. room: (n, d) 0 to 1, NaN where it is
    not reached. limits, away, clearance: (n, d) what it is the least of. joints: (n, d, a).
    nearest: of two bodies, of how many of `touching`, at most `_MOST_ASKED`, they keep least of
    their margin.
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
    """Return which of the points (n, 3) mm of the world a robot of a scene reaches.

    directions: of the tip, in the world. tip: in the flange. bodies: True to check for contact;
    False for reach and limits alone, which needs no library for collisions. margin: mm, None for
    those of the scene. Other robots stay at home.
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
    some = evenly_spaced(len(rows), _MOST_ASKED)
    return dict(Counter(_nearest_bodies(space, row) for row in rows[some]).most_common())
