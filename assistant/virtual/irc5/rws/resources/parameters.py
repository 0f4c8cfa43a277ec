"""`/rw/cfg`: system parameters that are read, set, loaded and saved."""

from __future__ import annotations

import re
from typing import Final, get_args

from assistant.base.file_access import read_text, write_whole
from assistant.virtual.irc5.cabinet import Cabinet
from assistant.virtual.irc5.parameters import (
    INSTANCE_NAME,
    PARAMETER_DOMAINS,
    Instance,
    LoadMethod,
    parse_cfg,
)
from assistant.virtual.irc5.rws import reasons
from assistant.virtual.irc5.rws.answers import DONE, Answer, Item, Rejected
from assistant.virtual.irc5.rws.request import Request
from assistant.virtual.irc5.rws.resources.files import path_of, unit_path

LOAD_METHODS: Final[dict[str, LoadMethod]] = {one: one for one in get_args(LoadMethod)}
INSTANCES_PAGE: Final = 70
"""Instances that are listed at once."""
_BRACKETS: Final = re.compile(r"\[(.*),\s*\d+\]")
"""How RWS 2.0 writes a value: the value, and which of several it is."""


def parameter_domains(cabinet: Cabinet, request: Request) -> Answer:
    names = cabinet.parameters.values
    return Answer(listed=[Item("cfg-domain-li", name, {}, f"cfg/{name}") for name in names])


def parameter_types(cabinet: Cabinet, request: Request) -> Answer:
    domain = _parameter_domain(request)
    names = cabinet.parameters.values[domain]
    return Answer(listed=[Item("cfg-dt-li", name, {}, f"{domain}/{name}") for name in names])


def _parameter_domain(request: Request) -> str:
    name = request.captures["domain"].upper()
    if name not in PARAMETER_DOMAINS:
        raise Rejected(reasons.NO_RESOURCE)
    return name


def _parameter_type(cabinet: Cabinet, request: Request) -> dict[str, Instance]:
    found = cabinet.parameters.values[_parameter_domain(request)]
    for name, instances in found.items():
        if name.lower() == request.captures["type"].lower():
            return instances
    raise Rejected(reasons.BAD_ARGUMENT, "Invalid type id")


def parameter_instances(cabinet: Cabinet, request: Request) -> Answer:
    found = sorted(_parameter_type(cabinet, request).items())
    start = request.number("start", 0, 10**6, 0)
    page = found[start : start + INSTANCES_PAGE]
    onward = (
        f"instances?start={start + INSTANCES_PAGE}" if start + INSTANCES_PAGE < len(found) else ""
    )
    return Answer(listed=[_instance_item(request, name, row) for name, row in page], next=onward)


def parameter_instance(cabinet: Cabinet, request: Request) -> Answer:
    name, row = _find_instance(cabinet, request)
    return Answer(items=[_instance_item(request, name, row)])


def _find_instance(cabinet: Cabinet, request: Request) -> tuple[str, Instance]:
    for name, row in _parameter_type(cabinet, request).items():
        if name.lower() == request.captures["instance"].lower():
            return name, row
    raise Rejected(reasons.NO_RESOURCE)


def _instance_item(request: Request, name: str, row: Instance) -> Item:
    kind = request.either("cfg-ia-t-li", "cfg-ia-t")
    inside = tuple(Item(kind, key, {"value": value}) for key, value in row.items())
    fields = {"rdonly": "false", "instanceid": name}
    return Item("cfg-dt-instance-li", name, fields, f"instances/{name}", inside, "attrib")


def change_parameter(cabinet: Cabinet, request: Request) -> Answer:
    """Only attributes that there are, and names stay as they are."""
    row = _find_instance(cabinet, request)[1]
    new = {}
    for key, value in request.form.items():
        found = _BRACKETS.fullmatch(value) if request.dialect == 2 else None
        known = next((name for name in row if name.lower() == key.lower()), None)
        if known is None or known in INSTANCE_NAME:
            raise Rejected(reasons.BAD_ARGUMENT, f"Error set attribute {key}")
        new[known] = found[1] if found else value
    row.update(new)
    return DONE


def load_parameters(cabinet: Cabinet, request: Request) -> Answer:
    how = LOAD_METHODS.get(request.given("action-type"))
    if how is None:
        raise Rejected(reasons.BAD_ARGUMENT, "action-type")
    try:
        cabinet.parameters.load(_parameter_file(cabinet, request), how)
    except ValueError as wrong:
        raise Rejected(reasons.BAD_ARGUMENT, str(wrong)) from None
    return DONE


def validate_parameters(cabinet: Cabinet, request: Request) -> Answer:
    """Whether a file could be loaded."""
    try:
        parse_cfg(_parameter_file(cabinet, request))
    except ValueError as wrong:
        raise Rejected(reasons.BAD_ARGUMENT, str(wrong)) from None
    return DONE


def _parameter_file(cabinet: Cabinet, request: Request) -> str:
    try:
        return read_text(path_of(cabinet, unit_path(request.given("filepath"))), "latin-1")
    except OSError:
        raise Rejected(reasons.NO_FILE if request.dialect == 1 else reasons.NO_PATH) from None


def save_parameters(cabinet: Cabinet, request: Request) -> Answer:
    path = path_of(cabinet, unit_path(request.given("filepath")))
    try:
        write_whole(
            path, cabinet.parameters.text(_parameter_domain(request)).encode("latin-1", "replace")
        )
    except OSError:
        raise Rejected(reasons.NO_FILE if request.dialect == 1 else reasons.NO_PATH) from None
    return DONE
