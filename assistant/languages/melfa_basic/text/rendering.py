"""The text of a tree: what was read as it stood, what changed in its place, what is new printed."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from assistant.languages.melfa_basic.tables.dialects import DIALECTS
from assistant.languages.melfa_basic.text.changed_lines import Code, of_line
from assistant.languages.melfa_basic.text.changed_rows import moves, positions
from assistant.languages.melfa_basic.text.layout.levels import levels
from assistant.languages.melfa_basic.text.layout.printing import decimals, item_text, print_items
from assistant.languages.melfa_basic.text.printer import INDENT
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.columnar import MoveRows, PositionRows
from assistant.languages.melfa_basic.tree.line_tables import as_rows
from assistant.languages.texts.alignment import same
from assistant.languages.texts.changed_lines import Indentation, changed_line, partners, parts_of
from assistant.program.text import dominant_newline


def render(file: s.File) -> str:
    """The text of a tree; lines that were read and not changed keep their bytes."""
    if file.source is None:
        return "".join(print_items(file.items, file.dialect, "\r\n"))
    if file.items is file.parsed:
        return file.source.text
    text = file.source.text
    newline = dominant_newline(text) if "\n" in text else file.source.newline
    parts: list[str] = []
    for part in _Changes(file, text, newline).texts():
        if parts and parts[-1] and not parts[-1].endswith("\n"):
            parts.append(newline)  # the last line of a file may have no line end
        parts.append(part)
    return "".join(parts)


class _Changes:
    """The items of a file against those that were read from its text. newline: of new lines."""

    def __init__(self, file: s.File, text: str, newline: str) -> None:
        self._new, self._old = file.items, file.parsed
        self._text, self._newline = text, newline
        self._dialect = DIALECTS[file.dialect]
        self._partner = partners(self._old, self._new, _said)
        kept = {
            at
            for at, item in zip(self._partner, self._new, strict=True)
            if at is not None and same(self._old[at], item)
        }
        self._lost = [
            (rows, _ended(self._source(item), self._newline))
            for at, item in enumerate(self._old)
            if at not in kept and isinstance(rows := as_rows(item), PositionRows)
        ]
        self._indents = Indentation(INDENT)
        self._code = Code(self._dialect.upper)
        for item, level in self._levels(self._old):
            if level not in self._indents:
                self._note(item, self._source(item), level)

    def _levels(self, items: Sequence[s.Item]) -> Iterator[tuple[s.Item, int]]:
        """The items with the level that each stands at."""
        for item, level in zip(items, levels(items), strict=True):
            yield item, level if self._dialect.blocks else 0

    def _note(self, item: s.Item, text: str, level: int) -> None:
        """Keeps in mind how lines as deep are indented."""
        if isinstance(item, MoveRows):
            self._indents.note(level, _row_indent(text))
        elif isinstance(item, s.Line) and (item.statement or item.label):
            self._indents.note(level, parts_of(text, of_line(item)).indent)

    def texts(self) -> Iterator[str]:
        """The text of each item, with its line ends."""
        places = decimals(self._new)
        levels = self._levels(self._new)
        for (item, level), at, decimal in zip(levels, self._partner, places, strict=True):
            old = None if at is None else self._old[at]
            if old is not None and same(old, item):
                text = self._source(old)
                self._note(old, text, level)
                yield text
            else:
                yield self._changed(item, old, level, decimal)

    def _source(self, item: s.Item) -> str:
        assert item.span is not None
        return self._text[item.span.start : item.span.end]

    def _changed(self, item: s.Item, old: s.Item | None, level: int, places: int) -> str:
        """An item that is new or not what it was."""
        upper = self._dialect.upper
        match item, old:
            case s.Line(), s.Line():
                was, now = of_line(old), of_line(item)
                text = changed_line(parts_of(self._source(old), was), was, now, self._code)
                self._note(item, text, level)
                return text
            case MoveRows(), MoveRows():
                text = self._source(old)
                self._note(old, text, level)
                deep = len(self._indents.of(level)) - 1
                return moves(item, old, text, self._newline, upper, deep)
            case ((PositionRows() | s.Data()), _):
                rows = as_rows(item)
                if isinstance(rows, PositionRows) and self._lost:
                    return positions(rows, self._lost, self._newline)
        printed = item_text(item, upper, self._newline, places, 0)
        if isinstance(item, s.Line) and (item.statement or item.label or item.comment):
            step = "" if item.number is None else str(item.number)
            indent = self._indents.of(level)
            if not step and level not in self._indents:
                indent = indent.removeprefix(" ")
            return step + (indent or " " * bool(step)) + printed.removeprefix(step).lstrip(" ")
        return printed


def _row_indent(text: str) -> str:
    """The blanks behind the first step number of a table of moves, at least one."""
    first = text[: text.index("\n")].lstrip("0123456789")
    return first[: len(first) - len(first.lstrip(" "))]


def _ended(text: str, newline: str) -> str:
    return text if text.endswith("\n") else text + newline


def _said(item: s.Item) -> object:
    """What an item says, whatever its step numbers; it can be compared and hashed."""
    match item:
        case s.Line(label=label, statement=statement, comment=comment):
            return label, statement, comment
        case MoveRows(stem=stem, kinds=kinds, start=start, via=via, end=end):
            return stem, *(column.tobytes() for column in (kinds, start, via, end))
    return item
