"""The event log of a controller."""

from __future__ import annotations

import re
from datetime import datetime
from typing import Final, Literal

from assistant.base.diagnostics import Refused
from assistant.controllers import rules
from assistant.controllers.abb.rws.answers import Answer, Row
from assistant.controllers.abb.rws.session import Session
from assistant.controllers.states import Fault

COMMON: Final = "0"
"""Domain of the log that holds the events of all others."""
LEVELS: Final[dict[str, Literal["error", "warning", "info"]]] = {
    "1": "info",
    "2": "warning",
    "3": "error",
}
TIME: Final = re.compile(r"(\d{4}-\d\d-\d\d)\s*T\s*(\d\d:\d\d:\d\d)")


def latest(session: Session, most: int) -> tuple[Fault, ...]:
    """The latest events, the newest first."""
    rows = [row for page in _pages(session, most) for row in page.of("elog-message")]
    newest = sorted(rows, key=_sequence, reverse=True)
    return tuple(_fault(row) for row in newest[: max(most, 0)])


def _pages(session: Session, most: int) -> list[Answer]:
    doing, at = "reading the event log", {"path": COMMON}
    if "newest events" in session.dialect.operations:
        try:
            return session.pages("newest events", doing=doing, at=at, enough=most)
        except rules.Lost:
            raise
        except Refused:  # an older system lists the oldest first
            return session.pages("events", doing=doing, at=at)
    return session.pages("events", doing=doing, at=at)


def _sequence(row: Row) -> int:
    """The number that events are counted with, from `/rw/elog/0/14073`."""
    last = (row.title or row.href.partition("?")[0]).rpartition("/")[2]
    return int(last) if last.isdecimal() else 0


def _fault(row: Row) -> Fault:
    code = row.get("code")
    told = TIME.search(row.get("tstamp"))
    parts = (row.get("title"), row.get("desc"))
    return Fault(
        number=int(code) if code.isdecimal() else 0,
        text=": ".join(part for part in parts if part),
        level=LEVELS.get(row.get("msgtype"), "info"),
        cure=row.get("actions"),
        time=_time(*told.groups()) if told else None,
    )


def _time(day: str, clock: str) -> datetime | None:
    try:
        return datetime.fromisoformat(f"{day} {clock}")
    except ValueError:
        return None
