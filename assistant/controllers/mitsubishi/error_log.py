"""The error history of a CR controller: `date;time;no;text;level;prog;line;detail` each."""

from __future__ import annotations

import re
from dataclasses import replace
from datetime import datetime
from typing import Final

from assistant.controllers.mitsubishi.programs import time_of
from assistant.controllers.mitsubishi.session import Session
from assistant.controllers.mitsubishi.state import fault
from assistant.controllers.states import Fault

LOG_LEVELS: Final = {"H": "1", "L": "2", "C": "3"}
MOST_LOG_ENTRIES: Final = 2000
"""Entries after which a history that never ends is taken for a fault."""


def error_history(session: Session, most: int) -> tuple[Fault, ...]:
    """The latest errors, the newest first; all are read, as manuals tell no order of theirs."""
    doing = "reading the error history"
    found: list[Fault] = []
    text = session.ask("ERRORLOGTOP", doing=doing).text
    while text.strip("; ") and len(found) < MOST_LOG_ENTRIES:
        fields = text.split(";")
        if len(fields) < 5 or not re.fullmatch(r"\d{1,5}", fields[2].strip()):
            session.garbled(doing, text)
        found.append(_log_entry(fields))
        text = session.ask("ERRORLOG+1", doing=doing).text
    newest = sorted(found, key=lambda entry: entry.time or datetime.min, reverse=True)
    return tuple(newest[:most])


def _log_entry(fields: list[str]) -> Fault:
    date, clock, number, text, level, *rest = (field.strip() for field in fields)
    words = "".join(letter for letter in text if letter.isprintable())
    if rest and rest[0]:
        line = f", line {rest[1]}" if len(rest) > 1 and rest[1].strip("0") else ""
        words += f" (`{rest[0]}`{line})"
    told = fault(int(number), LOG_LEVELS.get(level.upper(), level), words)
    return replace(told, time=time_of(f"{date}{clock}"))
