"""Commands that tell how the controller is and where its arm stands."""

from __future__ import annotations

import re
from collections.abc import Callable
from datetime import datetime
from typing import TYPE_CHECKING, Final

from assistant.virtual.cr import positions
from assistant.virtual.cr.command import Command, bare
from assistant.virtual.cr.machinery import Standing
from assistant.virtual.cr.sessions import axes_there
from assistant.virtual.cr.state import CrSession
from assistant.virtual.cr.store import CrRefusal

if TYPE_CHECKING:
    from assistant.robots import Robot

ALL_AXES: Final = "F"
NO_FLAGS: Final = "****,****"
CLOCK_FORMAT: Final = "%y-%m-%d%H:%M:%S"


def _read_state(session: CrSession) -> str:
    state = session.state
    slot = state.machinery.slot_now(session.slot)
    program = f"{slot.program}.{state.suffix}" if slot.program else ""
    edits = session.name is not None
    edit = edits | slot.runs << 1 | (edits and session.changed) << 2
    row = state.parameters[f"SLT{session.slot}"] if slot.is_task else ("", "REP", "START", "1")
    listed = f"{row[0]}.{state.suffix}" if row[0] else program
    fields = [program, str(slot.line), str(state.override), str(edit), _state_bits(session)]
    told = [listed, slot.mode, row[2], row[3], str(int(slot.moves))]
    return ";".join([*fields, str(slot.step), "1", *[""] * 7, *told])


def _read_short_state(session: CrSession) -> str:
    slot = session.state.machinery.slot_now(session.slot)
    return f"{_state_bits(session)};{slot.step};{int(slot.moves)}"


def _state_bits(session: CrSession) -> str:
    """Run bits, stop bits, error number.

    Run: 01 repeat, 02 cycle stop off, 04 machine lock, 20 servos on, 40 runs, 80 operation right.
    Stop: 01 emergency stop, 02 stopped, 04 waits, 10 a program can be selected, 40 pseudo input.
    """
    state = session.state
    slot = state.machinery.slot_now(session.slot)
    run = (
        (slot.mode == "REP") * 0x01
        | (not slot.ends_cycle) * 0x02
        | state.machine_lock * 0x04
        | state.servo * 0x20
        | slot.runs * 0x40
        | (state.right is not None) * 0x80
    )
    stop = (
        state.emergency * 0x01
        | (not slot.runs) * 0x02
        | slot.waits * 0x04
        | (not slot.runs and not slot.waits) * 0x10
        | (state.real_inputs is not None) * 0x40
    )
    return f"{run:02X}{stop:02X}{state.alarm[0] if state.alarm else 0}"


def _read_joints(session: CrSession, axis: str) -> str:
    return _position_answer(session, axis, _joints_shown, goal=False)


def _read_pose(session: CrSession, axis: str) -> str:
    return _position_answer(session, axis, _pose_shown, goal=False)


def _read_cylinder(session: CrSession, axis: str) -> str:
    return _position_answer(session, axis, _cylinder_shown, goal=False)


def _read_goal_joints(session: CrSession, axis: str) -> str:
    return _position_answer(session, axis, _joints_shown, goal=True)


def _read_goal_pose(session: CrSession, axis: str) -> str:
    return _position_answer(session, axis, _pose_shown, goal=True)


def _joints_shown(robot: Robot, arm: Standing) -> tuple[positions.AxisValues, str]:
    return positions.joint_values(robot, arm.joints), NO_FLAGS


def _pose_shown(robot: Robot, arm: Standing) -> tuple[positions.AxisValues, str]:
    shown = positions.pose_values(robot, arm.joints, arm.tool, arm.foot)
    return shown, positions.posture_flags(robot, arm.joints)


def _cylinder_shown(robot: Robot, arm: Standing) -> tuple[positions.AxisValues, str]:
    shown, flags = _pose_shown(robot, arm)
    return positions.cylinder_values(shown), flags


def _position_answer(
    session: CrSession,
    axis: str,
    show: Callable[[Robot, Standing], tuple[positions.AxisValues, str]],
    *,
    goal: bool,
) -> str:
    """`name;value;…;;flags;override;speed;limits`; an axis (1 to 8) chooses one of them."""
    axis = axis.removeprefix(ALL_AXES)
    if axis and not re.fullmatch(r"[1-8]", axis):
        raise CrRefusal(4460)
    state = session.state
    arm = state.machinery.standing(goal=goal)
    shown, flags = show(state.robot, arm)
    chosen = shown[int(axis) - 1 : int(axis)] if axis else shown
    values = "".join(f"{name};{value};" for name, value in chosen)
    limits = positions.reached_limits(state.robot, arm.now)
    return f"{values};{flags};{state.override};{arm.speed:.2f};{limits}"


def _read_calibration(session: CrSession) -> str:
    """The origin of every axis is set."""
    _, joints = axes_there(session.state.robot)
    return f"N{joints:02X}{joints:02X}"


def _read_stops(session: CrSession) -> str:
    """Stop of the computer's line, and emergency stop of the operating panel."""
    state = session.state
    return f"{state.stop_on * 2:X};{state.emergency * 2:X}"


def _read_time(session: CrSession) -> str:
    return f"{session.state.now():{CLOCK_FORMAT}}"


def _set_time(session: CrSession, argument: str) -> str:
    state = session.state
    try:
        wanted = datetime.strptime(argument, CLOCK_FORMAT)
    except ValueError:
        raise CrRefusal(6070) from None
    state.clock_off = (wanted - state.clock()).total_seconds()
    return ""


def _read_areas(session: CrSession) -> str:
    """No user-defined area is set."""
    del session
    return "0"


STATE_COMMANDS: Final = {
    "STATE": Command(bare(_read_state)),
    "DSTATE": Command(bare(_read_short_state)),
    "JPOS": Command(_read_joints),
    "PPOS": Command(_read_pose),
    "XPOS": Command(_read_pose),
    "RPOS": Command(_read_cylinder),
    "GJPOS": Command(_read_goal_joints),
    "GPPOS": Command(_read_goal_pose),
    "CALIB": Command(bare(_read_calibration)),
    "STPSIG": Command(bare(_read_stops)),
    "TIME": Command(bare(_read_time)),
    "TIME=": Command(_set_time),
    "USERAREASTS": Command(bare(_read_areas)),
}
