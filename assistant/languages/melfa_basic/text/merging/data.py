"""Changed positions put into the position lines of a text."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from assistant.languages.melfa_basic.text.printer import expression
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.columnar import PositionRows
from assistant.languages.melfa_basic.tree.line_tables import rows_as_lines
from assistant.languages.runs.columns import joined
from assistant.languages.runs.names import rows_of

Table = dict[str, s.Data]


def merged_data(
    items: Sequence[s.Item], before: Sequence[s.Item], after: Sequence[s.Item]
) -> list[s.Item] | None:
    """The items with the position lines changed that differ between two built programs.

    Of a line that stays only the numbers change that have. None if a changed one is not there.
    """
    old, new = _differing(before, after)
    if not (old or new):
        return list(items)
    made: list[s.Item] = []
    done: set[str] = set()
    for item in items:
        if isinstance(item, s.Data):
            key = _key(item.variable)
            done.add(key)
            if key in new:
                made.append(_changed(item, old.get(key), new[key]))
            elif key not in old:
                made.append(item)
        elif isinstance(item, PositionRows):
            made += _rows(item, old, new, done)
        else:
            made.append(item)
    if (old.keys() & new.keys()) - done:
        return None
    return made + [data for key, data in new.items() if key not in done]


def _key(variable: s.Variable) -> str:
    return expression(variable).upper()


def _differing(before: Sequence[s.Item], after: Sequence[s.Item]) -> tuple[Table, Table]:
    """The position lines that differ, as they were and as they are, without an object a row."""
    mine, theirs = list(_tables(before)), list(_tables(after))
    old: Table = {}
    new: Table = {}
    stems = {(t.stem.upper(), t.values.shape[1]) for t in (*mine, *theirs)}
    for stem, width in stems:
        a, b = (_joined(tables, stem, width) for tables in (mine, theirs))
        for table, other, into in ((a, b, old), (b, a, new)):
            if table is None:
                continue
            differs = np.ones(len(table), dtype=bool)
            if other is not None:
                differs = ~other.equal(rows_of(other.numbers, table.numbers), table)
            if differs.any():
                rows = rows_as_lines(table.rows(differs))
                into |= {_key(d.variable): d for d in rows if isinstance(d, s.Data)}
    plain = [
        {_key(i.variable): i for i in items if isinstance(i, s.Data)} for items in (before, after)
    ]
    old |= {k: d for k, d in plain[0].items() if plain[1].get(k) != d}
    new |= {k: d for k, d in plain[1].items() if plain[0].get(k) != d}
    same = {k for k in old.keys() & new.keys() if old[k] == new[k]}
    for table_of in (old, new):
        for key in same:
            del table_of[key]
    return old, new


def _tables(items: Sequence[s.Item]) -> Iterator[PositionRows]:
    return (item for item in items if isinstance(item, PositionRows))


def _joined(tables: Sequence[PositionRows], stem: str, width: int) -> PositionRows | None:
    some = [t for t in tables if t.stem.upper() == stem and t.values.shape[1] == width]
    return joined(some) if some else None


def _changed(item: s.Data, old: s.Data | None, new: s.Data) -> s.Data:
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


def _rows(table: PositionRows, old: Table, new: Table, done: set[str]) -> Iterator[PositionRows]:
    """A table with its changed rows."""
    stem = table.stem.upper()
    touched = {
        int(key[len(stem) :]): key
        for key in (*old, *new)
        if key.startswith(stem) and key[len(stem) :].isdigit()
    }
    at = np.flatnonzero(np.isin(table.numbers, np.array(list(touched), dtype=np.int64)))
    if not len(at):
        yield table
        return
    values, flags = table.values.copy(), table.flags.copy()
    kept = np.ones(len(table), dtype=bool)
    for row in at.tolist():
        key = touched[int(table.numbers[row])]
        done.add(key)
        if key not in new:
            kept[row] = False
            continue
        (line,) = rows_as_lines(table.rows(slice(row, row + 1)))
        assert isinstance(line, s.Data)
        value = _changed(line, old.get(key), new[key]).value
        if not isinstance(value, s.Constant) or len(value.values) != values.shape[1]:
            kept[row] = False  # in another form: on a line of its own
            done.discard(key)
            continue
        values[row] = value.values
        if value.flags is not None:
            flags[row] = [flag or 0 for flag in value.flags]
    if kept.any():
        yield replace(table, values=values, flags=flags).rows(kept)
