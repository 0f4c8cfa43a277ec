"""Text of a tree: unchanged lines byte for byte, new ones printed, all of them in one layout.

The one layout of `fmt`: blanks, indentation, comments, position lines.

    1 Function Main
    2     If M_In(8)=1 Then      ' comments after lines that were aligned
    3         Mov P1,-50         ' stay aligned
    4     EndIf
    5 FEnd
    P1=(+400.00,-200.00,+438.33,+180.00,+0.00,+88.09)(7,0)

Step numbers, names, numbers and strings stay as they are written, keywords become as the makers'
tools spell them. Programs of MELFA-BASIC IV are not indented.
"""

from __future__ import annotations

import re
import string
from collections.abc import Callable, Iterator, Sequence
from functools import lru_cache
from itertools import groupby
from typing import Any, Final

import numpy as np

from assistant.languages.line_blocks import BlockWord
from assistant.languages.melfa_basic.reading.line import lexemes
from assistant.languages.melfa_basic.reading.parser import statement as read
from assistant.languages.melfa_basic.tables.dialects import DIALECTS
from assistant.languages.melfa_basic.tables.variables import keyword_spelling
from assistant.languages.melfa_basic.text.printer import constant, expression, line
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.columnar import (
    MOST_PLACES,
    MoveRows,
    PositionRows,
    move_text,
    places_of,
    position_text,
)
from assistant.languages.melfa_basic.tree.control_flow import block_word
from assistant.languages.melfa_basic.tree.line_tables import position_rows
from assistant.languages.texts import line_text
from assistant.languages.texts.layout import INDENT
from assistant.languages.texts.line_text import Line, print_items
from assistant.languages.texts.words import Word

_BLANK_RUN: Final = re.compile(r"[ \t\f]+")
_MARK_KINDS: Final = frozenset(("NAME", "FN_NAME", "SUFFIX", "REM", "HASH"))
"""Kinds of tokens that may begin like a keyword but are not keywords; all other words are
keywords.
"""
_TIGHT: Final = frozenset(("POSITION", "EMPTY", "LABEL"))
"""Kinds of tokens that lose the blanks within them."""
_OPERATORS: Final = frozenset(
    ("EQUALS", "SIGN", "TIMES", "BACKSLASH", "SHIFT", "COMPARISON", "CIRCUMFLEX")
)
_TIGHT_BEFORE: Final = frozenset(("COLON", "RPAR", "SEMICOLON", "SUFFIX", "DOT"))
_TIGHT_BEHIND: Final = frozenset(("COLON", "LPAR", "COMMA", "SEMICOLON", "HASH", "DOT"))
_CLAUSES: Final = frozenset(
    ("ELSE", "_WTH", "_WTHIF", "_TYPE_OF", "GOTO", "GOSUB", "_TO", "_STEP_OF")
)
"""Words that begin a part of a statement, also where the last argument before is left out."""
_HEADS: Final = frozenset(("MOTION", "COMMAND"))
"""Statements whose first argument may be left out: `Mvs ,-100`."""


@lru_cache(maxsize=1 << 14)
def _code_tokens(line: str, start: str = "line") -> tuple[Word, ...]:
    """The tokens of a line that the grammar takes, without step number.

    start: the grammar's rule, `line` or `data`.
    """
    return tuple(Word(one.type, one.text, one.start) for one in lexemes(line, start))


def _code_text(listed: Sequence[Word], upper: bool) -> str:
    """Words with the blanks that belong between them, keywords spelt as the tools do.

    upper: keywords in upper case. Names, numbers, strings and comments stay as they are.
    """
    return "".join(_spaced(listed, upper))


def _spaced(listed: Sequence[Word], upper: bool) -> Iterator[str]:
    for before, token, at in zip([None, *listed], listed, range(len(listed)), strict=False):
        # Blanks surround `Is` and the comparison after it: `Is <= 5`.
        within_is = at > 0 and "_IS" in (listed[at - 1].kind, listed[at - 2].kind if at > 1 else "")
        if before is not None and (within_is or _are_apart(before, token)):
            yield " "
        yield _spelt(token, upper)


def _spelt(token: Word, upper: bool) -> str:
    if _is_keyword(token):
        word = keyword_spelling(token.text)
        return word.upper() if upper else word
    return _BLANK_RUN.sub("", token.text) if token.kind in _TIGHT else token.text


def _is_keyword(token: Word) -> bool:
    return token.kind not in _MARK_KINDS and (token.text[0].isalpha() or token.text[0] == "#")


def _are_apart(before: Word, token: Word) -> bool:
    """True if a blank separates two neighbours."""
    # Before a clause a blank also follows an argument that is left out.
    if token.kind in _CLAUSES and before.kind != "COLON":
        return True
    if token.kind in _TIGHT_BEFORE or before.kind in _TIGHT_BEHIND:
        return False
    if token.kind == "COMMA":
        # The first argument is left out, and the comma would run into the word.
        return before.kind in _HEADS
    if _is_keyword(before):
        return not (before.kind == "_COM" and token.kind == "LPAR")
    if _is_keyword(token):
        return before.kind not in _OPERATORS
    if before.kind in _OPERATORS or token.kind in _OPERATORS:
        return False
    if "LABEL" in (before.kind, token.kind):
        return True
    return _ends_word(before) and _begins_word(token)


def _begins_word(token: Word) -> bool:
    return token.text[0].isalnum() or token.text[0] in '"&.'


def _ends_word(token: Word) -> bool:
    return token.kind != "HASH" and (token.text[-1].isalnum() or token.text[-1] in '")$%&!#.')


Code = tuple[str | None, s.Statement | None]
"""Label and statement."""


class _Lines(line_text.LinePrinter):
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
        return _code_tokens(text)

    def spaced(self, words: Sequence[Word]) -> str:
        return _code_text(words, self._upper)

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
        listed = _code_tokens(text, "data" if item.type else "line")
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
    # Neighbours of one table have the same decimals, so that their columns line up.
    places: list[int] = []
    for _, group in groupby(items, _table_kind):
        together = list(group)
        places += [max(map(_needed_decimals, together))] * len(together)
    return places


def _table_kind(item: s.Item) -> object:
    """Return the common property of position lines that may form one table."""
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
    """True if so many decimals print every number of a constant without loss."""
    return all(v is None or round(v, places) == v for v in value.values)


def render(file: s.File) -> str:
    """The text of a tree; lines that were read and not changed keep their bytes."""
    if file.source is None:
        return "".join(print_items(_Lines(file), "\r\n"))
    if file.items is file.parsed:
        return file.source.text
    return line_text.render_changed_file(file.source, file.parsed, _Lines(file))


def lay_out(file: s.File) -> str:
    """The text of a file that was read and has no syntax error in the one layout; idempotent.

    Line ends become the ones that most lines have.
    """
    assert file.source is not None
    return line_text.lay_out(file.source, _Lines(file))
