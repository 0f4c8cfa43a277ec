"""Text of RAPID to the typed tree: runs as columns first, the rest by the lark grammar."""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from itertools import accumulate
from typing import TYPE_CHECKING, Any, Final

from assistant.languages.rapid import rules
from assistant.languages.rapid.rows import Found, find_runs
from assistant.languages.rapid.runs import TargetRun
from assistant.languages.rapid.syntax import File, Item, Origin, StatementNode
from assistant.languages.rapid.tables import MOST_NESTING
from assistant.program.collecting import uncollected
from assistant.program.diagnostics import Diagnostic, Span
from assistant.program.text import SourceText
from assistant.resources import read_grammar

if TYPE_CHECKING:
    from lark import Lark

_MARKS: Final = "\x02\x03\x04\x05"
"""Characters that stand for runs in what the grammar reads."""


def parse(source: SourceText | str, *, runs: bool = True) -> File:
    """The tree of a file; bad text gives a tree without parts and a finding.

    runs: False has the grammar read every line, which gives the same with a node a row.
    """
    text = source if isinstance(source, SourceText) else _source(source)
    with uncollected():
        reading = _read(text, "start", runs=runs)
    if isinstance(reading, Diagnostic):
        return File((), None, Origin(text, ()), (reading,))
    header, parts = reading
    return File(parts, header, Origin(text, parts))


def _source(text: str) -> SourceText:
    newline = "\r\n" if "\r\n" in text or "\n" not in text else "\n"
    return SourceText(text, encoding="ascii" if text.isascii() else "utf-8", newline=newline)


def parse_statements(text: str) -> tuple[StatementNode, ...] | Diagnostic:
    """A list of statements, or what is wrong with it."""
    read: tuple[StatementNode, ...] | Diagnostic
    read = _read(SourceText(text), "statements", runs=False)
    return read


def parse_items(text: str) -> tuple[Item, ...] | Diagnostic:
    """A list of declarations and routines, or what is wrong with it."""
    read: tuple[Item, ...] | Diagnostic
    read = _read(SourceText(text), "items", runs=False)
    return read


def _read(source: SourceText, start: str, *, runs: bool) -> Any:
    if (at := max(source.text.find(mark) for mark in _MARKS)) >= 0:
        return source.finding(
            rules.SYNTAX,
            Span(at, at + 1),
            found="a control character",
            expected="text",
            hint="delete it",
        )
    found = list(find_runs(source.text)) if runs else []
    while True:
        short = _Shortened.of(source.text, found)
        reading = _grammar_reads(source, short, start)
        if not isinstance(reading, _RunInTheWay):
            return reading
        # What stands before the run wants its first row for itself: `IF x` and a line end.
        found = _without_first_row(source.text, found, reading.number)


@dataclass(frozen=True, slots=True)
class _Shortened:
    """A text with a mark in place of each run, and the way back to the offsets of the text."""

    text: str
    runs: Sequence[Found]
    begins: list[int]
    shifts: list[int]

    @staticmethod
    def of(text: str, runs: Sequence[Found]) -> _Shortened:
        pieces, at = [], 0
        lengths, removed = [], []
        for number, run in enumerate(runs):
            opening, closing = (
                ("\x02", "\x03") if isinstance(run.run, TargetRun) else ("\x04", "\x05")
            )
            mark = f"{opening}{number}{closing}\n"
            pieces += [text[at : run.start], mark]
            lengths.append(run.start - at + len(mark))
            removed.append(run.end - run.start - len(mark))
            at = run.end
        pieces.append(text[at:])
        begins = list(accumulate(lengths, initial=0))
        return _Shortened("".join(pieces), runs, begins, list(accumulate(removed, initial=0)))

    def offset(self, short: int) -> int:
        return short + self.shifts[bisect_right(self.begins, short) - 1]


@dataclass(frozen=True, slots=True)
class _RunInTheWay:
    number: int


def _without_first_row(text: str, found: Sequence[Found], number: int) -> list[Found]:
    run = found[number]
    second = text.find("\n", run.start, run.end) + 1
    rest = list(find_runs(text[second : run.end])) if second else []
    moved = [Found(f.start + second, f.end + second, f.run, f.scope) for f in rest]
    return [*found[:number], *moved, *found[number + 1 :]]


@cache
def grammar() -> Lark:
    from lark import Lark

    return Lark(
        read_grammar("rapid.lark"),
        parser="lalr",
        lexer="contextual",
        start=["start", "statements", "items"],
        propagate_positions=True,
        maybe_placeholders=True,
    )


def _grammar_reads(source: SourceText, short: _Shortened, start: str) -> Any:
    from lark.exceptions import UnexpectedInput, VisitError

    from assistant.languages.rapid.nodes import Nodes

    if (deep := _too_deep(short.text)) is not None:
        at = short.offset(deep)
        return source.finding(rules.TOO_DEEP, Span(at, at + 1), most=MOST_NESTING)
    try:
        tree = grammar().parse(short.text, start=start)
    except UnexpectedInput as error:
        token = getattr(error, "token", None)
        if token is not None and token.type in ("TARGETS", "MOVES"):
            return _RunInTheWay(int(token[1:-1]))
        stopped: int | None = getattr(error, "pos_in_stream", None)
        if stopped is not None and short.text[stopped : stopped + 1] in tuple("\x02\x04"):
            return _RunInTheWay(int(re.findall(r"\d+", short.text[stopped:])[0]))
        return _syntax_error(source, short, error)
    try:
        return Nodes(short.text, short.offset, short.runs).transform(tree)
    except VisitError as error:
        raise error.orig_exc from None


_DEPTH: Final = re.compile(
    r"![^\n]*|\"[^\"\n]*\"|(?P<open>[\[({]|\b(?:if|for|while|test)\b)"
    r"|(?P<close>[\])}]|\bend(?:if|for|while|test)\b)|;|\bthen\b",
    re.IGNORECASE,
)


def _too_deep(text: str) -> int | None:
    """Offset at which brackets or blocks stand too deep inside each other, None if they do not."""
    depth = compact = 0
    for match in _DEPTH.finditer(text):
        word = match[0].lower()
        if match["open"]:
            depth += 1
            compact += word == "if"
            if depth > MOST_NESTING:
                return match.start()
        elif match["close"]:
            depth = max(depth - 1, 0)
        elif word == "then":
            compact = max(compact - 1, 0)
        elif word == ";" and compact:  # IF without THEN ends with its statement
            depth, compact = max(depth - compact, 0), 0
    return None


def _syntax_error(source: SourceText, short: _Shortened, error: Exception) -> Diagnostic:
    from assistant.languages.rapid import mistakes

    given: Any = getattr(error, "pos_in_stream", None)
    token = getattr(error, "token", None)
    if given is None or (token is not None and token.type == "$END"):
        given = len(short.text.rstrip())
    at = min(int(given), len(short.text))
    expected = set(getattr(error, "accepts", None) or getattr(error, "expected", None) or ())
    expected |= set(getattr(error, "allowed", None) or ())
    word = re.match(r"[A-Za-z_]\w*|[0-9.]+|:=|<=|>=|<>|==|\"[^\"\n]*\"?|.|", short.text[at:])
    found = word[0] if word else ""
    begin = short.offset(at)
    return source.finding(
        rules.SYNTAX,
        Span(begin, begin + max(len(found), 1)),
        found=mistakes.found(found),
        expected=mistakes.expected(expected),
        hint=mistakes.cure(short.text[:at], found, expected),
    )
