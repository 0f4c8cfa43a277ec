"""A trajectory for an arm that is led along it: where its joints and its tool are over time."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Final

import numpy as np

from assistant.base.arrays import Floats
from assistant.base.diagnostics import Diagnostic, Refused, error, fold, has_errors
from assistant.compiler.arms import Arms, teaching_arm
from assistant.compiler.crossing import for_arm
from assistant.compiler.loading import load
from assistant.compiler.teaching import own_joints
from assistant.compiler.turning import with_chosen_turns
from assistant.controllers.states import Position
from assistant.controllers.trajectory_execution import TimedMotion
from assistant.program.program import Program
from assistant.program.statements import Comment, Moving, Statement, Wait

if TYPE_CHECKING:
    from assistant.robots import Robot
    from assistant.robots.solved_program import SolvedProgram

NOT_ONLY_MOTION: Final = error(
    "CO721",
    "the program does more than move: `{what}` is done by nobody while an arm is led",
    "leave it out, or translate the program and start it on the controller",
)
NO_MOTION: Final = error("CO722", "there is no motion in it", "name a trajectory")
MOTION_UNKNOWN: Final = error(
    "CO723", "how it moves is not known before it runs: {what}", "name a trajectory without that"
)


def trajectory_of_source(
    source: str, robot: Robot, position: Position | None, period: float, speed: float
) -> TimedMotion:
    """The motion of a trajectory, or of a program that only moves, from where the arm is now.

    It begins with the way to the first target, as the source says to go there (a joint move, if
    it says nothing). position: None where nobody tells, to begin at the first target. period:
    seconds between moments, at most. speed: percent of what the source says.
    Raises Refused for what cannot be reached, and for what is more than motion.
    """
    loaded = load(source, robot=robot)
    return trajectory_of_program(
        loaded.program, robot, position, period, speed, source, loaded.findings
    )


def trajectory_of_program(
    program: Program,
    robot: Robot,
    position: Position | None,
    period: float,
    speed: float,
    source: str,
    findings: Sequence[Diagnostic] = (),
) -> TimedMotion:
    """The same of a program that is there already. source: what findings call it."""
    _check_only_moves(program, source)
    program, changed = for_arm(program, teaching_arm(program, Arms(robot)), robot)
    from assistant import robots
    from assistant.robots.timing import simulate

    program, turned = with_chosen_turns(program, robot)
    changed += turned
    solved = robots.solve_program(replace(program, robot=robot.name), robot)
    found = (*findings, *changed, *solved.findings)
    told = tuple(fold(finding.within(source) for finding in found))
    if has_errors(told):
        raise Refused(*told)
    scale = speed / 100.0
    done = simulate(solved, start=_start_joints(solved, position))
    if done.unknown:
        raise Refused(MOTION_UNKNOWN(path=source, what=str(done.unknown[0])))
    if not done.seconds > 0.0:
        raise Refused(NO_MOTION(path=source))
    # So many that the last one is at the end.
    count = max(1, math.ceil(done.seconds / (period * scale)))
    samples = replace(done, wanted_period=done.seconds / count).samples
    return TimedMotion(
        axes=robot.axes,
        sliding=tuple(bool(slides) for slides in robot.sliding),
        seconds=samples.t / scale,
        joints=samples.joints,
        positions=samples.position,
        quaternions=samples.quaternion,
        speeds=robot.speeds,
        accelerations=robot.accelerations,
        limits=robot.limits,
        findings=told,
    )


def _start_joints(solved: SolvedProgram, position: Position | None) -> Floats:
    """(a,) joints where it begins: at the first target, if nobody tells where the arm is."""
    if position is not None:
        return np.array(own_joints(position, solved.robot))
    legs = solved.legs.get(solved.program.entry or "", ())
    known = (leg.joints[0] for leg in legs if len(leg.joints))
    return next(known, np.array(solved.robot.home))


def _check_only_moves(program: Program, source: str) -> None:
    for statement in _statements_run(program):
        if not isinstance(statement, Moving | Wait | Comment):
            raise Refused(NOT_ONLY_MOTION(path=source, what=type(statement).__name__))
        if getattr(statement, "triggers", ()):
            raise Refused(NOT_ONLY_MOTION(path=source, what="a signal on the way"))
        if getattr(statement, "until", None) is not None:
            raise Refused(NOT_ONLY_MOTION(path=source, what="what breaks a move off"))


def _statements_run(program: Program) -> Iterator[Statement]:
    entry = program.procedure(program.entry) if program.entry else None
    yield from entry.body if entry is not None else ()
