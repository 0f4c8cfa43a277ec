"""The state of one studio: its folder, the windows that are open, and the files of its project.

The oldest window writes; the others only look. Files are listed with their kinds by suffix, without
hidden ones and without links that lead out of the folder.
"""

from __future__ import annotations

import os
import secrets
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import field
from pathlib import Path as FilePath
from pathlib import PurePosixPath
from typing import TYPE_CHECKING, Any, Final

from assistant import languages, sources
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused
from assistant.base.source_text import is_file
from assistant.program import pseudo
from assistant.sources import PROCESS_SUFFIX
from assistant.sources.process.placement import DRAWING_SUFFIXES
from assistant.studio import rules

if TYPE_CHECKING:
    from assistant.compiler.comparison import Comparison


Notify = Callable[[Mapping[str, object]], None]
"""Tells a window something; may be called from any thread."""


@dataclass(slots=True, eq=False)
class Windows:
    """Those that are open, the oldest first: that one writes until it is closed."""

    _open: dict[str, Notify] = field(default_factory=dict)
    _lock: threading.Lock = field(default_factory=threading.Lock)

    def opened(self, tell: Notify) -> str:
        """Return a name for a new window, which cannot be guessed."""
        name = secrets.token_urlsafe(16)
        with self._lock:
            self._open[name] = tell
        self._tell_who()
        return name

    def closed(self, name: str, over: Callable[[bool], None]) -> None:
        """Close a window; the oldest of the others writes from now on.

        over: receives True if this one wrote, before another one does; it must not call this
        object.
        """
        with self._lock:
            wrote = self._writer() == name
            self._open.pop(name, None)
            over(wrote)
        if wrote:
            self._tell_who()

    def writes(self, name: str) -> bool:
        with self._lock:
            writer = self._writer()
        return writer is not None and secrets.compare_digest(writer.encode(), name.encode())

    def has(self, name: str) -> bool:
        """True if a window of that name is open."""
        with self._lock:
            return name in self._open

    def tell(self, message: Mapping[str, object]) -> None:
        """Tells all windows."""
        with self._lock:
            every = tuple(self._open.values())
        for tell in every:
            tell(message)

    def tell_one(self, name: str, message: Mapping[str, object]) -> None:
        """Tells a window, if it is still open."""
        with self._lock:
            tell = self._open.get(name)
        if tell is not None:
            tell(message)

    def _tell_who(self) -> None:
        with self._lock:
            writer, every = self._writer(), dict(self._open)
        for name, tell in every.items():
            tell({"kind": "window", "name": name, "writes": name == writer})

    def _writer(self) -> str | None:
        return next(iter(self._open), None)


_UNLISTED_FOLDERS = frozenset({".git", ".robot-assistant", ".venv", "__pycache__", "node_modules"})
"""Folders that are not looked into."""


@dataclass(slots=True)
class Studio:
    """State of the studio.

    folder: of the project, absolute. windows: that are open, one of which writes. live: runs and
    connections while windows are open, by kind. leaving: those being ended. left_on: why motors may
    still be on that no user controls. beginning: lock for replacing one, so that of two each is
    ended. comparison: of the programs that were compared last.
    """

    folder: FilePath
    windows: Windows = field(default_factory=Windows)
    live: dict[str, object] = field(default_factory=dict)
    leaving: tuple[object, ...] = ()
    left_on: tuple[Diagnostic, ...] = ()
    beginning: threading.RLock = field(default_factory=threading.RLock, repr=False)
    comparison: Comparison | None = None
    _taking: threading.Lock = field(default_factory=threading.Lock, repr=False)

    def file(self, name: str) -> FilePath:
        """A file of the project that is there; raises Refused."""
        found = self.place(name)
        if not is_file(found):
            raise Refused(rules.GONE(path=name, name=name))
        return found

    def place(self, name: str) -> FilePath:
        """Return the path of a file of the project, existing or not; raise Refused for one outside
        of it.
        """
        from assistant.project.project_file import path_inside

        found = path_inside(self.folder, name)
        if found is None or _UNLISTED_FOLDERS & set(found.relative_to(self.folder).parts):
            raise Refused(rules.OUTSIDE(name=name))
        return found

    def named(self, file: FilePath) -> str:
        """A file as the page calls it: from the folder, with slashes."""
        path = file.absolute()
        return path.relative_to(self.folder).as_posix() if path.is_relative_to(self.folder) else ""

    def go_to(self, folder: FilePath) -> None:
        """Switch to another folder; raise Refused for a missing one."""
        there = self.folder_at(folder)
        os.chdir(there)  # commands take the project of the working folder
        self.folder = FilePath.cwd()

    def folder_at(self, folder: FilePath) -> FilePath:
        """Return the folder as an absolute path; raise Refused for a missing one."""
        there = folder.absolute()
        if not there.is_dir():
            raise Refused(rules.NO_FOLDER(name=folder), exit_status=2)
        return there

    def end(self) -> None:
        """End all runs and connections, and wait for those that others are ending."""
        self.drop(*reversed(list(self.live)))

    def drop(self, *names: str) -> None:
        """Ends some of them, in this order; none of them is live any more before the first ends."""
        self.finish(self.taken_off(*names))

    def taken_off(self, *names: str) -> Sequence[object]:
        """Some of them, live no more, behind what is still being ended: `finish` ends them all."""
        with self._taking:
            found = (self.live.pop(name, None) for name in names)
            self.leaving = (*self.leaving, *(one for one in found if one is not None))
            return self.leaving

    def finish(self, leaving: Sequence[object]) -> None:
        """Ends what was taken off, in this order, whatever goes wrong with those before."""
        try:
            with ExitStack() as ending:
                for one in reversed(leaving):
                    end = getattr(one, "end", None)
                    if end is not None:
                        ending.callback(end)
        finally:
            with self._taking:
                self.leaving = tuple(one for one in self.leaving if one not in leaving)


