"""Commands of the link: session, operation right, state, position of the arm, signals."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from datetime import datetime
from typing import TYPE_CHECKING, Final

import numpy as np

from assistant.base.rotations import to_euler
from assistant.program.geometry import Pose
from assistant.virtual.cr.command import Command, bare, hexadecimal, parts, whole
from assistant.virtual.cr.slots_and_arm import Standing
from assistant.virtual.cr.state import FIRST_HAND, HANDS, TASKMAX, CrSession
from assistant.virtual.cr.store import CrRefusal
from assistant.virtual.kernel.kernel import Signals

if TYPE_CHECKING:
    from assistant.robots import Robot


_AxisValues = list[tuple[str, str]]
"""Name and value of each axis."""
_MISSING_AXIS: Final = "****"
"""Value of an axis that the arm lacks."""
_NEAR_LIMIT: Final = 0.005
"""Degrees or mm from the limit of an axis within which it counts as reached."""


def _joint_values(robot: Robot, angles: Sequence[float]) -> _AxisValues:
    """Degrees of J1 to J6, as JPOSF shows them."""
    own = dict(zip(robot.axes, angles, strict=True))
    names = [f"J{i}" for i in range(1, 7)]
    return [(name, f"{own[name]:.2f}" if name in own else _MISSING_AXIS) for name in names]


def _pose_values(robot: Robot, angles: Sequence[float], tool: Pose, foot: Pose) -> _AxisValues:
    """X, Y, Z in mm, A, B, C in degrees of the tip; an arm of five axes shows no C.

    foot: the frame that positions are counted in, with the robot's base in it.
    """
    positions, quaternions = robot.flange_poses(np.array([angles]))
    tip = foot @ Pose.of(positions[0], quaternions[0]) @ tool
    values = list(tip.position)
    if robot.five_axis:
        from assistant.robots.arms.closed_form import to_ab

        found = to_ab(np.array([tip.position]), np.array([tip.quaternion]))
        values += [float(v) for v in found[0]]
    else:
        values += [float(v) for v in to_euler(np.array(tip.quaternion), "ZYX")[::-1]]
    # + 0.0 turns -0.00 into 0.00.
    return [(name, f"{value + 0.0:.2f}") for name, value in zip("XYZABC", values, strict=False)]


def _cylinder_values(shown: _AxisValues) -> _AxisValues:
    """Radius in mm and angle in degrees about the base in the places of X and Y (RPOSF)."""
    x, y = (float(value) for _, value in shown[:2])
    radius, angle = math.hypot(x, y), math.degrees(math.atan2(y, x))
    return [("R", f"{radius:.2f}"), ("T", f"{angle:.2f}"), *shown[2:]]


def _posture_flags(robot: Robot, angles: Sequence[float]) -> str:
    from assistant.robots.configurations import to_flags

    one, two = to_flags(robot.configuration(np.array([angles])))[0]
    return f"{one},{two}"


def _reached_limits(robot: Robot, angles: Sequence[float]) -> str:
    """Axes at their upper and at their lower limits, two hexadecimal digits each, and a reserve."""
    upper = lower = 0
    for place, angle, (low, high) in zip(robot.places, angles, robot.limits, strict=True):
        upper |= (angle >= float(high) - _NEAR_LIMIT) << place
        lower |= (angle <= float(low) + _NEAR_LIMIT) << place
    return f"{upper:02X}{lower:02X}0000"


_JOG_SPEEDS: Final = "3,5,A,1E,32,46,64"
"""Percent, hexadecimal."""


def _open_session(session: CrSession, argument: str) -> str:
    state = session.state
    world, joints = _axes_there(state.robot)
    return ";".join(
        [
            f"{world:02X}",
            f"{joints:02X}",
            _posture_flags(state.robot, state.joints),
            _JOG_SPEEDS,
            state.suffix,
            "PRM",
            state.robot.name.upper(),
            state.robot.controller,
            "MELFA",
            f"{state.now():%y-%m-%d}",
            "Ver.VIRTUAL",
            "JPN" if argument.endswith(";JPN") else "ENG",
            "VIRTUAL CONTROLLER",
            "1;1",
            f"{TASKMAX};",
        ]
    )


def _axes_there(robot: Robot) -> tuple[int, int]:
    """Bits of X Y Z A B C and of J1 to J6 that the arm has; a SCARA turns about Z only."""
    joints = sum(1 << place for place in robot.places if place < 6)
    # X Y Z A B without C; X Y Z and C.
    world = {"five-axis": 0x1F, "scara": 0x27}.get(robot.arm.kind, 0x3F)
    return world, joints


def _close_session(session: CrSession) -> str:
    session.hang_up()
    return ""


def _take_right(session: CrSession) -> str:
    holder = session.state.right
    if holder not in (None, session) and not holder.silent:
        raise CrRefusal(6020)
    session.state.right = session
    return ""


def _give_right(session: CrSession) -> str:
    if session.state.right is session:
        session.state.right = None
    return ""


SESSION_COMMANDS: Final = {
    "OPEN=": Command(_open_session),
    "CLOSE": Command(bare(_close_session)),
    "CNTLON": Command(bare(_take_right)),
    "CNTLOFF": Command(bare(_give_right)),
}


_ALL_AXES: Final = "F"
_NO_FLAGS: Final = "****,****"
_CLOCK_FORMAT: Final = "%y-%m-%d%H:%M:%S"


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


def _joints_shown(robot: Robot, arm: Standing) -> tuple[_AxisValues, str]:
    return _joint_values(robot, arm.joints), _NO_FLAGS


def _pose_shown(robot: Robot, arm: Standing) -> tuple[_AxisValues, str]:
    shown = _pose_values(robot, arm.joints, arm.tool, arm.foot)
    return shown, _posture_flags(robot, arm.joints)


def _cylinder_shown(robot: Robot, arm: Standing) -> tuple[_AxisValues, str]:
    shown, flags = _pose_shown(robot, arm)
    return _cylinder_values(shown), flags


def _position_answer(
    session: CrSession,
    axis: str,
    show: Callable[[Robot, Standing], tuple[_AxisValues, str]],
    *,
    goal: bool,
) -> str:
    """`name;value;…;;flags;override;speed;limits`; an axis (1 to 8) chooses one of them."""
    # `JPOSF` and the like: F asks for all axes.
    axis = axis.removeprefix(_ALL_AXES)
    if axis and not re.fullmatch(r"[1-8]", axis):
        raise CrRefusal(4460)
    state = session.state
    arm = state.machinery.standing(goal=goal)
    shown, flags = show(state.robot, arm)
    chosen = shown[int(axis) - 1 : int(axis)] if axis else shown
    values = "".join(f"{name};{value};" for name, value in chosen)
    limits = _reached_limits(state.robot, arm.now)
    return f"{values};{flags};{state.override};{arm.speed:.2f};{limits}"


def _read_calibration(session: CrSession) -> str:
    """The origin of every axis is set."""
    _, joints = _axes_there(session.state.robot)
    return f"N{joints:02X}{joints:02X}"


def _read_stops(session: CrSession) -> str:
    """Stop of the computer's line, and emergency stop of the operating panel."""
    state = session.state
    return f"{state.stop_on * 2:X};{state.emergency * 2:X}"


