"""Planned paths as moves of a program: straight lines of the tool, and rounded corners.

The proof is of the motion that the controller makes of the moves: joint moves and straight lines
with their corners as `robots.timing` cuts them, tested by `collision.continuous`. A line is solved
and timed as a separate program, which has to keep the branch and the turns that it begins with and
to end at the joints of the path.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import Final

import numpy as np

from assistant.base.arrays import Floats, Truths, norms
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Severity
from assistant.cell.collision.continuous import Hit, hits
from assistant.cell.planning.space import Space
from assistant.program.expressions import JointValue, TargetValue
from assistant.program.geometry import FLANGE, IDENTITY, JointTarget, Pose, Target, Tool
from assistant.program.motion import FINE, MAXIMUM_SPEED, Blend, Speed, configuration_of
from assistant.program.program import Procedure, Program
from assistant.program.statements import Motion, Move, MoveJoints
from assistant.robots import solve_program
from assistant.robots.configurations import QUADRANTS
from assistant.robots.robot import Robot
from assistant.robots.timing import simulate
from assistant.robots.timing.uninterrupted_moves import stretches_of

_BLEND_RADII: Final = (50.0, 20.0, 5.0)
"""mm of blends, the largest that stays clear is taken."""
_TOOL_NAME: Final = "tool"


def _joint_target(robot: Robot, row: Floats) -> JointTarget:
    """Joints (a,) as a target, NaN for an axis in between that the arm does not have."""
    values = [float("nan")] * (max(robot.places) + 1)
    for place, value in zip(robot.places, row.tolist(), strict=True):
        values[place] = value + 0.0
    return JointTarget(tuple(values))


def _rounded_pose(pose: Pose) -> Pose:
    """A pose in as many digits as are worth saying."""
    position, turn = (
        np.round(pose.position, _POSE_DIGITS[0]),
        np.round(pose.quaternion, _POSE_DIGITS[1]),
    )
    return Pose.of(position + 0.0, turn + 0.0)


_POSE_DIGITS: Final = (6, 12)
"""Decimals of positions in mm and of quaternions."""


@dataclass(frozen=True, slots=True, eq=False)
class Route:
    """A way of an arm through joints.

    rows: (n, a) joints, the start first. radii: (n - 1,) mm of the blend at the end of each move,
    0 for a stop. linear: (n - 1,) whether the tip goes there on a straight line, or all axes move
    straight. tip: of the tool in the flange.
    """

    robot: Robot
    rows: Floats
    radii: Floats
    linear: Truths
    tip: Pose

    def statements(
        self, speed: Speed = MAXIMUM_SPEED, tool: str = FLANGE
    ) -> tuple[MoveJoints | Move, ...]:
        """The moves of which the arm stands at the start. tool: the name of the tip."""
        return tuple(self._moves(speed, tool))

    def _moves(self, speed: Speed, tool: str) -> Iterator[MoveJoints | Move]:
        p, q = self.robot.flange_poses(self.rows)
        shapes = self.robot.configuration(self.rows)
        for to, (radius, linear) in enumerate(zip(self.radii, self.linear, strict=True), start=1):
            motion = Motion(speed, Blend(float(radius)) if radius else FINE, tool)
            if linear:
                stated = configuration_of(shapes[to]) if self.robot.arm.named else None
                target = Target(_rounded_pose(Pose.of(p[to], q[to]) @ self.tip), stated)
                yield Move("linear", TargetValue(target), motion)
            else:
                yield MoveJoints(JointValue(_joint_target(self.robot, self.rows[to])), motion)

    def program(self, name: str, speed: Speed = MAXIMUM_SPEED) -> Program:
        """A program of these moves only."""
        plain = self.tip == IDENTITY
        statements = self.statements(speed, FLANGE if plain else _TOOL_NAME)
        tools = {} if plain else {_TOOL_NAME: Tool(self.tip)}
        return Program(name, (Procedure("main", statements),), robot=self.robot.name, tools=tools)


@dataclass(frozen=True, slots=True, eq=False)
class RouteCheck:
    """Result of checking a route as the controller runs it.

    driven: True if the arm runs all of it as its moves state: within reach and limits, in the
    branch that they begin with, and to the joints of the route. hits: points that are closer than
    the margins. moves: the numbers of the moves that have hits, or that tilt the tool too far.
    """

    driven: bool
    hits: tuple[Hit, ...]
    moves: tuple[int, ...]

    @property
    def good(self) -> bool:
        """True if the route is proven."""
        return self.driven and not self.moves


@dataclass(frozen=True, slots=True, eq=False)
class RoundedCorners:
    """Radii (n - 1,) mm of blends, and what is seen with them."""

    radii: Floats
    seen: RouteCheck


def round_corners(space: Space, rows: Floats, linear: Truths) -> RoundedCorners:
    """The largest of `_BLEND_RADII` at each corner of a way with which it keeps its margins and
    tilt.

    rows: (n, a). linear: (n - 1,), see `Route`.
    """
    sizes = np.append(_BLEND_RADII, 0.0)
    tips, _ = space.tip(rows)
    room = norms(np.diff(tips, axis=0)) / 2.0  # a controller rounds no further than half a move
    room = np.minimum(room, np.append(room[1:], 0.0))
    level = np.minimum((sizes[:-1] > room[:, None]).sum(axis=1), len(_BLEND_RADII) - 1)
    level[-1] = len(_BLEND_RADII)
    while True:
        radii = sizes[level]
        seen = check_route(space, Route(space.robot, rows, radii, linear, space.tool))
        # A move is bent by the corner that it leads to and by the one that it comes from.
        corners = np.unique([c for m in seen.moves for c in (m - 1, m) if c >= 0])
        corners = corners[level[corners] < len(_BLEND_RADII)] if len(corners) else corners
        if not len(corners):
            return RoundedCorners(radii, seen)
        level[corners.astype(np.intp)] += 1


def check_route(space: Space, route: Route) -> RouteCheck:
    """Check a route for reach, branch, tilt and collisions."""
    solved = solve_program(route.program("way"), space.robot)
    usual = {one.code for one in space.robot.findings}
    bad = [f for f in solved.findings if f.severity is not Severity.INFO and f.code not in usual]
    if bad and route.linear.any():
        return RouteCheck(False, (), ())
    found: list[Hit] = []
    numbers: set[int] = set()
    driven = True
    for passed in simulate(solved, start=route.rows[0]).passed:
        way = stretches_of(passed.plan)
        ends = [piece.number for piece in passed.pieces]
        driven &= not len(passed.plan.course.knots.guessed)
        driven &= bool(np.abs(way.joints[-1] - route.rows[ends[-1]]).max() < _SAME_JOINTS)
        for hit in hits(space.model, space.way(way), space.margins):
            found.append(hit)
            at = min(int(hit.at), len(way.row) - 1)
            numbers.add(passed.piece_of(int(way.row[at]))[0].number - 1)
        if space.cone is not None:
            upright = space.upright(way.joints[:-1], way.joints[1:], _CORNER_TILT, way.slack)
            numbers |= {passed.piece_of(int(m))[0].number - 1 for m in way.row[~upright]}
    return RouteCheck(driven, tuple(found), tuple(sorted(numbers)))


_CORNER_TILT: Final = 0.2
"""degrees by which a rounded corner may be tilted further than its cone."""
_SAME_JOINTS: Final = 1e-3
"""degrees (mm) by which joints may differ where a straight line ends, and be the same."""


_JOINT_MOVE_PARTS: Final = 8
"""That a joint move is cut into, for lines."""
_MOST_LINE_PARTS: Final = 32
"""Parts of a way of several moves, about."""
_SHORTEST_LINE: Final = 1.0
"""mm that the tip goes at least on a line that is worth one."""


def goal_on_line(space: Space, start: Floats, goals: Floats) -> Floats | None:
    """The goal (a,), of goals (k, a) in order, to which a line from joints (a,) is free, if any."""
    for goal in goals:
        if _line_is_clear(space, start, goal):
            return np.asarray(goal)
    return None


def with_lines(space: Space, rows: Floats) -> tuple[Floats, Truths]:
    """A way (n, a) with lines as long as they can be: rows (m, a), and for each move whether it is.

    Joint moves that stay in a branch are cut into `_JOINT_MOVE_PARTS`, so that several lines may
    stand for one. From each place on a line goes as far as one is found that is clear; where none
    is, the joint move stays.
    """
    parts = int(np.clip(_MOST_LINE_PARTS // (len(rows) - 1), 1, _JOINT_MOVE_PARTS))
    moves = [_cut(space, one, other, parts) for one, other in pairwise(rows)]
    places = np.concatenate([rows[:1], *moves])
    move = np.repeat(np.arange(len(moves)), [len(part) for part in moves])  # to a place but one
    kept, linear, at = [0], list[bool](), 0
    while at < len(move):
        to = _farthest(space, places, at)
        same = bool(linear) and not linear[-1] and move[at] == move[at - 1]
        if to:
            kept.append(to)
            linear.append(True)
        elif same:  # on with the joint move that is under way
            kept[-1] = at + 1
        else:
            kept.append(at + 1)
            linear.append(False)
        at = kept[-1]
    return places[kept], np.array(linear)


def _farthest(space: Space, places: Floats, at: int) -> int:
    """The farthest of places (n, a) that a line from one of them reaches, 0 if none."""
    last = len(places) - 1
    while last > at:
        if _line_is_clear(space, places[at], places[last]):
            return last
        last = at + (last - at) // 2
    return 0


def in_branch(space: Space, start: Floats, goals: Floats) -> Floats:
    """Return the goals (k, a) that the arm holds in the branch of joints (a,)."""
    shapes = space.robot.configuration(np.vstack([start, goals]))[:, : QUADRANTS.start]
    return np.asarray(goals[(shapes[1:] == shapes[0]).all(axis=1)])


def _cut(space: Space, start: Floats, end: Floats, parts: int) -> Floats:
    """(k, a) joints on a joint move, its end the last."""
    if not len(in_branch(space, start, end[None])):
        return end[None]
    rows = start + np.linspace(0.0, 1.0, parts + 1)[1:, None] * (end - start)
    rows[-1] = end
    return np.asarray(rows)


def _line_is_clear(space: Space, start: Floats, end: Floats) -> bool:
    """True if the tip can move in a line from joints (a,) to joints (a,), with margins and tilt."""
    rows = np.stack([start, end])
    tips, _ = space.tip(rows)
    if np.linalg.norm(tips[1] - tips[0]) < _SHORTEST_LINE:
        return False
    # The first move stands still: it tells the branch and the turns that the line begins with.
    route = Route(space.robot, rows[[0, 0, 1]], np.zeros(2), np.array([False, True]), space.tool)
    return check_route(space, route).good
