"""Protocol of Robot Web Services: the requests of both dialects, their answers, and error numbers.

`DIALECTS` holds method, path and form of each operation. Sources: ABB's reference of Robot Web
Services 1.0 (RobotWare 6) and, for both dialects, `src/paths` of ichbinmeraj/abb-rws-client, whose
rows were tried on RobotWare 6.16 and 7.21.
Answers become rows, whether XHTML (`<li class="pnl-opmode" title="opmode"><span class="opmode">AUTO
</span></li>`) or JSON (objects with `_type` and `_title`, under `_embedded._state`,
`_embedded.resources` or `state`). Both dialects share the error numbers; their meanings are from
`tests/fixtures/errors` of that client, answers of RobotWare 6.16, 7.21 and 8.1.
"""

from __future__ import annotations

import html
import json
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import field
from typing import Final, Literal
from xml.etree import ElementTree

from assistant.base.data_classes import dataclass

Domain = Literal["", "rapid", "cfg"]
"""Domains of mastership; RWS 2.0 has one for both."""
_FORM_TYPE: Final = "application/x-www-form-urlencoded"


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
_HAL: Final = "application/hal+json;v=2.0"
ANYTHING: Final = "*/*"
_NEWEST_FIRST: Final = "application/hal+json;v=2.1"
"""The only form in which RWS 2.0 lists the newest events first."""

_FILES: Final = "/fileservice/{path}"
CFG: Final = "/rw/cfg/{domain}/{type}/instances"
_SIGNALS: Final = "/rw/iosystem/signals"
_SYMBOL: Final = "RAPID/{task}/{module}/{name}"
TASK: Final = "/rw/rapid/tasks/{task}"
_UNIT: Final = "/rw/motionsystem/mechunits/{unit}"
_BLOCK: Final = {"view": "block", "vartyp": "any", "symtyp": "any", "recursive": "TRUE"}
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
    "unit": get(_UNIT),
    "joints": get(f"{_UNIT}/jointtarget"),
    "pose": get(f"{_UNIT}/robtarget"),
    "read file": Operation("GET", _FILES, accept=ANYTHING),
    "list folder": Operation("GET", _FILES, accept=XHTML),
    "write file": Operation("PUT", _FILES),
    "delete file": Operation("DELETE", _FILES),
    "signals": get(_SIGNALS),
    "signal": get(f"{_SIGNALS}/{{path}}"),
    "events": get("/rw/elog/{path}", lang="en"),
    "instances": get(CFG),
    "progress": get("/progress/{path}"),
    "privilege": get("/users/rmmp"),
    "ask privilege": post("/users/rmmp"),
    "poll privilege": get("/users/rmmp/poll"),
    "subscribe": post("/subscription"),
    "unsubscribe": Operation("DELETE", "/subscription/{path}"),
}

_RWS_1: Final[Mapping[str, Operation]] = {
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
    "value": get(f"/rw/rapid/symbol/data/{_SYMBOL}"),
    "properties": get(f"/rw/rapid/symbol/properties/{_SYMBOL}"),
    "set value": post(f"/rw/rapid/symbol/data/{_SYMBOL}", "set", domain="rapid"),
    "check value": post("/rw/rapid/symbol/data", "validate"),
    "find symbol": Operation(
        "POST",
        "/rw/rapid/symbols",
        "search-symbols",
        form={**_BLOCK, "skipshared": "FALSE", "onlyused": "FALSE", "stack": "0", "posl": "0"}
        | {"posc": "0"},
    ),
    "find signal": post(_SIGNALS, "signal-search"),
    "set signal": post(f"{_SIGNALS}/{{path}}", "set"),
    "set instance": post(f"{CFG}/{{instance}}", "set", domain="cfg"),
    "check settings": post("/rw/cfg", "validate"),
    "load settings": post("/rw/cfg", "load", domain="cfg"),
    "make folder": Operation("POST", _FILES, form={"fs-action": "create"}),
    "rename file": Operation("POST", _FILES, form={"fs-action": "rename"}),
    "back up": post("/ctrl/backup", "backup"),
    "backup state": get("/ctrl/backup", action="backupstate"),
    "take": post("/rw/mastership/{domain}", "request"),
    "give back": post("/rw/mastership/{domain}", "release"),
}

