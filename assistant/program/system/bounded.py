"""Reading with an end: regular files alone, and no more of them than a stated size.

A named pipe waits for somebody who writes into it, a device may never end, and a file may be
larger than the memory. Everything that a user or a client names is read here.
"""

from __future__ import annotations

import errno
import os
import stat
from pathlib import Path as FilePath
from typing import BinaryIO, Final

from assistant.program.system.budgets import FILE, budget_factor

SPECIAL_FILES: Final = {
    stat.S_IFIFO: "a named pipe",
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
    stat.S_IFSOCK: "a socket",
}
READ_BYTES: Final = 1 << 20
"""Bytes that are read at once of what does not say how long it is."""
_OPEN_FLAGS: Final = (
    os.O_RDONLY
    | getattr(os, "O_BINARY", 0)
    | getattr(os, "O_CLOEXEC", 0)
    | getattr(os, "O_NOCTTY", 0)
    | getattr(os, "O_NONBLOCK", 0)  # what became a pipe since it was looked at does not wait
)


class NoFile(OSError):
    """It is there, but no regular file; `strerror` says what it is."""


class TooLarge(OSError):
    """It has more bytes than are read; `strerror` says how many that are."""


def read_file(path: str | FilePath, most: int = FILE) -> bytes:
    """The bytes of a regular file; raises OSError, of it NoFile and TooLarge, and ValueError.

    most: bytes, times the factor of all budgets. Looked at before and while it is read: a file
    may grow, and those of `/proc` say that they are empty.
    """
    check_regular(path)
    number = os.open(path, _OPEN_FLAGS)
    with os.fdopen(number, "rb", buffering=0) as file:
        found = os.fstat(file.fileno())
        _require_regular(found, path)
        limit = int(most * budget_factor())
        if found.st_size > limit:
            raise too_large(limit, path)
        return _read_all(file, limit, path, found.st_size + 1)


def check_regular(path: str | FilePath) -> None:
    """Raises NoFile for a pipe, a device or a socket, and OSError for a folder or nothing."""
    _require_regular(FilePath(path).stat(), path)


def read_text(path: str | FilePath, encoding: str = "utf-8", errors: str = "strict") -> str:
    """The text of a regular file, with a line feed for each end of a line; raises as above."""
    text = read_file(path).decode(encoding, errors)
    return text.replace("\r\n", "\n").replace("\r", "\n")


def read_stream(stream: BinaryIO, most: int = FILE, name: str = "") -> bytes:
    """All that comes until the stream ends; raises TooLarge and other OSErrors."""
    return _read_all(stream, int(most * budget_factor()), name, READ_BYTES)


def _read_all(file: BinaryIO, limit: int, path: str | FilePath, first: int) -> bytes:
    parts: list[bytes] = []
    total, wanted = 0, first
    while True:
        part = file.read(min(wanted, limit + 1 - total))
        if part is None:
            raise OSError(errno.EAGAIN, os.strerror(errno.EAGAIN), str(path))
        if not part:
            return parts[0] if len(parts) == 1 else b"".join(parts)
        parts.append(part)
        total, wanted = total + len(part), READ_BYTES
        if total > limit:
            raise too_large(limit, path)


def too_large(limit: int, path: str | FilePath) -> TooLarge:
    return TooLarge(errno.EFBIG, f"it is larger than {limit / 1e6:.0f} MB", str(path))


def _require_regular(found: os.stat_result, path: str | FilePath) -> None:
    if stat.S_ISDIR(found.st_mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
    if not stat.S_ISREG(found.st_mode):
        kind = SPECIAL_FILES.get(stat.S_IFMT(found.st_mode), "a special file")
        raise NoFile(errno.EINVAL, f"it is {kind}", str(path))
