"""Where words and rows stand in a text of lines."""

from __future__ import annotations

import re
from dataclasses import dataclass

from assistant.base.diagnostics import Span


@dataclass(frozen=True, slots=True)
class LineFormat:
    """How the lines of a language are cut.

    begin: what may stand in front of what a line says, such as its number. token: a string, a
    comment, or any other character. comments: how comments begin, in lower case. longest:
    characters of a line that are looked at.
    """

    begin: re.Pattern[str]
    token: re.Pattern[str]
    comments: tuple[str, ...]
    longest: int = 1000

    def word(self, text: str, span: Span, word: str) -> Span | None:
        """Where a word first stands in a span: not in a string or comment, in any case.

        Blanks inside of it stand for any blanks.
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
        """What of the first line of a span says something: without number, comment, line end."""
        start = self.start(text, span)
        end = last = start
        for token in self.token.finditer(text, start, min(span.end, start + self.longest)):
            if last != start and "\n" in text[last : token.start()]:
                break
            last = token.end()
            if not token.group().lower().startswith(self.comments):
                end = token.end()
        return Span(start, end if end > start else max(last, start))

    def start(self, text: str, span: Span) -> int:
        """Where what a line says begins; the line itself if it says nothing."""
        found = self.begin.match(text, span.start, span.end)
        at = found.end() if found else span.start
        return at if at < span.end and not text[at : at + 1].isspace() else span.start


def _is_whole(text: str, start: int, end: int) -> bool:
    """Whether a range of a text is not a part of a longer name or number."""
    before, after = text[start - 1 : start], text[end : end + 1]
    if text[start].isalnum() and (before.isalnum() or before == "_"):
        return False
    return not (text[end - 1].isalnum() and (after.isalnum() or after == "_"))


def row_span(text: str, span: Span, row: int, name: str = "", *, last: bool = False) -> Span:
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
