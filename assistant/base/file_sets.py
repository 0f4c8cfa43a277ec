"""Sets of files that appear in a folder complete or not at all, and recovery after a killed run.

A name never disappears, and at every instant holds all old or all new bytes. Each folder that is
written into gets a hidden one for the time:

    .robot-assistant-…/new/    the new files, on the disk before anything else happens
    .robot-assistant-…/old/    those that they replace: links to them, or copies
    .robot-assistant-…/ready   what is to be replaced; from here on names change

Then each new file takes the place of the old one. What fails is put back, and nothing interrupts
that. A run that is killed leaves the folder, and the next run recovers: where nothing had been
replaced yet, or everything had, the hidden folder goes; in between, the replaced files become what
they were, byte for byte. A file that was changed since then stays as it is, and its old content
stays where it was kept. Folders of another user, or with anything else in them, are left alone.
"""

from __future__ import annotations

import errno
import hashlib
import json
import os
import shutil
import stat
import tempfile
import time
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from contextvars import ContextVar
from dataclasses import field
from pathlib import Path as FilePath
from typing import Final

from assistant.base import file_access
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused, error, warning
from assistant.base.termination import defer_termination

_HOLDING: Final = ".robot-assistant-"
"""First characters of the name of a folder that holds files until all of them are written."""
NEW: Final = "new"
_OLD: Final = "old"
READY: Final = "ready"
"""The note of what is to be replaced."""
_BACK: Final = "back"
"""Name of the note once its files are to be put back."""
_STALE_AFTER: Final = 3600.0
"""Seconds after which a folder counts as left where the file system has no locks."""
_RIGHTS_OF_OTHERS: Final = 0o077
"""Rights of others, which no folder of ours gives."""

_CUT_OFF: Final = warning(
    "CO203",
    "a run was cut off while it wrote {names}: {state}",
    "run it again, if what it was to write is wanted",
)
_OLD_FILES_KEPT: Final = warning(
    "CO204",
    "`{holding}` has {names} as they were before a run that was cut off: {state}",
    "take from there what is needed, and delete that folder",
)
LeftoverReporter = Callable[[Diagnostic], None]
_reporter: Final[ContextVar[LeftoverReporter | None]] = ContextVar("tell", default=None)


@contextmanager
def reporting_leftovers(tell: LeftoverReporter) -> Iterator[None]:
    """Pass findings on leftovers to `tell` in the block; without it they are Python warnings."""
    before = _reporter.set(tell)
    try:
        yield
    finally:
        _reporter.reset(before)


def _recover_folder(folder: FilePath, locked: bool) -> None:
    """Recover a folder from interrupted writes while no other process uses it; raises OSError.

    locked: true if the file system has locks, which distinguish leftovers from writes in progress.
    """
    try:
        found = [one for one in folder.iterdir() if one.name.startswith(_HOLDING)]
    except PermissionError:  # a folder that may be written but not read
        return
    for holding in sorted(found):
        if not _is_under_way(holding, locked):
            _recover_from(folder, holding)


def _mark_for_recovery(holding: FilePath) -> None:
    """Says that what was replaced is to be put back, also where all of it was."""
    with suppress(OSError):
        (holding / READY).rename(holding / _BACK)
        file_access.sync_folder(holding)


def _remove_holding_folder(holding: FilePath, lock: int = file_access.NO_LOCK) -> None:
    """Takes a hidden folder away, and frees its lock; the note goes first."""
    # The notes go first: with a note and half of the files, the next run would put files back.
    with suppress(OSError):
        for note in (READY, _BACK):
            (holding / note).unlink(missing_ok=True)
        for part in (NEW, _OLD):
            shutil.rmtree(holding / part, ignore_errors=True)
    with suppress(OSError):
        holding.rmdir()
    file_access.free_lock(lock)
    with suppress(OSError):  # where the lock was a file in it
        holding.rmdir()


