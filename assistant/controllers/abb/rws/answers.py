"""Answers of Robot Web Services, as XHTML or as JSON, as one kind of rows.

XHTML: `<li class="pnl-opmode" title="opmode"><span class="opmode">AUTO</span></li>`; JSON: objects
with `_type` and `_title`, under `_embedded._state`, `_embedded.resources` or `state`.
"""

from __future__ import annotations

import html
import json
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final
from xml.etree import ElementTree

DEEPEST_ANSWER: Final = 50
"""Levels of an answer after which it is taken for garbage."""
DOCTYPE: Final = re.compile(r"<!DOCTYPE [^\[\]<>]*>")
"""A document type without declarations of its own."""
SOURCE_PLACE: Final = re.compile(r"(?:[A-Za-z]:\\|\w)[^\s\[\]]*\.cpp\[\d+\]:?")
"""Where in RobotWare's own source an error arose, as its messages begin."""


@dataclass(frozen=True, slots=True)
class Row:
    """A resource. kind: its class. href: of itself. values: what is told of it, by name."""

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

    number, text: of an error. location: the header of that name. data: the bytes as they came.
    framed: whether their end was told.
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
        wanted = {kind.removesuffix("-li") for kind in kinds}
        return tuple(row for row in self.rows if row.kind.removesuffix("-li") in wanted)


def parse_answer(data: bytes) -> tuple[tuple[Row, ...], str, int | None, str]:
    """Rows, next page, number and text of the status; raises ValueError for another form."""
    text = data.decode("utf-8").strip()
    if not text:
        return (), "", None, ""
    return _of_json(text) if text.startswith("{") else _of_xhtml(text)


def _of_xhtml(text: str) -> tuple[tuple[Row, ...], str, int | None, str]:
    text = DOCTYPE.sub("", text, count=1)
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
    if depth > DEEPEST_ANSWER:
        raise ValueError("it is nested too deep")
    for below in item:
        name = _local(below)
        if name == "span":
            yield below.get("class", ""), "".join(below.itertext()).strip()
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
    if depth > DEEPEST_ANSWER:
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
    said = re.sub(r"\bERROR:\s*", "", SOURCE_PLACE.sub("", message))
    said = re.sub(r"[\x00-\x1f\x7f]+|\s+", " ", said)
    return re.sub(r"\s*\bi?code:\s*-?\d+", "", said).strip(" ;:")


def numbers(row: Row, names: Sequence[str]) -> tuple[float, ...]:
    """Values as numbers; raises ValueError naming the first that is none."""
    found = []
    for name in names:
        try:
            found.append(float(row.values[name]))
        except (KeyError, ValueError):
            raise ValueError(f"no number `{name}` in {row.kind or 'the answer'}") from None
    return tuple(found)
