"""File access: bounded reads of regular files, durable writes, and locks on folders.

Every file that a user or a client names is read here. A named pipe waits for a writer, a device may
never end, and a file may be larger than the memory: only regular files are read, up to a stated
size. A written file is on the disk, with its name, before anything continues. The system frees a
lock when its owner dies. Functions raise OSError.
"""

from __future__ import annotations

import errno
import os
import secrets
import stat
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path as FilePath
from typing import BinaryIO, Final

from assistant.base.budgets import FILE, budget_factor

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
        # Checked once more: the name may lead to another file since.
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
        # One byte over the limit shows that there is more.
        part = file.read(min(wanted, limit + 1 - total))
        if part is None:
            # A stream that does not block has nothing yet.
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


LOCK_TIMEOUT: Final = 30.0
"""Seconds to wait for a folder that another process has locked."""
LOCK_INTERVAL: Final = 0.02
"""Seconds between two looks at whether it is free."""
LOCK_FILE: Final = ".lock"
"""The file that is the lock where folders themselves have none: on Windows."""
TAKEN_ERRORS: Final = (errno.EAGAIN, errno.EACCES, errno.EEXIST)


@contextmanager
def locked_folder(folder: FilePath) -> Iterator[bool]:
    """Hold the only lock of this computer on a folder; raises OSError if that takes too long.

    Yields whether the file system has locks at all; without locks, other processes are not kept
    out.
    """
    until = time.monotonic() + LOCK_TIMEOUT
    # A blocking `flock` has no timeout, so the lock is polled.
    while (lock := take_lock(folder)) is None:
        if time.monotonic() > until:
            raise BlockingIOError(errno.EBUSY, "another process writes there", str(folder))
        time.sleep(LOCK_INTERVAL)
    try:
        yield lock != NO_LOCK
    finally:
        free_lock(lock)


NO_LOCK: Final = -1
"""Value in place of a lock on file systems without locks."""

if sys.platform == "win32":

    def take_lock(folder: FilePath) -> int | None:
        """Return a folder's lock, None if it is taken; raises OSError."""
        try:  # a file that goes away with who has it open
            return os.open(folder / LOCK_FILE, os.O_CREAT | os.O_EXCL | os.O_RDWR | os.O_TEMPORARY)
        except (FileExistsError, PermissionError):
            return None

    def free_lock(lock: int) -> None:
        if lock != NO_LOCK:
            os.close(lock)

    def lock_open_file(_number: int) -> int:
        """Mark an open file as being written: on Windows, opening it is the mark."""
        return NO_LOCK

    def is_unlocked(_file: FilePath) -> bool:
        """True if no process marks the file as being written: Windows keeps open files anyway."""
        return True

else:
    import fcntl

    def take_lock(folder: FilePath) -> int | None:
        """Return a folder's lock, None if it is taken, NO_LOCK without locks; raises OSError."""
        try:
            number = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
        except PermissionError:  # one that may be written but not read
            return NO_LOCK
        try:
            fcntl.flock(number, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            os.close(number)
            return None if error.errno in TAKEN_ERRORS else NO_LOCK
        return number

    def free_lock(lock: int) -> None:
        if lock != NO_LOCK:
            fcntl.flock(lock, fcntl.LOCK_UN)  # which a process that was forked may have open, too
            os.close(lock)

    def lock_open_file(number: int) -> int:
        """Says that an open file is being written, until that is freed; raises OSError."""
        with suppress(OSError):
            fcntl.flock(number, fcntl.LOCK_EX | fcntl.LOCK_NB)
        # The lock is of the open file, not of its number: a copy of the number holds it after
        # closing.
        return os.dup(number)

    def is_unlocked(_file: FilePath) -> bool:
        """True if no process marks the file as being written; raises OSError."""
        number = os.open(_file, os.O_RDONLY)
        try:
            fcntl.flock(number, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            return False
        finally:
            os.close(number)
        return True


UNFINISHED: Final = ".arriving-"
"""First characters of the name of a file that is being written."""


def make_folders(folder: FilePath) -> list[FilePath]:
    """Makes a folder with those above it; which of them were not there, the outermost last."""
    missing = [one for one in (folder, *folder.parents) if not one.exists()]
    folder.mkdir(parents=True, exist_ok=True)
    for one in missing:
        sync_folder(one.parent)
    return missing


def write_new(path: FilePath, data: bytes) -> None:
    """Writes a file that is not there yet."""
    with path.open("xb") as file:
        file.write(data)
        file.flush()
        os.fsync(file.fileno())


def write_whole(path: FilePath, data: bytes) -> None:
    """Write a complete file: first next to it, then in its place; leaves no other file.

    Removes files that processes which were killed have left next to it.
    """
    for one in path.parent.glob(f"{UNFINISHED}*"):
        with suppress(OSError):
            if is_unlocked(one):
                one.unlink()
    beside = path.with_name(f"{UNFINISHED}{secrets.token_hex(8)}")
    lock = NO_LOCK
    try:
        with beside.open("xb") as file:
            # While it is locked, no other process takes the file for a leftover.
            lock = lock_open_file(file.fileno())
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        beside.replace(path)
    finally:
        beside.unlink(missing_ok=True)
        free_lock(lock)
    sync_folder(path.parent)


def add_line(path: FilePath, line: str) -> None:
    """Adds a line to a file, a new one if its last was cut off."""
    new = not path.exists()
    with path.open("a+b") as file:
        end = file.seek(0, os.SEEK_END)
        whole = True
        # A line that was cut off must not swallow the new one.
        if end:
            file.seek(end - 1)
            whole = file.read(1) == b"\n"
        file.write(("" if whole else "\n").encode() + line.encode() + b"\n")
        file.flush()
        os.fsync(file.fileno())
    if new:
        sync_folder(path.parent)


def sync_folder(folder: FilePath) -> None:
    """Wait until the names in a folder are on the disk; Windows needs no such wait.

    For a folder that may be written but not read, this wait is impossible and is skipped.
    """
    if os.name == "nt":
        return
    try:
        number = os.open(folder, os.O_RDONLY)
    except PermissionError:
        return
    try:
        os.fsync(number)
    finally:
        os.close(number)
