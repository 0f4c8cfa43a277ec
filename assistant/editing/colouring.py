"""The words of a text with their sorts, in columns."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from typing import Final

import numpy as np

from assistant.editing.answers import SORTS, Tokens
from assistant.editing.workspace import Document
from assistant.program.editor_support import Declaration, Editable, KnownWord, LineFacts

_SORT: Final = {name: number for number, name in enumerate(SORTS)}
_PLAIN_SORTS: Final = {
    kind: _SORT[kind]
    for kind in ("comment", "keyword", "number", "string", "operator", "label", "property")
}
_DECLARED_SORTS: Final[Mapping[str, str]] = {
    "procedure": "procedure", "function": "function", "interrupt": "procedure", "record": "type",
    "type": "type", "constant": "variable", "variable": "variable", "target": "target",
    "parameter": "parameter", "label": "label", "step": "label", "module": "type",
    "program": "type",
}  # fmt: skip
DECLARATION, READONLY, PREDEFINED = 1, 2, 4
LineTokens = tuple[tuple[int, ...], tuple[int, ...], tuple[int, ...], tuple[int, ...]]


def tokens(document: Document, first: int, last: int | None) -> Tokens:
    """See `service.tokens`."""
    speaks = document.spoken
    editable = None if speaks is None else speaks.editable
    if editable is None:
        return Tokens(*(np.zeros(0, dtype=np.int32) for _ in range(5)))
    declared: dict[str, int] = {}
    for other in document.workspace.task(document):
        for facts in other.facts:
            for one in facts.declares:
                if not one.implied or one.kind == "label":
                    declared.setdefault(editable.folded(one.name), _packed_sort(one))
    lines = document.lines
    rows: list[tuple[int, int, int, int, int]] = []
    known, narrow = editable.known(), document.text.isascii()
    for number, facts in enumerate(
        document.facts[first : None if last is None else last + 1], first
    ):
        text = "" if narrow else lines.line(number)
        ascii_line = narrow or text.isascii()
        for start, end, sort, marks in _line_tokens(editable, facts, declared, known):
            if not ascii_line:
                start, end = _utf16_column(text, start), _utf16_column(text, end)
            rows.append((number, start, end - start, sort, marks))
    table = np.array(rows, dtype=np.int32).reshape(-1, 5)
    return Tokens(*(np.ascontiguousarray(column) for column in table.T))


@lru_cache(maxsize=1 << 12)
def _utf16_column(text: str, column: int) -> int:
    return len(text[:column].encode("utf-16-le")) // 2


def _packed_sort(one: Declaration) -> int:
    readonly = READONLY if one.fixed or one.kind == "constant" else 0
    return _SORT[_DECLARED_SORTS[one.kind]] << 3 | readonly


def _line_tokens(
    editable: Editable,
    facts: LineFacts,
    declared: Mapping[str, int],
    known: Mapping[str, KnownWord],
) -> list[tuple[int, int, int, int]]:
    here = {one.start: one for one in facts.declares}
    found = []
    for kind, start, end, text in facts.words:
        own = here.get(start)
        if own is not None:
            packed = _packed_sort(own) | DECLARATION
        elif kind != "name":
            packed = _PLAIN_SORTS[kind] << 3
        else:
            key = editable.folded(text)
            packed = declared.get(key, -1)
            if packed < 0:
                packed = _of_known(known.get(key))
        found.append((start, end, packed >> 3, packed & 7))
    return found


def _of_known(known: KnownWord | None) -> int:
    if known is None:
        return _SORT["variable"] << 3
    return _SORT[known.sort] << 3 | PREDEFINED
