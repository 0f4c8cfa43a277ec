"""The best position for a work piece or for the base of a robot, on a grid of positions.

The targets of a program are its goals. A position is left out if bodies would overlap there more
than they do now.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Container, Iterator, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused
from assistant.cell.collision.continuous import RESOLUTION
from assistant.cell.collision.distances import Distances
from assistant.cell.collision.model import Carriers, Item, Model, carrier_of
from assistant.cell.exploration.filled_cells import thinner_shape
from assistant.cell.findings import (
    CHART_ONLY_HERE,
    NO_MOVABLE_BODY,
    NO_TARGETS,
    OVERLAPPING_PLACES,
    TOO_MANY_POINTS,
)
from assistant.cell.planning.space import Space
from assistant.cell.reach_map import (
    ENOUGH_AWAY,
    ENOUGH_CLEAR,
    ENOUGH_LIMITS,
    Postures,
    best_postures,
)
from assistant.cell.scene import OCCUPIED_SUFFIX, UNKNOWN_SUFFIX, Body, Mesh, PlacedRobot, Scene
from assistant.program.geometry import IDENTITY, Pose
from assistant.program.statements import MoveJoints
from assistant.robots.motion.run import Run
from assistant.robots.solved_program import SolvedProgram

_UNKNOWN_DEPTH: Final = -1.0
"""mm that stand for a depth that is not known."""

_OverlapDepths = dict[tuple[str, str], float]
"""Names of a moved body and of the body that it overlaps → mm that they are apart, below 0."""


def _overlap_depths(model: Model, moved: Container[str]) -> _OverlapDepths:
    """Return how deep moved bodies of the world, given by name, overlap others.

    Pairs that the scene allows to touch are left out.
    """
    still = [item for item in model.items if not model.carriers.moved_by(item.carrier)]
    rows = np.concatenate([placed.robot.home for placed in model.scene.robots])[None]
    origins, turns = model.carriers.at(rows)
    found: _OverlapDepths = {}
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
    """Return the mm between two items, negative by the penetration depth.

    For a mesh only contact is known: the result is `_UNKNOWN_DEPTH` if the item also has contact
    when it is thinner by `RESOLUTION`, or lies inside. Two meshes that touch count as overlapping.
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
    return _UNKNOWN_DEPTH if found <= 0.0 else 0.0


def _deeper_overlap(now: _OverlapDepths, before: _OverlapDepths) -> tuple[str, str] | None:
    """Return the names of two bodies that overlap deeper than before, None if no pair does."""
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


_OFFSET_DIGITS: Final = 6
_MOST_PLACES: Final = 20_000
_WORLD_ITSELF: Final = 0
"""The carrier that does not stand on any robot."""
_MOST_POSES: Final = 5_000_000
"""Largest number of poses to examine: placements times targets times turns."""


@dataclass(frozen=True, slots=True, eq=False)
class Goals:
    """n targets of one tip.

    positions: (n, 3) mm of the tip in the world. quaternions: (n, k, 4), of which one is enough.
    """

    names: tuple[str, ...]
    positions: Floats
    quaternions: Floats
    tip: Pose = IDENTITY

    def moved(self, by: Pose) -> Goals:
        """Return the goals after the body that they are on is moved in the world."""
        turn = np.array(by.quaternion)
        positions = rotations.rotate(turn, self.positions) + np.array(by.position)
        return replace(
            self, positions=positions, quaternions=rotations.multiply(turn, self.quaternions)
        )


@dataclass(frozen=True, slots=True, eq=False)
class Place:
    """A placement that was examined.

    offset: (4,) mm along x, y and z and degrees about z from the present placement. pose: as the
    cell file states it. reached: number of targets reached. room: the least, and mean the mean, of
    the targets reached; 0 if none is reached. worst: the target with the least room, or the first
    that is not reached. limits, away, clearance: the least of each, see `Postures`.
    """

    offset: Floats
    pose: Pose
    reached: int
    room: float
    mean: float
    worst: str
    limits: float
    away: float
    clearance: float

    @property
    def shares(self) -> tuple[float, ...]:
        """Return the shares of the sufficient values, 0 to 1, the least first."""
        each = (
            self.limits / ENOUGH_LIMITS,
            self.away / ENOUGH_AWAY,
            self.clearance / ENOUGH_CLEAR,
        )
        return tuple(sorted(min(share, 1.0) for share in each))


