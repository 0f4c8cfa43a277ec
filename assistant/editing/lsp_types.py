"""Conversion of the editing service's answers into types of the Language Server Protocol 3.17.

Semantic tokens are encoded as five numbers a word, line and column relative to the word before.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Final

import numpy as np
from lsprotocol import types as lsp

from assistant.base.diagnostics import Severity
from assistant.editing.answers import MARKS, Change, Completion, Fix, Found, OutlineItem, Tokens
from assistant.editing.text_lines import Place, Range
from assistant.findings.rulebook import PAGES

_SOURCE: Final = "robot-assistant"
_SEVERITIES: Final = {
    Severity.ERROR: lsp.DiagnosticSeverity.Error,
    Severity.WARNING: lsp.DiagnosticSeverity.Warning,
    Severity.INFO: lsp.DiagnosticSeverity.Information,
}
_SORTS: Final = {
    "comment": "comment", "keyword": "keyword", "type": "type", "variable": "variable",
    "parameter": "parameter", "function": "function", "procedure": "method",
    "instruction": "macro", "target": "enumMember", "number": "number", "string": "string",
    "operator": "operator", "label": "event", "property": "property",
}  # fmt: skip
"""Sorts of words by those that every editor has colours for."""
_MARKS: Final = {
    "declaration": "declaration",
    "readonly": "readonly",
    "predefined": "defaultLibrary",
}
LEGEND: Final = lsp.SemanticTokensLegend(list(_SORTS.values()), [_MARKS[mark] for mark in MARKS])
_COMPLETIONS: Final = {
    "keyword": lsp.CompletionItemKind.Keyword,
    "type": lsp.CompletionItemKind.Struct,
    "variable": lsp.CompletionItemKind.Variable,
    "parameter": lsp.CompletionItemKind.Variable,
    "function": lsp.CompletionItemKind.Function,
    "procedure": lsp.CompletionItemKind.Method,
    "instruction": lsp.CompletionItemKind.Function,
    "target": lsp.CompletionItemKind.EnumMember,
    "label": lsp.CompletionItemKind.Event,
    "property": lsp.CompletionItemKind.Property,
    "snippet": lsp.CompletionItemKind.Snippet,
    "value": lsp.CompletionItemKind.Value,
}
_OUTLINE: Final = {
    "program": lsp.SymbolKind.Module,
    "module": lsp.SymbolKind.Module,
    "procedure": lsp.SymbolKind.Method,
    "function": lsp.SymbolKind.Function,
    "interrupt": lsp.SymbolKind.Event,
    "record": lsp.SymbolKind.Struct,
    "type": lsp.SymbolKind.Struct,
    "variable": lsp.SymbolKind.Variable,
    "constant": lsp.SymbolKind.Constant,
    "target": lsp.SymbolKind.EnumMember,
    "label": lsp.SymbolKind.Key,
    "step": lsp.SymbolKind.Key,
}


def position(place: Place) -> lsp.Position:
    return lsp.Position(place.line, place.column)


def range_of(range: Range) -> lsp.Range:
    return lsp.Range(position(range.start), position(range.end))


def place_of(position: lsp.Position) -> Place:
    return Place(position.line, position.character)


def our_range(range: lsp.Range) -> Range:
    return Range(place_of(range.start), place_of(range.end))


def diagnostic(found: Found) -> lsp.Diagnostic:
    one = found.diagnostic
    about = f"{one.place}: " if one.place else ""
    cure = f"\n{one.cure}" if one.cure else ""
    return lsp.Diagnostic(
        range_of(found.range),
        f"{about}{one.message}{cure}",
        severity=_SEVERITIES[one.severity],
        code=one.code,
        code_description=lsp.CodeDescription(f"{PAGES}#{one.code.lower()}"),
        source=_SOURCE,
    )


def edits(changes: Iterable[Change]) -> list[lsp.TextEdit]:
    return [lsp.TextEdit(range_of(one.range), one.text) for one in changes]


def action(
    fix: Fix, changes: Mapping[str, Sequence[lsp.TextEdit]], told: lsp.Diagnostic
) -> lsp.CodeAction:
    """changes: of the fix, by the address of each file."""
    return lsp.CodeAction(
        fix.title,
        kind=lsp.CodeActionKind.QuickFix,
        diagnostics=[told],
        is_preferred=fix.preferred,
        edit=lsp.WorkspaceEdit(changes=dict(changes)),
    )


def completion(one: Completion) -> lsp.CompletionItem:
    return lsp.CompletionItem(
        one.label,
        kind=_COMPLETIONS[one.kind],
        detail=one.detail or None,
        documentation=lsp.MarkupContent(lsp.MarkupKind.Markdown, one.about) if one.about else None,
        sort_text=f"{one.rank:05d}",
        filter_text=one.label,
        text_edit=lsp.TextEdit(range_of(one.range), one.text),
    )


def symbol(item: OutlineItem) -> lsp.DocumentSymbol:
    return lsp.DocumentSymbol(
        item.name,
        _OUTLINE[item.kind],
        range_of(item.range),
        range_of(item.selection),
        detail=item.detail or None,
        children=[symbol(one) for one in item.children],
    )


def encoded(tokens: Tokens) -> list[int]:
    """Five numbers a word, line and column counted from the word before."""
    if not len(tokens):
        return []
    lines = np.diff(tokens.line, prepend=0)
    columns = np.where(lines == 0, np.diff(tokens.column, prepend=0), tokens.column)
    rows = np.stack([lines, columns, tokens.length, tokens.sort, tokens.marks], axis=1)
    return [int(number) for number in rows.ravel().tolist()]


def delta(before: Sequence[int], after: Sequence[int]) -> list[lsp.SemanticTokensEdit]:
    """One edit that makes the one row of numbers of the other, none if they are the same."""
    start, most = 0, min(len(before), len(after))
    while start < most and before[start] == after[start]:
        start += 1
    end = 0
    while end < most - start and before[-1 - end] == after[-1 - end]:
        end += 1
    if start == len(before) == len(after):
        return []
    made = list(after[start : len(after) - end])
    return [lsp.SemanticTokensEdit(start, len(before) - start - end, made)]
