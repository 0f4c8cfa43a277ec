"""Subscriptions: groups of resources, and the WebSockets that carry their events.

A change is reported as late as the priority of its resource allows; signals report each change,
everything else its value at the next look. Classes and references of events as of the public
clients rpiRobotics/abb_robot_client (rws.py), ichbinmeraj/abb-rws-client and a capture in the tests
of a Go client (`ios-signalstate-ev`, `elog-message-ev`). For data RWS 1.0 sends two elements, the
second with the value.
"""

from __future__ import annotations

import contextlib
import re
import threading
import time
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import field
from typing import TYPE_CHECKING, Final

from wsproto.connection import Connection as WebSocket
from wsproto.connection import ConnectionType
from wsproto.events import CloseConnection, Message, Ping
from wsproto.utilities import LocalProtocolError, RemoteProtocolError, generate_accept_token

from assistant.base.data_classes import dataclass
from assistant.virtual.irc5 import rws_hardware, rws_messages, rws_rapid
from assistant.virtual.irc5.cabinet import OUTPUT_TYPES, Cabinet, Signal
from assistant.virtual.irc5.programs import TASK
from assistant.virtual.irc5.rws_messages import (
    Answer,
    Item,
    Place,
    Rejected,
    Request,
    event_message,
)

if TYPE_CHECKING:
    from assistant.virtual.irc5.rws_http import Connection


ReadValue = Callable[[], str]


@dataclass(frozen=True, slots=True)
class Watch:
    """A resource that a client watches. resource: as the client named it. read: returns its present
    value; a changed value sends an event. events: returns the items of a value. signal: the signal
    whose changes are reported one by one, None if the resource has none. first: whether the value
    at the beginning is reported.
    """

    resource: str
    priority: int
    read: ReadValue
    events: Callable[[str], Sequence[Item]]
    signal: Signal | None = None
    first: bool = True


@dataclass(frozen=True, slots=True)
class _PlainKind:
    """field: of the event. path: what the pattern of the resource is, of each dialect."""

    one: str
    two: str
    type: str
    field: str
    read: Callable[[Cabinet], str]


_PLAIN_KINDS: Final = (
    _PlainKind("/rw/panel/ctrlstate(;ctrlstate)?", "/rw/panel/ctrl-state(;ctrlstate)?",
          "pnl-ctrlstate-ev", "ctrlstate", lambda c: c.panel.state),
    _PlainKind("/rw/panel/opmode(;opmode)?", "/rw/panel/opmode(;opmode)?",
          "pnl-opmode-ev", "opmode", lambda c: c.panel.mode),
    _PlainKind("/rw/panel/speedratio(;speedratio)?", "/rw/panel/speedratio(;speedratio)?",
          "pnl-speedratio-ev", "speedratio", lambda c: str(c.panel.speed)),
    _PlainKind("/rw/panel/coldetstate(;coldetstate)?", "/rw/panel/coldetstate(;coldetstate)?",
          "pnl-coldetstate-ev", "coldetstate", lambda _: "INIT"),
    _PlainKind("/rw/rapid/execution;ctrlexecstate", "/rw/rapid/execution;ctrlexecstate",
          "rap-ctrlexecstate-ev", "ctrlexecstate",
          lambda c: "running" if c.programs.running else "stopped"),
    _PlainKind("/rw/rapid/execution;rapidexeccycle", "/rw/rapid/execution;rapidexeccycle",
          "rap-execcycle-ev", "rapidexeccycle", lambda c: c.programs.cycle),
    _PlainKind(f"/rw/rapid/tasks/{TASK};taskchange", f"/rw/rapid/tasks/{TASK};taskchange",
          "rap-task-ev", "change-count", lambda c: str(c.programs.changes)),
)  # fmt: skip
_SIGNAL_PATHS: Final = re.compile(r"/rw/iosystem/signals/(.+);state")
_DATA_PATHS: Final = {
    1: re.compile(r"/rw/rapid/symbol/data/(RAPID/(.+));value"),
    2: re.compile(r"/rw/rapid/symbol/(RAPID/(.+))/data(?:;value)?"),
}
_LOG_PATHS: Final = re.compile(r"/rw/elog/(\d+)(?:;\w+)?")