@dataclass(frozen=True, slots=True, eq=False)
class Places:
    """places: the best first. total: targets. findings: of places that are left out."""

    places: tuple[Place, ...]
    total: int
    findings: tuple[Diagnostic, ...]

    @property
    def best(self) -> Place | None:
        """The best one at which everything is reached."""
        return self.places[0] if self.places and self.places[0].reached == self.total else None


def best_base(
    scene: Scene,
    placed: PlacedRobot,
    offsets: Floats,
    goals: Sequence[Goals],
    *,
    bodies: bool = True,
    margin: float | None = None,
) -> Places:
    """Places of the base of a robot, for targets that stay in the world.

    offsets: (m, 4) mm along x, y and z of the world, degrees about z of the base. bodies: whether
    anything may be touched. margin: mm, None for those of the scene. Raises Refused for no targets,
    too many places, or a robot that a chart keeps to space that was explored from where it stands.
    """
    at = scene.robots.index(placed)
    if any(
        body.name in (placed.name + UNKNOWN_SUFFIX, placed.name + OCCUPIED_SUFFIX)
        for body in scene.bodies
    ):
        raise Refused(CHART_ONLY_HERE(name=placed.name), exit_status=2)

    def stands(offset: Floats) -> tuple[Scene, PlacedRobot, Pose, Pose]:
        base = shifted(placed.base, offset)
        moved = replace(placed, base=base)
        robots = (*scene.robots[:at], moved, *scene.robots[at + 1 :])
        return replace(scene, robots=robots), moved, base, IDENTITY

    carriers = Carriers(scene.robots)
    names = frozenset(
        body.name
        for body in scene.all_bodies()
        if carrier_of(scene, body, carriers)[0] == carriers.first[at]
    )
    search = _Search(stands, names, scene, goals, bodies, margin)
    return search.places(offsets, f"`{placed.name}`")


def best_place(
    scene: Scene,
    placed: PlacedRobot,
    name: str,
    offsets: Floats,
    goals: Sequence[Goals],
    *,
    margin: float | None = None,
) -> Places:
    """Places of a body, with all that stands on it, for targets that move with it.

    offsets: (m, 4) mm along x, y and z of its parent's frame, degrees about that z. Else as
    `best_base`. Raises Refused also for a body that is not there, or that a robot carries.
    """
    body = standing_body(scene, name)
    carriers = Carriers(scene.robots)
    parent = carrier_of(scene, body, carriers)[1] @ body.pose.inverse()

    def stands(offset: Floats) -> tuple[Scene, PlacedRobot, Pose, Pose]:
        pose = shifted(body.pose, offset)
        moved = replace(body, pose=pose)
        bodies = tuple(moved if one is body else one for one in scene.bodies)
        by = parent @ pose @ body.pose.inverse() @ parent.inverse()
        return replace(scene, bodies=bodies), placed, pose, by

    names = frozenset(one.name for one in scene.bodies if name in _below(scene, one))
    return _Search(stands, names, scene, goals, True, margin).places(offsets, f"`{name}`")


_SceneAtOffset = Callable[[Floats], tuple[Scene, PlacedRobot, Pose, Pose]]
"""An offset → the scene with it, the robot there, what is moved as the cell file states its pose,
and by what targets are moved in the world.
"""


