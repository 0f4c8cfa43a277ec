"""Changed positions put into the position lines of a text."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from assistant.languages.melfa_basic.text.printer import expression
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.columnar import PositionRows
from assistant.languages.melfa_basic.tree.line_tables import gathered, rows_as_lines
from assistant.languages.runs.columns import joined
from assistant.languages.runs.names import rows_of

Table = dict[str, s.Data]


def merged_data(
    items: Sequence[s.Item], before: Sequence[s.Item], after: Sequence[s.Item]
) -> list[s.Item] | None:
    """The items with the position lines changed that differ between two built programs.

    Of a line that stays only the numbers change that have. None if a changed one is not there.
    """
    gone, come = _lacking(after, before), _lacking(before, after)
    old = {key: data for key, data in gone.items() if come.get(key) != data}
    new = {key: data for key, data in come.items() if gone.get(key) != data}
    if not (old or new):
        return list(items)
    made: list[s.Item] = []
    done: set[str] = set()
    for item in items:
        if isinstance(item, PositionRows):
            lines = list(_apart(item, old.keys() | new.keys()))
            made += lines if lines == [item] else gathered(_changed(lines, old, new, done))
        else:
            made += _changed([item], old, new, done)
    if (old.keys() & new.keys()) - done:
        return None
    return made + [data for key, data in new.items() if key not in done]


def _key(variable: s.Variable) -> str:
    return expression(variable).upper()


def _lacking(items: Iterable[s.Item], lines: Iterable[s.Item]) -> Table:
    """Position lines that are not among the items, few objects for tables that are there."""
    known: dict[object, list[PositionRows]] = {}
    for item in items:
        if isinstance(item, PositionRows):
            known.setdefault((item.stem.upper(), item.values.shape[1]), []).append(item)
    found: list[s.Item] = []
    for item in lines:
        if isinstance(item, PositionRows):
            same = known.get((item.stem.upper(), item.values.shape[1]))
            if same:
                table = joined(same)
                item = item.rows(~table.equal(rows_of(table.numbers, item.numbers), item))
            found += rows_as_lines(item)
        else:
            found.append(item)
    return {_key(data.variable): data for data in found if isinstance(data, s.Data)}


def _apart(table: PositionRows, keys: Collection[str]) -> Iterator[s.Item]:
    """A table with the rows of such names as lines of their own."""
    stem = table.stem.upper()
    numbers = [k[len(stem) :] for k in keys if k.startswith(stem)]
    wanted = np.array([int(n) for n in numbers if n.isdigit()], dtype=np.int64)
    start = 0
    for row in np.flatnonzero(np.isin(table.numbers, wanted)).tolist():
        if start < row:
            yield table.rows(slice(start, row))
        yield from rows_as_lines(table.rows(slice(row, row + 1)))
        start = row + 1
    if start < len(table):
        yield table.rows(slice(start, None)) if start else table


def _changed(items: Iterable[s.Item], old: Table, new: Table, done: set[str]) -> Iterator[s.Item]:
    """Items with each position line that differs changed or left out. done: what was there."""
    for item in items:
        key = _key(item.variable) if isinstance(item, s.Data) else ""
        if not isinstance(item, s.Data) or (key not in old and key not in new):
            yield item
            continue
        done.add(key)
        if key in new:
            yield _line(item, old.get(key), new[key])


def _line(item: s.Data, old: s.Data | None, new: s.Data) -> s.Data:
    """A line with the numbers of the new one where it differs from the old one."""
    was, now, here = (None if d is None else d.value for d in (old, new, item))
    if not (
        isinstance(was, s.Constant) and isinstance(now, s.Constant) and isinstance(here, s.Constant)
    ) or not (len(was.values) == len(now.values) == len(here.values)):
        return replace(item, value=new.value)
    values = tuple(
        h if w == n else n for h, w, n in zip(here.values, was.values, now.values, strict=True)
    )
    flags = here.flags if was.flags == now.flags else now.flags
    return replace(item, value=s.Constant(values, flags))
