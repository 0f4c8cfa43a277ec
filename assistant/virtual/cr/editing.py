"""Editing a program on a virtual CR controller: opening, lines in, listings out, saving."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Final

from assistant.virtual.cr.lines import check
from assistant.virtual.cr.state import CrSession
from assistant.virtual.cr.store import CrProgram, CrRefusal, checked_name

VT: Final = "\v"
MOST_LISTED: Final = 230
"""Bytes of lines in one answer to LISTL."""


def new(session: CrSession) -> str:
    session.close()
    return ""


def load(session: CrSession, argument: str) -> str:
    session.open(checked_name(argument))
    return ""


def save(session: CrSession) -> str:
    program = session.edit
    assert session.name is not None
    program.changed = session.state.clock()
    session.state.store.save(session.name, program)
    session.close()
    return ""


def put_line(session: CrSession, argument: str) -> str:
    program = session.edit
    _put(session, program, argument)
    return ""


def put_lines(session: CrSession, argument: str) -> str:
    program = session.edit
    for number, line in enumerate(argument.split(VT), start=1):
        try:
            if line:
                _put(session, program, line)
        except CrRefusal as error:
            raise CrRefusal(error.number, number, *error.places) from None
    return ""


def _put(session: CrSession, program: CrProgram, line: str) -> None:
    if not re.fullmatch(r"\s*\d+\s*", line):  # a number alone deletes, and is no line to parse
        check(session.state.language, line)
    program.put(line)


def clear(session: CrSession) -> str:
    session.edit.clear()
    return ""


def delete_steps(session: CrSession, argument: str) -> str:
    program = session.edit
    first, last = _range(argument)
    gone = [number for number in program.steps if first <= number <= last]
    if not gone:
        raise CrRefusal(4230)
    for number in gone:
        del program.steps[number]
    return ""


def count_steps(session: CrSession, argument: str) -> str:
    first, last = _range(argument)
    return f"{sum(first <= number <= last for number in session.edit.steps):04}"


def _range(argument: str) -> tuple[int, int]:
    """`<a>;<b>`, either may be missing."""
    found = re.fullmatch(r"(\d{0,5})(?:;(\d{0,5}))?", argument)
    if found is None:
        raise CrRefusal(4460)
    first = int(found[1]) if found[1] else 1
    return first, int(found[2]) if found[2] else (first if found[2] is None else 32767)


def list_lines(session: CrSession, argument: str) -> str:
    lines = session.edit.lines()
    start = _place(argument, session.next_line, sorted(session.edit.steps))
    listed: list[str] = []
    for line in lines[start:]:
        if listed and sum(map(len, listed)) + len(listed) + len(line) > MOST_LISTED:
            break
        listed.append(line)
    session.next_line = start + len(listed)
    more = int(session.next_line < len(lines))
    return f"{VT.join(listed)};{len(listed)};{more}" if listed else ""


def list_line(session: CrSession, argument: str) -> str:
    lines = session.edit.lines()
    at = _place(argument, session.next_line, sorted(session.edit.steps))
    session.next_line = min(at + 1, len(lines))
    return lines[at] if at < len(lines) else ""


def list_position(session: CrSession, argument: str) -> str:
    positions = session.edit.positions()
    if argument in ("TOP", "END", "+1", "-1", ""):
        at = _place(argument, session.next_position, range(len(positions)))
    else:
        names = [line.partition("=")[0].upper() for line in positions]
        at = _place(argument, session.next_position, names)
    session.next_position = min(at + 1, len(positions))
    return positions[at] if at < len(positions) else ""


def _place(argument: str, following: int, keys: Sequence[int] | Sequence[str]) -> int:
    """Index that TOP, END, +1, -1, or a key of a listing means; its length for none."""
    steps = {
        "TOP": 0,
        "END": max(len(keys) - 1, 0),
        "+1": following,
        "-1": max(following - 2, 0),
        "": following,
    }
    if argument in steps:
        return steps[argument]
    wanted = [str(key) for key in keys]
    return wanted.index(argument.upper()) if argument.upper() in wanted else len(keys)
