"""Teaching: where a controller says that its arm is, as a target of a file."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Final

import numpy as np

from assistant.base import rotations
from assistant.base.diagnostics import Refused, error
from assistant.base.file_sets import write_files
from assistant.base.source_text import SourceText, decode, encode, read_bytes
from assistant.controllers.states import Position
from assistant.program.expressions import Name
from assistant.program.geometry import Configuration, Pose
from assistant.program.program import Program
from assistant.program.statements import Motion, Move, MoveCircular
from assistant.sources import process_of
from assistant.sources.process.file import ENCODINGS
from assistant.sources.reading import Reading
from assistant.sources.tables.teaching import (
    TaughtTarget,
    is_otherwise_equal,
    new_file_text,
    with_target,
)

if TYPE_CHECKING:
    from assistant.robots import Robot

POSE_OF_OTHER_TOOL: Final = error(
    "CO701",
    "the controller shows a pose that is {distance:.2f} mm and {angle:.2f} degrees off where its "
    "joints put tool `{tool}` in frame `{frame}`",
    "declare in {file} the tool and the frame that the controller uses, and name them, or store "
    "joints",
)
JOINTS_OF_OTHER_ARM: Final = error(
    "CO702",
    "the controller tells joints {told}, and `{robot}` has {axes}",
    "correct `robot` of the controller in the project's file",
)
TARGET_CHANGES_OTHERS: Final = error(
    "CO703",
    "`{name}` cannot be written into {file} without changing the rest of it; it was not touched",
    "name another file",
)
POSE_INCOMPLETE: Final = error(
    "CO704", "the controller tells no whole pose", "store joints, or ask it again"
)
MOST_POSE_OFFSET: Final = 2.0
"""mm that a shown pose may be off: a hundredth of a degree in each joint, and the lengths of
the catalogue, which are not those of one calibrated arm."""
MOST_POSE_TURN: Final = 0.5
"""degrees, as well."""

MOST_ARM_JOINTS: Final = 6
"""Joints that no external axis has; those behind may be of the arm or not."""


@dataclass(frozen=True, slots=True)
class TargetOptions:
    """How targets are stored.

    joints: as joint angles, not as a pose. tool, frame: that the controller shows the pose of
    and in, by their names in the file; None for what the file's [motion] says. again: a target
    of the same name is taught anew.
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
        name, _target_values(position, robot, own, wanted), more_keys(wanted), arm
    )
    source, changed, reading = taught_text(file, target, wanted)
    if robot is not None and own is not None and not wanted.joints:
        _check_pose(file, position, robot, own, reading, name)
    write_taught(file, source, changed, name)
    return reading


def taught_text(
    file: FilePath, target: TaughtTarget, wanted: TargetOptions
) -> tuple[SourceText, SourceText, Reading]:
    """The text of a file as it is and with a target, and what that reads as.

    Raises Refused and Unreadable.
    """
    source = _file_text(file, target.robot)
    changed, reading = with_target(source, file.stem, target, process_of(file), again=wanted.again)
    return source, changed, reading


def write_taught(file: FilePath, source: SourceText, changed: SourceText, name: str) -> None:
    """Writes a text that says something else of one target only; raises Refused."""
    if not is_otherwise_equal(source.text, changed.text, name):
        raise Refused(TARGET_CHANGES_OTHERS(path=str(file), name=name, file=file))
    write_files({file.name: encode(changed)}, file.parent)


def own_joints(position: Position, robot: Robot) -> tuple[float, ...]:
    """(a,) joints of the arm's axes as a controller tells them; raises Refused for another arm."""
    told = {f"J{i}": joint for i, joint in enumerate(position.joints, 1) if joint is not None}
    others = {f"J{i}" for i in range(1, MOST_ARM_JOINTS + 1)} & told.keys() - {*robot.axes}
    if others or not told.keys() >= {*robot.axes}:
        there, axes = " ".join(told) or "none", " ".join(robot.axes)
        raise Refused(JOINTS_OF_OTHER_ARM(told=there, robot=robot.name, axes=axes), exit_status=2)
    return tuple(told[axis] for axis in robot.axes)


