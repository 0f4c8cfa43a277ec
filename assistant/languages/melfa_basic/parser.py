"""Text to tree: tables of plain rows at once, every other line through the grammar."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from functools import cache, lru_cache
from typing import Any, Final

from assistant.languages.melfa_basic import rules
from assistant.languages.melfa_basic import syntax as s
from assistant.languages.melfa_basic.columnar import MoveRows, PositionRows, rows_at
from assistant.languages.melfa_basic.vocabulary import Role, words
from assistant.program.diagnostics import Diagnostic, Span
from assistant.program.text import SourceText
from assistant.resources import read_grammar

TOKENISED: Final = "ROBPRG"
"""What a controller's own .MB4, .MB5 and .MB6 files begin with."""

_STEP: Final = re.compile(r"[ \t]*([0-9]{1,9})(?=[ \t*']|$)")
_DECLARED: Final = re.compile(
    r"[ \t]*DEF[ \t]+(?:POS|JNT|INTE|LONG|FLOAT|DOUBLE|CHAR)[ \t]+[A-Z][A-Z0-9_]*"
    r"[$%&!#]?[ \t]*(?:\([0-9, \t]*\))?[ \t]*=",
    re.IGNORECASE,
)
"""A line of a position list: `DEF POS P1=(…)(6,0)`."""


def parse(source: SourceText | str, dialect: str) -> s.File:
    """The tree of a program or position list; what cannot be read is a finding, never raised."""
    source = source if isinstance(source, SourceText) else SourceText(source)
    if source.text.startswith(TOKENISED):
        finding = rules.TOKENISED(path=source.path, line=1, column=1)
        whole = s.Unread(source.text, Span(0, len(source.text)))
        return s.File(dialect, (whole,), (finding,), source, (whole,))
    items: list[s.Item] = []
    findings: list[Diagnostic] = []
    for start, end in _pieces(source.text, items):
        item, wrong = _line(source, start, end)
        items.append(item)
        if wrong:
            findings.append(wrong)
    parsed = tuple(_with_data(items))
    return s.File(dialect, parsed, tuple(findings), source, parsed)


def _pieces(text: str, items: list[s.Item]) -> Iterator[tuple[int, int]]:
    """The offsets of the lines that are left for the grammar; tables go straight to items."""
    at, size = 0, len(text)
    while at < size:
        rows = rows_at(text, at)
        if rows is not None and rows.span is not None:
            items.append(rows)
            at = rows.span.end
            continue
        end = text.find("\n", at) + 1 or size
        yield at, end
        at = end


def _line(source: SourceText, start: int, end: int) -> tuple[s.Item, Diagnostic | None]:
    text, span = source.text[start:end].rstrip("\r\n"), Span(start, end)
    if not text.strip(" \t\f\x1a"):
        return s.Blank(span), None
    found = _STEP.match(text)
    offset = found.end() if found else 0
    result = _read(text[offset:])
    if isinstance(result, s.Line):
        number = int(found.group(1)) if found else None
        return replace(result, number=number, span=span), None
    if isinstance(result, s.Data):
        return replace(result, span=span), None
    column, expected = result
    at = start + offset + min(column, max(len(text) - offset - 1, 0))
    quotes = any(mark in text for mark in "‘’“”＂")
    rule = rules.QUOTES if quotes else rules.SYNTAX
    finding = source.finding(rule, Span(at, at + 1), reason=expected)
    return s.Unread(text, span), finding


def statement(text: str) -> s.Line | None:
    """One code line without a step number, None if it is not MELFA-BASIC."""
    result = _read(text) if "\n" not in text and "\r" not in text else None
    return result if isinstance(result, s.Line) else None


@lru_cache(maxsize=4096)
def _read(text: str) -> s.Line | s.Data | tuple[int, str]:
    """A line without its step number, or the column (from 0) and reason of what is wrong."""
    from lark import UnexpectedInput
    from lark.exceptions import VisitError

    try:
        start = "data" if _DECLARED.match(text) else "line"
        line: s.Line | s.Data = _nodes().transform(grammar().parse(text, start=start))
    except UnexpectedInput as error:
        return max(error.pos_in_stream or 0, 0) if _placed(error) else len(text), _reason(error)
    except RecursionError:
        return 0, "is nested too deeply"
    except VisitError as error:
        if isinstance(error.orig_exc, RecursionError):
            return 0, "is nested too deeply"
        if isinstance(error.orig_exc, ValueError):
            return 0, "holds a number with too many digits"
        raise
    return line


def _placed(error: Any) -> bool:
    return getattr(getattr(error, "token", None), "type", "") != "$END"


def _reason(error: Any) -> str:
    token = getattr(error, "token", None)
    if token is not None and token.type == "$END":
        return "ends too early"
    return f"has `{token}` where it cannot stand" if token else "has a character it cannot have"


@cache
def grammar() -> Any:
    """The parser of one code line (start rule `line`) or variable line (`data`)."""
    from lark import Lark

    text = read_grammar("melfa_basic.lark")
    roles: tuple[Role, ...] = ("motion", "command")
    for role in roles:
        others = [word for word in words(role) if f"\n{word.upper()}.3:" not in text]
        any_of = "|".join(sorted(map(_spaced, others), key=len, reverse=True))
        text += f"\n{role.upper()}.3: /({any_of})(?![A-Z0-9_])" + (
            "|mxt(?=[0-9])/i" if role == "command" else "/i"
        )
    text = text.replace("%declare MOTION COMMAND", "")
    return Lark(text, start=["line", "data"], parser="lalr", maybe_placeholders=True)


def _spaced(word: str) -> str:
    return "end[ \\t]?if" if word == "EndIf" else word.replace(" ", "[ \\t]+")


@cache
def _nodes() -> Any:
    from assistant.languages.melfa_basic.transformer import ToNodes

    return ToNodes()


def _with_data(items: list[s.Item]) -> list[s.Item]:
    """Variable lines at the end told apart from assignments: they have no step number.

    In a source without step numbers they are what follows the last other statement.
    """
    numbered = any(isinstance(item, s.Line) and item.number is not None for item in items)
    first = len(items)
    if not numbered and not any(isinstance(item, MoveRows) for item in items):
        while first and (
            isinstance(items[first - 1], s.Blank | PositionRows) or _datum(items[first - 1])
        ):
            first -= 1
    else:
        first = 0
    for at in range(first, len(items)):
        datum = _datum(items[at])
        if datum is not None:
            items[at] = datum
    return items


def _datum(item: s.Item) -> s.Data | None:
    """An unnumbered assignment of a constant, or declaration of one, as a variable line."""
    if not isinstance(item, s.Line) or item.number is not None or item.label or item.comment:
        return None
    value: object = None
    match item.statement:
        case s.Assign(target=target, value=value, delay=None) if not target.component:
            plain = (
                value.operand if isinstance(value, s.Unary) and value.operator in "+-" else value
            )
            if isinstance(plain, s.Constant | s.Number | s.String) and isinstance(
                value, s.Constant | s.Number | s.String | s.Unary
            ):
                return s.Data(target, value, "", item.span)
    return None
