"""Lines of one kind gathered into the columns that a parser would read them as."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from itertools import chain
from typing import Any, Final

import numpy as np

from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.columnar import (
    FEWEST,
    KEYWORDS,
    MVR,
    MoveRows,
    PositionRows,
)
from assistant.languages.runs import gathering as alike
from assistant.languages.runs.columns import Run, joined

_NUMBERED: Final = re.compile(r"([A-Za-z][A-Za-z_]*)(0|[1-9][0-9]{0,8})")


def split_name(variable: s.Expression | None) -> tuple[str, int] | None:
    """Stem and number of a plain variable such as `P12`, None for any other expression."""
    if not isinstance(variable, s.Variable):
        return None
    if variable.suffix or variable.arguments is not None or variable.component:
        return None
    return split_numbered(variable.name)


def split_numbered(name: str) -> tuple[str, int] | None:
    """Stem and number of a name such as `P12`, None for any other."""
    found = _NUMBERED.fullmatch(name)
    return (found.group(1), int(found.group(2))) if found else None


def gathered(items: Iterable[s.Item]) -> Iterator[s.Item]:
    """The same lines, neighbours of one stem as one table, lone ones as lines."""
    known: list[s.Item] = [as_rows(item) or item for item in items]
    for item in chain.from_iterable(
        alike.gathered(known, map(_kind, known), _run, FEWEST, _joined)
    ):
        if isinstance(item, MoveRows | PositionRows) and 0 < len(item) < FEWEST:
            yield from rows_as_lines(item)
        else:
            yield item


def _run(item: s.Item) -> Run | None:
    return item if isinstance(item, Run) else None


def _kind(item: s.Item) -> object:
    """What rows of one table have in common."""
    match item:
        case MoveRows(stem=stem) if len(item):
            return MoveRows, stem
        case PositionRows(stem=stem, values=values) if len(item):
            return PositionRows, stem, values.shape[1]
    return None


def _joined(items: Sequence[Any]) -> Any:
    return joined(items)


def as_rows(item: s.Item) -> MoveRows | PositionRows | None:
    """A plain move or position line as a table of one row, a table as it is, else None."""
    match item:
        case MoveRows() | PositionRows():
            return item if len(item) else None
        case s.Line(
            label=None,
            statement=s.Motion(keyword=keyword, arguments=arguments, type=None, append=None),
            comment=None,
        ) if keyword in KEYWORDS:
            names = [split_name(a) for a in arguments]
            found = [n for n in names if n is not None]
            wanted = 3 if keyword == KEYWORDS[MVR] else 1
            if len(found) != len(names) or len(names) != wanted:
                return None
            if len({stem for stem, _ in found}) != 1:
                return None
            start, via, end = [-1, -1, *(n for _, n in found)][-3:]
            step = np.array([item.number or 0], dtype=np.int64)
            kind = np.array([KEYWORDS.index(keyword)], dtype=np.int64)
            return MoveRows(
                found[0][0], step, kind, np.array([start]), np.array([via]), np.array([end])
            )
        case s.Data(variable=variable, value=s.Constant(values=values, flags=flags), type=""):
            name = split_name(variable)
            if name is None or flags is None or len(values) not in (6, 7, 8):
                return None
            if None in values or None in flags:
                return None
            return PositionRows(
                name[0],
                np.array([name[1]], dtype=np.int64),
                np.array([values], dtype=np.float64),
                np.array([flags], dtype=np.int64),
            )
    return None


def rows_as_lines(rows: MoveRows | PositionRows) -> Iterator[s.Line | s.Data]:
    """The rows as the nodes that the grammar gives for their lines; for few, not for many."""

    def variable(number: int) -> s.Variable:
        return s.Variable(f"{rows.stem}{number}")

    if isinstance(rows, PositionRows):
        for number, values, flags in zip(rows.numbers, rows.values, rows.flags, strict=True):
            numbers = tuple(float(v) for v in values)
            constant = s.Constant(numbers, (int(flags[0]), int(flags[1])))
            yield s.Data(variable(int(number)), constant)
        return
    for i, step in enumerate(rows.steps):
        ends = [variable(int(rows.end[i]))]
        if rows.kinds[i] == MVR:
            ends = [variable(int(rows.start[i])), variable(int(rows.via[i])), *ends]
        yield s.Line(int(step) or None, None, s.Motion(KEYWORDS[rows.kinds[i]], tuple(ends)))
