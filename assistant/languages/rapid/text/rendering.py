"""Text of a changed RAPID file: what `assistant.languages.lossless` has to know of the language."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Final

import numpy as np

from assistant.languages import lossless
from assistant.languages.lossless import Block, Extent, Sketch, Spread
from assistant.languages.rapid.reading.scanner import words
from assistant.languages.rapid.text.printer import INDENT, PRINTER
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.gather import plain_move, target_values
from assistant.languages.words import Word
from assistant.program.arrays import Rows
from assistant.program.text import lines_of

MOST_ROWS: Final = 4096
"""Rows of a run that are written one by one; if more of it changed it is printed as a whole."""

_OPTION: Final = re.compile(r"(?:[ \t\f\r\n]|![^\r\n]*)*\\")
"""A comma may stand in front of an optional argument."""
_SIMPLE: Final = (
    *(s.Assignment, s.ProcedureCall, s.GotoLabel, s.ReturnFrom, s.RaiseError, s.Word),
    *(s.Connect, s.CompactIf, s.MoveRunNode),
)
"""Statements that end with a semicolon, which their span may leave out."""
_SEMICOLON: Final = re.compile(r"(?:[ \t\f\r\n]|![^\r\n]*)*;")
_RUNS: Final = (s.TargetRunNode, s.MoveRunNode)
_HEADER: Final = re.compile(r"\s*%%%(.*?)%%%", re.DOTALL)


def render(file: s.File, origin: s.Origin) -> str:
    """The text of a file; what is as it was read keeps its bytes."""
    begin = _HEADER.match(origin.source.text)
    header = begin[1] if begin and origin.parts else None
    if file.parts is origin.parts and file.header == header:
        return origin.source.text
    old = s.File(origin.parts, header)
    text = lossless.render(origin.source, old, replace(file, header=header), Layout())
    if file.header == header:
        return text
    newline = origin.source.newline
    new = "" if file.header is None else f"%%%{file.header}%%%"
    if begin is None:
        return new + newline + text
    rest = text[begin.end() :]
    return new + rest if new else re.sub(r"^[ \t]*\r?\n", "", rest)


@dataclass(frozen=True, slots=True)
class _Row:
    """A row of a run. key: what it says, as it is compared; text: as it is printed."""

    key: str
    text: str = field(compare=False)


@dataclass(frozen=True, slots=True, eq=False)
class _Rows:
    """Rows of a run that did not change."""


class Layout(lossless.Layout):
    """RAPID: statements end with `;`, comments with their line."""

    spelled = frozenset(("string", "number"))
    indent = INDENT

    def words(self, text: str, start: int, end: int) -> Iterator[Word]:
        return _words(text, start, end)

    def noted(self, gap: str) -> bool:
        return any(word.kind == "comment" for word in words(gap))

    def sketch(self, node: Any) -> Sketch:
        match node:
            case s.File():
                header = () if node.header is None else (f"%%%{node.header}%%%\n",)
                return (*header, Block(node.parts, 0))
            case _Row():
                return (node.text,)
        return PRINTER.sketch(node)

    def extent(self, text: str, node: Any) -> Extent | None:
        if node.span is None:
            return None
        start, end = node.span.start, node.span.end
        while start < end and text[start].isspace():
            start += 1
        while start < end and text[end - 1].isspace():
            end -= 1
        if isinstance(node, _SIMPLE) and text[end - 1] != ";":
            if semicolon := _SEMICOLON.match(text, end):
                end = semicolon.end()
        return Extent(start, end)

    def line_ends(self, before: Any, after: Any) -> int | None:
        if isinstance(before, s.CommentLine):
            return 1
        if isinstance(after, s.CommentLine) and before is not None:
            return 0 if after.trailing else 1
        blank = isinstance(before, s.Routine) or isinstance(after, s.Routine)
        return 2 if blank and before is not None and after is not None else None

    def spread(self, text: str, old: Sequence[Any], new: Sequence[Any]) -> Spread | None:
        """Runs as their rows, those that stay in both lists together."""
        shared = {id(node) for node in old} & {id(node) for node in new}
        mine = [node for node in old if id(node) not in shared]
        other = [node for node in new if id(node) not in shared]
        if not any(isinstance(node, _RUNS) for node in (*mine, *other)):
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
                olds.append(rows := _Rows())
                news.append(rows)
                extents.append(Extent(int(places[at, 0]), int(places[i1 - 1, 1])))
            olds += [_Row(line, line) for line in had[i1:i2]]
            news += [_Row(line, line) for line in has[j1:j2]]
            extents += [Extent(*map(int, places[k])) for k in range(i1, i2)]
            at = i2
        return Spread(olds, extents, news)

    def _of_many(
        self, text: str, old: Sequence[Any], new: Sequence[Any], shared: set[int]
    ) -> Spread | None:
        """Runs beside rows of their own: each row as a node, equal if it is spelled alike."""
        if sum(len(n.run) for n in (*old, *new) if isinstance(n, _RUNS)) > MOST_ROWS:
            return None
        spelled = any(id(node) not in shared and _may_be_row(node) for node in new)
        olds: list[Any] = []
        news: list[Any] = []
        extents: list[Extent] = []
        for node in old:
            place = self._place(text, node)
            if id(node) in shared or not (isinstance(node, _RUNS) or _may_be_row(node)):
                olds.append(node)
                extents.append(place)
                continue
            lines = self._lines(node)
            places = self._row_places(text, node, len(lines))
            if places is None:
                return None
            for line, (start, end) in zip(lines, places.tolist(), strict=True):
                olds.append(_Row(_key(text[start:end] if spelled else line), line))
                extents.append(Extent(start, end))
        for node in new:
            if id(node) in shared or not (isinstance(node, _RUNS) or _may_be_row(node)):
                news.append(node)
            else:
                news += [_Row(_key(line), line) for line in self._lines(node)]
        return Spread(olds, extents, news)

    def _lines(self, node: Any) -> list[str]:
        return lines_of("".join(str(part) for part in self.sketch(node)))

    def _row_places(self, text: str, node: Any, rows: int) -> Rows | None:
        """Offsets (n, 2) of each row, None where they cannot be told apart at a glance."""
        place = self._place(text, node)
        if rows == 1:
            return np.array([place])
        inner = text[place.start : place.end]
        if not inner.isascii() or "!" in inner or inner.count(";") != rows:
            return None
        data = np.frombuffer(inner.encode("ascii"), dtype=np.uint8)
        ends = np.flatnonzero(data == ord(";")) + 1
        starts = np.concatenate([[0], ends[:-1]])
        while (blank := data[starts] <= ord(" ")).any():
            starts += blank
        return np.stack([starts, ends], axis=1) + place.start


def _may_be_row(node: Any) -> bool:
    if isinstance(node, s.Data):
        return target_values(node) is not None
    return isinstance(node, s.ProcedureCall) and plain_move(node) is not None


def _words(text: str, start: int, end: int) -> Iterator[Word]:
    for word in words(text, start, end):
        if word.kind not in ("comment", "break"):
            if word.text != "," or not _OPTION.match(text, word.end, end):
                yield word


def _key(line: str) -> str:
    return " ".join(word.text for word in _words(line, 0, len(line)))
