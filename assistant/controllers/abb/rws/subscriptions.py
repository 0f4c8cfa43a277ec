"""Subscriptions to events of a controller by WebSocket, and samples of its state that use them.

The client never sends into the WebSocket: RWS 2.0 hangs up on a client that does, pings included
(source: `src/rws2/core.ts` of ichbinmeraj/abb-rws-client). `watch` needs no rights.
"""

from __future__ import annotations

import re
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import field, replace
from typing import TYPE_CHECKING, Final

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Refused
from assistant.controllers import rules
from assistant.controllers.abb.rws.protocol import Answer, Row, parse_answer
from assistant.controllers.abb.rws.rapid import Rapid
from assistant.controllers.abb.rws.session import Session
from assistant.controllers.abb.rws.system import Panel, Signals
from assistant.controllers.states import Sample, State

if TYPE_CHECKING:
    from assistant.controllers.abb.rws.channel import Channel


_GROUP_ADDRESS: Final = re.compile(r"/(?:poll|subscription)/([\w-]+)")
_RESOURCE_ADDRESS: Final = re.compile(r"[\w/.;$:-]+")
PRIORITY: Final = {"log": "1", "signal": "2", "variable": "2"}
"""Highest priorities that the kinds of resources may have; the others have 1 at most."""


@dataclass(frozen=True, slots=True)
class Event:
    """resource: address of the changed resource. values: its reported values, by name."""

    resource: str
    kind: str
    values: Mapping[str, str] = field(default_factory=dict)


class Events:
    """Events as they come; made by `subscribed`."""

    def __init__(self, session: Session, channel: Channel, initial: Sequence[Event]) -> None:
        self._session = session
        self._channel = channel
        self._waiting = list(initial)

    def next(self, timeout: float | None = None) -> Event | None:
        """Return the next event, None if none arrives in time (None: the session's time-out)."""
        until = time.monotonic() + (self._session.timeout if timeout is None else timeout)
        while not self._waiting:
            left = until - time.monotonic()
            message = self._received(max(left, 0.0))
            if message is None:
                return None
            self._waiting.extend(_parse_events(self._session, message))
        return self._waiting.pop(0)

    def _received(self, timeout: float) -> bytes | None:
        doing, state = "waiting for events", "nothing was changed by that"
        try:
            return self._channel.receive(timeout)
        except TimeoutError:
            return None
        except OSError as error:
            self._session.lost(doing, str(error) or type(error).__name__, state)


@contextmanager
def subscribed(
    session: Session, signals: Signals, names: Sequence[str], *, most: int = 1000
) -> Iterator[Events]:
    """Subscribe to events of resources.

    names: `motors`, `mode`, `override`, `execution`, `log`, `signal:NAME`,
    `variable:TASK/MODULE/NAME`, or the address of a resource. Raises Refused if the controller does
    not report one of them.
    """
    form: list[str] = []
    for number, name in enumerate(names[:most], start=1):
        place, priority = _resource(session, signals, name)
        # The body is written by hand: `urlencode` would escape the semicolons of resources.
        form.append(f"resources={number}&{number}={place}&{number}-p={priority}")
    doing = f"subscribing to {', '.join(names)}"
    answer = session.ask("subscribe", doing=doing, body="&".join(form).encode())
    # Versions differ in where they state the place of the WebSocket.
    where = answer.location or _link(answer)
    group = _GROUP_ADDRESS.search(where)
    if group is None:
        raise session.garbled(doing, f"the place of the events is `{where}`")
    with ExitStack() as stack:
        # Ended before the WebSocket is opened, too: the group exists from the answer on.
        stack.callback(_unsubscribe, session, group[1])
        channel = _channel(session, f"/poll/{group[1]}", stack)
        yield Events(session, channel, _of_rows(answer.rows))


def _unsubscribe(session: Session, group: str) -> None:
    if session.connected:
        with suppress(Refused):  # the group ends with the session at the latest
            session.ask("unsubscribe", doing="ending the subscription", at={"path": group})


