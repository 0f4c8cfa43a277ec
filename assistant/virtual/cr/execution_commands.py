"""Commands of the link that run programs: select one for a slot, start, stop, step, break points.

Also single statements, jogging, the override, the tool, and the servos.
"""

from __future__ import annotations

from concurrent.futures import Future
from typing import Final, Literal

import numpy as np

from assistant.virtual.cr.command import VT, Command, bare, hexadecimal, parts, whole
from assistant.virtual.cr.state import HIGH, TASKMAX, CrSession, CrState
from assistant.virtual.cr.store import LAST_LINE, CrProgram, CrRefusal, checked_name

_TOOLS: Final = 16
_CYCLE_MODES: Final[dict[str, Literal["REP", "CYC"]]] = {"0": "REP", "1": "CYC"}
_LONGEST_STATEMENT: Final = 3600.0
"""Seconds that EXEC2= waits for its command at most."""
_STEP_FORWARD, _STEP_ON, _STEP_BACK, _STEP_STOP = "1", "R", "B", "S"

# ------------------------------------------------------------------------------- programs


def _run_program(session: CrSession, argument: str) -> str:
    """The program that is named, or that is selected; 0 repeats it, 1 runs one cycle."""
    state = session.state
    slot = _slot_number(session)
    _may_start(state)
    name, _, number = argument.partition(";")
    if number and number not in _CYCLE_MODES:
        raise CrRefusal(5410)
    if name:
        program = checked_name(name)
        if program not in state.store:
            raise CrRefusal(4140)
        now = state.machinery.slot_now(slot)
        if now.runs:
            raise CrRefusal(5640)
        # A paused program keeps its slot: only the same one may go on.
        if not now.waits:
            state.machinery.select(slot, program)
        elif now.program != program:
            raise CrRefusal(5120)
    # Another session edits it: what would run is not what that session sees.
    if state.is_edited(state.machinery.slot_now(slot).program):
        raise CrRefusal(4170)
    state.machinery.run(slot, _CYCLE_MODES.get(number, "REP"))
    return ""


def _may_start(state: CrState) -> None:
    if state.alarm is not None and state.alarm[1] <= _LOW_LEVEL:
        raise CrRefusal(5600)
    if state.stop_on:
        raise CrRefusal(5610)
    if not state.may_start:
        raise CrRefusal(5010)


_LOW_LEVEL: Final = HIGH + 1
"""Level of an error behind which nothing can be started, as behind a high one."""


def _slot_number(session: CrSession) -> int:
    if not 0 <= session.slot <= TASKMAX:
        raise CrRefusal(5420)
    return max(session.slot, 1)


def _stop_all(session: CrSession) -> str:
    session.state.machinery.stop_all()
    return ""


def _hold_stop(session: CrSession) -> str:
    session.state.stop_on = True
    return _stop_all(session)


def _cycle_stop(session: CrSession) -> str:
    session.state.machinery.stop_cycles()
    return ""


def _step_program(session: CrSession, argument: str) -> str:
    """Step the program of the slot; stepping backwards is refused."""
    state = session.state
    slot = _slot_number(session) if session.slot <= TASKMAX else 1
    if argument == _STEP_STOP:
        return _stop_all(session)
    _may_start(state)
    if argument == _STEP_FORWARD:
        state.machinery.step(slot)
    elif argument == _STEP_ON:
        state.machinery.run(slot, "CYC")
    else:
        raise CrRefusal(5410)
    return ""


# ------------------------------------------------------------------------- single commands


def _start_statement(session: CrSession, argument: str) -> str:
    _started_statement(session, argument)
    return ""


def _run_statement(session: CrSession, argument: str) -> str:
    """Answers when it is done: with its error number if it ended so."""
    done = _started_statement(session, argument)
    # The lock is free meanwhile: a stop must get through.
    with session.state.unlocked():
        number = done.result(_LONGEST_STATEMENT)
    if number is not None:
        raise CrRefusal(number)
    return ""


def _started_statement(session: CrSession, argument: str) -> Future[int | None]:
    """In the edit slot with the variables of the program that is open for editing."""
    _may_start(session.state)
    edited = session.slot > TASKMAX and session.name is not None
    edit = session.program if edited else None
    return session.state.machinery.execute(session.slot, argument, edit)


# -------------------------------------------------------------------------------- the arm


def _jog(session: CrSession, argument: str) -> str:
    """Mode, a reserve, axes in negative and in positive direction, inching; hexadecimal."""
    _may_start(session.state)
    mode, _, negative, positive, inch = (hexadecimal(part, 2) for part in parts(argument, 5))
    session.state.machinery.move(lambda hand: hand.jog(mode, negative, positive, inch))
    return ""


