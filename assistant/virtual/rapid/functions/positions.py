"""Functions that tell where the arm is, and with which tool and work object."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Final

import numpy as np

from assistant.base.arrays import Floats
from assistant.languages.rapid.tree import syntax as s
from assistant.program.geometry import Pose
from assistant.robots.configurations import from_confdata, to_confdata
from assistant.virtual.kernel.motion import Standing
from assistant.virtual.rapid.ends import Fault, NotSimulated
from assistant.virtual.rapid.given import Given, table_row
from assistant.virtual.rapid.machine import Function, Machine
from assistant.virtual.rapid.motion import flange_of
from assistant.virtual.rapid.poses import (
    confdata,
    extjoint_of,
    joints_of,
    jointtarget,
    number,
    pos,
    pose_of,
    record,
    robtarget,
)
from assistant.virtual.rapid.predefined import tool0, wobj0
from assistant.virtual.rapid.values import Record


def _current_target(given: Given) -> Pose:
    """The position in the tool and work object that are named, else in those of the latest move.

    CRobT without them reads in the active tool and work object: tool0 and wobj0 before a motion, as
    in a controller that was just started.
    """
    tool = given.optional_record("tool", "tooldata") or given.machine.arm.tool or tool0()
    frame = given.optional_record("wobj", "wobjdata")
    if frame is None:
        frame = given.machine.arm.frame or wobj0()
    standing = _arm_standing(given)
    return given.machine.arm.reading(tool, frame, None if standing is None else standing[0])


def _arm_standing(given: Given) -> Standing | None:
    """Where the arm is now, also on its way; None if only the motions tell."""
    machine, motion = given.machine, given.machine.task.kernel.motion
    if machine.robot is None:
        return None
    standing = motion.where()
    if not motion.stands():
        machine.hangs_on.add("time")
    return standing


def present_target(given: Given) -> Record:
    """CRobT: in the tool and work object of its options."""
    arm, machine, standing = given.machine.arm, given.machine, _arm_standing(given)
    joints = arm.joints if standing is None else standing[1]
    configuration = arm.configuration
    if joints is not None and (configuration is None or standing is not None):
        configuration = _stated_configuration(machine, joints)
    return robtarget(_current_target(given), configuration, arm.external)


def _current_joints(given: Given) -> Record:
    """Where the arm was sent by a position, it stands as the configuration of that tells."""
    arm, machine, standing = given.machine.arm, given.machine, _arm_standing(given)
    joints = arm.joints if standing is None else standing[1][:6]
    if joints is None and arm.watches_joints and arm.watches_lines and arm.flange is not None:
        joints = _solved_joints(machine, arm.flange, arm.configuration)
    if joints is None:
        raise NotSimulated("joints that are read behind a motion to a position")
    return jointtarget(joints, arm.external)


def _target_of_joints(given: Given) -> Record:
    target, tool = given.record(0, "jointtarget"), given.record(1, "tooldata")
    frame = given.optional_record("wobj", "wobjdata") or wobj0()
    arm, joints = given.machine.arm, joints_of(target)
    flange = flange_of(given.machine, joints)
    if flange is None:
        raise NotSimulated("CalcRobT without a robot")
    there = arm.reading(tool, frame, flange)
    axes = extjoint_of(target.parts["extax"], [-offset for offset in arm.offsets])
    return robtarget(there, _stated_configuration(given.machine, joints), axes)


def _joints_of_target(given: Given) -> Record:
    """CalcJointT: with the displacement and the offset that are active."""
    target, tool = given.record(0, "robtarget"), given.record(1, "tooldata")
    frame = given.optional_record("wobj", "wobjdata") or wobj0()
    arm, machine = given.machine.arm, given.machine
    if machine.robot is None:
        raise NotSimulated("CalcJointT without a robot")
    flange = arm.flange_at(pose_of(target), tool, frame)
    joints = _solved_joints(machine, flange, record(target.parts["robconf"], "confdata"))
    if joints is None:
        _, excess = machine.robot.solve(*_joint_rows(flange))
        reached = bool((excess <= 0.0).any())
        raise Fault("a position that the robot does not reach", UNREACHED_ERROR[reached])
    return jointtarget(joints, extjoint_of(target.parts["extax"], arm.offsets))


UNREACHED_ERROR: Final = {False: "ERR_OUTSIDE_REACH", True: "ERR_ROBLIMIT"}
"""By whether the arm is long enough (manual, CalcJointT)."""


def _joint_rows(flange: Pose) -> tuple[Floats, Floats]:
    return np.array([flange.position]), np.array([flange.quaternion])


def _solved_joints(
    machine: Machine, flange: Pose, configuration: Record | None
) -> tuple[float, ...] | None:
    """The six joints at a pose of the flange, None where there are none in this configuration."""
    robot = machine.robot
    if robot is None or configuration is None or not robot.arm.named or len(robot.axes) > 6:
        return None
    stated = [[int(number(part)) for part in configuration.parts.values()]]
    found = robot.joints_of(*_joint_rows(flange), from_confdata(stated))[0]
    if bool(np.isnan(found).any()):
        return None
    joints = [0.0] * 6
    for place, joint in zip(robot.places, found, strict=True):
        joints[place] = float(joint)
    return tuple(joints)


def _stated_configuration(machine: Machine, joints: tuple[float, ...]) -> Record | None:
    """As confdata, None where the robot's arm has none."""
    robot = machine.robot
    if robot is None or not robot.arm.named:
        return None
    own = np.array([robot.own_joints(joints)])
    one, four, six, x = (float(part) for part in to_confdata(robot.configuration(own))[0])
    return confdata(one, four, six, x)


def _active_tool(given: Given) -> Record:
    return given.machine.arm.tool or tool0()


def _active_frame(given: Given) -> Record:
    return given.machine.arm.frame or wobj0()


def _own_task_row(read: Callable[[Given], Record]) -> Callable[[Given], Record]:
    """Reads of the arm of the task that an option names: only its own is known here."""

    def of_task(given: Given) -> Record:
        task, reference = given.optional("taskname"), given.options.get("taskref")
        if isinstance(reference, s.NameRef):
            task = reference.name.lower().removesuffix("id")
        if task is not None and str(task).lower() != given.machine.task.name.lower():
            if any(str(task).lower() == one.name.lower() for one in given.machine.controller.tasks):
                raise NotSimulated("the arm of another task")
            raise Fault(f"there is no task `{task}`", "ERR_TASKNAME")
        return read(given)

    return of_task


TASK_OPTIONS: Final = "taskname taskref"
ARM_FUNCTIONS: Final[Mapping[str, Function]] = dict(
    (
        table_row("CRobT", 0, _own_task_row(present_target), f"tool wobj {TASK_OPTIONS}"),
        table_row("CPos", 0, lambda given: pos(_current_target(given).position), "tool wobj"),
        table_row("CJointT", 0, _own_task_row(_current_joints), TASK_OPTIONS),
        table_row("CTool", 0, _own_task_row(_active_tool), TASK_OPTIONS),
        table_row("CWObj", 0, _own_task_row(_active_frame), TASK_OPTIONS),
        table_row("CalcRobT", 2, _target_of_joints, "wobj"),
        table_row("CalcJointT", 2, _joints_of_target, "wobj usecurwobjpos"),
    )
)