def _file_text(file: FilePath, robot: str | None) -> SourceText:
    if file.exists():
        return decode(read_bytes(file, allow_empty=True), str(file), ENCODINGS)
    return SourceText(new_file_text(robot), str(file), "utf-8", "\n")


def _target_values(
    position: Position, robot: Robot | None, own: tuple[float, ...] | None, wanted: TargetOptions
) -> dict[str, str]:
    if wanted.joints:
        joints = (math.nan if joint is None else joint for joint in position.joints)
        return {"joints": number_list(joints_without_end(list(joints)), 4)}
    numbers = (*position.position, *position.quaternion)
    if not all(map(math.isfinite, numbers)):
        raise Refused(POSE_INCOMPLETE())
    found = {
        "position": number_list(position.position, 4),
        "quaternion": number_list(rotations.canonical(position.quaternion).tolist(), 9),
    }
    if robot is not None and own is not None:
        found["configuration"] = branch_words(branch_at(robot, own))
    return found


def branch_at(robot: Robot, joints: Sequence[float]) -> Configuration:
    """The branch that the arm is on with joints (a,)."""
    back, down, flip, *q = (int(v) for v in robot.configuration(np.array([joints]))[0])
    return Configuration(bool(back), bool(down), bool(flip), (q[0], q[1], q[2]))


def branch_words(branch: Configuration) -> str:
    """As the TOML of a file of targets."""
    words = {"back": branch.back, "down": branch.down, "flip": branch.flip}
    said = ", ".join(f"{word} = {'true' if on else 'false'}" for word, on in words.items())
    return f"{{{said}, quadrants = {list(branch.quadrants)}}}"


def joints_without_end(joints: list[float]) -> list[float]:
    """Joints without those behind the last axis of the arm."""
    while joints and math.isnan(joints[-1]):
        joints.pop()
    return joints


def more_keys(wanted: TargetOptions) -> dict[str, str]:
    """Tool and frame as the TOML of a file of targets."""
    given = {"tool": wanted.tool, "frame": wanted.frame}
    return {key: json.dumps(name) for key, name in given.items() if name is not None}


def number_list(values: Sequence[float], digits: int) -> str:
    """As the TOML of a file of targets."""
    return "[" + ", ".join(_number_text(value, digits) for value in values) + "]"


def _number_text(value: float, digits: int) -> str:
    """With as many digits as a controller tells, at least one behind the point; `nan` for none."""
    if math.isnan(value):
        return "nan"
    whole, _, part = f"{round(value, digits) + 0.0:.{digits}f}".partition(".")
    return f"{whole}.{part.rstrip('0') or '0'}"


def _check_pose(
    file: FilePath,
    position: Position,
    robot: Robot,
    own: tuple[float, ...],
    reading: Reading,
    name: str,
) -> None:
    """Raises Refused if the pose is not of the tool and frame that the file says it is of."""
    program = reading.program
    motion = motion_to(program, name)
    tool_name, frame_name = str(motion.tool), str(motion.frame)
    tool, frame = program.tools.get(tool_name), program.frames.get(frame_name)
    if (tool is not None and not tool.held) or (frame is not None and frame.held):
        return
    positions, quaternions = robot.fk(np.array([own]))
    tip = Pose.of(positions[0], quaternions[0]) @ (Pose() if tool is None else tool.tip)
    expected = tip if frame is None else frame.pose.inverse() @ tip
    distance = math.dist(expected.position, position.position)
    angle = float(rotations.angle_between(expected.quaternion, position.quaternion))
    if distance > MOST_POSE_OFFSET or angle > MOST_POSE_TURN:
        finding = POSE_OF_OTHER_TOOL(
            path=str(file),
            distance=distance,
            angle=angle,
            tool=tool_name,
            frame=frame_name,
            file=file,
        )
        raise Refused(finding)


def motion_to(program: Program, name: str) -> Motion:
    """The motion of the one move that a file of targets makes to each of them."""
    moves = (s for s in program.procedures[0].body if isinstance(s, Move | MoveCircular))
    for move in moves:
        named = (move.target,) if isinstance(move, Move) else (move.via, move.target)
        if any(isinstance(one, Name) and one.name.lower() == name.lower() for one in named):
            return move.motion
    raise LookupError(name)
