"""Plan paths through a cell that keep clear of everything: `plan`.

scene, _ = read_scene("cell.toml")
way = plan(scene, robot.home, Pose((450, 100, 300), (0, 0, 1, 0)))
way.statements()        # joint moves of the pseudo-program
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike

from assistant.base.arrays import Floats, Truths, reals
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused
from assistant.base.length_units import length_text
from assistant.cell.collision.continuous import RESOLUTION
from assistant.cell.findings import (
    FEWER_LINES,
    GOAL_NOT_REACHED,
    GOAL_TOUCHES,
    LESS_MARGIN,
    NO_PATH,
    NO_ROBOT,
    PATH_OUTSIDE_LIMITS,
    PATH_TILTED,
    SENSELESS_VALUE,
    START_TOUCHES,
    STOPS_AT_CORNERS,
    WRONG_JOINT_COUNT,
)
from assistant.cell.planning.path_search import SearchResult, search_path, shorten_path
from assistant.cell.planning.program_moves import (
    Route,
    RouteCheck,
    goal_on_line,
    in_branch,
    round_corners,
    with_lines,
)
from assistant.cell.planning.space import TILT_TOLERANCE, Cone, Space, goal_joints
from assistant.cell.scene import PlacedRobot, Scene
from assistant.program.geometry import FLANGE, IDENTITY, Pose
from assistant.program.motion import MAXIMUM_SPEED, Speed
from assistant.program.program import Program
from assistant.program.se3 import AnyPose, Unit, pose_of
from assistant.program.statements import Move, MoveJoints
from assistant.robots.robot import Robot

_TOUCHING: Final = 2.0 * RESOLUTION
"""mm that two bodies must be apart for a way to begin or to end there: what is nearer cannot be
told from contact."""
_SECONDS: Final = 10.0


@dataclass(frozen=True, slots=True, eq=False)
class Planned:
    """A motion that is proven clear.

    route: its joints, moves and blends. seconds: duration of the search. moves_tried: number of
    moves that were examined. findings: requests that are not fully met.
    """

    route: Route
    seconds: float
    moves_tried: int
    findings: tuple[Diagnostic, ...]

    @property
    def robot(self) -> Robot:
        return self.route.robot

    @property
    def rows(self) -> Floats:
        """(n, a) joints, the start first."""
        return self.route.rows

    @property
    def radii(self) -> Floats:
        """(n - 1,) mm of the blend at the end of each move, 0 for a stop."""
        return self.route.radii

    @property
    def linear(self) -> Truths:
        """(n - 1,) whether the tip goes on a straight line; else all axes move straight."""
        return self.route.linear

    @property
    def tool(self) -> Pose:
        """The tip in the flange."""
        return self.route.tip

    @property
    def length(self) -> float:
        """Seconds of all axes at full speed, root of the sum of squares, between the rows."""
        return float(np.linalg.norm(np.diff(self.rows, axis=0) / self.robot.speeds, axis=1).sum())

    def statements(
        self, speed: Speed = MAXIMUM_SPEED, tool: str = FLANGE
    ) -> tuple[MoveJoints | Move, ...]:
        """Moves from the start on. tool: its name; lines and blends are those of its tip."""
        return self.route.statements(speed, tool)

    def program(self, name: str = "way", speed: Speed = MAXIMUM_SPEED) -> Program:
        """A program of the moves, which begins at the start."""
        return self.route.program(name, speed)


def plan(
    scene: Scene,
    start: ArrayLike,
    goal: AnyPose | ArrayLike,
    *,
    unit: Unit | None = None,
    robot: str | None = None,
    tool: AnyPose = IDENTITY,
    others: Mapping[str, ArrayLike] | None = None,
    margin: float | None = None,
    cone: Cone | None = None,
    linear: bool = False,
    seconds: float = _SECONDS,
    seed: int = 1,
) -> Planned:
    """A way of a robot from joints to a pose of its tool, or to other joints.

    start: (a,) degrees, mm of an axis that slides. goal: the pose of the tip in the base of the
    robot, a `Pose`, an SE3 or a matrix (4, 4), held in whichever way (branch, turns) is found
    first, or joints (a,). unit: of the positions of SE3 and matrices. robot: its name in the scene,
    None for the only one. tool: the tip in the flange; bodies that move with it are those of the
    scene. others: (a,) joints of other robots by name, at home if it names them not.
    margin: mm, None for the margins of the scene. cone: how far the tool may be tilted. linear:
    the tip goes on straight lines where the arm can follow them and they are clear. seconds: the
    search takes at most. seed: of what is random.

    Every move of the way, rounded corners included, keeps the margins by `continuous.hits`. A body
    that is within its margin at the start, or at every way to hold the goal, is kept as far away as
    it is there, with a finding.

    Raises Refused, with a finding: a start outside the limits, in contact or tilted; a goal out
    of reach, inside something or tilted; no way found in time, with the nearest approach; no
    robot of that name; without coal or OMPL.
    """
    placed = _robot(scene.robots, robot)
    if not isinstance(tool, Pose):
        tool = pose_of(tool, unit=unit, what="tool")
    if hasattr(goal, "A") or np.shape(goal) == (4, 4):
        goal = pose_of(goal, unit=unit, what="goal")
    _sensible(goal, tool, margin, cone, seconds)
    begin = _joints(placed.robot, start, "start", "begins")
    where = {}
    for name, joints in (others or {}).items():
        other = _robot([one for one in scene.robots if one is not placed], name)
        where[name] = _joints(other.robot, joints, f"`{name}`", "has")
    space = Space(scene, placed, others=where, margin=margin, cone=cone, tool=tool)
    found = list(_start(space, begin))
    goals, said = _goals(space, begin, goal)
    found += said
    searched = _searched(space, begin, goals, linear, seconds, seed)
    if searched.rows is None:
        raise Refused(_no_way(space, goals, goal, searched.nearest, searched.seconds))
    near = in_branch(space, searched.rows[-1], goals) if linear else goals
    rows = shorten_path(space, searched.rows, near, seed=seed)
    route, seen = _route(space, rows, linear)
    if seen.moves:  # nothing that `Space.clear` proves is hit: a guard, should that be wrong
        near = seen.hits[0].joints[space.columns] if seen.hits else begin
        raise Refused(_no_way(space, goals, goal, near, searched.seconds))
    found += _told(route, linear)
    return Planned(route, searched.seconds, space.asked, tuple(found))


def _searched(
    space: Space, start: Floats, goals: Floats, linear: bool, seconds: float, seed: int
) -> SearchResult:
    """A way to one of goals (k, a); for lines first to those in the branch of the start."""
    rest = seconds
    if linear:
        near = in_branch(space, start, goals)
        straight = goal_on_line(space, start, near)
        if straight is not None:
            return SearchResult(np.stack([start, straight]), straight, 0.0)
        if 0 < len(near) < len(goals):
            found = search_path(space, start, near, seconds=seconds / 2.0, seed=seed)
            if found.rows is not None:
                return found
            rest = max(seconds - found.seconds, 0.0)
    found = search_path(space, start, goals, seconds=rest, seed=seed)
    return replace(found, seconds=found.seconds + seconds - rest)


def _route(space: Space, rows: Floats, linear: bool) -> tuple[Route, RouteCheck]:
    """The moves through joints (n, a), and what is met on them nonetheless."""
    if linear:
        straight, lines = with_lines(space, rows)
        done = round_corners(space, straight, lines)
        if done.seen.good:
            return Route(space.robot, straight, done.radii, lines, space.tool), done.seen
    none = np.zeros(len(rows) - 1, dtype=bool)
    done = round_corners(space, rows, none)
    return Route(space.robot, rows, done.radii, none, space.tool), done.seen


def _told(route: Route, linear: bool) -> Iterator[Diagnostic]:
    """Yield findings for requests that the route does not fully meet."""
    stops = int((route.radii[:-1] == 0.0).sum())
    if stops:
        yield STOPS_AT_CORNERS(count=stops, total=len(route.radii) - 1)
    others = int((~route.linear).sum())
    if linear and others:
        yield FEWER_LINES(count=others, total=len(route.linear))


def _sensible(
    goal: Pose | ArrayLike, tool: Pose, margin: float | None, cone: Cone | None, seconds: float
) -> None:
    """Raises Refused for what is no number, or none that can be meant."""
    numbers, vectors = "finite numbers", "three finite numbers that are not all 0"
    asked: list[tuple[str, object, bool, str]] = [
        ("the tool", tool, _is_pose(tool), numbers),
        ("the goal", goal, not isinstance(goal, Pose) or _is_pose(goal), numbers),
        ("the time", seconds, 0.0 <= seconds < np.inf, "seconds, 0 or more"),
    ]
    if margin is not None:
        asked.append(("the margin", margin, 0.0 <= margin < np.inf, "mm, 0 or more"))
    if cone is not None:
        angle = 0.0 <= cone.angle <= 180.0
        asked += [
            ("the angle of the cone", cone.angle, angle, "degrees from 0 to 180"),
            ("the direction of the cone", cone.direction, _is_vector(cone.direction), vectors),
            ("the axis of the cone", cone.axis, _is_vector(cone.axis), vectors),
        ]
    for what, value, good, wanted in asked:
        if not good:
            raise Refused(SENSELESS_VALUE(what=what, value=value, wanted=wanted), exit_status=2)


def _is_pose(pose: Pose) -> bool:
    return bool(np.isfinite(pose.position).all()) and _is_vector(pose.quaternion)


def _is_vector(values: tuple[float, ...]) -> bool:
    """True if the numbers are finite and not all 0."""
    return bool(np.isfinite(values).all()) and float(np.square(values).sum()) > 0.0


def _robot(robots: Sequence[PlacedRobot], name: str | None) -> PlacedRobot:
    for placed in robots:
        if placed.name == name or (name is None and len(robots) == 1):
            return placed
    names = ", ".join(placed.name for placed in robots)
    raise Refused(NO_ROBOT(name=name or "", names=names or "none"), exit_status=2)


def _joints(robot: Robot, values: ArrayLike, what: str, where: str) -> Floats:
    row = reals(values)
    row = row[0] if row.ndim == 2 and len(row) == 1 else row
    if row.ndim != 1:
        raise Refused(
            WRONG_JOINT_COUNT(what=what, given=row.size, robot=robot.title, wanted=len(robot.axes)),
            exit_status=2,
        )
    given = int(np.isfinite(row).sum())
    if len(row) != len(robot.axes) or given != len(row):
        raise Refused(
            WRONG_JOINT_COUNT(what=what, given=given, robot=robot.title, wanted=len(robot.axes)),
            exit_status=2,
        )
    if not bool(robot.inside(row)):
        low, high = robot.limits.T
        axis = int(np.argmax(np.maximum(low - row, row - high)))
        raise Refused(
            PATH_OUTSIDE_LIMITS(
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
    if len(distances) and distances[pair] <= _TOUCHING:
        contact = space.contact(row, pair)
        deep = length_text(max(-float(distances[pair]), 0.0))
        raise Refused(START_TOUCHES(one=contact.one, other=contact.other, deep=deep))
    _upright(space, row, "begins")
    yield from _less(space, row, distances, "begins")


def _upright(space: Space, row: Floats, where: str) -> None:
    tilt = float(space.tilt(row[None])[0])
    if space.cone is not None and tilt > space.cone.angle + TILT_TOLERANCE:
        raise Refused(PATH_TILTED(where=where, angle=tilt, most=space.cone.angle))


def _less(space: Space, row: Floats, distances: Floats, where: str) -> Iterator[Diagnostic]:
    """Less margin for what is within it at a place; a finding for each two bodies."""
    told = set[tuple[str, str]]()
    for pair in np.flatnonzero(distances <= space.margins + _TOUCHING):
        margin, least = float(space.margins[pair]), float(distances[pair]) - _TOUCHING
        space.margins[pair] = min(margin, least)
        contact = space.contact(row, int(pair))
        names = contact.one, contact.other
        if names not in told and least < margin - _TOUCHING:
            told.add(names)
            said: dict[str, Any] = {
                "least": length_text(max(least, 0.0)),
                "margin": margin,
                "where": where,
            }
            yield LESS_MARGIN(one=names[0], other=names[1], **said)


def _goals(
    space: Space, start: Floats, goal: Pose | ArrayLike
) -> tuple[Floats, tuple[Diagnostic, ...]]:
    """Return the free joints (k, a) at the goal; raises Refused if all are blocked."""
    if isinstance(goal, Pose):
        goals = goal_joints(space.robot, goal, start, space.tool)
        if not len(goals):
            raise Refused(GOAL_NOT_REACHED(robot=space.robot.title, goal=_shown(goal)))
    else:
        goals = _joints(space.robot, goal, "goal", "ends")[None]
    _upright(space, goals[0], "ends")
    free = goals[space.free(goals)]
    if len(free):
        return free, ()
    distances = np.array([space.distances(row) for row in goals])
    least = distances.min(axis=1)
    if least.max() <= _TOUCHING:
        best = int(np.argmax(least))
        contact = space.contact(goals[best], int(np.argmin(distances[best])))
        raise Refused(
            GOAL_TOUCHES(
                goal=_shown(goal),
                one=contact.one,
                other=contact.other,
                deep=length_text(max(-float(least[best]), 0.0)),
                count=len(goals),
            )
        )
    best = int(
        np.argmax(np.where(least > _TOUCHING, (distances - space.margins).min(axis=1), -1e9))
    )
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
    return NO_PATH(
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
