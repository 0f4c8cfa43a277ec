r"""EGM in RAPID programs: instructions that a virtual controller adds to the common ones.

EGMReset, EGMGetId, EGMSetupUC, EGMActJoint, EGMActPose, EGMRunJoint, EGMRunPose and EGMStop (option
689-1, manual 3HAC073318). The run ends as not simulated at: speed control (`\PosCorrGain:=0`),
guidance in parallel with the program (`\NoWaitCond`), ramping back at the end, frames other than
the work object and tool.
"""

from __future__ import annotations

import socket
from collections.abc import Mapping
from contextlib import suppress
from functools import partial
from typing import Final

import numpy as np

from assistant.base.data_classes import dataclass
from assistant.languages.rapid.tree import syntax as s
from assistant.program.geometry import IDENTITY, Pose
from assistant.virtual.events import Moved
from assistant.virtual.irc5.egm import CYCLE, NO_DATA, Guidance
from assistant.virtual.irc5.egm_packets import Kind
from assistant.virtual.rapid.call_arguments import Ability, Given
from assistant.virtual.rapid.control_flow import Fault, NotSimulated
from assistant.virtual.rapid.machine import Machine, is_carried
from assistant.virtual.rapid.motion import flange_of
from assistant.virtual.rapid.records import number, pose_of, wobj0
from assistant.virtual.rapid.values import Handle, Record

Devices = Mapping[str, tuple[str, int]]
"""UdpUc devices by name: address and port of the computer that they send to."""
_COND_TIME: Final = 20.0
_COMM_TIMEOUT: Final = 1.0
NEAR: Final = 0.5
"""Degrees or mm that count as converged, where nothing states it."""
_TOOL_SPEEDS: Final = (1000.0, 180.0)
"""Speeds of a guided tool: mm and degrees a second, assumed."""
_HOLD: Final = "EGM_STOP_HOLD"
AXES: Final = tuple(f"j{axis}" for axis in range(1, 7))
_FREEDOMS: Final = ("x", "y", "z", "rx", "ry", "rz")


@dataclass(slots=True)
class _Prepared:
    """Settings that the instructions have made so far. target: address that receives the
    packets.
    """

    kind: Kind | None = None
    target: tuple[str, int] = ("", 0)
    comm_timeout: float = _COMM_TIMEOUT
    cycle: float = CYCLE
    within: float | None = None
    most: float | None = None
    tool: Record | None = None
    frame: Record | None = None


def abilities(devices: Devices) -> dict[str, Ability]:
    """The instructions by name, for `abilities` of a run."""
    return {
        "EGMReset": _reset,
        "EGMGetId": _get,
        "EGMSetupUC": partial(_set_up, devices),
        "EGMActJoint": partial(_act, "joints", AXES),
        "EGMActPose": partial(_act, "poses", _FREEDOMS),
        "EGMRunJoint": partial(_run, "joints"),
        "EGMRunPose": partial(_run, "poses"),
        "EGMStop": _stop,
    }


def _handle(given: Given, index: int = 0) -> Handle:
    handle = given.place(index).get()
    if not isinstance(handle, Handle) or handle.type != "egmident":
        raise Fault("what is no egmident is used as one")
    return handle


def _prepared(given: Given, index: int = 0) -> _Prepared:
    inside = _handle(given, index).inside
    if not isinstance(inside, _Prepared):
        raise Fault("an EGM identity is used that EGMGetId did not give")
    return inside


def _reset(given: Given) -> None:
    _handle(given).inside = None


def _get(given: Given) -> None:
    handle = _handle(given)
    if not isinstance(handle.inside, _Prepared):
        handle.inside = _Prepared()


def _set_up(devices: Devices, given: Given) -> None:
    egm = _prepared(given, 1)
    if given.has("pathcorr"):
        raise NotSimulated("EGM that corrects a path")
    name = given.text(3).removesuffix(":")
    if name not in devices:
        raise Fault(f"there is no UdpUc device `{name}`")
    egm.target = devices[name]
    egm.kind = "poses" if given.has("pose") else "joints"
    stated = given.optional_number("commtimeout")
    egm.comm_timeout = _COMM_TIMEOUT if stated is None else stated


def _act(kind: Kind, axes: tuple[str, ...], given: Given) -> None:
    egm = _prepared(given)
    if egm.kind != kind:
        raise Fault("EGM is prepared for what EGMSetupUC did not set up")
    if given.has("streamstart"):
        raise NotSimulated("EGM that streams before it is run")
    if kind == "poses":
        for index in (1, 3):
            if pose_of(given.record(index, "pose")) != IDENTITY:
                raise NotSimulated("EGM in a correction or sensor frame of its own")
    found = [given.optional_record(axis, "egm_minmax") for axis in axes if given.has(axis)]
    ranges = [abs(number(one.parts[end])) for one in found if one for end in ("min", "max")]
    egm.within = max(ranges) if ranges else NEAR
    egm.most = given.optional_number("maxspeeddeviation")
    rate = given.optional_number("samplerate")
    egm.cycle = CYCLE if rate is None else max(CYCLE, rate / 1000.0)
    egm.tool = given.optional_record("tool", "tooldata") or egm.tool
    egm.frame = given.optional_record("wobj", "wobjdata") or egm.frame


