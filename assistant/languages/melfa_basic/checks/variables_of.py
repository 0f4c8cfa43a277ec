"""What a file and those it includes say about its variables."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

from assistant.languages.checks.names import NameSet
from assistant.languages.melfa_basic.checks.file_view import Calls, Look
from assistant.languages.melfa_basic.tables.dialects import DIALECTS
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.columnar import PositionRows
from assistant.languages.melfa_basic.tree.walk import nodes
from assistant.languages.runs.columns import Names


@dataclass(slots=True)
class Known:
    """What a file and those it includes say about variables, by name in upper case.

    given: names that something gives a value, rows of positions too. declared: by Def, Dim, FPrm
    or a Function's head. dimensioned: arrays. read: names that something reads.
    """

    given: NameSet = field(default_factory=NameSet)
    declared: set[str] = field(default_factory=set)
    dimensioned: set[str] = field(default_factory=set)
    read: set[str] = field(default_factory=set)


def known_variables(look: Look) -> Known:
    """Worked out once for a file."""
    found = Known()
    for tree in look.included:
        beside = look if tree is look.tree else Look(tree, look.dialect, look.calls, look.damage)
        _take_file(beside, found)
    return found


def _take_file(look: Look, found: Known) -> None:
    given = found.given.words
    for _, use in look.uses:
        key = use.variable.key
        if use.role in ("written", "either"):
            given.add(key)
        if use.role == "declared":
            found.declared.add(key)
            if use.variable.arguments is not None:
                found.dimensioned.add(key)
        if use.role in ("read", "either") or use.variable.component:
            found.read.add(key)
        for inner in nodes(use.variable.arguments):
            if isinstance(inner, s.Variable):
                found.read.add(inner.key)
    for line in look.lines:
        match line.statement:
            case s.FPrm(variables):
                found.declared |= {v.key for v in variables}
            case s.Function(_, name, _, parameters):
                given.add(name.upper())
                names = {p.name.upper() for p in parameters or ()}
                given |= names
                found.declared |= names
                found.dimensioned |= {p.name.upper() for p in parameters or () if p.array}
            case s.DefFunction(name, _, parameters):
                given |= {name.upper(), *(p.key for p in parameters)}
    _take_data(look.data, found.given)
    for item in look.data:
        if isinstance(item, s.Data) and item.variable.arguments is not None:
            found.dimensioned.add(item.variable.key)


def _take_data(items: Iterable[s.Data | PositionRows], given: NameSet) -> None:
    for item in items:
        if isinstance(item, PositionRows):
            given.columns.append(names_of(item))
        elif not _is_untaught(item):
            given.words.add(item.variable.key)


def given_by_data(calls: Calls) -> NameSet:
    """Variables that the data of any of some files gives a value, by name in upper case."""
    found = NameSet()
    for tree in calls.trees:
        _take_data(Look(tree, DIALECTS[tree.dialect], calls).data, found)
    return found


def given_anywhere(calls: Calls) -> NameSet:
    """Variables that any of some files gives a value, by name in upper case."""
    found = Known()
    for tree in calls.trees:
        _take_file(Look(tree, DIALECTS[tree.dialect], calls), found)
    return found.given


def names_of(rows: PositionRows) -> Names:
    return Names.numbered(rows.stem.upper().encode("ascii"), rows.numbers)


def is_position(item: s.Data) -> bool:
    """Whether a line of data gives a position or joints."""
    return isinstance(item.value, s.Constant)


def _is_untaught(item: s.Data) -> bool:
    """Whether a line says that a position has no value: `(,,,,,)(,)`, as the tools write it."""
    value = item.value
    return isinstance(value, s.Constant) and not any(v is not None for v in value.values)
