"""Folders of an FTP server: what is in them, by whichever listing the server has; fetching all.

MLSD says exactly what an entry is (RFC 3659). Servers without it, vsftpd and that of VxWorks among
them, have LIST, whose lines are those of `ls -l` or of DOS. Where they are neither, names come from
NLST, and a folder is what can be entered.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path as FilePath
from typing import Final, Literal

from assistant.base.diagnostics import Refused
from assistant.controllers import folders, rules
from assistant.controllers.abb.files import MOST_ENTRIES, MOST_FOLDERS, told_name
from assistant.controllers.abb.ftp_resuming import read_whole
from assistant.controllers.abb.ftp_session import FtpSession

EntryKind = Literal["file", "folder", "other"]
"""Links and devices are others: they are never followed, for they may lead in circles."""
FOLDER_KIND: Final = "abb files"
"""Of the index of a folder of files: no backup of a whole controller."""
UNTOUCHED: Final = "nothing was changed by that"

UNIX_LINE: Final = re.compile(
    r"(?P<type>[-dlbcps])[-rwxsStTlL]{9}[.+@]?\s+\d+\s+(?:\S+\s+){1,2}(?P<size>\d+)\s+"
    r"(?:[A-Za-z]{3,9}\.?\s+\d{1,2}|\d{1,2}\s+[A-Za-z]{3,9}\.?|\d{4}-\d\d-\d\d)\s+"
    r"(?:\d{1,2}:\d\d(?::\d\d)?|\d{4})\s(?P<name>.+)"
)
"""As `ls -l` writes a line: mode, links, owner, group, size, date, time or year, name."""
DOS_LINE: Final = re.compile(
    r"\d\d-\d\d-(?:\d\d|\d{4})\s+\d\d:\d\d(?:[AP]M)?\s+(?:(?P<folder><DIR>)|(?P<size>\d+))\s+"
    r"(?P<name>.+)",
    re.IGNORECASE,
)
UNIX_TYPES: Final[dict[str, EntryKind]] = {"-": "file", "d": "folder"}
MLSD_TYPES: Final[dict[str, EntryKind]] = {"file": "file", "dir": "folder"}


@dataclass(frozen=True, slots=True, order=True)
class Entry:
    """path: below the folder that was asked for. size: bytes, None where it is not told."""

    path: str
    kind: EntryKind
    size: int | None = None


def folder_tree(session: FtpSession, folder: str = "") -> tuple[Entry, ...]:
    """All below a folder, sorted; the session is in its own folder again afterwards."""
    with session.during("asking for the folder", UNTOUCHED):
        home = session.session.pwd()
    found: list[Entry] = []
    try:
        if folder:
            _enter(session, folder)
        with session.during("asking for the folder", UNTOUCHED):
            top = session.session.pwd()
        spelling = session.session.spelling
        _walk(session, top.rstrip("/"), "", 0, found)
        if session.session.spelling != spelling:  # what was read before is spelled anew
            found.clear()
            _enter(session, top)
            _walk(session, top.rstrip("/"), "", 0, found)
    except rules.Lost:
        raise
    except Refused:
        _enter(session, home)
        raise
    _enter(session, home)
    return tuple(sorted(found))


def fetch_tree(session: FtpSession, folder: str, into: FilePath) -> tuple[str, ...]:
    """Fetches all files below a folder into a new one."""
    files = [entry.path for entry in folder_tree(session, folder) if entry.kind == "file"]
    start = f"{folder.rstrip('/')}/" if folder else ""
    with folders.appearing_folder(into, FOLDER_KIND) as new:
        for path in files:
            folders.put_file(new, path, read_whole(session, start + path))
    return tuple(files)


def parse_list(lines: Iterable[str]) -> list[Entry] | None:
    """What the lines of LIST say, None if one of them is of no known form."""
    found = []
    for line in lines:
        if re.fullmatch(r"(total \d+)?\s*", line):
            continue
        unix, dos = UNIX_LINE.fullmatch(line), DOS_LINE.fullmatch(line)
        if unix is not None:
            kind = UNIX_TYPES.get(unix["type"], "other")
            name = unix["name"].split(" -> ")[0] if unix["type"] == "l" else unix["name"]
            found.append(Entry(name, kind, int(unix["size"]) if kind == "file" else None))
        elif dos is not None:
            size = None if dos["folder"] else int(dos["size"])
            found.append(Entry(dos["name"], "folder" if dos["folder"] else "file", size))
        else:
            return None
    return found


def parse_mlsd(lines: Iterable[str]) -> list[Entry] | None:
    """What the lines of MLSD say: facts, a blank, the name."""
    found = []
    for line in lines:
        facts, blank, name = line.partition(" ")
        pairs = dict(fact.lower().partition("=")[::2] for fact in facts.rstrip(";").split(";"))
        if not blank or "type" not in pairs:
            return None
        if pairs["type"] in ("cdir", "pdir"):
            continue
        size = pairs.get("size", "")
        kind = MLSD_TYPES.get(pairs["type"], "other")
        found.append(Entry(name, kind, int(size) if size.isdecimal() else None))
    return found


def _walk(session: FtpSession, top: str, below: str, depth: int, found: list[Entry]) -> None:
    """Gathers what is in a folder, which the session is in, and in those inside of it."""
    if depth > MOST_FOLDERS:
        reason = f"folders are more than {MOST_FOLDERS} deep"
        raise Refused(rules.FILE_NAME(place=below, name=below, reason=reason))
    if len(found) > MOST_ENTRIES:
        reason = f"there are more than {MOST_ENTRIES} files and folders"
        raise Refused(rules.FILE_NAME(place=below, name=below, reason=reason))
    inner = []
    for entry in _entries(session):
        if entry.path in (".", ".."):
            continue
        path = f"{below}{told_name(entry.path)}"
        found.append(Entry(path, entry.kind, entry.size))
        if entry.kind == "folder":
            inner.append(path)
    for path in inner:
        _enter(session, f"{top}/{path}")
        _walk(session, top, f"{path}/", depth + 1, found)


def _entries(session: FtpSession) -> list[Entry]:
    ways: tuple[tuple[str, Callable[[Iterable[str]], list[Entry] | None]], ...] = (
        ("MLSD", parse_mlsd),
        ("LIST", parse_list),
    )
    for command, read in ways:
        try:
            found = read(_listing_lines(session, command))
        except rules.Lost:
            raise
        except Refused:
            continue
        if found is not None:
            return found
    return list(_entries_by_name(session))


def _listing_lines(session: FtpSession, command: str) -> list[str]:
    with session.during("listing a folder", UNTOUCHED):
        return session.lines(command)


def _entries_by_name(session: FtpSession) -> Iterator[Entry]:
    """By names alone: what can be entered is a folder."""
    names = [line.rsplit("/", 1)[-1] for line in _listing_lines(session, "NLST")]
    with session.during("asking for the folder", UNTOUCHED):
        here = session.session.pwd()
    for name in sorted(set(names) - {".", ".."}):
        try:
            _enter(session, told_name(name))
        except rules.Lost:
            raise
        except Refused:
            yield Entry(name, "file")
        else:
            _enter(session, here)
            yield Entry(name, "folder")


def _enter(session: FtpSession, folder: str) -> None:
    if re.search(r"[\x00-\x1f\x7f]", folder):
        reason = "it holds a control character"
        raise Refused(rules.FILE_NAME(place=repr(folder), name=repr(folder), reason=reason))
    with session.during(f"entering `{folder}`", UNTOUCHED):
        session.session.cwd(folder)
