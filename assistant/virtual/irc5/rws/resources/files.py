"""`/fileservice`: the volumes of the controller. HOME is the folder that FTP serves as well.

RWS 1.0 writes a volume as `$HOME`, literally; 2.0 as `HOME`. A file is given back as it is,
whatever the request accepts. Files are not looked into: a module with errors is refused when it is
loaded.
"""

from __future__ import annotations

import re
import shutil
from datetime import datetime
from pathlib import Path as FilePath
from typing import Final
from urllib.parse import unquote

from assistant.base.file_access import UNFINISHED, read_file, write_whole
from assistant.virtual.irc5.cabinet import Cabinet
from assistant.virtual.irc5.rws import reasons
from assistant.virtual.irc5.rws.answers import DONE, Answer, Item, Rejected
from assistant.virtual.irc5.rws.request import Request

VOLUMES: Final = ("HOME", "TEMP", "BACKUP", "RAMDISK")
FILE_TIME: Final = "%Y-%m-%d T %H:%M:%S"
_CONTROL: Final = re.compile(r"[\x00-\x1f\x7f]")


def path_of(cabinet: Cabinet, path: str, dialect: int = 1) -> FilePath:
    """A file or folder by `HOME/parts/a.mod`; raises Rejected for what is in no volume."""
    volume, _, inside = path.strip("/").partition("/")
    name = volume.lstrip("$").rstrip(":").upper()
    if name not in VOLUMES:
        raise Rejected(reasons.NO_FILE if dialect == 1 else reasons.NO_VOLUME)
    root = cabinet.disk.folder(name)
    found = None if _CONTROL.search(inside) else (root / inside).resolve()
    if found is None or (found != root and root not in found.parents):
        raise Rejected(reasons.NO_FILE if dialect == 1 else reasons.NO_PATH)
    return found


def unit_path(path: str) -> str:
    """What a form names, with or without `/fileservice/` in front, as `$HOME/x` or `HOME:/x`."""
    return path.removeprefix("/fileservice/").lstrip("/")


def _requested_path(cabinet: Cabinet, request: Request) -> FilePath:
    raw = request.captures.get("path", "")
    if request.dialect == 1 and "%24" in raw:  # A real one takes the sign only as it is.
        raise Rejected(reasons.NO_FILE)
    return path_of(cabinet, unquote(raw), request.dialect)


def _missing_path(request: Request) -> Rejected:
    return Rejected(reasons.NO_FILE if request.dialect == 1 else reasons.NO_PATH)


def list_volumes(cabinet: Cabinet, request: Request) -> Answer:
    kind, sign = request.either("fs-device", "fs-dir"), request.either("$", "")
    return Answer(listed=[Item(kind, f"{sign}{name}", {}, f"{sign}{name}") for name in VOLUMES])


def read_path(cabinet: Cabinet, request: Request) -> Answer:
    path = _requested_path(cabinet, request)
    try:
        if path.is_dir():
            names = sorted(one for one in path.iterdir() if not one.name.startswith(UNFINISHED))
            return Answer(listed=[_path_item(one) for one in names])
        return Answer(data=read_file(path))
    except OSError:
        raise _missing_path(request) from None


def _path_item(path: FilePath) -> Item:
    facts = path.stat()
    fields = {
        "fs-cdate": datetime.fromtimestamp(facts.st_ctime).strftime(FILE_TIME),
        "fs-mdate": datetime.fromtimestamp(facts.st_mtime).strftime(FILE_TIME),
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
        raise Rejected(reasons.UNSPECIFIED, wrong.strerror or "") from None
    return Answer(201 if new else 200)


def delete_path(cabinet: Cabinet, request: Request) -> Answer:
    path = _requested_path(cabinet, request)
    if path == path_of(cabinet, unquote(request.captures["path"]).partition("/")[0]):
        raise Rejected(reasons.NOT_PERMITTED, "a volume")
    try:
        if path.is_dir():
            shutil.rmtree(path)
        else:
            path.unlink()
    except OSError:
        raise _missing_path(request) from None
    return Answer(200) if request.dialect == 1 else DONE


def act_on_path(cabinet: Cabinet, request: Request) -> Answer:
    """RWS 1.0: what is to be done stands in the form."""
    actions = {"create": create_folder, "copy": copy_path, "rename": rename_path}
    wanted = request.given("fs-action")
    if wanted not in actions:
        raise Rejected(reasons.BAD_ARGUMENT, f"fs-action {wanted}")
    return actions[wanted](cabinet, request)


def _new_name(request: Request) -> str:
    name = request.given("fs-newname")
    if not name or name in (".", "..") or "/" in name or "\\" in name or _CONTROL.search(name):
        raise Rejected(reasons.BAD_ARGUMENT, "fs-newname")
    return name


def create_folder(cabinet: Cabinet, request: Request) -> Answer:
    folder = _requested_path(cabinet, request) / _new_name(request)
    try:
        folder.mkdir()
    except FileExistsError:
        raise Rejected(reasons.BAD_ARGUMENT, "there is one of that name") from None
    except OSError:
        raise _missing_path(request) from None
    return Answer(201)


def copy_path(cabinet: Cabinet, request: Request) -> Answer:
    """In its own folder only."""
    source = _requested_path(cabinet, request)
    target = source.with_name(_new_name(request))
    overwrite = request.form.get("fs-overwrite", "false").lower() == "true"
    if target.exists() and not overwrite:
        raise Rejected(reasons.BAD_ARGUMENT, "there is one of that name")
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
        raise Rejected(reasons.BAD_ARGUMENT, "there is one of that name")
    try:
        source.replace(target)
    except OSError:
        raise _missing_path(request) from None
    return DONE
