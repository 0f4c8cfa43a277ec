"""Programs of arrays: poses and joints, with speed, blend, tool and frame as plain arguments."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path as FilePath
from typing import Any, Final, Literal

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats, finite_row, number_of, number_within, reals
from assistant.base.diagnostics import Refused, Severity, error, has_errors
from assistant.compiler.arms import robot_of
from assistant.compiler.loader import equipment_facts, language_of
from assistant.compiler.program_forms import with_structure
from assistant.program.analysis.uses import without_unused_equipment
from assistant.program.expressions import JointValue
from assistant.program.geometry import FLANGE, Frame, JointTarget, Load, Pose, Tool
from assistant.program.motion import FINE, Blend, Kind, Speed
from assistant.program.program import Program, identifier
from assistant.program.se3 import NO_POSES, AnyPose, AnyPoses, Unit, pose_of
from assistant.program.statements import Motion, MoveJoints, OwnText
from assistant.robots import Robot
from assistant.sources.process import NO_PROCESS, NO_STYLE, Process
from assistant.sources.process.file import read_process
from assistant.sources.tables import rows
from assistant.sources.tables.headers import shown
from assistant.sources.tables.rows import NOT_FINITE
from assistant.sources.tables.waypoints import read_poses

_NO_JOINTS = error(
    "TB431",
    "`{given}` is no array of joints",
    "give an array (n, {axes}), a row for each point, or what jtraj of roboticstoolbox returns",
)
_JOINT_SHAPE = error(
    "TB432",
    "the shape is {shape}, and {robot} has {axes} axes: {names}",
    "give a row of {axes} values for each point",
)
_JOINT_UNIT = error(
    "TB433", "the unit {unit} of joints is not known", 'write unit="rad" or unit="deg"'
)
_NO_ARM = error(
    "TB434",
    "joint angles mean a place on one arm only, and none is named",
    'name it: robot="irb1200-7-0.7"; assistant.robots.names() lists them',
)
_TOO_MUCH = error(
    "TB435", "{value:g} percent is no part of the joints' speed", "write a number from 1 to 100"
)
_BLEND_WORD = error(
    "TB437", "the blend {given} is not known", 'write mm as a number, or blend="fine" to stop'
)
_NO_PLACE = error(
    "TB436",
    "`{given}` is no {kind}",
    "give the name of one in the process file, three numbers in mm, a Pose, an SE3 or a matrix "
    "(4, 4) in the unit of the poses, or a {type}",
)
_NO_LOAD = error(
    "TB439",
    "{given} is no part of a tool's load",
    "write assistant.Load(2.0, (0.0, 0.0, 60.0)): kg, and the centre of gravity in mm",
)
_UNIT_LENGTH: Final = 1e-3
"""Deviation of the length of a unit quaternion, at most."""
_MAY_BE_METRES = error(
    "TB438",
    "the {what} {given} would be less than a millimetre away: three numbers are mm, and the poses "
    "are in m",
    "write the three numbers in mm, or give a Pose, which is in mm, or an SE3 in m",
)
_LEAST_TIP: Final = 1.0
"""mm within which the three numbers of a tool or frame beside poses in m are meant as metres."""

JointUnit = Literal["rad", "deg"]
_LENGTHS: Final[Mapping[str, Unit]] = {"rad": "m", "deg": "mm"}
"""Unit of the lengths that go with joints in radians, as in roboticstoolbox, and in degrees."""
TOOL: Final = "tool"
FRAME: Final = "frame"
"""End of the name of a tool or a frame given by value, after the name of the program."""


def from_poses(
    poses: AnyPoses,
    *,
    unit: Unit | None = None,
    name: str = "path",
    speed: float | None = None,
    travel: float | None = None,
    approach: float | None = None,
    retract: float | None = None,
    percent: float | None = None,
    blend: float | Literal["fine"] | None = None,
    tool: str | Tool | AnyPose | None = None,
    frame: str | Frame | AnyPose | None = None,
    robot: str | Robot | None = None,
    process: str | FilePath | Process | None = None,
) -> Program:
    """Return a program that follows poses.

    poses: one spatialmath SE3 of many poses (the result of roboticstoolbox's `ctraj`), an array (n,
    7) of x y z and a quaternion w x y z, or (n, 4, 4), columns (n, 3) and (n, 4), or a sequence of
    SE3, matrices or `Pose`. unit: of their positions, "mm" or "m"; it is not guessed,
    roboticstoolbox uses metres; a `Pose` is in mm whatever the unit. speed: mm/s of the tool along
    the poses, 100 if nothing else states it; travel: mm/s of the joint move to the first pose, 200
    if nothing else states it; approach, retract: mm along the tool's axis in a line to the first
    pose and away from the last one, 0 if nothing else states them; percent: of the joints' greatest
    speed, for that joint move in languages that state joint moves so; without it `joint_percent` of
    the process file. blend: mm at which a corner may be rounded, the first and the last pose are
    stops; "fine" to stop at each; without one, corners are rounded within the tolerance. tool: name
    of a tool in the process file, or a value: its tip in the flange as three numbers in mm, as a
    `Pose`, as an SE3 or matrix in `unit`, or a complete `Tool`. frame: the frame of the poses, in
    the same forms, in the robot's base. robot: the arm that runs the program. process: file with
    tools, frames, signals and all that is not stated here.

    Warnings are issued as Python warnings; errors raise Refused.
    """
    given = {TOOL: tool, FRAME: frame}
    stated = _process(process, speed, percent, blend, given, robot, unit, str(name))
    ways: dict[str, Any] = {}
    if travel is not None:
        ways["travel"] = Speed(_positive(travel, "travel"))
    for key, length in (("approach", approach), ("retract", retract)):
        if length is not None:
            ways[key] = _length(length, key)
    stated = replace(stated, defaults=replace(stated.defaults, **ways))
    reading = read_poses(poses, replace(stated, merges=True), str(name), unit=unit)
    for finding in (*stated.findings, *reading.findings):
        if finding.severity is Severity.WARNING:
            warnings.warn(str(finding), stacklevel=2)
    program = without_unused_equipment(reading.program)
    program = replace(
        program, comments=(*program.comments, *map(OwnText, equipment_facts(program)))
    )
    # As a table of the same poses: a procedure for each path, with what it is.
    return with_structure(program, NO_STYLE)


def from_joints(
    joints: Any,
    *,
    unit: JointUnit,
    robot: str | Robot | None = None,
    name: str = "path",
    speed: float | None = None,
    percent: float | None = None,
    blend: float | Literal["fine"] | None = None,
    tool: str | Tool | AnyPose | None = None,
    process: str | FilePath | Process | None = None,
) -> Program:
    """Return a program of joint moves through rows of joints.

    joints: array (n, a) for the a axes of the arm in their order, or an object with such an array
    as `q`, like the trajectory of roboticstoolbox's `jtraj`. unit: "rad", sliding axes in m, as in
    roboticstoolbox, or "deg", sliding axes in mm. robot: the arm of the joints. speed: mm/s of the
    tool at most, 100 if nothing else states it; percent: of the joints' greatest speed, for
    languages that state joint moves so; without it `joint_percent` of the process file. The time of
    each row is lost: a program states speeds, and the controller goes as fast as these allow.
    blend: mm at which the path may leave a row for the next one, "fine" to stop at each; without
    one, the arm stops only at the ends and where the tool tip stays or turns back sharply, and
    keeps within the tolerance. tool, process: as for `from_poses`; an SE3 is in m beside "rad", in
    mm beside "deg".

    Raises Refused for errors; `check` and `compile` check the joint limits.
    """
    if not isinstance(unit, str) or unit not in _LENGTHS:
        raise Refused(_JOINT_UNIT(place="unit", unit=shown(str(unit))))
    length = _LENGTHS[unit]
    stated = _process(process, speed, percent, blend, {TOOL: tool}, robot, length, str(name))
    arm = robot_of(stated.robot if robot is None else robot)
    if arm is None:
        raise Refused(_NO_ARM(place="robot"))
    values = _in_degrees(_array_of(joints, arm), unit, arm)
    found = rows.default_findings(stated, None)
    if has_errors(found):
        raise Refused(*found)
    kinds = np.full(len(values), Kind.JOINT, dtype=np.uint8)
    motions = rows.default_motions(len(values), stated)
    columns = motions.rounded(_tips(values, arm, stated), kinds, stated.tolerance)
    defaults, blends = stated.defaults, columns["blends"]
    body = [
        MoveJoints(
            JointValue(JointTarget(_spread(row, arm))),
            Motion(defaults.speed, blends[index], defaults.tool, defaults.frame),
        )
        for row, index in zip(values.tolist(), columns["blend"].tolist(), strict=True)
    ]
    for finding in stated.findings:
        if finding.severity is Severity.WARNING:
            warnings.warn(str(finding), stacklevel=2)
    program = rows.program_of(identifier(str(name)), body, replace(stated, robot=arm.name))
    return without_unused_equipment(program)


def _process(
    given: str | FilePath | Process | None,
    speed: float | None,
    percent: float | None,
    blend: float | Literal["fine"] | None,
    places: Mapping[str, Any],
    robot: str | Robot | None,
    unit: Unit | None,
    program: str,
) -> Process:
    """Return a process file with the options given beside it; raise Refused.

    places: tool and frame, None if not given. unit: of those that are SE3 or matrices. program: its
    name, with which those begin that are given by value: a task may run several programs.
    """
    if given is None:
        given = NO_PROCESS
    stated = given if isinstance(given, Process) else read_process(given)
    changed: dict[str, Any] = {}
    if percent is None and getattr(stated.defaults.speed, "joint", None) is None:
        percent = _percent_of(stated, robot)
    if speed is not None or percent is not None:
        changed["speed"] = _speed(stated, speed, percent)
    if blend is not None:
        changed["blend"] = _blend(blend)
    tools, frames = dict(stated.tools), dict(stated.frames)
    if places.get(TOOL) is not None:
        changed[TOOL] = _declared(places[TOOL], TOOL, Tool, tools, unit, program)
    if places.get(FRAME) is not None:
        changed[FRAME] = _declared(places[FRAME], FRAME, Frame, frames, unit, program)
    arm = stated.robot if robot is None else getattr(robot_of(robot), "name", None)
    defaults = replace(stated.defaults, **changed)
    return replace(stated, defaults=defaults, tools=tools, frames=frames, robot=arm)


def _percent_of(stated: Process, robot: str | Robot | None) -> float | None:
    """Return `joint_percent` of a process file, None for an arm that takes no percents."""
    if stated.joint_percent is None:
        return None
    arm = robot_of(stated.robot if robot is None else robot)
    takes = arm is None or any(language_of(name).joint_percent for name in arm.languages)
    return stated.joint_percent if takes else None


def _positive(given: float, place: str) -> float:
    """Return a speed in mm/s; raise Refused unless it is positive."""
    value = number_of(given, place)
    if not value > 0.0:
        raise Refused(rows.TOO_SLOW(place=place, what=f"the {place}", value=value, more=""))
    return value


def _length(given: float, place: str) -> float:
    """Return a length in mm that is not negative; raise Refused."""
    value = number_of(given, place)
    if value < 0.0:
        raise Refused(rows.NEGATIVE(place=place, what=f"the {place}", value=value, more=""))
    return value


def _speed(stated: Process, tcp: float | None, percent: float | None) -> Speed:
    tcp = None if tcp is None else _positive(tcp, "speed")
    percent = None if percent is None else number_of(percent, "percent")
    if percent is not None and not 0.0 < percent <= 100.0:
        raise Refused(_TOO_MUCH(place="percent", value=percent))
    known = stated.defaults.speed
    base = known if isinstance(known, Speed) else Speed(100.0)
    changed = {"tcp": tcp, "joint": percent}
    return replace(base, **{key: float(v) for key, v in changed.items() if v is not None})


def _blend(blend: float | Literal["fine"]) -> Blend:
    if isinstance(blend, str):
        if blend == "fine":
            return FINE
        raise Refused(_BLEND_WORD(place="blend", given=shown(blend)))
    radius = number_of(blend, "blend")
    if not radius >= 0.0:
        raise Refused(rows.NEGATIVE(place="blend", what="the blend", value=radius, more=""))
    return Blend(radius) if radius else FINE


def _declared(
    given: Any,
    name: str,
    kind: type[Tool] | type[Frame],
    table: dict[str, Any],
    unit: Unit | None,
    program: str,
) -> str:
    """Return the name of a tool or frame, and add it to the table if it is given by value."""
    if isinstance(given, str):
        return given
    free = identifier(f"{program}_{name}", frozenset(table))
    table[free] = _tool_or_frame(given, name, kind, unit)
    return free


def _tool_or_frame(
    given: Any, name: str, kind: type[Tool] | type[Frame], unit: Unit | None
) -> Tool | Frame:
    """Return a tool or frame given by value; raise Refused for one that is wrong."""
    if isinstance(given, Tool) and kind is Tool:
        return replace(given, tip=_pose(given.tip, name, kind, unit), load=_load(given.load))
    if isinstance(given, Frame) and kind is Frame:
        user, within = (_pose(one, name, kind, unit) for one in (given.user, given.object))
        return replace(given, user=user, object=within)
    return kind(_pose(given, name, kind, unit))


def _load(given: Any) -> Load | None:
    """Return the load of a tool; raise Refused for one that no tool has."""
    if given is None:
        return None
    if not isinstance(given, Load):
        raise Refused(_NO_LOAD(place=TOOL, given=shown(str(given))))
    parts = {"centre": 3, "axes": 4, "inertia": 3}
    rows = {part: finite_row(getattr(given, part), f"`{part}` of the load") for part in parts}
    wrong = next((part for part, size in parts.items() if len(rows[part]) != size), None)
    if wrong is None and abs(np.linalg.norm(rows["axes"]) - 1.0) > _UNIT_LENGTH:
        wrong = "axes"
    if wrong is not None:
        raise Refused(_NO_LOAD(place=TOOL, given=shown(str(getattr(given, wrong)))))
    mass = number_within(given.mass, "`mass` of the load", above=0.0)
    for value in rows["inertia"]:
        number_within(value, "`inertia` of the load", least=0.0)
    return replace(given, mass=mass, **{part: tuple(row.tolist()) for part, row in rows.items()})


def _pose(given: Any, name: str, kind: type[Tool] | type[Frame], unit: Unit | None) -> Pose:
    """Return the pose of a tool or frame: three numbers in mm, or a form of `pose_of`."""
    if isinstance(given, Pose) or np.shape(given) != (3,):
        try:
            return pose_of(given, unit=unit, what=name)
        except Refused as refused:
            if refused.findings[0].code != NO_POSES.code or isinstance(given, Pose):
                raise
            wrong = _NO_PLACE(place=name, given=str(given)[:80], kind=name, type=kind.__name__)
            raise Refused(wrong) from None
    try:
        x, y, z = reals(given).tolist()
    except ValueError:
        wrong = _NO_PLACE(place=name, given=str(given)[:80], kind=name, type=kind.__name__)
        raise Refused(wrong) from None
    if not all(np.isfinite((x, y, z))):
        raise Refused(NOT_FINITE(place=name, what=f"the {name}", value=given, more=""))
    if isinstance(unit, str) and unit == "m" and 0.0 < max(map(abs, (x, y, z))) < _LEAST_TIP:
        raise Refused(_MAY_BE_METRES(place=name, what=name, given=f"({x:g}, {y:g}, {z:g})"))
    return Pose((x, y, z))


def _array_of(joints: Any, arm: Robot) -> Floats:
    """Return the joints as rows (n, a); raise Refused."""
    given = getattr(joints, "q", joints)
    wrong = _NO_JOINTS(place="joints", given=type(joints).__name__, axes=len(arm.axes))
    try:
        array = reals(given)
    except (TypeError, ValueError):
        raise Refused(wrong) from None
    if array.ndim == 0:
        raise Refused(wrong)
    array = array[None] if array.ndim == 1 else array
    if array.ndim != 2 or array.shape[1] != len(arm.axes) or not len(array):
        shape = "(" + ", ".join(map(str, np.shape(given))) + ")"
        said: Mapping[str, Any] = {"robot": arm.name, "names": ", ".join(arm.axes)}
        raise Refused(_JOINT_SHAPE(place="joints", shape=shape, axes=len(arm.axes), **said))
    return array


def _in_degrees(values: Floats, unit: JointUnit, arm: Robot) -> Floats:
    """Degrees, and mm of sliding axes; raises Refused for what is not finite."""
    bad = np.argwhere(~np.isfinite(values))
    if len(bad):
        row, axis = bad[0].tolist()
        what, more = f"the joint {arm.axes[axis]}", f" ({len(bad)} such)" if len(bad) > 1 else ""
        fields: dict[str, Any] = {"what": what, "value": values[row, axis], "more": more}
        raise Refused(NOT_FINITE(place=f"joints[{row}]", **fields))
    if unit == "deg":
        return values
    return np.where(arm.sliding, values * 1000.0, np.degrees(values))


def _tips(values: Floats, arm: Robot, process: Process) -> Floats:
    """Return the positions of the tool tip (n, 3), in mm."""
    positions, quaternions = arm.fk(values)
    named = rows.known_tool(process.defaults.tool, process)
    tool = Tool() if named in (None, FLANGE) else process.tools[str(named)]
    if not tool.held:
        return positions
    return np.asarray(positions + rotations.rotate(quaternions, np.array(tool.tip.position)))


def _spread(row: Sequence[float], arm: Robot) -> tuple[float, ...]:
    """The values of a row at the places of their axes; NaN for one that the arm has not."""
    full = [float("nan")] * (max(arm.places) + 1)
    for place, value in zip(arm.places, row, strict=True):
        full[place] = value
    return tuple(full)
