"""A way as the moves of a program, with corners that are rounded as far as it stays clear.

What is proven is what the controller makes of the moves: their corners as `robots.timing` cuts
them, looked at by `collision.continuous`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from assistant.cell.collision.continuous import Hit, Way, hits
from assistant.cell.planning.space import Space
from assistant.program.arrays import Floats
from assistant.program.expressions import JointValue
from assistant.program.geometry import FLANGE, IDENTITY, JointTarget, Pose, Tool
from assistant.program.motion import FINE, MAXIMUM_SPEED, Blend, Speed
from assistant.program.program import Procedure, Program
from assistant.program.statements import Motion, MoveJoints
from assistant.robots import solve_program
from assistant.robots.robot import Robot
from assistant.robots.timing import simulate
from assistant.robots.timing.passed import stretches_of

RADII: Final = (50.0, 20.0, 5.0)
"""mm of blends, the largest that stays clear is taken."""
TOOL: Final = "tool"


def joint_target(robot: Robot, row: Floats) -> JointTarget:
    """Joints (a,) as a target, NaN for an axis in between that the arm does not have."""
    values = [float("nan")] * (max(robot.places) + 1)
    for place, value in zip(robot.places, row.tolist(), strict=True):
        values[place] = value + 0.0
    return JointTarget(tuple(values))


def moves(
    robot: Robot, rows: Floats, radii: Floats, speed: Speed = MAXIMUM_SPEED, tool: str = FLANGE
) -> tuple[MoveJoints, ...]:
    """Joint moves through joints (n, a), of which the arm stands at the first.

    radii: (n - 1,) mm of the blend at the end of each move, 0 for a stop.
    """
    return tuple(
        MoveJoints(
            JointValue(joint_target(robot, row)),
            Motion(speed, Blend(float(radius)) if radius else FINE, tool),
        )
        for row, radius in zip(rows[1:], radii, strict=True)
    )


def program_of(name: str, robot: Robot, statements: tuple[MoveJoints, ...], tip: Pose) -> Program:
    """A program of moves only."""
    tools = {} if tip == IDENTITY else {TOOL: Tool(tip)}
    return Program(name, (Procedure("main", statements),), robot=robot.name, tools=tools)


@dataclass(frozen=True, slots=True, eq=False)
class Rounded:
    """Radii (n - 1,) mm of blends, and what is too near to something nonetheless."""

    radii: Floats
    hits: tuple[Hit, ...]


def rounded(space: Space, rows: Floats) -> Rounded:
    """The largest of `RADII` at each corner of a way with which it keeps its margins and tilt."""
    level = np.zeros(len(rows) - 1, dtype=np.intp)
    level[-1] = len(RADII)
    sizes = np.append(RADII, 0.0)
    found: tuple[Hit, ...] = ()
    while True:
        radii = sizes[level]
        found, moves_hit = _looked_at(space, rows, radii)
        # A move is bent by the corner that it leads to and by the one that it comes from.
        corners = np.unique([c for m in moves_hit for c in (m - 1, m) if c >= 0])
        corners = corners[level[corners] < len(RADII)] if len(corners) else corners
        if not len(corners):
            return Rounded(radii, found)
        level[corners.astype(np.intp)] += 1


def _looked_at(space: Space, rows: Floats, radii: Floats) -> tuple[tuple[Hit, ...], list[int]]:
    """Where moves come too near to anything, and the numbers of the moves that do."""
    tool = FLANGE if space.tool == IDENTITY else TOOL
    statements = moves(space.robot, rows, radii, tool=tool)
    solved = solve_program(program_of("way", space.robot, statements, space.tool), space.robot)
    found: list[Hit] = []
    numbers: set[int] = set()
    for passed in simulate(solved, start=rows[0]).passed:
        way = stretches_of(passed.plan)
        joints = space.all_joints(way.joints)
        slack = np.zeros((len(way.slack), joints.shape[1]))
        slack[:, space.columns] = way.slack
        for hit in hits(space.model, Way(joints, slack), space.margins):
            found.append(hit)
            at = min(int(hit.at), len(way.row) - 1)
            numbers.add(passed.piece_of(int(way.row[at]))[0].number - 1)
        if space.cone is not None:
            turned = (np.abs(np.diff(way.joints, axis=0)) / 2.0 + way.slack) @ space.turning
            tilt = space.tilt(way.joints)
            high = np.maximum(tilt[1:], tilt[:-1]) + turned > space.cone.angle + SLACK
            numbers |= {passed.piece_of(int(m))[0].number - 1 for m in way.row[high]}
    return tuple(found), sorted(numbers)


SLACK: Final = 0.2
"""degrees by which a rounded corner may be tilted further than its cone."""
