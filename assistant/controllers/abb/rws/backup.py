"""A backup: the controller's own, made on its disk, brought here, and deleted there."""

from __future__ import annotations

import time
from collections.abc import Mapping
from datetime import datetime
from pathlib import Path as FilePath
from typing import Final

from assistant.base.diagnostics import Refused
from assistant.controllers import folders, rules
from assistant.controllers.abb.rws.files import Files
from assistant.controllers.abb.rws.session import NotThere, Session

KIND: Final = "abb"
VOLUME: Final = "BACKUP:"
PATIENCE: Final = 600.0
"""Seconds that a controller is granted for writing its backup, unless the time-out is longer."""
INFO_FILE: Final = "backinfo/backinfo.txt"
"""A file that every backup has."""
FIRST_POLL: Final = 0.2
SLOWEST_POLL: Final = 2.0
"""Seconds between two looks whether the backup is written: the first, and at most."""
FAILED: Final = ("error", "invalid")
UNDER_WAY: Final = ("progress", "pending", "init", "running", "none")
"""Parts of the words for the state of a backup: `Backup in Progress`, `Error during backup`, …"""


def back_up(session: Session, files: Files, folder: str | FilePath) -> tuple[str, ...]:
    """Writes a backup into a new folder, which appears whole or not at all; its files."""
    with folders.appearing_folder(folder, KIND) as place:
        name = f"assistant_{datetime.now():%Y%m%d_%H%M%S_%f}"
        path = f"{VOLUME}/{name}"
        try:
            _make(session, files, path)
            for found, size in files.tree(path):
                folders.put_file(place, found, _read(session, files, f"{path}/{found}", size))
        finally:
            if session.connected:
                files.discard(path)
        written = folders.backup_files(place)
        if not any(one.lower() == INFO_FILE for one in written):
            raise session.garbled("reading the backup", f"it has no `{INFO_FILE}`")
        return written


def _make(session: Session, files: Files, path: str) -> None:
    doing = "making a backup"
    form = {"backup": f"/fileservice/{files.path(path)}"}
    answer = session.ask("back up", doing=doing, form=form)
    number = answer.location.rpartition("/progress/")[2]
    patience = max(PATIENCE, session.timeout)
    until = time.monotonic() + patience
    pause = FIRST_POLL
    while not _ready(session, number if number.isalnum() else ""):
        if time.monotonic() + pause > until:
            state = "the backup may still be under way on the controller"
            place = str(session.address)
            raise Refused(rules.NOT_DONE(place=place, doing=doing, seconds=patience, state=state))
        time.sleep(pause)
        pause = min(2 * pause, SLOWEST_POLL)


def _ready(session: Session, number: str) -> bool:
    """Whether the backup is written, by its progress if it has a number, and by its state."""
    doing = "asking how far the backup is"
    told = [
        _state_word(session, "backup state", doing, {}, "backup-state", "backup state", "state")
    ]
    if number:
        told.append(_state_word(session, "progress", doing, {"path": number}, "state"))
    if not any(told):
        raise session.refusal(
            "make a backup", "it does not tell when one is whole", "make it on the FlexPendant"
        )
    for state in told:
        if any(word in state for word in FAILED):
            raise session.refusal("make a backup", state, "look into its event log; free its disk")
    return not any(word in state for state in told for word in UNDER_WAY)


def _state_word(
    session: Session, name: str, doing: str, at: Mapping[str, str], *values: str
) -> str:
    """A state in the controller's words, lower case; "" where it tells none."""
    try:
        rows = session.ask(name, doing=doing, at=at).rows
    except NotThere:
        return ""
    return next((row.get(*values).lower() for row in rows if row.get(*values)), "")


def _read(session: Session, files: Files, name: str, size: int | None) -> bytes:
    data = files.read(name)
    if data is None or (size is not None and len(data) != size):
        got = "nothing" if data is None else f"{len(data)} bytes"
        raise session.garbled(f"reading `{name}` of the backup", f"{got} instead of {size} bytes")
    return data
