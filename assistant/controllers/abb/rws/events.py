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

COMMON_LOG: Final = "0"
"""Domain of the log that holds the events of all others."""
EVENT_LEVELS: Final[dict[str, Literal["error", "warning", "info"]]] = {
    "1": "info",
    "2": "warning",
    "3": "error",
}
EVENT_TIME: Final = re.compile(r"(\d{4}-\d\d-\d\d)\s*T\s*(\d\d:\d\d:\d\d)")


def latest_events(session: Session, most: int) -> tuple[Fault, ...]:
    """The latest events, the newest first."""
    rows = [row for page in _event_pages(session, most) for row in page.of("elog-message")]
    newest = sorted(rows, key=_event_number, reverse=True)
    return tuple(_event_fault(row) for row in newest[: max(most, 0)])


def _event_pages(session: Session, most: int) -> list[Answer]:
    doing, at = "reading the event log", {"path": COMMON_LOG}
    if "newest events" in session.dialect.operations:
        try:
            return session.pages("newest events", doing=doing, at=at, enough=most)
        except rules.Lost:
            raise
        except Refused:  # an older system lists the oldest first
            return session.pages("events", doing=doing, at=at)
    return session.pages("events", doing=doing, at=at)


def _event_number(row: Row) -> int:
    """The number that events are counted with, from `/rw/elog/0/14073`."""
    last = (row.title or row.href.partition("?")[0]).rpartition("/")[2]
    return int(last) if last.isdecimal() else 0


def _event_fault(row: Row) -> Fault:
    code = row.get("code")
    told = EVENT_TIME.search(row.get("tstamp"))
    parts = (row.get("title"), row.get("desc"))
    return Fault(
        number=int(code) if code.isdecimal() else 0,
        text=": ".join(part for part in parts if part),
        level=EVENT_LEVELS.get(row.get("msgtype"), "info"),
        cure=row.get("actions"),
        time=_event_time(*told.groups()) if told else None,
    )


def _event_time(day: str, clock: str) -> datetime | None:
    try:
        return datetime.fromisoformat(f"{day} {clock}")
    except ValueError:
        return None
