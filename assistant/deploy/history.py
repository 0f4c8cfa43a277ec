"""History of deployments: a journal for each, enough to finish it or to take it back after a crash.

A journal is a numbered folder in the history of this computer:

    record.json     what the controller will have (see `record`)
    earlier.json    the record that it had, if there was one
    programs.json   its programs, and the files that hold them with their SHA-256
    before/…        what the controller had of each, byte for byte
    after/…         what it is to have
    journal.jsonl   what was done, a line a step

All but the last are on the disk before the first byte goes to the controller, and never change. A
controller with a disk gets the same in one archive, so that another computer can go on. Archives
come from outside and are checked before they are unpacked.
"""

from __future__ import annotations

import enum
import errno
import hashlib
import io
import json
import lzma
import re
import shutil
import struct
import tempfile
import zipfile
import zlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import field
from datetime import UTC, datetime
from pathlib import Path as FilePath
from typing import Final

from assistant.base import file_access
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused, has_errors
from assistant.base.file_access import read_file, read_text
from assistant.controllers import Address
from assistant.deploy import rules
from assistant.deploy.record import LONGEST_RECORD, PROGRAM_NAME, Held, Record, read_record
from assistant.deploy.site import RECORD, UNDER_WAY, Site, of_deployments

HISTORY: Final = FilePath(".robot-assistant") / "deployments"
"""Beside the project, one folder a controller in it."""
RECORD_FILE: Final = "record.json"
_EARLIER_FILE: Final = "earlier.json"
_PROGRAMS_FILE: Final = "programs.json"
_STEPS_FILE: Final = "journal.jsonl"
_FOLDER_NUMBER: Final = re.compile(r"\d{4,}")
_PARTS: Final = ("before", "after")
_KEPT_FILE: Final = re.compile(rf"(before|after)/\d{{1,6}}-{PROGRAM_NAME.pattern}", re.ASCII)
"""A file of a program in the folder; the number is that of its entry."""
_UNNUMBERED_PREFIX: Final = ".new"
"""Prefix of a folder's name until it has its number."""


class Step(enum.StrEnum):
    """Step in a line of a journal."""

    NOTHING = "not begun"
    """It has no line: the process died before anything was changed."""

    BEGUN = "begun"
    WRITING = "writing"
    """A program, which is named, is about to be changed."""
    VERIFIED = "verified"
    """It is there and was read back."""
    DONE = "done"
    """All programs are there and the record is kept."""
    TAKING_BACK = "taking back"
    TAKEN_BACK = "taken back"
    """Everything is again what it was before."""
    ELSEWHERE = "ended elsewhere"
    """Another computer ended it, and has deployed since."""


ENDED: Final = (Step.NOTHING, Step.DONE, Step.TAKEN_BACK, Step.ELSEWHERE)


@dataclass(frozen=True, slots=True)
class Entry:
    """A program of a deployment, before and after it."""

    name: str
    before: Held
    after: Held


@dataclass(frozen=True, slots=True)
class Journal:
    """A deployment in the history.

    folder: where it stands. earlier: the record that was on the controller, None for none.
    """

    folder: FilePath
    record: Record
    entries: tuple[Entry, ...]
    earlier: bytes | None = field(default=None, repr=False)

    @property
    def number(self) -> int:
        return int(self.folder.name)

    def steps(self) -> list[tuple[Step, str]]:
        """Return the completed steps, each with its program."""
        return steps_of(self.folder)

    @property
    def last(self) -> Step:
        return last_step(self.folder)

    @property
    def open(self) -> bool:
        """True if it was neither finished nor rolled back."""
        return self.last not in ENDED

    @property
    def result(self) -> str:
        """Result in a word or two."""
        return "interrupted" if self.open else str(self.last)

    def add(self, step: Step, program: str = "") -> None:
        """One more line, on the disk before this returns; raises Refused."""
        row = {"time": datetime.now(UTC).isoformat(), "step": step}
        if program:
            row["program"] = program
        try:
            file_access.add_line(self.folder / _STEPS_FILE, json.dumps(row))
        except OSError as error:
            raise unusable_history(self.folder, error) from None


def place_of(address: Address, history: str | FilePath | None = None) -> FilePath:
    """The folder of a controller in a history, None for the default one."""
    return (FilePath(history) if history is not None else HISTORY) / address.label


