"""A backup: the controller's own, made on its disk, brought here, and deleted there."""

from __future__ import annotations

import time
from datetime import datetime
from pathlib import Path as FilePath
from typing import Final

from assistant.controllers import folders, rules
from assistant.controllers.abb.rws.files import Files
from assistant.controllers.abb.rws.session import NotThere, Session
from assistant.program.diagnostics import Refused

KIND: Final = "abb"
VOLUME: Final = "BACKUP:"
PATIENCE: Final = 600.0
"""Seconds that a controller is granted for writing its backup, unless the time-out is longer."""
POLL: Final = 0.2
SLOWEST: Final = 2.0
"""Seconds between two looks whether the backup is written: the first, and at most."""
FAILED: Final = ("error", "invalid")
UNDER_WAY: Final = ("progress", "pending", "init", "running")
"""Parts of the words for the state of a backup."""


def back_up(session: Session, files: Files, folder: str | FilePath) -> tuple[str, ...]:
    """Writes a backup into a new folder, which appears whole or not at all; its files."""
    with folders.appearing(folder, KIND) as place:
        name = f"assistant_{datetime.now():%Y%m%d_%H%M%S_%f}"
        path = f"{VOLUME}/{name}"
        try:
            _make(session, files, path)
            for found, size in files.tree(path):
                folders.put(place, found, _read(session, files, f"{path}/{found}", size))
        finally:
            if session.connected:
                files.discard(path)
        return folders.files(place)


def _make(session: Session, files: Files, path: str) -> None:
    doing = "making a backup"
    form = {"backup": f"/fileservice/{files.path(path)}"}
    answer = session.ask("back up", doing=doing, form=form)
    progress = answer.location.rpartition("/progress/")[2] if answer.location else ""
    until = time.monotonic() + max(PATIENCE, session.timeout)
    pause = POLL
    while True:
        state = _state(session, progress)
        if any(word in state for word in FAILED):
            raise session.refusal("make a backup", state, "look into its event log; free its disk")
        if not any(word in state for word in UNDER_WAY):
            return
        if time.monotonic() + pause > until:
            raise Refused(
                rules.NOT_DONE(
                    place=str(session.address), doing=doing, seconds=max(PATIENCE, session.timeout),
                    state="the backup may still be under way on the controller",
                )
            )  # fmt: skip
        time.sleep(pause)
        pause = min(2 * pause, SLOWEST)


def _state(session: Session, progress: str) -> str:
    """How far the backup is, in the controller's words, lower case; "" for done."""
    doing = "asking how far the backup is"
    if progress.isalnum():
        try:
            rows = session.ask("progress", doing=doing, at={"path": progress}).of("progress")
        except NotThere:
            rows = ()
        told = rows[0].get("state").lower() if rows else ""
        if any(word in told for word in (*UNDER_WAY, *FAILED)):
            return told
    answer = session.ask("backup state", doing=doing)
    states = [row.get("backup-state", "backup state", "state") for row in answer.rows]
    return next((state.lower() for state in states if state), "")


def _read(session: Session, files: Files, name: str, size: int | None) -> bytes:
    data = files.read(name)
    if data is None or (size is not None and len(data) != size):
        got = "nothing" if data is None else f"{len(data)} bytes"
        raise session.garbled(f"reading `{name}` of the backup", f"{got} instead of {size} bytes")
    return data
