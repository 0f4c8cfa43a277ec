"""Remote access in manual mode (RMMP), which somebody confirms on the pendant."""

from __future__ import annotations

import time
from typing import Final

from assistant.base.diagnostics import Refused
from assistant.controllers import rules
from assistant.controllers.abb.rws.session import Session

REMOTE_POLL: Final = 0.5
GRANTED: Final = frozenset({"modify", "exec", "exclusive"})


def ask_remote_access(session: Session, wait: float) -> None:
    """Returns when the leave to write has been given; raises Refused if it was not in time."""
    doing = "asking for remote access in manual mode"
    if _granted(session):
        return
    session.ask("ask privilege", doing=doing, form={"privilege": "modify"})
    until = time.monotonic() + wait
    while not _granted(session):
        if time.monotonic() + REMOTE_POLL > until:
            raise Refused(
                rules.NOT_DONE(
                    place=str(session.address),
                    doing=doing,
                    seconds=wait,
                    state="nobody confirmed it on the pendant",
                )
            )
        time.sleep(REMOTE_POLL)
        session.ask("poll privilege", doing=doing)


def _granted(session: Session) -> bool:
    """Whether this session may write in manual mode."""
    rows = session.ask("privilege", doing="asking for the remote access").rows
    mine = [row for row in rows if row.get("rmmpheldbyme").lower() == "true"]
    return any(row.get("privilege").lower() in GRANTED for row in mine)
