"""A journal as one file, which a controller keeps while a deployment to it is under way.

What comes from a controller may have been made by anybody: it is looked at before it is believed.
"""

from __future__ import annotations

import io
import lzma
import struct
import tempfile
import zipfile
import zlib
from collections.abc import Mapping
from pathlib import Path as FilePath
from typing import Final

from assistant.base import file_access
from assistant.base.file_access import read_file
from assistant.deploy.journal import (
    EARLIER,
    KEPT,
    PROGRAMS,
    RECORD,
    STEPS,
    Entry,
    Journal,
    appeared,
    failing,
    read_journal,
)
from assistant.deploy.record import LONGEST, read_record
from assistant.deploy.site import UNDER_WAY

MOST_BYTES: Final = 256 * 2**20
"""Of an archive, packed and unpacked."""
MOST_FILES: Final = 10_000
BROKEN: Final = (zipfile.BadZipFile, zlib.error, lzma.LZMAError, struct.error, EOFError)
"""What an archive that is cut or made up meets beside ValueError and the like."""
COMPRESSIONS: Final = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)


def packed(journal: Journal) -> bytes:
    """The folder of a journal without its steps."""
    data = io.BytesIO()
    with zipfile.ZipFile(data, "w") as archive:
        for file in sorted(journal.folder.rglob("*")):
            if file.is_file() and file.name != STEPS:
                name = file.relative_to(journal.folder).as_posix()
                archive.writestr(zipfile.ZipInfo(name), read_file(file), zipfile.ZIP_DEFLATED)
    return data.getvalue()


def unpack(data: bytes, place: FilePath, name: str) -> Journal | None:
    """The journal of a deployment in a new numbered folder, None if it is of another one.

    Raises Refused if it is damaged.
    """
    with failing(place):
        files = _whole(data)
        if read_record(files[RECORD], RECORD).name != name:
            return None

        def fill(new: FilePath) -> None:
            _fill(new, files)
            read_journal(new)

        return read_journal(appeared(place, fill))


def archived(data: bytes) -> tuple[Entry, ...]:
    """The programs of a journal that a controller kept; raises Refused. Nothing stays here."""
    with tempfile.TemporaryDirectory() as folder, failing(FilePath(UNDER_WAY)):
        _fill(FilePath(folder), _whole(data))
        return read_journal(FilePath(folder)).entries


def _whole(data: bytes) -> dict[str, bytes]:
    """The files of an archive; raises ValueError."""
    try:
        return _files(data)
    except (*BROKEN, NotImplementedError, RuntimeError) as error:
        raise ValueError(f"the archive on the controller is damaged ({error})") from None


def _fill(new: FilePath, files: Mapping[str, bytes]) -> None:
    for path, content in files.items():
        (new / path).parent.mkdir(exist_ok=True)
        file_access.write_new(new / path, content)


def _files(data: bytes) -> dict[str, bytes]:
    """Those of a journal in an archive, by their paths in its folder."""
    if len(data) > MOST_BYTES:
        raise ValueError("the archive on the controller is too long")
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        rows = archive.infolist()
        whole = sum(row.file_size for row in rows)
        if whole > MOST_BYTES or len(rows) > MOST_FILES:
            raise ValueError("the archive on the controller is too long")
        if any(row.filename == RECORD and row.file_size > LONGEST for row in rows):
            raise ValueError("the record in the archive on the controller is too long")
        wanted = [
            row
            for row in rows
            if row.filename in (RECORD, EARLIER, PROGRAMS) or KEPT.fullmatch(row.filename)
        ]
        if any(row.compress_type not in COMPRESSIONS for row in wanted):
            raise ValueError("the archive on the controller is packed in a way that is not known")
        if len({row.filename.lower() for row in wanted}) < len(wanted):
            raise ValueError("the archive on the controller has a file twice")
        return {row.filename: archive.read(row) for row in wanted}
