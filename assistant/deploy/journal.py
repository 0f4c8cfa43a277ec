"""A deployment on paper: all that is needed to finish it or to take it back, whoever died.

A folder of its own in the history of this computer:

    record.json     what the controller will have (see `record`)
    programs.json   the programs of it, and the files that hold them
    before/…        what the controller had of each, byte for byte
    after/…         what it is to have
    journal.jsonl   what was done, a line a step

All but the last are written before the first byte goes to the controller, and never change. A
controller with a disk gets the same in one archive, for another computer to go on with.
"""

from __future__ import annotations

import enum
import io
import json
import os
import re
import shutil
import tempfile
import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path as FilePath
from typing import Final

from assistant.controllers import Address
from assistant.deploy import rules
from assistant.deploy.held import Held
from assistant.deploy.record import Record, read_record
from assistant.program.diagnostics import Refused

HISTORY: Final = FilePath(".robot-assistant") / "deployments"
"""Beside the project, one folder a controller in it."""
RECORD: Final = "record.json"
PROGRAMS: Final = "programs.json"
STEPS: Final = "journal.jsonl"
NUMBER: Final = re.compile(r"\d{4,}")
PARTS: Final = ("before", "after")
KEPT: Final = re.compile(r"(before|after)/\d+-[\w. ~-]{1,80}", re.ASCII)
"""A file of a program in the folder; the number is that of its entry."""
MOST_BYTES: Final = 256 * 2**20
"""Of an archive from a controller, unpacked."""


class Step(enum.StrEnum):
    """What a line of a journal says."""

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


ENDED: Final = (Step.DONE, Step.TAKEN_BACK)


@dataclass(frozen=True, slots=True)
class Entry:
    """A program of a deployment, before and after it."""

    name: str
    before: Held
    after: Held


@dataclass(frozen=True, slots=True)
class Journal:
    """A deployment in the history. folder: where it stands."""

    folder: FilePath
    record: Record
    entries: tuple[Entry, ...]

    @property
    def number(self) -> int:
        return int(self.folder.name)

    def steps(self) -> list[tuple[Step, str]]:
        """What was done so far, each with the program that it was done to."""
        found: list[tuple[Step, str]] = []
        try:
            text = (self.folder / STEPS).read_text("utf-8")
        except FileNotFoundError:
            return found
        for line in text.splitlines():
            try:
                row = json.loads(line)
                found.append((Step(row["step"]), str(row.get("program", ""))))
            except (ValueError, KeyError, TypeError, AttributeError):
                break  # the line that was being written when the power went
        return found

    @property
    def last(self) -> Step:
        steps = self.steps()
        return steps[-1][0] if steps else Step.BEGUN

    @property
    def open(self) -> bool:
        """Whether it was neither finished nor taken back."""
        return self.last not in ENDED

    @property
    def result(self) -> str:
        """What became of it, in a word or two."""
        return "interrupted" if self.open else str(self.last)

    def add(self, step: Step, program: str = "") -> None:
        """One more line, on the disk before this returns; raises Refused."""
        row = {"time": datetime.now(UTC).isoformat(), "step": step}
        if program:
            row["program"] = program
        try:
            with (self.folder / STEPS).open("a", encoding="utf-8") as file:
                file.write(json.dumps(row) + "\n")
                file.flush()
                os.fsync(file.fileno())
        except OSError as error:
            raise _refused(self.folder, error) from None

    def packed(self) -> bytes:
        """The folder without its steps, as an archive."""
        data = io.BytesIO()
        with zipfile.ZipFile(data, "w") as archive:
            for file in sorted(self.folder.rglob("*")):
                if file.is_file() and file.name != STEPS:
                    name = file.relative_to(self.folder).as_posix()
                    archive.writestr(zipfile.ZipInfo(name), file.read_bytes(), zipfile.ZIP_DEFLATED)
        return data.getvalue()


def place_of(address: Address, history: str | FilePath | None = None) -> FilePath:
    """The folder of a controller in a history, None for the default one."""
    return (FilePath(history) if history is not None else HISTORY) / address.label


def create(place: FilePath, record: Record, entries: Sequence[Entry]) -> Journal:
    """Writes a new numbered folder, which appears whole; raises Refused."""
    try:
        place.mkdir(parents=True, exist_ok=True)
        new = FilePath(tempfile.mkdtemp(prefix=".new", dir=place))
        try:
            _write(new / RECORD, record.written())
            rows = [
                {"name": entry.name, **_written(new, number, entry)}
                for number, entry in enumerate(entries, 1)
            ]
            _write(new / PROGRAMS, (json.dumps(rows, indent=2) + "\n").encode())
            new.chmod(0o755)
            folder = _numbered(new, place)
        finally:
            shutil.rmtree(new, ignore_errors=True)
    except OSError as error:
        raise _refused(place, error) from None
    journal = Journal(folder, record, tuple(entries))
    journal.add(Step.BEGUN)
    return journal


