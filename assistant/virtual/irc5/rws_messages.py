"""Messages of Robot Web Services: requests with their sessions and routes, answers, and refusals.

Digest for RWS 1.0, Basic for RWS 2.0. The challenge is the one that controllers send, field by
field (captured in the public sources loupeteam/A3br and others). A session is known by its cookie
`-http-session-`; there are at most 70 at once, and one that is not used for five minutes ends
(abb-rws-client, docs/ARCHITECTURE.md). An answer holds items. In XHTML an item is an `li` whose
class is its type, and its fields are `span`s; in JSON it is an object with `_type` and `_title`.
RWS 1.0 puts all items into `_embedded._state`; RWS 2.0 puts what a resource is into `state` and
what it lists into `_embedded.resources`. Shapes and reasons as captured from RobotWare 6.16 and
7.21 in the tests of the public client ichbinmeraj/abb-rws-client (tests/fixtures/errors,
src/ControllerError.ts). The first status of a reason is that of RWS 1.0; a number that no public
source states is marked.
"""

from __future__ import annotations

import base64
import binascii
import hashlib
import hmac
import json
import re
import secrets
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import field
from html import escape as escaped
from http.cookies import CookieError, SimpleCookie
from typing import Final, Generic, TypeVar
from urllib.parse import unquote

from assistant.base.data_classes import dataclass

_REALM: Final = "validusers@robapi.abb"
_OPAQUE: Final = "799d5"
_MOST_SESSIONS: Final = 70
_SESSION_TIMEOUT: Final = 300.0
"""Seconds that a session lasts without a request."""
_MOST_NONCES: Final = 1000
_COOKIE: Final = "-http-session-"
_DIGEST_FIELD: Final = re.compile(r'(\w+)\s*=\s*(?:"((?:[^"\\]|\\.)*)"|([^\s,]+))')


@dataclass(slots=True, eq=False)
class Session:
    """number: counted from 1. key: of its cookie. privilege: in manual mode, `none`, `pending` or
    `modify`. used: when it was last, of the monotonic clock.
    """

    number: int
    key: str
    user: str
    used: float
    privilege: str = "none"

    @property
    def cookies(self) -> tuple[str, str]:
        return (
            f"{_COOKIE}={self.key}; path=/; httponly",
            f"ABBCX={self.number}; path=/",
        )


