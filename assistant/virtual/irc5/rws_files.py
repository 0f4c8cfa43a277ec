"""`/fileservice` and `/rw/cfg`: the volumes of the controller, and its system parameters.

HOME is the folder that FTP serves as well. RWS 1.0 writes a volume as `$HOME`, literally; 2.0 as
`HOME`. A file is returned as it is, whatever the request accepts. Files are not checked: a module
with errors is refused when it is loaded. System parameters are read, set, loaded and saved.
"""

from __future__ import annotations

import re
import shutil
from collections.abc import Iterable, Iterator
from contextlib import suppress
from datetime import datetime
from pathlib import Path as FilePath
from typing import Final, get_args
from urllib.parse import unquote

from assistant.base.file_access import UNFINISHED, read_file, read_text, write_whole
from assistant.virtual.irc5 import rws_messages
from assistant.virtual.irc5.cabinet import (
    INSTANCE_NAME,
    PARAMETER_DOMAINS,
    Cabinet,
    Instance,
    LoadMethod,
    parse_cfg,
)
from assistant.virtual.irc5.rws_messages import DONE, Answer, Item, Rejected, Request

_VOLUMES: Final = ("HOME", "TEMP", "BACKUP", "RAMDISK")
_FILE_TIME: Final = "%Y-%m-%d T %H:%M:%S"
_CONTROL: Final = re.compile(r"[\x00-\x1f\x7f]")


def path_of(cabinet: Cabinet, path: str, dialect: int = 1) -> FilePath:
    """A file or folder by `HOME/parts/a.mod`; raises Rejected for what is in no volume."""
    volume, _, inside = path.strip("/").partition("/")
    name = volume.lstrip("$").rstrip(":").upper()
    if name not in _VOLUMES:
        raise Rejected(rws_messages.NO_FILE if dialect == 1 else rws_messages.NO_VOLUME)
    root = cabinet.disk.folder(name)
    # Resolved, so that links and `..` cannot lead out of the volume.
    found = None if _CONTROL.search(inside) else (root / inside).resolve()
    if found is None or (found != root and root not in found.parents):
        raise Rejected(rws_messages.NO_FILE if dialect == 1 else rws_messages.NO_PATH)
    return found


def unit_path(path: str) -> str:
    """Return the path that a form names, with or without `/fileservice/` in front, as `$HOME/x` or
    `HOME:/x`.
    """
    return path.removeprefix("/fileservice/").lstrip("/")


def _requested_path(cabinet: Cabinet, request: Request) -> FilePath:
    raw = request.captures.get("path", "")
    if request.dialect == 1 and "%24" in raw:  # A real one takes the sign only as it is.
        raise Rejected(rws_messages.NO_FILE)
    return path_of(cabinet, unquote(raw), request.dialect)


def _missing_path(request: Request) -> Rejected:
    return Rejected(rws_messages.NO_FILE if request.dialect == 1 else rws_messages.NO_PATH)


def list_volumes(cabinet: Cabinet, request: Request) -> Answer:
    kind, sign = request.either("fs-device", "fs-dir"), request.either("$", "")
    return Answer(listed=[Item(kind, f"{sign}{name}", {}, f"{sign}{name}") for name in _VOLUMES])


def read_path(cabinet: Cabinet, request: Request) -> Answer:
    path = _requested_path(cabinet, request)
    try:
        if path.is_dir():
            names = sorted(one for one in path.iterdir() if not one.name.startswith(UNFINISHED))
            return Answer(listed=list(_path_items(names)))
        return Answer(data=read_file(path))
    except OSError:
        raise _missing_path(request) from None


def _path_items(paths: Iterable[FilePath]) -> Iterator[Item]:
    for one in paths:
        with suppress(FileNotFoundError):  # a program may delete it meanwhile
            yield _path_item(one)


def _path_item(path: FilePath) -> Item:
    facts = path.stat()
    fields = {
        "fs-cdate": datetime.fromtimestamp(facts.st_ctime).strftime(_FILE_TIME),
        "fs-mdate": datetime.fromtimestamp(facts.st_mtime).strftime(_FILE_TIME),
    }
    if path.is_dir():
        return Item("fs-dir", path.name, fields, path.name)
    fields |= {"fs-size": str(facts.st_size), "fs-readonly": "false"}
    return Item("fs-file", path.name, fields, path.name)


def store_file(cabinet: Cabinet, request: Request) -> Answer:
    path = _requested_path(cabinet, request)
    if path.is_dir() or not path.parent.is_dir():
        raise _missing_path(request)
    new = not path.exists()
    try:
        write_whole(path, request.body)
    except OSError as wrong:
        raise Rejected(rws_messages.UNSPECIFIED, wrong.strerror or "") from None
    return Answer(201 if new else 200)


def delete_path(cabinet: Cabinet, request: Request) -> Answer:
    path = _requested_path(cabinet, request)
    # A volume itself is never deleted.
    if path == path_of(cabinet, unquote(request.captures["path"]).partition("/")[0]):
        raise Rejected(rws_messages.NOT_PERMITTED, "a volume")
    try:
        if path.is_dir():
            shutil.rmtree(path)
        else:
            path.unlink()
    except OSError:
        raise _missing_path(request) from None
    return Answer(200) if request.dialect == 1 else DONE


