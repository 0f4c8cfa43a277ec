"""One line by lark's tables: its node, or where it stops being MELFA-BASIC."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any, Final, NamedTuple

from assistant.languages.lalr import END, Reduction
from assistant.languages.melfa_basic.grammar import tables
from assistant.languages.melfa_basic.lexer import lexer
from assistant.languages.melfa_basic.nodes import Nodes, Token

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

    word: its type is END behind the last one. row: the terminals that would have fitted, without
    those that only a left-out part would bring. states: of the tables, before the word.
    """

    word: Lexeme
    states: tuple[int, ...]
    start: str

    @property
    def fitting(self) -> frozenset[str]:
        """Terminals that go on from here, in states that the end of a rule leads to as well."""
        return frozenset(t for t in _terminals(self.start) if fits(self.start, self.states, t))


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
            return Stop(Lexeme(*word), tuple(states), start)
        count += 1
        if words is not None:
            words.append(Lexeme(*word))
        token = Token(text[begin:at])
        token.type = type
        states.append(action)
        values.append(token)
        begins.append(begin)
        ends.append(at)


def fits(start: str, before: tuple[int, ...], terminal: str) -> bool:
    """Whether a terminal has room behind what led to these states."""
    table = tables(start).rows
    states = list(before)
    while (action := table[states[-1]].get(terminal)) is not None:
        if isinstance(action, int):
            return True
        if action.size:
            del states[-action.size :]
        if states[-1] == tables(start).last:
            return True
        follow = table[states[-1]].get(action.origin)
        if follow is None:
            return False
        states.append(follow)
        if terminal == END and follow == tables(start).last:
            return True
    return False


@cache
def _terminals(start: str) -> tuple[str, ...]:
    rows = tables(start).rows
    return tuple(sorted({t for row in rows for t in row if t is not None and t.isupper()} | {END}))