_RWS_2: Final[Mapping[str, Operation]] = {
    **_SHARED_OPERATIONS,
    "motors": get("/rw/panel/ctrl-state"),
    "set motors": post("/rw/panel/ctrl-state"),
    "set override": post("/rw/panel/speedratio", "setspeedratio", domain="rapid"),
    "modules": get(f"{TASK}/modules"),
    "text": get(f"{TASK}/modules/{{module}}/text"),
    "load module": post(f"{TASK}/loadmod", domain="rapid", accept=_HAL),
    "unload module": post(f"{TASK}/unloadmod", domain="rapid"),
    "load program": post(f"{TASK}/program/load", domain="rapid"),
    "to main": post("/rw/rapid/execution/resetpp", domain="rapid"),
    "start": Operation("POST", "/rw/rapid/execution/start", form=START),
    "stop": Operation(
        "POST", "/rw/rapid/execution/stop", form={"stopmode": "stop", "usetsp": "normal"}
    ),
    "value": get(f"/rw/rapid/symbol/{_SYMBOL}/data"),
    "properties": get(f"/rw/rapid/symbol/{_SYMBOL}/properties"),
    "set value": post(f"/rw/rapid/symbol/{_SYMBOL}/data", domain="rapid"),
    "check value": post("/rw/rapid/symbol/RAPID/{task}/data", "validate"),
    "find symbol": Operation("POST", "/rw/rapid/symbols/search", form=_BLOCK),
    "find signal": post(f"{_SIGNALS}/signal-search"),
    "set signal": post(f"{_SIGNALS}/{{path}}/set-value"),
    "set instance": post(f"{CFG}/{{instance}}", domain="cfg"),
    "load settings": post("/rw/cfg/load", domain="cfg"),
    "newest events": Operation(
        "GET", "/rw/elog/{path}", query={"lang": "en", "order": "lifo"}, accept=_NEWEST_FIRST
    ),
    "make folder": post(f"{_FILES}/create"),
    "rename file": post(f"{_FILES}/rename"),
    "back up": post("/ctrl/backup/create"),
    "backup state": get("/ctrl/backup/state"),
    "take": post("/rw/mastership/{domain}/request"),
    "give back": post("/rw/mastership/{domain}/release"),
    "register": post("/rw/controlstation/register/remote"),
    "take access": post("/rw/controlstation/writeaccess/request"),
    "give access back": post("/rw/controlstation/writeaccess/release"),
}


@dataclass(frozen=True, slots=True)
class _Dialect:
    """unit: prefix of a volume. accept, accept_written: content types for reading and for the rest.

    form, upload: content types. subprotocol: of the WebSocket. domains: of mastership, by purpose.
    quoted_text: whether a module's text arrives percent-encoded. events: resource by its name in a
    subscription; `{}` is a name.
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
    "rws": _Dialect(
        name="RWS 1.0",
        secure=False,
        unit="$",
        accept="application/xhtml+xml",
        accept_written="application/xhtml+xml",
        form=_FORM_TYPE,
        upload="application/octet-stream",
        subprotocol="robapi2_subscription",
        domains={"rapid": "rapid", "cfg": "cfg"},
        quoted_text=True,
        operations=_RWS_1,
        events={
            **_EVENT_RESOURCES,
            "motors": "/rw/panel/ctrlstate;ctrlstate",
            "variable": "/rw/rapid/symbol/data/RAPID/{};value",
        },
    ),
    "rwss": _Dialect(
        name="RWS 2.0",
        secure=True,
        unit="",
        accept=_HAL,
        accept_written=XHTML,
        form=f"{_FORM_TYPE};v=2.0",
        upload="text/plain;v=2.0",
        subprotocol="rws_subscription",
        domains={"rapid": "edit", "cfg": "edit"},
        quoted_text=False,
        operations=_RWS_2,
        events={
            **_EVENT_RESOURCES,
            "motors": "/rw/panel/ctrl-state;ctrlstate",
            "variable": "/rw/rapid/symbol/RAPID/{}/data;value",
        },
    ),
}
"""Scheme of an address → the dialect that is spoken there."""


_DEEPEST_ANSWER: Final = 50
"""Levels of an answer after which it counts as garbage."""
_DOCTYPE: Final = re.compile(r"<!DOCTYPE [^\[\]<>]*>")
"""A document type without internal declarations."""
_SOURCE_PLACE: Final = re.compile(r"(?:[A-Za-z]:\\|\w)[^\s\[\]]*\.cpp\[\d+\]:?")
"""Location of an error in RobotWare's source, as its messages begin."""


