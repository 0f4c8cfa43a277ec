"""Rules of what stands twice, and of what nothing uses."""

from __future__ import annotations

from collections.abc import Set

import numpy as np

from assistant.languages.checks.names import NameSet
from assistant.languages.checks.registry import Found, Listing
from assistant.languages.melfa_basic import rules
from assistant.languages.melfa_basic.checks.file_view import Look
from assistant.languages.melfa_basic.checks.uses import Use
from assistant.languages.melfa_basic.checks.variables_of import (
    Known,
    is_position,
    known_variables,
    names_of,
)
from assistant.languages.melfa_basic.text import printer
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.columnar import MoveRows, PositionRows
from assistant.languages.melfa_basic.tree.targets import labels_named
from assistant.languages.runs.columns import Names


def stored_twice(look: Look) -> Found:
    """Variables with two lines of data; names in tables are there once."""
    items: dict[str, list[s.Data]] = {}
    for item in look.data:
        if isinstance(item, s.Data):
            items.setdefault(printer.expression(item.variable).upper(), []).append(item)
    for several in items.values():
        if len(several) > 1:
            last = several[-1]
            yield look.at(rules.TWO_POSITIONS, last, last.variable.name, name=last.variable.name)


# -------------------------------------------------------------------------------------- unused


def unused_names(look: Look) -> Found:
    """Labels, variables and positions that nothing uses; one finding for each of the three."""
    aimed = set(labels_named(look.lines))
    labels: Listing[s.Item] = Listing()
    for line in look.lines:
        label = (line.label or "").upper()
        # what begins with `L_` is shared with the programs on top of this one
        if label and label not in aimed and not label.startswith("L_"):
            labels.add(line, f"*{line.label}")
    yield from _listed_finding(look, "label", labels)
    names = look.once(known_variables)
    variables: Listing[s.Item] = Listing()
    told: set[str] = set()
    moved = _table_move_targets(look)
    for line, use in look.uses:
        key = use.variable.key
        written = use.role in ("written", "declared") and key not in told
        if written and _is_own(look, use, names) and key not in moved:
            told.add(key)
            variables.add(line, use.variable.marked)
    yield from _listed_finding(look, "variable", variables)
    yield from _unused_positions(look, _table_move_targets(look, names.read | told))


def _table_move_targets(look: Look, words: Set[str] = frozenset()) -> NameSet:
    """The positions that moves in tables name, and other words."""
    moved = NameSet()
    moved.words |= words
    for rows in look.code:
        if isinstance(rows, MoveRows):
            stem, points = rows.stem.encode("ascii"), (rows.end, rows.via, rows.start)
            moved.columns += [Names.numbered(stem, numbers[numbers >= 0]) for numbers in points]
    return moved


def _is_own(look: Look, use: Use, names: Known) -> bool:
    key = use.variable.key
    return (
        key not in names.read
        and key[1:2] != "_"
        and key not in look.functions
        and not isinstance(use.variable.arguments, tuple)
        and key not in names.dimensioned
    )


def _listed_finding(look: Look, what: str, found: Listing[s.Item]) -> Found:
    if found.first is None:
        return
    item, row = found.first
    words = {"what": f"the {what}s" if found.count > 1 else f"the {what}", **found.words}
    if isinstance(item, s.Line):
        yield look.at(rules.UNUSED, item, found.names[0].rstrip("$%&!#"), **words)
    else:
        where = look.row(item, row) if isinstance(item, PositionRows) else item
        yield look.finding(rules.UNUSED, where, **words)


def _unused_positions(look: Look, used: NameSet) -> Found:
    """Positions with a line that no statement names."""
    if not look.code:
        return  # a list of positions for other programs
    found: Listing[s.Item] = Listing()
    for item in look.data:
        if isinstance(item, PositionRows):
            written = Names.numbered(item.stem.encode("ascii"), item.numbers)
            found.add_rows(item, np.flatnonzero(~used.among(names_of(item))), written.name)
        elif is_position(item) and not _is_shared(item.variable) and item.variable.key not in used:
            found.add(item, item.variable.name)
    yield from _listed_finding(look, "position", found)


def _is_shared(variable: s.Variable) -> bool:
    """Whether other programs, or subscripts that are worked out, may name a position."""
    return variable.key[1:2] == "_" or variable.arguments is not None