def _read_time(session: CrSession) -> str:
    return f"{session.state.now():{_CLOCK_FORMAT}}"


def _set_time(session: CrSession, argument: str) -> str:
    state = session.state
    try:
        wanted = datetime.strptime(argument, _CLOCK_FORMAT)
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


_WORD_BITS: Final = 16
_LAST_SIGNAL: Final = 32767
_REGISTERS: Final = range(6000, 6256)
"""Registers of CC-Link."""
_MOST_REGISTERS: Final = 16
_SHOWN_HANDS: Final = 8


def _read_inputs(session: CrSession, argument: str) -> str:
    # Connected equipment is asked for its inputs now.
    session.state.machinery.feel()
    return _signal_word(session.state.board.inputs, argument)


def _read_outputs(session: CrSession, argument: str) -> str:
    return _signal_word(session.state.board.outputs, argument)


def _read_signals(session: CrSession, argument: str) -> str:
    first, second = parts(argument, 2)
    return _read_inputs(session, first) + _read_outputs(session, second)


def _signal_word(signals: Signals, argument: str) -> str:
    first = whole(argument, 0, _LAST_SIGNAL, error=6600)
    return f"{sum(bool(signals.read(str(first + i))) << i for i in range(_WORD_BITS)):04X}"


def _set_outputs(session: CrSession, argument: str) -> str:
    return _between_statements(session, lambda: _set_word(session.state.board.outputs, argument))


