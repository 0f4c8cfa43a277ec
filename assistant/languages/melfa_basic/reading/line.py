"""One line of a program, from its text to its node."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from functools import cache
from typing import Final

from assistant.languages.melfa_basic.reading.driver import drive
from assistant.languages.melfa_basic.reading.nodes import Nodes
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.recovery.lexemes import Lexeme, Stop
from assistant.program.diagnostics import Span

BLANKS: Final = " \t\f\x1a"
"""What a line holds that holds nothing; the last one ends files of old systems."""

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


def read_line(
    text: str, start: int, end: int, behind: int
) -> s.Line | s.Data | s.Blank | Stop | TooLarge:
    """The node of what stands between two offsets, or why there is none.

    behind: offset behind the line end.
    """
    span = Span(start, behind)
    if not text[start:end].strip(BLANKS):
        return s.Blank(span)
    step = _STEP.match(text, start, end)
    at = step.end() if step else start
    kind = rule_of(text, at, end)
    try:
        node = drive(text, at, end, kind, _nodes())
    except ValueError:
        return TooLarge()
    if isinstance(node, s.Line):
        number = int(step.group(1)) if step else None
        return s.Line(number, node.label, node.statement, node.comment, span)
    if isinstance(node, s.Data):
        return replace(node, span=span)
    return node if isinstance(node, Stop) else TooLarge()


def rule_of(text: str, at: int, end: int) -> str:
    """The rule of the grammar that code begins, which stands behind a step number."""
    return "data" if _DECLARED.match(text, at, end) else "line"


def step_of(text: str, start: int, end: int) -> int | None:
    """The step number of a line, None if it has none."""
    step = _STEP.match(text, start, end)
    return None if step is None else int(step.group(1))


def code_start(text: str, start: int, end: int) -> int:
    """The offset behind a line's step number."""
    step = _STEP.match(text, start, end)
    return step.end() if step else start


def statement(text: str) -> s.Line | None:
    """One code line without a step number, None if it is not MELFA-BASIC."""
    if "\n" in text or "\r" in text or _STEP.match(text):
        return None
    node = read_line(text, 0, len(text), len(text))
    return node if isinstance(node, s.Line) else None


def lexemes(text: str, start: str = "line") -> tuple[Lexeme, ...]:
    """The words of a line without its step number, as far as it is MELFA-BASIC.

    start: the rule of the grammar, `line` or `data`.
    """
    words: list[Lexeme] = []
    drive(text, 0, len(text), start, _Nothing(), words)
    return tuple(words)


class _Nothing(Nodes):
    """Makes no nodes."""

    def __getattribute__(self, name: str) -> object:
        return _no_node


def _no_node(_: Span | None, __: list[object]) -> None:
    return None


@cache
def _nodes() -> Nodes:
    return Nodes()