def watch(cabinet: Cabinet, request: Request, resource: str, priority: int) -> Watch:
    """Raises Rejected for what cannot be watched."""
    for kind in _PLAIN_KINDS:
        if re.fullmatch(request.either(kind.one, kind.two), resource):
            return _watch_plain(cabinet, kind, resource, priority)
    if found := _SIGNAL_PATHS.fullmatch(resource):
        return _watch_signal(cabinet, found[1], resource, priority)
    if found := _DATA_PATHS[request.dialect].fullmatch(resource):
        return _watch_data(cabinet, request, resource, priority, found[1], found[2])
    if found := _LOG_PATHS.fullmatch(resource):
        return _watch_log(cabinet, resource, priority, int(found[1]))
    raise Rejected(rws_messages.NO_EVENTS, resource)


def _watch_plain(cabinet: Cabinet, kind: _PlainKind, resource: str, priority: int) -> Watch:
    return Watch(
        resource,
        priority,
        lambda: kind.read(cabinet),
        lambda value: [Item(kind.type, kind.field, {kind.field: value}, resource)],
    )


def _watch_signal(cabinet: Cabinet, path: str, resource: str, priority: int) -> Watch:
    signal = rws_hardware.find_signal(cabinet, path)

    def events(value: str) -> list[Item]:
        fields = {"lvalue": value, "lstate": "not simulated"}
        return [Item("ios-signalstate-ev", signal.title, fields, resource)]

    return Watch(
        resource, priority, lambda: rws_hardware.signal_value(cabinet, signal), events, signal
    )


def _watch_data(
    cabinet: Cabinet, request: Request, resource: str, priority: int, url: str, path: str
) -> Watch:
    def read() -> str:
        return rws_rapid.symbol_value_at(cabinet, request.dialect, path)

    def events(value: str) -> list[Item]:
        if request.dialect == 2:
            return [Item("rap-value-ev", "value", {"value": value}, resource)]
        told = Item("rap-value-ev", "value", {}, resource)
        return [told, Item("rap-data", url, {"value": value})]

    # Read once now, so that data that does not exist refuses the subscription.
    read()
    return Watch(resource, priority, read, events)


def _watch_log(cabinet: Cabinet, resource: str, priority: int, domain: int) -> Watch:
    """Its value is the number of the latest event of all; those of other domains tell nothing."""

    def read() -> str:
        return str(cabinet.log.count)

    def events(value: str) -> list[Item]:
        if all(str(one.number) != value for one in cabinet.log.of(domain)):
            return []
        href = f"/rw/elog/{domain}/{value}"
        return [Item("elog-message-ev", "message", {"seqnum": value}, href)]

    return Watch(resource, priority, read, events, first=False)


_PROTOCOLS: Final = {1: "robapi2_subscription", 2: "rws_subscription"}
_PERIODS: Final = {0: 5.0, 1: 0.2, 2: 0.02}
"""Seconds by priority, from low to high, as the manual of RWS states them (told from memory)."""
_TICK: Final = 0.02
"""Seconds between two looks of a WebSocket."""
_MOST_GROUPS: Final = 64
_MOST_WATCHED: Final = 1000
_POLICY_VIOLATION: Final = 1008
_GOING_AWAY: Final = 1001
_POLL: Final = re.compile(r"/poll/(\d+)")


