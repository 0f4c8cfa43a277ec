"""Long transfers by FTP that go on where they were cut.

Servers do different things with REST and STOR: some overwrite in place, pure-ftpd cuts the file at
the offset. So an upload is gone on with by APPE, and only after what is there has been read and
compared; a download only where the file has its size and time still, and the end of what is here.
"""

from __future__ import annotations

import ftplib
import json
import os
from collections.abc import Callable
from pathlib import Path as FilePath
from typing import BinaryIO, Final

from assistant.base import file_access
from assistant.base.diagnostics import Refused
from assistant.base.file_access import read_text
from assistant.controllers import rules
from assistant.controllers.abb.files import TEMPORARY, first_difference
from assistant.controllers.abb.ftp_session import FtpSession

Progress = Callable[[int, int | None], None]
"""Is told how many bytes are here, and of how many, None if the server does not tell."""

COMPARED_OVERLAP: Final = 4096
"""Bytes at the end of a part that are fetched again and compared."""
UNTOUCHED: Final = "nothing was changed by that"


def file_size(session: FtpSession, name: str) -> int | None:
    """Bytes of a file; in binary mode, for in ASCII mode servers refuse or count otherwise."""
    told = _status_text(session, f"SIZE {name}")
    return int(told) if told is not None and told.isdecimal() else None


def read_whole(session: FtpSession, name: str) -> bytes:
    """A file with as many bytes as the server says that it has, where it says so."""
    data = session.retrieve(name, UNTOUCHED)
    length = file_size(session, name)
    if length not in (None, len(data)):
        raise Refused(rules.SHORT(place=name, name=name, there=length, back=len(data)))
    return data


def download(session: FtpSession, name: str, to: FilePath, progress: Progress | None) -> int:
    to = FilePath(os.path.realpath(to))  # a link stays one
    part, note = to.with_name(f"{to.name}.part"), to.with_name(f"{to.name}.part.json")
    stamp = _size_and_time(session, name)
    whole = None if stamp is None else int(stamp[0])
    try:
        start = _partial_size(part, note, stamp)
        if start == 0:
            part.write_bytes(b"")
            if stamp is not None:
                note.write_text(json.dumps(stamp), encoding="utf-8")
        with part.open("r+b") as file:
            if not _went_on(session, name, file, start, whole, progress):
                _fetch_rest(session, name, file, 0, whole, progress)
            file.flush()
            os.fsync(file.fileno())
        length = part.stat().st_size
        if stamp != _size_and_time(session, name) or (whole is not None and length != whole):
            part.unlink()
            raise Refused(rules.SHORT(place=name, name=name, there=whole, back=length))
        part.replace(to)
        file_access.sync_folder(to.parent)
        note.unlink(missing_ok=True)
    except OSError as error:
        reason = error.strerror or str(error)
        raise Refused(rules.NOT_KEPT(path=str(to), name=name, reason=reason)) from None
    return length


def upload(session: FtpSession, name: str, data: bytes) -> None:
    """Puts a file whole under its temporary name."""
    temporary, doing = TEMPORARY.format(name=name), f"storing `{name}`"
    state = f"`{name}` there is as it was"
    there = file_size(session, temporary) or 0
    begun = 0
    if 0 < there <= len(data) and session.retrieve(temporary, state) == data[:there]:
        begun = there
    if begun:
        try:
            session.store(temporary, data[begun:], doing, state, command="APPE")
        except rules.Lost:
            raise
        except Refused:
            begun = 0  # a server that takes no parts
    if not begun:
        session.store(temporary, data, doing, state)
    back = session.retrieve(temporary, state, start=begun)
    if back != data[begun:] or file_size(session, temporary) not in (None, len(data)):
        session.discard(temporary)
        raise Refused(
            rules.ALTERED(
                place=name,
                name=name,
                sent=len(data),
                back=begun + len(back),
                at=begun + first_difference(data[begun:], back),
                state=state,
            )
        )


def _went_on(
    session: FtpSession,
    name: str,
    file: BinaryIO,
    start: int,
    whole: int | None,
    progress: Progress | None,
) -> bool:
    """Whether the rest could be fetched, and belongs to what is there."""
    try:
        return start > 0 and _fetch_rest(session, name, file, start, whole, progress)
    except rules.Lost:
        raise
    except Refused:
        return False  # a server that only sends whole files


def _fetch_rest(
    session: FtpSession,
    name: str,
    file: BinaryIO,
    start: int,
    whole: int | None,
    progress: Progress | None,
) -> bool:
    """Fetches into a file from an offset on; False if what is there is not the same any more."""
    begin = max(0, start - COMPARED_OVERLAP)
    file.seek(begin)
    known = file.read(start - begin)
    file.seek(begin)
    file.truncate()
    seen = bytearray()

    def keep(piece: bytes) -> None:
        if len(seen) < len(known):
            seen.extend(piece)
        file.write(piece)
        if progress is not None:
            progress(file.tell(), whole)

    session.retrieve_into(name, UNTOUCHED, keep, begin)
    return bytes(seen[: len(known)]) == known


def _partial_size(part: FilePath, note: FilePath, stamp: tuple[str, str] | None) -> int:
    """Bytes that an earlier transfer left of the same file."""
    if stamp is None or not part.is_file() or not note.is_file():
        return 0
    try:
        same = json.loads(read_text(note)) == list(stamp)
    except ValueError:
        return 0
    length = part.stat().st_size
    return length if same and length <= int(stamp[0]) else 0


def _size_and_time(session: FtpSession, name: str) -> tuple[str, str] | None:
    """Size and time of a file, None if the server does not tell both."""
    length, changed = file_size(session, name), _status_text(session, f"MDTM {name}")
    return None if length is None or changed is None else (str(length), changed)


def _status_text(session: FtpSession, command: str) -> str | None:
    """What stands behind `213` in the answer to a command, None for another answer."""
    with session.during(f"asking `{command.split()[0]}`", UNTOUCHED):
        try:
            session.session.voidcmd("TYPE I")
            answer = session.session.sendcmd(command)
        except ftplib.error_perm:
            return None
    return answer[4:].strip() if answer.startswith("213") else None