@dataclass(frozen=True, slots=True)
class Row:
    """A resource. kind: its class. href: its address. values: its reported values, by name."""

    kind: str
    title: str = ""
    href: str = ""
    values: Mapping[str, str] = field(default_factory=dict)

    def get(self, *names: str) -> str:
        """The value of the first of these names that there is; "" for none."""
        return next((self.values[name] for name in names if name in self.values), "")


@dataclass(frozen=True, slots=True)
class Answer:
    """rows: in the order of the document. next: address of the next page.

    number, text: of an error. location: the header of that name. data: the raw bytes. framed:
    whether the controller marked their end.
    """

    status: int
    rows: tuple[Row, ...] = ()
    next: str = ""
    number: int | None = None
    text: str = ""
    location: str = ""
    data: bytes = b""
    framed: bool = True

    def of(self, *kinds: str) -> tuple[Row, ...]:
        """The rows of these classes, with or without the `-li` of a list."""
        # Rows of a list have `-li` after their class, single ones have not.
        wanted = {kind.removesuffix("-li") for kind in kinds}
        return tuple(row for row in self.rows if row.kind.removesuffix("-li") in wanted)


def parse_answer(data: bytes) -> tuple[tuple[Row, ...], str, int | None, str]:
    """Rows, next page, number and text of the status; raises ValueError for another form."""
    text = data.decode("utf-8").strip()
    if not text:
        return (), "", None, ""
    return _of_json(text) if text.startswith("{") else _of_xhtml(text)


def _of_xhtml(text: str) -> tuple[tuple[Row, ...], str, int | None, str]:
    # A plain document type is harmless; any other declaration could expand entities.
    text = _DOCTYPE.sub("", text, count=1)
    if "<!" in text.replace("<!--", ""):  # no entity of a stranger is ever expanded
        raise ValueError("it declares entities")
    try:
        root = ElementTree.fromstring(text.encode())  # noqa: S314 - without document type
    except ElementTree.ParseError as error:
        raise ValueError(str(error)) from None
    if _local(root) != "html":
        raise ValueError("it is no XHTML")
    rows = tuple(_row(item) for item in root.iter() if _local(item) == "li")
    links = {a.get("rel", ""): a.get("href", "") for a in root.iter() if _local(a) == "a"}
    status = next(
        (d for d in root.iter() if _local(d) == "div" and d.get("class") == "status"), None
    )
    said = dict(_spans(status)) if status is not None else {}
    return rows, links.get("next", ""), _number(said.get("code", "")), said.get("msg", "")


def _row(item: ElementTree.Element) -> Row:
    hrefs = [a.get("href", "") for a in item if _local(a) == "a" and a.get("rel") == "self"]
    return Row(
        item.get("class", ""), item.get("title", ""), hrefs[0] if hrefs else "", dict(_spans(item))
    )


def _spans(item: ElementTree.Element, depth: int = 0) -> Iterator[tuple[str, str]]:
    """Values below an element, but those of list items inside it."""
    if depth > _DEEPEST_ANSWER:
        raise ValueError("it is nested too deep")
    for below in item:
        name = _local(below)
        if name == "span":
            yield below.get("class", ""), "".join(below.itertext()).strip()
        # Items inside have their own row, and the text of a link is no value.
        elif name not in ("li", "a"):
            yield from _spans(below, depth + 1)


def _local(element: ElementTree.Element) -> str:
    return element.tag.rpartition("}")[2]


def _of_json(text: str) -> tuple[tuple[Row, ...], str, int | None, str]:
    try:
        root = json.loads(text)
    except RecursionError:
        raise ValueError("it is nested too deep") from None
    if not isinstance(root, dict):
        raise ValueError("it is no object")  # noqa: TRY004
    embedded = root.get("_embedded")
    status = root.get("status") or (embedded.get("status") if isinstance(embedded, dict) else None)
    said = status if isinstance(status, dict) else {}
    following = _href(root, "next")
    return (
        tuple(_objects(root, 0)),
        html.unescape(following),  # `&amp;` even in JSON
        _number(str(said.get("code", ""))),
        str(said.get("msg", "")),
    )


