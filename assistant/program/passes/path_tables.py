"""Paths by their columns: rows that no language can say, arcs, and the tables beside the rows."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any, Final, TypeVar

import numpy as np
from numpy.typing import NDArray

from assistant.program.diagnostics import Findings, Span
from assistant.program.path import Kind, Path

T = TypeVar("T")

COLUMNS: Final = ("speed", "blend", "tool", "frame")
"""Columns of rows in the tables `speeds`, `blends`, `tools` and `frames` of a path."""


def has_half_arcs(path: Path) -> bool:
    """Whether a via point has no end behind it, or an end no via point in front of it."""
    if not len(path):
        return False
    after = np.append(path.kinds[1:], np.uint8(Kind.LINEAR))
    torn = (path.kinds == Kind.VIA) != (after == Kind.END)
    return bool(torn.any() or path.kinds[0] == Kind.END)


def with_whole_arcs(path: Path) -> Path:
    """The path with speed, blend, tool and frame of an arc's end at its via point, too."""
    via = np.flatnonzero(path.kinds[:-1] == Kind.VIA)
    made: dict[str, Any] = {}
    for column in COLUMNS:
        values = np.array(getattr(path, column))
        values[via] = values[via + 1]
        made[column] = values
    return replace(path, **made)


def with_used_entries(path: Path) -> Path:
    """The path with only those table rows that it uses, in the order of their first use."""
    made: dict[str, Any] = {}
    for column in COLUMNS:
        table: tuple[Any, ...] = getattr(path, column + "s")
        made[column + "s"], made[column] = table_of(getattr(path, column), table.__getitem__)
    return replace(path, **made)


def reported_at_lines(
    findings: Findings,
    line: Callable[[int], Span | None],
    index: NDArray[Any],
    value: Callable[[int], T],
    entry: int,
) -> T:
    """The value of an entry, with what is found about it at the line of each row that has it.

    line: where the move to a row is in the source text. index: (n,) the entry of each row.
    """
    rows = np.flatnonzero(index == entry)
    before, known = line(int(rows[0])), len(findings)
    with findings.at(before):
        made = value(entry)
    found = findings[known:]
    for row in rows[1:].tolist() if found else ():
        span = line(row)
        if span != before:  # the two rows of an arc have one line
            with findings.at(span):
                findings.extend(found)
        before = span
    return made


def table_of(
    index: NDArray[Any], value: Callable[[int], Any]
) -> tuple[tuple[Any, ...], NDArray[np.int32]]:
    """The entries that an index column uses, each once and by first use, and their rows."""
    used, first, inverse = np.unique(index, return_index=True, return_inverse=True)
    order = np.argsort(first)
    entries: list[Any] = []
    rows = np.zeros(len(used), dtype=np.int32)
    for i in order:
        entry = value(int(used[i]))
        if entry not in entries:
            entries.append(entry)
        rows[i] = entries.index(entry)
    return tuple(entries), rows[inverse.reshape(-1)]
