"""The two dialects of Robot Web Services: what is asked by which method, path and form.

Sources: ABB's reference of Robot Web Services 1.0 (RobotWare 6) and, for both dialects,
`src/paths` of ichbinmeraj/abb-rws-client, whose rows were tried on RobotWare 6.16 and 7.21.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final, Literal

Domain = Literal["", "rapid", "cfg"]
"""What mastership is for; RWS 2.0 has one for both."""
FORM_TYPE: Final = "application/x-www-form-urlencoded"


@dataclass(frozen=True, slots=True)
class Operation:
    """A request. path: with fields in braces. action: of the query, as RWS 1.0 has them.

    query, form: what goes along every time. domain: of the mastership that it needs.
    accept: what it answers with, where that is not the dialect's own.
    """

    method: str
    path: str
    action: str = ""
    query: Mapping[str, str] = field(default_factory=dict)
    form: Mapping[str, str] = field(default_factory=dict)
    domain: Domain = ""
    accept: str = ""


def get(path: str, **query: str) -> Operation:
    return Operation("GET", path, query=query)


def post(path: str, action: str = "", *, domain: Domain = "", accept: str = "") -> Operation:
    return Operation("POST", path, action, domain=domain, accept=accept)


XHTML: Final = "application/xhtml+xml;v=2.0"
HAL: Final = "application/hal+json;v=2.0"
ANYTHING: Final = "*/*"
NEWEST_FIRST: Final = "application/hal+json;v=2.1"
"""The only form in which RWS 2.0 lists the newest events first."""

FILES: Final = "/fileservice/{path}"
CFG: Final = "/rw/cfg/{domain}/{type}/instances"
SIGNALS: Final = "/rw/iosystem/signals"
SYMBOL: Final = "RAPID/{task}/{module}/{name}"
TASK: Final = "/rw/rapid/tasks/{task}"
UNIT: Final = "/rw/motionsystem/mechunits/{unit}"
BLOCK: Final = {"view": "block", "vartyp": "any", "symtyp": "any", "recursive": "TRUE"}
START: Final = {
    "regain": "continue",
    "execmode": "continue",
    "condition": "none",
    "stopatbp": "disabled",
    "alltaskbytsp": "false",
}

_SHARED_OPERATIONS: Final = {
    "logout": get("/logout"),
    "system": get("/rw/system"),
    "identity": get("/ctrl/identity"),
    "robot type": get("/rw/system/robottype"),
    "mode": get("/rw/panel/opmode"),
    "override": get("/rw/panel/speedratio"),
    "execution": get("/rw/rapid/execution"),
    "tasks": get("/rw/rapid/tasks"),
    "pointer": get(f"{TASK}/pcp"),
    "unit": get(UNIT),
    "joints": get(f"{UNIT}/jointtarget"),
    "pose": get(f"{UNIT}/robtarget"),
    "read file": Operation("GET", FILES, accept=ANYTHING),
    "list folder": Operation("GET", FILES, accept=XHTML),
    "write file": Operation("PUT", FILES),
    "delete file": Operation("DELETE", FILES),
    "signals": get(SIGNALS),
    "signal": get(f"{SIGNALS}/{{path}}"),
    "events": get("/rw/elog/{path}", lang="en"),
    "instances": get(CFG),
    "progress": get("/progress/{path}"),
    "privilege": get("/users/rmmp"),
    "ask privilege": post("/users/rmmp"),
    "poll privilege": get("/users/rmmp/poll"),
    "subscribe": post("/subscription"),
    "unsubscribe": Operation("DELETE", "/subscription/{path}"),
}

RWS_1: Final[Mapping[str, Operation]] = {
    **_SHARED_OPERATIONS,
    "motors": get("/rw/panel/ctrlstate"),
    "set motors": post("/rw/panel/ctrlstate", "setctrlstate"),
    "set override": post("/rw/panel/speedratio", "setspeedratio"),
    "modules": get("/rw/rapid/modules"),
    "text": get("/rw/rapid/modules/{module}", resource="module-text"),
    "load module": post(TASK, "loadmod", domain="rapid"),
    "unload module": post(TASK, "unloadmod", domain="rapid"),
    "load program": post(f"{TASK}/program", "loadprog", domain="rapid"),
    "to main": post("/rw/rapid/execution", "resetpp", domain="rapid"),
    "start": Operation("POST", "/rw/rapid/execution", "start", form=START),
    "stop": Operation("POST", "/rw/rapid/execution", "stop", form={"stopmode": "stop"}),
    "value": get(f"/rw/rapid/symbol/data/{SYMBOL}"),
    "properties": get(f"/rw/rapid/symbol/properties/{SYMBOL}"),
    "set value": post(f"/rw/rapid/symbol/data/{SYMBOL}", "set", domain="rapid"),
    "check value": post("/rw/rapid/symbol/data", "validate"),
    "find symbol": Operation(
        "POST",
        "/rw/rapid/symbols",
        "search-symbols",
        form={**BLOCK, "skipshared": "FALSE", "onlyused": "FALSE", "stack": "0", "posl": "0"}
        | {"posc": "0"},
    ),
    "find signal": post(SIGNALS, "signal-search"),
    "set signal": post(f"{SIGNALS}/{{path}}", "set"),
    "set instance": post(f"{CFG}/{{instance}}", "set", domain="cfg"),
    "check settings": post("/rw/cfg", "validate"),
    "load settings": post("/rw/cfg", "load", domain="cfg"),
    "make folder": Operation("POST", FILES, form={"fs-action": "create"}),
    "rename file": Operation("POST", FILES, form={"fs-action": "rename"}),
    "back up": post("/ctrl/backup", "backup"),
    "backup state": get("/ctrl/backup", action="backupstate"),
    "take": post("/rw/mastership/{domain}", "request"),
    "give back": post("/rw/mastership/{domain}", "release"),
}

RWS_2: Final[Mapping[str, Operation]] = {
    **_SHARED_OPERATIONS,
    "motors": get("/rw/panel/ctrl-state"),
    "set motors": post("/rw/panel/ctrl-state"),
    "set override": post("/rw/panel/speedratio", "setspeedratio", domain="rapid"),
    "modules": get(f"{TASK}/modules"),
    "text": get(f"{TASK}/modules/{{module}}/text"),
    "load module": post(f"{TASK}/loadmod", domain="rapid", accept=HAL),
    "unload module": post(f"{TASK}/unloadmod", domain="rapid"),
    "load program": post(f"{TASK}/program/load", domain="rapid"),
    "to main": post("/rw/rapid/execution/resetpp", domain="rapid"),
    "start": Operation("POST", "/rw/rapid/execution/start", form=START),
    "stop": Operation(
        "POST", "/rw/rapid/execution/stop", form={"stopmode": "stop", "usetsp": "normal"}
    ),
    "value": get(f"/rw/rapid/symbol/{SYMBOL}/data"),
    "properties": get(f"/rw/rapid/symbol/{SYMBOL}/properties"),
    "set value": post(f"/rw/rapid/symbol/{SYMBOL}/data", domain="rapid"),
    "check value": post("/rw/rapid/symbol/RAPID/{task}/data", "validate"),
    "find symbol": Operation("POST", "/rw/rapid/symbols/search", form=BLOCK),
    "find signal": post(f"{SIGNALS}/signal-search"),
    "set signal": post(f"{SIGNALS}/{{path}}/set-value"),
    "set instance": post(f"{CFG}/{{instance}}", domain="cfg"),
    "load settings": post("/rw/cfg/load", domain="cfg"),
    "newest events": Operation(
        "GET", "/rw/elog/{path}", query={"lang": "en", "order": "lifo"}, accept=NEWEST_FIRST
    ),
    "make folder": post(f"{FILES}/create"),
    "rename file": post(f"{FILES}/rename"),
    "back up": post("/ctrl/backup/create"),
    "backup state": get("/ctrl/backup/state"),
    "take": post("/rw/mastership/{domain}/request"),
    "give back": post("/rw/mastership/{domain}/release"),
    "register": post("/rw/controlstation/register/remote"),
    "take access": post("/rw/controlstation/writeaccess/request"),
    "give access back": post("/rw/controlstation/writeaccess/release"),
}


@dataclass(frozen=True, slots=True)
class Dialect:
    """unit: what stands before the name of a volume. accept: of what is read, and of the rest.

    form, upload: content types. subprotocol: of the WebSocket. domains: of mastership, by what
    it is for. quoted_text: whether a module's text arrives percent-encoded. events: resource
    by what a subscription calls it; `{}` is a name.
    """

    name: str
    secure: bool
    unit: str
    accept: str
    accept_written: str
    form: str
    upload: str
    subprotocol: str
    domains: Mapping[str, str]
    quoted_text: bool
    operations: Mapping[str, Operation]
    events: Mapping[str, str]


_EVENT_RESOURCES: Final = {
    "mode": "/rw/panel/opmode;opmode",
    "override": "/rw/panel/speedratio;speedratio",
    "execution": "/rw/rapid/execution;ctrlexecstate",
    "log": "/rw/elog/0",
    "signal": "/rw/iosystem/signals/{};state",
}

DIALECTS: Final = {
    "rws": Dialect(
        name="RWS 1.0",
        secure=False,
        unit="$",
        accept="application/xhtml+xml",
        accept_written="application/xhtml+xml",
        form=FORM_TYPE,
        upload="application/octet-stream",
        subprotocol="robapi2_subscription",
        domains={"rapid": "rapid", "cfg": "cfg"},
        quoted_text=True,
        operations=RWS_1,
        events={
            **_EVENT_RESOURCES,
            "motors": "/rw/panel/ctrlstate;ctrlstate",
            "variable": "/rw/rapid/symbol/data/RAPID/{};value",
        },
    ),
    "rwss": Dialect(
        name="RWS 2.0",
        secure=True,
        unit="",
        accept=HAL,
        accept_written=XHTML,
        form=f"{FORM_TYPE};v=2.0",
        upload="text/plain;v=2.0",
        subprotocol="rws_subscription",
        domains={"rapid": "edit", "cfg": "edit"},
        quoted_text=False,
        operations=RWS_2,
        events={
            **_EVENT_RESOURCES,
            "motors": "/rw/panel/ctrl-state;ctrlstate",
            "variable": "/rw/rapid/symbol/RAPID/{}/data;value",
        },
    ),
}
"""Scheme of an address → the dialect that is spoken there."""
