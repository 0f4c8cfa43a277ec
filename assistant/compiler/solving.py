"""Solving: a program as one arm goes through it, for what times it, draws it or looks along it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

from assistant import robots
from assistant.base.diagnostics import Diagnostic, Refused, error, fold, has_errors
from assistant.compiler.arms import known_robot, robot_of, teaching_arm, with_robot_of_cell
from assistant.compiler.crossing import for_arm
from assistant.compiler.loading import Loaded
from assistant.compiler.locations import with_locations
from assistant.compiler.scenes import InCell
from assistant.compiler.seen_frames import with_located_frames
from assistant.compiler.source_map import Places, at_moves
from assistant.compiler.travelling import with_planned_travels
from assistant.compiler.turning import with_chosen_turns
from assistant.compiler.unplaced import fold_unplaced_work
from assistant.program.program import Program

if TYPE_CHECKING:
    from assistant.cell.scene import Scene
    from assistant.robots import Robot, SolvedProgram

NO_ROBOT: Final = error(
    "CL010",
    "the program names no robot that it is for",
    "name one with --robot; `robot-assistant robots` lists them",
)


@dataclass(frozen=True, slots=True)
class Solved:
    """A program as the arm goes through it, in a scene if there is one, and where its parts are.

    program: as it was read, before ways were planned and turns chosen.
    """

    solution: SolvedProgram
    scene: Scene | None
    places: Places
    findings: list[Diagnostic]
    program: Program


def solve(
    loaded: Loaded, stands: InCell, source: str | None, from_robot: str | Robot | None = None
) -> Solved:
    """A program for the arm that runs it. Raises Refused if nobody names one.

    stands: the cell, and the robot that was asked for. source: what findings are placed in.
    """
    arms = stands.beside(loaded.seen).arms(robot_of(from_robot))
    program: Program = loaded.program
    arms = with_robot_of_cell(program, arms)
    program, located = with_locations(program, arms)
    program, sights = with_located_frames(program, arms)
    arm = arms.robot or known_robot(program.robot)
    if arm is None:
        raise Refused(NO_ROBOT(path=source), exit_status=2)
    program, changed = for_arm(program, teaching_arm(program, replace(arms, robot=arm)), arm)
    program, turned = with_chosen_turns(program, arm, arms.scene)
    changed += turned
    places = Places(loaded.program, loaded.text)
    ways = with_planned_travels(program, arm, arms.scene, places)
    solution = robots.solve_program(replace(ways.program, robot=arm.name), arm)
    also = () if has_errors(ways.findings) else solution.findings
    changed = (*located, *sights, *changed, *map(places.finding, ways.findings))
    at_lines = map(places.finding, at_moves(also, solution.program, places))
    found = (*loaded.findings, *changed, *fold_unplaced_work(program, arm, at_lines))
    said = [*stands.findings, *fold(f.within(source) for f in found)]
    return Solved(solution, arms.scene, places, said, loaded.program)
