"""`/rw/system`, `/ctrl`, `/rw/elog`, `/rw/mastership`, `/users`: the controller and its users.

Identity, clock, backup and restore; the event log, which RWS 1.0 lists from the newest event and
2.0 from the oldest unless the request asks for the other order; who may change what, and who is
logged in.
"""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from datetime import datetime
from typing import Final

from assistant.virtual.irc5 import rws_messages
from assistant.virtual.irc5.cabinet import (
    MASTERSHIP_DOMAINS,
    SYSTEM_ID,
    VERSIONS,
    Cabinet,
    back_up,
    is_backup,
    restore,
)
from assistant.virtual.irc5.panel import Event
from assistant.virtual.irc5.programs import NotPossible
from assistant.virtual.irc5.rws_files import path_of, unit_path
from assistant.virtual.irc5.rws_messages import DONE, Answer, Item, Rejected, Request

_SYSTEM_OPTIONS: Final = (
    "RobotWare Base",
    "English",
    "616-1 PC Interface",
    "689-1 Externally Guided Motion",
)
_CONTROLLER_TIME: Final = "%Y-%m-%d T %H:%M:%S"
_CLOCK: Final = ("year", "month", "day", "hour", "min", "sec")


def system_info(cabinet: Cabinet, request: Request) -> Answer:
    version = VERSIONS[request.dialect]
    major, minor, *_ = version.split(".")
    fields = {
        "major": major,
        "minor": minor,
        "name": cabinet.name,
        "rwversion": version,
        "sysid": SYSTEM_ID,
        "starttm": cabinet.began.strftime(_CONTROLLER_TIME),
        "rwversionname": f"{major}.{minor}.00.00",
    }
    own = Item(request.either("sys-system-li", "sys-system"), "system", fields)
    kind = request.either("sys-option-li", "sys-options")
    inside = tuple(Item(kind, str(i), {"option": one}) for i, one in enumerate(_SYSTEM_OPTIONS))
    listed = Item("sys-options-li", "options", {}, "options", inside, "options")
    return Answer(items=[own], listed=[listed])


def system_options(cabinet: Cabinet, request: Request) -> Answer:
    return Answer(
        items=[Item("sys-option-li", str(i), {"option": o}) for i, o in enumerate(_SYSTEM_OPTIONS)]
    )


def robot_type(cabinet: Cabinet, request: Request) -> Answer:
    title = "none" if cabinet.robot is None else cabinet.robot.title
    return Answer(items=[Item("sys-robottype", "robottype", {"robot-type": title})])


def controller_identity(cabinet: Cabinet, request: Request) -> Answer:
    fields = {
        "ctrl-name": cabinet.name,
        "ctrl-type": "Virtual Controller",
        "ctrl-level": "System Level",
    }
    if cabinet.serial:
        fields["ctrl-id"] = cabinet.serial
    return Answer(items=[Item("ctrl-identity-info", "identity", fields)])


def read_clock(cabinet: Cabinet, request: Request) -> Answer:
    fields = {"datetime": cabinet.now().strftime(_CONTROLLER_TIME)}
    return Answer(items=[Item("ctrl-clock-info", "clock", fields)])


def set_clock(cabinet: Cabinet, request: Request) -> Answer:
    try:
        wanted = datetime.strptime(
            " ".join(request.given(f"sys-clock-{part}") for part in _CLOCK), "%Y %m %d %H %M %S"
        )
    except (ValueError, OverflowError):
        raise Rejected(rws_messages.BAD_ARGUMENT, "no time") from None
    cabinet.offset += wanted - cabinet.now()
    return DONE


def volume_path(cabinet: Cabinet, request: Request) -> Answer:
    """`/ctrl/$RAMDISK`: where a volume is."""
    volume = request.captures["volume"].upper()
    if volume not in ("HOME", "TEMP", "RAMDISK", "BACKUP"):
        raise Rejected(rws_messages.NO_RESOURCE)
    value = f"/hd0a/{cabinet.name}/{volume}"
    return Answer(items=[Item("ctrl-env", f"${volume}", {"_value": value, "value": value})])


# ------------------------------------------------------------------------------- backup


def backup_state(cabinet: Cabinet, request: Request) -> Answer:
    """It is made while the request that asks for it is answered, so none is ever under way."""
    fields = {"progress-state": "idle", "backup-state": "idle"}
    return Answer(items=[Item("ctrl-backup-info-li", "backup", fields)])


