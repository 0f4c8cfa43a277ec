"""One line by lark's tables: its node, or where it stops being MELFA-BASIC."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final, NamedTuple

from assistant.languages.lalr import END
from assistant.languages.melfa_basic.reading.grammar import tables
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
    text: str, at: int, end: int, start: str, nodes: Nodes, words: list[Lexeme] | None = None
) -> Any | Stop:
    """What `nodes` made of a line that stands between two offsets.

    words: takes what was read.
    """
    found = tables(start)
    rows = found.rows
    states, values, begins, ends = [found.first], list[Any](), list[int](), list[int]()
    following = lexer().next
    count = 0
    while True:
        word = following(text, at, end, rows[states[-1]]) or (END, end, end)
        type, begin, at = word
        state = found.settle(type, states, values, begins, ends, nodes)
        if state is not None and type == END:
            return values[0]
        if state is None or count > MOST_WORDS or len(states) > 2 * MOST_NESTING:
            return Stop(Lexeme(*word), start)
        count += 1
        if words is not None:
            words.append(Lexeme(*word))
        token = Token(text[begin:at])
        token.type = type
        states.append(state)
        values.append(token)
        begins.append(begin)
        ends.append(at)
