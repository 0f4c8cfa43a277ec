"""Answers about texts, from the language service."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import wraps
from pathlib import Path as FilePath
from typing import Any, Final

from assistant import languages
from assistant.base.budgets import freeze_loaded_objects
from assistant.base.data_classes import dataclass
from assistant.editing import service
from assistant.editing.language_adapter import PSEUDO, adapter_of
from assistant.editing.service import (
    SORTS,
    Change,
    Document,
    Fix,
    Found,
    OutlineItem,
    Place,
    Range,
    Tokens,
    Workspace,
)
from assistant.studio.route_answers import Answering, Question, finding_records, not_asked
from assistant.studio.studio import Studio
from assistant.studio.texts import desk, read_text, stamp, stamp_of

MOST: Final = 500
"""Most findings of a text in an answer; a page shows fewer."""
LINES: Final = 400
"""Most lines whose words are sent at once."""
TRANSLATED: Final = 10_000
"""The same of a translation, which nobody scrolls while he types."""
STALE: Final = {"stale": True}
"""Answer about a text that has changed since the question."""
_kept: set[str] = set()


@dataclass(frozen=True, slots=True)
class State:
    """A state of a text that is asked about."""

    studio: Studio
    asked: Question
    document: Document

    @property
    def at(self) -> Place:
        """Position in the text."""
        return _place(self.asked.values.get("at"))


def of_state(does: Callable[[State], dict[str, Any]]) -> Answering:
    """An answer about the state of that number; STALE if the text is in another one by now."""

    @wraps(does)
    def answer(studio: Studio, asked: Question) -> dict[str, Any]:
        found = desk(studio, asked.window).document(studio.place(asked.text("path")))
        current = found.version == asked.number("version")
        return does(State(studio, asked, found)) if current else STALE

    return answer


def open_text(studio: Studio, asked: Question) -> dict[str, Any]:
    """A file's text, its stamp, and what it can be translated to."""
    path = asked.text("path")
    document, known = desk(studio, asked.window).open(studio.file(path), path)
    own = document.spoken
    others = [] if own is None else [name for name in _spoken() if name != document.language]
    return {
        "path": path,
        "text": document.text,
        "stamp": known,
        "language": document.language,
        "title": "" if own is None else own.title,
        "languages": [{"name": name, "title": _title(name)} for name in others],
    }


def close(studio: Studio, asked: Question) -> dict[str, Any]:
    desk(studio, asked.window).workspace.close(str(studio.place(asked.text("path"))))
    return {}


def on_disk(studio: Studio, asked: Question) -> dict[str, Any]:
    """Return the present contents of a file while it is open; its text only if its stamp is new.

    All that was known of its program is determined again.
    """
    path = studio.place(asked.text("path"))
    desk(studio, asked.window).workspace.saved(str(path))
    now = stamp_of(path)
    if not now or now == asked.text("stamp", ""):
        return {"stamp": now}
    data = path.read_bytes()
    return {"stamp": stamp(data), "text": read_text(data, asked.text("path")).text}


def change(studio: Studio, asked: Question) -> dict[str, Any]:
    """Apply typed changes; return findings and the words of the visible lines."""
    path = studio.place(asked.text("path"))
    one, version = desk(studio, asked.window), int(asked.number("version"))
    if "text" in asked.values:
        document = one.workspace.open(str(path), asked.text("text"), version)
    else:
        made = [_change(each) for each in _list(asked, "changes")]
        document = one.change(path, made, version)
    known = one.workspace.is_known(document)
    return {
        "findings": _findings(service.findings(document)) if known else None,
        "words": _words(document, asked),
    }


@of_state
def words(on: State) -> dict[str, Any]:
    """Words of some lines, for their colours."""
    return {"words": _words(on.document, on.asked)}


@of_state
def settled(on: State) -> dict[str, Any]:
    """Findings of the whole program, as `check` has them, and the outline."""
    found = service.settled(on.document)
    if on.document.language not in _kept:
        _kept.add(on.document.language)
        freeze_loaded_objects()
    return {
        "findings": _findings(found),
        "outline": [_item(one) for one in service.outline(on.document)],
    }


@of_state
def fixes(on: State) -> dict[str, Any]:
    """Cures of the findings in some lines that are definite edits."""
    first, last = int(on.asked.number("first")), int(on.asked.number("last"))
    told = []
    for found in service.findings(on.document):
        if first <= found.range.start.line <= last:
            made = [_fix(on.studio, one) for one in service.fixes(on.document, found)]
            told.append({"finding": _finding(found), "fixes": made})
    return {"found": told}


@of_state
def completions(on: State) -> dict[str, Any]:
    found = service.completions(on.document, on.at)
    return {
        "words": [
            {
                "label": one.label,
                "kind": one.kind,
                "text": one.text,
                "detail": one.detail,
                "about": one.about,
                **_range(one.range),
            }
            for one in found
        ]
    }