def _run(kind: Kind, given: Given) -> None:
    egm, machine = _prepared(given), given.machine
    if egm.kind != kind or egm.within is None:
        raise Fault("EGM is run that nothing has prepared")
    if given.has("nowaitcond"):
        raise NotSimulated("EGM that goes on beside the program")
    mode = given.required[1] if len(given.required) > 1 else None
    if not isinstance(mode, s.NameRef) or mode.name.upper() != _HOLD:
        raise NotSimulated("EGM that goes back to where it began")
    if given.optional_number("poscorrgain") == 0.0:
        raise NotSimulated("EGM that controls the speed")
    if machine.robot is None:
        raise NotSimulated("EGM without a robot")
    # Guidance begins where the arm stands, not on its way to a corner.
    machine.settle()
    stated = given.optional_number("condtime")
    guidance = Guidance(
        kind,
        _joints(machine) if kind == "joints" else _pose(machine, egm),
        _speeds(machine, egm),
        comm_timeout=egm.comm_timeout,
        cond_time=_COND_TIME if stated is None else stated,
        within=egm.within,
    )
    _follow(machine, guidance, egm)
    if guidance.ended == "silent":
        raise Fault(f"event {NO_DATA}: no data from the UdpUc device", "ERR_UDPUC_COMM")


def _follow(machine: Machine, guidance: Guidance, egm: _Prepared) -> None:
    """Cycle by cycle, until it is over; then the arm is where it was led."""
    before, task = machine.arm.flange, machine.task
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as own:
        own.setblocking(False)
        with suppress(OSError):  # a host that cannot be reached now
            own.connect(egm.target)  # nobody else is heard
        last = task.kernel.now
        try:
            while guidance.ended is None:
                _hear(own, guidance)
                now = task.kernel.now
                # The first step has no time before it: it counts as one cycle.
                packet, last = guidance.step(max(now - last, 0.0) or egm.cycle), now
                with suppress(OSError):  # nobody listens yet
                    own.send(packet)
                if guidance.kind == "joints":
                    task.kernel.motion.lead(task.kernel, guidance.values)
                task.wait(None, egm.cycle, "packets of EGM", outside=True)
        # Also after a fault: the program goes on from where the arm was led.
        finally:
            _arrive(machine, guidance, egm, before)


def _hear(own: socket.socket, guidance: Guidance) -> None:
    """Receive the waiting packets, but no more than fit between two cycles."""
    with suppress(BlockingIOError, ConnectionRefusedError):
        # A sensor that floods the port must not keep the program here.
        for _ in range(64):
            guidance.hear(own.recv(2048))


def _arrive(machine: Machine, guidance: Guidance, egm: _Prepared, before: Pose | None) -> None:
    arm = machine.arm
    tool, frame = _frames(machine, egm)
    if guidance.kind == "joints":
        arm.joints = tuple(guidance.values)
        arm.flange = flange_of(machine, arm.joints)
        moved = Moved("joint", arm.flange, is_carried(tool), joints=arm.joints)
    else:
        arm.joints = None
        place = Pose.of(np.array(guidance.values[:3]), np.array(guidance.values[3:]))
        arm.flange = arm.flange_at(place, tool, frame)
        moved = Moved("linear", arm.flange, is_carried(tool), speed=_TOOL_SPEEDS[0])
    arm.tool, arm.frame = tool, frame
    machine.go(moved, before)


def _frames(machine: Machine, egm: _Prepared) -> tuple[Record, Record]:
    tool = egm.tool or machine.arm.tool
    if tool is None:
        raise NotSimulated("EGM with the tool of the program before")
    return tool, egm.frame or machine.arm.frame or wobj0()


def _joints(machine: Machine) -> tuple[float, ...]:
    standing = machine.task.kernel.motion.where()
    joints = machine.arm.joints if standing is None else standing[1][:6]
    if joints is None:
        raise NotSimulated("EGM with joints, behind a motion to a position")
    return tuple(joints)


def _pose(machine: Machine, egm: _Prepared) -> tuple[float, ...]:
    standing = machine.task.kernel.motion.where()
    flange = None if standing is None else standing[0]
    pose = machine.arm.reading(*_frames(machine, egm), flange)
    return (*pose.position, *pose.quaternion)


def _speeds(machine: Machine, egm: _Prepared) -> tuple[float, ...]:
    """Return the speeds that the arm can reach and is allowed to use."""
    if egm.kind == "poses":
        return _TOOL_SPEEDS
    assert machine.robot is not None
    most = float("inf") if egm.most is None else egm.most
    return tuple(min(most, float(speed)) for speed in machine.robot.speeds)


def _stop(given: Given) -> None:
    """Nothing is guided beside the program."""
    _prepared(given)