MOST_FILES: Final = 5_000
"""That are listed."""
SUFFIX_KINDS: Final[Mapping[str, str]] = {
    **dict.fromkeys(DRAWING_SUFFIXES, "drawing"),
    **dict.fromkeys((".stl", ".obj", ".glb", ".gltf"), "shape"),
    **dict.fromkeys((".png", ".jpg", ".jpeg", ".svg"), "picture"),
    ".toml": "settings",
    ".csv": "table",
}
"""File kind by suffix, except programs."""


def file_tree(folder: FilePath) -> list[dict[str, Any]]:
    """Files with their kinds, in the order of their names."""
    suffixes = program_suffixes()
    return [
        {"path": path, "kind": _file_kind(path, suffixes), "size": size}
        for path, (_, size) in sorted(file_stamps(folder).items())
    ]


def file_stamps(folder: FilePath) -> dict[str, tuple[int, int]]:
    """When each file was changed, in ns, and how many bytes it has."""
    found: dict[str, tuple[int, int]] = {}
    for path, entry in _listed_files(folder):
        try:
            facts = entry.stat()
        except OSError:
            continue  # it has just gone
        found[path] = (facts.st_mtime_ns, facts.st_size)
        if len(found) >= MOST_FILES:
            break
    return found


def program_suffixes() -> frozenset[str]:
    """Suffixes of programs, in lower case."""
    theirs = (s for name in languages.names() for s in languages.get(name).suffixes)
    return frozenset({pseudo.SUFFIX, *(suffix.lower() for suffix in theirs)})


def _file_kind(path: str, suffixes: frozenset[str]) -> str:
    """drawing, process, program, table, settings, … or file."""
    name = PurePosixPath(path).name.lower()
    suffix = PurePosixPath(name).suffix
    if name.endswith(PROCESS_SUFFIX):
        return "process"
    if name.endswith(".schema.json"):
        return "settings"
    if name == "assistant.toml":
        return "project"
    if suffix in suffixes:
        return "program"
    return SUFFIX_KINDS.get(suffix, "table" if suffix in sources.READERS else "file")


def _listed_files(folder: FilePath) -> Iterator[tuple[str, os.DirEntry[str]]]:
    """Without what is hidden, and without links that lead elsewhere."""
    waiting = [(folder, "")]
    while waiting:
        here, before = waiting.pop()
        try:
            with os.scandir(here) as entries:
                listed = sorted(entries, key=lambda one: one.name)
        except OSError:
            continue  # it may not be read, or has gone
        for entry in listed:
            if entry.name in _UNLISTED_FOLDERS or entry.name.startswith(".") or entry.is_symlink():
                continue
            path = f"{before}{entry.name}"
            if entry.is_dir(follow_symlinks=False):
                waiting.append((here / entry.name, f"{path}/"))
            elif entry.is_file(follow_symlinks=False):
                yield path, entry
