"""`/rw/motionsystem`: where the simulated arm is. Jogging is not served."""

from __future__ import annotations

from typing import Final

import numpy as np

from assistant.program.geometry import Pose
from assistant.robots.configurations import to_confdata
from assistant.virtual.irc5.cabinet import Cabinet
from assistant.virtual.irc5.programs import TASK, Programs
from assistant.virtual.irc5.rws import reasons
from assistant.virtual.irc5.rws.answers import Answer, Item, Rejected
from assistant.virtual.irc5.rws.request import Request
from assistant.virtual.kernel.motion import Standing
from assistant.virtual.rapid.ends import Fault, NotSimulated
from assistant.virtual.rapid.expressions import settled
from assistant.virtual.rapid.poses import record
from assistant.virtual.rapid.scopes import Cell
from assistant.virtual.rapid.values import Record

UNIT: Final = "ROB_1"
NO_AXIS: Final = "8.999999E+09"
"""An additional axis that is not there, as single precision writes 9E9."""
EXTERNAL_AXES: Final = "abcdef"


def _check_unit(request: Request) -> None:
    if request.captures["unit"].upper() != UNIT:
        raise Rejected(reasons.NO_RESOURCE, request.captures["unit"])


def _arm_now(cabinet: Cabinet) -> Standing:
    found = cabinet.standing()
    if found is None:
        raise Rejected(reasons.UNSPECIFIED, "the controller has no robot")
    return found


def motion_system(cabinet: Cabinet, request: Request) -> Answer:
    count = cabinet.do(lambda programs: programs.changes)
    return Answer(items=[Item("ms-motionsystem", "motionsystem", {"change-count": str(count)})])


def mechanical_units(cabinet: Cabinet, request: Request) -> Answer:
    fields = {"mode": "Activated", "activation-allowed": "TRUE", "drive-module": "1"}
    return Answer(listed=[Item("ms-mechunit-li", UNIT, fields, f"mechunits/{UNIT}")])


def mechanical_unit(cabinet: Cabinet, request: Request) -> Answer:
    _check_unit(request)
    fields = {
        "type": "TCPRobot",
        "task-name": TASK,
        "is-integrated-unit": "NoIntegratedUnit",
        "has-integrated-unit": "NoIntegratedUnit",
        "axes": "6",
        "axes-total": "6",
        "tool-name": "tool0",
        "wobj-name": "wobj0",
        "payload-name": "load0",
        "total-payload-name": "load0",
        "status": "Synchronized",
        "mode": "Activated",
        "jog-mode": "AxisGroup1",
        "coord-system": "Base",
    }
    return Answer(items=[Item("ms-mechunit", UNIT, fields)])


def joint_target(cabinet: Cabinet, request: Request) -> Answer:
    _check_unit(request)
    values = _arm_now(cabinet)[1]
    fields = {f"rax_{i}": _single_text(value) for i, value in enumerate(values[:6], 1)}
    fields |= {f"eax_{letter}": NO_AXIS for letter in EXTERNAL_AXES}
    return Answer(items=[Item("ms-jointtarget", UNIT, fields)])


def robot_target(cabinet: Cabinet, request: Request) -> Answer:
    """Of a tool in a work object, or in the base where `coordinate` says so."""
    _check_unit(request)
    tool = request.query.get("tool", "tool0")
    frame = request.query.get("wobj", "wobj0")
    coordinate = request.query.get("coordinate", "Wobj").lower()
    if coordinate not in ("base", "world", "wobj"):
        raise Rejected(reasons.BAD_ARGUMENT, f"coordinate {coordinate}")
    if coordinate != "wobj":
        frame = "wobj0"
    flange, values = _arm_now(cabinet)
    pose = cabinet.do(lambda programs: _tool_pose(programs, flange, tool, frame))
    fields = _pose_fields(pose)
    names = ("cf1", "cf4", "cf6", "cfx")
    fields |= dict(zip(names, _configuration_values(cabinet, values), strict=True))
    fields |= {f"eax{letter}": NO_AXIS for letter in EXTERNAL_AXES}
    return Answer(items=[Item("ms-robtargets", UNIT, fields)])


def cartesian_pose(cabinet: Cabinet, request: Request) -> Answer:
    _check_unit(request)
    flange, values = _arm_now(cabinet)
    names = ("j1", "j4", "j6", "jx") if request.dialect == 1 else ("cf1", "cf4", "cf6", "cfx")
    configuration = dict(zip(names, _configuration_values(cabinet, values), strict=True))
    return Answer(
        items=[Item("ms-mechunit-cartesian", "cartesian", _pose_fields(flange) | configuration)]
    )


def _pose_fields(pose: Pose) -> dict[str, str]:
    fields = {axis: _single_text(value) for axis, value in zip("xyz", pose.position, strict=True)}
    return fields | {f"q{i}": _single_text(value) for i, value in enumerate(pose.quaternion, 1)}


def _single_text(value: float) -> str:
    """Seven digits, as single precision has them; never `-0`."""
    return f"{value:.7g}" if abs(value) >= 1e-6 else "0"


def _configuration_values(cabinet: Cabinet, values: tuple[float, ...]) -> list[str]:
    assert cabinet.robot is not None
    own = np.array([cabinet.robot.own_joints(values)])
    return [str(one) for one in to_confdata(cabinet.robot.configuration(own))[0].tolist()]


def _tool_pose(programs: Programs, flange: Pose, tool: str, frame: str) -> Pose:
    if programs.machine is None:
        if (tool.lower(), frame.lower()) != ("tool0", "wobj0"):
            raise Rejected(reasons.NO_SYMBOL, f"{tool}, {frame}")
        return flange
    try:
        held = _record_named(programs, tool, "tooldata"), _record_named(programs, frame, "wobjdata")
        return programs.machine.arm.reading(*held, flange)
    except (Fault, NotSimulated) as wrong:
        raise Rejected(reasons.BAD_ARGUMENT, str(wrong)) from None


def _record_named(programs: Programs, name: str, type: str) -> Record:
    machine = programs.machine
    assert machine is not None
    key = name.lower()
    places = [machine.named, machine.predefined, *(unit.names for unit in machine.modules.values())]
    for names in places:
        cell = names.get(key)
        if isinstance(cell, Cell):
            value = settled(machine, cell).value
            if value is not None:
                return record(value, type)
    raise Rejected(reasons.NO_SYMBOL, name)