def _resource(session: Session, signals: Signals, name: str) -> tuple[str, str]:
    kind, _, about = name.partition(":")
    if name.startswith("/"):
        place = name
    elif kind == "signal":
        place = session.dialect.events[kind].format(signals.place(about))
    elif kind in session.dialect.events:
        place = session.dialect.events[kind].format(about)
    else:
        place = ""
    if not _RESOURCE_ADDRESS.fullmatch(place):
        known = ", ".join(f"`{known}`" for known in sorted(session.dialect.events))
        raise Refused(
            rules.BAD_VALUE(
                place=name, value=name, what="subscribed to", reason="it is no resource", form=known
            )
        )
    return place, PRIORITY.get(kind, "1")


def _channel(session: Session, path: str, stack: ExitStack) -> Channel:
    """The WebSocket of a group, at the controller's address as this computer knows it."""
    from assistant.controllers.abb.rws.channel import opened

    uri = f"{'wss' if session.dialect.secure else 'ws'}://{session.authority}{path}"
    # The cookie makes the WebSocket part of the session.
    place, headers = (session.address.host, session.address.port), {"Cookie": session.cookie}
    subprotocol = session.dialect.subprotocol
    try:
        return stack.enter_context(
            opened(uri, place, session.trust, subprotocol, headers, session.timeout)
        )
    except (OSError, ValueError) as error:
        reason = str(error) or type(error).__name__
        raise session.refusal(
            "tell of events", reason, "look at the state again and again instead"
        ) from None


def _link(answer: Answer) -> str:
    """Some versions have the place in the answer instead of a header."""
    found = re.search(rb'href="(wss?://[^"]+)"', answer.data)
    return found[1].decode("ascii", "replace") if found else ""


def _parse_events(session: Session, message: bytes) -> list[Event]:
    if message.strip() in (b"", b"PONG"):
        return []
    try:
        rows, _, _, _ = parse_answer(message)
    except ValueError as error:
        raise session.garbled("waiting for events", str(error)) from None
    return _of_rows(rows)


def _of_rows(rows: Sequence[Row]) -> list[Event]:
    """Events; of data, RWS 1.0 tells the value in a row behind that of the event."""
    found: list[Event] = []
    for row in rows:
        if row.kind.endswith("-ev"):
            found.append(Event(row.href, row.kind, row.values))
        elif found and row.values:
            found[-1] = replace(found[-1], values={**found[-1].values, **row.values})
    return found


_WATCHED_RESOURCES: Final = ("motors", "mode", "override", "execution")
"""Resources that report changes by events instead of a request at each sample."""
_FULL_LOOK_INTERVAL: Final = 1.0
"""Seconds after which the state is requested in any case."""


def watch(
    session: Session,
    panel: Panel,
    rapid: Rapid,
    signals: Signals,
    interval: float,
    names: Sequence[str],
) -> Iterator[Sample]:
    """Yield samples, one each `interval` seconds; late ones are not made up for.

    Controllers take 20 requests a second. So each sample requests the pose, which has no event, and
    whether programs run, whose events arrive 0.2 s late; it requests the rest of the state only
    while they run, after an event of another resource, or after a second.
    """
    with ExitStack() as stack:
        events = _subscription(session, signals, names, stack)
        began = due = time.monotonic()
        state, asked = State(), float("-inf")
        values: dict[str, float] = {}
        while True:
            told = list(_waiting_events(events))
            running = panel.running()
            # Events of the execution come 0.2 s late; while
            # programs run, their lines change without any.
            old = events is None or running or running != state.running or bool(told)
            if old or time.monotonic() > asked + _FULL_LOOK_INTERVAL:
                state, asked = panel.state(rapid.tasks()), time.monotonic()
            if names and (events is None or not values or any(_of_signal(e) for e in told)):
                values = signals.values(names, frozenset())
            yield Sample(time.monotonic() - began, state, panel.position(), dict(values))
            # A late sample shifts the next ones: they are not made up for in a burst.
            due = max(due + interval, time.monotonic())
            time.sleep(max(0.0, due - time.monotonic()))


def _subscription(
    session: Session, signals: Signals, names: Sequence[str], stack: ExitStack
) -> Events | None:
    """Return a subscription; None if the controller refuses, so that all is requested."""
    wanted = [*_WATCHED_RESOURCES, *(f"signal:{signals.known(name)}" for name in names)]
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
