"""One line by lark's tables: its node, or where it stops being MELFA-BASIC."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice
from typing import Any, Final, NamedTuple

from assistant.languages.lalr import END, Rows, Stack, Word
from assistant.languages.melfa_basic.reading.grammar import grammar
from assistant.languages.melfa_basic.reading.lexer import lexer
from assistant.languages.melfa_basic.reading.nodes import Nodes, Token

MOST_WORDS: Final = 256
"""Words of a line that are read: no controller takes a step of more bytes."""
MOST_NESTING: Final = 60
"""Brackets inside each other that are read. Controllers take 16."""


class Lexeme(NamedTuple):
    """type: a terminal of the grammar, STRANGE or END. start, end: offsets in the text."""

    type: str
    start: int
    end: int


@dataclass(frozen=True, slots=True)
class Stop:
    """A word that does not fit.

    word: its type is END behind the last one. start: rule of the grammar.
    """

    word: Lexeme
    start: str


def drive(
    text: str, at: int, end: int, start: str, nodes: Nodes, read: list[Lexeme] | None = None
) -> Any | Stop:
    """What `nodes` made of a line that stands between two offsets.

    read: takes the words that were.
    """
    tables = grammar().tables[start]
    stack = Stack(tables.first)
    words = islice(_words(text, at, end, tables.rows, stack.states, read), MOST_WORDS + 2)
    wrong = tables.drive(stack, words, nodes, most=2 * MOST_NESTING)
    if wrong is None:
        return stack.values[0]
    type, _, at, end = wrong
    return Stop(Lexeme(type, at, end), start)


def _words(
    text: str, at: int, end: int, rows: Rows, states: list[int], read: list[Lexeme] | None
) -> Iterator[Word]:
    """Each as what there is room for behind those before it."""
    following = lexer().next
    while (found := following(text, at, end, rows[states[-1]])) is not None:
        type, begin, at = found
        yield type, Token.of(text[begin:at], type), begin, at
        if read is not None:
            read.append(Lexeme(type, begin, at))
    yield END, "", end, end