def backup_ready(cabinet: Cabinet, request: Request) -> Answer:
    """The last of: None, Init State, Backup in Progress, Backup Ready, Error during backup."""
    return Answer(items=[Item("ctrl-backup-state", "backup", {"backup-state": "Backup Ready"})])


def read_progress(cabinet: Cabinet, request: Request) -> Answer:
    """Answer with the progress of a request that got a 202."""
    number = request.captures["number"]
    return Answer(items=[Item("progress", number, {"state": "ready", "code": "294912"})])


def create_backup(cabinet: Cabinet, request: Request) -> Answer:
    target = path_of(cabinet, unit_path(request.given("backup")))
    if target.exists():
        raise Rejected(rws_messages.BAD_ARGUMENT, "there is a file or folder of that name")
    try:
        cabinet.do(lambda programs: back_up(programs, target, cabinet))
    except OSError as wrong:
        shutil.rmtree(target, ignore_errors=True)
        raise Rejected(rws_messages.UNSPECIFIED, wrong.strerror or "") from None
    return Answer(202, headers={"Location": "/progress/1"})


def restore_backup(cabinet: Cabinet, request: Request) -> Answer:
    source = path_of(cabinet, unit_path(request.given("backup")))
    if not is_backup(source):
        raise Rejected(rws_messages.BAD_ARGUMENT, "no backup")
    try:
        cabinet.do(lambda programs: restore(programs, source, cabinet))
    except ValueError as wrong:
        raise Rejected(rws_messages.BAD_ARGUMENT, str(wrong)) from None
    except NotPossible as wrong:
        raise Rejected(rws_messages.WRONG_STATE, str(wrong)) from None
    except OSError as wrong:
        raise Rejected(rws_messages.UNSPECIFIED, wrong.strerror or "") from None
    return Answer(202, headers={"Location": "/ctrl/backup"})


def check_backup(cabinet: Cabinet, request: Request) -> Answer:
    if not is_backup(path_of(cabinet, unit_path(request.given("backup")))):
        raise Rejected(rws_messages.BAD_ARGUMENT, "no backup")
    return DONE


_EVENT_DOMAINS: Final = (0, 1, 2, 3, 4, 5, 7, 8, 9, 10, 11, 12, 13, 15)
_EVENTS_PAGE: Final = 50


def event_domains(cabinet: Cabinet, request: Request) -> Answer:
    listed = []
    for number in _EVENT_DOMAINS:
        fields = {"numevts": str(len(cabinet.log.of(number))), "buffsize": "1000"}
        listed.append(Item("elog-domain-li", str(number), fields, str(number)))
    return Answer(listed=listed)


def event_messages(cabinet: Cabinet, request: Request) -> Answer:
    domain, newest = _event_domain(request), request.dialect == 1
    if request.query.get("order", "").lower() == "lifo":
        if request.dialect == 2 and "v=2.1" not in request.accept:
            raise Rejected(rws_messages.BAD_ARGUMENT, "LIFO is not supported in v=2.0, use v=2.1")
        newest = True
    events = cabinet.log.of(domain)
    if newest:
        events.reverse()
    limit = request.number("limit", 1, _EVENTS_PAGE, _EVENTS_PAGE)
    # RWS 1.0 counts pages from 1, RWS 2.0 events from 0.
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
    raise Rejected(rws_messages.NO_RESOURCE)


def clear_events(cabinet: Cabinet, request: Request) -> Answer:
    cabinet.log.clear(_event_domain(request) if "domain" in request.captures else 0)
    return DONE


def _event_domain(request: Request) -> int:
    text = request.captures["domain"]
    if not text.isdecimal() or int(text) not in _EVENT_DOMAINS:
        raise Rejected(rws_messages.NO_RESOURCE)
    return int(text)


