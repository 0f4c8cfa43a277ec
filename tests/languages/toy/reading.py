"""Text to tree: each line by the grammar; one that does not fit is kept as its text."""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import cache
from typing import Final

from lark import Lark, UnexpectedToken

from assistant.base.diagnostics import Diagnostic, Span
from assistant.base.source_text import SourceText, dominant_newline

from . import tables
from .tree import File, Line

VALUES: Final = {"NUMBER": float, "BIT": int}
"""Terminal → what its text becomes; names stay texts."""


@cache
def grammar() -> Lark:
    return Lark.open("toy.lark", rel_to=__file__, parser="lalr", start="line")


def parse(source: SourceText | str) -> File:
    """The tree of a file, with a finding for each line that is wrong."""
    if isinstance(source, str):
        source = SourceText(source, None, "utf-8", dominant_newline(source))
    findings = [*source.odd_characters()]
    lines = tuple(_line(source, span, findings) for span in _spans(source.text))
    return File(lines, tuple(findings), source, lines)


def _spans(text: str) -> Iterator[Span]:
    """The lines that are not blank, without the blanks around them."""
    newline = r"\n" if "\n" in text else r"\r"
    return (Span(*found.span()) for found in re.finditer(rf"\S(?:[^{newline}]*\S)?", text))


def _line(source: SourceText, span: Span, findings: list[Diagnostic]) -> Line:
    text = source.text[span.start : span.end]
    try:
        word, *rest = grammar().parse(text).children
    except UnexpectedToken as error:
        found = "" if error.token.type == "$END" else str(error.token)
        said = [tables.EXPECTED.get(one, f"`{one.lower()}`") for one in sorted(error.accepts)]
        start = span.start + error.token.start_pos if found else span.end - 1
        wrong = Span(start, start + max(len(found), 1))
        wanted = "a word of the language" if "WORD" in error.accepts else " or ".join(said)
        fields = {"found": f"`{found}`" if found else "the end of the line", "expected": wanted}
        findings.append(source.finding(tables.UNREAD, wrong, **fields))
        return Line("", (text,), span)
    if word.type == "NOTE":
        return Line("#", (word[1:].strip(),), span)
    values = (VALUES.get(one.type, str.strip)(one) for one in rest)
    return Line(str(word), tuple(values), span)
