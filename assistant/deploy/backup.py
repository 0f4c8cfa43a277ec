"""What was on a controller before a deployment, kept in a folder of its own."""

from __future__ import annotations

import hashlib
import json
import os
import re
from collections.abc import Sequence
from pathlib import Path as FilePath
from typing import Final

from assistant.controllers import Address
from assistant.deploy import rules
from assistant.deploy.plan import PlannedFile
from assistant.program.diagnostics import Refused

DEFAULT: Final = FilePath(".robot-assistant") / "backup"
"""Beside the project, one folder a controller in it."""
INDEX: Final = "backup.json"
NUMBER: Final = re.compile(r"\d{4,}")


def keep(
    address: Address, files: Sequence[PlannedFile], folder: str | FilePath | None = None
) -> FilePath:
    """Writes what the controller has of the files into a new numbered folder, and gives that.

    folder: where the numbered folders stand, None for the default. `backup.json` lists
    each program with its hash, null for one that was not there. Raises Refused; a folder
    without that list is not whole.
    """
    place = FilePath(folder) if folder is not None else DEFAULT / address.label
    try:
        kept = _numbered(place)
        programs: dict[str, str | None] = {}
        for file in files:
            programs[file.name] = None
            if file.before is not None:
                _write(kept / file.name, file.before)
                programs[file.name] = hashlib.sha256(file.before).hexdigest()
        index = {"controller": str(address), "programs": programs}
        _write(kept / INDEX, (json.dumps(index, indent=2) + "\n").encode())
    except OSError as error:
        reason = error.strerror or str(error)
        raise Refused(rules.NO_BACKUP(folder=place, reason=reason, path=str(place))) from None
    return kept


def _numbered(place: FilePath) -> FilePath:
    """A new folder with the next number; two runs at once get two."""
    place.mkdir(parents=True, exist_ok=True)
    numbers = [int(entry.name) for entry in place.iterdir() if NUMBER.fullmatch(entry.name)]
    number = max(numbers, default=0) + 1
    while True:
        try:
            folder = place / f"{number:04}"
            folder.mkdir()
        except FileExistsError:
            number += 1
        else:
            return folder


def _write(path: FilePath, data: bytes) -> None:
    with path.open("xb") as file:
        file.write(data)
        file.flush()
        os.fsync(file.fileno())
