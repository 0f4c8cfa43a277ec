"""Long paths: one program holds so many steps, the rest goes to programs that it calls."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from assistant.languages.melfa_basic import rules
from assistant.languages.melfa_basic.lower.adapt.paths import table_of
from assistant.languages.melfa_basic.tables.dialects import LAST_STEP
from assistant.program import statements as p
from assistant.program.arrays import Ints
from assistant.program.path import Kind, Path
from assistant.program.program import Procedure, identifier, walk
from assistant.program.rewriting import Body, map_bodies
from assistant.program.subjects import Declared

if TYPE_CHECKING:
    from assistant.languages.melfa_basic.lower.adapt.context import Context

MOST_TARGETS: Final = 30_000
"""Targets of one program: its steps end at 32767, and the heading takes some."""

MOST_STEPS: Final = LAST_STEP - 700
"""Steps that a path may take of one program."""


def split(context: Context, procedure: Procedure, most: int) -> Iterator[Procedure]:
    """The procedure, and one in a unit of its own for each part of a path that is too long."""
    parts: list[Procedure] = []
    taken = {q.name for q in context.program.procedures}
    taken |= {q.unit for q in context.program.procedures if q.unit}
    lone = procedure.unit is not None and len(procedure.body) == 1

    def follow(node: p.Follow) -> Iterator[p.Statement]:
        pieces = cuts(node.path, most)
        if len(pieces) < 2 and (lone or not long_together):
            yield node
            return
        for number, (start, stop) in enumerate(pieces, 1):
            name = identifier(f"{node.path.name}_part_{number}", taken)
            taken.add(name)
            rows = node.path.rows(start, stop, name)
            parts.append(Procedure(name, (p.Follow(compact(rows)),), unit=name))
            yield p.Call(name, unit=name, span=node.span)
        context.findings.append(
            rules.SPLIT(
                name=node.path.name,
                count=len(node.path),
                parts=len(pieces),
                about=Declared(procedure.name, "procedures"),
            )
        )

    def body(statements: Body) -> Body:
        made: list[p.Statement] = []
        for node in statements:
            if isinstance(node, p.Follow):
                made += follow(node)
            else:
                made.append(map_bodies(node, body))
        return tuple(made)

    sizes = [len(node.path) for node in walk(procedure.body) if isinstance(node, p.Follow)]
    long_together = sum(sizes) > most and len(sizes) > 1
    yield replace(procedure, body=body(procedure.body))
    yield from parts


def cuts(path: Path, most: int) -> list[tuple[int, int]]:
    """Ranges of rows that fit one program each; an arc's two rows stay together.

    A part begins with a straight move where one is near, so that no arc starts unknown.
    """
    n = len(path)
    costs = _steps(path)
    if n <= most and int(costs.sum()) <= MOST_STEPS:
        return [(0, n)]
    total = np.concatenate([[0], np.cumsum(costs)])
    pieces, start = [], 0
    while start < n:
        stop = int(np.searchsorted(total, total[start] + MOST_STEPS, side="right")) - 1
        stop = min(n, start + most, max(stop, start + 2))
        if stop < n:
            stop = _good_cut(path, start, stop)
        pieces.append((start, stop))
        start = stop
    return pieces


def _good_cut(path: Path, start: int, stop: int) -> int:
    """The last row up to `stop` that a part may begin with."""
    least = max(start + 1, stop - (stop - start) // 4)
    kinds = path.kinds[least : stop + 1]
    straight = np.flatnonzero((kinds != Kind.VIA) & (kinds != Kind.END))
    if len(straight):
        return least + int(straight[-1])
    whole = np.flatnonzero(path.kinds[start + 1 : stop + 1] != Kind.END)
    return start + 1 + int(whole[-1]) if len(whole) else stop


def _steps(path: Path) -> Ints:
    """Steps that each row takes at most: its move, and its settings where they change."""
    costs = (path.kinds != Kind.VIA).astype(np.int64)
    costs[0] += 5
    for column, lines in (("speed", 2), ("blend", 1), ("tool", 1), ("frame", 1)):
        values = getattr(path, column)
        costs[1:] += lines * (values[1:] != values[:-1])
    return np.asarray(costs)


def compact(path: Path) -> Path:
    """The path with only those table rows that it uses, in the order of their first use."""
    made: dict[str, Any] = {}
    for column in ("speed", "blend", "tool", "frame"):
        table: tuple[Any, ...] = getattr(path, column + "s")
        made[column + "s"], made[column] = table_of(getattr(path, column), table.__getitem__)
    return replace(path, **made)