@dataclass(eq=False)
class Sessions:
    """Sessions of a server's clients. ended: are called with each session that has ended. refuses:
    True to refuse every login.
    """

    user: str
    password: str = field(repr=False)
    ended: list[Callable[[Session], None]] = field(default_factory=list)
    refuses: bool = False
    most: int = _MOST_SESSIONS

    def __post_init__(self) -> None:
        self._open: dict[str, Session] = {}
        self._nonces: dict[str, None] = {}
        self._count = 0
        self._lock = threading.RLock()

    def __len__(self) -> int:
        return len(self._open)

    def of(self, cookies: str) -> Session | None:
        """The session that a request belongs to, None for a new one."""
        try:
            found = SimpleCookie(cookies).get(_COOKIE)
        except CookieError:
            return None
        with self._lock:
            session = None if found is None else self._open.get(found.value)
            if session is None:
                return None
            if time.monotonic() - session.used > _SESSION_TIMEOUT:
                self.end(session)
                return None
            session.used = time.monotonic()
            return session

    def begin(self) -> Session | None:
        """A new session, None if there are too many."""
        with self._lock:
            now = time.monotonic()
            for old in [one for one in self._open.values() if now - one.used > _SESSION_TIMEOUT]:
                self.end(old)
            if len(self._open) >= self.most:
                return None
            self._count += 1
            # `mastership_holder` reads the number of the session from the beginning of the key.
            key = f"{self._count}::http.session::{secrets.token_hex(16)}"
            session = self._open[key] = Session(self._count, key, self.user, now)
            return session

    def end(self, session: Session) -> None:
        with self._lock:
            if self._open.pop(session.key, None) is None:
                return
        for told in tuple(self.ended):
            told(session)

    def answer_requests(self, answer: str) -> None:
        """The pendant answers all who ask for a privilege."""
        with self._lock:
            for one in self._open.values():
                if one.privilege == "pending":
                    one.privilege = answer

    # ------------------------------------------------------------------------------ login

    def challenge(self, dialect: int, stale: bool = False) -> str:
        # RWS 2.0 always runs over TLS, where Basic is no leak.
        if dialect == 2:
            return f'Basic realm="{_REALM}"'
        nonce = base64.b64encode(secrets.token_bytes(30)).decode()
        with self._lock:
            self._nonces[nonce] = None
            while len(self._nonces) > _MOST_NONCES:
                del self._nonces[next(iter(self._nonces))]
        return (
            f'Digest realm="{_REALM}", domain="/", qop="auth", nonce="{nonce}", '
            f'opaque="{_OPAQUE}", algorithm="MD5", stale="{"TRUE" if stale else "FALSE"}"'
        )

    def admits(self, dialect: int, header: str, method: str, target: str) -> bool:
        """True if an `Authorization` header is right. target: as the request line states it."""
        scheme, _, rest = header.partition(" ")
        if self.refuses:
            return False
        if dialect == 2:
            return scheme.lower() == "basic" and self._is_basic(rest)
        return scheme.lower() == "digest" and self._is_digest(rest, method, target)

    def _is_basic(self, rest: str) -> bool:
        try:
            given = base64.b64decode(rest.strip(), validate=True)
        except (binascii.Error, ValueError):
            return False
        return hmac.compare_digest(given, f"{self.user}:{self.password}".encode())

    def _is_digest(self, rest: str, method: str, target: str) -> bool:
        """True if a digest matches RFC 2617, with or without `qop`."""
        given = {name.lower(): quoted or bare for name, quoted, bare in _DIGEST_FIELD.findall(rest)}
        nonce = given.get("nonce", "")
        if nonce not in self._nonces or given.get("username") != self.user:
            return False
        if given.get("realm") != _REALM or given.get("uri") != target:
            return False
        one = _md5(f"{self.user}:{_REALM}:{self.password}")
        two = _md5(f"{method}:{given['uri']}")
        middle = nonce
        # RFC 2617 2.2: without qop the middle part is the nonce alone.
        if "qop" in given:
            middle = ":".join((nonce, given.get("nc", ""), given.get("cnonce", ""), given["qop"]))
        wanted = _md5(f"{one}:{middle}:{two}")
        return hmac.compare_digest(wanted.encode(), given.get("response", "").encode())


def _md5(text: str) -> str:
    return hashlib.md5(text.encode(), usedforsecurity=False).hexdigest()


_SUCCESS: Final = 294912
"""The code of the status of an answer of RWS 2.0 without an error."""
HEAD: Final = '<?xml version="1.0" encoding="UTF-8"?><html xmlns="http://www.w3.org/1999/xhtml">'


@dataclass(frozen=True, slots=True)
class Item:
    """An item of an answer. type: its class. href: its reference, empty if it states none. inside:
    items that it holds.

    group: the name of the list of those in JSON. An item without a type is a `value` of some
    `type`, for which XHTML has a separate span.
    """

    type: str
    title: str
    fields: Mapping[str, str] = field(default_factory=dict)
    href: str = ""
    inside: tuple[Item, ...] = ()
    group: str = "items"


@dataclass(frozen=True, slots=True)
class Answer:
    """Answer to a request. items: the resource. listed: its contents. data: bytes of a file,
    instead of those.

    next: reference to the next page of a list. headers: in addition to those of every answer.
    links: references and their relations, instead of the reference to itself. only_xhtml: True to
    ignore the requested format.
    """

    status: int = 200
    items: Sequence[Item] = ()
    listed: Sequence[Item] = ()
    data: bytes | None = None
    next: str = ""
    headers: Mapping[str, str] = field(default_factory=dict)
    links: Sequence[tuple[str, str]] = ()
    only_xhtml: bool = False


