"""Looking at a controller again and again, without any right."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from typing import Final

from assistant.base.diagnostics import Refused
from assistant.controllers import rules
from assistant.controllers.abb.rws.panel import Panel
from assistant.controllers.abb.rws.rapid import Rapid
from assistant.controllers.abb.rws.session import Session
from assistant.controllers.abb.rws.signals import Signals
from assistant.controllers.abb.rws.subscriptions import Event, Events, subscribed
from assistant.controllers.states import Sample, State

WATCHED_RESOURCES: Final = ("motors", "mode", "override", "execution")
"""What is told of by events instead of being asked for at each look."""
FULL_LOOK_INTERVAL: Final = 1.0
"""Seconds after which the state is asked for in any case."""


def watch(
    session: Session,
    panel: Panel,
    rapid: Rapid,
    signals: Signals,
    interval: float,
    names: Sequence[str],
) -> Iterator[Sample]:
    """Samples, each `interval` seconds: late ones are not made up for.

    Controllers take 20 requests a second. So each look asks for the pose, of which no event
    tells, and whether programs run, whose events come 0.2 s late; for the rest of the state only
    while they run, when an event has told of another one, or after a second.
    """
    with ExitStack() as stack:
        events = _subscription(session, signals, names, stack)
        began = due = time.monotonic()
        state, asked = State(), float("-inf")
        values: dict[str, float] = {}
        while True:
            told = list(_waiting_events(events))
            running = panel.running()
            old = events is None or running or running != state.running or bool(told)
            if old or time.monotonic() > asked + FULL_LOOK_INTERVAL:
                state, asked = panel.state(rapid.tasks()), time.monotonic()
            if names and (events is None or not values or any(_of_signal(e) for e in told)):
                values = signals.values(names, frozenset())
            yield Sample(time.monotonic() - began, state, panel.position(), dict(values))
            due = max(due + interval, time.monotonic())
            time.sleep(max(0.0, due - time.monotonic()))


def _subscription(
    session: Session, signals: Signals, names: Sequence[str], stack: ExitStack
) -> Events | None:
    """A subscription; None where the controller has none to give, so that all is asked for."""
    wanted = [*WATCHED_RESOURCES, *(f"signal:{signals.known(name)}" for name in names)]
    try:
        return stack.enter_context(subscribed(session, signals, wanted))
    except rules.Lost:
        raise
    except Refused:
        return None


def _waiting_events(events: Events | None) -> Iterator[Event]:
    while events is not None and (event := events.next(0.0)) is not None:
        yield event


def _of_signal(event: Event) -> bool:
    return event.kind.startswith("ios-signal")
