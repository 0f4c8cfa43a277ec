"""One layout for files of lines: blanks, indentation, comments, tables."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence

from assistant.base.source_text import SourceText, dominant_newline
from assistant.languages.line_blocks import NO_WORD, BlockWord
from assistant.languages.runs.columns import Run
from assistant.languages.texts import changed_lines
from assistant.languages.texts.changed_lines import Parts, parts_of
from assistant.languages.texts.laying_out import INDENT, TAB, LaidOutLine, align_comments
from assistant.languages.texts.lines import LinePrinter


def lay_out(source: SourceText, lines: LinePrinter) -> str:
    """The text of items that were read from a source in the one layout; idempotent.

    Line ends become the ones that most lines have.
    """
    return "".join(_FileLayout(source, lines).pieces())


class _FileLayout:
    """The lines of one file. above, below: indices of the lines of code next to each item."""

    def __init__(self, source: SourceText, lines: LinePrinter) -> None:
        self._lines, self._items = lines, lines.items
        self._text, self._encoding = source.text, source.encoding
        self._newline = dominant_newline(source.text)
        self._said = list(map(lines.line, lines.items))
        places = range(len(lines.items))
        self._above = dict(self._next_to(places))
        self._below = dict(self._next_to(reversed(places)))

    def _next_to(self, places: Iterable[int]) -> Iterator[tuple[int, int | None]]:
        """Each place with the last line of code before it, nothing but lines between them."""
        code: int | None = None
        for at in places:
            yield at, code
            line = self._said[at]
            if line is None and self._source(at).strip():
                code = None
            elif line is not None and not line.is_comment:
                code = at

    def pieces(self) -> Iterator[str]:
        """Lines with their ends; a table is one piece."""
        waiting: list[LaidOutLine] = []
        levels = self._lines.levels(self._said)
        for at, (line, level) in enumerate(zip(self._said, levels, strict=True)):
            if line is not None:
                waiting.append(self._line(at, line, level))
                continue
            yield from self._aligned(waiting)
            waiting = []
            yield self._other(at, level)
        yield from self._aligned(waiting)

    # Levels

    def _heads_division(self, comment: int) -> bool:
        """Whether a comment belongs to a line below that divides a block, not to what is above.

        It does where it stands at that word's column and what is above does not.
        """
        above, below = self._above[comment], self._below[comment]
        if below is None or not self._word(below).parts:
            return False
        word = NO_WORD if above is None else self._word(above)
        if word.parts or word.opens:
            return False  # that one comes to stand at the same column
        column = self._column(comment)
        return column == self._column(below) and (above is None or column != self._column(above))

    def _word(self, at: int) -> BlockWord:
        line = self._said[at]
        return NO_WORD if line is None else self._lines.word(line.code)

    def _column(self, at: int) -> int:
        """The column at which the text behind the number begins."""
        return len(_indent(self._parts(at)).expandtabs(TAB))

    # Lines

    def _source(self, at: int) -> str:
        span = self._items[at].span
        return self._text[span.start : span.end].rstrip("\r\n")

    def _parts(self, at: int) -> Parts:
        line = self._said[at]
        assert line is not None
        return parts_of(self._source(at), line)

    def _line(self, at: int, line: changed_lines.Line, level: int) -> LaidOutLine:
        if self._lines.blocks and line.is_comment:
            level -= self._heads_division(at)
        parts = self._parts(at)
        body = self._lines.spaced(self._lines.words(parts.code)) or parts.comment
        number = "" if line.number is None else str(line.number)
        lead = f"{number} " if number and body else number
        indented, before = " " * (INDENT * level) + body, _indent(parts)
        if not self._lines.blocks:  # comments stand under each other as a whole
            lead, indented, before = "", lead + indented, parts.margin + parts.number + parts.indent
        made = LaidOutLine(indented, lead=lead)
        if parts.code and parts.comment:
            made.put_behind(parts.comment, before + parts.code + parts.gap)
        return made

    def _aligned(self, lines: Sequence[LaidOutLine]) -> Iterator[str]:
        return map(self._fitting, align_comments(lines, self._fits))

    def _fitting(self, text: str) -> str:
        """A line that the controller takes, if need be without its indentation."""
        if not self._fits(text):
            text = re.sub(r"^([0-9]*) +", r"\1 " if text[:1].isdigit() else "", text)
        return text + self._newline

    def _fits(self, text: str) -> bool:
        return len(text.encode(self._encoding, "replace")) <= self._lines.most

    def _other(self, at: int, level: int) -> str:
        """What is no line of the program."""
        text = self._source(at)
        if not isinstance(self._items[at], Run):
            return self._lines.respelled(at, text.strip(" \t\f")) + self._newline
        try:
            return self._lines.text(at, self._newline, level)
        except ValueError:  # more digits than a number of that table holds
            return text.replace("\r", "").replace("\n", self._newline)


def _indent(parts: Parts) -> str:
    """The blanks in front of the code, but for the one behind a number."""
    return parts.indent[1:] if parts.number else parts.indent
