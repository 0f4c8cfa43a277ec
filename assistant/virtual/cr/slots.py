"""Commands about the program of a task slot: selecting, its lines, resetting."""

from __future__ import annotations

from typing import Final

from assistant.virtual.cr.command import VT, Command, bare, parts, whole
from assistant.virtual.cr.state import TASKMAX, CrSession
from assistant.virtual.cr.store import LAST_LINE, CrProgram, CrRefusal, checked_name

AROUND: Final = 40
"""Lines before and behind the one that runs, at most, in one answer."""


def _select(session: CrSession, argument: str) -> str:
    name = checked_name(argument)
    _choose(session, name)
    return ""


def _choose(session: CrSession, name: str) -> None:
    state = session.state
    if name not in state.store:
        raise CrRefusal(4140)
    _task(session)
    state.machinery.select(session.slot, name)


def _next(session: CrSession) -> str:
    return _step(session, 1)


def _previous(session: CrSession) -> str:
    return _step(session, -1)


def _step(session: CrSession, by: int) -> str:
    """The next program in the order of their names; the first one behind the last."""
    _task(session)
    names = list(session.state.store)
    if not names:
        raise CrRefusal(4140)
    selected = session.state.selected.get(session.slot)
    at = names.index(selected) + by if selected in names else min(by, 0)
    _choose(session, names[at % len(names)])
    return ""


def _selected(session: CrSession) -> str:
    name = session.state.selected.get(session.slot)
    return f"{name}.{session.state.suffix}" if name else ""


def _set_line(session: CrSession, argument: str) -> str:
    program = _program(session)
    number = whole(argument, 1, LAST_LINE, error=4420)
    if number not in program.steps:
        raise CrRefusal(4230)
    session.state.machinery.go_to_line(session.slot, number)
    return ""


def _line(session: CrSession) -> str:
    return str(session.state.machinery.slot_now(session.slot).line)


def _line_text(session: CrSession) -> str:
    return _program(session).steps.get(session.state.machinery.slot_now(session.slot).line, "")


def _lines_around(session: CrSession, argument: str) -> str:
    """Whether more follow, how many, the lines about the one that runs, and its number."""
    going_on, before, behind = parts(argument, 3)
    whole(going_on, 0, 1)
    program, line = _program(session), session.state.machinery.slot_now(session.slot).line
    numbers = sorted(program.steps)
    at = numbers.index(line) if line in numbers else 0
    first = max(at - whole(before, 0, AROUND), 0)
    count = whole(before, 0, AROUND) + whole(behind, 0, AROUND) + 1
    lines = [program.steps[number] for number in numbers[first : first + count]]
    return f"0;{len(lines)};{VT.join(lines)};{line:04}"


def _program(session: CrSession) -> CrProgram:
    name = session.state.selected.get(session.slot)
    if name is None or name not in session.state.store:
        raise CrRefusal(5100)
    return session.state.store[name]


def _task(session: CrSession) -> None:
    if not 1 <= session.slot <= TASKMAX:
        raise CrRefusal(5420)


def _reset_one(session: CrSession) -> str:
    _task(session)
    session.state.machinery.reset(session.slot)
    return ""


def _reset_all(session: CrSession) -> str:
    machinery = session.state.machinery
    if any(machinery.slot_now(slot).runs for slot in range(1, TASKMAX + 1)):
        raise CrRefusal(5640)
    for slot in range(1, TASKMAX + 1):
        machinery.reset(slot)
    return ""


COMMANDS: Final = {
    "PRGLOAD=": Command(_select, right=True),
    "PRGUP": Command(bare(_next), right=True),
    "PRGDOWN": Command(bare(_previous), right=True),
    "PRGRD": Command(bare(_selected)),
    "LINENO=": Command(_set_line, right=True),
    "LINENO": Command(bare(_line)),
    "LINERD": Command(bare(_line_text)),
    "LINESRD": Command(_lines_around),
    "RSTPRG": Command(bare(_reset_one)),
    "SLOTINIT": Command(bare(_reset_all)),
}
