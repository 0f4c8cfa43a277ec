"""Commands about parameters, and the slot table, whose rows are parameters."""

from __future__ import annotations

from typing import Final

from assistant.virtual.cr.command import VT, Command, at_once, bare, parts, whole
from assistant.virtual.cr.parameter_table import BETWEEN
from assistant.virtual.cr.state import TASKMAX, CrSession
from assistant.virtual.cr.store import CrRefusal, checked_name

KEYWORD: Final = "MELFA"
"""Opens protected parameters (KEYWD in BFP-A4288)."""
MODES: Final = ("REP", "CYC")
CONDITIONS: Final = ("START", "ALWAYS", "ERROR")
MOST_LINES: Final = 31


def _read(session: CrSession, argument: str) -> str:
    return _told(session, argument, all_levels=session.keyword)


def _read_any(session: CrSession, argument: str) -> str:
    return _told(session, argument, all_levels=True)


def _told(session: CrSession, argument: str, *, all_levels: bool) -> str:
    name = argument.strip().upper()
    values = session.state.parameters.read(name, all_levels=all_levels)
    return f"{name};{BETWEEN.join(values)};{len(values)}"


def _write(session: CrSession, argument: str) -> str:
    return _set(session, argument, all_levels=session.keyword)


def _write_any(session: CrSession, argument: str) -> str:
    return _set(session, argument, all_levels=True)


def _set(session: CrSession, argument: str, *, all_levels: bool) -> str:
    name, values = parts(argument, 2)
    session.state.parameters.write(name.strip().upper(), values, all_levels=all_levels)
    return ""


def _changed(session: CrSession, argument: str) -> str:
    """0 begins anew, 1 goes on; the answer tells first whether more follow."""
    if whole(argument, 0, 1) == 0:
        session.listed = session.state.parameters.changed
    names = at_once(session.listed)
    session.listed = session.listed[len(names) :]
    return f"{int(bool(session.listed))};{len(names)};{VT.join(names)}"


def _undo(session: CrSession, argument: str) -> str:
    mechanism, name = parts(argument, 2)
    whole(mechanism, 0, 3)
    session.state.parameters.undo(name.strip().upper())
    return ""


def _undo_all(session: CrSession) -> str:
    session.state.parameters.undo_all()
    return ""


def _keyword(session: CrSession, argument: str) -> str:
    session.keyword = argument == KEYWORD
    return ""


# ---------------------------------------------------------------------------------- slot table


def _row(session: CrSession) -> str:
    return ";".join(session.state.parameters[_row_name(session)])


def _set_row(session: CrSession, argument: str) -> str:
    """Holds from the next start on, as the parameter does."""
    program, mode, condition, priority = parts(argument, 4)
    if program:
        program = checked_name(program)
    if mode not in MODES or condition not in CONDITIONS:
        raise CrRefusal(4460)
    lines = whole(priority, 1, MOST_LINES)
    values = BETWEEN.join([program, mode, condition, str(lines)])
    session.state.parameters.write(_row_name(session), values, all_levels=True)
    return ""


def _row_name(session: CrSession) -> str:
    if not 1 <= session.slot <= TASKMAX:
        raise CrRefusal(5420)
    return f"SLT{session.slot}"


COMMANDS: Final = {
    "PNR": Command(_read),
    "PAR": Command(_read_any),
    "PRM=": Command(_write),
    "PAW=": Command(_write_any),
    "PAW2=": Command(_write_any),
    "PMR=": Command(_changed),
    "PRMUNDO": Command(_undo),
    "PRMINIT": Command(bare(_undo_all)),
    "KEYWDp": Command(_keyword),
    "SLOTRD": Command(bare(_row)),
    "SLOTSET": Command(_set_row),
}
