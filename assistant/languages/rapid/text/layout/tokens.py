"""Tokens of a RAPID text, with the line ends and comments between them."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Final

from assistant.languages.rapid.reading.scanner import words
from assistant.languages.texts.words import Word

FEWEST_ROWS: Final = 8
MOST_ROWS: Final = 1 << 16
"""Rows of one token, so that a long table comes in pieces of bounded size."""


def tokens(text: str, *, rows: bool = True, start: int = 0) -> Iterator[Word]:
    """The words of a text, and `rows`: tables of alike lines, line ends included.

    rows: False takes tables apart as well. start: of the text.
    """
    found = words(text)
    header = next(found, None)
    at = 0
    if header is not None and header.kind == "header":
        at = header.end
        yield header._replace(start=start)
    for table in _TABLE.finditer(text, at) if rows else ():
        if _may_be_rows(table[0]):
            yield from _moved_words(words(text, at, table.start()), start)
            yield Word("rows", table[0], start + table.start())
            at = table.end()
    yield from _moved_words(words(text, at), start)


def _moved_words(found: Iterator[Word], by: int) -> Iterator[Word]:
    return found if not by else (word._replace(start=word.start + by) for word in found)


def _may_be_rows(text: str) -> bool:
    """Whether no word in a table could need upper case."""
    lower = text.lower()
    return "true" not in lower and "false" not in lower


_ROW_HEAD = r"(?:(?:LOCAL +)?+CONST +robtarget +|Move[JLC] +(?!\\))"
_ROW_REST = r"(?:[^\s;!\"()<>%]++|(?<=\W)[ \t]++|[ \t]++(?=\W))*+"
_ROW = rf"[ \t]*+{_ROW_HEAD}{_ROW_REST};[ \t]*+(?:\r?\n|\Z)"
"""A declared target or a move on one line, that needs no blank but those of its head."""

_TABLE: Final = re.compile(rf"^(?:{_ROW}){{{FEWEST_ROWS},{MOST_ROWS}}}+", re.MULTILINE)
