"""Runs of like lines that changed in a text: each line of one as a node of its own."""

from __future__ import annotations

import abc
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np

from assistant.base.arrays import Rows
from assistant.base.source_text import lines_of
from assistant.languages.texts import printed_blocks
from assistant.languages.texts.printed_blocks import Extent, Spread

MOST_ROWS: Final = 4096
"""Rows of a run that are written one by one; if more of it changed it is printed as a whole."""


@dataclass(frozen=True, slots=True)
class RunRow:
    """A row of a run. key: what it says, as it is compared; text: as it is printed."""

    key: str
    text: str = field(compare=False)


@dataclass(frozen=True, slots=True, eq=False)
class _UnchangedRows:
    """Rows of a run that did not change."""


class RunLayout(printed_blocks.Layout):
    """Of a language whose tree has nodes for runs of like lines.

    row_end: what each row ends with. note: what a comment begins with.
    """

    row_end: str
    note: str

    @abc.abstractmethod
    def is_run(self, node: Any) -> bool:
        """Whether a node is a run; it has its rows in `run`."""

    @abc.abstractmethod
    def may_be_row(self, node: Any) -> bool:
        """Whether a node could be a row of a run."""

    def spread(self, text: str, old: Sequence[Any], new: Sequence[Any]) -> Spread | None:
        """Runs as their rows, those that stay in both lists together."""
        shared = {id(node) for node in old} & {id(node) for node in new}
        mine = [node for node in old if id(node) not in shared]
        other = [node for node in new if id(node) not in shared]
        if not any(self.is_run(node) for node in (*mine, *other)):
            return None
        if len(mine) == len(other) == 1 and type(mine[0]) is type(other[0]):
            spread = self._of_one_run(text, mine[0], other[0])
            if spread is None or len(old) == len(new) == 1:
                return spread
            i, j = old.index(mine[0]), new.index(other[0])
            places = [self._place(text, node) for node in old]
            return Spread(
                (*old[:i], *spread.old, *old[i + 1 :]),
                (*places[:i], *spread.extents, *places[i + 1 :]),
                (*new[:j], *spread.new, *new[j + 1 :]),
            )
        return self._of_many(text, old, new, shared)

    def _place(self, text: str, node: Any) -> Extent:
        extent = self.extent(text, node)
        if extent is None:
            raise ValueError(f"{type(node).__name__} of the tree that was read has no span")
        return extent

    def _of_one_run(self, text: str, old: Any, new: Any) -> Spread | None:
        """A run that was changed: only the rows that are different."""
        had, has = self._lines(old), self._lines(new)
        places = self._row_places(text, old, len(had))
        if places is None:
            return None
        if len(had) == len(has):
            differ = [k for k, (a, b) in enumerate(zip(had, has, strict=True)) if a != b]
            stretches = [(k, k + 1, k, k + 1) for k in differ]
        else:
            most = min(len(had), len(has))
            head = next((k for k in range(most) if had[k] != has[k]), most)
            tails = range(1, most - head + 1)
            tail = next((k - 1 for k in tails if had[-k] != has[-k]), most - head)
            stretches = [(head, len(had) - tail, head, len(has) - tail)]
        if sum(i2 - i1 + j2 - j1 for i1, i2, j1, j2 in stretches) > MOST_ROWS:
            return None
        olds: list[Any] = []
        news: list[Any] = []
        extents: list[Extent] = []
        at = 0
        for i1, i2, j1, j2 in (*stretches, (len(had), len(had), len(has), len(has))):
            if i1 > at:
                olds.append(rows := _UnchangedRows())
                news.append(rows)
                extents.append(Extent(int(places[at, 0]), int(places[i1 - 1, 1])))
            olds += [RunRow(line, line) for line in had[i1:i2]]
            news += [RunRow(line, line) for line in has[j1:j2]]
            extents += [Extent(*map(int, places[k])) for k in range(i1, i2)]
            at = i2
        return Spread(olds, extents, news)

    def _of_many(
        self, text: str, old: Sequence[Any], new: Sequence[Any], shared: set[int]
    ) -> Spread | None:
        """Runs beside rows of their own: each row as a node, equal if it is spelled alike."""
        if sum(len(n.run) for n in (*old, *new) if self.is_run(n)) > MOST_ROWS:
            return None
        spelled = any(id(node) not in shared and self.may_be_row(node) for node in new)
        olds: list[Any] = []
        news: list[Any] = []
        extents: list[Extent] = []
        for node in old:
            place = self._place(text, node)
            if id(node) in shared or not (self.is_run(node) or self.may_be_row(node)):
                olds.append(node)
                extents.append(place)
                continue
            lines = self._lines(node)
            places = self._row_places(text, node, len(lines))
            if places is None:
                return None
            for line, (start, end) in zip(lines, places.tolist(), strict=True):
                olds.append(RunRow(self._key(text[start:end] if spelled else line), line))
                extents.append(Extent(start, end))
        for node in new:
            if id(node) in shared or not (self.is_run(node) or self.may_be_row(node)):
                news.append(node)
            else:
                news += [RunRow(self._key(line), line) for line in self._lines(node)]
        return Spread(olds, extents, news)

    def _lines(self, node: Any) -> list[str]:
        return lines_of("".join(str(part) for part in self.sketch(node)))

    def _key(self, line: str) -> str:
        return " ".join(word.text for word in self.words(line, 0, len(line)))

    def _row_places(self, text: str, node: Any, rows: int) -> Rows | None:
        """Offsets (n, 2) of each row, None where they cannot be told apart at a glance."""
        place = self._place(text, node)
        if rows == 1:
            return np.array([place])
        inner = text[place.start : place.end]
        if not inner.isascii() or self.note in inner or inner.count(self.row_end) != rows:
            return None
        data = np.frombuffer(inner.encode("ascii"), dtype=np.uint8)
        ends = np.flatnonzero(data == ord(self.row_end)) + 1
        starts = np.concatenate([[0], ends[:-1]])
        while (blank := data[starts] <= ord(" ")).any():
            starts += blank
        return np.stack([starts, ends], axis=1) + place.start
