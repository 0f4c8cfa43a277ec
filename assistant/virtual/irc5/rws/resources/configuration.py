"""`/rw/cfg`: the parameters of the I/O configuration, which are what the controller was given.

Classes `cfg-dt-instance-li` and `cfg-ia-t` (RWS 1.0: `-li` behind it) as of ABB's reference of
Robot Web Services 1.0 and the tests of ichbinmeraj/abb-rws-client.
"""

from __future__ import annotations

from typing import Final

from assistant.virtual.irc5.cabinet import Cabinet, Signal
from assistant.virtual.irc5.rws import reasons
from assistant.virtual.irc5.rws.answers import Answer, Item, Rejected
from assistant.virtual.irc5.rws.request import Request

DOMAIN: Final = "EIO"
TYPE: Final = "EIO_SIGNAL"
PAGE: Final = 70
"""Instances that are listed at once."""


def domains(cabinet: Cabinet, request: Request) -> Answer:
    return Answer(listed=[Item("cfg-domain-li", DOMAIN, {}, f"cfg/{DOMAIN}")])


def instances(cabinet: Cabinet, request: Request) -> Answer:
    domain, type = request.captures["domain"].upper(), request.captures["type"].upper()
    if (domain, type) != (DOMAIN, TYPE):
        raise Rejected(reasons.BAD_ARGUMENT, "Invalid type id")
    found = sorted(cabinet.signals().values(), key=lambda one: one.name)
    start = request.number("start", 0, 10**6, 0)
    page = found[start : start + PAGE]
    onward = f"instances?start={start + PAGE}" if start + PAGE < len(found) else ""
    return Answer(listed=[_instance(request, one) for one in page], next=onward)


def set_instance(cabinet: Cabinet, request: Request) -> Answer:
    raise Rejected(reasons.NOT_PERMITTED, "it keeps the parameters that it was given")


def _instance(request: Request, signal: Signal) -> Item:
    told = {"Name": signal.name, "SignalType": signal.type, "Device": signal.device}
    kind = request.either("cfg-ia-t-li", "cfg-ia-t")
    inside = tuple(Item(kind, name, {"value": value}) for name, value in told.items())
    fields = {"rdonly": "true", "instanceid": signal.name}
    return Item("cfg-dt-instance-li", signal.name, fields, "", inside, "attrib")
