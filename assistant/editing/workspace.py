"""Open documents, which stand for their files, and the tasks and project that they belong to."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path as FilePath

from assistant.editing.answers import Change
from assistant.editing.places import Lines


@dataclass(frozen=True, slots=True, eq=False)
class Document:
    """One state of a text. path: of its file, or any other name. version: as the editor counts.

    language: its name, `pseudo` for the pseudo-program, empty for what is no program.
    """

    path: str
    text: str
    version: int
    language: str
    workspace: Workspace = field(repr=False)
    lines: Lines = field(repr=False)


class Workspace:
    """The documents that are open, by path.

    root: folder of the project, whose `assistant.toml` says robot, cell and severities; None takes
    the one above each file.
    """

    def __init__(self, root: FilePath | None = None) -> None:
        self.root = root
        self.documents: dict[str, Document] = {}

    def open(self, path: str, text: str, version: int = 0, language: str = "") -> Document:
        """Takes a document's text instead of its file's.

        language: a name of `assistant.languages` or `pseudo`; told by suffix and text if empty.
        """
        raise NotImplementedError

    def change(self, path: str, changes: Sequence[Change] | str, version: int) -> Document:
        """Makes changes one after the other, or takes a whole text; raises KeyError if not open."""
        raise NotImplementedError

    def close(self, path: str) -> None:
        """The document's file counts again."""

    def saved(self, path: str) -> None:
        """A file changed on the disk: what was known of its task is asked anew."""
