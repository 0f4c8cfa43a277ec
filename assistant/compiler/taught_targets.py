"""Taught targets of a file: from the position of a controller, or shown to cameras.

The branch of a target that was shown to cameras is computed: the one whose joints are nearest to
those that the arm has, or has at home. `program_to_target` is the program that moves the arm
there.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused, error, warning
from assistant.base.file_sets import write_files
from assistant.base.source_text import SourceText, decode, encode, read_bytes
from assistant.base.toml_edits import rounded
from assistant.controllers.states import Position
from assistant.program.expressions import Name
from assistant.program.geometry import Configuration, Pose, Target
from assistant.program.program import Procedure, Program
from assistant.program.settings_tables import ENCODINGS
from assistant.program.statements import Motion, Move, MoveCircular
from assistant.sources import process_of
from assistant.sources.reading import Reading
from assistant.sources.tables.taught import (
    TARGET_EXISTS,
    TaughtTarget,
    new_file_text,
    with_target,
)

if TYPE_CHECKING:
    from assistant.robots import Robot


_POSE_OF_OTHER_TOOL: Final = error(
    "CO701",
    "the controller shows a pose that is {distance:.2f} mm and {angle:.2f} degrees off where its "
    "joints put tool `{tool}` in frame `{frame}`",
    "declare in {file} the tool and the frame that the controller uses, and name them, or store "
    "joints",
)
_JOINTS_OF_OTHER_ARM: Final = error(
    "CO702",
    "the controller tells joints {told}, and `{robot}` has {axes}",
    "correct `robot` of the controller in the project's file",
)
_POSE_INCOMPLETE: Final = error(
    "CO704", "the controller tells no whole pose", "store joints, or ask it again"
)
_MOST_POSE_OFFSET: Final = 2.0
"""mm that a shown pose may be off: a hundredth of a degree in each joint, and the lengths of
the catalogue, which are not those of one calibrated arm."""
_MOST_POSE_TURN: Final = 0.5
"""degrees, as well."""

_MOST_ARM_JOINTS: Final = 6
"""Joints that no external axis has; those behind may be of the arm or not."""


@dataclass(frozen=True, slots=True)
class TargetOptions:
    """Options for storing targets.

    joints: as joint angles, not as a pose. tool, frame: the controller's pose is of this tool and
    in this frame, by their names in the file; None for those of the file's [motion]. again: replace
    a target of the same name.
    """

    joints: bool = False
    tool: str | None = None
    frame: str | None = None
    again: bool = False


def teach_target(
    file: FilePath, name: str, position: Position, robot: Robot | None, wanted: TargetOptions
) -> Reading:
    """Stores a position under a name into a file of taught targets, a new one if it is not there.

    robot: the arm, which tells the branch of a pose, and whether the pose is of the tool that
    the file says. The file is written whole or not at all, and read back before.
    Raises Refused and Unreadable.
    """
    own = own_joints(position, robot) if robot is not None else None
    arm = None if robot is None else robot.name
    target = TaughtTarget(
        name, _target_values(position, robot, own, wanted), _more_keys(wanted), arm
    )
    changed, reading = _taught_text(file, target, wanted)
    # The file states the tool and frame of the target, so it is read before the pose is checked.
    if robot is not None and own is not None and not wanted.joints:
        _check_pose(file, position, robot, own, reading, name)
    _write_taught(file, changed)
    return reading


def _taught_text(
    file: FilePath, target: TaughtTarget, wanted: TargetOptions
) -> tuple[SourceText, Reading]:
    """The text of a file with a target, and what it reads as.

    Raises Refused and Unreadable.
    """
    source = _file_text(file, target.robot)
    return with_target(source, file.stem, target, process_of(file), again=wanted.again)


def _write_taught(file: FilePath, changed: SourceText) -> None:
    write_files({file.name: encode(changed)}, file.parent)


def own_joints(position: Position, robot: Robot) -> tuple[float, ...]:
    """(a,) joints of the arm's axes as a controller tells them; raises Refused for another arm."""
    told = {f"J{i}": joint for i, joint in enumerate(position.joints, 1) if joint is not None}
    others = {f"J{i}" for i in range(1, _MOST_ARM_JOINTS + 1)} & told.keys() - {*robot.axes}
    if others or not told.keys() >= {*robot.axes}:
        there, axes = " ".join(told) or "none", " ".join(robot.axes)
        raise Refused(_JOINTS_OF_OTHER_ARM(told=there, robot=robot.name, axes=axes), exit_status=2)
    return tuple(told[axis] for axis in robot.axes)


def _file_text(file: FilePath, robot: str | None) -> SourceText:
    if file.exists():
        return decode(read_bytes(file, allow_empty=True), str(file), ENCODINGS)
    return SourceText(new_file_text(robot), str(file), "utf-8", "\n")


