"""A document in its standard layout, as changes of lines, and in another language.

A translation lists lines of the source beside the lines that they became.
"""

from __future__ import annotations

from assistant import languages
from assistant.base.diagnostics import Refused
from assistant.compiler.loader import language_of
from assistant.editing.answers import Change, Found, Pair, Translation
from assistant.editing.document_findings import found_at
from assistant.editing.language_adapter import PSEUDO
from assistant.editing.text_lines import Lines, Place, Range, hunks
from assistant.editing.workspace import Document


def formatted(document: Document) -> tuple[Change, ...]:
    """See `service.formatted`."""
    speaks = document.spoken
    if speaks is None:
        return ()
    text = speaks.laid_out(document.source)
    return () if text == document.text else _changes_to(document.lines, text)


def _changes_to(lines: Lines, text: str) -> tuple[Change, ...]:
    """Return the changes that turn these lines into another text, complete lines at a time."""
    new = Lines(text)
    before, after = _ended(lines), _ended(new)
    found = []
    for hunk in hunks(before, after):
        start = _place(lines, hunk.first)
        end = _place(lines, hunk.last)
        found.append(Change(Range(start, end), "".join(after[hunk.new_first : hunk.new_last])))
    return tuple(found)


def _ended(lines: Lines) -> list[str]:
    ends = [*lines.starts[1:], len(lines.text)]
    return [lines.text[a:b] for a, b in zip(lines.starts, ends, strict=True)]


def _place(lines: Lines, line: int) -> Place:
    return Place(line, 0) if line < len(lines) else lines.place(len(lines.text))


def translation(document: Document, language: str) -> Translation:
    """See `service.translation`."""
    if language != PSEUDO:
        language_of(language)
    speaks = document.spoken
    if speaks is None:
        return Translation(language)
    workspace = document.workspace
    _, *others = workspace.task(document)
    try:
        done = speaks.translated(
            document.source, [one.source for one in others], language, workspace.stands(document)
        )
    except Refused as refused:
        return Translation(language, findings=_translation_findings(document, refused.findings))
    files = {name: _decoded(language, data, name) for name, data in done.files.items()}
    path = next(iter(files), "")
    pairs = tuple(
        Pair(
            tuple(range(first - 1, last)),
            tuple(sorted({line - 1 for line in went})),
            path if went else "",
            level,
        )
        for first, last, level, went in done.rows
    )
    return Translation(
        language, files, pairs, _translation_findings(document, done.findings), done.draft
    )


def _translation_findings(document: Document, findings: object) -> tuple[Found, ...]:
    assert isinstance(findings, tuple | list)
    here = [one for one in findings if one.path in (document.path, None)]
    return tuple(dict.fromkeys(found_at(document, one, settled=True) for one in here))


def _decoded(language: str, data: bytes, name: str) -> str:
    if language == PSEUDO:
        return data.decode()
    return languages.get(language).decode(data, name).text
