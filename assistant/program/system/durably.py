"""Files on the disk, with their names, before anything goes on; all of these raise OSError."""

from __future__ import annotations

import os
import secrets
from contextlib import suppress
from pathlib import Path as FilePath
from typing import Final

from assistant.program.system import locks

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
    """Writes beside a file, then takes its place; leaves nothing behind.

    What others who were killed have left beside it is taken away.
    """
    for one in path.parent.glob(f"{UNFINISHED}*"):
        with suppress(OSError):
            if locks.is_unlocked(one):
                one.unlink()
    beside = path.with_name(f"{UNFINISHED}{secrets.token_hex(8)}")
    lock = locks.NO_LOCK
    try:
        with beside.open("xb") as file:
            lock = locks.lock_open_file(file.fileno())
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        beside.replace(path)
    finally:
        beside.unlink(missing_ok=True)
        locks.free_lock(lock)
    sync_folder(path.parent)


def add_line(path: FilePath, line: str) -> None:
    """Adds a line to a file, a new one if its last was cut off."""
    new = not path.exists()
    with path.open("a+b") as file:
        end = file.seek(0, os.SEEK_END)
        whole = True
        if end:
            file.seek(end - 1)
            whole = file.read(1) == b"\n"
        file.write(("" if whole else "\n").encode() + line.encode() + b"\n")
        file.flush()
        os.fsync(file.fileno())
    if new:
        sync_folder(path.parent)


def sync_folder(folder: FilePath) -> None:
    """Waits until the names in a folder are on the disk; Windows does that by itself.

    Of a folder that may be written but not read nobody can wait for that.
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
