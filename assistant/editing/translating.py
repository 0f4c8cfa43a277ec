"""A document in another language, its lines beside what they became."""

from __future__ import annotations

from assistant import languages
from assistant.base.diagnostics import Refused
from assistant.compiler.loading import language_of
from assistant.editing.answers import Found, Pair, Translation
from assistant.editing.finding import found_at
from assistant.editing.speaking import PSEUDO
from assistant.editing.workspace import Document


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
