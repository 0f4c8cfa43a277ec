"""How the items of a file are written, new ones and those of one that was read."""

from __future__ import annotations

import string
from collections.abc import Callable, Sequence
from itertools import groupby
from typing import Any

import numpy as np

from assistant.languages.line_blocks import BlockWord
from assistant.languages.melfa_basic.reading.parser import statement as read
from assistant.languages.melfa_basic.tables.dialects import DIALECTS
from assistant.languages.melfa_basic.text.layout.tokens import code_text, code_tokens
from assistant.languages.melfa_basic.text.printer import constant, expression, line
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.blocks import block_word
from assistant.languages.melfa_basic.tree.columnar import (
    MOST_PLACES,
    MoveRows,
    PositionRows,
    move_text,
    places_of,
    position_text,
)
from assistant.languages.melfa_basic.tree.line_tables import position_rows
from assistant.languages.texts import line_text
from assistant.languages.texts.layout import INDENT
from assistant.languages.texts.line_text import Line
from assistant.languages.texts.words import Word

Code = tuple[str | None, s.Statement | None]
"""Label and statement."""


class Lines(line_text.LinePrinter):
    """The items of a file as its dialect writes them."""

    table, number = MoveRows, "numbers"

    def __init__(self, file: s.File) -> None:
        dialect = DIALECTS[file.dialect]
        self.items, self._upper = file.items, dialect.upper
        self.blocks, self.most = dialect.blocks, dialect.line
        self._places = _decimals(file.items)

    def line(self, item: s.Item) -> Line | None:
        if not isinstance(item, s.Line):
            return None
        said = (item.label, item.statement)
        return Line(item.number, None if said == (None, None) else said, item.comment)

    def word(self, code: Code | None) -> BlockWord:
        return block_word(code and code[1])

    def printed(self, code: Code | None) -> str:
        return "" if code is None else line(s.Line(None, *code), self._upper)

    def words(self, text: str) -> Sequence[Word]:
        return code_tokens(text)

    def spaced(self, words: Sequence[Word]) -> str:
        return code_text(words, self._upper)

    def key(self, word: Word) -> str | float:
        """The value of a number; any other text without blanks in lower case."""
        if word.kind == "NUMBER":
            return float(word.text)
        return "".join(word.text.split()).casefold()

    def says(self, text: str, code: Code) -> bool:
        return read(text) == s.Line(None, *code)

    def text(self, at: int, newline: str, level: int = 0) -> str:
        match self.items[at]:
            case (MoveRows() | PositionRows()) as table:
                return self._rows(table, newline, INDENT * level, self._places[at])(table)
            case s.Line() as item:
                return line(item, self._upper, level) + newline
            case s.Data(variable, s.Constant() as value, type=type):
                text = constant(value, self._places[at])
            case s.Data(variable, value, type=type):
                text = expression(value)
            case item:
                return (item.text if isinstance(item, s.Unread) else "") + newline
        declared = f"Def {type} " if type else ""
        declared = declared.upper() if self._upper else declared
        return f"{declared}{expression(variable)}={text}{newline}"

    def respelled(self, at: int, text: str) -> str:
        item, places = self.items[at], self._places[at]
        if not isinstance(item, s.Data):
            return text
        listed = code_tokens(text, "data" if item.type else "line")
        if not isinstance(item.value, s.Constant) or not _is_exact(item.value, places):
            return self.spaced(listed)
        head = [token for token in listed if token.kind != "POSITION"]
        return self.spaced(head) + constant(item.value, places)

    def rows(self, table: Any, newline: str, indent: int) -> Callable[[Any], str]:
        places = places_of(table.values) if isinstance(table, PositionRows) else 0
        return self._rows(table, newline, indent, places)

    def _rows(self, table: Any, newline: str, indent: int, places: int) -> Callable[[Any], str]:
        end = newline.encode("ascii")
        if isinstance(table, MoveRows):
            return lambda rows: move_text(rows, end, self._upper, indent)
        return lambda rows: position_text(rows, end, places)

    def as_data(self, item: s.Item) -> PositionRows | None:
        return position_rows(item)


# Decimals


def _decimals(items: Sequence[s.Item]) -> list[int]:
    """Decimal places of each item; neighbours whose names differ in the number only have the same.

    They print every number without loss, as far as any decimals do.
    """
    places: list[int] = []
    for _, group in groupby(items, _table_kind):
        together = list(group)
        places += [max(map(_needed_decimals, together))] * len(together)
    return places


def _table_kind(item: s.Item) -> object:
    """What position lines have in common that may stand in one table."""
    match item:
        case PositionRows(stem=stem, values=values):
            return stem, values.shape[1], False, True
        case s.Data(variable=variable, value=s.Constant(values=elements, flags=flags)):
            indexed = variable.arguments is not None
            return variable.name.rstrip(string.digits), len(elements), indexed, flags is not None
    return None


def _needed_decimals(item: s.Item) -> int:
    match item:
        case PositionRows(values=values):
            return places_of(values)
        case s.Data(value=s.Constant() as value) if _is_exact(value, MOST_PLACES):
            return places_of(np.array([v for v in value.values if v is not None], dtype=np.float64))
    return 2


def _is_exact(value: s.Constant, places: int) -> bool:
    """Whether so many decimals print every number of a constant without loss."""
    return all(v is None or round(v, places) == v for v in value.values)
