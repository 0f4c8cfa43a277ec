"""Commands about the program of a task slot: selecting, its lines, resetting."""

from __future__ import annotations

from typing import Final

from assistant.virtual.cr.command import VT, Command, bare, parts, whole
from assistant.virtual.cr.state import TASKMAX, CrSession
from assistant.virtual.cr.store import LAST_LINE, CrProgram, CrRefusal, checked_name

MOST_LINES_AROUND: Final = 40
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
    """The next program in the order of their names; the first one behind the last."""
    _check_slot(session)
    names = list(session.state.store)
    if not names:
        raise CrRefusal(4140)
    selected = session.state.selected.get(session.slot)
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
    """Whether more follow, how many, the lines about the one that runs, and its number."""
    going_on, before, behind = parts(argument, 3)
    whole(going_on, 0, 1)
    program, line = _required_program(session), session.state.machinery.slot_now(session.slot).line
    numbers = sorted(program.steps)
    at = numbers.index(line) if line in numbers else 0
    first = max(at - whole(before, 0, MOST_LINES_AROUND), 0)
    count = whole(before, 0, MOST_LINES_AROUND) + whole(behind, 0, MOST_LINES_AROUND) + 1
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
