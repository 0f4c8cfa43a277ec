"""Text to tree: tables of plain rows at once, every other line through the grammar.

Lines with errors go to the recovery, which is loaded only then. `mended` repairs a text whose
damage leaves no doubt of what is meant: word processors and other keyboards write marks that no
controller takes, and comments lose their mark. Such a text remains an error in its file, but
another language can be given what it means.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import compress
from typing import Final

from assistant.base.arrays import Truths
from assistant.base.budgets import without_gc
from assistant.base.diagnostics import Diagnostic, Severity, Span, has_errors
from assistant.base.source_text import SourceText, with_line_feeds
from assistant.languages.melfa_basic import rules
from assistant.languages.melfa_basic.reading.files import TOKENISED
from assistant.languages.melfa_basic.reading.line import TooLarge, read_line, split_step, statement
from assistant.languages.melfa_basic.tables.variables import TAUGHT_STATUS
from assistant.languages.melfa_basic.tables.vocabulary import status
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.columnar import MoveRows, PositionRows, row_spans, rows_at
from assistant.languages.melfa_basic.tree.control_flow import exits_of, statement_of
from assistant.languages.melfa_basic.tree.syntax import File
from assistant.languages.recovery.syntax import Stop

__all__ = ["parse", "statement"]

TOO_LARGE: Final = "a number is too large"
SMALLER: Final = "write one that a variable can hold"


@without_gc()
def parse(source: SourceText | str, dialect: str, *, runs: bool = True) -> s.File:
    """The tree of a program or position list; what cannot be read is a finding, never raised.

    runs: False has the grammar read every line, which gives the same with a node a row.
    """
    source = source if isinstance(source, SourceText) else SourceText(source)
    if source.text.startswith(TOKENISED.decode()):
        finding = rules.TOKENISED(path=source.path, line=1, column=1)
        whole = s.Unread(source.text, Span(0, len(source.text)))
        return s.File(dialect, (whole,), (finding,), source, (whole,))
    text = with_line_feeds(source.text)
    items: list[s.Item] = []
    findings: list[Diagnostic] = list(source.odd_characters())
    for start, end in _pieces(text, items, runs):
        stop = start + len(text[start:end].rstrip("\r\n"))
        node = read_line(text, start, stop, end)
        if isinstance(node, Stop):
            # Recovery is expensive to load, and most files need none.
            from assistant.languages.melfa_basic.reading.mistakes import recovery_reader

            item, found = recovery_reader().read(source, start, stop, node, len(findings))
            span = Span(start, end)
            unread = s.Unread(source.text[start:stop], span)
            items.append(unread if item is None else replace(item, span=span))
            findings += found
        elif isinstance(node, TooLarge):
            at = Span(split_step(text, start, stop)[1], stop)
            findings.append(source.finding(rules.SYNTAX, at, what=TOO_LARGE, cure=SMALLER))
            items.append(s.Unread(text[start:stop], Span(start, end)))
        else:
            items.append(node)
    parsed = tuple(_with_data(items))
    return s.File(dialect, parsed, tuple(findings), source, parsed)


def read_rows(text: str, rows: MoveRows | PositionRows, chosen: Truths) -> list[s.Item]:
    """Some rows (n,) of a table as the grammar reads their lines. text: of the table."""
    found: list[s.Item] = []
    for span in compress(row_spans(rows), chosen.tolist()):
        start, stop = span.start, span.start + len(text[span.start : span.end].rstrip("\r\n"))
        node = read_line(text, start, stop, span.end)
        assert isinstance(node, s.Line | s.Data), text[start:stop]
        found.append(_datum(node) or node if isinstance(rows, PositionRows) else node)
    return found


def _pieces(text: str, items: list[s.Item], runs: bool) -> Iterator[tuple[int, int]]:
    """The offsets of lines that are left for the grammar; tables and empty ones are items."""
    at, size = 0, len(text)
    while at < size:
        if text[at] == "\n":
            items.append(s.Blank(Span(at, at + 1)))
            at += 1
            continue
        rows = rows_at(text, at) if runs else None
        if rows is not None and rows.span is not None:
            items.append(rows)
            at = rows.span.end
            continue
        end = text.find("\n", at) + 1 or size
        yield at, end
        at = end


def _with_data(items: list[s.Item]) -> list[s.Item]:
    """Variable lines at the end told apart from assignments: they have no step number.

    In a source without step numbers they are what follows the last other statement. A number or a
    text that the program comes to is assigned there; what it cannot come to is a variable line.
    """
    # In a file with step numbers, lines without them are variable lines.
    numbered = any(isinstance(item, s.Line) and item.number is not None for item in items)
    first = 0
    if not numbered and not any(isinstance(item, MoveRows) for item in items):
        first = len(items)
        while first and (
            isinstance(items[first - 1], s.Blank | PositionRows) or _datum(items[first - 1])
        ):
            first -= 1
        while first < len(items) and _is_come_to(items, first):
            first += 1
    return items[:first] + [_datum(item) or item for item in items[first:]]


def _is_come_to(items: list[s.Item], at: int) -> bool:
    """True if control reaches an assignment of a number or a text, or a blank line."""
    match items[at]:
        case s.Line(statement=s.Assign(value=s.Constant())):
            return False
        case s.Line() | s.Blank():
            before = next((x for x in items[at - 1 :: -1] if _runs(x)), None) if at else None
            return before is not None and exits_of(statement_of(before)).on
    return False


def _runs(item: s.Item) -> bool:
    return isinstance(item, s.Line) and item.statement is not None


def _datum(item: s.Item) -> s.Data | None:
    """An unnumbered assignment of a constant, or declaration of one, as a variable line."""
    match item:
        case s.Line(None, None, s.Assign(s.Variable(component="") as target, value, None), None):
            # A line with the name of a status variable would set it, except for positions that are
            # taught.
            if status(target.name) is not None and target.name.upper() not in TAUGHT_STATUS:
                return None
            match value:
                case (s.Constant() | s.Number() | s.String()) | s.Unary(
                    "+" | "-", s.Constant() | s.Number() | s.String()
                ):
                    return s.Data(target, value, "", item.span)
    return None


_PLAIN_MARKS: Final = str.maketrans({
    **dict.fromkeys("‘’‚‛′´`＇", "'"),
    **dict.fromkeys("“”„‟″＂", '"'),
    **dict.fromkeys("，、", ","),
    **dict.fromkeys("–—−－", "-"),
    **dict.fromkeys("\u3000\u00a0\ufeff", " "),
    **{chr(code): " " for code in range(0x2000, 0x200C)},
})  # fmt: skip
"""The marks that findings of `rules.QUOTES` are about; each takes one character, as before."""
CERTAIN_FINDINGS: Final = (rules.QUOTES.code, rules.REMARK.code)


def mended(tree: File, dialect: str) -> File | None:
    """The tree of what is certainly meant, its findings as warnings; None if that is not known.

    Lines keep their numbers.
    """
    errors = [f for f in tree.findings if f.severity is Severity.ERROR]
    source = tree.source
    if source is None or any(f.code not in CERTAIN_FINDINGS or f.span is None for f in errors):
        return None
    text = source.text
    # From the last finding to the first, so that the offsets of those in front stay right.
    for finding in sorted(errors, key=lambda f: -f.span.start if f.span else 0):
        text = _replaced(text, finding)
    again = parse(replace(source, text=text), dialect)
    if has_errors(again.findings):
        return None
    told = (replace(f, severity=Severity.WARNING) for f in tree.findings)
    return replace(again, findings=tuple(told))


def _replaced(text: str, finding: Diagnostic) -> str:
    span = finding.span
    assert span is not None
    if finding.code == rules.REMARK.code:
        return f"{text[: span.start]}'{text[span.start :]}"
    inside = text[span.start : span.end]
    plain = inside.translate(_PLAIN_MARKS)
    if plain.startswith("'"):  # a comment, which keeps its own marks
        plain = f"'{inside[1:]}"
    return text[: span.start] + plain + text[span.end :]
