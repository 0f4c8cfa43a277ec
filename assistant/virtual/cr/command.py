"""Commands of the controller link, and functions that read arguments and listings."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from typing import Final

from assistant.base.data_classes import dataclass
from assistant.virtual.cr.state import CrSession
from assistant.virtual.cr.store import CrRefusal

VT: Final = "\v"
"""Between the parts of an argument or an answer that may hold semicolons."""
_MOST_LISTED: Final = 230
"""Bytes of lines in one answer that lists several."""

Handler = Callable[[CrSession, str], str]


@dataclass(frozen=True, slots=True)
class Command:
    """handler: session and argument → answer. right: needs the operation right (BFP-A4288)."""

    handler: Handler
    right: bool = False


def bare(handler: Callable[[CrSession], str]) -> Handler:
    """A command that nothing may follow."""

    def answer(session: CrSession, argument: str) -> str:
        if argument:
            raise CrRefusal(6010)
        return handler(session)

    return answer


def fixed(text: str) -> Command:
    """A command that always answers the same."""
    return Command(bare(lambda _: text))


def whole(text: str, low: int, high: int, error: int = 4460) -> int:
    """A decimal number of an argument; raises CrRefusal."""
    # The length is limited before the conversion, whose time grows with it.
    if not re.fullmatch(r"\d{1,9}", text, re.ASCII) or not low <= int(text) <= high:
        raise CrRefusal(error)
    return int(text)


def hexadecimal(text: str, digits: int) -> int:
    """A number of at most so many hexadecimal digits; raises CrRefusal."""
    if not re.fullmatch(rf"[0-9A-Fa-f]{{1,{digits}}}", text):
        raise CrRefusal(4460)
    return int(text, 16)


def parts(argument: str, count: int) -> list[str]:
    """Return the parts of an argument between semicolons; raises CrRefusal for another count."""
    found = argument.split(";", count - 1)
    if len(found) != count:
        raise CrRefusal(4460)
    return found


def place(
    argument: str,
    following: int,
    keys: Sequence[int] | Sequence[str],
    top: str = "TOP",
    end: str = "END",
) -> int:
    """Index that the words for top and end, +1, -1, or a key of a listing mean; its length for
    none. following: the index behind the one that was listed last.
    """
    steps = {
        top: 0,
        end: max(len(keys) - 1, 0),
        "+1": following,
        # `following` is behind the one listed last: two back is the one before it.
        "-1": max(following - 2, 0),
        "": following,
    }
    if argument in steps:
        return steps[argument]
    wanted = [str(key) for key in keys]
    return wanted.index(argument.upper()) if argument.upper() in wanted else len(keys)


def at_once(lines: Sequence[str], separator: str = VT) -> list[str]:
    """The first lines, as many as one answer takes."""
    listed: list[str] = []
    size = 0
    for line in lines:
        size += len(line) + len(separator)
        # One line always goes, however long.
        if listed and size > _MOST_LISTED:
            break
        listed.append(line)
    return listed
