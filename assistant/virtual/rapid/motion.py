"""Motions: where each ends, how fast, and how wide its corner may be cut."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache
from typing import Literal

import numpy as np

from assistant.program.geometry import Pose
from assistant.robots.configurations import from_confdata
from assistant.virtual.events import How, Moved
from assistant.virtual.rapid.arm import Arm, is_carried, work_object
from assistant.virtual.rapid.ends import Fault
from assistant.virtual.rapid.expressions import evaluate
from assistant.virtual.rapid.given import Given
from assistant.virtual.rapid.machine import Machine
from assistant.virtual.rapid.poses import axes_of, joints_of, number, pose_of, record, truth
from assistant.virtual.rapid.predefined import wobj0
from assistant.virtual.rapid.scopes import Place
from assistant.virtual.rapid.values import Record, Shape, copied

MOVE_OPTIONS = "conc id v t z inpos wobj tload noeoffs"
"""What a move may say beside its target, speed, zone and tool, and is simulated here."""


def move_joint(given: Given) -> None:
    _to_target(given, "joint", 0)


def move_linear(given: Given) -> None:
    _to_target(given, "linear", 0)


def move_circular(given: Given) -> None:
    via = given.record(0, "robtarget")
    _to_target(given, "circular", 1, via)


def move_absolute(given: Given) -> None:
    """MoveAbsJ: no displacement and no work object changes where the joints go."""
    arm, target = given.machine.arm, given.record(0, "jointtarget")
    tool, frame, before = _tool_argument(given, 3), _frame_argument(given), arm.flange
    arm.joints = joints_of(target)
    arm.flange = flange_of(given.machine, arm.joints)
    arm.tool, arm.frame = tool, frame
    arm.configuration, arm.external = None, record(copied(target.parts["extax"]), "extjoint")
    speed, blend, how = _speed(given, 1), _blend(given, 2), _motion_style(given, 1)
    moved = Moved(
        "joint", arm.flange, is_carried(tool), joints=arm.joints, speed=speed, blend=blend, how=how
    )
    given.machine.go(replace(moved, external=tuple(axes_of(arm.external))), before)


def flange_of(machine: Machine, joints: tuple[float, ...]) -> Pose | None:
    """Where the flange is at joints in degrees, None without a robot."""
    if machine.robot is None:
        return None
    p, q = machine.robot.fk(np.array([machine.robot.own_joints(joints)]))
    return Pose.of(p[0], q[0])


def _to_target(
    given: Given,
    kind: Literal["joint", "linear", "circular"],
    first: int,
    via: Record | None = None,
) -> None:
    arm, target = given.machine.arm, given.record(first, "robtarget")
    before = arm.flange
    tool, frame = _tool_argument(given, first + 3), _frame_argument(given)
    flange = arm.flange_at(pose_of(target), tool, frame)
    between = None if via is None else arm.flange_at(pose_of(via), tool, frame)
    arm.flange, arm.joints, arm.tool, arm.frame = flange, None, tool, frame
    arm.configuration = record(copied(target.parts["robconf"]), "confdata")
    arm.external = record(copied(target.parts["extax"]), "extjoint")
    speed, blend = _speed(given, first + 1), _blend(given, first + 2)
    place = work_object(frame, tool) @ arm.displacement
    how = replace(_motion_style(given, first + 1), configuration=_configuration(arm, kind))
    moved = Moved(kind, flange, is_carried(tool), between, speed=speed, blend=blend, how=how)
    external = tuple(axes_of(arm.external))
    given.machine.go(replace(moved, frame=place, external=external), before)


def _motion_style(given: Given, index: int) -> How:
    """index: of the speed among the arguments."""
    arm, rotation = given.machine.arm, number(given.record(index, "speeddata").parts["v_ori"])
    share = arm.acceleration / 100.0
    assert arm.tool is not None
    mass = number(record(arm.tool.parts["tload"], "loaddata").parts["mass"])
    return How(
        rotation=rotation * arm.override / 100.0,
        acceleration=share,
        deceleration=share,
        seconds=given.optional_number("t"),
        mass=mass if mass >= 0.0 else None,
    )


def _configuration(arm: Arm, kind: str) -> tuple[int, ...] | None:
    """As the target states it, where ConfJ or ConfL has it looked at."""
    watched = arm.watches_joints if kind == "joint" else arm.watches_lines
    if arm.configuration is None or not watched:
        return None
    stated = [number(part) for part in arm.configuration.parts.values()]
    return _neutral_configuration(*stated)


@lru_cache(256)
def _neutral_configuration(*stated: float) -> tuple[int, ...] | None:
    """The columns of a configuration in whole numbers."""
    if not all(part.is_integer() and abs(part) < 128 for part in stated):
        return None
    return tuple(from_confdata([[int(part) for part in stated]])[0].tolist())


def _tool_argument(given: Given, index: int) -> Record:
    return _persistent_argument(given.place(index), "tooldata")


def _frame_argument(given: Given) -> Record:
    node = given.options.get("wobj")
    if node is None:
        return wobj0()
    return record(copied(evaluate(given.machine, node, Shape("wobjdata"))), "wobjdata")


def _persistent_argument(place: Place, type: str) -> Record:
    if place.storage == "VAR":
        raise Fault(f"a VAR as {type}, which has to be persistent")
    return record(copied(place.get()), type)


def _speed(given: Given, index: int) -> float | None:
    r"""Of the tool in mm/s; None where the motion states its time, or the fastest there is."""
    stated = number(given.record(index, "speeddata").parts["v_tcp"])
    if given.has("t"):
        return None
    own = given.optional_number("v")
    arm = given.machine.arm
    speed = min((stated if own is None else own) * arm.override / 100.0, arm.most)
    return None if math.isinf(speed) else speed


def _blend(given: Given, index: int) -> float:
    zone = given.record(index, "zonedata")
    own = given.optional_number("z")
    if truth(zone.parts["finep"]) or given.has("inpos"):
        return 0.0
    return number(zone.parts["pzone_tcp"]) if own is None else own