@dataclass(frozen=True, slots=True, eq=False)
class _Search:
    """Search for a placement. moved: names of the bodies that are moved, among those fixed in the
    world.
    """

    stands: _SceneAtOffset
    moved: frozenset[str]
    scene: Scene
    goals: Sequence[Goals]
    bodies: bool
    margin: float | None

    def places(self, offsets: Floats, what: str) -> Places:
        total = sum(len(one.names) for one in self.goals)
        if not total:
            raise Refused(NO_TARGETS(what=what), exit_status=2)
        poses = len(offsets) * sum(one.quaternions[..., 0].size for one in self.goals)
        if len(offsets) > _MOST_PLACES:
            said = "places"
            raise Refused(
                TOO_MANY_POINTS(count=len(offsets), what=said, most=_MOST_PLACES), exit_status=2
            )
        if poses > _MOST_POSES:
            said = "places times targets times turns"
            raise Refused(TOO_MANY_POINTS(count=poses, what=said, most=_MOST_POSES), exit_status=2)
        before = _overlap_depths(Model(self.scene), self.moved) if self.bodies else {}
        found, blocked = list[Place](), Counter[tuple[str, str]]()
        for offset in offsets:
            place = self._place(offset, before)
            if isinstance(place, Place):
                found.append(place)
            else:
                blocked[place] += 1
        count = len(offsets)
        said_ = [
            OVERLAPPING_PLACES(count=times, total=count, one=one, other=other)
            for (one, other), times in blocked.items()
        ]
        return Places(tuple(sorted(found, key=_merit)), total, tuple(said_))

    def _place(self, offset: Floats, before: _OverlapDepths) -> Place | tuple[str, str]:
        """Return a placement, or the first two bodies that would overlap there."""
        scene, placed, pose, by = self.stands(offset)
        model = Model(scene) if self.bodies else None
        if model is not None:
            inside = _deeper_overlap(_overlap_depths(model, self.moved), before)
            if inside is not None:
                return inside
        names, parts = list[str](), list[Postures]()
        into = placed.base.inverse() @ by
        for one in self.goals:
            space = None
            if self.bodies:
                space = Space(scene, placed, margin=self.margin, tool=one.tip)
            here = one.moved(into)
            robot = placed.robot
            parts.append(best_postures(robot, here.positions, here.quaternions, space, one.tip))
            names += one.names
        return _place_of(offset, pose, names, Postures.joined(parts))


def _place_of(offset: Floats, pose: Pose, names: Sequence[str], ways: Postures) -> Place:
    reached = ways.reached
    count = int(reached.sum())
    if not count:
        return Place(offset, pose, 0, 0.0, 0.0, names[0], 0.0, 0.0, 0.0)
    rooms = np.where(reached, ways.room, np.inf)
    worst = int(np.argmin(rooms))
    named = worst if count == len(names) else int(np.argmin(reached))
    figures = (float(np.nanmin(column)) for column in (ways.limits, ways.away, ways.clearance))
    mean = float(rooms[reached].mean())
    return Place(offset, pose, count, float(rooms[worst]), mean, names[named], *figures)


def _merit(place: Place) -> tuple[float, ...]:
    """Most targets first, then the most of what there is least of, then of the next; then the most
    room in the mean, and the shortest way.

    Rounded, so that places that are alike do not depend on the last digits.
    """
    far = round(float(np.linalg.norm(place.offset[:3])), _OFFSET_DIGITS)
    scarce = (-round(share, _OFFSET_DIGITS) for share in place.shares)
    last = (
        -round(place.mean, _OFFSET_DIGITS),
        far,
        abs(float(place.offset[3])),
        *place.offset.tolist(),
    )
    return (-float(place.reached), *scarce, *last)


def standing_body(scene: Scene, name: str) -> Body:
    """Return a body that is fixed in the world; raises Refused if no such body has that name."""
    carriers = Carriers(scene.robots)
    still = [body for body in scene.bodies if carrier_of(scene, body, carriers)[0] == _WORLD_ITSELF]
    for body in still:
        if body.name == name:
            return body
    names = ", ".join(f"`{body.name}`" for body in still) or "(none)"
    raise Refused(NO_MOVABLE_BODY(name=name, names=names), exit_status=2)


