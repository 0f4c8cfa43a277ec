"""Changes of a program of lines, made in the lines that it was lifted from.

The parts of each line, as a label, a statement and a comment, are entries of their own. A table of
like lines is compared row by row, and stays one where nothing happened to it.
"""

from __future__ import annotations

import abc
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any, Final, NamedTuple

import numpy as np

from assistant.languages.line_steps import steps_of, with_steps
from assistant.languages.runs.columns import Run
from assistant.languages.texts import merging
from assistant.languages.texts.merging import Entry

MOST_ROWS: Final = 1 << 10
"""Rows of a table that are compared one by one; a longer one is the same or it is not."""


class LinePart(NamedTuple):
    """What one field of a line says.

    key: whatever its layout. kind: what parts that may take each other's place have in common.
    setting: the word of a statement that holds for what follows.
    """

    field: str
    key: str
    kind: object = None
    setting: str | None = None


class LineMerger(abc.ABC):
    """Puts changes into the lines of a program.

    line: a record whose fields have defaults that say nothing. table: many lines of the program.
    header: what the keys of the first and the last comment begin with that keep what the language
    cannot say.
    """

    line: type[Any]
    table: type[Run]
    header: tuple[str, str]

    @abc.abstractmethod
    def parts(self, line: Any) -> Iterator[LinePart]:
        """What a line says, in order."""

    @abc.abstractmethod
    def rows_as_lines(self, rows: Any) -> Iterator[Any]:
        """The rows of a table as lines."""

    def entries(self, items: Sequence[Any]) -> list[Entry]:
        """The entries of all lines of the program, in order."""
        found: list[Entry] = []
        for at, item in enumerate(items):
            if isinstance(item, self.line):
                found += self._of_line(item, at, -1)
            elif isinstance(item, self.table):
                if len(item) > MOST_ROWS:
                    key = f"table {hash(item.said({'steps'}))}"
                    bare = with_steps(item.rows(slice(None)), np.zeros_like(steps_of(item)))
                    found.append(Entry(key, self.table, None, at, -1, "", bare))
                    continue
                for row, line in enumerate(self.rows_as_lines(item)):
                    found += self._of_line(line, at, row)
        return found

    def _of_line(self, line: Any, at: int, row: int) -> Iterator[Entry]:
        for field, key, kind, setting in self.parts(line):
            alone = self.line(**{field: getattr(line, field)})
            yield Entry(key, (field, kind), setting, at, row, field, alone)

    def merged(
        self, items: Sequence[Any], before: Sequence[Any], after: Sequence[Any]
    ) -> Iterator[list[Any]]:
        """The lines with everything changed that differs between two built programs.

        One outcome for each way to tell where that goes: what is new stands behind what is above
        it or before what follows it, and settings that the lines state once are stated again
        behind a changed one or they are not.
        """
        here, old, new = map(self.entries, (items, before, after))
        if not any(entry.key.startswith(self.header[0]) for entry in here):
            old, new = map(self._headless, (old, new))
        place = merging.matched_entries(old, here)
        found = merging.changes(old, new)
        changed = {at for change in found for at in range(change.first, change.stop)}
        for forward, restored in product((False, True), (False, True)):
            edits = _LineEdits(here, place, forward, language=self)
            if all(edits.take(change) for change in found):
                for change in found if restored else ():
                    edits.restore(change, old, changed)
                yield edits.items(items)

    def _headless(self, listed: list[Entry]) -> list[Entry]:
        end = next((at for at, e in enumerate(listed) if e.key.startswith(self.header[1])), -1)
        return listed[end + 1 :]


@dataclass(kw_only=True)
class _LineEdits(merging.Edits):
    """What is done to the entries of a program."""

    language: LineMerger

    def items(self, items: Sequence[Any]) -> list[Any]:
        """The items with all edits done; tables that nothing happened to stay one."""
        touched = {self.here[at].at for at in self.replaced}
        for gap in self.put:
            if 0 < gap < len(self.here) and self.here[gap - 1].at == self.here[gap].at:
                touched.add(self.here[gap].at)
        of: dict[int, list[int]] = {}
        for index, entry in enumerate(self.here):
            of.setdefault(entry.at, []).append(index)
        made: list[Any] = []
        last = -1
        for at, item in enumerate(items):
            mine = of.get(at, [])
            if mine:
                last = mine[-1]
                made += self._new(mine[0])
            if at not in touched:
                made.append(item)
            elif not self.here[mine[0]].part:
                made += self._table(item, mine[0])
            elif isinstance(item, Run):
                made += self._rows(item, mine)
            else:
                made += self._line(item, mine)
            if mine and last == len(self.here) - 1:
                made += self._new(len(self.here))
        return made

    def _new(self, before: int) -> list[Any]:
        """New lines in front of an entry."""
        return [entry.line for entry in self.put.get(before, [])]

    def _line(self, line: Any, mine: Sequence[int]) -> Iterator[Any]:
        """A line with its parts changed; lines that are put between them go in front."""
        for index in mine[1:]:
            yield from self._new(index)
        for index in mine:
            if index in self.replaced:
                now, part = self.replaced[index], self.here[index].part
                line = replace(line, **{part: None if now is None else getattr(now.line, part)})
        if any(getattr(line, self.here[index].part) for index in mine):
            yield line

    def _table(self, rows: Run, index: int) -> Iterator[Any]:
        """A table that is one entry: another one in its place, or none."""
        now = self.replaced[index]
        if now is not None:
            same = len(rows) == len(now.line)
            yield with_steps(now.line, steps_of(rows)) if same else now.line

    def _rows(self, rows: Run, mine: Sequence[int]) -> Iterator[Any]:
        """The rows of a table around the lines that are new or changed."""
        start = 0
        for index in mine:
            row = self.here[index].row
            put = self._new(index) if index != mine[0] else []
            if not put and index not in self.replaced:
                continue
            if start < row:
                yield rows.rows(slice(start, row))
            yield from put
            start = row
            if index in self.replaced:
                now = self.replaced[index]
                if now is not None:
                    yield with_steps(now.line, steps_of(rows)[row : row + 1])
                start = row + 1
        if start < len(rows):
            yield rows.rows(slice(start, None))
