"""What one studio works on: a folder, and what is open while its windows are."""

from __future__ import annotations

import os
import threading
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path as FilePath
from typing import TYPE_CHECKING

from assistant.base.diagnostics import Diagnostic, Refused
from assistant.base.source_text import is_file
from assistant.studio import rules
from assistant.studio.windows import Windows

if TYPE_CHECKING:
    from assistant.compiler.comparison import Comparison

UNLISTED_FOLDERS = frozenset({".git", ".robot-assistant", ".venv", "__pycache__", "node_modules"})
"""Folders that are not looked into."""


@dataclass(slots=True)
class Studio:
    """folder: of the project, absolute. windows: that are open, one of which writes.

    live: what runs or is connected to while windows are open, by its kind. leaving: what was live
    and is being ended. left_on: why motors may still be on that nobody has control of. beginning:
    held by whoever puts something there in place of another, so that of two none is left without
    an end. comparison: of the programs that were compared last.
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
        """Where a file of the project is or would be; raises Refused for one outside of it."""
        from assistant.project.layout import path_inside

        found = path_inside(self.folder, name)
        if found is None or UNLISTED_FOLDERS & set(found.relative_to(self.folder).parts):
            raise Refused(rules.OUTSIDE(name=name))
        return found

    def named(self, file: FilePath) -> str:
        """A file as the page calls it: from the folder, with slashes."""
        path = file.absolute()
        return path.relative_to(self.folder).as_posix() if path.is_relative_to(self.folder) else ""

    def go_to(self, folder: FilePath) -> None:
        """Works on another folder from now on; raises Refused if there is none."""
        there = self.folder_at(folder)
        os.chdir(there)  # commands take the project of the working folder
        self.folder = FilePath.cwd()

    def folder_at(self, folder: FilePath) -> FilePath:
        """A folder, absolute; raises Refused if there is none."""
        there = folder.absolute()
        if not there.is_dir():
            raise Refused(rules.NO_FOLDER(name=folder), exit_status=2)
        return there

    def end(self) -> None:
        """Ends whatever runs or is connected to, and waits for what somebody else ends."""
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