def locations(scene: Scene, name: str | None = None, tip: Pose = IDENTITY, turns: int = 1) -> Goals:
    """Return the locations of bodies fixed in the world: of one body and all on it, or of all.

    tip: in the flange. turns: number of turns of the tool about its z axis; one that is reached is
    enough.
    """
    carriers = Carriers(scene.robots)
    names, poses = list[str](), list[Pose]()
    for body in scene.bodies:
        number, pose = carrier_of(scene, body, carriers)
        if number != _WORLD_ITSELF or (name is not None and name not in _below(scene, body)):
            continue
        names += [f"{body.name}.{one}" for one in body.locations]
        poses += [pose @ one for one in body.locations.values()]
    positions = np.array([pose.position for pose in poses]).reshape(-1, 3)
    quaternions = np.array([pose.quaternion for pose in poses]).reshape(-1, 4)
    return Goals(tuple(names), positions, turned_about_z(quaternions, turns), tip)


def turned_about_z(quaternions: Floats, turns: int) -> Floats:
    """(n, 4) → (n, k, 4) the same turned about their z axes by k equal parts of a whole turn."""
    about = rotations.about([0.0, 0.0, 1.0], np.arange(turns) * (360.0 / turns))
    return rotations.multiply(quaternions[:, None], about[None])


def shifted(pose: Pose, offset: Floats) -> Pose:
    """A pose moved along the axes of the frame that it is in, and turned about its z."""
    x, y, z = pose.position
    turn = Pose.of(np.zeros(3), rotations.about([0.0, 0.0, 1.0], float(offset[3])))
    there = (x + float(offset[0]), y + float(offset[1]), z + float(offset[2]))
    return Pose(there, (turn @ Pose(quaternion=pose.quaternion)).quaternion)


def _below(scene: Scene, body: Body) -> Iterator[str]:
    """A body and those that it stands on."""
    one: Body | None = body
    while one is not None:
        yield one.name
        one = scene.body(one.parent)


_TARGET_DIGITS: Final = 6
"""Digits by which two targets are one."""


@dataclass(frozen=True, slots=True, eq=False)
class FoundTargets:
    """goals: those of each tip together. unknown: how many moves go to what only running the
    program tells.
    """

    goals: tuple[Goals, ...]
    unknown: int


def targets_of(
    solution: SolvedProgram, placed: PlacedRobot, turns: int = 1, *, carried: bool = True
) -> FoundTargets:
    """Each target of a program once, reached or not, in the order of text.

    placed: the robot that runs it. turns: of the tool about its z axis of which one is enough.
    carried: whether moves count that hold a work piece in the arm against a tool in the room.
    Moves to joints have no targets.
    """
    rows: dict[Pose, dict[tuple[float, ...], tuple[str, Pose]]] = {}
    for solved in solution.solved_runs:
        run = solved.run
        positions, quaternions = run.flange(np.arange(len(run)))
        known = np.isfinite(positions).all(axis=1) & np.isfinite(quaternions).all(axis=1)
        for row in np.flatnonzero(known).tolist():
            if not carried and _in_the_arm(run, row):
                continue
            tip = run.mounting.tip(row)
            pose = placed.base @ Pose.of(positions[row], quaternions[row]) @ tip
            key = tuple(
                round(value, _TARGET_DIGITS) for value in (*pose.position, *pose.quaternion)
            )
            rows.setdefault(tip, {}).setdefault(key, (str(run.label(row)), pose))
    unknown = sum(
        leg.solved_run is None and not isinstance(leg.statement, MoveJoints)
        for legs in solution.legs.values()
        for leg in legs
    )
    return FoundTargets(
        tuple(_goals(tip, list(found.values()), turns) for tip, found in rows.items()), unknown
    )


def _in_the_arm(run: Run, row: int) -> bool:
    mounting = run.mounting
    tool, frame = mounting.tools[mounting.tool[row]], mounting.frames[mounting.frame[row]]
    return frame.held or not tool.held


def _goals(tip: Pose, found: list[tuple[str, Pose]], turns: int) -> Goals:
    positions: Floats = np.array([pose.position for _, pose in found])
    quaternions = rotations.canonical([pose.quaternion for _, pose in found])
    return Goals(
        tuple(name for name, _ in found), positions, turned_about_z(quaternions, turns), tip
    )
