"""What can be subscribed to: a resource, and how its events look.

Classes and references of events as of the public clients rpiRobotics/abb_robot_client (rws.py),
ichbinmeraj/abb-rws-client and a capture in the tests of a Go client (`ios-signalstate-ev`,
`elog-message-ev`). Of data RWS 1.0 sends two elements, the second with the value.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

from assistant.virtual.irc5.cabinet import Cabinet, Signal
from assistant.virtual.irc5.programs import TASK
from assistant.virtual.irc5.rws import reasons
from assistant.virtual.irc5.rws.answers import Item, Rejected
from assistant.virtual.irc5.rws.request import Request
from assistant.virtual.irc5.rws.resources import signals, symbols

ReadValue = Callable[[], str]


@dataclass(frozen=True, slots=True)
class Watch:
    """resource: as the client named it. read: its value now; an event is sent where it is another
    one. events: of a value. signal: whose changes are told one by one, None if there is none.
    first: whether the value at the beginning is told.
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


PLAIN_KINDS: Final = (
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
SIGNAL_PATHS: Final = re.compile(r"/rw/iosystem/signals/(.+);state")
DATA_PATHS: Final = {
    1: re.compile(r"/rw/rapid/symbol/data/(RAPID/(.+));value"),
    2: re.compile(r"/rw/rapid/symbol/(RAPID/(.+))/data(?:;value)?"),
}
LOG_PATHS: Final = re.compile(r"/rw/elog/(\d+)(?:;\w+)?")


def watch(cabinet: Cabinet, request: Request, resource: str, priority: int) -> Watch:
    """Raises Rejected for what cannot be watched."""
    for kind in PLAIN_KINDS:
        if re.fullmatch(request.either(kind.one, kind.two), resource):
            return _watch_plain(cabinet, kind, resource, priority)
    if found := SIGNAL_PATHS.fullmatch(resource):
        return _watch_signal(cabinet, found[1], resource, priority)
    if found := DATA_PATHS[request.dialect].fullmatch(resource):
        return _watch_data(cabinet, request, resource, priority, found[1], found[2])
    if found := LOG_PATHS.fullmatch(resource):
        return _watch_log(cabinet, resource, priority, int(found[1]))
    raise Rejected(reasons.NO_EVENTS, resource)


def _watch_plain(cabinet: Cabinet, kind: _PlainKind, resource: str, priority: int) -> Watch:
    return Watch(
        resource,
        priority,
        lambda: kind.read(cabinet),
        lambda value: [Item(kind.type, kind.field, {kind.field: value}, resource)],
    )


def _watch_signal(cabinet: Cabinet, path: str, resource: str, priority: int) -> Watch:
    signal = signals.find_signal(cabinet, path)

    def events(value: str) -> list[Item]:
        fields = {"lvalue": value, "lstate": "not simulated"}
        return [Item("ios-signalstate-ev", signal.title, fields, resource)]

    return Watch(resource, priority, lambda: signals.signal_value(cabinet, signal), events, signal)


def _watch_data(
    cabinet: Cabinet, request: Request, resource: str, priority: int, url: str, path: str
) -> Watch:
    def read() -> str:
        return symbols.symbol_value_at(cabinet, request.dialect, path)

    def events(value: str) -> list[Item]:
        if request.dialect == 2:
            return [Item("rap-value-ev", "value", {"value": value}, resource)]
        told = Item("rap-value-ev", "value", {}, resource)
        return [told, Item("rap-data", url, {"value": value})]

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
