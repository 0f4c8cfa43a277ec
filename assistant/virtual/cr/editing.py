"""Editing a program on a virtual CR controller: opening, lines in, numbering, saving."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Final

from assistant import languages
from assistant.base.diagnostics import Refused
from assistant.base.source_text import lines_of
from assistant.virtual.cr.command import VT, Command, bare, parts, whole
from assistant.virtual.cr.lines import check_line
from assistant.virtual.cr.state import CrSession
from assistant.virtual.cr.store import LAST_LINE, CrProgram, CrRefusal, checked_name

DELETED_LINE: Final = re.compile(r"\s*\d*\s*", re.ASCII)
"""A number alone deletes its line, and is no line to parse."""
FIRST_LINE: Final = 10
"""The number of the first line, and from line to line, where RENUM is told 0."""


def _new_program(session: CrSession) -> str:
    session.close()
    return ""


def _load_program(session: CrSession, argument: str) -> str:
    session.open(checked_name(argument))
    return ""


def _save_program(session: CrSession) -> str:
    program = session.edit
    assert session.name is not None
    state = session.state
    program.changed = state.now()
    state.store.save(session.name, program)
    state.forget(session.name)
    session.close()
    return ""


def _put_line(session: CrSession, argument: str) -> str:
    program = session.edit
    _put_checked_line(session, program, argument)
    return ""


def _put_lines(session: CrSession, argument: str) -> str:
    program, lines = session.edit, argument.split(VT)
    known = _are_correct(session.state.language, lines)
    for number, line in enumerate(lines, start=1):
        try:
            if line:
                _put_checked_line(session, program, line, known=known)
        except CrRefusal as error:
            raise CrRefusal(error.number, number, *error.places) from None
    return ""


def _are_correct(language: str, lines: Sequence[str]) -> bool:
    """Whether nothing is wrong with any line; looked at together they take the time of one."""
    try:
        check_line(
            language, "\r\n".join(line for line in lines if not DELETED_LINE.fullmatch(line))
        )
    except CrRefusal:
        return False
    return True


def _put_checked_line(
    session: CrSession, program: CrProgram, line: str, *, known: bool = False
) -> None:
    """known: that nothing is wrong with the line."""
    if not known and not DELETED_LINE.fullmatch(line):
        check_line(session.state.language, line)
    program.put(line)
    session.changed = True


def _insert_line(session: CrSession, argument: str) -> str:
    """A line before the one that has its number; that and those that follow close up move on."""
    program = session.edit
    number, text = parts(argument, 2)
    at = whole(number, 1, LAST_LINE, error=4420)
    check_line(session.state.language, f"{at} {text}")
    last = at
    while last in program.steps:
        last += 1
    if last > LAST_LINE:
        raise CrRefusal(4420, 1)
    steps = dict(program.steps)
    for line in range(last, at, -1):
        steps[line] = f"{line} {program.steps[line - 1].partition(' ')[2]}"
    program.renumber(steps)
    program.put(f"{at} {text}")
    session.changed = True
    return ""


def _clear_program(session: CrSession) -> str:
    session.edit.clear()
    session.changed = True
    return ""


def _delete_steps(session: CrSession, argument: str) -> str:
    program = session.edit
    first, last = line_range(argument)
    gone = [number for number in program.steps if first <= number <= last]
    if not gone:
        raise CrRefusal(4230)
    program.renumber({n: line for n, line in program.steps.items() if n not in gone})
    session.changed = True
    return ""


def line_range(argument: str) -> tuple[int, int]:
    """`<a>;<b>`, either may be missing."""
    found = re.fullmatch(r"(\d{0,5})(?:;(\d{0,5}))?", argument, re.ASCII)
    if found is None:
        raise CrRefusal(4460)
    first = int(found[1]) if found[1] else 1
    return first, int(found[2]) if found[2] else (first if found[2] is None else LAST_LINE)


def _renumber(session: CrSession, argument: str) -> str:
    """Jumps to line numbers are changed with them; 4410 where that cannot be done."""
    program = session.edit
    new, start, step, end = (whole(part, 0, LAST_LINE) for part in parts(argument, 4))
    numbers = sorted(program.steps)
    if not numbers:
        return ""
    if (start not in (0, numbers[0])) or (end != 0 and end < numbers[-1]):
        raise CrRefusal(4410)  # jumps between renumbered lines and others are not followed
    language = languages.get(session.state.language)
    text = "".join(f"{line}\n" for line in program.lines())
    try:
        made = language.render(
            language.renumber(language.parse(text), new or FIRST_LINE, step or FIRST_LINE)
        )
    except Refused:
        raise CrRefusal(4410) from None
    renumbered = CrProgram()
    for line in lines_of(made):
        renumbered.put(line)
    program.renumber(renumbered.steps)
    session.changed = True
    return ""


EDIT_COMMANDS: Final = {
    "NEW": Command(bare(_new_program)),
    "LOAD=": Command(_load_program),
    "SAVE": Command(bare(_save_program)),
    "EDATA": Command(_put_line),
    "EMDAT": Command(_put_lines),
    "EDINS=": Command(_insert_line),
    "ECLR": Command(bare(_clear_program)),
    "DELETE": Command(_delete_steps),
    "RENUM": Command(_renumber),
}
