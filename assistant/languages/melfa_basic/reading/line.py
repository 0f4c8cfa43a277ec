"""One line of a program, from its text to its node."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from functools import cache
from typing import Final

from assistant.base.diagnostics import Span
from assistant.languages.line_grammar import LineGrammar
from assistant.languages.melfa_basic.reading.grammar import grammar
from assistant.languages.melfa_basic.reading.lexer import lexer
from assistant.languages.melfa_basic.reading.nodes import Nodes
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.recovery.syntax import Lexeme, Stop

BLANKS: Final = " \t\f\x1a"
"""What a line holds that holds nothing; the last one ends files of old systems."""
MOST_WORDS: Final = 256
"""Words of a line that are read: no controller takes a step of more bytes."""
MOST_NESTING: Final = 60
"""Brackets inside each other that are read. Controllers take 16."""

_STEP: Final = re.compile(r"[ \t]*+([0-9]{1,9})(?=[ \t*']|$)")
_DECLARED: Final = re.compile(
    r"[ \t]*DEF[ \t]+(?:POS|JNT|INTE|LONG|FLOAT|DOUBLE|CHAR)[ \t]+[A-Z][A-Z0-9_]*+"
    r"[$%&!#]?[ \t]*(?:\([0-9, \t]*\))?[ \t]*=",
    re.IGNORECASE,
)
"""A line of a position list: `DEF POS P1=(…)(6,0)`."""


@dataclass(frozen=True, slots=True)
class TooLarge:
    """A line that has a number which no variable takes."""


@cache
def line_grammar() -> LineGrammar:
    return LineGrammar(grammar().tables, lexer().next, MOST_WORDS, 2 * MOST_NESTING)


@cache
def _nodes() -> Nodes:
    return Nodes()


def read_line(
    text: str, start: int, end: int, behind: int
) -> s.Line | s.Data | s.Blank | Stop | TooLarge:
    """The node of what stands between two offsets, or why there is none.

    behind: offset behind the line end.
    """
    span = Span(start, behind)
    if not text[start:end].strip(BLANKS):
        return s.Blank(span)
    number, at, rule = split_step(text, start, end)
    try:
        node = line_grammar().read(text, at, end, rule, _nodes(), None)
    except ValueError:
        return TooLarge()
    return node if isinstance(node, Stop) else placed(node, number, span)


def placed(node: s.Line | s.Data, number: int | None, span: Span | None) -> s.Line | s.Data:
    """What the grammar made of a line, with its step number and its place."""
    if isinstance(node, s.Line):
        return s.Line(number, node.label, node.statement, node.comment, span)
    return replace(node, span=span)


def split_step(text: str, start: int, end: int) -> tuple[int | None, int, str]:
    """Step number of a line, offset of the code behind it, and the rule of the grammar for that."""
    step = _STEP.match(text, start, end)
    at = step.end() if step else start
    rule = "data" if _DECLARED.match(text, at, end) else "line"
    return int(step[1]) if step else None, at, rule


def statement(text: str) -> s.Line | None:
    """One code line without a step number, None if it is not MELFA-BASIC."""
    if "\n" in text or "\r" in text or _STEP.match(text):
        return None
    node = read_line(text, 0, len(text), len(text))
    return node if isinstance(node, s.Line) else None


def expression(text: str) -> s.Expression | None:
    """What a text says that is an expression, None if it is none."""
    line = statement("M0=" + text)
    if line is None or line.comment is not None:
        return None
    match line.statement:
        case s.Assign(value=value, delay=None):
            return value
    return None


def lexemes(text: str, start: str = "line") -> tuple[Lexeme, ...]:
    """The words of a line without its step number, as far as it is MELFA-BASIC.

    start: the rule of the grammar, `line` or `data`.
    """
    words: list[Lexeme] = []
    line_grammar().read(text, 0, len(text), start, _Nothing(), words)
    return tuple(words)


class _Nothing(Nodes):
    """Makes no nodes."""

    def __getattribute__(self, name: str) -> object:
        return _no_node


def _no_node(_: Span | None, __: list[object]) -> None:
    return None
