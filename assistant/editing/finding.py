"""Findings with the places that they stand at."""

from __future__ import annotations

from assistant.base.diagnostics import Diagnostic, Span
from assistant.editing.answers import Found
from assistant.editing.places import Place, Range
from assistant.editing.workspace import Document


def findings(document: Document, *, whole: bool) -> tuple[Found, ...]:
    """In the order of the lines."""
    found, settled = document.workspace.found(document, whole=whole)
    placed = [found_at(document, one, settled=settled) for one in found]
    return tuple(sorted(placed, key=_text_order))


def _text_order(one: Found) -> tuple[int, int, str]:
    return one.range.start.line, one.range.start.column, one.diagnostic.code


def found_at(document: Document, finding: Diagnostic, *, settled: bool) -> Found:
    return Found(finding, _finding_range(document, finding), settled)


def _finding_range(document: Document, finding: Diagnostic) -> Range:
    """Line and column where they are known: offsets of a program of several texts count on."""
    lines = document.lines
    if finding.line is None:
        return _line_range(document, 0)
    line = min(max(finding.line - 1, 0), len(lines) - 1)
    if finding.column is None:
        return _line_range(document, line)
    if lines.narrow and finding.end_column is not None and finding.end_line == finding.line:
        most = lines.length(line)
        start_column = min(finding.column - 1, most)
        end_column = max(min(finding.end_column - 1, most), start_column)
        return Range(Place(line, start_column), Place(line, end_column))
    start = lines.starts[line] + min(finding.column - 1, len(lines.line(line)))
    last = min(max((finding.end_line or finding.line) - 1, line), len(lines) - 1)
    end = start + 1
    if finding.end_column is not None:
        end = lines.starts[last] + min(finding.end_column - 1, len(lines.line(last)))
    return lines.range(Span(start, max(end, start)))


def _line_range(document: Document, line: int) -> Range:
    lines = document.lines
    text = lines.line(line)
    start = lines.starts[line]
    begin = len(text) - len(text.lstrip())
    return lines.range(Span(start + begin, start + max(len(text.rstrip()), begin)))