def create_journal(
    place: FilePath, record: Record, entries: Sequence[Entry], earlier: bytes | None = None
) -> Journal:
    """Writes a new numbered folder, which appears whole; raises Refused."""

    def fill(new: FilePath) -> None:
        file_access.write_new(new / RECORD_FILE, record.written())
        if earlier is not None:
            file_access.write_new(new / _EARLIER_FILE, earlier)
        rows = [_write_program(new, number, entry) for number, entry in enumerate(entries, 1)]
        file_access.write_new(new / _PROGRAMS_FILE, (json.dumps(rows, indent=2) + "\n").encode())

    journal = Journal(new_folder(place, fill), record, tuple(entries), earlier)
    journal.add(Step.BEGUN)
    return journal


def new_folder(place: FilePath, fill: Callable[[FilePath], None]) -> FilePath:
    """A new numbered folder, which is there when `fill` has written into it; raises Refused.

    Only who holds the lock of the place may call this: what a dead process left is cleared away.
    """
    with report_file_errors(place):
        file_access.make_folders(place)
        # Whoever holds the lock is alone here: unnumbered folders are of dead processes.
        for rest in place.glob(f"{_UNNUMBERED_PREFIX}*"):
            shutil.rmtree(rest, ignore_errors=True)
        new = FilePath(tempfile.mkdtemp(prefix=_UNNUMBERED_PREFIX, dir=place))
        try:
            fill(new)
            # Contents first, then folders: the rename below must never show a half-written journal.
            for folder in (*(new / part for part in _PARTS), new):
                if folder.is_dir():
                    file_access.sync_folder(folder)
            # mkdtemp makes a folder for its owner alone; a history may be shared.
            new.chmod(0o755)
            folder = _numbered(new, place)
            file_access.sync_folder(place)
        finally:
            shutil.rmtree(new, ignore_errors=True)
    return folder


def read_journal(folder: FilePath) -> Journal:
    """A deployment of a history; raises Refused if it is damaged."""
    with report_file_errors(folder):
        record = read_record(read_file(folder / RECORD_FILE), str(folder / RECORD_FILE))
        rows = json.loads(read_file(folder / _PROGRAMS_FILE))
        entries = tuple(_read_entry(folder, row) for row in rows)
        if len({entry.name.lower() for entry in entries}) < len(entries):
            raise ValueError("a program is there twice")
        kept = folder / _EARLIER_FILE
        return Journal(folder, record, entries, read_file(kept) if kept.exists() else None)


def journal_folders(place: FilePath) -> list[FilePath]:
    """Those of the deployments to a controller, the oldest first; raises Refused."""
    with report_file_errors(place):
        if not place.is_dir():
            return []
        found = [entry for entry in place.iterdir() if _FOLDER_NUMBER.fullmatch(entry.name)]
    return sorted(found, key=lambda folder: int(folder.name))


def open_journal(place: FilePath) -> Journal | None:
    """Return the deployment that is neither finished nor rolled back; raises Refused.

    Finished deployments are not read: a damaged one does not block further work.
    """
    for folder in journal_folders(place):
        if last_step(folder) not in ENDED:
            return read_journal(folder)
    return None


def steps_of(folder: FilePath) -> list[tuple[Step, str]]:
    """Return the completed steps of the deployment in a folder; raises Refused."""
    found: list[tuple[Step, str]] = []
    with report_file_errors(folder):
        try:
            text = read_text(folder / _STEPS_FILE, "utf-8", "replace")
        except FileNotFoundError:
            return found
    lines = text.split("\n")
    if len(lines) == 1:  # its first line, which comes before any change, was never finished
        return found
    for line in lines:
        try:
            row = json.loads(line)
            found.append((Step(row["step"]), str(row.get("program", ""))))
        except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
            continue  # it was being written when the power went
    return found


def last_step(folder: FilePath) -> Step:
    """The last step of the deployment of a folder; raises Refused.

    A journal whose whole lines are all damaged counts as begun.
    """
    steps = steps_of(folder)
    if steps:
        return steps[-1][0]
    with report_file_errors(folder):
        file = folder / _STEPS_FILE
        return Step.BEGUN if file.is_file() and b"\n" in read_file(file) else Step.NOTHING


def journals(place: FilePath) -> tuple[Journal, ...]:
    """The deployments to a controller, the oldest first; raises Refused."""
    return tuple(read_journal(folder) for folder in journal_folders(place))


