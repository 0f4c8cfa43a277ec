"""Functions that tell where the arm is, and with which tool and work object."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from assistant.program.geometry import Pose
from assistant.virtual.rapid.ends import NotSimulated
from assistant.virtual.rapid.given import Given, takes
from assistant.virtual.rapid.machine import Function
from assistant.virtual.rapid.motion import flange_of
from assistant.virtual.rapid.poses import joints_of, jointtarget, pos, robtarget
from assistant.virtual.rapid.predefined import wobj0
from assistant.virtual.rapid.values import Record


def _here(given: Given) -> Pose:
    """The position in the tool and work object that are named, else in those of the latest move.

    CRobT without them reads in the active tool and work object.
    """
    tool = given.optional_record("tool", "tooldata") or _active(given.machine.arm.tool, "tool")
    frame = given.optional_record("wobj", "wobjdata")
    if frame is None:
        frame = _active(given.machine.arm.frame, "work object")
    return given.machine.arm.reading(tool, frame)


def _active(record: Record | None, what: str) -> Record:
    if record is None:
        raise NotSimulated(f"a position that is read in the {what} of the program before")
    return record


def _target(given: Given) -> Record:
    arm = given.machine.arm
    return robtarget(_here(given), arm.configuration, arm.external)


def _joints(given: Given) -> Record:
    arm = given.machine.arm
    if arm.joints is None:
        raise NotSimulated("joints that are read behind a motion to a position")
    return jointtarget(arm.joints, arm.external)


def _target_of_joints(given: Given) -> Record:
    target, tool = given.record(0, "jointtarget"), given.record(1, "tooldata")
    frame = given.optional_record("wobj", "wobjdata") or wobj0()
    arm = given.machine.arm
    flange = flange_of(given.machine, joints_of(target))
    if flange is None:
        raise NotSimulated("CalcRobT without a robot")
    before, arm.flange = arm.flange, flange
    try:
        return robtarget(arm.reading(tool, frame), None, None)
    finally:
        arm.flange = before


def _tool(given: Given) -> Record:
    return _active(given.machine.arm.tool, "tool")


def _frame(given: Given) -> Record:
    return _active(given.machine.arm.frame, "work object")


TABLE: Final[Mapping[str, Function]] = dict(
    (
        takes("CRobT", 0, _target, "tool wobj"),
        takes("CPos", 0, lambda given: pos(_here(given).position), "tool wobj"),
        takes("CJointT", 0, _joints),
        takes("CTool", 0, _tool),
        takes("CWObj", 0, _frame),
        takes("CalcRobT", 2, _target_of_joints, "wobj"),
    )
)