DONE: Final = Answer(204)


@dataclass(frozen=True, slots=True)
class Reason:
    """Why a request is refused: the controller's number and words, and the HTTP status that each
    dialect sends with it.
    """

    code: int
    text: str
    one: int
    two: int


class Rejected(Exception):
    """A request that is not carried out. detail: added to the words of its reason."""

    def __init__(self, reason: Reason, detail: str = "") -> None:
        super().__init__(f"{reason.text}{'; ' * bool(detail)}{detail}")
        self.reason = reason

    def status(self, dialect: int) -> int:
        return self.reason.one if dialect == 1 else self.reason.two


@dataclass(frozen=True, slots=True)
class Place:
    """base: address of the resource's folder, with a slash at its end. own: the last part."""

    base: str
    own: str = ""


def _html(value: str) -> str:
    """Return a text escaped as in XHTML."""
    return escaped(value).replace("&#x27;", "&#39;")


def _plain_fields(href: str) -> str:
    """A reference in JSON, where controllers escape the ampersand all the same."""
    return escaped(href, quote=False)


def _xhtml(answer: Answer, place: Place) -> str:
    rows = "".join(map(_xhtml_item, (*answer.items, *answer.listed)))
    refers = list(answer.links) or [(place.own, "self")]
    if answer.next:
        refers.append((answer.next, "next"))
    links = "".join(f'<a href="{_html(href)}" rel="{rel}"></a>' for href, rel in refers)
    body = f'<div class="state">{links}<ul>{rows}</ul></div>'
    return _xhtml_page(place, body)


def event_message(group: int, items: Sequence[Item], place: Place) -> str:
    """Return the message of an event for a WebSocket."""
    rows = "".join(map(_xhtml_item, items))
    link = f'<a href="subscription/{group}" rel="group"></a>'
    return _xhtml_page(place, f'<div class="state">{link}<ul>{rows}</ul></div>', "Event")


def _xhtml_page(place: Place, body: str, title: str = "rw") -> str:
    base = _html(place.base)
    return (
        f'{HEAD}<head><title>{title}</title><base href="{base}"/></head><body>{body}</body></html>'
    )


def _xhtml_item(item: Item) -> str:
    link = f'<a href="{_html(item.href)}" rel="self"></a>' if item.href else ""
    spans = "".join(
        f'<span class="{_html(name)}">{_html(value)}</span>' for name, value in item.fields.items()
    )
    spans += "".join(_typed_item(one) for one in item.inside if not one.type)
    rows = "".join(_xhtml_item(one) for one in item.inside if one.type)
    inside = f"<ul>{rows}</ul>" if rows else ""
    return f'<li class="{_html(item.type)}" title="{_html(item.title)}">{link}{spans}{inside}</li>'


def _typed_item(item: Item) -> str:
    kind, value = _html(item.fields["type"]), _html(item.fields["value"])
    return f'<span class="{_html(item.title)}" type="{kind}">{value}</span>'


def _json_object(item: Item) -> dict[str, object]:
    links = {"_links": {"self": {"href": _plain_fields(item.href)}}} if item.href else {}
    inside = {item.group: [_json_object(one) for one in item.inside]} if item.inside else {}
    if not item.type:
        return dict(item.fields)
    return {**links, "_type": item.type, "_title": item.title, **item.fields, **inside}


def _json_of_one(answer: Answer, place: Place) -> str:
    onward = {"next": {"href": _plain_fields(answer.next)}} if answer.next else {}
    rows = [_json_object(item) for item in (*answer.items, *answer.listed)]
    links = {"base": {"href": place.base}, **onward}
    return json.dumps({"_links": links, "_embedded": {"_state": rows}})


