"""Colours without a server: TextMate grammars, made of the words of a language."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from typing import Any, Final

from assistant.editing.speaking import LanguageAdapter
from assistant.program.editor_support import Editable

_SCOPES: Final = {
    "keyword": "keyword.control",
    "type": "storage.type",
    "instruction": "support.function.instruction",
    "function": "support.function",
    "variable": "variable.language",
    "target": "variable.language",
}
"""Sorts of known words by what colour themes know."""


def textmate_grammar(spoken: LanguageAdapter, id: str) -> dict[str, Any]:
    """The grammar of a language as VS Code and others read it. id: of the language there."""
    editable = spoken.editable
    assert editable is not None
    patterns = [
        {"name": f"{name}.{id}", "match": match} for name, match in _plain_patterns(editable)
    ]
    return {
        "name": spoken.title,
        "scopeName": textmate_scope(id),
        "patterns": patterns,
    }


def textmate_scope(id: str) -> str:
    return f"source.{id}"


def _plain_patterns(editable: Editable) -> Iterator[tuple[str, str]]:
    yield from editable.colours().items()
    sorts: dict[str, list[str]] = {}
    for known in editable.known().values():
        sorts.setdefault(_SCOPES[known.sort], []).append(known.name)
    case = "(?i)" if editable.folds else ""
    for name in dict.fromkeys(_SCOPES.values()):
        if sorts.get(name):
            yield name, f"{case}{_words_pattern(sorts[name])}"
    yield "keyword.operator", r"<>|<=|>=|:=|[-+*/=<>]"


def _words_pattern(words: Iterable[str]) -> str:
    """One of some words, whole; the longest first, as one may begin another."""
    listed = sorted({*words}, key=lambda word: (-len(word), word))
    spelled = (r"\s+".join(map(re.escape, word.split())) for word in listed)
    return rf"(?<![A-Za-z0-9_])(?:{'|'.join(spelled)})(?![A-Za-z0-9_])"