def read_journal(folder: FilePath) -> Journal:
    """A deployment of a history; raises Refused if it is damaged."""
    try:
        record = read_record((folder / RECORD).read_bytes(), str(folder / RECORD))
        rows = json.loads((folder / PROGRAMS).read_bytes())
        entries = tuple(
            Entry(str(row["name"]), *(_held(folder, row[part]) for part in PARTS)) for row in rows
        )
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise _refused(folder, error) from None
    return Journal(folder, record, entries)


def journals(place: FilePath) -> tuple[Journal, ...]:
    """The deployments to a controller, the oldest first; raises Refused."""
    if not place.is_dir():
        return ()
    folders = [entry for entry in place.iterdir() if NUMBER.fullmatch(entry.name)]
    return tuple(read_journal(folder) for folder in sorted(folders, key=lambda f: int(f.name)))


def all_journals(history: str | FilePath | None = None) -> tuple[Journal, ...]:
    """The deployments to all controllers of a history, the oldest of each first."""
    root = FilePath(history) if history is not None else HISTORY
    places = sorted(root.iterdir()) if root.is_dir() else []
    return tuple(journal for place in places for journal in journals(place))


def archived(data: bytes) -> tuple[Entry, ...]:
    """The programs of a journal that a controller kept; raises Refused. Nothing stays here."""
    with tempfile.TemporaryDirectory() as folder:
        return unpack(data, FilePath(folder)).entries


def unpack(data: bytes, place: FilePath) -> Journal:
    """A journal that a controller kept, in a new numbered folder; raises Refused."""
    try:
        place.mkdir(parents=True, exist_ok=True)
        new = FilePath(tempfile.mkdtemp(prefix=".new", dir=place))
        try:
            with zipfile.ZipFile(io.BytesIO(data)) as archive:
                if sum(info.file_size for info in archive.infolist()) > MOST_BYTES:
                    raise ValueError("it is too long")
                for info in archive.infolist():
                    if info.filename in (RECORD, PROGRAMS) or KEPT.fullmatch(info.filename):
                        (new / info.filename).parent.mkdir(exist_ok=True)
                        _write(new / info.filename, archive.read(info))
            read_journal(new)
            new.chmod(0o755)
            folder = _numbered(new, place)
        finally:
            shutil.rmtree(new, ignore_errors=True)
    except (OSError, ValueError, zipfile.BadZipFile, NotImplementedError, RuntimeError) as error:
        raise _refused(place, error) from None
    return read_journal(folder)


def _written(folder: FilePath, number: int, entry: Entry) -> dict[str, Mapping[str, str | None]]:
    """Writes the bytes of a program; in which file each part of it stands."""
    rows: dict[str, Mapping[str, str | None]] = {}
    for part, held in zip(PARTS, (entry.before, entry.after), strict=True):
        names: dict[str, str | None] = {}
        for kind, data in (("file", held.file), ("loaded", held.loaded)):
            file = f"{number}-{entry.name}" + (".loaded" if kind == "loaded" else "")
            names[kind] = None if data is None else f"{part}/{file}"
            if data is not None:
                (folder / part).mkdir(exist_ok=True)
                _write(folder / part / file, data)
        rows[part] = names
    return rows


def _held(folder: FilePath, names: Mapping[str, str | None]) -> Held:
    def data(name: str | None) -> bytes | None:
        if name is None:
            return None
        if KEPT.fullmatch(name) is None:
            raise ValueError(f"`{name}` is no file of it")
        return (folder / name).read_bytes()

    return Held(data(names["file"]), data(names["loaded"]))


def _numbered(new: FilePath, place: FilePath) -> FilePath:
    """Gives a folder that is whole the next number; two runs at once get two."""
    numbers = [int(entry.name) for entry in place.iterdir() if NUMBER.fullmatch(entry.name)]
    number = max(numbers, default=0) + 1
    while True:
        folder = place / f"{number:04}"
        try:
            folder.mkdir()  # takes the number; a folder renamed onto an empty one replaces it
            if os.name == "nt":
                folder.rmdir()
            return new.rename(folder)
        except FileExistsError:
            number += 1


def _write(path: FilePath, data: bytes) -> None:
    with path.open("xb") as file:
        file.write(data)
        file.flush()
        os.fsync(file.fileno())


def _refused(place: FilePath, error: Exception) -> Refused:
    reason = getattr(error, "strerror", None) or str(error) or type(error).__name__
    return Refused(rules.NO_HISTORY(folder=place, reason=reason, path=str(place)))
