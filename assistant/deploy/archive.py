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
    EARLIER_FILE,
    KEPT_FILE,
    PROGRAMS_FILE,
    RECORD_FILE,
    STEPS_FILE,
    Entry,
    Journal,
    new_folder,
    read_journal,
    report_file_errors,
)
from assistant.deploy.record import LONGEST_RECORD, read_record
from assistant.deploy.site import UNDER_WAY

MOST_ARCHIVE_BYTES: Final = 256 * 2**20
"""Of an archive, packed and unpacked."""
MOST_ARCHIVE_FILES: Final = 10_000
BROKEN_ARCHIVE: Final = (zipfile.BadZipFile, zlib.error, lzma.LZMAError, struct.error, EOFError)
"""What an archive that is cut or made up meets beside ValueError and the like."""
COMPRESSIONS: Final = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)


def pack_journal(journal: Journal) -> bytes:
    """The folder of a journal without its steps."""
    data = io.BytesIO()
    with zipfile.ZipFile(data, "w") as archive:
        for file in sorted(journal.folder.rglob("*")):
            if file.is_file() and file.name != STEPS_FILE:
                name = file.relative_to(journal.folder).as_posix()
                archive.writestr(zipfile.ZipInfo(name), read_file(file), zipfile.ZIP_DEFLATED)
    return data.getvalue()


def unpack_journal(data: bytes, place: FilePath, name: str) -> Journal | None:
    """The journal of a deployment in a new numbered folder, None if it is of another one.

    Raises Refused if it is damaged.
    """
    with report_file_errors(place):
        files = _archive_files(data)
        if read_record(files[RECORD_FILE], RECORD_FILE).name != name:
            return None

        def fill(new: FilePath) -> None:
            _fill_folder(new, files)
            read_journal(new)

        return read_journal(new_folder(place, fill))


def archived_programs(data: bytes) -> tuple[Entry, ...]:
    """The programs of a journal that a controller kept; raises Refused. Nothing stays here."""
    with tempfile.TemporaryDirectory() as folder, report_file_errors(FilePath(UNDER_WAY)):
        _fill_folder(FilePath(folder), _archive_files(data))
        return read_journal(FilePath(folder)).entries


def _archive_files(data: bytes) -> dict[str, bytes]:
    """The files of an archive; raises ValueError."""
    try:
        return _journal_files(data)
    except (*BROKEN_ARCHIVE, NotImplementedError, RuntimeError) as error:
        raise ValueError(f"the archive on the controller is damaged ({error})") from None


def _fill_folder(new: FilePath, files: Mapping[str, bytes]) -> None:
    for path, content in files.items():
        (new / path).parent.mkdir(exist_ok=True)
        file_access.write_new(new / path, content)


def _journal_files(data: bytes) -> dict[str, bytes]:
    """Those of a journal in an archive, by their paths in its folder."""
    if len(data) > MOST_ARCHIVE_BYTES:
        raise ValueError("the archive on the controller is too long")
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        rows = archive.infolist()
        whole = sum(row.file_size for row in rows)
        if whole > MOST_ARCHIVE_BYTES or len(rows) > MOST_ARCHIVE_FILES:
            raise ValueError("the archive on the controller is too long")
        if any(row.filename == RECORD_FILE and row.file_size > LONGEST_RECORD for row in rows):
            raise ValueError("the record in the archive on the controller is too long")
        wanted = [
            row
            for row in rows
            if row.filename in (RECORD_FILE, EARLIER_FILE, PROGRAMS_FILE)
            or KEPT_FILE.fullmatch(row.filename)
        ]
        if any(row.compress_type not in COMPRESSIONS for row in wanted):
            raise ValueError("the archive on the controller is packed in a way that is not known")
        if len({row.filename.lower() for row in wanted}) < len(wanted):
            raise ValueError("the archive on the controller has a file twice")
        return {row.filename: archive.read(row) for row in wanted}
