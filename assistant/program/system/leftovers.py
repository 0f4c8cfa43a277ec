"""What a run that was killed while it wrote has left: told, and put in order.

Nothing had been replaced yet, or everything had: the hidden folder goes. In between, the files that
were replaced become what they were before, byte for byte. One that somebody has changed since then
stays as it is, and what it was before stays where it was kept. Folders that are not ours, of
another user or with anything else in them, are left alone.
"""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import stat
import time
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from pathlib import Path as FilePath
from typing import Final

from assistant.program.diagnostics import Diagnostic, warning
from assistant.program.system import durably, locks
from assistant.program.system.ending import defer_termination

HOLDING: Final = ".robot-assistant-"
"""How the folder begins that holds files until all of them are there."""
NEW: Final = "new"
OLD: Final = "old"
READY: Final = "ready"
"""The note of what is to be replaced."""
BACK: Final = "back"
"""What the note is called once that is to be put back."""
STALE_AFTER: Final = 3600.0
"""Seconds after which a folder counts as left where the file system has no locks."""
RIGHTS_OF_OTHERS: Final = 0o077
"""Rights of others, which no folder of ours gives."""

CUT_OFF: Final = warning(
    "CO203",
    "a run was cut off while it wrote {names}: {state}",
    "run it again, if what it was to write is wanted",
)
OLD_FILES_KEPT: Final = warning(
    "CO204",
    "`{holding}` has {names} as they were before a run that was cut off: {state}",
    "take from there what is needed, and delete that folder",
)
LeftoverReporter = Callable[[Diagnostic], None]
_reporter: Final[ContextVar[LeftoverReporter | None]] = ContextVar("tell", default=None)


@contextmanager
def reporting_leftovers(tell: LeftoverReporter) -> Iterator[None]:
    """Meanwhile what was left is told by that; else it is a warning of Python."""
    before = _reporter.set(tell)
    try:
        yield
    finally:
        _reporter.reset(before)


def recover_folder(folder: FilePath, locked: bool) -> None:
    """Puts in order what others have left in a folder, which nobody else is at; raises OSError.

    locked: whether the file system has locks, which tell what is left from what is under way.
    """
    try:
        found = [one for one in folder.iterdir() if one.name.startswith(HOLDING)]
    except PermissionError:  # a folder that may be written but not read
        return
    for holding in sorted(found):
        if not _is_under_way(holding, locked):
            _recover_from(folder, holding)


def mark_for_recovery(holding: FilePath) -> None:
    """Says that what was replaced is to be put back, also where all of it was."""
    with suppress(OSError):
        (holding / READY).rename(holding / BACK)
        durably.sync_folder(holding)


def remove_holding_folder(holding: FilePath, lock: int = locks.NO_LOCK) -> None:
    """Takes a hidden folder away, and frees its lock; the note goes first."""
    with suppress(OSError):
        for note in (READY, BACK):
            (holding / note).unlink(missing_ok=True)
        for part in (NEW, OLD):
            shutil.rmtree(holding / part, ignore_errors=True)
    with suppress(OSError):
        holding.rmdir()
    locks.free_lock(lock)
    with suppress(OSError):  # where the lock was a file in it
        holding.rmdir()


def _is_under_way(holding: FilePath, locked: bool) -> bool:
    with suppress(OSError):
        if not locked:
            return time.time() - holding.stat().st_mtime < STALE_AFTER
        lock = locks.take_lock(holding)
        if lock is not None:
            locks.free_lock(lock)
        return lock is None
    return True  # it is gone meanwhile, or nobody may look


def _recover_from(folder: FilePath, holding: FilePath) -> None:
    if not _is_own_folder(holding):
        names = "files"
        report_leftover(
            OLD_FILES_KEPT(path=str(folder), holding=holding, names=names, state="not ours")
        )
        return
    rows = _read_note(holding)
    if rows is None:
        names, state = _first_names(_names_in_folder(holding)), "each is whole, or as it was"
    else:
        names = _first_names(rows)
        back, changed = _put_files_back(folder, holding, rows)
        if changed:
            state = "somebody has written them since"
            report_leftover(
                OLD_FILES_KEPT(
                    path=str(folder), holding=holding, names=_first_names(changed), state=state
                )
            )
            return
        state = "they are as they were before" if back else "they are all there"
    with defer_termination():
        remove_holding_folder(holding)
    report_leftover(CUT_OFF(path=str(folder), names=names, state=state))


def _put_files_back(
    folder: FilePath, holding: FilePath, rows: Mapping[str, tuple[bool, str]]
) -> tuple[bool, list[str]]:
    """Whether files are as they were before, and names of those that somebody has changed.

    Nothing is done if every new file had taken its place. rows: of each file whether there was an
    old one, and the digest of the new one.
    """
    replaced = [name for name in rows if not (holding / NEW / name).exists()]
    if len(replaced) == len(rows) and not (holding / BACK).exists():
        return False, []
    changed: list[str] = []
    with defer_termination():
        mark_for_recovery(holding)
        for name in replaced:
            was_there, digest = rows[name]
            target, old = folder / name, holding / OLD / name
            if was_there and (not old.exists() or _are_one(target, old)):
                continue  # it is back already
            if old.is_symlink() or not _has_digest(target, digest):
                changed += [name] if was_there else []
            elif was_there:
                old.replace(target)
            else:
                target.unlink()
        durably.sync_folder(folder)
    return True, changed


def _are_one(target: FilePath, old: FilePath) -> bool:
    return target.exists() and target.samefile(old)


def _has_digest(file: FilePath, digest: str) -> bool:
    try:
        return hashlib.sha256(file.read_bytes()).hexdigest() == digest
    except FileNotFoundError:
        return False


def _read_note(holding: FilePath) -> dict[str, tuple[bool, str]] | None:
    """What was to be replaced, None if nothing was yet: the note is whole before anything is."""
    note = BACK if (holding / BACK).exists() else READY
    try:
        rows = json.loads((holding / note).read_bytes())
        found = {str(name): (bool(row["old"]), str(row["new"])) for name, row in rows.items()}
    except (FileNotFoundError, ValueError, KeyError, TypeError, AttributeError, RecursionError):
        return None
    plain = all(FilePath(name).name == name and name not in ("", ".", "..") for name in found)
    return found if plain else None


def _is_own_folder(holding: FilePath) -> bool:
    facts = holding.lstat()
    if not stat.S_ISDIR(facts.st_mode):
        return False
    if os.name != "nt" and (facts.st_uid != os.geteuid() or facts.st_mode & RIGHTS_OF_OTHERS):
        return False
    return {one.name for one in holding.iterdir()} <= {NEW, OLD, READY, BACK, locks.LOCK_FILE}


def _names_in_folder(holding: FilePath) -> list[str]:
    found = (one.name for part in (NEW, OLD) for one in (holding / part).glob("*"))
    return sorted({*found})


def _first_names(names: Mapping[str, object] | list[str]) -> str:
    """Some names, and how many more."""
    some = [f"`{name}`" for name in names]
    more = f" and {len(some) - 3} more" if len(some) > 3 else ""
    return (", ".join(some[:3]) or "files") + more


def report_leftover(finding: Diagnostic) -> None:
    """Tells it to whom `told_by` named."""
    tell = _reporter.get()
    if tell is not None:
        tell(finding)
    else:
        warnings.warn(f"{finding.code}: {finding.message}", RuntimeWarning, stacklevel=2)