@dataclass(slots=True, eq=False)
class _Group:
    """A subscription group. session: its key. watches: by resource. known: reported values. spent:
    whether its WebSocket was opened once.
    """

    number: int
    session: str
    dialect: int
    watches: dict[str, Watch] = field(default_factory=dict)
    known: dict[str, str] = field(default_factory=dict)
    looked: dict[str, float] = field(default_factory=dict)
    changes: deque[tuple[Watch, str]] = field(default_factory=deque)
    leave: dict[str, Callable[[], None]] = field(default_factory=dict)
    spent: bool = False
    over: threading.Event = field(default_factory=threading.Event)

    def news(self) -> list[Sequence[Item]]:
        """Return the items of each event since the last look."""
        found: list[Sequence[Item]] = []
        # Signals report every change, also one that is gone again at the next look.
        while self.changes:
            one, value = self.changes.popleft()
            if one.resource in self.watches:
                found.append(one.events(value))
        now = time.monotonic()
        for resource, one in tuple(self.watches.items()):
            if one.signal is not None or now < self.looked[resource] + _PERIODS[one.priority]:
                continue
            self.looked[resource] = now
            with contextlib.suppress(Rejected, RuntimeError, TimeoutError):
                value = one.read()
                if self.known[resource] != value:
                    found += self._told(one, value)
        return found

    def _told(self, one: Watch, value: str) -> list[Sequence[Item]]:
        """Return the events of a changed value; those of the log one for each number since the last
        one.
        """
        before, self.known[one.resource] = self.known[one.resource], value
        if one.first:
            return [one.events(value)]
        # Several events may have come since the last look: each gets its message.
        numbers = range(int(before) + 1, int(value) + 1)
        return [told for number in numbers if (told := one.events(str(number)))]


