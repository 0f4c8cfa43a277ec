"""`/rw/iosystem`: signals that are read and set."""

from __future__ import annotations

import math

from assistant.virtual.irc5.cabinet import Cabinet, Signal
from assistant.virtual.irc5.rws import reasons
from assistant.virtual.irc5.rws.answers import DONE, Answer, Item, Rejected
from assistant.virtual.irc5.rws.request import Request

SIGNALS_PAGE = 100
"""Signals that RWS 2.0 lists at once; 1.0 lists all."""


def list_signals(cabinet: Cabinet, request: Request) -> Answer:
    return _signal_page(cabinet, request, sorted(cabinet.signals().values(), key=lambda s: s.title))


def _signal_page(cabinet: Cabinet, request: Request, found: list[Signal]) -> Answer:
    start = request.number("start", 0, 10**6, 0)
    usual = SIGNALS_PAGE if request.dialect == 2 else len(found) + 1
    limit = request.number("limit", 1, usual, usual)
    page = found[start : start + limit]
    onward = f"signals?start={start + limit}&limit={limit}" if start + limit < len(found) else ""
    return Answer(listed=[_signal_item(cabinet, one, "ios-signal-li") for one in page], next=onward)


def search_signals(cabinet: Cabinet, request: Request) -> Answer:
    """What the form states has to hold; a name is part of one."""
    found = []
    for one in sorted(cabinet.signals().values(), key=lambda s: s.title):
        facts = {"device": one.device, "network": one.network, "type": one.type}
        stated = {key: request.form[key] for key in facts if request.form.get(key)}
        part = request.form.get("name", "").lower()
        if part in one.name.lower() and all(facts[key] == value for key, value in stated.items()):
            found.append(one)
    return _signal_page(cabinet, request, found)


def read_signal(cabinet: Cabinet, request: Request) -> Answer:
    kind = request.either("ios-signal", "ios-signal-li")
    return Answer(
        items=[_signal_item(cabinet, find_signal(cabinet, request.captures["signal"]), kind)]
    )


def write_signal(cabinet: Cabinet, request: Request) -> Answer:
    signal = find_signal(cabinet, request.captures["signal"])
    text = request.given("lvalue")
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    binary = signal.type in ("DI", "DO")
    whole = binary or signal.type in ("GI", "GO")
    if not math.isfinite(value) or (whole and not value.is_integer()) or (whole and value < 0):
        raise Rejected(reasons.BAD_ARGUMENT, f"lvalue {text}")
    if binary and value > 1:
        raise Rejected(reasons.BAD_ARGUMENT, f"lvalue {text}")
    cabinet.write(signal, value)
    return DONE


def find_signal(cabinet: Cabinet, path: str) -> Signal:
    """A signal by its network, device and name, or by its name alone."""
    *where, name = path.split("/")
    signal = cabinet.signals().get(name.lower())
    if signal is None or (where and where != [signal.network, signal.device]):
        raise Rejected(reasons.NO_SIGNAL)
    return signal


def signal_value(cabinet: Cabinet, signal: Signal) -> str:
    return f"{cabinet.read(signal):.7g}"


def _signal_item(cabinet: Cabinet, signal: Signal, kind: str) -> Item:
    fields = {
        "name": signal.name,
        "type": signal.type,
        "category": "",
        "lvalue": signal_value(cabinet, signal),
        "lstate": "not simulated",
    }
    if kind == "ios-signal":
        fields |= {"pvalue": fields["lvalue"], "write-access": "Rapid, LocalManual, LocalAuto"}
    return Item(kind, signal.title, fields, f"signals/{signal.title}")


def list_networks(cabinet: Cabinet, request: Request) -> Answer:
    names = sorted({one.network for one in cabinet.signals().values() if one.network})
    fields = {"pstate": "running", "lstate": "started"}
    return Answer(
        listed=[Item("ios-network-li", n, {"name": n, **fields}, f"networks/{n}") for n in names]
    )


def list_devices(cabinet: Cabinet, request: Request) -> Answer:
    pairs = sorted({(s.network, s.device) for s in cabinet.signals().values() if s.network})
    only = request.query.get("network")
    fields = {"lstate": "enabled", "pstate": "running", "address": "-"}
    return Answer(
        listed=[
            Item("ios-device-li", f"{n}/{d}", {"name": d, **fields}, f"devices/{n}/{d}")
            for n, d in pairs
            if only in (None, n)
        ]
    )
