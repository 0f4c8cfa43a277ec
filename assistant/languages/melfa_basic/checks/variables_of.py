"""What a file and those it includes say about its variables."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import Final

from assistant.languages.melfa_basic.checks.file_view import Look
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.columnar import PositionRows
from assistant.languages.melfa_basic.tree.walk import nodes
from assistant.program.arrays import Ints

NUMBERED: Final = re.compile(r"([A-Z][A-Z_]*)(0|[1-9][0-9]{0,8})")
"""A name in upper case that ends with a number, as those of tables do."""


@dataclass(slots=True)
class Known:
    """What a file and those it includes say about variables, by name in upper case.

    given: names that something gives a value. declared: by Def, Dim, FPrm or a Function's head.
    dimensioned: arrays. read: names that something reads. rows: numbers that have a position
    line, by stem.
    """

    given: set[str] = field(default_factory=set)
    declared: set[str] = field(default_factory=set)
    dimensioned: set[str] = field(default_factory=set)
    read: set[str] = field(default_factory=set)
    rows: dict[str, list[Ints]] = field(default_factory=dict)

    def has_row(self, name: str) -> bool:
        found = NUMBERED.fullmatch(name)
        if found is None:
            return False
        number = int(found[2])
        return any(bool((numbers == number).any()) for numbers in self.rows.get(found[1], ()))


def known(look: Look) -> Known:
    """Worked out once for a file."""
    found = Known()
    for tree in look.included:
        beside = look if tree is look.tree else Look(tree, look.dialect, look.calls, look.damage)
        _take(beside, found)
    return found


def _take(look: Look, found: Known) -> None:
    for _, use in look.uses:
        key = use.variable.key
        if use.role in ("written", "either"):
            found.given.add(key)
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
                found.given.add(name.upper())
                names = {p.name.upper() for p in parameters or ()}
                found.given |= names
                found.declared |= names
                found.dimensioned |= {p.name.upper() for p in parameters or () if p.array}
            case s.DefFunction(name, _, parameters):
                found.given |= {name.upper(), *(p.key for p in parameters)}
    for item in look.data:
        if isinstance(item, PositionRows):
            found.rows.setdefault(item.stem.upper(), []).append(item.numbers)
        elif not _is_empty(item):
            found.given.add(item.variable.key)
        if isinstance(item, s.Data) and item.variable.arguments is not None:
            found.dimensioned.add(item.variable.key)


def is_position(item: s.Data) -> bool:
    """Whether a line of data gives a position or joints."""
    return isinstance(item.value, s.Constant)


def _is_empty(item: s.Data) -> bool:
    """Whether a line says that a position has no value: `(,,,,,)(,)`, as the tools write it."""
    value = item.value
    return isinstance(value, s.Constant) and not any(v is not None for v in value.values)