def _hal(answer: Answer, place: Place) -> str:
    onward = {"next": {"href": _plain_fields(answer.next)}} if answer.next else {}
    links = {"base": {"href": place.base}, "self": {"href": place.own}, **onward}
    told: dict[str, object] = {"_links": links}
    # RWS 2.0 states a status only where no list follows.
    if not answer.listed:
        told["status"] = {"code": _SUCCESS}
    if answer.items or not answer.listed:
        told["state"] = [_json_object(item) for item in answer.items]
    if answer.listed:
        told["_embedded"] = {"resources": [_json_object(item) for item in answer.listed]}
    return json.dumps(told)


def _refused_xhtml(code: int, message: str, place: Place) -> str:
    spans = f'<span class="code">{code}</span><span class="msg">{_html(message)}</span>'
    return _xhtml_page(place, f'<div class="status">{spans}</div>')


def _refused_json_of_one(code: int, message: str, place: Place) -> str:
    status = {"code": code, "msg": message}
    links = {"base": {"href": place.base}}
    return json.dumps({"_links": links, "_embedded": {"status": status, "_state": []}})


def _refused_hal(code: int, message: str, place: Place) -> str:
    status = {"code": code, "msg": message}
    return json.dumps({"_links": {"base": {"href": place.base}}, "status": status})


@dataclass(frozen=True, slots=True)
class Form:
    """One way to write answers down. type: of its content."""

    type: str
    written: Callable[[Answer, Place], str]
    refused: Callable[[int, str, Place], str]


XHTML_1: Final = Form("application/xhtml+xml", _xhtml, _refused_xhtml)
JSON_1: Final = Form("application/json", _json_of_one, _refused_json_of_one)
XHTML_2: Final = Form("application/xhtml+xml;v=2.0", _xhtml, _refused_xhtml)
HAL_2: Final = Form("application/hal+json;v=2.0", _hal, _refused_hal)


HELD_BY_OTHER: Final = Reason(-1073445862, "Requested resource is held by someone else", 403, 403)
NO_MASTERSHIP: Final = Reason(
    -1073445859, "The user does not have required mastership for the operation.", 403, 403
)
NOT_PERMITTED: Final = Reason(-1073445881, "Rejected", 403, 403)
NO_RESOURCE: Final = Reason(-1073414146, "Resource not found", 404, 404)
NO_FILE: Final = Reason(-1073414146, "Resource does not exist", 404, 404)
NO_PATH: Final = Reason(-1073438713, "Path does not exist", 404, 404)
NO_VOLUME: Final = Reason(-1073438716, "Virtual root does not exist", 400, 400)
NO_MODULE: Final = Reason(-1073414146, "Resource not found", 404, 404)
NO_MODULE_2: Final = Reason(-1073442813, "module name/parameter is invalid or missing", 400, 400)
NO_MODULE_TO_UNLOAD: Final = Reason(-1073442816, "Unknown module name", 400, 400)
NO_MODULE_FILE: Final = Reason(-1073438708, "", 400, 400)
"""RWS 1.0 sends no words; that 2.0 answers the same is assumed."""
NO_SYMBOL: Final = Reason(-1073414146, "Symbol not found", 400, 404)
NO_SYMBOL_2: Final = Reason(-1073442816, "Symbol not found", 404, 404)
NO_SIGNAL: Final = Reason(-1073445866, "Invalid IO signal name passed in the uri", 404, 404)
NO_TASK: Final = Reason(-1073445879, "Task does not exist", 404, 404)
BAD_ARGUMENT: Final = Reason(-1073445879, "Invalid action parameter value", 400, 400)
WRONG_STATE: Final = Reason(-1073442809, "Operation not allowed in the current state", 400, 403)
"""400 is what RWS 1.0 sends for a start that is not allowed; 403 is assumed of 2.0."""
UNSPECIFIED: Final = Reason(-1073445885, "Unspecified Error", 400, 400)
"""Reason of failures without a number in any public source, as a load of a text with errors."""
NO_EVENTS: Final = Reason(-1073414146, "Resource does not exist on the controller", 400, 400)
_NO_METHOD: Final = Reason(-1073445879, "Method not allowed", 405, 405)
UNACCEPTABLE: Final = Reason(-1073445879, "Not acceptable", 406, 406)
NOT_THIS_TYPE: Final = Reason(-1073445879, "Unsupported media type", 415, 415)
INTERNAL_ERROR: Final = Reason(-1073445885, "Unspecified Error", 500, 500)
"""The virtual controller itself has gone wrong."""
TOO_MANY_REQUESTS: Final = Reason(-1073445885, "Too many sessions", 503, 503)


