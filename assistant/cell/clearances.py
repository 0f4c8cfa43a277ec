"""How near a program comes to the bodies of its cell, everywhere on its way."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from assistant.base.arrays import Floats, Rows, Truths
from assistant.base.diagnostics import Span
from assistant.cell.arms import arm_alone
from assistant.cell.collision.carriers import Carriers
from assistant.cell.collision.continuous import (
    RESOLUTION,
    ClosestApproach,
    Curve,
    Hit,
    JointPath,
    closest_approaches,
    firsts,
)
from assistant.cell.collision.model import Contact, Model
from assistant.cell.holding import CarriedBodies
from assistant.cell.scene import FLANGE, PlacedRobot, Scene
from assistant.cell.shapes import Mesh
from assistant.program.geometry import Pose, Tool
from assistant.robots.robot import Robot
from assistant.robots.timing import Carried, Simulation
from assistant.robots.timing.passed import MovesWithoutStop, Stretches, stretches_of


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
    """The robot of a scene that runs a program for a robot, the one that is named if any is.

    Raises LookupError if there is none, or if several are of that model and none is named.
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
    return JointPath(*rows_of(scene, placed, stretches), curve_of(scene, placed, stretches))


def curve_of(scene: Scene, placed: PlacedRobot, stretches: Stretches) -> Curve:
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
