"""One line by lark's tables: its node, or where it stops being MELFA-BASIC."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache
from typing import Any, Final, NamedTuple

from assistant.languages.lalr import END, Reduction, Tables
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

    @property
    def terminals(self) -> tuple[str, ...]:
        """All terminals of the grammar, and END."""
        return _terminals(self.start)


def drive(
    text: str, at: int, end: int, start: str, nodes: Nodes, words: list[Lexeme] | None = None
) -> Any | Stop:
    """What `nodes` made of a line that stands between two offsets.

    words: takes what was read.
    """
    found = tables(start)
    table, passing = found.rows, found.passing
    states, values, begins, ends = [found.first], list[Any](), list[int](), list[int]()
    following = lexer().next
    count = 0
    while True:
        word = following(text, at, end, table[states[-1]]) or (END, end, end)
        type, begin, at = word
        action = table[states[-1]].get(type)
        while action.__class__ is Reduction:
            if action.passes:
                states[-1], action = passing[states[-2], states[-1], type]
                continue
            action.reduce(table, states, values, begins, ends, nodes)
            if states[-1] == found.last:
                return values[0]
            action = table[states[-1]].get(type)
        if action is None or count > MOST_WORDS or len(states) > 2 * MOST_NESTING:
            return Stop(Lexeme(*word), start)
        count += 1
        if words is not None:
            words.append(Lexeme(*word))
        token = Token(text[begin:at])
        token.type = type
        states.append(action)
        values.append(token)
        begins.append(begin)
        ends.append(at)


def states_of(start: str, words: Iterable[Lexeme]) -> tuple[int, ...]:
    """The states that words lead to which fit one behind the other."""
    found = tables(start)
    states = [found.first]
    for word in words:
        action = _settled(found, states, word.type)
        if not isinstance(action, int):
            break
        states.append(action)
    return tuple(states)


def fits(start: str, before: tuple[int, ...], terminal: str) -> bool:
    """Whether a terminal has room behind what led to these states."""
    return _settled(tables(start), list(before), terminal) is not None


def _settled(found: Tables, states: list[int], terminal: str) -> int | None:
    """The state that a terminal leads to once its rules are done, None where it does not fit."""
    while (action := found.rows[states[-1]].get(terminal)) is not None:
        if isinstance(action, int):
            return action
        if action.size:
            del states[-action.size :]
        states.append(found.rows[states[-1]][action.origin])
        if states[-1] == found.last:
            return found.last if terminal == END else None
    return None


@cache
def _terminals(start: str) -> tuple[str, ...]:
    rows = tables(start).rows
    return tuple(sorted({t for row in rows for t in row if t is not None and t.isupper()} | {END}))