def _target_values(
    position: Position, robot: Robot | None, own: tuple[float, ...] | None, wanted: TargetOptions
) -> dict[str, Any]:
    if wanted.joints:
        joints = (math.nan if joint is None else joint for joint in position.joints)
        return {"joints": rounded(_joints_without_end(list(joints)), 4)}
    numbers = (*position.position, *position.quaternion)
    if not all(map(math.isfinite, numbers)):
        raise Refused(_POSE_INCOMPLETE())
    found: dict[str, Any] = {
        "position": rounded(position.position, 4),
        "quaternion": rounded(rotations.canonical(position.quaternion).tolist(), 9),
    }
    if robot is not None and own is not None:
        found["configuration"] = branch_table(branch_at(robot, own))
    return found


def branch_at(robot: Robot, joints: Sequence[float]) -> Configuration:
    """The branch that the arm is on with joints (a,)."""
    back, down, flip, *q = (int(v) for v in robot.configuration(np.array([joints]))[0])
    return Configuration(bool(back), bool(down), bool(flip), (q[0], q[1], q[2]))


def branch_table(branch: Configuration) -> dict[str, Any]:
    """Return a configuration as a file of targets has it."""
    words = {"back": branch.back, "down": branch.down, "flip": branch.flip}
    return {**words, "quadrants": list(branch.quadrants)}


def _joints_without_end(joints: list[float]) -> list[float]:
    """Return the joints without unused values after the last axis of the arm."""
    while joints and math.isnan(joints[-1]):
        joints.pop()
    return joints


def _more_keys(wanted: TargetOptions) -> dict[str, str]:
    """Tool and frame of a new target."""
    given = {"tool": wanted.tool, "frame": wanted.frame}
    return {key: name for key, name in given.items() if name is not None}


def _check_pose(
    file: FilePath,
    position: Position,
    robot: Robot,
    own: tuple[float, ...],
    reading: Reading,
    name: str,
) -> None:
    """Check that the pose is of the tool and frame that the file states; raise Refused
    otherwise.
    """
    program = reading.program
    motion = _motion_to(program, name)
    tool_name, frame_name = str(motion.tool), str(motion.frame)
    tool, frame = program.tools.get(tool_name), program.frames.get(frame_name)
    # The flange alone does not give the pose of a stationary tool or of held work.
    if (tool is not None and not tool.held) or (frame is not None and frame.held):
        return
    positions, quaternions = robot.flange_poses(np.array([own]))
    tip = Pose.of(positions[0], quaternions[0]) @ (Pose() if tool is None else tool.tip)
    expected = tip if frame is None else frame.pose.inverse() @ tip
    distance = math.dist(expected.position, position.position)
    angle = float(rotations.angle_between(expected.quaternion, position.quaternion))
    if distance > _MOST_POSE_OFFSET or angle > _MOST_POSE_TURN:
        finding = _POSE_OF_OTHER_TOOL(
            path=str(file),
            distance=distance,
            angle=angle,
            tool=tool_name,
            frame=frame_name,
            file=file,
        )
        raise Refused(finding)


