"""Text of RAPID to the typed tree: runs as columns first, the rest by the lark grammar."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any, Final, Literal

from assistant.base.budgets import without_gc
from assistant.base.diagnostics import Diagnostic, Span
from assistant.base.source_text import SourceText, with_line_feeds
from assistant.languages.grammar import RunInTheWay, Shortened
from assistant.languages.lalr import Stack
from assistant.languages.rapid import rules
from assistant.languages.rapid.reading import files
from assistant.languages.rapid.reading.rows import RunNode, Runs, find_runs
from assistant.languages.rapid.tables.words import MOST_NESTING, MOST_OPERATORS
from assistant.languages.rapid.tree.syntax import File, Item, Origin, StatementNode, TargetRunNode
from assistant.languages.runs.row_text import Found


def parse(source: SourceText | str, *, runs: bool = True) -> File:
    """The tree of a file; of a damaged one what could be read, with a finding for each place.

    A list of modules (`.pgf`) has no parts: `files.listed` tells what it names.
    runs: False has the grammar read every line, which gives the same with a node a row.
    """
    text = source if isinstance(source, SourceText) else _source(source)
    unreadable = files.unreadable(text)
    if unreadable is None and files.is_list(text.text):
        return File((), None, Origin(text, ()), tuple(files.notes(text)))
    reading = unreadable or _read(text, "start", runs=runs)
    if isinstance(reading, Diagnostic):
        return File((), None, Origin(text, ()), (reading,))
    (header, parts), findings = reading
    if findings and not text.text.lstrip().startswith("%%%"):
        header = None  # a header that was put in to read on
    told = {finding.span.start for finding in findings if finding.span}
    odd = (one for one in text.odd_characters() if one.span is None or one.span.start not in told)
    noted = (*odd, *files.notes(text), *findings)
    return File(parts, header, Origin(text, parts), noted)


def _source(text: str) -> SourceText:
    encoding = "ascii" if text.isascii() else "utf-8"
    return SourceText(text, encoding=encoding, newline=files.newline_of(text))


def parse_statements(text: str) -> tuple[StatementNode, ...] | Diagnostic:
    """A list of statements, or what is wrong with it."""
    read: tuple[StatementNode, ...] | Diagnostic = _read_part(text, "statements")
    return read


def parse_items(text: str) -> tuple[Item, ...] | Diagnostic:
    """A list of declarations and routines, or what is wrong with it."""
    read: tuple[Item, ...] | Diagnostic = _read_part(text, "items")
    return read


def parse_rows(
    text: str, spans: Sequence[Span], start: Literal["statements", "items"]
) -> list[Any]:
    """The lines of a run that are at these places of a text, a node each.

    start: moves are statements, declarations are items of a module. A damaged line, which was
    mended when it was read, is mended once more.
    """
    from assistant.languages.rapid.reading.grammar import grammar
    from assistant.languages.rapid.reading.nodes import SingleNodes
    from assistant.languages.rapid.reading.scanner import table_words

    tables, words = grammar().tables[start], table_words()
    found: list[Any] = []
    for span in spans:
        line = with_line_feeds(text[span.start : span.end])
        line += ";" * (not line.endswith(";"))  # a statement ends before it
        stack = Stack(tables.first)
        read = words.sound(line, tables.rows, stack.states)
        if tables.drive(stack, read, SingleNodes(line, span.start.__add__, ())) is None:
            found += stack.values[0]
            continue
        mended = _read(SourceText(" " * span.start + line), start, runs=False)
        found += () if isinstance(mended, Diagnostic) else mended[0]
    return found


def _read_part(text: str, start: str) -> Any:
    source = SourceText(text)
    reading = files.unreadable(source) or _read(source, start, runs=False)
    if isinstance(reading, Diagnostic):
        return reading
    tree, findings = reading
    return findings[0] if findings else tree


@without_gc()
def _read(
    source: SourceText, start: str, *, runs: bool
) -> tuple[Any, tuple[Diagnostic, ...]] | Diagnostic:
    """What the typed tree is made of, and the findings; or why the text cannot be read."""
    from assistant.languages.rapid.reading.grammar import grammar
    from assistant.languages.rapid.reading.nodes import Nodes
    from assistant.languages.rapid.reading.scanner import table_words

    text = with_line_feeds(source.text)
    tables = grammar().tables[start]
    found: Runs = list(find_runs(text)) if runs else []
    while True:
        short = Shortened.of(text, found, _marks)
        if (long := _too_long(short.text)) is not None:
            at = short.offset(long)
            return source.finding(rules.TOO_LONG, Span(at, at + 1), most=MOST_OPERATORS)
        nodes = Nodes(short.text, short.offset if found else None, found)
        stack = Stack(tables.first)
        read = table_words().sound(short.text, tables.rows, stack.states)
        sound = tables.drive(stack, read, nodes) is None
        if sound and stack.deepest < MOST_NESTING:
            return stack.values[0], ()
        if (deep := _too_deep(short.text)) is not None:
            at = short.offset(deep)
            return source.finding(rules.TOO_DEEP, Span(at, at + 1), most=MOST_NESTING)
        if sound:
            return stack.values[0], ()
        from assistant.languages.rapid.reading.recovery.reader import reader

        reading = reader().read(source, text, short, tables, nodes)
        if not isinstance(reading, RunInTheWay):
            value = nodes.start(None, [None]) if reading.value is None else reading.value
            return value, reading.findings
        # What stands before the run wants its first row for itself: `IF x` and a line end.
        found = _without_first_row(text, found, reading.number)


def _marks(found: Found[RunNode]) -> tuple[str, str]:
    opening, closing = (
        files.RUN_MARKS[:2] if isinstance(found.node, TargetRunNode) else files.RUN_MARKS[2:]
    )
    return opening, closing


def _without_first_row(text: str, found: Runs, number: int) -> Runs:
    run = found[number]
    second = text.find("\n", run.start, run.end) + 1
    rest = find_runs(text[second : run.end]) if second else ()
    moved = (one.moved(second) for one in rest)
    return [*found[:number], *moved, *found[number + 1 :]]


_LONG_STRETCH: Final = re.compile(rf"[^;]{{{2 * MOST_OPERATORS},}}")
_OPERATOR_COUNT: Final = re.compile(
    r"![^\n]*|\"[^\"\n]*\"|(?P<open>[\[({])|(?P<close>[\])}])|(?P<end>,|:=)"
    r"|(?P<operator>[-+*/.<>=]|\b(?:and|or|xor|div|mod|not)\b)",
    re.IGNORECASE,
)


def _too_long(text: str) -> int | None:
    """Offset of an operator that is one too many in its expression, None if there is none."""
    for stretch in _LONG_STRETCH.finditer(text):
        counts = [0]
        for match in _OPERATOR_COUNT.finditer(text, stretch.start(), stretch.end()):
            if match["open"]:
                counts.append(0)
            elif match["close"]:
                counts = counts[:-1] or [0]
            elif match["end"]:
                counts[-1] = 0
            elif match["operator"]:
                counts[-1] += 1
                if counts[-1] > MOST_OPERATORS:
                    return match.start()
    return None


_NESTING: Final = re.compile(
    r"![^\n]*|\"[^\"\n]*\"|(?P<open>[\[({]|\b(?:if|for|while|test)\b)"
    r"|(?P<close>[\])}]|\bend(?:if|for|while|test)\b)|;|\bthen\b|(?P<routine>\b(?:proc|func|trap)\b)",
    re.IGNORECASE,
)


def _too_deep(text: str) -> int | None:
    """Offset at which brackets or blocks stand too deep inside each other, None if they do not."""
    depth = compact = 0
    for match in _NESTING.finditer(text):
        word = match[0].lower()
        if match["open"]:
            depth += 1
            compact += word == "if"
            if depth > MOST_NESTING:
                return match.start()
        elif match["close"]:
            depth = max(depth - 1, 0)
        elif match["routine"]:
            depth = compact = 0
        elif word == "then":
            compact = max(compact - 1, 0)
        elif word == ";" and compact:  # IF without THEN ends with its statement
            depth, compact = max(depth - compact, 0), 0
    return None
