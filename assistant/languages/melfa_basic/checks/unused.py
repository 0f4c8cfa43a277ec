"""Rules of what stands twice, and of what nothing uses."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from typing import Final

import numpy as np

from assistant.languages.melfa_basic import rules
from assistant.languages.melfa_basic.checks.file_view import Look
from assistant.languages.melfa_basic.checks.steps import MOST_ROWS, row_span
from assistant.languages.melfa_basic.checks.uses import Use
from assistant.languages.melfa_basic.checks.variables_of import NUMBERED, Known, is_position, known
from assistant.languages.melfa_basic.text import printer
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.columnar import MoveRows, PositionRows
from assistant.languages.melfa_basic.tree.targets import labels_named
from assistant.program.arrays import Ints
from assistant.program.diagnostics import Diagnostic, Span

Found = Iterator[Diagnostic]

SHOWN: Final = 6
"""Names that one finding lists."""


def twice(look: Look) -> Found:
    """Variables with two lines of data."""
    counts: Counter[str] = Counter()
    last: dict[str, s.Data] = {}
    stems: dict[str, list[PositionRows]] = {}
    single: dict[str, list[int]] = {}
    for item in look.data:
        if isinstance(item, PositionRows):
            stems.setdefault(item.stem.upper(), []).append(item)
            continue
        name = printer.expression(item.variable).upper()
        counts[name] += 1
        last[name] = item
        split = NUMBERED.fullmatch(name)
        if split is not None:
            single.setdefault(split[1], []).append(int(split[2]))
    for stem, tables in stems.items():
        alone = np.array(single.get(stem, []), dtype=np.int64)
        every = np.concatenate([*(t.numbers for t in tables), np.unique(alone)])
        numbers, times = np.unique(every, return_counts=True)
        for number in numbers[times > 1][:MOST_ROWS].tolist():
            name = f"{stem}{number}"
            counts.pop(name, None)
            where = last.get(name) or _second(look, tables, number)
            yield look.finding(rules.TWO_POSITIONS, where, name=name)
    for name, count in counts.items():
        if count > 1:
            yield look.at(rules.TWO_POSITIONS, last[name], last[name].variable.name, name=name)


def _second(look: Look, tables: list[PositionRows], number: int) -> Span | None:
    """Where the last row of a number stands."""
    for table in reversed(tables):
        rows = np.flatnonzero(table.numbers == number)
        if len(rows):
            return row_span(look, table, int(rows[-1]))
    return None


# -------------------------------------------------------------------------------------- unused


def unused(look: Look) -> Found:
    """Labels, variables and positions that nothing uses; one finding for each of the three."""
    aimed = set(labels_named(look.lines))
    labels = [
        (line, f"*{line.label}")
        for line in look.lines
        if line.label is not None
        and line.label.upper() not in aimed
        and not line.label.upper().startswith("L_")  # shared with the programs on top of it
    ]
    yield from _unused(look, "the label" if len(labels) == 1 else "the labels", labels)
    names = look.once(known)
    variables: dict[str, tuple[s.Line, str]] = {}
    for line, use in look.uses:
        key = use.variable.key
        if use.role in ("written", "declared") and _is_own(look, use, names):
            variables.setdefault(key, (line, use.variable.name + use.variable.suffix))
    what = "the variable" if len(variables) == 1 else "the variables"
    yield from _unused(look, what, list(variables.values()))
    yield from _unused_positions(look, names, set(variables))


def _is_own(look: Look, use: Use, names: Known) -> bool:
    key = use.variable.key
    return (
        key not in names.read
        and key[1:2] != "_"
        and key not in look.functions
        and not isinstance(use.variable.arguments, tuple)
        and key not in names.dimensioned
    )


def _unused(look: Look, what: str, found: list[tuple[s.Line, str]]) -> Found:
    if found:
        line, first = found[0]
        names = ", ".join(f"`{name}`" for _, name in found[:SHOWN])
        more = f" and {len(found) - SHOWN} more" if len(found) > SHOWN else ""
        them = "them" if len(found) > 1 else "it"
        word = first.rstrip("$%&!#")
        yield look.at(rules.UNUSED, line, word, what=what, names=names + more, them=them)


def _unused_positions(look: Look, names: Known, told: set[str]) -> Found:
    """Positions with a line that no statement names."""
    if not look.lines and not any(isinstance(item, MoveRows) for item in look.code):
        return  # a list of positions for other programs
    moved: dict[str, list[Ints]] = {}
    for rows in look.code:
        if isinstance(rows, MoveRows):
            numbers = moved.setdefault(rows.stem.upper(), [])
            numbers += [rows.end, rows.via, rows.start]
    for key in names.read | names.given:
        split = NUMBERED.fullmatch(key)
        if split is not None and (key in names.read or key in told):
            moved.setdefault(split[1], []).append(np.array([int(split[2])]))
    found: list[tuple[s.Item | Span | None, str]] = []
    count = 0
    for item in look.data:
        if isinstance(item, PositionRows):
            used = moved.get(item.stem.upper(), [np.empty(0, np.int64)])
            idle = np.flatnonzero(~np.isin(item.numbers, np.concatenate(used)))
            count += len(idle)
            for row in idle[: max(0, SHOWN - len(found))].tolist():
                name = f"{item.stem}{int(item.numbers[row])}"
                found.append((row_span(look, item, row), name))
        elif is_position(item) and not _is_used(item, names, moved, told):
            count += 1
            found.append((item, item.variable.name))
    if found:
        where, _ = found[0]
        listed = ", ".join(f"`{name}`" for _, name in found[:SHOWN])
        more = f" and {count - SHOWN} more" if count > SHOWN else ""
        what, them = ("the positions", "them") if count > 1 else ("the position", "it")
        yield look.finding(rules.UNUSED, where, what=what, names=listed + more, them=them)


def _is_used(
    item: s.Data,
    names: Known,
    moved: dict[str, list[Ints]],
    told: set[str],
) -> bool:
    key = item.variable.key
    if key in names.read or key in told or key[1:2] == "_" or item.variable.arguments is not None:
        return True
    split = NUMBERED.fullmatch(key)
    return split is not None and any(
        bool((numbers == int(split[2])).any()) for numbers in moved.get(split[1], ())
    )
