"""`/rw/cfg`: system parameters that are read, set, loaded and saved."""

from __future__ import annotations

import re
from typing import Final, get_args

from assistant.base.file_access import read_text, write_whole
from assistant.virtual.irc5.cabinet import Cabinet
from assistant.virtual.irc5.parameters import DOMAINS, NAMES, How, Instance, parse
from assistant.virtual.irc5.rws import reasons
from assistant.virtual.irc5.rws.answers import DONE, Answer, Item, Rejected
from assistant.virtual.irc5.rws.request import Request
from assistant.virtual.irc5.rws.resources.files import path_of, unit_path

HOWS: Final[dict[str, How]] = {one: one for one in get_args(How)}
PAGE: Final = 70
"""Instances that are listed at once."""
_BRACKETS: Final = re.compile(r"\[(.*),\s*\d+\]")
"""How RWS 2.0 writes a value: the value, and which of several it is."""


def domains(cabinet: Cabinet, request: Request) -> Answer:
    names = cabinet.parameters.values
    return Answer(listed=[Item("cfg-domain-li", name, {}, f"cfg/{name}") for name in names])


def types(cabinet: Cabinet, request: Request) -> Answer:
    domain = _domain(request)
    names = cabinet.parameters.values[domain]
    return Answer(listed=[Item("cfg-dt-li", name, {}, f"{domain}/{name}") for name in names])


def _domain(request: Request) -> str:
    name = request.captures["domain"].upper()
    if name not in DOMAINS:
        raise Rejected(reasons.NO_RESOURCE)
    return name


def _type(cabinet: Cabinet, request: Request) -> dict[str, Instance]:
    found = cabinet.parameters.values[_domain(request)]
    for name, instances in found.items():
        if name.lower() == request.captures["type"].lower():
            return instances
    raise Rejected(reasons.BAD_ARGUMENT, "Invalid type id")


def instances(cabinet: Cabinet, request: Request) -> Answer:
    found = sorted(_type(cabinet, request).items())
    start = request.number("start", 0, 10**6, 0)
    page = found[start : start + PAGE]
    onward = f"instances?start={start + PAGE}" if start + PAGE < len(found) else ""
    return Answer(listed=[_item(request, name, row) for name, row in page], next=onward)


def instance(cabinet: Cabinet, request: Request) -> Answer:
    name, row = _named(cabinet, request)
    return Answer(items=[_item(request, name, row)])


def _named(cabinet: Cabinet, request: Request) -> tuple[str, Instance]:
    for name, row in _type(cabinet, request).items():
        if name.lower() == request.captures["instance"].lower():
            return name, row
    raise Rejected(reasons.NO_RESOURCE)


def _item(request: Request, name: str, row: Instance) -> Item:
    kind = request.either("cfg-ia-t-li", "cfg-ia-t")
    inside = tuple(Item(kind, key, {"value": value}) for key, value in row.items())
    fields = {"rdonly": "false", "instanceid": name}
    return Item("cfg-dt-instance-li", name, fields, f"instances/{name}", inside, "attrib")


def change(cabinet: Cabinet, request: Request) -> Answer:
    """Only attributes that there are, and names stay as they are."""
    row = _named(cabinet, request)[1]
    new = {}
    for key, value in request.form.items():
        found = _BRACKETS.fullmatch(value) if request.dialect == 2 else None
        known = next((name for name in row if name.lower() == key.lower()), None)
        if known is None or known in NAMES:
            raise Rejected(reasons.BAD_ARGUMENT, f"Error set attribute {key}")
        new[known] = found[1] if found else value
    row.update(new)
    return DONE


def load(cabinet: Cabinet, request: Request) -> Answer:
    how = HOWS.get(request.given("action-type"))
    if how is None:
        raise Rejected(reasons.BAD_ARGUMENT, "action-type")
    try:
        cabinet.parameters.load(_text(cabinet, request), how)
    except ValueError as wrong:
        raise Rejected(reasons.BAD_ARGUMENT, str(wrong)) from None
    return DONE


def validate(cabinet: Cabinet, request: Request) -> Answer:
    """Whether a file could be loaded."""
    try:
        parse(_text(cabinet, request))
    except ValueError as wrong:
        raise Rejected(reasons.BAD_ARGUMENT, str(wrong)) from None
    return DONE


def _text(cabinet: Cabinet, request: Request) -> str:
    try:
        return read_text(path_of(cabinet, unit_path(request.given("filepath"))), "latin-1")
    except OSError:
        raise Rejected(reasons.NO_FILE if request.dialect == 1 else reasons.NO_PATH) from None


def save(cabinet: Cabinet, request: Request) -> Answer:
    path = path_of(cabinet, unit_path(request.given("filepath")))
    try:
        write_whole(path, cabinet.parameters.text(_domain(request)).encode("latin-1", "replace"))
    except OSError:
        raise Rejected(reasons.NO_FILE if request.dialect == 1 else reasons.NO_PATH) from None
    return DONE