def _align(session: CrSession) -> str:
    _may_start(session.state)
    session.state.machinery.move(lambda hand: hand.align())
    return ""


def _safe_position(session: CrSession) -> str:
    """By joints, to those of the parameter JSAFE."""
    state = session.state
    _may_start(state)
    angles = [float(value) for value in state.parameters["JSAFE"]]
    joints = np.array([angles[place] for place in state.robot.places])
    state.machinery.move(lambda hand: hand.go_to(joints))
    return ""


# ----------------------------------------------------------------------------- breakpoints


def _set_break_point(session: CrSession, argument: str) -> str:
    name, line, kind = parts(argument.removeprefix("="), 3)
    program = _stored_program(session, name)
    number = whole(line, 1, LAST_LINE, error=4420)
    if number not in session.state.store[program].steps:
        raise CrRefusal(4230)
    session.state.machinery.break_at(program, number, once=bool(whole(kind, 0, 1)))
    return ""


def _clear_break_point(session: CrSession, argument: str) -> str:
    name, line = parts(argument.removeprefix("="), 2)
    number = whole(line, 0, LAST_LINE, error=4420)
    session.state.machinery.no_break(_stored_program(session, name), number)
    return ""


def _read_break_point(session: CrSession, argument: str) -> str:
    """One of those of a program, or of all without a name, by its number and a range of lines."""
    name, number, first, last = parts(argument.removeprefix("="), 4)
    low = whole(first or "0", 0, LAST_LINE)
    high = whole(last or str(LAST_LINE), 0, LAST_LINE)
    program = checked_name(name) if name else None
    found = [
        (one, line, once)
        for one, line, once in session.state.machinery.breakpoints()
        if program in (None, one) and low <= line <= high
    ]
    at = whole(number, 1, 128) - 1
    if at >= len(found):
        return ""
    one, line, once = found[at]
    return f"{one}.{session.state.suffix};{line};{int(once)}"


def _stored_program(session: CrSession, name: str) -> str:
    program = checked_name(name)
    if program not in session.state.store:
        raise CrRefusal(4140)
    return program


# -------------------------------------------------------------------------------- switches


def _servo_command(*, on: bool) -> Command:
    def handler(session: CrSession) -> str:
        session.state.switch_servo(on)
        return ""

    return Command(bare(handler), right=True)


def _switch_command(name: str, *, on: bool) -> Command:
    """A switch of the controller."""

    def handler(session: CrSession) -> str:
        setattr(session.state, name, on)
        return ""

    return Command(bare(handler))


def _read_override(session: CrSession) -> str:
    return str(session.state.override)


def _set_override(session: CrSession, argument: str) -> str:
    session.state.override = whole(argument, 1, 100)
    return argument


def _set_tool(session: CrSession, argument: str) -> str:
    """The tool whose frame the parameter MEXTL with its number has; 0 for none."""
    state = session.state
    number = whole(argument.removeprefix("="), 0, _TOOLS)
    frame = state.parameters[f"MEXTL{number}"] if number else ("0",) * 6
    state.machinery.set_tool([float(value) for value in frame])
    state.tool = number
    return ""


def _read_tool(session: CrSession) -> str:
    return str(session.state.tool)


def _set_safe_speed(session: CrSession, argument: str) -> str:
    session.state.slow = bool(whole(argument, 0, 1))
    return ""


def _can_start(session: CrSession) -> str:
    """0 if a program can be started."""
    try:
        _may_start(session.state)
    except CrRefusal:
        return "1"
    return "0"


RUN_COMMANDS: Final = {
    "RUN": Command(_run_program, right=True),
    "STOP": Command(bare(_stop_all)),
    "STOPON": Command(bare(_hold_stop)),
    "STOPOFF": _switch_command("stop_on", on=False),
    "CSTOP": Command(bare(_cycle_stop)),
    "STEP": Command(_step_program, right=True),
    "EXEC": Command(_start_statement, right=True),
    "EXEC2=": Command(_run_statement, right=True),
    "JOG": Command(_jog, right=True),
    "ALIGN": Command(bare(_align), right=True),
    "MOVSP": Command(bare(_safe_position), right=True),
    "BRKPTSET": Command(_set_break_point),
    "BRKPTCLR": Command(_clear_break_point),
    "BRKPTGET": Command(_read_break_point),
    "SRVON": _servo_command(on=True),
    "SRVOFF": _servo_command(on=False),
    "OVRD=": Command(_set_override, right=True),
    "OVRD": Command(bare(_read_override)),
    "MLOCKON": _switch_command("machine_lock", on=True),
    "MLOCKOFF": _switch_command("machine_lock", on=False),
    "LSON": Command(bare(lambda _: "")),
    "LSOFF": Command(bare(lambda _: "")),
    "AUEON": _switch_command("may_start", on=True),
    "AUEOFF": _switch_command("may_start", on=False),
    "ATENA": Command(bare(_can_start)),
    "TOOLSET": Command(_set_tool),
    "TOOLRD": Command(bare(_read_tool)),
    "SAFE=": Command(_set_safe_speed),
}