@of_state
def hover(on: State) -> dict[str, Any]:
    """Markdown without HTML."""
    found = service.hover(on.document, on.at)
    return {} if found is None else {"text": found.text, **_range(found.range)}


@of_state
def definition(on: State) -> dict[str, Any]:
    found = service.definition(on.document, on.at)
    if found is None:
        return {}
    return {"path": _named(on.studio, found.path), **_range(found.range)}


@of_state
def renameable(on: State) -> dict[str, Any]:
    """The name that can be changed, and where it stands."""
    found = service.renameable(on.document, on.at)
    if found is None:
        return {}
    span = on.document.lines.span(found)
    return {"name": on.document.text[span.start : span.end], **_range(found)}


@of_state
def rename(on: State) -> dict[str, Any]:
    """Edits by file; the page makes them, and nothing is written before it is saved."""
    made = service.rename(on.document, on.at, on.asked.text("name"))
    return {"changes": _changes(on.studio, made)}


@of_state
def formatted(on: State) -> dict[str, Any]:
    return {"edits": [_edit(one) for one in service.formatted(on.document)]}


@of_state
def translation(on: State) -> dict[str, Any]:
    """The first file of it, with the lines that each line of the source became."""
    done = service.translation(on.document, on.asked.text("language"))
    name, text = next(iter(done.files.items()), ("", ""))
    return {
        "name": name,
        "others": list(done.files)[1:],
        "text": text,
        "draft": done.draft,
        "words": _words_of(name, text, done.language),
        "pairs": [
            {"source": one.source, "written": one.written, "what": one.what} for one in done.pairs
        ],
        "findings": _findings(done.findings),
    }


def save(studio: Studio, asked: Question) -> dict[str, Any]:
    """Write the file; raise Refused, and write nothing, if others have changed it since."""
    path = asked.text("path")
    one = desk(studio, asked.window)
    known = one.save(studio.place(path), path, asked.text("text"), asked.text("stamp"))
    return {"stamp": known}


# ------------------------------------------------------------------------------ as plain data


def _spoken() -> list[str]:
    return [PSEUDO, *languages.names()]


def _title(name: str) -> str:
    one = adapter_of(name)
    return name if one is None else one.title


def _named(studio: Studio, path: str) -> str:
    """Return the page's name of a file; a file outside of the project keeps its full name."""
    return studio.named(FilePath(path)) or path


def _finding(found: Found) -> dict[str, Any]:
    (said,) = finding_records([found.diagnostic])
    return {**said, **_range(found.range), "settled": found.settled}


def _findings(found: Sequence[Found]) -> list[dict[str, Any]]:
    return [_finding(one) for one in found[:MOST]]


def _fix(studio: Studio, fix: Fix) -> dict[str, Any]:
    changed = _changes(studio, fix.changes)
    return {"title": fix.title, "changes": changed, "preferred": fix.preferred}


def _changes(studio: Studio, changes: Mapping[str, Sequence[Change]]) -> dict[str, Any]:
    return {_named(studio, path): [_edit(one) for one in made] for path, made in changes.items()}


def _edit(change: Change) -> dict[str, Any]:
    return {**_range(change.range), "text": change.text}


def _range(range: Range) -> dict[str, Any]:
    start, end = range.start, range.end
    return {"from": [start.line, start.column], "to": [end.line, end.column]}


def _item(item: OutlineItem) -> dict[str, Any]:
    return {
        "name": item.name,
        "kind": item.kind,
        "detail": item.detail,
        "line": item.selection.start.line,
        "children": [_item(one) for one in item.children],
    }


def _words(document: Document, asked: Question) -> list[list[int | str]]:
    """Line, column, length, sort and marks of each word of some lines."""
    first = int(asked.number("first", 0))
    last = min(int(asked.number("last", first)), first + LINES)
    return _rows(service.tokens(document, first, max(first, last)))


def _words_of(name: str, text: str, language: str) -> list[list[int | str]]:
    document = Workspace().open(name, text, language=language)
    return _rows(service.tokens(document, 0, TRANSLATED))


def _rows(tokens: Tokens) -> list[list[int | str]]:
    columns = (tokens.line, tokens.column, tokens.length, tokens.sort, tokens.marks)
    rows = zip(*(column.tolist() for column in columns), strict=True)
    return [[line, at, length, SORTS[sort], marks] for line, at, length, sort, marks in rows]


def _list(asked: Question, key: str) -> list[Any]:
    value = asked.values.get(key)
    if not isinstance(value, list):
        raise not_asked(f"`{key}` is no list")
    return value


def _change(value: Any) -> Change:
    if not isinstance(value, dict) or not isinstance(value.get("text"), str):
        raise not_asked("a change has no text")
    return Change(Range(_place(value.get("from")), _place(value.get("to"))), value["text"])


def _place(value: Any) -> Place:
    if not isinstance(value, list) or [type(one) for one in value] != [int, int]:
        raise not_asked("a place is no line and column")
    return Place(*value)
