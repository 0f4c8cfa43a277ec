"""What a program says, step by step, to be compared with another one."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final, Literal

import numpy as np

from assistant.languages.melfa_basic.tables.vocabulary import commands
from assistant.languages.melfa_basic.text.merging.names import in_upper_case
from assistant.languages.melfa_basic.text.printer import statement as printed
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.columnar import MoveRows
from assistant.languages.melfa_basic.tree.line_tables import rows_as_lines
from assistant.languages.texts import merging

MOST_ROWS: Final = 1 << 10
"""Rows of a table that are compared one by one; a longer one is the same or it is not."""


@dataclass(frozen=True, slots=True)
class Entry(merging.Entry):
    """A comment, label or statement of a line, or a long table; a comment comes first.

    key: what it says, whatever its step number and layout. at: index of its item.
    row: of a table, -1 for others. line: it alone, without a number.
    """

    key: str
    part: Literal["comment", "label", "statement", "table"]
    at: int
    row: int
    line: s.Entry

    @property
    def place(self) -> tuple[int, int]:
        return self.at, self.row

    @property
    def kind(self) -> str:
        node = self.line.statement if isinstance(self.line, s.Line) else None
        return f"{self.part} {type(node).__name__} {getattr(node, 'keyword', '')}"

    @property
    def setting(self) -> str | None:
        node = self.line.statement if isinstance(self.line, s.Line) else None
        keyword = node.keyword if isinstance(node, s.Command) else None
        return keyword if keyword in commands("sets") else None


def entries(items: Sequence[s.Item]) -> list[Entry]:
    """The entries of all code lines, in order."""
    found: list[Entry] = []
    for at, item in enumerate(items):
        if isinstance(item, s.Line):
            found += _of_line(item, at, -1)
        elif isinstance(item, MoveRows):
            if len(item) > MOST_ROWS:
                columns = (item.kinds, item.start, item.via, item.end)
                key = f"{item.stem} {hash(tuple(c.tobytes() for c in columns))}"
                bare = replace(item, steps=np.zeros_like(item.steps), span=None)
                found.append(Entry(key, "table", at, -1, bare))
                continue
            for row, line in enumerate(rows_as_lines(item)):
                assert isinstance(line, s.Line)
                found += _of_line(line, at, row)
    return found


def _of_line(line: s.Line, at: int, row: int) -> Iterator[Entry]:
    if line.comment is not None:
        text = line.comment.removeprefix("'").strip()
        yield Entry("' " + text, "comment", at, row, s.Line(comment=line.comment))
    if line.label is not None:
        yield Entry("*" + line.label.upper(), "label", at, row, s.Line(label=line.label))
    if line.statement is not None:
        key = printed(in_upper_case(line.statement), upper=True)
        yield Entry(key, "statement", at, row, s.Line(statement=line.statement))