def all_journals(history: str | FilePath | None = None) -> tuple[Journal, ...]:
    """The deployments to all controllers of a history, the oldest of each first."""
    root = FilePath(history) if history is not None else HISTORY
    places = sorted(root.iterdir()) if root.is_dir() else []
    return tuple(journal for place in places for journal in journals(place))


def _write_program(folder: FilePath, number: int, entry: Entry) -> Mapping[str, object]:
    """Writes the bytes of a program; in which file each part of it stands, with its digest."""
    row: dict[str, object] = {"name": entry.name}
    digests: dict[str, str] = {}
    for part, held in zip(_PARTS, (entry.before, entry.after), strict=True):
        names: dict[str, str | None] = {}
        for kind, data in (("file", held.file), ("loaded", held.loaded)):
            file = f"{part}/{number}-{entry.name}" + (".loaded" if kind == "loaded" else "")
            names[kind] = None if data is None else file
            if data is not None:
                (folder / part).mkdir(exist_ok=True)
                file_access.write_new(folder / file, data)
                digests[file] = hashlib.sha256(data).hexdigest()
        row[part] = names
    return {**row, "sha256": digests}


def _read_entry(folder: FilePath, row: Mapping[str, Mapping[str, str | None]]) -> Entry:
    name = row["name"]
    if not isinstance(name, str) or PROGRAM_NAME.fullmatch(name) is None or of_deployments(name):
        raise ValueError(f"`{name}` is no name of a program")
    before, after = (_read_installed(folder, row[part], row["sha256"]) for part in _PARTS)
    return Entry(name, before, after)


def _read_installed(
    folder: FilePath, names: Mapping[str, str | None], digests: Mapping[str, str | None]
) -> Held:
    def data(name: str | None) -> bytes | None:
        if name is None:
            return None
        if _KEPT_FILE.fullmatch(name) is None:
            raise ValueError(f"`{name}` is no file of it")
        found = read_file(folder / name)
        if hashlib.sha256(found).hexdigest() != digests[name]:
            raise ValueError(f"`{name}` is not as it was written")
        return found

    return Held(data(names["file"]), data(names["loaded"]))


def _numbered(new: FilePath, place: FilePath) -> FilePath:
    """Gives a folder that is whole the next number; two runs at once get two."""
    numbers = [int(entry.name) for entry in place.iterdir() if _FOLDER_NUMBER.fullmatch(entry.name)]
    number = max(numbers, default=0) + 1
    while True:
        folder = place / f"{number:04}"
        try:
            return new.rename(folder)
        except OSError as error:  # one that is not empty is never replaced
            if error.errno not in (errno.EEXIST, errno.ENOTEMPTY):
                raise
            number += 1


@contextmanager
def report_file_errors(place: FilePath) -> Iterator[None]:
    """Turns what goes wrong with files, or makes no sense in them, into a finding."""
    try:
        yield
    except Refused as refusal:
        if has_errors(refusal.findings):
            raise
        raise unusable_history(place, refusal) from None
    except (OSError, ValueError, LookupError, TypeError, AttributeError, RecursionError) as error:
        raise unusable_history(place, error) from None


def unusable_history(place: FilePath, error: Exception) -> Refused:
    reason = getattr(error, "strerror", None) or str(error) or type(error).__name__
    return Refused(rules.NO_HISTORY(folder=place, reason=reason, path=str(place)))


MOST_ARCHIVE_BYTES: Final = 256 * 2**20
"""Bytes of an archive, packed and unpacked."""
_MOST_ARCHIVE_FILES: Final = 10_000
_BROKEN_ARCHIVE: Final = (zipfile.BadZipFile, zlib.error, lzma.LZMAError, struct.error, EOFError)
"""Errors of a truncated or forged archive, in addition to ValueError and the like."""
_COMPRESSIONS: Final = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)


def pack_journal(journal: Journal) -> bytes:
    """The folder of a journal without its steps."""
    data = io.BytesIO()
    with zipfile.ZipFile(data, "w") as archive:
        for file in sorted(journal.folder.rglob("*")):
            if file.is_file() and file.name != _STEPS_FILE:
                name = file.relative_to(journal.folder).as_posix()
                # ZipInfo without a time: the same journal gives the same bytes.
                archive.writestr(zipfile.ZipInfo(name), read_file(file), zipfile.ZIP_DEFLATED)
    return data.getvalue()