@dataclass(frozen=True, slots=True)
class Request:
    """dialect: 1 or 2. path: as it was sent, without the query. query, form: by name.

    captures: the parts of the path that its route names. body: as it arrived.
    """

    dialect: int
    method: str
    path: str
    session: Session
    query: Mapping[str, str] = field(default_factory=dict)
    form: Mapping[str, str] = field(default_factory=dict)
    captures: Mapping[str, str] = field(default_factory=dict)
    body: bytes = b""
    accept: str = ""
    host: str = ""

    def either(self, one: str, two: str) -> str:
        """Return the text for the dialect of the request."""
        return one if self.dialect == 1 else two

    def given(self, name: str, *others: str) -> str:
        """A field of the form; raises Rejected if it is missing."""
        for one in (name, *others):
            if one in self.form:
                return self.form[one]
        raise Rejected(BAD_ARGUMENT, f"`{name}` is missing")

    def number(self, name: str, least: int, most: int, usual: int) -> int:
        """A whole number of the query."""
        text = self.query.get(name)
        if text is None:
            return usual
        if not text.isdecimal() or len(text) > 9:
            raise Rejected(BAD_ARGUMENT, f"`{name}` is no number")
        return min(max(int(text), least), most)


H = TypeVar("H")
_KEPT_CHARACTERS: Final = "/fileservice"
"""Beginning of paths that stay as sent: their encoding may matter."""


@dataclass(frozen=True, slots=True)
class Route(Generic[H]):
    """action: that the query has to name, empty for none. needs: see `routes.Row`."""

    method: str
    pattern: re.Pattern[str]
    action: str
    handler: H
    needs: str


def make_route(method: str, stated: str, handler: H, needs: str = "") -> Route[H]:
    """stated: a path with names in braces, and behind `?` the action."""
    path, _, action = stated.partition("?")
    pattern = ""
    for part in re.split(r"(\{\w+(?:\.\.\.)?\})", path):
        # Literal parts may hold characters that mean something in a pattern.
        if not part.startswith("{"):
            pattern += re.escape(part)
        elif part.endswith("...}"):
            pattern += f"(?P<{part[1:-4]}>.+)"
        else:
            pattern += f"(?P<{part[1:-1]}>[^/]+)"
    return Route(method, re.compile(pattern), action, handler, needs)


def find_route(
    routes: Sequence[Route[H]], request: Request
) -> tuple[Route[H], dict[str, str]] | Rejected:
    """Return the first route that matches, with the values of its names; else the reason for the
    refusal.
    """
    raw = request.path.rstrip("/") or "/"
    # `%2F` in the name of a file is no separator: file paths are decoded by their handler.
    path = raw if raw.startswith(_KEPT_CHARACTERS) else unquote(raw)
    action = request.query.get("action", request.query.get("resource", ""))
    # RWS 1.0 knows `show` as the default action of a reading.
    action = "" if action == "show" else action
    there = False
    for one in routes:
        found = one.pattern.fullmatch(path)
        if found is None or one.action != action:
            continue
        if one.method == request.method:
            return one, found.groupdict()
        # The path exists, but for another method: 405 instead of 404.
        there = True
    return Rejected(_NO_METHOD if there else NO_RESOURCE)
