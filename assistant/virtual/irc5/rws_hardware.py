"""`/rw/panel`, `/rw/motionsystem`, `/rw/iosystem`: motors and operating mode, the arm, the signals.

The position of the simulated arm is read; jogging is not served. Signals are read and set.
"""

from __future__ import annotations

import math
from typing import Final, get_args

import numpy as np

from assistant.program.geometry import Pose
from assistant.robots.configurations import to_confdata
from assistant.virtual.irc5 import rws_messages
from assistant.virtual.irc5.cabinet import Cabinet, Signal
from assistant.virtual.irc5.panel import Mode
from assistant.virtual.irc5.programs import TASK, Programs
from assistant.virtual.irc5.rws_messages import DONE, Answer, Item, Rejected, Request
from assistant.virtual.kernel.kernel import Standing
from assistant.virtual.rapid.control_flow import Fault, NotSimulated
from assistant.virtual.rapid.expressions import settled
from assistant.virtual.rapid.records import record
from assistant.virtual.rapid.scopes import Cell
from assistant.virtual.rapid.values import Record

_OPERATING_MODES: Final[dict[str, Mode]] = {
    "auto": "AUTO",
    "man": "MANR",
    "manfs": "MANF",
    "manf": "MANF",
    **{mode.lower(): mode for mode in get_args(Mode)},
}


def motor_state(cabinet: Cabinet, request: Request) -> Answer:
    title = request.either("ctrlstate", "ctrl-state")
    return Answer(items=[Item("pnl-ctrlstate", title, {"ctrlstate": cabinet.panel.state})])


def set_motor_state(cabinet: Cabinet, request: Request) -> Answer:
    wanted = request.given("ctrl-state")
    if wanted not in ("motoron", "motoroff"):
        raise Rejected(rws_messages.BAD_ARGUMENT, f"ctrl-state {wanted}")
    try:
        # The programs stop before the motors go off: the arm is held where it is.
        if wanted == "motoroff":
            cabinet.do(lambda programs: programs.fail("the motors were switched off"))
        cabinet.panel.set_motors(wanted == "motoron")
    except ValueError as wrong:
        raise Rejected(rws_messages.WRONG_STATE, str(wrong)) from None
    return DONE


def operating_mode(cabinet: Cabinet, request: Request) -> Answer:
    return Answer(items=[Item("pnl-opmode", "opmode", {"opmode": cabinet.panel.mode})])


def set_operating_mode(cabinet: Cabinet, request: Request) -> Answer:
    """Set the operating mode, as virtual controllers allow; on a real one only its key does."""
    wanted = _OPERATING_MODES.get(request.given("opmode").lower())
    if wanted is None:
        raise Rejected(rws_messages.BAD_ARGUMENT, "opmode")
    cabinet.panel.set_mode(wanted)
    return DONE


def speed_ratio(cabinet: Cabinet, request: Request) -> Answer:
    fields = {"speedratio": str(cabinet.panel.speed)}
    return Answer(items=[Item("pnl-speedratio", "speedratio", fields)])


def set_speed_ratio(cabinet: Cabinet, request: Request) -> Answer:
    text = request.given("speed-ratio")
    try:
        ratio = round(float(text))
    except (ValueError, OverflowError):
        ratio = -1
    if not 0 <= ratio <= 100:
        raise Rejected(rws_messages.BAD_ARGUMENT, f"speed-ratio {text}")
    if cabinet.panel.mode != "AUTO":
        raise Rejected(rws_messages.WRONG_STATE, "only in automatic mode")
    cabinet.panel.speed = ratio
    return DONE


def collision_detection(cabinet: Cabinet, request: Request) -> Answer:
    return Answer(items=[Item("pnl-coldetstate", "collisiondetectstate", {"coldetstate": "INIT"})])


