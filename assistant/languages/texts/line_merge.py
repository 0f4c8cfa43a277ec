"""Merge of a changed program into the lines that it was lifted from.

The parts of a line (label, statement, comment) are separate entries. Tables of like lines, and data
in them by the thousand, are compared row by row; a table in which nothing changed stays one.
"""

from __future__ import annotations

import abc
from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import replace
from itertools import product
from typing import Any, Final, NamedTuple

import numpy as np

from assistant.base.data_classes import dataclass
from assistant.languages.runs.columns import Run, joined_runs, rows_of
from assistant.languages.step_numbers import steps_of, with_steps
from assistant.languages.texts import tree_merge
from assistant.languages.texts.tree_merge import Entry

_MOST_ROWS: Final = 1 << 10
"""Rows of a table that are compared one by one; a longer one is the same or it is not."""


class LinePart(NamedTuple):
    """Content of one field of a line.

    key: independent of its layout. kind: common property of parts that may replace each other.
    setting: the word of a statement that applies to the lines after it.
    """

    field: str
    key: str
    kind: object = None
    setting: str | None = None


class LineMerger(abc.ABC):
    """Merges changes into the lines of a program.

    line: a record whose fields have defaults without content. table: many lines of the program.
    header: first characters of the keys of the first and the last comment that hold what the
    language cannot express.
    """

    line: type[Any]
    table: type[Run]
    header: tuple[str, str]

    @abc.abstractmethod
    def parts(self, line: Any) -> Iterator[LinePart]:
        """Yield the parts of a line, in order."""

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
                if len(item) > _MOST_ROWS:
                    # A long table is compared as a whole, whatever its step numbers are.
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
        """Yield the lines with the differences between two built programs merged in.

        One result for each strategy: new lines follow the line above them or precede the line below
        them, and settings that the lines state once are stated again after a changed one or not.
        """
        here, old, new = map(self.entries, (items, before, after))
        # A file without a heading does not get one by a merge.
        if not any(entry.key.startswith(self.header[0]) for entry in here):
            old, new = map(self._headless, (old, new))
        place = tree_merge.matched_entries(old, here)
        found = tree_merge.changes(old, new)
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
class _LineEdits(tree_merge.Edits):
    """Edits of the entries of a program."""

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


_Known = dict[str, Any]
"""Lines of data by their names."""


class DataMerger(abc.ABC):
    """Merges changes into lines of data, each with a separate name.

    line: type of a line. table: many whose names are a stem and a number. number: the column of
    these.
    """

    line: type[Any]
    table: type[Run]
    number: str

    @abc.abstractmethod
    def name(self, line: Any) -> str:
        """The name of a line as it is compared."""

    @abc.abstractmethod
    def stem(self, table: Any) -> str:
        """Return the stem of the names of a table, as they are compared."""

    @abc.abstractmethod
    def rows_as_lines(self, table: Any) -> Iterable[Any]:
        """The rows of a table as lines."""

    @abc.abstractmethod
    def gathered(self, lines: Iterable[Any]) -> Iterable[Any]:
        """Join neighbours that could be in one table into a table."""

    @abc.abstractmethod
    def changed(self, here: Any, old: Any, new: Any) -> Any:
        """Return a line with the differences between two built lines merged in.

        old: None for a new line.
        """

    def merged(
        self, items: Sequence[Any], before: Sequence[Any], after: Sequence[Any]
    ) -> list[Any] | None:
        """The items with the data changed that differ between two built programs.

        None if a changed line is not there; new ones stand last.
        """
        gone, come = self._lacking(after, before), self._lacking(before, after)
        old = {name: line for name, line in gone.items() if come.get(name) != line}
        new = {name: line for name, line in come.items() if gone.get(name) != line}
        if not (old or new):
            return list(items)
        made: list[Any] = []
        done: set[str] = set()
        for item in items:
            if isinstance(item, self.table):
                # A table without such rows comes back as it is, and nothing is gathered.
                lines = list(self._apart(item, old.keys() | new.keys()))
                untouched = lines[0] is item
                made += lines if untouched else self.gathered(self._changed(lines, old, new, done))
            else:
                made += self._changed([item], old, new, done)
        # A line that changed in the built program has no counterpart here.
        if (old.keys() & new.keys()) - done:
            return None
        return made + [line for name, line in new.items() if name not in done]

    def _lacking(self, items: Iterable[Any], others: Iterable[Any]) -> _Known:
        """The data of others that are not among the items, few objects for tables that are."""
        known: dict[str, list[Run]] = {}
        for item in items:
            if isinstance(item, self.table):
                known.setdefault(self.stem(item), []).append(item)
        found: list[Any] = []
        for item in others:
            if isinstance(item, self.table):
                if tables := [
                    table for table in known.get(self.stem(item), ()) if table.fits(item)
                ]:
                    whole = joined_runs(tables)
                    at = rows_of(getattr(whole, self.number), getattr(item, self.number))
                    # Only rows that differ become lines: a table has thousands that do not.
                    item = item.rows(~whole.equal(at, item))
                found += self.rows_as_lines(item)
            elif isinstance(item, self.line):
                found.append(item)
        return {self.name(line): line for line in found}

    def _apart(self, table: Run, names: Collection[str]) -> Iterator[Any]:
        """A table with the rows of such names as lines."""
        stem = self.stem(table)
        numbers = [name[len(stem) :] for name in names if name.startswith(stem)]
        wanted = np.array([int(n) for n in numbers if n.isdigit()], dtype=np.int64)
        start = 0
        for row in np.flatnonzero(np.isin(getattr(table, self.number), wanted)).tolist():
            if start < row:
                yield table.rows(slice(start, row))
            yield from self.rows_as_lines(table.rows(slice(row, row + 1)))
            start = row + 1
        if start < len(table):
            yield table.rows(slice(start, None)) if start else table

    def _changed(
        self, items: Iterable[Any], old: _Known, new: _Known, done: set[str]
    ) -> Iterator[Any]:
        """Items with each line that differs changed or left out. done: names that were there."""
        for item in items:
            name = self.name(item) if isinstance(item, self.line) else ""
            if name not in old and name not in new:
                yield item
                continue
            done.add(name)
            if name in new:
                yield self.changed(item, old.get(name), new[name])
