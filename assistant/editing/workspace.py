"""Open documents, which stand for their files, and the tasks and project that they belong to."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import field
from functools import cached_property
from itertools import islice
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any, Final

from assistant.base.budgets import internal_error, without_gc
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused, Unreadable
from assistant.base.source_text import SourceText, decode, read_bytes
from assistant.compiler.arms import InCell, open_cell
from assistant.compiler.program_files import tasks_of
from assistant.editing.answers import Change
from assistant.editing.excerpts import Excerpt, Structure, excerpt, newline_of, structure
from assistant.editing.language_adapter import LanguageAdapter, adapter_of, language_name
from assistant.editing.live_findings import Seen, Unseen, Watch
from assistant.editing.text_lines import Lines
from assistant.findings.severities import apply_severities
from assistant.program.editor_support import LineFacts
from assistant.project.project_file import project_of
from assistant.project.source_options import SourceOptions, completed_options

if TYPE_CHECKING:
    from assistant.robots import Robot

_MOST_FILES: Final = 200
"""Files of a task that are read beside an open one."""
_Stamps = tuple[tuple[str, int], ...]
"""Files with the times of their last change."""
MOST_ENTRIES: Final = 5000
"""Largest number of names in a folder that are examined."""
_LONGEST: Final = 4_000_000
"""Largest number of characters of a document that is checked while it is typed; a longer one has no
findings.
"""


@dataclass(frozen=True, eq=False)
class Document:
    """One state of a text. path: of its file, or any other name. version: as the editor counts.

    language: its name, `pseudo` for the pseudo-program, empty for what is no program.
    """

    path: str
    text: str
    version: int
    language: str
    workspace: Workspace = field(repr=False)

    @cached_property
    def lines(self) -> Lines:
        return Lines(self.text)

    @property
    def spoken(self) -> LanguageAdapter | None:
        return adapter_of(self.language)

    @cached_property
    def facts(self) -> list[LineFacts]:
        """Return the facts of each line; empty lines for a language without line facts."""
        speaks = self.spoken
        lines = self.lines
        said = [lines.line(number) for number in range(len(lines))]
        if speaks is None or speaks.remembered is None:
            return [LineFacts() for _ in said]
        return speaks.remembered.all(said)

    @cached_property
    def made_of(self) -> Structure:
        speaks = self.spoken
        editable = None if speaks is None else speaks.editable
        return structure(self.facts, str if editable is None else editable.folded)

    @property
    def source(self) -> SourceText:
        return source_of(self.text, self.path)

    def declared(self, names: frozenset[str]) -> Excerpt:
        """Nothing but what declares some names, and what that needs."""
        return excerpt(self.text, self.lines.starts, self.facts, self.made_of, (), needed=names)


def source_of(text: str, path: str) -> SourceText:
    return SourceText(text, path, "utf-8", newline_of(text))


class Workspace:
    """The documents that are open, by path.

    root: folder of the project, whose `assistant.toml` says robot, cell and severities; None takes
    the one above each file.
    """

    def __init__(self, root: FilePath | None = None) -> None:
        self.root = root
        self.documents: dict[str, Document] = {}
        self.lock: Final = threading.RLock()
        self._watches: dict[str, Watch] = {}
        self._warm: set[str] = set()
        self.apart: Callable[[Document, Unseen], Seen | None] | None = None
        """Looks at whole programs elsewhere; None for what it cannot."""
        self._groups: dict[FilePath, tuple[_Stamps, Mapping[str, tuple[str, ...]]]] = {}
        self._files: dict[str, tuple[tuple[int, int], Document]] = {}

    def open(self, path: str, text: str, version: int = 0, language: str = "") -> Document:
        """Use a document's text instead of its file's.

        language: a name of `assistant.languages` or `pseudo`; found from suffix and text if empty.
        """
        with self.lock:
            name = language if adapter_of(language) is not None else language_name(path, text)
            self._forget_others(path)
            self._watches.pop(path, None)
            made = Document(path, text, version, name, self)
            self.documents[path] = made
            return made

    def change(self, path: str, changes: Sequence[Change] | str, version: int) -> Document:
        """Makes changes one after the other, or takes a whole text; raises KeyError if not open."""
        with self.lock:
            document = self.documents[path]
            text = document.text if not isinstance(changes, str) else changes
            lines = document.lines
            for change in () if isinstance(changes, str) else changes:
                lines = lines if lines.text is text else Lines(text)
                span = lines.span(change.range)
                text = text[: span.start] + change.text + text[span.end :]
            name = document.language or language_name(path, text)
            made = Document(path, text, version, name, self)
            self.documents[path] = made
            return made

    def close(self, path: str) -> None:
        """The document's file counts again."""
        with self.lock:
            self.documents.pop(path, None)
            self._watches.pop(path, None)
            self._forget_others(path)

    def saved(self, path: str) -> None:
        """A file changed on the disk: what was known of its task is asked anew."""
        with self.lock:
            self._files.pop(path, None)
            for watch in self._watches.values():
                watch.forget()

    def current(self, document: Document) -> Document:
        """The open state of a document; itself if it is not open."""
        return self.documents.get(document.path, document)

    # ------------------------------------------------------------------------------- tasks

    def task(self, document: Document) -> tuple[Document, ...]:
        """The document, and the other files of its program: open ones as they are open."""
        others = (self.document(path) for path in self._beside(document))
        return (document, *(one for one in others if one is not None))

    def document(self, path: str) -> Document | None:
        """The open document of that path, else its file's; None for what cannot be read."""
        if path in self.documents:
            return self.documents[path]
        try:
            stat = FilePath(path).stat()
            known = self._files.get(path)
            stamp = stat.st_mtime_ns, stat.st_size
            if known is not None and known[0] == stamp:
                return known[1]
            data = read_bytes(path, most=_LONGEST)
            text = _decoded(data, path)
        except (OSError, ValueError):
            return None
        made = Document(path, text, 0, language_name(path, text), self)
        self._files[path] = stamp, made
        return made

    def _beside(self, document: Document) -> list[str]:
        """Other files of the same task, where a language loads several into one."""
        speaks = document.spoken
        if speaks is None:
            return []
        path = FilePath(document.path)
        try:
            room = speaks.program_of(path.absolute())
            if room == path.absolute() or not room.is_dir():
                return []
            there = sorted(_of_room(room, speaks))[:_MOST_FILES]
            stamps = tuple((str(one), one.stat().st_mtime_ns) for one in there)
        except (OSError, ValueError):
            return []
        known_group = self._groups.get(room)
        if known_group is None or known_group[0] != stamps:
            known_group = stamps, _grouped([name for name, _ in stamps])
            self._groups[room] = known_group
        group = known_group[1].get(str(path.absolute()), ())
        known = {str(FilePath(name).absolute()): name for name in self.documents}
        listed = (known.get(one, one) for one in group)
        return [one for one in listed if one != document.path]

    # ---------------------------------------------------------------------------- findings

    def found(self, document: Document, *, whole: bool) -> tuple[tuple[Diagnostic, ...], bool]:
        """Findings of a document, and whether they are of the whole program."""
        speaks = document.spoken
        if speaks is None or len(document.text) > _LONGEST:
            return (), True
        if speaks.remembered is None:
            return self._guarded(lambda: self._whole(document, document.text)), True
        if whole:
            self._settle(document, speaks)
        with self.lock, without_gc():
            watch = self._watch(document, speaks)
            found = self._guarded(lambda: watch.findings(document.text))
            return found, watch.is_settled(document.text)

    def is_known(self, document: Document) -> bool:
        """True if the document's complete program was checked, possibly in another state."""
        watch = self._watches.get(document.path)
        return watch is not None and watch.is_known

    def seen(self, document: Document, unseen: Unseen) -> Seen:
        """Looks at the whole of an open document."""
        speaks = document.spoken
        assert speaks is not None
        try:
            return self._watch(document, speaks).look(unseen)
        except (OSError, MemoryError):
            raise
        except Exception as error:  # noqa: BLE001 - told as a finding
            found = error.findings if isinstance(error, Refused) else (internal_error(error),)
            return Seen(unseen.text, found)

    def _settle(self, document: Document, speaks: LanguageAdapter) -> None:
        """Looks at the whole; keys are answered meanwhile."""
        with self.lock:
            watch = self._watch(document, speaks)
            unseen, last = watch.unseen(document.text), watch.last
        if unseen is None:
            return
        done = self.apart(document, unseen) if self.apart is not None else None
        done = self.seen(document, unseen) if done is None else done
        if done.text is None:
            return
        state, found = watch.state_of(done.text), done.findings
        state.prepare()
        if speaks.name not in self._warm:
            self._warm.add(speaks.name)
            with suppress(Exception):
                speaks.warm(document.text)
        with self.lock:
            if self._watches.get(document.path) is watch:
                watch.settle(state, found, last)

    def tried(self, document: Document, text: str) -> tuple[Diagnostic, ...] | None:
        """Return the findings that a document would have with another text; None if they cannot be
        found.
        """
        speaks = document.spoken
        if speaks is None or speaks.remembered is None:
            return None
        with self.lock:
            watch = self._watch(document, speaks)
            watch.findings(document.text)
            return self._guarded(lambda: watch.tried(text))

    def _watch(self, document: Document, speaks: LanguageAdapter) -> Watch:
        watch = self._watches.get(document.path)
        if watch is None:
            assert speaks.remembered is not None

            def quick(part: Excerpt) -> Any:
                return self._quick(document, speaks, part)

            def whole(text: str) -> Sequence[Diagnostic]:
                return self._whole(document, text)

            watch = self._watches[document.path] = Watch(speaks.remembered, quick, whole)
        return watch

    def _quick(self, document: Document, speaks: LanguageAdapter, part: Excerpt) -> Any:
        _, *others = self.task(document)
        texts = [one.declared(part.names).source(one.path) for one in others]
        syntax, found = speaks.quick(part.source(document.path), texts)
        whole = source_of(part.whole, document.path)  # a comment may ignore what stands elsewhere
        return syntax, self._settled(document, speaks, whole, found)

    def _settled(
        self,
        document: Document,
        speaks: LanguageAdapter,
        source: SourceText,
        found: Sequence[Diagnostic],
    ) -> tuple[Diagnostic, ...]:
        from assistant.compiler.checker import CheckedText

        text = CheckedText(source, speaks.mark, complete=False)
        placed = [one.within(document.path) for one in found]
        left = apply_severities(placed, {document.path: text}).left
        return tuple(one for one in left if one.path == document.path)

    def _whole(self, document: Document, text: str) -> tuple[Diagnostic, ...]:
        """Return the findings of `robot-assistant check` for a document with this text."""
        speaks = document.spoken
        assert speaks is not None
        _, *others = self.task(document)
        texts = [source_of(one.text, one.path) for one in others]
        stands, given, said = self._stated(document)
        checked = speaks.whole(source_of(text, document.path), texts, **given, cell=stands)
        left = apply_severities(checked.findings, checked.texts).left
        here = (one for one in left if one.path in (document.path, None))
        return tuple(dict.fromkeys((*said, *(one.within(document.path) for one in here))))

    def _stated(self, document: Document) -> tuple[InCell, dict[str, Any], tuple[Diagnostic, ...]]:
        """Cell and robot of the project, what else it says, and what is wrong with it."""
        try:
            given = completed_options(document.path, SourceOptions(), ("robot", "process", "cell"))
            stands = open_cell(given.cell, given.robot)
        except Refused as refused:
            return InCell(), {}, tuple(one.within(document.path) for one in refused.findings[:1])
        process = {} if given.process is None else {"process": given.process}
        return stands, process, tuple(one for one in stands.findings if one.path == document.path)

    def stands(self, document: Document) -> InCell:
        """Cell and robot of the project; neither where that is wrong."""
        return self._stated(document)[0]

    def robot(self, document: Document) -> Robot | None:
        """The robot of a document: its project says which, for it or for all of its programs."""
        from assistant.compiler.arms import robot_of

        stands = self.stands(document)
        if stands.robot is not None:
            return stands.robot
        try:
            project = project_of(self.root or FilePath(document.path).absolute().parent)
            named = {recipe.robot for recipe in project.programs.values()} - {None}
            return robot_of(named.pop()) if len(named) == 1 else None
        except (Refused, OSError):
            return None

    def _guarded(self, look: Any) -> tuple[Diagnostic, ...]:
        """Return a refusal or a failure as a finding too, so that the editor continues."""
        try:
            found: tuple[Diagnostic, ...] = look()
        except Refused as refused:
            return tuple(refused.findings)
        except (OSError, MemoryError):
            raise
        except Exception as error:  # noqa: BLE001 - told as a finding
            return (internal_error(error),)
        return found

    def _forget_others(self, path: str) -> None:
        for other, watch in self._watches.items():
            if other != path:
                watch.forget()