def _objects(node: object, depth: int) -> Iterator[Row]:
    if depth > _DEEPEST_ANSWER:
        raise ValueError("it is nested too deep")
    if isinstance(node, list):
        for item in node:
            yield from _objects(item, depth + 1)
    elif isinstance(node, dict):
        if "_type" in node:
            values = {
                str(name): "" if value is None else str(value)
                for name, value in node.items()
                if not str(name).startswith("_") and not isinstance(value, (list, dict))
            }
            title = str(node.get("_title", ""))
            yield Row(str(node["_type"]), title, _href(node, "self"), values)
        # Links are addresses of other resources, not resources.
        for name, value in node.items():
            if name != "_links":
                yield from _objects(value, depth + 1)


def _href(node: Mapping[str, object], rel: str) -> str:
    links = node.get("_links")
    link = links.get(rel) if isinstance(links, dict) else None
    return str(link.get("href", "")) if isinstance(link, dict) else ""


def _number(text: str) -> int | None:
    return int(text) if re.fullmatch(r"-?\d{1,12}", text.strip()) else None


def plain_message(message: str) -> str:
    """A controller's message without the places in its own source, and on one line."""
    said = re.sub(r"\bERROR:\s*", "", _SOURCE_PLACE.sub("", message))
    said = re.sub(r"[\x00-\x1f\x7f]+|\s+", " ", said)
    return re.sub(r"\s*\bi?code:\s*-?\d+", "", said).strip(" ;:")


def numbers(row: Row, names: Sequence[str]) -> tuple[float, ...]:
    """Return values as numbers; raises ValueError naming the first that is not a number."""
    found = []
    for name in names:
        try:
            found.append(float(row.values[name]))
        except (KeyError, ValueError):
            raise ValueError(f"no number `{name}` in {row.kind or 'the answer'}") from None
    return tuple(found)


_HELD: Final = -1073445862
NO_MASTERSHIP: Final = -1073445859
_REJECTED: Final = -1073445881
_NO_ACCESS: Final = -1073445867
NOT_NOW: Final = -1073442809
_NO_MODULE: Final = -1073442813
_NO_SYMBOL: Final = -1073442816
_NO_RESOURCE: Final = -1073414146
_NO_SIGNAL: Final = -1073445866
_NO_PATH: Final = -1073438713
_NO_VOLUME: Final = -1073438716
_NO_FILE: Final = -1073438708
_ARGUMENT: Final = -1073445879
_NO_STATION: Final = -1073435873
_STATION_TAKEN: Final = -1073435870

_GRANT_CURE: Final = (
    "give the user the grant in the controller's User Authorization System; in manual mode "
    "request remote access and confirm it on the pendant"
)
_RELEASE_CURE: Final = (
    "release the write access where it is held (FlexPendant, RobotStudio or another program), "
    "or wait until what is under way has ended"
)

ERROR_CURES: Final = {
    _HELD: _RELEASE_CURE,
    NO_MASTERSHIP: _RELEASE_CURE,
    _STATION_TAKEN: _RELEASE_CURE,
    _NO_STATION: _RELEASE_CURE,
    _REJECTED: _GRANT_CURE,
    _NO_ACCESS: _GRANT_CURE,
    NOT_NOW: "stop the programs, or load one and switch the motors on, then run it again",
    _NO_MODULE: "check the names of task and module",
    _NO_SYMBOL: "check the names of task, module and data",
    _NO_RESOURCE: "check the names; the option may be missing on this controller",
    _NO_SIGNAL: "check the name of the signal",
    _NO_PATH: "check the name of the file",
    _NO_VOLUME: "check the folder of the address",
    _NO_FILE: "check the name of the file and that its text has no errors",
    _ARGUMENT: "check the value and what the controller accepts there",
}
OTHER_CURE: Final = "put right what it says, then run it again"

ERROR_TEXTS: Final = {
    _HELD: "the resource is held by someone else",
    NO_MASTERSHIP: "the user does not have the mastership",
    _REJECTED: "rejected",
    NOT_NOW: "not allowed in the state that the programs are in",
    _NO_FILE: "the file cannot be loaded",
    _NO_SYMBOL: "not found",
}
"""Texts for answers without a text."""

ABSENT: Final = frozenset({_NO_MODULE, _NO_SYMBOL, _NO_RESOURCE, _NO_SIGNAL, _NO_PATH})
"""Errors which say that there is no such thing."""
