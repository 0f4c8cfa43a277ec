"""`/rw/elog`: the event log. RWS 1.0 tells the newest first, 2.0 the oldest unless asked."""

from __future__ import annotations

from typing import Final

from assistant.virtual.irc5.cabinet import Cabinet
from assistant.virtual.irc5.panel import Event
from assistant.virtual.irc5.rws import reasons
from assistant.virtual.irc5.rws.answers import DONE, Answer, Item, Rejected
from assistant.virtual.irc5.rws.request import Request
from assistant.virtual.irc5.rws.resources.system import CONTROLLER_TIME

EVENT_DOMAINS: Final = (0, 1, 2, 3, 4, 5, 7, 8, 9, 10, 11, 12, 13, 15)
EVENTS_PAGE: Final = 50


def event_domains(cabinet: Cabinet, request: Request) -> Answer:
    listed = []
    for number in EVENT_DOMAINS:
        fields = {"numevts": str(len(cabinet.log.of(number))), "buffsize": "1000"}
        listed.append(Item("elog-domain-li", str(number), fields, str(number)))
    return Answer(listed=listed)


def event_messages(cabinet: Cabinet, request: Request) -> Answer:
    domain, newest = _event_domain(request), request.dialect == 1
    if request.query.get("order", "").lower() == "lifo":
        if request.dialect == 2 and "v=2.1" not in request.accept:
            raise Rejected(reasons.BAD_ARGUMENT, "LIFO is not supported in v=2.0, use v=2.1")
        newest = True
    events = cabinet.log.of(domain)
    if newest:
        events.reverse()
    limit = request.number("limit", 1, EVENTS_PAGE, EVENTS_PAGE)
    start = request.number("start", 0, 10**6, request.dialect == 1)
    first = max(start - 1, 0) * limit if request.dialect == 1 else start
    words = bool(request.query.get("lang"))
    page = events[first : first + limit]
    more = first + limit < len(events)
    onward = start + 1 if request.dialect == 1 else first + limit
    lang = f"&lang={request.query['lang']}" if words else ""
    order = "&order=lifo" if request.dialect == 2 and newest else ""
    return Answer(
        listed=[_event_item(one, domain, words, "elog-message-li") for one in page],
        next=f"{domain}?start={onward}&limit={limit}{lang}{order}" if more else "",
    )


def event_message(cabinet: Cabinet, request: Request) -> Answer:
    domain, number = _event_domain(request), request.captures["number"]
    for one in cabinet.log.of(domain):
        if str(one.number) == number:
            words = bool(request.query.get("lang"))
            return Answer(items=[_event_item(one, domain, words, "elog-message")])
    raise Rejected(reasons.NO_RESOURCE)


def clear_events(cabinet: Cabinet, request: Request) -> Answer:
    cabinet.log.clear(_event_domain(request) if "domain" in request.captures else 0)
    return DONE


def _event_domain(request: Request) -> int:
    text = request.captures["domain"]
    if not text.isdecimal() or int(text) not in EVENT_DOMAINS:
        raise Rejected(reasons.NO_RESOURCE)
    return int(text)


def _event_item(event: Event, domain: int, words: bool, kind: str) -> Item:
    fields = {
        "msgtype": str(event.kind),
        "code": str(event.code),
        "src-name": "MC0",
        "tstamp": event.time.strftime(CONTROLLER_TIME),
    }
    if words:
        said = {
            "title": event.title,
            "desc": event.text,
            "conseqs": "",
            "causes": "",
            "actions": "",
        }
        fields |= said
    fields["argc"] = str(len(event.arguments))
    arguments = tuple(
        Item("", f"arg{i}", {"value": value, "type": "string"})
        for i, value in enumerate(event.arguments, 1)
    )
    href = f"{domain}/{event.number}?lang=en"
    return Item(kind, f"/rw/elog/{domain}/{event.number}", fields, href, arguments, "argv")
