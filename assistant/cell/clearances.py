"""Clearances of a program from the bodies of its cell, everywhere along its motion.

Bodies that the program takes and releases by its outputs are carried along (`CarriedBodies`).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import field, replace
from itertools import pairwise
from typing import Final, TypeAlias

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats, Rows, Truths
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Span
from assistant.cell.collision.continuous import (
    RESOLUTION,
    ClosestApproach,
    Curve,
    Hit,
    JointPath,
    closest_approaches,
    firsts,
)
from assistant.cell.collision.model import Carriers, Contact, Model, carrier_of
from assistant.cell.link_bodies import arm_alone
from assistant.cell.scene import FLANGE, WORLD, Body, Mesh, PlacedRobot, Scene
from assistant.program.geometry import Pose, Tool
from assistant.robots.robot import Robot
from assistant.robots.timing import Carried, Simulation
from assistant.robots.timing.uninterrupted_moves import MovesWithoutStop, Stretches, stretches_of

_POSE_DIGITS: Final = 6
"""Digits of a place that is kept, so that rounds of a loop are alike."""

CarriedPlace: TypeAlias = tuple[str, Pose] | None
"""Parent of a body and pose in it; None if they are known only when the program runs."""


@dataclass(slots=True)
class CarryingDoubts:
    """Events that make an answer incomplete. empty: outputs that should have made a tool take
    something when nothing was in range; lost: bodies whose position is unknown.
    """

    empty: set[tuple[str, float]] = field(default_factory=set)
    lost: set[str] = field(default_factory=set)


@dataclass(frozen=True)
class CarriedBodies:
    """Positions of the bodies of a scene that can be taken, as `Carried` of a simulation.

    robot: the robot that takes them. places: in the order of `takeable(scene)`.
    """

    scene: Scene = field(compare=False)
    robot: PlacedRobot = field(compare=False)
    places: tuple[CarriedPlace, ...]
    doubts: CarryingDoubts = field(default_factory=CarryingDoubts, compare=False)

    @staticmethod
    def at_first(scene: Scene, robot: PlacedRobot) -> CarriedBodies:
        places = tuple((body.parent, body.pose) for body in takeable(scene))
        return CarriedBodies(scene, robot, places)

    def switched(
        self, name: str, value: float | None, joints: tuple[float, ...] | None
    ) -> CarriedBodies:
        """After an output is set: what it takes and is at the tool goes along with the flange,
        what it lets go stays where it is then.
        """
        places, taken, wanted = list(self.places), False, False
        for number, body in enumerate(takeable(self.scene)):
            place = self.places[number]
            names, lets, low = _named(body.taken), _named(body.released), name.lower()
            if place is None or low not in names | lets:
                continue
            held = place[0] in (self.flange, FLANGE)
            if value is None:
                places[number] = self._lost(body)
            elif held and lets.get(low) == value:
                places[number] = self._moved(place, joints, WORLD) or self._lost(body)
            elif not held and names.get(low) == value:
                wanted = True
                near = None if joints is None else self._near(number, np.array(joints))
                if near is not False:
                    taken = True
                    places[number] = self._moved(place, joints, self.flange) or self._lost(body)
            elif held and names.get(low) == value:
                taken = True
        if wanted and not taken:
            self.doubts.empty.add((name, float(value or 0.0)))
        return replace(self, places=tuple(places))

    def met(self, other: object) -> CarriedBodies:
        """Merge two branches of a run: bodies whose positions differ between them are lost."""
        assert isinstance(other, CarriedBodies)
        both = zip(takeable(self.scene), self.places, other.places, strict=True)
        places = tuple(a if a == b else self._lost(body) for body, a, b in both)
        return replace(self, places=places)

    @property
    def flange(self) -> str:
        return f"{self.robot.name}.{FLANGE}"

    def scene_now(self) -> Scene:
        """The scene with each body where it is, without those that are lost and what they bear."""
        places = dict(zip((body.name for body in takeable(self.scene)), self.places, strict=True))
        lost = {name for name, place in places.items() if place is None}
        while more := {b.name for b in self.scene.bodies if b.parent in lost} - lost - {*places}:
            lost |= more
        bodies = []
        for body in self.scene.bodies:
            place = places.get(body.name)
            if place is not None:
                bodies.append(replace(body, parent=place[0], pose=place[1]))
            elif body.name not in lost:
                bodies.append(body)
        return replace(self.scene, bodies=tuple(bodies))

    def _lost(self, body: Body) -> CarriedPlace:
        self.doubts.lost.add(body.name)
        return None

    def _rows(self, joints: Floats) -> Floats:
        """(1, j) of all robots, of which the others stand at home."""
        own = [joints if one is self.robot else one.robot.home for one in self.scene.robots]
        return np.concatenate(own)[None]

    def _moved(
        self, place: CarriedPlace, joints: tuple[float, ...] | None, parent: str
    ) -> CarriedPlace:
        """The same place in the world in another frame."""
        if place is None or joints is None:
            return None
        carriers = Carriers(self.scene.robots)
        one = Body("", (), place[1], place[0])
        number, pose = carrier_of(self.scene_now(), one, carriers)
        origins, turns = carriers.at(self._rows(np.array(joints)))
        frames = [
            Pose.of(origins[0, i], rotations.from_matrix(turns[:1, i])[0])
            for i in (number, carriers.names[parent])
        ]
        there = frames[1].inverse() @ frames[0] @ pose
        turn = rotations.canonical(np.array(there.quaternion))
        return parent, Pose.of(np.round(there.position, _POSE_DIGITS), np.round(turn, 12))

    def _near(self, number: int, joints: Floats) -> bool:
        """True if a body is within its margin of the bodies that the flange carries."""
        now = self.scene_now()
        name = takeable(self.scene)[number].name
        carriers = Carriers(self.scene.robots)
        moved = carriers.moved_by(carriers.names[self.flange])
        model = Model(replace(now, allowed=frozenset()))
        tools = {
            item.body.name
            for item in model.items
            if carriers.moved_by(item.carrier) == moved and item.body.name != name
        }
        pairs = np.array(
            [
                pair
                for pair in range(len(model))
                for one, other in [(model.items[model.one[pair]], model.items[model.other[pair]])]
                if {one.body.name, other.body.name} - {name} <= tools
                and name in (one.body.name, other.body.name)
            ],
            dtype=np.intp,
        )
        if not len(pairs):
            return False
        found = model.exact(self._rows(joints), np.zeros(len(pairs), dtype=np.intp), pairs)
        return bool((found <= model.margins[pairs]).any())


def _named(said: tuple[str, float] | None) -> dict[str, float]:
    return {} if said is None else {said[0].lower(): said[1]}


def takeable(scene: Scene) -> tuple[Body, ...]:
    """Bodies that an output takes."""
    return tuple(body for body in scene.bodies if body.taken is not None)


@dataclass(frozen=True, slots=True)
class Closeness:
    """Two bodies that come too near to each other on the way of a motion statement.

    procedure, number, row: the motion statement and its move. label: what it moves to. time:
    seconds from the start of the procedure at which that begins. contact: then. least: mm at the
    nearest place of the statement. bound: mm that it is not less than. starts: whether the
    statement starts so near. joints: (a,) of the robot where it begins.
    """

    procedure: str
    number: int
    row: int
    label: str
    time: float
    contact: Contact
    least: float
    bound: float
    starts: bool
    joints: Floats
    span: Span | None = None

    @property
    def touches(self) -> bool:
        return self.bound <= 0.0 and self.least <= RESOLUTION

    @property
    def exact(self) -> bool:
        return self.least - self.bound <= RESOLUTION


def closeness(
    simulation: Simulation, scene: Scene, name: str | None = None, margin: float | None = None
) -> Iterator[Closeness]:
    """Yield where a program comes closer than the margins to anything, in the order of its motions.

    Two parts come once for each statement or line of a path.

    name: of the robot of the scene that runs it; the others stand at home. margin: mm, for all
    pairs, instead of those of the scene; 0 for contacts only.
    """
    models: dict[Carried | None, Model] = {}
    placed = robot_of(scene, simulation.robot, name)
    for passed in simulation.passed:
        for carried, stretches in carried_stretches(passed):
            if carried not in models:
                now = carried.scene_now() if isinstance(carried, CarriedBodies) else scene
                models[carried] = Model(now)
            model = models[carried]
            limit = model.margins if margin is None else np.full(len(model), margin)
            yield from _of_stretches(simulation, model, passed, stretches, (placed, limit))


def own_contacts(simulation: Simulation, tools: Mapping[str, Tool]) -> Iterator[Closeness]:
    """Return the contacts of an arm without a cell with itself, its base or its tool, in order.

    tools: those of the program, by their names.
    """
    robot = simulation.robot
    names = {tool.tip.position: name for name, tool in reversed(list(tools.items()))}
    models: dict[int, Model] = {}
    for passed in simulation.passed:
        moves, whole = passed.plan.course.moves, stretches_of(passed.plan)
        mount = moves.mount[whole.row]
        ends = [0, *(np.flatnonzero(np.diff(mount)) + 1).tolist(), len(mount)]
        for first, last in pairwise(ends):
            tool = moves.mounts[mount[first]].tool if last > first else Tool()
            name = names.get(tool.tip.position)
            scene = arm_alone(robot, (name, tool.tip) if name and tool.held else None)
            model = models.setdefault(id(scene), Model(scene))
            asked = scene.robots[0], model.margins
            yield from _of_stretches(simulation, model, passed, whole.part(first, last), asked)


def _of_stretches(
    simulation: Simulation,
    model: Model,
    passed: MovesWithoutStop,
    stretches: Stretches,
    asked: tuple[PlacedRobot, Floats],
) -> Iterator[Closeness]:
    """Select the pairs of the robot and their limits (p,)."""
    placed, limit = asked
    way = way_of(model.scene, placed, stretches)
    statement = _statement_numbers(passed, stretches)
    found = closest_approaches(model, way, limit, statement)
    contacts = [one for one in found if _touches(one)]
    others = [one for one in found if not _touches(one)]
    begin = firsts(model, way, np.minimum(limit, 0.0), statement, contacts)
    begin |= firsts(model, way, limit, statement, others)
    firsts_of = dict(zip(*np.unique(statement, return_index=True), strict=True))
    known = [(begin[one.group, one.pair], one) for one in found if (one.group, one.pair) in begin]
    for hit, one in sorted(known, key=lambda two: two[0].at):
        starts = hit.at <= firsts_of[one.group]
        yield _closeness(simulation, model, passed, stretches, (hit, one, starts))


def _statement_numbers(passed: MovesWithoutStop, stretches: Stretches) -> Rows:
    """(n - 1,) numbers that are the same for the stretches of a statement, or of a line of one."""
    sizes = np.array([len(piece.moves) for piece in passed.pieces], dtype=np.intp)
    ends, move = np.cumsum(sizes), stretches.row + passed.skipped
    piece = np.searchsorted(ends, move, side="right")
    lines = np.array([one.lines for one in passed.pieces], dtype=bool)
    return np.asarray(np.where(lines[piece], move, (ends - sizes)[piece]))


def _touches(one: ClosestApproach) -> bool:
    return one.bound <= 0.0 and one.distance <= RESOLUTION


def carried_stretches(passed: MovesWithoutStop) -> Iterator[tuple[Carried | None, Stretches]]:
    """The stretches of a plan, split where what the arm carries changes."""
    whole = stretches_of(passed.plan)
    kinds = list(dict.fromkeys(piece.carried for piece in passed.pieces))
    if len(kinds) == 1:
        yield kinds[0], whole
        return
    moves = [kinds.index(p.carried) for p in passed.pieces for _ in range(len(p.moves))]
    kind = np.array(moves[passed.skipped :])[whole.row]
    ends = [*(np.flatnonzero(np.diff(kind)) + 1).tolist(), len(kind)]
    for first, last in pairwise([0, *ends]):
        part = whole.part(first, last)
        yield kinds[int(kind[first])] if first < len(kind) else kinds[0], part


def robot_of(scene: Scene, robot: Robot, name: str | None = None) -> PlacedRobot:
    """Return the robot of a scene that runs a program for a robot: the named one if a name is
    given.

    Raises LookupError if none matches, or if several are of that model and no name is given.
    """
    name = name or scene.runs
    found = [
        placed
        for placed in scene.robots
        if placed.robot.name == robot.name and name in (None, placed.name)
    ]
    if len(found) != 1:
        raise LookupError(name or robot.name)
    return found[0]


def beyond_bodies(scene: Scene, placed: PlacedRobot, tip: Pose) -> float:
    """Mm from a tip in the flange frame to the boxes around what a robot carries there: 0 if it is
    in one of them.
    """
    model, carriers = Model(scene), Carriers(scene.robots)
    home = np.concatenate([one.robot.home for one in scene.robots])[None]
    flange = carriers.names[f"{placed.name}.{FLANGE}"]
    moved = carriers.moved_by(flange)
    origins, turns = carriers.at(home)
    point = origins[0, flange] + turns[0, flange] @ np.array(tip.position)
    gaps = [
        model.beyond(number, origins[0], turns[0], point)
        for number, item in enumerate(model.items)
        if carriers.moved_by(item.carrier) == moved
    ]
    return min(gaps, default=float(np.linalg.norm(tip.position)))


def way_of(scene: Scene, placed: PlacedRobot, stretches: Stretches) -> JointPath:
    """The way of the joints of all robots, of which one moves."""
    return JointPath(*rows_of(scene, placed, stretches), _curve_of(scene, placed, stretches))


def _curve_of(scene: Scene, placed: PlacedRobot, stretches: Stretches) -> Curve:
    """Return the joints of all robots along stretches on which one of them moves."""
    rows, _ = rows_of(scene, placed, stretches.part(0, 0))
    columns = Carriers(scene.robots).columns
    own = next(c for c, one in zip(columns, scene.robots, strict=True) if one is placed)

    def curve(stretch: Rows, part: Floats) -> tuple[Floats, Truths]:
        joints, exact = stretches.between(stretch, part)
        out = np.tile(rows[0], (len(joints), 1))
        out[:, own] = joints
        return out, exact

    return curve


def rows_of(scene: Scene, placed: PlacedRobot, stretches: Stretches) -> tuple[Floats, Floats]:
    """Rows of the joints of all robots, of which one moves, with their slack."""
    rows, slack = [], []
    for one in scene.robots:
        still = np.tile(one.robot.home, (len(stretches.joints), 1))
        rows.append(stretches.joints if one is placed else still)
        slack.append(stretches.slack if one is placed else still[1:] * 0.0)
    return np.concatenate(rows, axis=1), np.concatenate(slack, axis=1)


def _closeness(
    simulation: Simulation,
    model: Model,
    passed: MovesWithoutStop,
    stretches: Stretches,
    found: tuple[Hit, ClosestApproach, bool],
) -> Closeness:
    hit, least, starts = found
    at = min(int(hit.at), len(stretches.row) - 1)
    part = hit.at - at
    piece, row = passed.piece_of(int(stretches.row[at]))
    time = float(stretches.times[at] * (1.0 - part) + stretches.times[at + 1] * part)
    distance, bound = least.distance, least.bound
    shapes = [model.items[int(i[hit.pair])] for i in (model.one, model.other)]
    if any(not item.body.shown for item in shapes):
        touches = _touches(least)
        distance = hit.distance  # how far into space that nobody knows says nothing
        bound = min(distance, 0.0) if touches else distance
    elif distance <= 0.0 and any(isinstance(item.part.shape, Mesh) for item in shapes):
        bound = -np.inf  # triangles do not tell how deep something is
    return Closeness(
        piece.procedure,
        piece.number,
        row,
        simulation.labels.get((piece.procedure, piece.number), ""),
        passed.start + time,
        model.contact(hit.joints, hit.pair),
        distance,
        bound,
        starts,
        hit.joints,
    )
