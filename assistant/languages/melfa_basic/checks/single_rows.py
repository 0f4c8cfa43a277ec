"""Lines of tables that are no plain ones, handed to the ordinary reader.

A table holds lines of which no rule of a single line has anything to report: moves in ascending
steps to positions that are there, and positions with names of their own. Any other line of a table
is read as if it were alone. So a rule of single lines never looks into tables; only those that
compare lines with each other do.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from assistant.base.arrays import Ints, Truths
from assistant.base.source_text import with_line_feeds
from assistant.languages.checks.names import NameSet, repeated_rows
from assistant.languages.melfa_basic.checks.file_view import Calls, Look
from assistant.languages.melfa_basic.checks.left_out import before_last_step
from assistant.languages.melfa_basic.checks.variables_of import known_variables, names_of
from assistant.languages.melfa_basic.reading.parser import read_rows
from assistant.languages.melfa_basic.tables.dialects import DIALECTS, LAST_STEP, Dialect
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.columnar import (
    MVR,
    MoveRows,
    PositionRows,
    row_slice,
)
from assistant.languages.runs.columns import Names

RowTable = MoveRows | PositionRows


def with_single_rows(trees: Sequence[s.File], dialect: Dialect | None = None) -> tuple[s.File, ...]:
    """The files of a program, with an ordinary line for each row of a table that is no plain one.

    dialect: with the limits of a certain controller; without it that of each file.
    """
    calls = Calls(trees)
    return tuple(
        _single_rows(Look(tree, dialect or DIALECTS[tree.dialect], calls)) for tree in trees
    )


def _single_rows(look: Look) -> s.File:
    tree, source = look.tree, look.source
    if source is None or not any(isinstance(item, RowTable) for item in tree.items):
        return tree
    single = {**_irregular_moves(look), **_irregular_positions(look)}
    if not any(rows.any() for rows in single.values()):
        return tree
    text = with_line_feeds(source.text)
    items: list[s.Item] = []
    for item in tree.items:
        if isinstance(item, RowTable) and item.places is not None and single[id(item)].any():
            items += _split_table(text, item, single[id(item)])
        else:
            items.append(item)
    return replace(tree, items=tuple(items))


def _split_table(text: str, rows: RowTable, single: Truths) -> list[s.Item]:
    bounds = np.flatnonzero(single[1:] != single[:-1]) + 1
    found: list[s.Item] = []
    for first, stop in pairwise([0, *bounds.tolist(), len(single)]):
        if single[first]:
            chosen = np.zeros(len(single), dtype=bool)
            chosen[first:stop] = True
            found += read_rows(text, rows, chosen)
        else:
            found.append(row_slice(rows, first, stop))
    return found


def _irregular_moves(look: Look) -> dict[int, Truths]:
    """By the `id` of a table of moves, its rows (n,) that are not plain."""
    names, found, before = look.once(known_variables).given, dict[int, Truths](), 0
    zeros = _zero_positions(look)
    for item in look.code:
        if not isinstance(item, MoveRows):
            before = item.number or before
            continue
        steps = np.concatenate([[before], item.steps])
        single = (steps[1:] <= steps[:-1]) | (item.steps > LAST_STEP)
        arc = item.kinds == MVR
        for numbers, counts in ((item.end, ~arc | arc), (item.via, arc), (item.start, arc)):
            targets = Names.numbered(item.stem.encode("ascii"), numbers)
            odd = zeros.among(targets) | _too_long(look, item.stem, numbers)
            if not look.has_strangers:
                odd |= ~names.among(targets)
            single |= counts & odd
        found[id(item)], before = single, int(item.steps[-1])
    return found


def _irregular_positions(look: Look) -> dict[int, Truths]:
    """The same of tables of positions."""
    tables = [item for item in look.data if isinstance(item, PositionRows)]
    found = {}
    among = {id(item) for item in before_last_step(look) if isinstance(item, PositionRows)}
    for rows in tables:
        zero = (rows.values == 0).all(axis=1)
        found[id(rows)] = _too_long(look, rows.stem, rows.numbers) | zero | (id(rows) in among)
    lines = [item.variable.key for item in look.data if isinstance(item, s.Data)]
    columns = [*map(names_of, tables), Names.of([name for name in lines if name.isascii()])]
    for pair in repeated_rows(columns):
        for at, row in pair:
            if at < len(tables):
                found[id(tables[at])][row] = True
    return found


def _too_long(look: Look, stem: str, numbers: Ints) -> Truths:
    """(n,) whether names are longer than the version takes."""
    room = look.dialect.longest - len(stem)
    return np.asarray(numbers >= 10 ** max(room, 0))


def _zero_positions(look: Look) -> NameSet:
    """Positions whose numbers are all 0."""
    found = NameSet()
    for item in look.data:
        if isinstance(item, PositionRows):
            found.columns.append(names_of(item).rows((item.values == 0).all(axis=1)))
        elif isinstance(item.value, s.Constant) and not any(item.value.values):
            found.words.add(item.variable.key)
    return found
