"""`/rw/mastership`, `/users`, `/logout`: who may change what, and who is there."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from assistant.virtual.irc5.cabinet import MASTERSHIP_DOMAINS, Cabinet
from assistant.virtual.irc5.rws import reasons
from assistant.virtual.irc5.rws.answers import DONE, Answer, Item, Rejected
from assistant.virtual.irc5.rws.request import Request

EDIT_DOMAINS: Final[Mapping[str, tuple[str, ...]]] = {
    "edit": ("cfg", "rapid"),
    "motion": ("motion",),
}
"""Domains of RWS 2.0 by those that it makes one of."""


def _mastership_domains(request: Request) -> tuple[str, ...]:
    """Those that the path names, all without one."""
    name = request.captures.get("domain")
    if name is None:
        return MASTERSHIP_DOMAINS
    known = {one: (one,) for one in MASTERSHIP_DOMAINS} if request.dialect == 1 else EDIT_DOMAINS
    if name not in known:
        raise Rejected(reasons.NO_RESOURCE)
    return known[name]


def list_mastership(cabinet: Cabinet, request: Request) -> Answer:
    names = MASTERSHIP_DOMAINS if request.dialect == 1 else tuple(EDIT_DOMAINS)
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
        raise Rejected(reasons.HELD_BY_OTHER)
    return DONE


def release_mastership(cabinet: Cabinet, request: Request) -> Answer:
    domains = _mastership_domains(request)
    holders = cabinet.mastership.holders
    if any(holders.get(domain, request.session.key) != request.session.key for domain in domains):
        raise Rejected(reasons.HELD_BY_OTHER)
    cabinet.mastership.give_back(domains, request.session.key)
    return DONE


def check_mastership(cabinet: Cabinet, request: Request, needs: str) -> None:
    """Raises Rejected if a session may not act. needs: a domain, with `?` behind it if it is enough
    that nobody else holds it.

    RWS 1.0 takes a mastership that nobody holds for the one request.
    """
    _check_manual(cabinet, request)
    domain = needs.rstrip("?")
    who = cabinet.mastership.holders.get(domain)
    if who == request.session.key:
        return
    if who is not None:
        raise Rejected(reasons.HELD_BY_OTHER)
    if request.dialect == 2 and not needs.endswith("?"):
        raise Rejected(reasons.NO_MASTERSHIP)


def _check_manual(cabinet: Cabinet, request: Request) -> None:
    """In manual mode only who was let in at the pendant may act."""
    if cabinet.panel.mode != "AUTO" and request.session.privilege != "modify":
        raise Rejected(reasons.NOT_PERMITTED, "in manual mode, without the privilege to modify")


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
        raise Rejected(reasons.BAD_ARGUMENT, "privilege")
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