def _of_room(room: FilePath, speaks: LanguageAdapter) -> Iterator[FilePath]:
    """The files of one program: of a folder, and of folders in it that are parts of one."""
    for one in islice(room.iterdir(), MOST_ENTRIES):
        if one.suffix.lower() in speaks.suffixes and speaks.program_of(one) == room:
            yield one
        elif not one.suffix and speaks.program_of(one / f"any{speaks.suffixes[0]}") == room:
            inner = islice(one.iterdir(), MOST_ENTRIES) if one.is_dir() else ()
            yield from (two for two in inner if two.suffix.lower() in speaks.suffixes)


def _grouped(files: Sequence[str]) -> Mapping[str, tuple[str, ...]]:
    """The other files of the task that each file is of."""
    found: dict[str, tuple[str, ...]] = {}
    for task in tasks_of(files) if len(files) > 1 else ():
        for file in task.files:
            found.setdefault(file, tuple(other for other in task.files if other != file))
    return found


def _decoded(data: bytes, path: str) -> str:
    """The text of a file, in the encoding of its language, else in one that takes all bytes."""
    from assistant import languages

    language = languages.of_file(path, data)
    try:
        if language is not None:
            return language.decode(data, path).text
    except Unreadable:
        pass
    return decode(data, path, ("utf-8-sig", "utf-8", "latin-1")).text
