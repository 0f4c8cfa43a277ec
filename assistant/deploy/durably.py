"""Files of the history: on the disk, with their names, before anything goes on."""

from __future__ import annotations

import os
from pathlib import Path as FilePath


def make_folders(folder: FilePath) -> None:
    """Makes a folder with those above it; raises OSError."""
    missing = [one for one in (folder, *folder.parents) if not one.exists()]
    folder.mkdir(parents=True, exist_ok=True)
    for one in missing:
        settle(one.parent)


def write_new(path: FilePath, data: bytes) -> None:
    """Writes a file that is not there yet; raises OSError."""
    with path.open("xb") as file:
        file.write(data)
        file.flush()
        os.fsync(file.fileno())


def add_line(path: FilePath, line: str) -> None:
    """Adds a line to a file, a new one if its last was cut off; raises OSError."""
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
        settle(path.parent)


def settle(folder: FilePath) -> None:
    """Waits until the names in a folder are on the disk; Windows does that by itself."""
    if os.name == "nt":
        return
    number = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(number)
    finally:
        os.close(number)
