"""Stop of an arm after a motion was broken off, and what is known of the arm afterwards.

The session that started the motion may be out of step: an answer may be on its way, or the line may
be cut. So the stop is sent on that session at once, for a controller that has one line only, and
again on a separate session, which then reports whether the arm stands still.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import suppress
from typing import Final

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Refused
from assistant.controllers.controller import Controller, Programs
from assistant.controllers.states import Position, State

PATIENCE: Final = 5.0
"""Seconds that the second session waits for each answer at most."""
_SETTLING: Final = 3.0
"""Seconds that an arm may take to come to rest."""
BETWEEN: Final = 0.1
"""Seconds between two looks at the joints."""
_STANDS: Final = 0.02
"""Degrees or mm that a joint that stands may differ from one look to the next: the last digit
that controllers show, twice."""


@dataclass(frozen=True, slots=True)
class Rest:
    """Result of stopping the arm.

    stands: whether two readings found every joint unchanged and nothing running. reason: why
    nothing is known, "" if something is.
    """

    stands: bool
    state: State | None = None
    position: Position | None = None
    reason: str = ""


def stop_at_once(session: Programs) -> None:
    """Sends the stop on the session of the motion; what comes back does not matter here."""
    if isinstance(session, Controller):
        with suppress(Refused, OSError):
            session.stop()


def brought_to_rest(again: Callable[[], Programs]) -> Rest:
    """Stop the arm over a separate session. again: returns a client that is not connected yet."""
    try:
        with again() as session:
            return stopped(session)
    except Refused as refused:
        return _unknown(refused)
    except OSError as error:
        return Rest(False, reason=error.strerror or str(error))


def stopped(session: Programs) -> Rest:
    """Stops on a session that is connected, and looks whether the arm stands."""
    if not isinstance(session, Controller):
        return Rest(False, reason="the address tells nothing of the arm")
    try:
        session.stop()
        return _watched(session)
    except Refused as refused:
        return _unknown(refused)


def _unknown(refused: Refused) -> Rest:
    return Rest(False, reason="; ".join(f.message for f in refused.findings))


def _watched(session: Controller) -> Rest:
    """Looks until the arm stands, or for as long as it may take."""
    end = time.monotonic() + _SETTLING
    before = session.position()
    while True:
        time.sleep(BETWEEN)
        state, now = session.state(), session.position()
        # Both: a program may run although the arm stands,
        # and an arm may still brake after it has ended.
        if not state.running and _same(before, now):
            return Rest(True, state, now)
        if time.monotonic() > end:
            return Rest(False, state, now)
        before = now


def _same(one: Position, other: Position) -> bool:
    if len(one.joints) != len(other.joints):
        return False
    # An arm without this axis reports None each time.
    pairs = zip(one.joints, other.joints, strict=True)
    return all(
        a == b or (a is not None and b is not None and abs(a - b) <= _STANDS) for a, b in pairs
    )
