"""Lines of the text form: what each says, its comment, and where it begins."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from assistant.program.diagnostics import Span
from assistant.program.lines import with_line_feeds
from assistant.program.pseudo.words import split_comment


@dataclass(slots=True)
class CodeLine:
    """A line without comment and outer blanks, and where it begins in the text, as an offset."""

    text: str
    start: int
    comment: str | None

    @property
    def span(self) -> Span:
        return Span(self.start, self.start + len(self.text))


def code_lines(source: str) -> Iterator[CodeLine]:
    """The lines of a text that say anything, with their comments taken apart."""
    start = 0
    for whole in with_line_feeds(source).split("\n"):
        text = whole.lstrip(" \t\f\r\ufeff" if not start else " \t\f\r")
        begin = start + len(whole) - len(text)
        start += len(whole) + 1
        text = text.rstrip("\r")
        if text.startswith("|") or (text.startswith("opaque") and "|" in text):
            yield CodeLine(text, begin, None)  # whatever stands behind `|` is as it is
            continue
        said, comment = split_comment(text)
        said = said.rstrip()
        if said or comment is not None:
            yield CodeLine(said, begin, comment)


def end_of_line(source: str, start: int) -> int:
    """The offset of the end of the line that an offset stands on."""
    end = with_line_feeds(source).find("\n", start)
    return len(source) if end < 0 else end
