"""Locks on folders, which the system frees when who has them dies."""

from __future__ import annotations

import errno
import os
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path as FilePath
from typing import Final

LOCK_TIMEOUT: Final = 30.0
"""Seconds for which somebody else may have a folder."""
LOCK_INTERVAL: Final = 0.02
"""Seconds between two looks at whether it is free."""
LOCK_FILE: Final = ".lock"
"""The file that is the lock where folders themselves have none: on Windows."""
TAKEN_ERRORS: Final = (errno.EAGAIN, errno.EACCES, errno.EEXIST)


@contextmanager
def locked_folder(folder: FilePath) -> Iterator[bool]:
    """While nobody else of this computer has the folder; raises OSError if that takes too long.

    Tells whether the file system has locks at all; where it has none, nobody is kept out.
    """
    until = time.monotonic() + LOCK_TIMEOUT
    while (lock := take_lock(folder)) is None:
        if time.monotonic() > until:
            raise BlockingIOError(errno.EBUSY, "another process writes there", str(folder))
        time.sleep(LOCK_INTERVAL)
    try:
        yield lock != NO_LOCK
    finally:
        free_lock(lock)


NO_LOCK: Final = -1
"""Instead of a lock where there are none."""

if sys.platform == "win32":

    def take_lock(folder: FilePath) -> int | None:
        """The lock of a folder, None if somebody has it, NONE if it has none; raises OSError."""
        try:  # a file that goes away with who has it open
            return os.open(folder / LOCK_FILE, os.O_CREAT | os.O_EXCL | os.O_RDWR | os.O_TEMPORARY)
        except (FileExistsError, PermissionError):
            return None

    def free_lock(lock: int) -> None:
        if lock != NO_LOCK:
            os.close(lock)

    def lock_open_file(_number: int) -> int:
        """Says that an open file is being written: Windows does by itself."""
        return NO_LOCK

    def is_unlocked(_file: FilePath) -> bool:
        """Whether nobody says that he writes a file: what is open cannot be deleted anyway."""
        return True

else:
    import fcntl

    def take_lock(folder: FilePath) -> int | None:
        """The lock of a folder, None if somebody has it, NONE if it has none; raises OSError."""
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
        return os.dup(number)

    def is_unlocked(_file: FilePath) -> bool:
        """Whether nobody says that he writes a file; raises OSError."""
        number = os.open(_file, os.O_RDONLY)
        try:
            fcntl.flock(number, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            return False
        finally:
            os.close(number)
        return True