def emergency_stop(cabinet: Cabinet, request: Request) -> Answer:
    """`off` presses it, as on virtual controllers of RobotWare 7 (abb-rws-client, panel.ts)."""
    wanted = request.given("state").lower()
    if wanted not in ("on", "off"):
        raise Rejected(rws_messages.BAD_ARGUMENT, "state")
    if wanted == "off":
        cabinet.press_emergency_stop()
    else:
        cabinet.release_emergency_stop()
    return DONE


_UNIT: Final = "ROB_1"
_NO_AXIS: Final = "8.999999E+09"
"""An additional axis that is not there, as single precision writes 9E9."""
_EXTERNAL_AXES: Final = "abcdef"


def _check_unit(request: Request) -> None:
    if request.captures["unit"].upper() != _UNIT:
        raise Rejected(rws_messages.NO_RESOURCE, request.captures["unit"])


def _arm_now(cabinet: Cabinet) -> Standing:
    found = cabinet.standing()
    if found is None:
        raise Rejected(rws_messages.UNSPECIFIED, "the controller has no robot")
    return found


def motion_system(cabinet: Cabinet, request: Request) -> Answer:
    count = cabinet.do(lambda programs: programs.changes)
    return Answer(items=[Item("ms-motionsystem", "motionsystem", {"change-count": str(count)})])


def mechanical_units(cabinet: Cabinet, request: Request) -> Answer:
    fields = {"mode": "Activated", "activation-allowed": "TRUE", "drive-module": "1"}
    return Answer(listed=[Item("ms-mechunit-li", _UNIT, fields, f"mechunits/{_UNIT}")])


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
    return Answer(items=[Item("ms-mechunit", _UNIT, fields)])


def joint_target(cabinet: Cabinet, request: Request) -> Answer:
    _check_unit(request)
    values = _arm_now(cabinet)[1]
    fields = {f"rax_{i}": _single_text(value) for i, value in enumerate(values[:6], 1)}
    fields |= {f"eax_{letter}": _NO_AXIS for letter in _EXTERNAL_AXES}
    return Answer(items=[Item("ms-jointtarget", _UNIT, fields)])


def robot_target(cabinet: Cabinet, request: Request) -> Answer:
    """Answer with the robtarget of a tool in a work object, or in the base if `coordinate` selects
    it.
    """
    _check_unit(request)
    tool = request.query.get("tool", "tool0")
    frame = request.query.get("wobj", "wobj0")
    coordinate = request.query.get("coordinate", "Wobj").lower()
    if coordinate not in ("base", "world", "wobj"):
        raise Rejected(rws_messages.BAD_ARGUMENT, f"coordinate {coordinate}")
    if coordinate != "wobj":
        frame = "wobj0"
    # One look for both: the pose and the configuration must be of the same moment.
    flange, values = _arm_now(cabinet)
    pose = cabinet.do(lambda programs: _tool_pose(programs, flange, tool, frame))
    fields = _pose_fields(pose)
    names = ("cf1", "cf4", "cf6", "cfx")
    fields |= dict(zip(names, _configuration_values(cabinet, values), strict=True))
    fields |= {f"eax{letter}": _NO_AXIS for letter in _EXTERNAL_AXES}
    return Answer(items=[Item("ms-robtargets", _UNIT, fields)])


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
    # Without a loaded program only the predefined tool and work object are known.
    if programs.machine is None:
        if (tool.lower(), frame.lower()) != ("tool0", "wobj0"):
            raise Rejected(rws_messages.NO_SYMBOL, f"{tool}, {frame}")
        return flange
    try:
        held = _record_named(programs, tool, "tooldata"), _record_named(programs, frame, "wobjdata")
        return programs.machine.arm.reading(*held, flange)
    except (Fault, NotSimulated) as wrong:
        raise Rejected(rws_messages.BAD_ARGUMENT, str(wrong)) from None


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
    raise Rejected(rws_messages.NO_SYMBOL, name)


_SIGNALS_PAGE = 100
"""Signals that RWS 2.0 lists at once; 1.0 lists all."""


