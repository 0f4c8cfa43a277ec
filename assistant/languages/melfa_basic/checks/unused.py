"""Rules of what stands twice, and of what nothing uses."""

from __future__ import annotations

from collections import Counter

import numpy as np

from assistant.languages.checks.name_sets import NameSet, repeated_rows
from assistant.languages.checks.registry import Found
from assistant.languages.checks.wording import SHOWN, listed
from assistant.languages.melfa_basic import rules
from assistant.languages.melfa_basic.checks.file_view import Look
from assistant.languages.melfa_basic.checks.steps import MOST_ROWS
from assistant.languages.melfa_basic.checks.uses import Use
from assistant.languages.melfa_basic.checks.variables_of import Known, is_position, known, names_of
from assistant.languages.melfa_basic.text import printer
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.columnar import MoveRows, PositionRows
from assistant.languages.melfa_basic.tree.targets import labels_named
from assistant.languages.runs.names import Names
from assistant.program.diagnostics import Span


def twice(look: Look) -> Found:
    """Variables with two lines of data."""
    items: dict[str, list[s.Data]] = {}
    tables: list[PositionRows] = []
    for item in look.data:
        if isinstance(item, PositionRows):
            tables.append(item)
        else:
            items.setdefault(printer.expression(item.variable).upper(), []).append(item)
    single = [name for name in items if name.isascii()]
    columns = [*map(names_of, tables), Names.of(single)]
    pairs = repeated_rows(columns)
    earlier = {before for before, _ in pairs}
    told: Counter[str] = Counter()
    for owner, row in (again for _, again in pairs if again not in earlier):
        name = columns[owner].name(row)
        stem = name.rstrip("0123456789")
        told[stem] += 1
        if told[stem] <= MOST_ROWS:
            inside = owner < len(tables)
            where = look.row(tables[owner], row) if inside else items.pop(name)[-1]
            yield look.finding(rules.TWO_POSITIONS, where, name=name)
    for name, several in items.items():
        if len(several) > 1:
            last = several[-1]
            yield look.at(rules.TWO_POSITIONS, last, last.variable.name, name=name)


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
            variables.setdefault(key, (line, use.variable.marked))
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
        names = listed([name for _, name in found])
        yield look.at(rules.UNUSED, line, first.rstrip("$%&!#"), what=what, **names)


def _unused_positions(look: Look, names: Known, told: set[str]) -> Found:
    """Positions with a line that no statement names."""
    if not look.code:
        return  # a list of positions for other programs
    used = NameSet()
    used.words = names.read | told
    for rows in look.code:
        if isinstance(rows, MoveRows):
            stem, points = rows.stem.encode("ascii"), (rows.end, rows.via, rows.start)
            used.columns += [Names.numbered(stem, numbers) for numbers in points]
    found: list[tuple[s.Item | Span | None, str]] = []
    count = 0
    for item in look.data:
        if isinstance(item, PositionRows):
            idle = np.flatnonzero(~used.among(names_of(item)))
            count += len(idle)
            for row in idle[: max(0, SHOWN - len(found))].tolist():
                name = f"{item.stem}{int(item.numbers[row])}"
                found.append((look.row(item, row), name))
        elif is_position(item) and not _is_shared(item.variable) and item.variable.key not in used:
            count += 1
            found.append((item, item.variable.name))
    if found:
        what = "the positions" if count > 1 else "the position"
        listing = listed([name for _, name in found], count)
        yield look.finding(rules.UNUSED, found[0][0], what=what, **listing)


def _is_shared(variable: s.Variable) -> bool:
    """Whether other programs, or subscripts that are worked out, may name a position."""
    return variable.key[1:2] == "_" or variable.arguments is not None
