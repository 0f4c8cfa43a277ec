"""Lines of one kind gathered into the columns that a parser would read them as."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
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
from assistant.languages.runs import columns as alike

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
    listed = list(items)
    for item in alike.gather_runs(
        listed, map(_table_row, listed), _table_of_rows, lambda _, run: run, FEWEST
    ):
        if isinstance(item, MoveRows | PositionRows) and 0 < len(item) < FEWEST:
            yield from rows_as_lines(item)
        else:
            yield item


def _table_row(item: s.Item) -> alike.Row | None:
    """What a line may be a row of, and what it says there; None for one that is not plain."""
    match item:
        case MoveRows(stem=stem) if len(item):
            return (MoveRows, stem), item
        case PositionRows(stem=stem, values=values) if len(item):
            return (PositionRows, stem, values.shape[1]), item
        case s.Line(
            label=None,
            statement=s.Motion(keyword=keyword, arguments=arguments, type=None, append=None),
            comment=None,
        ) if keyword in KEYWORDS:
            found = [name for name in map(split_name, arguments) if name is not None]
            wanted = 3 if keyword == KEYWORDS[MVR] else 1
            if len({stem for stem, _ in found}) != 1 or not len(arguments) == len(found) == wanted:
                return None
            stem, numbers = found[0][0], [-1, -1, *(number for _, number in found)][-3:]
            row = [item.number or 0, KEYWORDS.index(keyword), *numbers]
            return (MoveRows, stem), (stem, row)
        case s.Data(variable=variable, value=s.Constant(values=values, flags=flags), type=""):
            name = split_name(variable)
            if name is None or flags is None or len(values) not in (6, 7, 8):
                return None
            if None in values or None in flags:
                return None
            return (PositionRows, name[0], len(values)), (*name, values, flags)
    return None


def _table_of_rows(rows: list[Any]) -> MoveRows | PositionRows:
    stem, *columns = zip(*rows, strict=True)
    if len(columns) == 1:
        return MoveRows(stem[0], *np.array(columns[0], dtype=np.int64).T)
    numbers, values, flags = columns
    return PositionRows(
        stem[0],
        np.array(numbers, dtype=np.int64),
        np.array(values, dtype=np.float64),
        np.array(flags, dtype=np.int64),
    )


def position_rows(item: s.Item) -> PositionRows | None:
    """A plain position line as a table of one row, a table as it is, None for anything else."""
    if isinstance(item, PositionRows):
        return item if len(item) else None
    row = _table_row(item) if isinstance(item, s.Data) else None
    table = None if row is None else _table_of_rows([row[1]])
    return table if isinstance(table, PositionRows) else None


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
    columns = (rows.steps, rows.kinds, rows.start, rows.via, rows.end)
    for step, kind, *numbers in np.stack(columns, axis=1).tolist():
        places = tuple(variable(number) for number in numbers if number >= 0)
        yield s.Line(step or None, None, s.Motion(KEYWORDS[kind], places))