class Subscriptions:
    """The groups of all sessions, of both dialects."""

    def __init__(self, cabinet: Cabinet) -> None:
        self.cabinet = cabinet
        self._groups: dict[int, _Group] = {}
        self._count = 0
        self._lock = threading.RLock()

    def close(self) -> None:
        for group in tuple(self._groups.values()):
            self._drop(group)

    def end_session(self, key: str) -> None:
        for group in tuple(self._groups.values()):
            if group.session == key:
                self._drop(group)

    # -------------------------------------------------------------------------- requests

    def create(self, request: Request) -> Answer:
        watches = self._watches(request)
        with self._lock:
            if len(self._groups) >= _MOST_GROUPS:
                raise Rejected(rws_messages.TOO_MANY_REQUESTS)
            self._count += 1
            group = _Group(self._count, request.session.key, request.dialect)
            self._groups[group.number] = group
        items = [item for one in watches for item in self._join(group, one)]
        scheme = request.either("ws", "wss")
        poll = f"{scheme}://{request.host}/poll/{group.number}"
        links = ((f"subscription/{group.number}", "group"), (poll, "self"))
        return Answer(201, items, links=links, headers={"Location": poll}, only_xhtml=True)

    def add(self, request: Request) -> Answer:
        """More resources; RWS 2.0 only."""
        group = self._of(request)
        items = [item for one in self._watches(request) for item in self._join(group, one)]
        return Answer(200, items, only_xhtml=True)

    def delete(self, request: Request) -> Answer:
        group = self._of(request)
        resource = request.captures.get("resource")
        if resource is None:
            self._drop(group)
            return Answer(200)
        if f"/{resource}" not in group.watches:
            raise Rejected(rws_messages.NO_EVENTS, f"/{resource} is not in the group")
        self._leave(group, f"/{resource}")
        if not group.watches:
            self._drop(group)
        return Answer(200)

    def _watches(self, request: Request) -> list[Watch]:
        found = []
        for key, resource in request.form.items():
            if key.isdecimal():
                priority = request.form.get(f"{key}-p", "1")
                if priority not in ("0", "1", "2"):
                    raise Rejected(rws_messages.BAD_ARGUMENT, f"{key}-p")
                found.append(watch(self.cabinet, request, resource, int(priority)))
        if not found or len(found) > _MOST_WATCHED:
            raise Rejected(rws_messages.BAD_ARGUMENT, "resources")
        return found

    def _of(self, request: Request) -> _Group:
        text = request.captures["group"]
        group = self._groups.get(int(text)) if text.isdecimal() and len(text) < 10 else None
        if group is None or group.session != request.session.key:
            raise Rejected(rws_messages.NO_EVENTS, f"group {text}")
        return group

    def _join(self, group: _Group, one: Watch) -> list[Item]:
        """Watches a resource; its value now."""
        value = one.read()
        self._leave(group, one.resource)
        group.watches[one.resource], group.known[one.resource] = one, value
        group.looked[one.resource] = time.monotonic()
        if one.signal is not None:
            name, board = one.signal.name.lower(), self.cabinet.board
            side = board.outputs if one.signal.type in OUTPUT_TYPES else board.inputs

            def heard(changed: str, before: float, now: float) -> None:  # noqa: ARG001
                if changed == name:
                    group.changes.append((one, f"{now:.7g}"))

            # Listeners belong to the thread of the kernel.
            self.cabinet.live.do(lambda _: side.listeners.append(heard))
            group.leave[one.resource] = lambda: side.listeners.remove(heard)
        return list(one.events(value)) if one.first else []

    def _leave(self, group: _Group, resource: str) -> None:
        group.watches.pop(resource, None)
        leave = group.leave.pop(resource, None)
        if leave is not None:
            with contextlib.suppress(RuntimeError, TimeoutError):
                self.cabinet.live.do(lambda _: leave())

    def _drop(self, group: _Group) -> None:
        with self._lock:
            self._groups.pop(group.number, None)
        for resource in tuple(group.watches):
            self._leave(group, resource)
        group.over.set()

    # ------------------------------------------------------------------------ WebSockets

    def open(self, path: str, connection: Connection) -> bool:
        """Serve a WebSocket until either side ends it; False if no group is at that path."""
        found = _POLL.fullmatch(path)
        group = None if found is None else self._groups.get(int(found[1][:9]))
        # A group of RWS 2.0 can open its WebSocket once only.
        if group is None or (group.dialect == 2 and group.spent):
            return False
        key = connection.headers.get("Sec-WebSocket-Key", "")
        offered = connection.headers.get("Sec-WebSocket-Protocol", "").replace(" ", "").split(",")
        protocol = _PROTOCOLS[connection.site.dialect]
        if not key or protocol not in offered or group.dialect != connection.site.dialect:
            connection.refuse_socket()
            return True
        group.spent = True
        rows = (
            "HTTP/1.1 101 Switching Protocols",
            "Upgrade: websocket",
            "Connection: Upgrade",
            f"Sec-WebSocket-Accept: {generate_accept_token(key.encode()).decode()}",
            f"Sec-WebSocket-Protocol: {protocol}",
        )
        with contextlib.suppress(OSError, LocalProtocolError, RemoteProtocolError):
            connection.transmit("\r\n".join((*rows, "", "")).encode())
            self._serve(group, connection)
        return True

    def _serve(self, group: _Group, connection: Connection) -> None:
        socket, wire = connection.connection, WebSocket(ConnectionType.SERVER)
        # The socket is read with a short time-out: events are sent between two reads.
        socket.settimeout(_TICK)
        place = Place(connection.place().base)
        while not group.over.is_set():
            for items in group.news():
                text = event_message(group.number, items, place)
                connection.transmit(wire.send(Message(data=text)))
            try:
                data = socket.recv(4096)
            except TimeoutError:
                continue
            if not data:
                return
            wire.receive_data(data)
            for told in wire.events():
                if isinstance(told, Ping):
                    connection.transmit(wire.send(told.response()))
                elif isinstance(told, CloseConnection):
                    connection.transmit(wire.send(told.response()))
                    return
                # RWS 2.0 hangs up on a client that sends data (see the client's `subscriptions`).
                elif isinstance(told, Message) and group.dialect == 2:
                    reason = "Client cannot send data."
                    connection.transmit(
                        wire.send(CloseConnection(code=_POLICY_VIOLATION, reason=reason))
                    )
                    return
        connection.transmit(wire.send(CloseConnection(code=_GOING_AWAY)))