def act_on_path(cabinet: Cabinet, request: Request) -> Answer:
    """Carry out the action that the form of RWS 1.0 names."""
    actions = {"create": create_folder, "copy": copy_path, "rename": rename_path}
    wanted = request.given("fs-action")
    if wanted not in actions:
        raise Rejected(rws_messages.BAD_ARGUMENT, f"fs-action {wanted}")
    return actions[wanted](cabinet, request)


def _new_name(request: Request) -> str:
    name = request.given("fs-newname")
    if not name or name in (".", "..") or "/" in name or "\\" in name or _CONTROL.search(name):
        raise Rejected(rws_messages.BAD_ARGUMENT, "fs-newname")
    return name


def create_folder(cabinet: Cabinet, request: Request) -> Answer:
    folder = _requested_path(cabinet, request) / _new_name(request)
    try:
        folder.mkdir()
    except FileExistsError:
        raise Rejected(rws_messages.BAD_ARGUMENT, "there is one of that name") from None
    except OSError:
        raise _missing_path(request) from None
    return Answer(201)


def copy_path(cabinet: Cabinet, request: Request) -> Answer:
    """In its own folder only."""
    source = _requested_path(cabinet, request)
    target = source.with_name(_new_name(request))
    overwrite = request.form.get("fs-overwrite", "false").lower() == "true"
    if target.exists() and not overwrite:
        raise Rejected(rws_messages.BAD_ARGUMENT, "there is one of that name")
    try:
        if source.is_dir():
            shutil.copytree(source, target)
        else:
            write_whole(target, read_file(source))
    except OSError:
        raise _missing_path(request) from None
    return Answer(201)


def rename_path(cabinet: Cabinet, request: Request) -> Answer:
    source = _requested_path(cabinet, request)
    target = source.with_name(_new_name(request))
    if target.exists():
        raise Rejected(rws_messages.BAD_ARGUMENT, "there is one of that name")
    try:
        source.replace(target)
    except OSError:
        raise _missing_path(request) from None
    return DONE


_LOAD_METHODS: Final[dict[str, LoadMethod]] = {one: one for one in get_args(LoadMethod)}
_INSTANCES_PAGE: Final = 70
"""Instances that are listed at once."""
_BRACKETS: Final = re.compile(r"\[(.*),\s*\d+\]")
"""Form of a value in RWS 2.0: the value, and its number among several."""


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
        raise Rejected(rws_messages.NO_RESOURCE)
    return name


def _parameter_type(cabinet: Cabinet, request: Request) -> dict[str, Instance]:
    found = cabinet.parameters.values[_parameter_domain(request)]
    for name, instances in found.items():
        if name.lower() == request.captures["type"].lower():
            return instances
    raise Rejected(rws_messages.BAD_ARGUMENT, "Invalid type id")


def parameter_instances(cabinet: Cabinet, request: Request) -> Answer:
    found = sorted(_parameter_type(cabinet, request).items())
    start = request.number("start", 0, 10**6, 0)
    page = found[start : start + _INSTANCES_PAGE]
    onward = (
        f"instances?start={start + _INSTANCES_PAGE}" if start + _INSTANCES_PAGE < len(found) else ""
    )
    return Answer(listed=[_instance_item(request, name, row) for name, row in page], next=onward)


def parameter_instance(cabinet: Cabinet, request: Request) -> Answer:
    name, row = _find_instance(cabinet, request)
    return Answer(items=[_instance_item(request, name, row)])


def _find_instance(cabinet: Cabinet, request: Request) -> tuple[str, Instance]:
    for name, row in _parameter_type(cabinet, request).items():
        if name.lower() == request.captures["instance"].lower():
            return name, row
    raise Rejected(rws_messages.NO_RESOURCE)


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
        # Names identify an instance: a change would make it another one.
        if known is None or known in INSTANCE_NAME:
            raise Rejected(rws_messages.BAD_ARGUMENT, f"Error set attribute {key}")
        # Collected first: one wrong attribute changes nothing.
        new[known] = found[1] if found else value
    row.update(new)
    return DONE


def load_parameters(cabinet: Cabinet, request: Request) -> Answer:
    how = _LOAD_METHODS.get(request.given("action-type"))
    if how is None:
        raise Rejected(rws_messages.BAD_ARGUMENT, "action-type")
    try:
        cabinet.parameters.load(_parameter_file(cabinet, request), how)
    except ValueError as wrong:
        raise Rejected(rws_messages.BAD_ARGUMENT, str(wrong)) from None
    return DONE


def validate_parameters(cabinet: Cabinet, request: Request) -> Answer:
    """Check that a file could be loaded."""
    try:
        parse_cfg(_parameter_file(cabinet, request))
    except ValueError as wrong:
        raise Rejected(rws_messages.BAD_ARGUMENT, str(wrong)) from None
    return DONE


def _parameter_file(cabinet: Cabinet, request: Request) -> str:
    try:
        return read_text(path_of(cabinet, unit_path(request.given("filepath"))), "latin-1")
    except OSError:
        raise Rejected(
            rws_messages.NO_FILE if request.dialect == 1 else rws_messages.NO_PATH
        ) from None


def save_parameters(cabinet: Cabinet, request: Request) -> Answer:
    path = path_of(cabinet, unit_path(request.given("filepath")))
    try:
        write_whole(
            path, cabinet.parameters.text(_parameter_domain(request)).encode("latin-1", "replace")
        )
    except OSError:
        raise Rejected(
            rws_messages.NO_FILE if request.dialect == 1 else rws_messages.NO_PATH
        ) from None
    return DONE
