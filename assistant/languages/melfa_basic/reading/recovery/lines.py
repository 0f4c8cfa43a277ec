"""Damaged lines as items of the tree."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

from assistant.languages.melfa_basic import rules
from assistant.languages.melfa_basic.reading.driver import Stop
from assistant.languages.melfa_basic.reading.recovery.damaged import mend
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.program.diagnostics import Diagnostic, Span
from assistant.program.text import SourceText

MOST_MENDED: Final = 500
"""Damaged lines of a file that are looked into; a file with more is no program."""


def mended(
    source: SourceText, start: int, stop: int, end: int, why: Stop, before: int
) -> tuple[s.Item, tuple[Diagnostic, ...]]:
    """The item of a damaged line, what it was meant to be if that is known, and its findings.

    start, stop, end: offsets of the line, of its line end, and behind that. why: where it stops
    being MELFA-BASIC. before: findings of the lines before it.
    """
    if before >= MOST_MENDED:
        at = min(why.word.start, max(stop - 1, start))
        word = source.text[at : max(why.word.end, at + 1)].strip()
        what, cure = f"`{word}` cannot stand here", "correct what is found before it first"
        finding = source.finding(rules.SYNTAX, Span(at, at + 1), what=what, cure=cure)
        return s.Unread(source.text[start:stop], Span(start, end)), (finding,)
    node, findings = mend(source, start, stop)
    span = Span(start, end)
    match node:
        case s.Line() | s.Data():
            return replace(node, span=span), findings
        case None:
            return s.Unread(source.text[start:stop], span), findings
