"""A file of a language of lines, as a rule sees it: findings at its items, words, names, rows."""

from __future__ import annotations

from typing import Any, ClassVar, Protocol

from assistant.base.diagnostics import Diagnostic, Rule, Span
from assistant.base.source_text import SourceText, finding_in
from assistant.languages.checks.places import LineFormat, row_span
from assistant.languages.checks.views import CachedResults


class HasSpan(Protocol):
    """What knows where it stands."""

    @property
    def span(self) -> Span | None: ...


class LineView(CachedResults):
    """cut: how the lines of the language are cut. source: None of what was not read."""

    cut: ClassVar[LineFormat]

    def __init__(self, source: SourceText | None) -> None:
        self.source = source

    def finding(self, rule: Rule, where: HasSpan | Span | None, /, **words: Any) -> Diagnostic:
        """The rule's finding at what an item says, or at a span of the text."""
        span = where if isinstance(where, Span) or where is None else where.span
        if self.source is not None and span is not None and not isinstance(where, Span):
            span = self.cut.said(self.source.text, span)
        return finding_in(self.source, rule, span, **words)

    def word(self, item: HasSpan, word: str) -> Span | None:
        """Where a word first stands in an item: not in a string or comment, in any case."""
        if item.span is None or self.source is None:
            return None
        start = self.cut.start(self.source.text, item.span)
        return self.cut.word(self.source.text, Span(start, item.span.end), word)

    def named(self, item: HasSpan, node: HasSpan, name: str) -> Span | None:
        """Where the name of a node in an item stands; None if it came from elsewhere."""
        if self.source is None or node.span is None or item.span is None:
            return None
        start, end = node.span.start, node.span.start + len(name)
        inside = item.span.start <= start and end <= item.span.end
        same = self.source.text[start:end].upper() == name.upper()
        return Span(start, end) if inside and same else None

    def row(self, table: HasSpan, row: int, name: str = "", *, last: bool = False) -> Span | None:
        """Span of a row of a table, or of the first or last occurrence of a name in it."""
        if self.source is None or table.span is None:
            return None
        return row_span(self.source.text, table.span, row, name, last=last)
