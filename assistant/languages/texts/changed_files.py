"""The text of a changed file of lines: what was read as it stood, what changed in its place.

Lines of one kind may stand in tables, `Run`s: those of the program with its numbers, and data that
are known by a number. Of a table that changed the rows that did not keep their bytes.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from assistant.base.source_text import SourceText, dominant_newline
from assistant.languages.runs.columns import Run, joined_runs
from assistant.languages.runs.merging import merged_run_text
from assistant.languages.runs.names import rows_of
from assistant.languages.texts.alignment import same
from assistant.languages.texts.changed_lines import (
    Indentation,
    Line,
    changed_line,
    partners,
    parts_of,
)
from assistant.languages.texts.lines import LinePrinter


def render_changed_file(source: SourceText, old: Sequence[Any], lines: LinePrinter) -> str:
    """The text of items that were made from old ones, which were read from the source."""
    newline = dominant_newline(source.text) if "\n" in source.text else source.newline
    parts: list[str] = []
    for part in _FileChanges(source.text, old, lines, newline).texts():
        if parts and parts[-1] and not parts[-1].endswith("\n"):
            parts.append(newline)  # the last line of a file may have no line end
        parts.append(part)
    return "".join(parts)


class _FileChanges:
    """The items of a file against those that were read from its text. newline: of new lines."""

    def __init__(self, text: str, old: Sequence[Any], lines: LinePrinter, newline: str) -> None:
        self._text, self._old, self._new = text, old, lines.items
        self._lines, self._newline = lines, newline
        self._as_line = {id(item): lines.line(item) for item in (*old, *self._new)}
        self._partner = partners(old, self._new, self._said)
        kept = {
            at
            for at, item in zip(self._partner, self._new, strict=True)
            if at is not None and same(old[at], item)
        }
        self._lost = [
            (rows, text if (text := self._source(item)).endswith("\n") else text + newline)
            for at, item in enumerate(old)
            if at not in kept and (rows := lines.as_data(item)) is not None
        ]
        self._indents = Indentation()
        for item, level in zip(old, self._levels(old), strict=True):
            if level not in self._indents:
                self._note(item, self._source(item), level)

    def _levels(self, items: Sequence[Any]) -> Sequence[int]:
        return self._lines.levels([self._as_line[id(item)] for item in items])

    def _said(self, item: Any) -> object:
        """What an item says, whatever its numbers; it can be compared and hashed."""
        if isinstance(item, self._lines.table):
            return item.said({"steps"})
        line = self._as_line[id(item)]
        return item if line is None else (line.code, line.comment)

    def _note(self, item: Any, text: str, level: int) -> None:
        """Keeps in mind how lines as deep are indented."""
        if isinstance(item, self._lines.table):
            first = parts_of(text[: text.index("\n")], Line(0, None, None))
            self._indents.note(level, first.indent)
        elif (line := self._as_line[id(item)]) is not None and line.code is not None:
            self._indents.note(level, parts_of(text, line).indent)

    def texts(self) -> Iterator[str]:
        """The text of each item, with its line ends."""
        levels = self._levels(self._new)
        for k, (item, at, level) in enumerate(zip(self._new, self._partner, levels, strict=True)):
            old = None if at is None else self._old[at]
            if old is not None and same(old, item):
                text = self._source(old)
                self._note(old, text, level)
                yield text
            else:
                changed = self._changed(item, old, level)
                yield self._indented(k, level) if changed is None else changed

    def _source(self, item: Any) -> str:
        return self._text[item.span.start : item.span.end]

    def _changed(self, item: Any, old: Any, level: int) -> str | None:
        """An item that is not what it was, None for one that is new."""
        was, now = self._as_line.get(id(old)), self._as_line[id(item)]
        if was is not None and now is not None:
            text = changed_line(parts_of(self._source(old), was), was, now, self._lines)
            self._note(item, text, level)
            return text
        if isinstance(item, self._lines.table) and isinstance(old, self._lines.table):
            text = self._source(old)
            self._note(old, text, level)
            deep = len(self._indents.of(level)) - 1
            return self._rows(item, [(old, text)], deep)
        rows = self._lines.as_data(item)
        return None if rows is None or not self._lost else self._rows(rows, self._lost, 0)

    def _rows(self, new: Run, olds: Sequence[tuple[Run, str]], indent: int) -> str:
        """The lines of a table made from others, which were read from the texts beside them."""
        fresh = self._lines.rows(new, self._newline, indent)
        fitting = [(rows, text) for rows, text in olds if rows.fits(new)]
        if not fitting:
            return fresh(new)
        old, text = joined_runs([rows for rows, _ in fitting]), "".join(text for _, text in fitting)
        steps = isinstance(new, self._lines.table)
        number = "steps" if steps else self._lines.number
        if steps and len(old) == len(new):
            at = np.arange(len(new))
        else:
            at = rows_of(getattr(old, number), getattr(new, number))
        return merged_run_text(new, old, text, at, fresh, number if steps else None)

    def _indented(self, at: int, level: int) -> str:
        """A new item, a line as deep as those around it."""
        printed = self._lines.text(at, self._newline)
        line = self._as_line[id(self._new[at])]
        if line is None or not (line.code or line.comment):
            return printed
        number = "" if line.number is None else str(line.number)
        indent = self._indents.of(level)
        if not number and level not in self._indents:
            indent = indent.removeprefix(" ")
        return number + (indent or " " * bool(number)) + printed.removeprefix(number).lstrip(" ")
