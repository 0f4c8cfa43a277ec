"""Places that somebody showed to cameras: as targets of a file, and as ways that lead an arm there.

Nobody's joints tell the branch of such a target, so it is worked out: the one whose joints are
nearest to those that the arm has, or has at home.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats
from assistant.base.diagnostics import Diagnostic, Refused, error, warning
from assistant.compiler.teaching import (
    TargetOptions,
    branch_at,
    branch_words,
    more_keys,
    motion_to,
    number_list,
    taught_text,
    write_taught,
)
from assistant.program.expressions import Name
from assistant.program.geometry import Pose, Target
from assistant.program.program import Procedure, Program
from assistant.program.statements import Move
from assistant.sources.reading import Reading
from assistant.sources.tables.teaching import TARGET_EXISTS, TaughtTarget

if TYPE_CHECKING:
    from assistant.robots import Robot

OUT_OF_REACH: Final = error(
    "CO731",
    "`{robot}` does not reach the place that was shown with tool `{tool}`: {why}",
    "show a place nearer to it, turn the device otherwise, or name the tool that it has",
)
DEVICE_TILTED: Final = error(
    "CO732",
    "the device was tilted {angle:.1f} degrees out of the plane that an arm of five axes turns its "
    "tool in, {most:.0f} allowed",
    "tilt it towards or away from axis 1 only",
)
DEVICE_TURNED_INTO_PLANE: Final = warning(
    "CO733",
    "the device was tilted {angle:.1f} degrees out of the plane that an arm of five axes turns its "
    "tool in; the target is turned into it",
    "look whether that does",
)
NO_CAMERA_FRAME: Final = error(
    "CO734",
    "the file declares no frame `{name}`, in which the cameras stand",
    "declare [frames.{name}] with the pose of the cameras' world in the base of the robot",
)
ARM_RESTS_ELSEWHERE: Final = error(
    "CO735",
    "the arm came to rest {distance:.2f} mm and {angle:.2f} degrees from the place that was shown, "
    "{most:.1f} mm and {turned:.1f} degrees allowed; nothing was stored",
    "look at what holds it, and show the place again",
)
MOST_DEVICE_TILT: Final = 15.0
"""Degrees, of an arm of five axes."""
REPORTED_TILT: Final = 1.0
"""Degrees from which on it is said."""
MOST_PLANE_ROUNDS: Final = 30
MOST_REST_OFFSET: Final = 1.0
"""mm that an arm may come to rest from where it was sent."""
MOST_REST_TURN: Final = 0.5


@dataclass(frozen=True, slots=True, eq=False)
class ShownTarget:
    """A place that was shown, as a target of a file.

    pose: of the tool in the target's frame. joints: (a,) with which the arm has it there, None
    without an arm. tip: of the tool in the base of the robot.
    """

    name: str
    pose: Pose
    joints: Floats | None
    tip: Pose
    target: TaughtTarget
    reading: Reading
    findings: tuple[Diagnostic, ...] = ()

    @property
    def program(self) -> Program:
        """What the file says with the target in it."""
        return self.reading.program


def target_of_shown(
    file: FilePath,
    name: str,
    shown: Pose,
    robot: Robot | None,
    wanted: TargetOptions,
    near: Floats | None = None,
    world: str | None = None,
) -> ShownTarget:
    """A pose that cameras located, as a target that the arm reaches; nothing is written.

    wanted.tool is what is to come to the place, wanted.frame what the target is stored in, as the
    file declares them. near: (a,) joints of the arm, None for its home. world: frame of the file
    that is the world of the cameras, None for the base of the robot. Raises Refused and Unreadable.
    """
    arm = None if robot is None else robot.name
    first = TaughtTarget(name, _pose_values(shown), more_keys(wanted), arm)
    program = taught_text(file, first, wanted)[2].program
    motion = motion_to(program, name)
    tool_name, frame_name = str(motion.tool), str(motion.frame)
    tool, frame = program.tools.get(tool_name), program.frames.get(frame_name)
    flange_to_tip = tool.tip if tool is not None and tool.held else Pose()
    tip = _shown_in_base(shown, program, world, file)
    joints: Floats | None = None
    findings: tuple[Diagnostic, ...] = ()
    values: dict[str, str] = {}
    if robot is not None:
        flange, findings = _flange_in_plane(tip @ flange_to_tip.inverse(), flange_to_tip, robot)
        joints = _nearest_joints(flange, robot, near, tool_name)
        tip = flange @ flange_to_tip
    pose = tip if frame is None or frame.held else frame.pose.inverse() @ tip
    if wanted.joints and joints is not None and robot is not None:
        values["joints"] = number_list(_with_all_axes(joints, robot), 4)
    else:
        values |= _pose_values(pose)
        if joints is not None and robot is not None:
            values["configuration"] = branch_words(branch_at(robot, joints.tolist()))
    target = replace(first, values=values)
    return ShownTarget(
        name, pose, joints, tip, target, taught_text(file, target, wanted)[2], findings
    )


def check_names(
    file: FilePath, names: Sequence[str], robot: Robot | None, wanted: TargetOptions
) -> None:
    """Raises Refused and Unreadable for names that the file would not take, or not all of them."""
    once: set[str] = set()
    for name in names:
        if name.lower() in once:
            raise Refused(TARGET_EXISTS(path=str(file), name=name))
        once.add(name.lower())
    arm = None if robot is None else robot.name
    for name in names:
        taught_text(file, TaughtTarget(name, _pose_values(Pose()), more_keys(wanted), arm), wanted)


def turned_into_plane(positions: Floats, quaternions: Floats, robot: Robot | None) -> Floats:
    """Quaternions (n, 4) that an arm takes with a tool along the axis of its flange.

    Those of an arm of six axes stay as they are. Raises Refused where they would turn too far.
    """
    if robot is None or not robot.five_axis:
        return quaternions
    from assistant.robots.arms.closed_form import from_ab, to_ab

    turned = from_ab(positions, to_ab(positions, quaternions))
    angle = float(rotations.angle_between(quaternions, turned).max())
    if angle > MOST_DEVICE_TILT:
        raise Refused(DEVICE_TILTED(angle=angle, most=MOST_DEVICE_TILT))
    return turned


def store_target(file: FilePath, place: ShownTarget, wanted: TargetOptions) -> Reading:
    """Writes the target into the file, whole or not at all; raises Refused and Unreadable."""
    source, changed, reading = taught_text(file, place.target, wanted)
    write_taught(file, source, changed, place.name)
    return reading


def program_to_target(place: ShownTarget, above: float, *, to_its_end: bool = True) -> Program:
    """A program that leads the tool to a place: by joints to where it is so many mm back along
    its own z axis, and straight from there unless the rest is left to others.
    """
    program, name = place.program, place.name
    motion = motion_to(program, name)
    branch = program.targets[name].configuration if name in program.targets else None
    before = f"{name}_before"
    targets = {
        before: Target(place.pose.offset(z=-above), branch),
        name: Target(place.pose, branch),
    }
    straight = above > 0.0
    body = [Move("joint", Name(before), motion)] if straight else []
    if to_its_end or not straight:
        body.append(Move("linear" if straight else "joint", Name(name), motion))
    main = Procedure("main", tuple(body))
    return replace(program, procedures=(main,), entry="main", targets=targets, joint_targets={})


def check_reached(place: ShownTarget, reached: Pose) -> tuple[float, float]:
    """How many mm and degrees an arm is from where it was sent, by its joints.

    Raises Refused if the arm is elsewhere: then what it reached is not what was shown.
    """
    distance = float(np.linalg.norm(np.subtract(place.tip.position, reached.position)))
    angle = float(rotations.angle_between(place.tip.quaternion, reached.quaternion))
    if not (distance <= MOST_REST_OFFSET and angle <= MOST_REST_TURN):
        finding = ARM_RESTS_ELSEWHERE(
            place=place.name,
            distance=distance,
            angle=angle,
            most=MOST_REST_OFFSET,
            turned=MOST_REST_TURN,
        )
        raise Refused(finding)
    return distance, angle


def tip_at(place: ShownTarget, joints: tuple[float, ...], robot: Robot) -> Pose:
    """The tool of a place in the base of the robot, with other joints (a,)."""
    positions, quaternions = robot.fk(np.array([joints]))
    return Pose.of(positions[0], quaternions[0]) @ tip_of(place)


def tip_of(place: ShownTarget) -> Pose:
    """The tip of a place's tool on the flange."""
    tool = place.program.tools.get(str(motion_to(place.program, place.name).tool))
    return tool.tip if tool is not None and tool.held else Pose()


