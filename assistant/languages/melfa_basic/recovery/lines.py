"""Damaged lines as items of the tree."""

from __future__ import annotations

from dataclasses import replace

from assistant.languages.melfa_basic import syntax as s
from assistant.languages.melfa_basic.recovery.damaged import mend
from assistant.program.diagnostics import Diagnostic, Span
from assistant.program.text import SourceText


def mended(
    source: SourceText, start: int, stop: int, end: int
) -> tuple[s.Item, tuple[Diagnostic, ...]]:
    """The item of a damaged line, what it was meant to be if that is known, and its findings.

    start, stop, end: offsets of the line, of its line end, and behind that.
    """
    node, findings = mend(source, start, stop)
    span = Span(start, end)
    match node:
        case s.Line() | s.Data():
            return replace(node, span=span), findings
        case None:
            return s.Unread(source.text[start:stop], span), findings
