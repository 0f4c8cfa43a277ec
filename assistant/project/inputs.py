"""What a program was made of: the files that were opened meanwhile, and their digests."""

from __future__ import annotations

import hashlib
import os
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path as FilePath
from typing import Final

from assistant.base.file_access import read_file

Digests = Mapping[str, str | None]
"""File or folder (with a `/` at its end), from the project's folder → SHA-256 of its bytes or of
the names of its files but for reports; None for one that is not there.
"""

PROGRAM_FOLDERS: Final = (".py", ".pyc", ".so", ".pyd", ".dll")
"""Of this program itself, where its environment is in the project's folder."""
REPORT_FILES: Final = (".html", ".log", ".md", ".sarif", ".xml")
"""Of what pipelines write beside the sources, such as a plan: no program is looked for in them."""
WRITE_FLAGS: Final = os.O_WRONLY | os.O_RDWR


@contextmanager
def recorded_inputs(folder: FilePath) -> Iterator[set[str]]:
    """Fills a set with the files below a folder that are read inside, folders that are listed too.

    Hidden ones are left out, and so is Python. One at a time in a process.
    """
    _add_audit_hook()
    root, found = folder.resolve(), set[str]()
    seen: list[tuple[str, bool]] = []
    _recorders.append(seen)
    try:
        yield found
    finally:
        _recorders.remove(seen)
        for path, is_folder in seen:
            name = _source_name(root, FilePath(path))
            if name is not None:
                found.add(f"{name}/" if is_folder else name)


def digests(folder: FilePath, names: set[str]) -> dict[str, str | None]:
    """Of files and folders as they are now, sorted by name."""
    return {name: _digest(folder, name) for name in sorted(names)}


def all_unchanged(folder: FilePath, known: Digests) -> bool:
    """Whether all of them are as they were."""
    return all(_digest(folder, name) == digest for name, digest in known.items())


def digest_of(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()


def _digest(folder: FilePath, name: str) -> str | None:
    path = folder / name
    try:
        if name.endswith("/"):
            names = sorted(one.name for one in path.iterdir() if one.is_file())
            plain = (
                n for n in names if not n.startswith(".") and not n.lower().endswith(REPORT_FILES)
            )
            return digest_of("\0".join(plain).encode("utf-8", "surrogateescape"))
        return digest_of(read_file(path))
    except OSError:
        return None


def _source_name(root: FilePath, path: FilePath) -> str | None:
    """The name from the folder, None for what is no source in it."""
    try:
        inside = path.resolve().relative_to(root)
    except (ValueError, OSError, RuntimeError):
        return None
    hidden = any(part.startswith(".") for part in inside.parts)
    return None if hidden or path.suffix.lower() in PROGRAM_FOLDERS else inside.as_posix()


_recorders: Final[list[list[tuple[str, bool]]]] = []
_AUDITED: Final[list[bool]] = []


def _add_audit_hook() -> None:
    if not _AUDITED:
        _AUDITED.append(True)
        sys.addaudithook(_on_audit_event)


def _on_audit_event(event: str, arguments: tuple[object, ...]) -> None:
    """Events `open`, `os.listdir` and `os.scandir` of Python's table of audit events."""
    if not _recorders or event not in ("open", "os.listdir", "os.scandir"):
        return
    path = arguments[0]
    if not isinstance(path, str | bytes | os.PathLike):
        return  # a descriptor that was opened before
    is_folder = event != "open"
    if is_folder or not (isinstance(arguments[2], int) and arguments[2] & WRITE_FLAGS):
        name = os.fsdecode(path)
        for seen in _recorders:
            seen.append((str(FilePath(name).absolute()), is_folder))
