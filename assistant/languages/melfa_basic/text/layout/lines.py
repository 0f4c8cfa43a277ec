"""One layout for every MELFA-BASIC text: blanks, indentation, comments, position lines.

    1 Function Main
    2     If M_In(8)=1 Then      ' comments behind lines that stood aligned
    3         Mov P1,-50         ' stay aligned
    4     EndIf
    5 FEnd
    P1=(+400.00,-200.00,+438.33,+180.00,+0.00,+88.09)(7,0)

Step numbers, names, numbers and strings stay as they are written, keywords become as the
makers' tools spell them. Programs of MELFA-BASIC IV are not indented.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

from assistant.languages.line_blocks import NO_WORD
from assistant.languages.melfa_basic.tables.dialects import DIALECTS, Dialect
from assistant.languages.melfa_basic.text.layout.levels import is_comment, levels
from assistant.languages.melfa_basic.text.layout.printing import decimals, exact, item_text
from assistant.languages.melfa_basic.text.layout.tokens import code, tokens
from assistant.languages.melfa_basic.text.printer import INDENT, constant
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.blocks import block_word
from assistant.languages.melfa_basic.tree.columnar import MoveRows, PositionRows
from assistant.languages.texts import changed_lines
from assistant.languages.texts.changed_lines import Parts, parts_of
from assistant.languages.texts.laying_out import TAB, Line, aligned
from assistant.program.text import dominant_newline


def lay_out(file: s.File) -> str:
    """The text of a file that was read and has no syntax error in the one layout; idempotent.

    Line ends become the ones that most lines have.
    """
    assert file.source is not None
    return "".join(_Pages(file, file.source.text).pieces())


def _before(items: Sequence[s.Item]) -> list[s.Line | None]:
    """For each item the next line of code in front of it, no table or data between them."""
    found: list[s.Line | None] = []
    code: s.Line | None = None
    for item in items:
        found.append(code)
        if not isinstance(item, s.Line | s.Blank):
            code = None
        elif isinstance(item, s.Line) and not is_comment(item):
            code = item
    return found


def _indent(parts: Parts) -> str:
    """The blanks in front of the code, but for the one behind a step number."""
    return parts.indent[1:] if parts.number else parts.indent


class _Pages:
    """The lines of one file."""

    def __init__(self, file: s.File, text: str) -> None:
        self._file, self._text = file, text
        self._dialect: Dialect = DIALECTS[file.dialect]
        self._newline = dominant_newline(text)
        self._places = decimals(file.items)
        assert file.source is not None
        self._encoding = file.source.encoding
        self._above = _before(file.items)
        self._below = _before(file.items[::-1])[::-1]

    def pieces(self) -> Iterator[str]:
        """Lines with their ends; a table is one piece."""
        waiting: list[Line] = []
        inside = levels(self._file.items)
        for at, (item, level) in enumerate(zip(self._file.items, inside, strict=True)):
            if not self._dialect.blocks:
                level = 0
            elif is_comment(item):
                level -= self._heads_division(item, at)
            if isinstance(item, s.Line):
                waiting.append(self._line(item, level))
                continue
            yield from self._aligned(waiting)
            waiting = []
            yield self._other(item, self._places[at], level)
        yield from self._aligned(waiting)

    # Levels

    def _heads_division(self, comment: s.Item, at: int) -> bool:
        """Whether a comment belongs to an `Else` or `Case` below rather than to what is above.

        It does where it stands at that word's column and what is above does not.
        """
        below = self._below[at]
        if below is None or not block_word(below.statement).parts:
            return False
        above = self._above[at]
        column = self._column(comment)
        word = NO_WORD if above is None else block_word(above.statement)
        if word.parts or word.opens:
            return False  # that one comes to stand at the same column
        return column == self._column(below) and (above is None or column != self._column(above))

    def _column(self, item: s.Item) -> int:
        """The column at which the text behind the step number begins."""
        assert isinstance(item, s.Line)
        return len(_indent(self._parts(item)).expandtabs(TAB))

    # Lines

    def _source(self, item: s.Item) -> str:
        assert item.span is not None
        return self._text[item.span.start : item.span.end].rstrip("\r\n")

    def _parts(self, item: s.Line) -> Parts:
        return parts_of(self._source(item), changed_lines.Line(item.number, None, item.comment))

    def _line(self, item: s.Line, level: int) -> Line:
        parts = self._parts(item)
        body = code(tokens(parts.code), self._dialect.upper) or parts.comment
        step = "" if item.number is None else str(item.number)
        lead = f"{step} " if step and body else step
        indented, before = " " * (INDENT * level) + body, _indent(parts)
        if not self._dialect.blocks:  # comments stand under each other as a whole
            lead, indented, before = "", lead + indented, parts.margin + parts.number + parts.indent
        line = Line(indented, lead=lead)
        if parts.code and parts.comment:
            line.put_behind(parts.comment, before + parts.code + parts.gap)
        return line

    def _aligned(self, lines: Sequence[Line]) -> Iterator[str]:
        return map(self._fitting, aligned(lines, self._fits))

    def _fitting(self, text: str) -> str:
        """A line that the controller takes, if need be without its indentation."""
        if not self._fits(text):
            text = re.sub(r"^([0-9]*) +", r"\1 " if text[:1].isdigit() else "", text)
        return text + self._newline

    def _fits(self, text: str) -> bool:
        return len(text.encode(self._encoding, "replace")) <= self._dialect.line

    # What is no line of code

    def _other(self, item: s.Item, places: int, level: int) -> str:
        if isinstance(item, PositionRows | MoveRows):
            try:
                return item_text(item, self._dialect.upper, self._newline, places, level)
            except ValueError:  # more digits than a number of that table holds
                return self._source(item).replace("\r", "").replace("\n", self._newline)
        if isinstance(item, s.Data):
            return self._data(item, places) + self._newline
        return self._source(item).strip(" \t\f") + self._newline

    def _data(self, item: s.Data, places: int) -> str:
        listed = tokens(self._source(item).strip(" \t\f"), "data" if item.type else "line")
        value = item.value
        if isinstance(value, s.Constant) and exact(value, places):
            head = [t for t in listed if t.kind != "POSITION"]
            return code(head, self._dialect.upper) + constant(value, places)
        return code(listed, self._dialect.upper)