def _is_under_way(holding: FilePath, locked: bool) -> bool:
    with suppress(OSError):
        if not locked:
            return time.time() - holding.stat().st_mtime < _STALE_AFTER
        # The system frees the lock of a process that dies: a free lock marks a leftover.
        lock = file_access.take_lock(holding)
        if lock is not None:
            file_access.free_lock(lock)
        return lock is None
    return True  # it is gone meanwhile, or nobody may look


def _recover_from(folder: FilePath, holding: FilePath) -> None:
    if not _is_own_folder(holding):
        names = "files"
        _report_leftover(
            _OLD_FILES_KEPT(path=str(folder), holding=holding, names=names, state="not ours")
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
            _report_leftover(
                _OLD_FILES_KEPT(
                    path=str(folder), holding=holding, names=_first_names(changed), state=state
                )
            )
            return
        state = "they are as they were before" if back else "they are all there"
    with defer_termination():
        _remove_holding_folder(holding)
    _report_leftover(_CUT_OFF(path=str(folder), names=names, state=state))


def _put_files_back(
    folder: FilePath, holding: FilePath, rows: Mapping[str, tuple[bool, str]]
) -> tuple[bool, list[str]]:
    """Put files back; return True if they are as before, and the names of files changed since.

    Nothing is done if every new file had taken its place. rows: of each file whether an old one
    existed, and the digest of the new one.
    """
    # A new file that is no longer in its folder has taken its place.
    replaced = [name for name in rows if not (holding / NEW / name).exists()]
    if len(replaced) == len(rows) and not (holding / _BACK).exists():
        return False, []
    changed: list[str] = []
    with defer_termination():
        # A recovery that is killed is continued by the next run, not taken for a complete write.
        _mark_for_recovery(holding)
        for name in replaced:
            was_there, digest = rows[name]
            target, old = folder / name, holding / _OLD / name
            if was_there and (not old.exists() or _are_one(target, old)):
                continue  # it is back already
            # An old file is never a link (`_check_replaceable`); another digest means that it was
            # written since.
            if old.is_symlink() or not _has_digest(target, digest):
                changed += [name] if was_there else []
            elif was_there:
                old.replace(target)
            else:
                target.unlink()
        file_access.sync_folder(folder)
    return True, changed


def _are_one(target: FilePath, old: FilePath) -> bool:
    return target.exists() and target.samefile(old)


def _has_digest(file: FilePath, digest: str) -> bool:
    try:
        return hashlib.sha256(file.read_bytes()).hexdigest() == digest
    except FileNotFoundError:
        return False


def _read_note(holding: FilePath) -> dict[str, tuple[bool, str]] | None:
    """Read which files were to be replaced, None before any was: the note is complete by then."""
    note = _BACK if (holding / _BACK).exists() else READY
    try:
        rows = json.loads((holding / note).read_bytes())
        found = {str(name): (bool(row["old"]), str(row["new"])) for name, row in rows.items()}
    except (FileNotFoundError, ValueError, KeyError, TypeError, AttributeError, RecursionError):
        return None
    # A note is data from the disk: its names must not lead out of the folder.
    plain = all(FilePath(name).name == name and name not in ("", ".", "..") for name in found)
    return found if plain else None


def _is_own_folder(holding: FilePath) -> bool:
    facts = holding.lstat()
    if not stat.S_ISDIR(facts.st_mode):
        return False
    if os.name != "nt" and (facts.st_uid != os.geteuid() or facts.st_mode & _RIGHTS_OF_OTHERS):
        return False
    return {one.name for one in holding.iterdir()} <= {
        NEW,
        _OLD,
        READY,
        _BACK,
        file_access.LOCK_FILE,
    }


def _names_in_folder(holding: FilePath) -> list[str]:
    found = (one.name for part in (NEW, _OLD) for one in (holding / part).glob("*"))
    return sorted({*found})


def _first_names(names: Mapping[str, object] | list[str]) -> str:
    """Some names, and how many more."""
    some = [f"`{name}`" for name in names]
    more = f" and {len(some) - 3} more" if len(some) > 3 else ""
    return (", ".join(some[:3]) or "files") + more


def _report_leftover(finding: Diagnostic) -> None:
    """Report it to the function that `reporting_leftovers` named."""
    tell = _reporter.get()
    if tell is not None:
        tell(finding)
    else:
        warnings.warn(f"{finding.code}: {finding.message}", RuntimeWarning, stacklevel=2)


_NOT_WRITTEN: Final = error(
    "CO201",
    "`{name}` cannot be written: {reason}",
    "free space, have it be writable, or name another folder; what was there before is untouched",
)
_BAD_NAME: Final = error("CO202", "`{name}` is no plain file name", "rename the program")
_NOT_PUT_BACK: Final = error(
    "CO205",
    "{names} could not be put back as they were: {reason}",
    "what they were is in `{holding}` until the next command that can write there has all of them "
    "old, or all new",
)
_UNCONFIRMED: Final = warning(
    "CO206",
    "`{name}` is there whole, but the disk does not confirm its name: {reason}",
    "look at the disk, and for the folder once more when the computer has been started again",
)


_WRITABLE: Final = stat.S_IWUSR | stat.S_IWGRP | stat.S_IWOTH
"""Permissions that a protected file lacks: a new file could still take its name."""


class _Stuck(OSError):
    """Replaced files could not be put back. names: of the files; holding: their folder."""

    def __init__(self, wrong: OSError, names: Iterable[str], holding: FilePath) -> None:
        super().__init__(wrong.errno, wrong.strerror or str(wrong), str(holding))
        self.names, self.holding = tuple(names), holding

    def told(self) -> Refused:
        names = ", ".join(f"`{name}`" for name in self.names)
        place, reason = str(self.holding.parent), self.strerror
        finding = _NOT_PUT_BACK(path=place, names=names, reason=reason, holding=self.holding)
        return Refused(finding, exit_status=2)


def write_files(files: Mapping[str, bytes], folder: str | FilePath) -> tuple[FilePath, ...]:
    """Writes files into a folder, which is made; all of them or none.

    Raises Refused (exit status 2) if the folder or a file cannot be written.
    """
    return write_all({file_in_folder(name, folder): data for name, data in files.items()})


def file_in_folder(name: str, folder: str | FilePath) -> FilePath:
    """A file of a folder; raises Refused (exit status 2) for a name that leads elsewhere."""
    if FilePath(name).name != name or name in {"", ".", ".."}:
        raise Refused(_BAD_NAME(path=str(folder), name=name), exit_status=2)
    return FilePath(folder) / name


def write_all(files: Mapping[FilePath, bytes]) -> tuple[FilePath, ...]:
    """Writes files, of several folders too; all of them or none.

    Only what is killed between two folders leaves one of them new and the other old. Raises Refused
    (exit status 2).
    """
    try:
        write_or_raise(files)
    except OSError as wrong:
        first = next(iter(files))
        name = _name_as_given(wrong, files) or first.parent
        reason = wrong.strerror or str(wrong)
        if isinstance(wrong, FileExistsError | NotADirectoryError):
            reason = "a file of that name is where the folder would be"
        finding = _NOT_WRITTEN(path=str(first.parent), name=name, reason=reason)
        raise Refused(finding, exit_status=2) from None
    return tuple(files)


def write_or_raise(files: Mapping[FilePath, bytes]) -> None:
    """The same for who says in words of his own what went wrong; raises OSError.

    A link stays one, and what it leads to is written. Raises Refused where files are not as they
    were: no words of others are right then.
    """
    made: list[FilePath] = []
    sets: list[_FileSet] = []
    try:
        for folder, inside in _by_folder(files).items():
            made += file_access.make_folders(folder)
            sets.append(_FileSet(folder, inside))
            sets[-1].begin()
        # Every folder is prepared before any name changes: if one cannot be written, all stay as
        # they are.
        for one in sets:
            one.prepare()
        with ExitStack() as here:
            # All processes lock in the same order, so that no two wait for each other.
            for one in sorted(sets, key=lambda one: one.folder):
                here.enter_context(file_access.locked_folder(one.folder))
            for one in sets:
                one.keep_old()
            with defer_termination():
                _take_their_places(sets)
    except BaseException as wrong:
        with defer_termination():
            _give_up(sets, made)
        if isinstance(wrong, _Stuck):
            raise wrong.told() from None
        raise
    with defer_termination():
        for one in sets:
            one.end()


@contextmanager
def scratch_folder(folder: FilePath) -> Iterator[FilePath]:
    """A hidden folder in one that is made, for as long as the block lasts; raises OSError."""
    made = file_access.make_folders(folder)
    one = _FileSet(FilePath(os.path.realpath(folder)), {})
    try:
        one.begin()
        one.prepare()
        yield one.inside(NEW)
    except BaseException:
        with defer_termination():
            _give_up([one], made)
        raise
    with defer_termination():
        one.end()


@contextmanager
def new_folder(target: FilePath) -> Iterator[FilePath]:
    """Yield a folder to write into; it becomes `target` if the block ends well, else it is removed.

    Raises OSError; `target` must not exist yet. If the disk neither confirms the name nor allows
    the rename to be undone, the folder stays and a warning is reported.
    """
    with scratch_folder(target.parent) as place:
        new = place / target.name
        new.mkdir()
        yield new
        # The disk has the content and the names inside before the folder appears under its own
        # name.
        for one in (*(one for one in new.rglob("*") if one.is_dir()), new):
            file_access.sync_folder(one)
        with defer_termination():
            new.rename(target)
            try:
                file_access.sync_folder(target.parent)
            except OSError as wrong:
                try:
                    target.rename(new)  # what is told as not written must not be there
                except OSError:
                    reason = wrong.strerror or str(wrong)
                    _report_leftover(_UNCONFIRMED(path=str(target), name=target, reason=reason))
                else:
                    raise


def _give_up(sets: Iterable[_FileSet], made: Iterable[FilePath]) -> None:
    for one in sets:
        one.end()
    for folder in made:
        with suppress(OSError):  # somebody has put something there
            folder.rmdir()


def _by_folder(files: Mapping[FilePath, bytes]) -> dict[FilePath, dict[str, bytes]]:
    """The files of each folder by their names, where links lead to."""
    found: dict[FilePath, dict[str, bytes]] = {}
    for path, data in files.items():
        real = FilePath(os.path.realpath(path))
        inside = found.setdefault(real.parent, {})
        if inside.setdefault(real.name, data) is not data:
            raise OSError(errno.EINVAL, "two files have this one place", str(path))
    return found


def _check_replaceable(target: FilePath) -> os.stat_result | None:
    """Return the status of a file to replace, None without one; raises OSError if it may not be."""
    try:
        facts = target.lstat()
    except FileNotFoundError:
        return None
    if stat.S_ISDIR(facts.st_mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(target))
    if stat.S_ISLNK(facts.st_mode):
        raise OSError(errno.ELOOP, os.strerror(errno.ELOOP), str(target))
    if not stat.S_ISREG(facts.st_mode):
        raise OSError(errno.EINVAL, "it is no plain file", str(target))
    if not facts.st_mode & _WRITABLE:  # whoever asks: to the administrator it is open
        raise PermissionError(errno.EACCES, "it is read-only", str(target))
    return facts


@dataclass(slots=True)
class _FileSet:
    """The files of one folder. placed: those that have taken their places, with their inodes."""

    folder: FilePath
    files: Mapping[str, bytes]
    holding: FilePath | None = None
    lock: int = file_access.NO_LOCK
    placed: dict[str, int] = field(default_factory=dict)
    stuck: bool = False

    def begin(self) -> None:
        """Makes the hidden folder; what others have left is seen to before."""
        with file_access.locked_folder(self.folder) as locked:
            _recover_folder(self.folder, locked)
            with defer_termination():
                self.holding = FilePath(tempfile.mkdtemp(prefix=_HOLDING, dir=self.folder))
                # Held until the end: it shows other processes that this write is in progress.
                lock = file_access.take_lock(self.holding)
                self.lock = file_access.NO_LOCK if lock is None else lock

    def prepare(self) -> None:
        """Writes the new files, with the permissions of those that they replace."""
        new = self.inside(NEW)
        new.mkdir()
        for name, data in self.files.items():
            facts = _check_replaceable(self.folder / name)
            file_access.write_new(new / name, data)
            if facts is not None:
                _copy_permissions(new / name, facts)

    def keep_old(self) -> None:
        """Links the old files aside, and says what is to be replaced."""
        old = self.inside(_OLD)
        old.mkdir()
        kept = [name for name in self.files if _link_aside(self.folder / name, old / name)]
        if len(self.files) == 1:
            return  # one file takes its place at once, there is nothing to be put back
        rows = {
            name: {"old": name in kept, "new": hashlib.sha256(data).hexdigest()}
            for name, data in self.files.items()
        }
        # First the old files, then the note, then the names of both: no note without its old files.
        file_access.sync_folder(old)
        file_access.write_new(self.inside(READY), json.dumps(rows).encode())
        file_access.sync_folder(self.inside(""))
        file_access.sync_folder(self.folder)

    def place(self) -> None:
        for name in self.files:
            new = self.inside(NEW) / name
            # The inode shows later whether the file in this place is still this one.
            self.placed[name] = new.stat().st_ino
            new.replace(self.folder / name)
        file_access.sync_folder(self.folder)

    def put_back(self) -> None:
        """Raises Stuck if that cannot be."""
        failed: dict[str, OSError] = {}
        _mark_for_recovery(self.inside(""))
        for name, inode in reversed(self.placed.items()):
            target, old = self.folder / name, self.inside(_OLD) / name
            try:
                if not target.exists() or target.stat().st_ino != inode:
                    continue  # it was not replaced, or somebody else has written it since
                if old.exists():
                    old.replace(target)
                else:
                    target.unlink()
            except OSError as wrong:
                failed[name] = wrong
        if failed:
            self.stuck = True
            raise _Stuck(next(iter(failed.values())), failed, self.inside(""))
        with suppress(OSError):
            file_access.sync_folder(self.folder)

    def end(self) -> None:
        """Remove the hidden folder, unless it has the only copy of a file."""
        if self.holding is not None and not self.stuck:
            _remove_holding_folder(self.holding, self.lock)
        else:
            file_access.free_lock(self.lock)
        self.holding, self.lock = None, file_access.NO_LOCK

    def inside(self, part: str) -> FilePath:
        assert self.holding is not None
        return self.holding / part


def _take_their_places(sets: Iterable[_FileSet]) -> None:
    """All new files, or none of them; raises OSError."""
    begun: list[_FileSet] = []
    try:
        for one in sets:
            begun.append(one)
            one.place()
    except BaseException:
        stuck: _Stuck | None = None
        for one in reversed(begun):
            try:
                one.put_back()
            except _Stuck as wrong:
                stuck = wrong
        if stuck is not None:
            raise stuck from None
        raise


def _link_aside(target: FilePath, aside: FilePath) -> bool:
    """Give the old file a second name, or copy it; returns False without an old file."""
    try:
        os.link(target, aside)
    except FileNotFoundError:
        return False
    except OSError:
        # The file system has no hard links, or the file is on another one.
        file_access.write_new(aside, target.read_bytes())
        _copy_permissions(aside, target.stat())
    return True


def _copy_permissions(file: FilePath, facts: os.stat_result) -> None:
    """Gives a file the permissions of another and, where that is allowed, its owner."""
    own = file.stat()
    if (own.st_uid, own.st_gid) != (facts.st_uid, facts.st_gid) and hasattr(os, "chown"):
        # Only an administrator may change the owner of a file.
        with suppress(PermissionError):
            os.chown(file, facts.st_uid, facts.st_gid)
    file.chmod(stat.S_IMODE(facts.st_mode))


def _name_as_given(wrong: OSError, files: Mapping[FilePath, bytes]) -> FilePath | str | None:
    """The file or folder that an error is about, as the user names it; None for one of ours."""
    named = str(wrong.filename or "")
    if not named or _HOLDING in named:
        return None
    for path in files:
        for one in (path, path.parent):
            if os.path.realpath(one) == named:
                return one
    return named
