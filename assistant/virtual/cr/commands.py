"""The commands of the controller link: which one a text is, and what it answers.

Answers, arguments and error numbers are those of the manual BFP-A4288 and of the controllers'
error lists. A command is a row in the table of its subject.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Final

from assistant.virtual.cr import (
    editing,
    errors,
    files,
    listing,
    maintenance,
    monitoring,
    parameters,
    running,
    sessions,
    signals,
    slots,
    variables,
)
from assistant.virtual.cr.command import Command
from assistant.virtual.cr.state import TASKMAX, CrSession
from assistant.virtual.cr.store import CrRefusal

COMMAND_MODULES: Final = (
    sessions,
    editing,
    listing,
    variables,
    files,
    slots,
    running,
    monitoring,
    signals,
    errors,
    parameters,
    maintenance,
)

COMMANDS: Final[Mapping[str, Command]] = {
    name: command for subject in COMMAND_MODULES for name, command in subject.COMMANDS.items()
}

BY_LENGTH: Final = sorted(COMMANDS, key=len, reverse=True)
"""Longest first, so that OVRD= is not taken for OVRD."""

MOST_ROBOTS: Final = 3
LINE_ENDS: Final = re.compile(r"[\r\n\0]")
"""A frame can hold them, but no line of a program and no name."""
EDIT_SLOT: Final = TASKMAX + 1


def execute(session: CrSession, text: str) -> str:
    """The answer to `[robot];[slot];COMMAND`, without `QoK`; raises CrRefusal."""
    head = re.match(r"(\d*);(\d*); *", text, re.ASCII)
    if head is None or LINE_ENDS.search(text):
        raise CrRefusal(6010)
    if int(head[1][:3] or 1) > MOST_ROBOTS:
        raise CrRefusal(5430)
    session.slot = int(head[2][:3] or 1)
    if session.slot > EDIT_SLOT:
        raise CrRefusal(5420)
    body = text[head.end() :]
    name = next((n for n in BY_LENGTH if body.startswith(n)), None)
    if name is None:
        raise CrRefusal(6010)
    command, argument = COMMANDS[name], body[len(name) :]
    if command.right and session.state.right is not session:
        raise CrRefusal(6020)
    return command.handler(session, argument)