def unpack_journal(data: bytes, place: FilePath, name: str) -> Journal | None:
    """The journal of a deployment in a new numbered folder, None if it is of another one.

    Raises Refused if it is damaged.
    """
    with report_file_errors(place):
        files = _archive_files(data)
        if read_record(files[RECORD_FILE], RECORD_FILE).name != name:
            return None

        def fill(new: FilePath) -> None:
            _fill_folder(new, files)
            # Read before the folder gets its number: a damaged one never appears in the history.
            read_journal(new)

        return read_journal(new_folder(place, fill))


def archived_programs(data: bytes) -> tuple[Entry, ...]:
    """The programs of a journal that a controller kept; raises Refused. Nothing stays here."""
    with tempfile.TemporaryDirectory() as folder, report_file_errors(FilePath(UNDER_WAY)):
        _fill_folder(FilePath(folder), _archive_files(data))
        return read_journal(FilePath(folder)).entries


def _archive_files(data: bytes) -> dict[str, bytes]:
    """The files of an archive; raises ValueError."""
    try:
        return _journal_files(data)
    except (*_BROKEN_ARCHIVE, NotImplementedError, RuntimeError) as error:
        raise ValueError(f"the archive on the controller is damaged ({error})") from None


def _fill_folder(new: FilePath, files: Mapping[str, bytes]) -> None:
    for path, content in files.items():
        (new / path).parent.mkdir(exist_ok=True)
        file_access.write_new(new / path, content)


def _journal_files(data: bytes) -> dict[str, bytes]:
    """Those of a journal in an archive, by their paths in its folder."""
    if len(data) > MOST_ARCHIVE_BYTES:
        raise ValueError("the archive on the controller is too long")
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        rows = archive.infolist()
        # Stated sizes are checked before anything is unpacked.
        whole = sum(row.file_size for row in rows)
        if whole > MOST_ARCHIVE_BYTES or len(rows) > _MOST_ARCHIVE_FILES:
            raise ValueError("the archive on the controller is too long")
        if any(row.filename == RECORD_FILE and row.file_size > LONGEST_RECORD for row in rows):
            raise ValueError("the record in the archive on the controller is too long")
        wanted = [
            row
            for row in rows
            if row.filename in (RECORD_FILE, _EARLIER_FILE, _PROGRAMS_FILE)
            or _KEPT_FILE.fullmatch(row.filename)
        ]
        if any(row.compress_type not in _COMPRESSIONS for row in wanted):
            raise ValueError("the archive on the controller is packed in a way that is not known")
        if len({row.filename.lower() for row in wanted}) < len(wanted):
            raise ValueError("the archive on the controller has a file twice")
        return {row.filename: archive.read(row) for row in wanted}


def last_record(
    site: Site, history: str | FilePath | None = None
) -> tuple[Record | None, tuple[Diagnostic, ...]]:
    """The record of the last deployment, with findings of one that cannot be trusted.

    That on the controller counts, if it has a disk: others deploy as well. Else the last of the
    history here.
    """
    if site.disk is not None:
        data = site.controller.read(RECORD)
        if data is None:
            return None, ()
        try:
            return read_record(data, RECORD), ()
        except Refused as refused:
            return None, refused.findings
    for folder in reversed(journal_folders(place_of(site.address, history))):
        if last_step(folder) is Step.DONE:
            with report_file_errors(folder):
                return read_record(read_file(folder / RECORD_FILE), str(folder / RECORD_FILE)), ()
    return None, ()


def what_was_left(
    site: Site, record: Record, name: str, history: str | FilePath | None = None
) -> Held | None:
    """Return a program's content after the deployments up to a record, None if not saved.

    It is searched in the local history, and in the archive that the last deployment left on a disk;
    the digests of the record identify it.
    """
    meant = {n.lower(): digests for n, digests in record.programs.items()}.get(name.lower())
    for entry in _earlier_programs(site, history):
        if entry.name.lower() != name.lower() or meant is None:
            continue
        for held in (entry.after, entry.before):
            if site.digests(held, meant.task) == meant:
                return held
    return None


def _earlier_programs(site: Site, history: str | FilePath | None) -> Iterator[Entry]:
    """Programs of earlier deployments, the newest first."""
    for folder in reversed(journal_folders(place_of(site.address, history))):
        with suppress(Refused):  # nor does one that is damaged
            yield from read_journal(folder).entries
    data = site.controller.read(UNDER_WAY) if site.disk is not None else None
    if data is not None:
        with suppress(Refused):  # an archive that is cut or changed tells nothing
            yield from archived_programs(data)
