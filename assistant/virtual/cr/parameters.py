"""Commands about parameters, and the slot table, whose rows are parameters."""

from __future__ import annotations

from typing import Final

from assistant.virtual.cr.command import VT, Command, at_once, bare, parts, whole
from assistant.virtual.cr.parameter_table import VALUE_SEPARATOR
from assistant.virtual.cr.state import TASKMAX, CrSession
from assistant.virtual.cr.store import CrRefusal, checked_name

KEYWORD: Final = "MELFA"
"""Opens protected parameters (KEYWD in BFP-A4288)."""
SLOT_MODES: Final = ("REP", "CYC")
START_CONDITIONS: Final = ("START", "ALWAYS", "ERROR")
MOST_PRIORITY: Final = 31


def _read_parameter(session: CrSession, argument: str) -> str:
    return _parameter_answer(session, argument, all_levels=session.keyword)


def _read_any_parameter(session: CrSession, argument: str) -> str:
    return _parameter_answer(session, argument, all_levels=True)


def _parameter_answer(session: CrSession, argument: str, *, all_levels: bool) -> str:
    name = argument.strip().upper()
    values = session.state.parameters.read(name, all_levels=all_levels)
    return f"{name};{VALUE_SEPARATOR.join(values)};{len(values)}"


def _write_parameter(session: CrSession, argument: str) -> str:
    return _set_parameter(session, argument, all_levels=session.keyword)


def _write_any_parameter(session: CrSession, argument: str) -> str:
    return _set_parameter(session, argument, all_levels=True)


def _set_parameter(session: CrSession, argument: str, *, all_levels: bool) -> str:
    name, values = parts(argument, 2)
    session.state.parameters.write(name.strip().upper(), values, all_levels=all_levels)
    return ""


def _read_changed(session: CrSession, argument: str) -> str:
    """0 begins anew, 1 goes on; the answer tells first whether more follow."""
    if whole(argument, 0, 1) == 0:
        session.listed = session.state.parameters.changed
    names = at_once(session.listed)
    session.listed = session.listed[len(names) :]
    return f"{int(bool(session.listed))};{len(names)};{VT.join(names)}"


def _undo_parameter(session: CrSession, argument: str) -> str:
    mechanism, name = parts(argument, 2)
    whole(mechanism, 0, 3)
    session.state.parameters.undo(name.strip().upper())
    return ""


def _undo_all_parameters(session: CrSession) -> str:
    session.state.parameters.undo_all()
    return ""


def _check_keyword(session: CrSession, argument: str) -> str:
    session.keyword = argument == KEYWORD
    return ""


# ---------------------------------------------------------------------------------- slot table


def _read_slot_row(session: CrSession) -> str:
    return ";".join(session.state.parameters[_slot_row_name(session)])


def _set_slot_row(session: CrSession, argument: str) -> str:
    """Holds from the next start on, as the parameter does."""
    program, mode, condition, priority = parts(argument, 4)
    if program:
        program = checked_name(program)
    if mode not in SLOT_MODES or condition not in START_CONDITIONS:
        raise CrRefusal(4460)
    lines = whole(priority, 1, MOST_PRIORITY)
    values = VALUE_SEPARATOR.join([program, mode, condition, str(lines)])
    session.state.parameters.write(_slot_row_name(session), values, all_levels=True)
    return ""


def _slot_row_name(session: CrSession) -> str:
    if not 1 <= session.slot <= TASKMAX:
        raise CrRefusal(5420)
    return f"SLT{session.slot}"


PARAMETER_COMMANDS: Final = {
    "PNR": Command(_read_parameter),
    "PAR": Command(_read_any_parameter),
    "PRM=": Command(_write_parameter),
    "PAW=": Command(_write_any_parameter),
    "PAW2=": Command(_write_any_parameter),
    "PMR=": Command(_read_changed),
    "PRMUNDO": Command(_undo_parameter),
    "PRMINIT": Command(bare(_undo_all_parameters)),
    "KEYWDp": Command(_check_keyword),
    "SLOTRD": Command(bare(_read_slot_row)),
    "SLOTSET": Command(_set_slot_row),
}
