"""The targets of a program as goals in the world."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats
from assistant.cell.reach.placing import Goals, turned_about_z
from assistant.cell.scene import PlacedRobot
from assistant.program.geometry import Pose
from assistant.program.statements import MoveJoints
from assistant.robots.motion.run import Run
from assistant.robots.solved_program import SolvedProgram

TARGET_DIGITS: Final = 6
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
            key = tuple(round(value, TARGET_DIGITS) for value in (*pose.position, *pose.quaternion))
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
