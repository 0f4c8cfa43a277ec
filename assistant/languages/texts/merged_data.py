"""Changed data put into the lines of data of a text, some of them in tables by the thousand."""

from __future__ import annotations

import abc
from collections.abc import Collection, Iterable, Iterator, Sequence
from typing import Any

import numpy as np

from assistant.languages.runs.columns import Run, joined_runs
from assistant.languages.runs.names import rows_of

Known = dict[str, Any]
"""Lines of data by their names."""


class DataMerger(abc.ABC):
    """Puts changes into lines of data, each with a name of its own.

    line: one. table: many whose names are a stem and a number. number: the column of these.
    """

    line: type[Any]
    table: type[Run]
    number: str

    @abc.abstractmethod
    def name(self, line: Any) -> str:
        """The name of a line as it is compared."""

    @abc.abstractmethod
    def stem(self, table: Any) -> str:
        """What the names of a table begin with, as they are compared."""

    @abc.abstractmethod
    def rows_as_lines(self, table: Any) -> Iterable[Any]:
        """The rows of a table as lines."""

    @abc.abstractmethod
    def gathered(self, lines: Iterable[Any]) -> Iterable[Any]:
        """Neighbours that could stand in one table as a table."""

    @abc.abstractmethod
    def changed(self, here: Any, old: Any, new: Any) -> Any:
        """A line as it is once what differs between two built ones has changed in it.

        old: None if there was none.
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
                lines = list(self._apart(item, old.keys() | new.keys()))
                untouched = lines[0] is item
                made += lines if untouched else self.gathered(self._changed(lines, old, new, done))
            else:
                made += self._changed([item], old, new, done)
        if (old.keys() & new.keys()) - done:
            return None
        return made + [line for name, line in new.items() if name not in done]

    def _lacking(self, items: Iterable[Any], others: Iterable[Any]) -> Known:
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
        self, items: Iterable[Any], old: Known, new: Known, done: set[str]
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
