"""Ways through a cell that touch nothing: `plan`.

scene, _ = read_scene("cell.toml")
way = plan(scene, robot.home, Pose((450, 100, 300), (0, 0, 1, 0)))
way.statements()        # joint moves of the pseudo-program
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from assistant.cell.collision.continuous import RESOLUTION
from assistant.cell.planning import moves
from assistant.cell.planning.goals import held
from assistant.cell.planning.rules import (
    GOAL_TOUCHES,
    LESS_MARGIN,
    NO_JOINTS,
    NO_WAY,
    NOT_REACHED,
    OUTSIDE,
    START_TOUCHES,
    STOPS,
    TILTED,
)
from assistant.cell.planning.search import search
from assistant.cell.planning.shortening import shortened
from assistant.cell.planning.space import TILT, Cone, Space
from assistant.cell.rules import NO_ROBOT
from assistant.cell.scene import Placed, Scene
from assistant.program.arrays import Floats
from assistant.program.diagnostics import Diagnostic, Refused
from assistant.program.geometry import FLANGE, IDENTITY, Pose
from assistant.program.motion import MAXIMUM_SPEED, Speed
from assistant.program.program import Program
from assistant.program.statements import MoveJoints
from assistant.robots.robot import Robot

TOUCHING: Final = 2.0 * RESOLUTION
"""mm that two bodies must be apart for a way to begin or to end there: what is nearer cannot be
told from contact."""
SECONDS: Final = 10.0


@dataclass(frozen=True, slots=True, eq=False)
class Planned:
    """A way that is proven clear.

    rows: (n, a) joints, the start first; straight moves of all axes lie between. radii: (n - 1,) mm
    of the blend at the end of each move, 0 for a stop. tool: the tip in the flange. seconds: that
    the search took. moves_tried: how many moves were looked at. findings: what is less than was
    asked for.
    """

    robot: Robot
    rows: Floats
    radii: Floats
    tool: Pose
    seconds: float
    moves_tried: int
    findings: tuple[Diagnostic, ...]

    @property
    def length(self) -> float:
        """Seconds of all axes at full speed, root of the sum of squares, over the moves."""
        return float(np.linalg.norm(np.diff(self.rows, axis=0) / self.robot.speeds, axis=1).sum())

    def statements(
        self, speed: Speed = MAXIMUM_SPEED, tool: str = FLANGE
    ) -> tuple[MoveJoints, ...]:
        """Joint moves from the start on. tool: its name; blends are mm of its tip."""
        return moves.moves(self.robot, self.rows, self.radii, speed, tool)

    def program(self, name: str = "way", speed: Speed = MAXIMUM_SPEED) -> Program:
        """A program of the moves, which begins at the start."""
        tool = FLANGE if self.tool == IDENTITY else moves.TOOL
        return moves.program_of(name, self.robot, self.statements(speed, tool), self.tool)


def plan(
    scene: Scene,
    start: ArrayLike,
    goal: Pose | ArrayLike,
    *,
    robot: str | None = None,
    tool: Pose = IDENTITY,
    others: Mapping[str, ArrayLike] | None = None,
    margin: float | None = None,
    cone: Cone | None = None,
    seconds: float = SECONDS,
    seed: int = 1,
) -> Planned:
    """A way of a robot from joints to a pose of its tool, or to other joints.

    start: (a,) degrees, mm of an axis that slides. goal: the pose of the tip in the base of the
    robot, held in whichever way (branch, turns) is found first, or joints (a,). robot: its name
    in the scene, None for the only one. tool: the tip in the flange; bodies that move with it are
    those of the scene. others: (a,) joints of other robots by name, at home if it names them not.
    margin: mm, None for the margins of the scene. cone: how far the tool may be tilted. seconds:
    the search takes at most. seed: of what is random.

    Every move of the way, rounded corners included, keeps the margins by `continuous.hits`. A body
    that is within its margin at the start, or at every way to hold the goal, is kept as far away as
    it is there, with a finding.

    Raises Refused, with a finding: a start outside the limits, in contact or tilted; a goal out
    of reach, inside something or tilted; no way found in time, with the nearest approach; no
    robot of that name; without coal or OMPL.
    """
    placed = _robot(scene, robot)
    begin = _joints(placed.robot, start, "start", "begins")
    where = {}
    for one in scene.robots:
        if one.name in (others or {}):
            where[one.name] = _joints(one.robot, (others or {})[one.name], f"`{one.name}`", "has")
    space = Space(scene, placed, others=where, margin=margin, cone=cone, tool=tool)
    found = list(_start(space, begin))
    goals, said = _goals(space, begin, goal)
    found += said
    searched = search(space, begin, goals, seconds=seconds, seed=seed)
    if searched.rows is None:
        raise Refused(_no_way(space, goals, goal, searched.nearest, searched.seconds))
    rows = shortened(space, searched.rows, seed=seed)
    done = moves.rounded(space, rows)
    if done.hits:  # nothing that `Space.clear` proves is hit: a guard, should that be wrong
        raise Refused(_no_way(space, goals, goal, done.hits[0].joints, searched.seconds))
    stops = int((done.radii[:-1] == 0.0).sum())
    if stops:
        found.append(STOPS(count=stops, total=len(rows) - 2))
    return Planned(
        placed.robot, rows, done.radii, tool, searched.seconds, space.asked, tuple(found)
    )


def _robot(scene: Scene, name: str | None) -> Placed:
    for placed in scene.robots:
        if placed.name == name or (name is None and len(scene.robots) == 1):
            return placed
    names = ", ".join(placed.name for placed in scene.robots)
    raise Refused(NO_ROBOT(name=name or "", names=names or "none"), exit_status=2)


def _joints(robot: Robot, values: ArrayLike, what: str, where: str) -> Floats:
    row = np.asarray(values, dtype=np.float64).reshape(-1)
    given = int(np.isfinite(row).sum())
    if len(row) != len(robot.axes) or given != len(row):
        raise Refused(
            NO_JOINTS(what=what, given=given, robot=robot.title, wanted=len(robot.axes)),
            exit_status=2,
        )
    if not bool(robot.inside(row)):
        low, high = robot.limits.T
        axis = int(np.argmax(np.maximum(low - row, row - high)))
        raise Refused(
            OUTSIDE(
                where=where,
                axis=robot.axes[axis],
                value=float(row[axis]),
                unit=robot.units[axis],
                low=float(low[axis]),
                high=float(high[axis]),
            )
        )
    return row


def _start(space: Space, row: Floats) -> Iterator[Diagnostic]:
    """Raises Refused for a start in contact; margins that it does not keep become less."""
    distances = space.distances(row)
    pair = int(np.argmin(distances)) if len(distances) else 0
    if len(distances) and distances[pair] <= TOUCHING:
        contact = space.contact(row, pair)
        deep = max(-float(distances[pair]), 0.0)
        raise Refused(START_TOUCHES(one=contact.one, other=contact.other, deep=deep))
    _upright(space, row, "begins")
    yield from _less(space, row, distances, "begins")


def _upright(space: Space, row: Floats, where: str) -> None:
    tilt = float(space.tilt(row[None])[0])
    if space.cone is not None and tilt > space.cone.angle + TILT:
        raise Refused(TILTED(where=where, angle=tilt, most=space.cone.angle))


def _less(space: Space, row: Floats, distances: Floats, where: str) -> Iterator[Diagnostic]:
    """Less margin for what is within it at a place; a finding for each two bodies."""
    told = set[tuple[str, str]]()
    for pair in np.flatnonzero(distances <= space.margins + TOUCHING):
        margin, least = float(space.margins[pair]), float(distances[pair]) - TOUCHING
        space.margins[pair] = min(margin, least)
        contact = space.contact(row, int(pair))
        names = contact.one, contact.other
        if names not in told and least < margin - TOUCHING:
            told.add(names)
            yield LESS_MARGIN(one=names[0], other=names[1], least=least, margin=margin, where=where)


def _goals(
    space: Space, start: Floats, goal: Pose | ArrayLike
) -> tuple[Floats, tuple[Diagnostic, ...]]:
    """Joints (k, a) at the goal that are free; raises Refused if there are none."""
    if isinstance(goal, Pose):
        goals = held(space.robot, goal, start, space.tool)
        if not len(goals):
            raise Refused(NOT_REACHED(robot=space.robot.title, goal=_shown(goal)))
    else:
        goals = _joints(space.robot, goal, "goal", "ends")[None]
    _upright(space, goals[0], "ends")
    free = goals[space.free(goals)]
    if len(free):
        return free, ()
    distances = np.array([space.distances(row) for row in goals])
    least = distances.min(axis=1)
    if least.max() <= TOUCHING:
        best = int(np.argmax(least))
        contact = space.contact(goals[best], int(np.argmin(distances[best])))
        raise Refused(
            GOAL_TOUCHES(
                goal=_shown(goal),
                one=contact.one,
                other=contact.other,
                deep=max(-float(least[best]), 0.0),
                count=len(goals),
            )
        )
    best = int(np.argmax(np.where(least > TOUCHING, (distances - space.margins).min(axis=1), -1e9)))
    return goals[best][None], tuple(_less(space, goals[best], distances[best], "ends"))


def _no_way(
    space: Space, goals: Floats, goal: Pose | ArrayLike, nearest: Floats, seconds: float
) -> Diagnostic:
    tips, _ = space.tip(np.vstack([nearest, goals]))
    towards = goals[int(np.argmin(space.length(nearest, goals)))]
    found = space.hits(np.stack([nearest, towards]))
    what = "nothing is in the way that could be told from a margin"
    if space.cone is not None:
        what = "the tool would have to tilt too far"
    if found:
        contact = space.contact(found[0].joints, found[0].pair)
        what = f"`{contact.one}` and `{contact.other}` come too near to each other"
    return NO_WAY(
        goal=_shown(goal),
        seconds=seconds,
        apart=float(np.linalg.norm(tips[1:] - tips[0], axis=1).min()),
        joints=_listed(nearest),
        what=what,
    )


def _shown(goal: Pose | ArrayLike) -> str:
    if isinstance(goal, Pose):
        return f"the pose at {_listed(np.array(goal.position))} mm"
    return f"the joints {_listed(np.asarray(goal, dtype=np.float64).reshape(-1))}"


def _listed(values: Floats) -> str:
    return f"({', '.join(f'{value:.6g}' for value in np.round(values, 2) + 0.0)})"
