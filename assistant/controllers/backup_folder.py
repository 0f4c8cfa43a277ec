"""Folder of a backup: it appears complete or not at all, and a damaged one is recognised.

`backup.json` lists the other files with the hashes of their text with LF line ends, so that version
control may convert line ends. No file holds the time of the backup: if nothing changed on the
controller, two backups are equal.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path as FilePath
from pathlib import PurePosixPath
from typing import Final

from assistant.base import file_access, file_sets
from assistant.base.diagnostics import Refused
from assistant.base.file_access import read_file
from assistant.controllers import rules

INDEX: Final = "backup.json"
FORMAT: Final = 1


@contextmanager
def appearing_folder(folder: str | FilePath, kind: str) -> Iterator[FilePath]:
    """A new folder to write into, which is `folder` when the block ends well and gone else.

    kind: of the controller, kept in the index. Raises Refused if there is one already, or if
    it cannot be written.
    """
    target = FilePath(folder)
    if target.exists():
        raise Refused(rules.BACKUP_EXISTS(folder=target, path=str(target)))
    try:
        with file_sets.new_folder(target) as under_way:
            yield under_way
            _seal(under_way, kind)
    except OSError as error:
        reason = error.strerror or str(error)
        raise Refused(rules.BACKUP_WRITE(folder=target, reason=reason, path=str(target))) from None


def put_file(folder: FilePath, name: str, data: bytes) -> None:
    """Writes a file below the folder; raises OSError."""
    path = folder / name
    path.parent.mkdir(parents=True, exist_ok=True)
    file_access.write_new(path, data)


def backup_files(folder: FilePath) -> tuple[str, ...]:
    """Names of all files of a backup but its index, relative to it, sorted."""
    found = (path for path in folder.rglob("*") if path.is_file())
    names = {path.relative_to(folder).as_posix() for path in found}
    return tuple(sorted(names - {INDEX}))


def backup_contents(folder: str | FilePath, kind: str) -> Mapping[str, bytes]:
    """The files of a backup that is whole, by name.

    Raises Refused if a file is missing or has changed, or if it is of another kind of controller.
    """
    place = FilePath(folder)
    try:
        if not (place / INDEX).is_file():  # a pipe would never end
            raise _refused(place, f"`{INDEX}` is no file there")
        index = json.loads(read_file(place / INDEX))
    except (OSError, ValueError) as error:
        raise _refused(place, f"`{INDEX}` cannot be read ({_reason(error)})") from None
    if not isinstance(index, dict) or index.get("format") != FORMAT:
        raise _refused(place, f"`{INDEX}` is not of format {FORMAT}")
    if index.get("kind") != kind:
        raise _refused(place, f"it is of another kind of controller (`{index.get('kind')}`)")
    listed = index.get("files")
    if not isinstance(listed, dict):
        raise _refused(place, f"`{INDEX}` lists no files")
    return {name: _checked(place, name, digest) for name, digest in listed.items()}


def _checked(place: FilePath, name: str, digest: object) -> bytes:
    path = PurePosixPath(name)
    if path.is_absolute() or ".." in path.parts or "\\" in name:
        raise _refused(place, f"`{name}` is outside of it")
    try:
        if not (place / name).is_file():
            raise _refused(place, f"`{name}` is no file there")
        data = read_file(place / name)
    except OSError as error:
        raise _refused(place, f"`{name}` cannot be read ({_reason(error)})") from None
    if _digest(data) != digest:
        raise _refused(place, f"`{name}` is not as it was written")
    return data


def _seal(folder: FilePath, kind: str) -> None:
    hashes = {name: _digest(read_file(folder / name)) for name in backup_files(folder)}
    index = {"format": FORMAT, "kind": kind, "files": hashes}
    put_file(folder, INDEX, (json.dumps(index, indent=2) + "\n").encode())


def _digest(data: bytes) -> str:
    # Version control may have converted line ends.
    return hashlib.sha256(data.replace(b"\r\n", b"\n")).hexdigest()


def _reason(error: Exception) -> str:
    return getattr(error, "strerror", None) or str(error)


def _refused(place: FilePath, reason: str) -> Refused:
    return Refused(rules.NO_BACKUP(folder=place, reason=reason, path=str(place)), exit_status=2)