def _set_inputs(session: CrSession, argument: str) -> str:
    if session.state.real_inputs is None:
        raise CrRefusal(6630)
    return _between_statements(session, lambda: _set_word(session.state.board.inputs, argument))


def _between_statements(session: CrSession, change: Callable[[], None]) -> str:
    """Signals change between two statements of the programs that see them."""
    session.state.machinery.do(change)
    return ""


def _set_word(signals: Signals, argument: str) -> None:
    number, value = parts(argument, 2)
    first, word = whole(number, 0, _LAST_SIGNAL, error=6600), hexadecimal(value, 4)
    for bit in range(_WORD_BITS):
        signals.set(str(first + bit), float(word >> bit & 1))


def _read_input_registers(session: CrSession, argument: str) -> str:
    return _register_values(session.state.board.inputs, argument)


def _read_output_registers(session: CrSession, argument: str) -> str:
    return _register_values(session.state.board.outputs, argument)


def _register_values(signals: Signals, argument: str) -> str:
    first = _register_number(argument)
    return ";".join(str(int(signals.read(f"register{first + i}"))) for i in range(_MOST_REGISTERS))


def _register_number(argument: str) -> int:
    return whole(argument, _REGISTERS.start, _REGISTERS.stop - 1, error=7780)


def _set_output_register(session: CrSession, argument: str) -> str:
    return _between_statements(
        session, lambda: _set_register(session.state.board.outputs, argument)
    )


def _set_input_register(session: CrSession, argument: str) -> str:
    if session.state.real_inputs is None:
        raise CrRefusal(6630)
    return _between_statements(session, lambda: _set_register(session.state.board.inputs, argument))


def _set_register(signals: Signals, argument: str) -> None:
    number, value = parts(argument, 2)
    signals.set(f"register{_register_number(number)}", float(hexadecimal(value, 4)))


def _use_pseudo_inputs(session: CrSession) -> str:
    """From now on IN= writes the inputs."""
    state = session.state
    if state.real_inputs is None:
        state.real_inputs = dict(state.board.inputs.values)
    return ""


def _use_real_inputs(session: CrSession) -> str:
    """The inputs are again what they were before they became pseudo inputs."""
    state = session.state
    before, state.real_inputs = state.real_inputs, None
    inputs = state.board.inputs

    def restore() -> None:
        # All that were set as pseudo inputs, also those that had no value before.
        for name in list(inputs.values) if before is not None else ():
            inputs.set(name, (before or {}).get(name, 0.0))

    return _between_statements(session, restore)


def _reset_outputs(session: CrSession) -> str:
    """All general outputs are off."""
    outputs = session.state.board.outputs
    hands = range(FIRST_HAND, FIRST_HAND + 2 * HANDS)

    def reset() -> None:
        for name in list(outputs.values):
            # Valves of hands follow commands for hands only.
            if name.isdigit() and int(name) not in hands:
                outputs.set(name, 0.0)

    return _between_statements(session, reset)


# --------------------------------------------------------------------------------------- hands


def _hand_command(*, opens: bool) -> Command:
    def handler(session: CrSession, argument: str) -> str:
        session.state.order_hand(whole(argument, 1, HANDS), opens)
        return ""

    return Command(handler)


def _read_hands(session: CrSession) -> str:
    """Eight times signal, 1 open or 2 closed, 1 for two valves; -1 for a hand that is not there."""
    told = []
    for hand in range(1, _SHOWN_HANDS + 1):
        if hand > HANDS:
            told.append("-1;-1;-1")
        else:
            is_open = session.state.hands[hand]
            told.append(f"{FIRST_HAND + 2 * (hand - 1)};{1 if is_open else 2};1")
    return ";".join(told)


SIGNAL_COMMANDS: Final = {
    "IOSIGNAL": Command(_read_signals),
    "IN": Command(_read_inputs),
    "OUT": Command(_read_outputs),
    "OUT=": Command(_set_outputs),
    "IN=": Command(_set_inputs),
    "DIN": Command(_read_input_registers),
    "DOUT": Command(_read_output_registers),
    "DIN=": Command(_set_input_register),
    "DOUT=": Command(_set_output_register),
    "INDMY": Command(bare(_use_pseudo_inputs)),
    "INSET": Command(bare(_use_real_inputs)),
    "RSTIO": Command(bare(_reset_outputs)),
    "HNDON": _hand_command(opens=True),
    "HNDOFF": _hand_command(opens=False),
    "HNDSTS": Command(bare(_read_hands)),
}
