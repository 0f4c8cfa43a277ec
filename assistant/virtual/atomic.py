"""A file appears whole or not at all."""

from __future__ import annotations

import os
import secrets
from pathlib import Path as FilePath
from typing import Final

ARRIVING: Final = ".arriving-"
"""First characters of the name of a file that is being written."""


def write_whole(path: FilePath, data: bytes) -> None:
    """Writes beside the file, then takes its place; raises OSError and leaves nothing behind."""
    beside = path.with_name(f"{ARRIVING}{secrets.token_hex(8)}")
    try:
        with beside.open("xb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        beside.replace(path)
    finally:
        beside.unlink(missing_ok=True)
