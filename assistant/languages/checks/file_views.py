"""Files as checks see them: results remembered from one check to the next, and positions.

`CachedResults` stores what functions work out for a view. `LineView` is the view of a file of a
language with one statement a line: findings at its items, words, names and table rows.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from functools import cached_property
from typing import Any, ClassVar, Protocol, Self, TypeVar, cast

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Rule, Span
from assistant.base.source_text import SourceText, finding_in

T = TypeVar("T")


class CachedResults:
    """Keeps what functions make of an object, for the next rule that asks."""

    def once(self, work: Callable[[Self], T]) -> T:
        """Return the result of a function of this object; compute it at the first request only."""
        if work not in self._worked:
            self._worked[work] = work(self)
        return cast("T", self._worked[work])

    def first(self, what: str, name: str) -> bool:
        """True at the first call with this topic and name, in any case."""
        known = (what, name.lower()) in self._told
        self._told.add((what, name.lower()))
        return not known

    @cached_property
    def _told(self) -> set[tuple[str, str]]:
        return set()

    @cached_property
    def _worked(self) -> dict[Callable[[Any], Any], Any]:
        return {}


def by_type(nodes: Iterable[tuple[object, T]]) -> dict[type, list[T]]:
    """Things by the class of the node that each comes with, in their order."""
    found: dict[type, list[T]] = {}
    for node, thing in nodes:
        found.setdefault(type(node), []).append(thing)
    return found


@dataclass(frozen=True, slots=True)
class LineFormat:
    """How to split the lines of a language.

    begin: what may precede the code of a line, such as its number. token: a string, a comment, or
    any other character. comments: how comments begin, in lower case. longest: number of characters
    of a line that are searched.
    """

    begin: re.Pattern[str]
    token: re.Pattern[str]
    comments: tuple[str, ...]
    longest: int = 1000

    def word(self, text: str, span: Span, word: str) -> Span | None:
        """Return the span of a word's first occurrence in a span: not in a string or comment, in
        any case.

        Blanks inside the word match any blanks.
        """
        low = " ".join(word.split()).lower()
        pattern = re.compile(re.escape(low).replace(r"\ ", r"[ \t]+"), re.IGNORECASE)
        at, end = span.start, min(span.end, span.start + self.longest)
        while at < end:
            token = self.token.search(text, at, end)
            if token is None:
                return None
            found = pattern.match(text, token.start(), end)
            if found and _is_whole(text, found.start(), found.end()):
                return Span(*found.span())
            at = token.end()
            if text[token.start()].isalnum():  # the rest of a name is no name
                while at < end and (text[at].isalnum() or text[at] == "_"):
                    at += 1
        return None

    def said(self, text: str, span: Span) -> Span:
        """Return the span of the code in a span's first line: without number, comment and line
        end.
        """
        start = self.start(text, span)
        end = last = start
        for token in self.token.finditer(text, start, min(span.end, start + self.longest)):
            # Only the first line of an item that takes several.
            if last != start and "\n" in text[last : token.start()]:
                break
            last = token.end()
            if not token.group().lower().startswith(self.comments):
                end = token.end()
        return Span(start, end if end > start else max(last, start))

    def start(self, text: str, span: Span) -> int:
        """Return the offset where the code of a line begins; that of the line itself if it has no
        code.
        """
        found = self.begin.match(text, span.start, span.end)
        at = found.end() if found else span.start
        return at if at < span.end and not text[at : at + 1].isspace() else span.start


def _is_whole(text: str, start: int, end: int) -> bool:
    """True if a range of a text is not part of a longer name or number."""
    before, after = text[start - 1 : start], text[end : end + 1]
    if text[start].isalnum() and (before.isalnum() or before == "_"):
        return False
    return not (text[end - 1].isalnum() and (after.isalnum() or after == "_"))


def _row_span(text: str, span: Span, row: int, name: str = "", *, last: bool = False) -> Span:
    """Span of a line of a table, without its line end.

    With a name: of its first or last occurrence in that line.
    """
    start = span.start
    for _ in range(row):
        start = text.find("\n", start) + 1
    end = text.find("\n", start)
    line = text[start : span.end if end < 0 else end].rstrip()
    names = re.finditer(rf"\b{re.escape(name)}\b", line, re.IGNORECASE) if name else ()
    matches = list(names)
    found = matches[-1 if last else 0] if matches else None
    begin, stop = found.span() if found else (0, len(line))
    return Span(start + begin, start + stop)


class HasSpan(Protocol):
    """Object with a source position."""

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
        """Return the span of a word's first occurrence in an item: not in a string or comment, in
        any case.
        """
        if item.span is None or self.source is None:
            return None
        start = self.cut.start(self.source.text, item.span)
        return self.cut.word(self.source.text, Span(start, item.span.end), word)

    def named(self, item: HasSpan, node: HasSpan, name: str) -> Span | None:
        """Return the span of a node's name in an item; None if the node is from elsewhere."""
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
        return _row_span(self.source.text, table.span, row, name, last=last)