def _motion_to(program: Program, name: str) -> Motion:
    """The motion of the one move that a file of targets makes to each of them."""
    moves = (s for s in program.procedures[0].body if isinstance(s, Move | MoveCircular))
    for move in moves:
        named = (move.target,) if isinstance(move, Move) else (move.via, move.target)
        if any(isinstance(one, Name) and one.name.lower() == name.lower() for one in named):
            return move.motion
    raise LookupError(name)


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
_DEVICE_TURNED_INTO_PLANE: Final = warning(
    "CO733",
    "the device was tilted {angle:.1f} degrees out of the plane that an arm of five axes turns its "
    "tool in; the target is turned into it",
    "look whether that does",
)
_NO_CAMERA_FRAME: Final = error(
    "CO734",
    "the file declares no frame `{name}`, in which the cameras stand",
    "declare [frames.{name}] with the pose of the cameras' world in the base of the robot",
)
_ARM_RESTS_ELSEWHERE: Final = error(
    "CO735",
    "the arm came to rest {distance:.2f} mm and {angle:.2f} degrees from the place that was shown, "
    "{most:.1f} mm and {turned:.1f} degrees allowed; nothing was stored",
    "look at what holds it, and show the place again",
)
_MOST_DEVICE_TILT: Final = 15.0
"""Degrees, of an arm of five axes."""
_REPORTED_TILT: Final = 1.0
"""Degrees of tilt from which it is reported."""
_MOST_PLANE_ROUNDS: Final = 30
_MOST_REST_OFFSET: Final = 1.0
"""mm that an arm may come to rest from where it was sent."""
_MOST_REST_TURN: Final = 0.5


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
        """Program of the file with the target in it."""
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
    first = TaughtTarget(name, _pose_values(shown), _more_keys(wanted), arm)
    program = _taught_text(file, first, wanted)[1].program
    motion = _motion_to(program, name)
    tool_name, frame_name = str(motion.tool), str(motion.frame)
    tool, frame = program.tools.get(tool_name), program.frames.get(frame_name)
    flange_to_tip = tool.tip if tool is not None and tool.held else Pose()
    tip = _shown_in_base(shown, program, world, file)
    joints: Floats | None = None
    findings: tuple[Diagnostic, ...] = ()
    values: dict[str, Any] = {}
    if robot is not None:
        flange, findings = _flange_in_plane(tip @ flange_to_tip.inverse(), flange_to_tip, robot)
        joints = _nearest_joints(flange, robot, near, tool_name)
        tip = flange @ flange_to_tip
    pose = tip if frame is None or frame.held else frame.pose.inverse() @ tip
    if wanted.joints and joints is not None and robot is not None:
        values["joints"] = rounded(_with_all_axes(joints, robot), 4)
    else:
        values |= _pose_values(pose)
        if joints is not None and robot is not None:
            values["configuration"] = branch_table(branch_at(robot, joints.tolist()))
    target = replace(first, values=values)
    return ShownTarget(
        name, pose, joints, tip, target, _taught_text(file, target, wanted)[1], findings
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
        _taught_text(
            file, TaughtTarget(name, _pose_values(Pose()), _more_keys(wanted), arm), wanted
        )


def turned_into_plane(positions: Floats, quaternions: Floats, robot: Robot | None) -> Floats:
    """Quaternions (n, 4) that an arm takes with a tool along the axis of its flange.

    Those of an arm of six axes stay as they are. Raises Refused where they would turn too far.
    """
    if robot is None or not robot.five_axis:
        return quaternions
    from assistant.robots.arms.closed_form import from_ab, to_ab

    turned = from_ab(positions, to_ab(positions, quaternions))
    angle = float(rotations.angle_between(quaternions, turned).max())
    if angle > _MOST_DEVICE_TILT:
        raise Refused(DEVICE_TILTED(angle=angle, most=_MOST_DEVICE_TILT))
    return turned


def store_target(file: FilePath, place: ShownTarget, wanted: TargetOptions) -> Reading:
    """Writes the target into the file, whole or not at all; raises Refused and Unreadable."""
    changed, reading = _taught_text(file, place.target, wanted)
    _write_taught(file, changed)
    return reading


def program_to_target(place: ShownTarget, above: float, *, to_its_end: bool = True) -> Program:
    """A program that leads the tool to a place: by joints to where it is so many mm back along
    its own z axis, and straight from there unless the rest is left to others.
    """
    program, name = place.program, place.name
    motion = _motion_to(program, name)
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
    """Return the distance in mm and degrees between an arm's pose, from its joints, and its goal.

    Raises Refused if the arm is elsewhere: then it has not reached the shown target.
    """
    distance = float(np.linalg.norm(np.subtract(place.tip.position, reached.position)))
    angle = float(rotations.angle_between(place.tip.quaternion, reached.quaternion))
    # The negation refuses NaN as well.
    if not (distance <= _MOST_REST_OFFSET and angle <= _MOST_REST_TURN):
        finding = _ARM_RESTS_ELSEWHERE(
            place=place.name,
            distance=distance,
            angle=angle,
            most=_MOST_REST_OFFSET,
            turned=_MOST_REST_TURN,
        )
        raise Refused(finding)
    return distance, angle


def tip_at(place: ShownTarget, joints: tuple[float, ...], robot: Robot) -> Pose:
    """The tool of a place in the base of the robot, with other joints (a,)."""
    positions, quaternions = robot.flange_poses(np.array([joints]))
    return Pose.of(positions[0], quaternions[0]) @ tip_of(place)


def tip_of(place: ShownTarget) -> Pose:
    """The tip of a place's tool on the flange."""
    tool = place.program.tools.get(str(_motion_to(place.program, place.name).tool))
    return tool.tip if tool is not None and tool.held else Pose()


def _pose_values(pose: Pose) -> dict[str, Any]:
    return {
        "position": rounded(pose.position, 4),
        "quaternion": rounded(rotations.canonical(pose.quaternion).tolist(), 9),
    }


def _shown_in_base(shown: Pose, program: Program, world: str | None, file: FilePath) -> Pose:
    if world is None:
        return shown
    name = next((n for n in program.frames if n.lower() == world.lower()), None)
    if name is None:
        raise Refused(_NO_CAMERA_FRAME(path=str(file), name=world), exit_status=2)
    return program.frames[name].pose @ shown


def _flange_in_plane(flange: Pose, tool: Pose, robot: Robot) -> tuple[Pose, tuple[Diagnostic, ...]]:
    """The flange with its axis in the plane of an arm of five axes, the tip where it was."""
    if not robot.five_axis:
        return flange, ()
    from assistant.robots.arms.closed_form import from_ab, to_ab

    tip, wished = flange @ tool, flange.quaternion
    # Turning the flange moves it, and with it its plane: repeated until it stays.
    for _ in range(_MOST_PLANE_ROUNDS):
        place = [flange.position]
        turn = Pose.of(np.zeros(3), from_ab(place, to_ab(place, [wished]))[0])
        before, flange = flange, Pose(tip.position) @ turn @ Pose(tool.position).inverse()
        if np.allclose(before.position, flange.position, atol=1e-9):
            break
    angle = float(rotations.angle_between(wished, flange.quaternion))
    if angle > _MOST_DEVICE_TILT:
        raise Refused(DEVICE_TILTED(angle=angle, most=_MOST_DEVICE_TILT))
    return flange, (_DEVICE_TURNED_INTO_PLANE(angle=angle),) if angle > _REPORTED_TILT else ()


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
