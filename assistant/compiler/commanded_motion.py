"""Motions that an arm is commanded: jogs checked against its limits, programs as trajectories.

`check_jog` computes before a jog whether it stays inside the limits of the arm.
`trajectory_of_source` returns where the joints and the tool are over time, for an arm that is led
along it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats
from assistant.base.diagnostics import Diagnostic, Refused, error, fold, has_errors, warning
from assistant.compiler.arms import Arms, teaching_arm
from assistant.compiler.loader import load
from assistant.compiler.retarget import for_arm, with_chosen_turns
from assistant.compiler.taught_targets import own_joints
from assistant.controllers.states import Jog, Position
from assistant.controllers.trajectory_execution import TimedMotion
from assistant.program.geometry import Pose
from assistant.program.program import Program
from assistant.program.statements import Comment, Moving, Statement, Wait

if TYPE_CHECKING:
    from assistant.robots import Robot
    from assistant.robots.solved_program import SolvedProgram


_JOG_BEYOND_LIMIT: Final = error(
    "CO711",
    "{axis} would come to {value:.2f} {unit}, beyond its limits ({low:g} to {high:g})",
    "move it by less",
)
_NO_AXIS: Final = error("CO712", "there is no axis `{axis}`", "name one of {axes}")
_JOG_OUT_OF_REACH: Final = error(
    "CO713",
    "the arm cannot come there without turning over: {why}",
    "move it by less, or by a joint",
)
_JOG_NOT_CHECKED: Final = warning(
    "CO714",
    "no project says which robot this is, so the limits of its joints are not checked here",
    "write robot = NAME into the table of the controller, or watch the arm",
)
_ARM_OUTSIDE_LIMITS: Final = error(
    "CO715",
    "{axis} is at {value:.2f} {unit}, beyond the limits of `{robot}` ({low:g} to {high:g})",
    "correct `robot` of the controller, or move the axis back by hand at the controller",
)

LINEAR_AXES: Final = ("X", "Y", "Z")
TURNING_AXES: Final = ("A", "B", "C")
"""Turns about X, Y and Z of the frame."""
JOINT_AXES: Final = tuple(f"J{i}" for i in range(1, 9))
_MOST_JOG_STEP: Final = 1.0
"""Most degrees or mm between two checked poses of a straight path."""


def check_jog(jog: Jog, position: Position, robot: Robot | None) -> tuple[Diagnostic, ...]:
    """Return the findings before a jog; raise Refused if it must not be made.

    The robot's base is assumed to be the controller's, and the tool to be the offset between the
    flange and the pose that the controller shows.
    """
    turns = TURNING_AXES[:2] if robot is not None and robot.five_axis else TURNING_AXES
    axes = (*(JOINT_AXES if robot is None else robot.axes), *LINEAR_AXES, *turns)
    if jog.axis not in axes:
        raise Refused(_NO_AXIS(axis=jog.axis, axes=", ".join(axes)), exit_status=2)
    if robot is None:
        return (_JOG_NOT_CHECKED(),)
    joints = np.array(own_joints(position, robot))
    if jog.axis in robot.axes:
        goal = joints.copy()
        goal[robot.axes.index(jog.axis)] += jog.by
        _check_limit(goal, robot, jog.axis)
    else:
        _check_flange_path(joints, jog, position, robot)
    return ()


def check_position(position: Position, robot: Robot | None) -> tuple[Diagnostic, ...]:
    """Check that the arm's position is possible for the project's robot; raise Refused
    otherwise.
    """
    if robot is None:
        return (_JOG_NOT_CHECKED(),)
    joints = own_joints(position, robot)
    for axis, value, unit, (low, high) in zip(
        robot.axes, joints, robot.units, robot.limits, strict=True
    ):
        if not low - _LIMIT_TOLERANCE <= value <= high + _LIMIT_TOLERANCE:
            fields = {"axis": axis, "value": value, "unit": unit, "low": low, "high": high}
            raise Refused(_ARM_OUTSIDE_LIMITS(**fields, robot=robot.name))
    return ()


_LIMIT_TOLERANCE: Final = 0.05
"""Degrees or mm that an axis at its limit may be shown beyond it."""


def _check_limit(joints: np.ndarray, robot: Robot, axis: str) -> None:
    index = robot.axes.index(axis)
    (low, high), value = robot.limits[index], float(joints[index])
    if not low <= value <= high:
        unit = robot.units[index]
        raise Refused(_JOG_BEYOND_LIMIT(axis=axis, value=value, unit=unit, low=low, high=high))


def _check_flange_path(joints: np.ndarray, jog: Jog, position: Position, robot: Robot) -> None:
    """Follows the way of the flange in steps, on the branch that the arm is on."""
    positions, quaternions = robot.flange_poses(joints[None])
    flange = Pose.of(positions[0], quaternions[0])
    shown = Pose(position.position, position.quaternion)
    tool = flange.inverse() @ shown
    steps = max(2, int(np.ceil(abs(jog.by) / _MOST_JOG_STEP)) + 1)
    moved = _jogged_pose_in_plane if robot.five_axis else _jogged_pose
    way = [moved(shown, jog, part) @ tool.inverse() for part in np.linspace(0.0, jog.by, steps)]
    p = np.array([pose.position for pose in way])
    q = np.array([pose.quaternion for pose in way])
    found, valid = robot.ik(p, q)
    # On the branch of the present joints: another one would turn the arm over.
    branch = int(robot.branch_of(robot.configuration(joints[None]))[0])
    wrong = np.flatnonzero(~valid[:, branch])
    if len(wrong):
        part = jog.by * wrong[0] / (steps - 1)
        unit = "mm" if jog.axis in LINEAR_AXES else "degrees"
        why = f"after {part:.0f} {unit} "
        reached = found[wrong[0], branch]
        why += "it is out of reach" if np.isnan(reached).any() else "a joint is at its limit"
        raise Refused(_JOG_OUT_OF_REACH(why=why))


def _jogged_pose(pose: Pose, jog: Jog, by: float) -> Pose:
    """The pose after a part of the motion."""
    if jog.axis in LINEAR_AXES:
        offset = tuple(by if axis == jog.axis else 0.0 for axis in LINEAR_AXES)
        step = Pose((offset[0], offset[1], offset[2]))
    else:
        axis = [float(letter == jog.axis) for letter in TURNING_AXES]
        w, x, y, z = rotations.about(axis, by).tolist()
        step = Pose((0.0, 0.0, 0.0), (w, x, y, z))
    if jog.frame == "tool":
        return pose @ step
    turned = step @ Pose((0.0, 0.0, 0.0), pose.quaternion)
    x, y, z = (a + b for a, b in zip(pose.position, step.position, strict=True))
    return Pose((x, y, z), turned.quaternion)


def _jogged_pose_in_plane(pose: Pose, jog: Jog, by: float) -> Pose:
    """The same of an arm of five axes, whose tool stays in its plane: A and B are kept, or turned.

    They are what its controller shows of an orientation; see `robots.arms.closed_form`.
    """
    from assistant.robots.arms.closed_form import from_ab, to_ab

    angles = to_ab([pose.position], [pose.quaternion])[0]
    if jog.axis in TURNING_AXES:
        angles = angles + np.array([by * (jog.axis == letter) for letter in TURNING_AXES[:2]])
        place = pose.position
    else:
        place = _jogged_pose(pose, jog, by).position
    return Pose.of(np.array(place), from_ab([place], angles)[0])


_NOT_ONLY_MOTION: Final = error(
    "CO721",
    "the program does more than move: `{what}` is done by nobody while an arm is led",
    "leave it out, or translate the program and start it on the controller",
)
_NO_MOTION: Final = error("CO722", "there is no motion in it", "name a trajectory")
_MOTION_UNKNOWN: Final = error(
    "CO723", "how it moves is not known before it runs: {what}", "name a trajectory without that"
)


def trajectory_of_source(
    source: str, robot: Robot, position: Position | None, period: float, speed: float
) -> TimedMotion:
    """Return the motion of a trajectory, or of a program that only moves, from the present
    position.

    It begins with the move to the first target, as the source states it (a joint move by default).
    position: None if unknown, to begin at the first target. period: seconds between moments, at
    most. speed: percent of the source's speed. Raises Refused for targets out of reach, and for
    statements other than motion.
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
        raise Refused(_MOTION_UNKNOWN(path=source, what=str(done.unknown[0])))
    if not done.seconds > 0.0:
        raise Refused(_NO_MOTION(path=source))
    # So many that the last one is at the end.
    count = max(1, math.ceil(done.seconds / (period * scale)))
    samples = replace(done, wanted_period=done.seconds / count).samples
    return TimedMotion(
        controller=robot.controller,
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
            raise Refused(_NOT_ONLY_MOTION(path=source, what=type(statement).__name__))
        if getattr(statement, "triggers", ()):
            raise Refused(_NOT_ONLY_MOTION(path=source, what="a signal on the way"))
        if getattr(statement, "until", None) is not None:
            raise Refused(_NOT_ONLY_MOTION(path=source, what="what breaks a move off"))


def _statements_run(program: Program) -> Iterator[Statement]:
    entry = program.procedure(program.entry) if program.entry else None
    yield from entry.body if entry is not None else ()
