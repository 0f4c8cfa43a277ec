"""One line by lark's tables: its node, or where it stops being MELFA-BASIC."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice
from typing import Any, Final

from assistant.languages.lalr import END, Rows, Stack, Word
from assistant.languages.melfa_basic.reading.grammar import grammar
from assistant.languages.melfa_basic.reading.lexer import lexer
from assistant.languages.melfa_basic.reading.nodes import Nodes, Token
from assistant.languages.recovery.lexemes import Lexeme, Stop

MOST_WORDS: Final = 256
"""Words of a line that are read: no controller takes a step of more bytes."""
MOST_NESTING: Final = 60
"""Brackets inside each other that are read. Controllers take 16."""


def drive(
    text: str, at: int, end: int, start: str, nodes: Nodes, words: list[Lexeme] | None = None
) -> Any | Stop:
    """What `nodes` made of a line that stands between two offsets.

    words: takes those that were read.
    """
    tables = grammar().tables[start]
    stack = Stack(tables.first)
    found = islice(_words(text, at, end, tables.rows, stack.states, words), MOST_WORDS + 2)
    wrong = tables.drive(stack, found, nodes, most=2 * MOST_NESTING)
    if wrong is None:
        return stack.values[0]
    return Stop(Lexeme(*wrong), start)


def _words(
    text: str, at: int, end: int, rows: Rows, states: list[int], words: list[Lexeme] | None
) -> Iterator[Word]:
    """Each as what there is room for behind those before it."""
    following = lexer().next
    while (found := following(text, at, end, rows[states[-1]])) is not None:
        type, begin, at = found
        said = Token.of(text[begin:at], type)
        yield type, said, begin, at
        if words is not None:
            words.append(Lexeme(type, said, begin, at))
    yield END, "", end, end
