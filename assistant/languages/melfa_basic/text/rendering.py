"""The text of a tree: what was read as it stood, what changed in its place, what is new printed."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from assistant.languages.melfa_basic.reading.parser import statement as read
from assistant.languages.melfa_basic.tables.dialects import DIALECTS
from assistant.languages.melfa_basic.text.layout.levels import levels
from assistant.languages.melfa_basic.text.layout.printing import decimals, item_text, print_items
from assistant.languages.melfa_basic.text.layout.tokens import tokens
from assistant.languages.melfa_basic.text.printer import INDENT, line
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.columnar import (
    MoveRows,
    PositionRows,
    move_text,
    places_of,
    position_text,
)
from assistant.languages.melfa_basic.tree.line_tables import position_rows
from assistant.languages.texts import changed_files
from assistant.languages.texts.changed_lines import Line
from assistant.languages.texts.words import Word

Code = tuple[str | None, s.Statement | None]
"""Label and statement."""


def render(file: s.File) -> str:
    """The text of a tree; lines that were read and not changed keep their bytes."""
    if file.source is None:
        return "".join(print_items(file.items, file.dialect, "\r\n"))
    if file.items is file.parsed:
        return file.source.text
    return changed_files.render(file.source, file.parsed, file.items, _Lines(file.dialect))


class _Lines(changed_files.Lines):
    step, table = INDENT, MoveRows

    def __init__(self, dialect: str) -> None:
        self._dialect = DIALECTS[dialect]
        self.numbers = {MoveRows: "steps", PositionRows: "numbers"}

    def line(self, item: s.Item) -> Line | None:
        if not isinstance(item, s.Line):
            return None
        code = (item.label, item.statement)
        return Line(item.number, None if code == (None, None) else code, item.comment)

    def printed(self, code: Code | None) -> str:
        return "" if code is None else line(s.Line(None, *code), self._dialect.upper)

    def words(self, text: str) -> Sequence[Word]:
        return tokens(text)

    def key(self, word: Word) -> str | float:
        """The value of a number; any other text without blanks in lower case."""
        if word.kind == "NUMBER":
            return float(word.text)
        return "".join(word.text.split()).casefold()

    def says(self, text: str, code: Code) -> bool:
        return read(text) == s.Line(None, *code)

    def levels(self, items: Sequence[s.Item]) -> Sequence[int]:
        return levels(items) if self._dialect.blocks else [0] * len(items)

    def texts(self, items: Sequence[s.Item], newline: str) -> Callable[[int], str]:
        places = decimals(items)
        return lambda at: item_text(items[at], self._dialect.upper, newline, places[at], 0)

    def rows(self, table: Any, newline: str, indent: int) -> Callable[[Any], str]:
        end = newline.encode("ascii")
        if isinstance(table, MoveRows):
            return lambda rows: move_text(rows, end, self._dialect.upper, indent)
        places = places_of(table.values)
        return lambda rows: position_text(rows, end, places)

    def as_data(self, item: s.Item) -> PositionRows | None:
        return position_rows(item)