def list_signals(cabinet: Cabinet, request: Request) -> Answer:
    return _signal_page(cabinet, request, sorted(cabinet.signals().values(), key=lambda s: s.title))


def _signal_page(cabinet: Cabinet, request: Request, found: list[Signal]) -> Answer:
    start = request.number("start", 0, 10**6, 0)
    usual = _SIGNALS_PAGE if request.dialect == 2 else len(found) + 1
    limit = request.number("limit", 1, usual, usual)
    page = found[start : start + limit]
    onward = f"signals?start={start + limit}&limit={limit}" if start + limit < len(found) else ""
    return Answer(listed=[_signal_item(cabinet, one, "ios-signal-li") for one in page], next=onward)


def search_signals(cabinet: Cabinet, request: Request) -> Answer:
    """List the signals that match all fields of the form; a name matches any part of the signal's
    name.
    """
    found = []
    for one in sorted(cabinet.signals().values(), key=lambda s: s.title):
        facts = {"device": one.device, "network": one.network, "type": one.type}
        stated = {key: request.form[key] for key in facts if request.form.get(key)}
        part = request.form.get("name", "").lower()
        if part in one.name.lower() and all(facts[key] == value for key, value in stated.items()):
            found.append(one)
    return _signal_page(cabinet, request, found)


def read_signal(cabinet: Cabinet, request: Request) -> Answer:
    kind = request.either("ios-signal", "ios-signal-li")
    return Answer(
        items=[_signal_item(cabinet, find_signal(cabinet, request.captures["signal"]), kind)]
    )


def write_signal(cabinet: Cabinet, request: Request) -> Answer:
    signal = find_signal(cabinet, request.captures["signal"])
    text = request.given("lvalue")
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    binary = signal.type in ("DI", "DO")
    whole = binary or signal.type in ("GI", "GO")
    if not math.isfinite(value) or (whole and not value.is_integer()) or (whole and value < 0):
        raise Rejected(rws_messages.BAD_ARGUMENT, f"lvalue {text}")
    if binary and value > 1:
        raise Rejected(rws_messages.BAD_ARGUMENT, f"lvalue {text}")
    cabinet.write(signal, value)
    return DONE


def find_signal(cabinet: Cabinet, path: str) -> Signal:
    """A signal by its network, device and name, or by its name alone."""
    *where, name = path.split("/")
    signal = cabinet.signals().get(name.lower())
    if signal is None or (where and where != [signal.network, signal.device]):
        raise Rejected(rws_messages.NO_SIGNAL)
    return signal


def signal_value(cabinet: Cabinet, signal: Signal) -> str:
    return f"{cabinet.read(signal):.7g}"


def _signal_item(cabinet: Cabinet, signal: Signal, kind: str) -> Item:
    fields = {
        "name": signal.name,
        "type": signal.type,
        "category": "",
        "lvalue": signal_value(cabinet, signal),
        "lstate": "not simulated",
    }
    if kind == "ios-signal":
        fields |= {"pvalue": fields["lvalue"], "write-access": "Rapid, LocalManual, LocalAuto"}
    return Item(kind, signal.title, fields, f"signals/{signal.title}")


def list_networks(cabinet: Cabinet, request: Request) -> Answer:
    names = sorted({one.network for one in cabinet.signals().values() if one.network})
    fields = {"pstate": "running", "lstate": "started"}
    return Answer(
        listed=[Item("ios-network-li", n, {"name": n, **fields}, f"networks/{n}") for n in names]
    )


def list_devices(cabinet: Cabinet, request: Request) -> Answer:
    pairs = sorted({(s.network, s.device) for s in cabinet.signals().values() if s.network})
    only = request.query.get("network")
    fields = {"lstate": "enabled", "pstate": "running", "address": "-"}
    return Answer(
        listed=[
            Item("ios-device-li", f"{n}/{d}", {"name": d, **fields}, f"devices/{n}/{d}")
            for n, d in pairs
            if only in (None, n)
        ]
    )
