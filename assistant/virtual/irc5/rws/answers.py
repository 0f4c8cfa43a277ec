"""What Robot Web Services answer, and how each dialect writes it down.

An answer holds items. In XHTML an item is an `li` whose class is its type, and its fields are
`span`s; in JSON it is an object with `_type` and `_title`. RWS 1.0 puts all items into
`_embedded._state`; RWS 2.0 puts what a resource is into `state` and what it lists into
`_embedded.resources` (shapes as captured from RobotWare 6.16 and 7.21 in the tests of the public
client ichbinmeraj/abb-rws-client).
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from html import escape as escaped
from typing import Final

SUCCESS: Final = 294912
"""The code of the status of an answer of RWS 2.0 without an error."""
HEAD: Final = '<?xml version="1.0" encoding="UTF-8"?><html xmlns="http://www.w3.org/1999/xhtml">'


@dataclass(frozen=True, slots=True)
class Item:
    """type: its class. href: of itself, empty if it states none. inside: items that it holds.

    group: the name of the list of those in JSON. An item without a type is a `value` of some
    `type`, which XHTML has as a span of its own.
    """

    type: str
    title: str
    fields: Mapping[str, str] = field(default_factory=dict)
    href: str = ""
    inside: tuple[Item, ...] = ()
    group: str = "items"


@dataclass(frozen=True, slots=True)
class Answer:
    """items: what the resource is. listed: what it holds. data: of a file, instead of those.

    next: reference to the next page of a list. headers: beside those that every answer has. links:
    what it refers to, and as what, instead of itself. only_xhtml: whatever form was asked for.
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
    """As XHTML writes it."""
    return escaped(value).replace("&#x27;", "&#39;")


def _plain_fields(href: str) -> str:
    """A reference in JSON, where controllers escape the ampersand all the same."""
    return escaped(href, quote=False)


def xhtml(answer: Answer, place: Place) -> str:
    rows = "".join(map(_xhtml_item, (*answer.items, *answer.listed)))
    refers = list(answer.links) or [(place.own, "self")]
    if answer.next:
        refers.append((answer.next, "next"))
    links = "".join(f'<a href="{_html(href)}" rel="{rel}"></a>' for href, rel in refers)
    body = f'<div class="state">{links}<ul>{rows}</ul></div>'
    return _xhtml_page(place, body)


def event_message(group: int, items: Sequence[Item], place: Place) -> str:
    """What a WebSocket is told."""
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


def json_of_one(answer: Answer, place: Place) -> str:
    onward = {"next": {"href": _plain_fields(answer.next)}} if answer.next else {}
    rows = [_json_object(item) for item in (*answer.items, *answer.listed)]
    links = {"base": {"href": place.base}, **onward}
    return json.dumps({"_links": links, "_embedded": {"_state": rows}})


def hal(answer: Answer, place: Place) -> str:
    onward = {"next": {"href": _plain_fields(answer.next)}} if answer.next else {}
    links = {"base": {"href": place.base}, "self": {"href": place.own}, **onward}
    told: dict[str, object] = {"_links": links}
    if not answer.listed:
        told["status"] = {"code": SUCCESS}
    if answer.items or not answer.listed:
        told["state"] = [_json_object(item) for item in answer.items]
    if answer.listed:
        told["_embedded"] = {"resources": [_json_object(item) for item in answer.listed]}
    return json.dumps(told)


def refused_xhtml(code: int, message: str, place: Place) -> str:
    spans = f'<span class="code">{code}</span><span class="msg">{_html(message)}</span>'
    return _xhtml_page(place, f'<div class="status">{spans}</div>')


def refused_json_of_one(code: int, message: str, place: Place) -> str:
    status = {"code": code, "msg": message}
    links = {"base": {"href": place.base}}
    return json.dumps({"_links": links, "_embedded": {"status": status, "_state": []}})


def refused_hal(code: int, message: str, place: Place) -> str:
    status = {"code": code, "msg": message}
    return json.dumps({"_links": {"base": {"href": place.base}}, "status": status})


@dataclass(frozen=True, slots=True)
class Form:
    """One way to write answers down. type: of its content."""

    type: str
    written: Callable[[Answer, Place], str]
    refused: Callable[[int, str, Place], str]


XHTML_1: Final = Form("application/xhtml+xml", xhtml, refused_xhtml)
JSON_1: Final = Form("application/json", json_of_one, refused_json_of_one)
XHTML_2: Final = Form("application/xhtml+xml;v=2.0", xhtml, refused_xhtml)
HAL_2: Final = Form("application/hal+json;v=2.0", hal, refused_hal)
