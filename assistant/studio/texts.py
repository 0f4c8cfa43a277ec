"""Texts that are open in windows, each window with a workspace of the language service."""

from __future__ import annotations

import hashlib
import threading
from collections.abc import Sequence
from dataclasses import field, replace
from pathlib import Path as FilePath
from typing import Final

from assistant import languages
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Refused
from assistant.base.file_access import read_file
from assistant.base.file_sets import write_all
from assistant.base.source_text import SourceText, decode, encode, is_file, read_bytes
from assistant.editing.checker import Checker
from assistant.editing.service import Change, Document, Workspace
from assistant.editing.text_lines import LINE_END
from assistant.studio import rules
from assistant.studio.route_answers import not_asked
from assistant.studio.studio import Studio

KIND: Final = "texts"
"""Kind of the texts in the live table."""
_ENCODINGS: Final = ("utf-8-sig", "utf-8")
"""Encodings of texts that are not in a controller's language."""
_LONGEST: Final = 8_000_000
"""Bytes of a text that is opened."""
_SAVING: Final = threading.Lock()
"""Lock held from the check of a file until it is written."""
_GONE: Final = ""
"""Stamp of a file that is not there."""


@dataclass(slots=True, eq=False)
class Desk:
    """The texts of one window; nobody sees what another one has not saved.

    read: how each was read, by its path.
    """

    workspace: Workspace
    read: dict[str, SourceText] = field(default_factory=dict)

    def open(self, path: FilePath, name: str) -> tuple[Document, str]:
        """A file's text and the stamp of its bytes; raises Unreadable. name: that people know."""
        data = read_bytes(path, allow_empty=True, most=_LONGEST)
        source = read_text(data, name)
        self.read[str(path)] = source
        return self.workspace.open(str(path), source.text), stamp(data)

    def document(self, path: FilePath) -> Document:
        """The open state; raises Refused if it is not open."""
        found = self.workspace.documents.get(str(path))
        if found is None:
            raise not_asked(f"`{path.name}` is not open")
        return found

    def change(self, path: FilePath, changes: Sequence[Change], version: int) -> Document:
        """Each change names places of the text that the ones before it leave."""
        self.document(path)
        newline = self.read[str(path)].newline
        ended = [replace(one, text=LINE_END.sub(newline, one.text)) for one in changes]
        return self.workspace.change(str(path), ended, version)

    def save(self, path: FilePath, name: str, text: str, known: str) -> str:
        """Writes a text whose lines end in line feeds, and gives its stamp.

        known: stamp of the file that it stands for. Raises Refused, and writes nothing, where the
        file is another one by now.
        """
        with _SAVING:
            return self._saved(path, name, text, known)

    def _saved(self, path: FilePath, name: str, text: str, known: str) -> str:
        now = stamp_of(path)
        if now != known:
            rule = rules.GONE if now == _GONE else rules.CHANGED
            raise Refused(rule(path=name, name=name), exit_status=2)
        before = self.read.get(str(path))
        if before is None:
            raise not_asked(f"`{name}` is not open")
        data = encode(replace(before, text=self._ended(path, text, before.newline), path=name))
        write_all({path: data})
        self.workspace.saved(str(path))
        return stamp(data)

    def _ended(self, path: FilePath, text: str, newline: str) -> str:
        """Lines that nobody changed keep their own ends."""
        document = self.workspace.documents.get(str(path))
        if document is not None and LINE_END.sub("\n", document.text) == text:
            return document.text
        return text.replace("\n", newline)


@dataclass(slots=True, eq=False)
class _Desks:
    """Those of all windows, by their names. checker: looks at whole programs for all of them."""

    checker: Checker = field(default_factory=Checker)
    _of: dict[str, Desk] = field(default_factory=dict)
    _lock: threading.Lock = field(default_factory=threading.Lock)

    def of(self, studio: Studio, window: str) -> Desk:
        """That of a window; those of windows that are gone go with it."""
        with self._lock:
            if window not in self._of:
                for other in [one for one in self._of if not studio.windows.has(one)]:
                    del self._of[other]
                workspace = Workspace(studio.folder)
                workspace.apart = self.checker.look
                self._of[window] = Desk(workspace)
            return self._of[window]

    def end(self) -> None:
        """Ends the process of the checker."""
        self.checker.close()


def desk(studio: Studio, window: str) -> Desk:
    """The texts of a window; raises Refused for one that is not open."""
    if not studio.windows.has(window):
        raise not_asked("this window has no line")
    desks = studio.live.setdefault(KIND, _Desks())
    assert isinstance(desks, _Desks)
    return desks.of(studio, window)


def open_text(studio: Studio, window: str, path: str) -> str:
    """Return a file's text, from the window if it is open there; raise Refused."""
    file = studio.file(path)
    if studio.windows.has(window):
        document = desk(studio, window).workspace.documents.get(str(file))
        if document is not None:
            return document.text
    return read_text(read_bytes(file, most=_LONGEST), str(file)).text


def read_text(data: bytes, path: str) -> SourceText:
    """Bytes as the language of the file has them; raises Unreadable."""
    language = languages.of_file(path, data)
    if language is not None:
        return language.decode(data, path)
    return decode(data, path, _ENCODINGS)


def stamp(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()


def stamp_of(path: FilePath) -> str:
    """Return the stamp of a file; that of a missing file if it cannot be read any more."""
    if not is_file(path):
        return _GONE
    try:
        return stamp(read_file(path, _LONGEST))
    except FileNotFoundError:
        return _GONE