def _event_item(event: Event, domain: int, words: bool, kind: str) -> Item:
    fields = {
        "msgtype": str(event.kind),
        "code": str(event.code),
        "src-name": "MC0",
        "tstamp": event.time.strftime(_CONTROLLER_TIME),
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


_EDIT_DOMAINS: Final[Mapping[str, tuple[str, ...]]] = {
    "edit": ("cfg", "rapid"),
    "motion": ("motion",),
}
"""Domains of RWS 2.0 by those that it makes one of."""


def _mastership_domains(request: Request) -> tuple[str, ...]:
    """Those that the path names, all without one."""
    name = request.captures.get("domain")
    if name is None:
        return MASTERSHIP_DOMAINS
    known = {one: (one,) for one in MASTERSHIP_DOMAINS} if request.dialect == 1 else _EDIT_DOMAINS
    if name not in known:
        raise Rejected(rws_messages.NO_RESOURCE)
    return known[name]


def list_mastership(cabinet: Cabinet, request: Request) -> Answer:
    names = MASTERSHIP_DOMAINS if request.dialect == 1 else tuple(_EDIT_DOMAINS)
    return Answer(
        listed=[Item("msh-resource-li", name, {}, f"mastership/{name}") for name in names]
    )


def mastership_holder(cabinet: Cabinet, request: Request) -> Answer:
    domain = _mastership_domains(request)[0]
    who = cabinet.mastership.holders.get(domain)
    mine = who == request.session.key
    remote = who is not None and "::http.session::" in who
    fields = {
        "mastership": "nomaster" if who is None else "remote" if remote else "local",
        "uid": "" if who is None else who.partition(":")[0] if remote else "0",
        "application": "" if who is None else "RWS" if remote else who,
        "location": "",
        "alias": "",
        "mastershipheldbyme": "TRUE" if mine else "FALSE",
    }
    return Answer(items=[Item("msh-resource", request.captures["domain"], fields)])


def take_mastership(cabinet: Cabinet, request: Request) -> Answer:
    _check_manual(cabinet, request)
    if not cabinet.mastership.take(_mastership_domains(request), request.session.key):
        raise Rejected(rws_messages.HELD_BY_OTHER)
    return DONE


def release_mastership(cabinet: Cabinet, request: Request) -> Answer:
    domains = _mastership_domains(request)
    holders = cabinet.mastership.holders
    if any(holders.get(domain, request.session.key) != request.session.key for domain in domains):
        raise Rejected(rws_messages.HELD_BY_OTHER)
    cabinet.mastership.give_back(domains, request.session.key)
    return DONE


def check_mastership(cabinet: Cabinet, request: Request, needs: str) -> None:
    """Raises Rejected if a session may not act. needs: a domain, followed by `?` if it is enough
    that no other session holds it.

    RWS 1.0 takes a free mastership for the one request.
    """
    _check_manual(cabinet, request)
    domain = needs.rstrip("?")
    who = cabinet.mastership.holders.get(domain)
    if who == request.session.key:
        return
    if who is not None:
        raise Rejected(rws_messages.HELD_BY_OTHER)
    if request.dialect == 2 and not needs.endswith("?"):
        raise Rejected(rws_messages.NO_MASTERSHIP)


def _check_manual(cabinet: Cabinet, request: Request) -> None:
    """In manual mode only who was let in at the pendant may act."""
    if cabinet.panel.mode != "AUTO" and request.session.privilege != "modify":
        raise Rejected(
            rws_messages.NOT_PERMITTED, "in manual mode, without the privilege to modify"
        )


# -------------------------------------------------------------------------------- users


def privilege_status(cabinet: Cabinet, request: Request) -> Answer:
    held = request.session.privilege
    fields = {
        "userid": str(request.session.number),
        "alias": "",
        "location": "",
        "application": "RWS",
        "privilege": held,
        "rmmpheldbyme": "true" if held == "modify" else "false",
    }
    return Answer(items=[Item("user-rmmp", "rmmp", fields)])


def request_privilege(cabinet: Cabinet, request: Request) -> Answer:
    """It is granted at the pendant, which is `VirtualIrc5.grant`, or at once."""
    if request.given("privilege") not in ("modify", "exclusive"):
        raise Rejected(rws_messages.BAD_ARGUMENT, "privilege")
    request.session.privilege = "modify" if cabinet.grants else "pending"
    return Answer(202, headers={"Location": "/users/rmmp/poll"})


def poll_privilege_request(cabinet: Cabinet, request: Request) -> Answer:
    said = {"modify": "GRANTED", "pending": "PENDING", "denied": "DENIED"}
    status = said.get(request.session.privilege, "NO SUCH REQUEST")
    return Answer(items=[Item("user-rmmp-poll", "rmmp-poll", {"code": "0", "status": status})])


def cancel_privilege(cabinet: Cabinet, request: Request) -> Answer:
    request.session.privilege = "none"
    return DONE


def register_user(cabinet: Cabinet, request: Request) -> Answer:
    return Answer(201)


def login_info(cabinet: Cabinet, request: Request) -> Answer:
    fields = {"uas-id": str(request.session.number), "user-name": request.session.user}
    return Answer(items=[Item("user-login-info", "login-info", fields)])