_MOST_LINES_AROUND: Final = 40
"""Lines before and behind the one that runs, at most, in one answer."""


def _select_program(session: CrSession, argument: str) -> str:
    name = checked_name(argument)
    _choose_program(session, name)
    return ""


def _choose_program(session: CrSession, name: str) -> None:
    state = session.state
    if name not in state.store:
        raise CrRefusal(4140)
    _check_slot(session)
    state.machinery.select(session.slot, name)


def _select_next(session: CrSession) -> str:
    return _select_neighbour(session, 1)


def _select_previous(session: CrSession) -> str:
    return _select_neighbour(session, -1)


def _select_neighbour(session: CrSession, by: int) -> str:
    """Select the next program in the order of names; the first one follows the last."""
    _check_slot(session)
    names = list(session.state.store)
    if not names:
        raise CrRefusal(4140)
    selected = session.state.selected.get(session.slot)
    # Without a selection the next one is the first, the previous one the last.
    at = names.index(selected) + by if selected in names else min(by, 0)
    _choose_program(session, names[at % len(names)])
    return ""


def _selected_program(session: CrSession) -> str:
    name = session.state.selected.get(session.slot)
    return f"{name}.{session.state.suffix}" if name else ""


def _go_to_line(session: CrSession, argument: str) -> str:
    program = _required_program(session)
    number = whole(argument, 1, LAST_LINE, error=4420)
    if number not in program.steps:
        raise CrRefusal(4230)
    session.state.machinery.go_to_line(session.slot, number)
    return ""


def _read_line_number(session: CrSession) -> str:
    return str(session.state.machinery.slot_now(session.slot).line)


def _read_line(session: CrSession) -> str:
    return _required_program(session).steps.get(
        session.state.machinery.slot_now(session.slot).line, ""
    )


def _read_lines_around(session: CrSession, argument: str) -> str:
    """Return whether more follow, the count, the lines around the current one, and its number."""
    going_on, before, behind = parts(argument, 3)
    whole(going_on, 0, 1)
    program, line = _required_program(session), session.state.machinery.slot_now(session.slot).line
    numbers = sorted(program.steps)
    at = numbers.index(line) if line in numbers else 0
    first = max(at - whole(before, 0, _MOST_LINES_AROUND), 0)
    count = whole(before, 0, _MOST_LINES_AROUND) + whole(behind, 0, _MOST_LINES_AROUND) + 1
    lines = [program.steps[number] for number in numbers[first : first + count]]
    return f"0;{len(lines)};{VT.join(lines)};{line:04}"


def _required_program(session: CrSession) -> CrProgram:
    name = session.state.selected.get(session.slot)
    if name is None or name not in session.state.store:
        raise CrRefusal(5100)
    return session.state.store[name]


def _check_slot(session: CrSession) -> None:
    if not 1 <= session.slot <= TASKMAX:
        raise CrRefusal(5420)


def _reset_slot(session: CrSession) -> str:
    _check_slot(session)
    session.state.machinery.reset(session.slot)
    return ""


def _reset_all_slots(session: CrSession) -> str:
    machinery = session.state.machinery
    if any(machinery.slot_now(slot).runs for slot in range(1, TASKMAX + 1)):
        raise CrRefusal(5640)
    for slot in range(1, TASKMAX + 1):
        machinery.reset(slot)
    return ""


SLOT_COMMANDS: Final = {
    "PRGLOAD=": Command(_select_program, right=True),
    "PRGUP": Command(bare(_select_next), right=True),
    "PRGDOWN": Command(bare(_select_previous), right=True),
    "PRGRD": Command(bare(_selected_program)),
    "LINENO=": Command(_go_to_line, right=True),
    "LINENO": Command(bare(_read_line_number)),
    "LINERD": Command(bare(_read_line)),
    "LINESRD": Command(_read_lines_around),
    "RSTPRG": Command(bare(_reset_slot)),
    "SLOTINIT": Command(bare(_reset_all_slots)),
}
