"""Listings of the program that is open for editing."""

from __future__ import annotations

from typing import Final

from assistant.virtual.cr.command import VT, Command, at_once, place
from assistant.virtual.cr.editing import line_range
from assistant.virtual.cr.state import CrSession
from assistant.virtual.cr.store import CrRefusal

LINE_LIST: Final = "lines"
POSITION_LIST: Final = "positions"
LISTING_WORDS: Final = ("TOP", "END", "+1", "-1", "")


def _list_lines(session: CrSession, argument: str) -> str:
    lines = session.edit.lines()
    start = place(argument, session.following.get(LINE_LIST, 0), sorted(session.edit.steps))
    listed = at_once(lines[start:])
    behind = session.following[LINE_LIST] = start + len(listed)
    return f"{VT.join(listed)};{len(listed)};{int(behind < len(lines))}" if listed else ""


def _list_line(session: CrSession, argument: str) -> str:
    lines = session.edit.lines()
    at = place(argument, session.following.get(LINE_LIST, 0), sorted(session.edit.steps))
    session.following[LINE_LIST] = min(at + 1, len(lines))
    return lines[at] if at < len(lines) else ""


def _list_position(session: CrSession, argument: str) -> str:
    positions = session.edit.positions()
    following = session.following.get(POSITION_LIST, 0)
    if argument in LISTING_WORDS:
        at = place(argument, following, range(len(positions)))
    else:
        names = [line.partition("=")[0].upper() for line in positions]
        at = place(argument, following, names)
    session.following[POSITION_LIST] = min(at + 1, len(positions))
    return positions[at] if at < len(positions) else ""


def _count_lines(session: CrSession, argument: str) -> str:
    first, last = line_range(argument)
    return f"{sum(first <= number <= last for number in session.edit.steps):04}"


def _find_text(session: CrSession, argument: str) -> str:
    """The first line from the top that has the text, and how many characters stand before it."""
    for line in session.edit.lines():
        if argument and argument in line:
            return f"{line};{line.index(argument)}"
    raise CrRefusal(4430)


LIST_COMMANDS: Final = {
    "LISTL": Command(_list_lines),
    "LISTI": Command(_list_line),
    "LISTP": Command(_list_position),
    "LISTCNT": Command(_count_lines),
    "ESEARCH": Command(_find_text),
}