def _pose_values(pose: Pose) -> dict[str, str]:
    return {
        "position": number_list(pose.position, 4),
        "quaternion": number_list(rotations.canonical(pose.quaternion).tolist(), 9),
    }


def _shown_in_base(shown: Pose, program: Program, world: str | None, file: FilePath) -> Pose:
    if world is None:
        return shown
    name = next((n for n in program.frames if n.lower() == world.lower()), None)
    if name is None:
        raise Refused(NO_CAMERA_FRAME(path=str(file), name=world), exit_status=2)
    return program.frames[name].pose @ shown


def _flange_in_plane(flange: Pose, tool: Pose, robot: Robot) -> tuple[Pose, tuple[Diagnostic, ...]]:
    """The flange with its axis in the plane of an arm of five axes, the tip where it was."""
    if not robot.five_axis:
        return flange, ()
    from assistant.robots.arms.closed_form import from_ab, to_ab

    tip, wished = flange @ tool, flange.quaternion
    for _ in range(MOST_PLANE_ROUNDS):
        place = [flange.position]
        turn = Pose.of(np.zeros(3), from_ab(place, to_ab(place, [wished]))[0])
        before, flange = flange, Pose(tip.position) @ turn @ Pose(tool.position).inverse()
        if np.allclose(before.position, flange.position, atol=1e-9):
            break
    angle = float(rotations.angle_between(wished, flange.quaternion))
    if angle > MOST_DEVICE_TILT:
        raise Refused(DEVICE_TILTED(angle=angle, most=MOST_DEVICE_TILT))
    return flange, (DEVICE_TURNED_INTO_PLANE(angle=angle),) if angle > REPORTED_TILT else ()


def _nearest_joints(flange: Pose, robot: Robot, near: Floats | None, tool: str) -> Floats:
    """(a,) joints of the branch that is nearest to where the arm is; raises Refused."""
    joints, valid = robot.ik([flange.position], [flange.quaternion])
    if not valid[0].any():
        known = np.isfinite(joints[0]).all(axis=1).any()
        why = "a joint would leave its limits" if known else "it is too far or too near"
        raise Refused(OUT_OF_REACH(robot=robot.name, tool=tool, why=why))
    start = np.array(robot.home) if near is None else near
    off = np.where(valid[0], np.abs(joints[0] - start).max(axis=1), np.inf)
    return np.asarray(joints[0, int(np.argmin(off))])


def _with_all_axes(joints: Floats, robot: Robot) -> list[float]:
    """With a place for each axis that the arm lacks."""
    found = [float("nan")] * (max(robot.places) + 1)
    for place, value in zip(robot.places, joints.tolist(), strict=True):
        found[place] = value
    return found
