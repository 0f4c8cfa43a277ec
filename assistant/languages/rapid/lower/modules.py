"""Programs of several files as modules that a task holds beside each other.

What another language calls by the name of its file stands in a module of its own here, as it stood
in a file of its own there; the task loads them all, and a call is a plain one. Long programs that
are spread over units for want of room are loaded when they are called, as before.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace
from typing import Any, Final

from assistant.languages.rapid.text import verbatim
from assistant.program import expressions as e
from assistant.program.program import Program
from assistant.program.rewriting import records

_TARGET_TABLES: Final = ("targets", "joint_targets")
_DATA_TABLES: Final = (
    "tools", "frames", "speeds", "blends", "signals", "targets", "joint_targets", "variables",
)  # fmt: skip


def resident_units(program: Program) -> frozenset[str | None]:
    """The units that a task holds: those that the source in another language had."""
    origin = program.origin
    if origin is None or origin.language == verbatim.LANGUAGE:
        return frozenset()
    return frozenset(q.unit for q in origin.lifted.procedures) - {None}


def with_own_targets(program: Program, unit: str | None, held: Collection[str | None]) -> Program:
    """A program with the data of one module: of one beside the main one places that it alone uses.

    held: the units that are modules of the task.
    """
    if not held:
        return program
    users: dict[str, set[str | None]] = {}
    for procedure in program.procedures:
        home = procedure.unit if procedure.unit in held else None
        for part in records(procedure):
            if isinstance(part, e.Name):
                users.setdefault(part.name.lower(), set()).add(home)
    for part in records(tuple(program.variables.values())):
        if isinstance(part, e.Name):
            users.setdefault(part.name.lower(), set()).add(None)
    texts = " ".join(one.text for one in program.declarations).lower()

    def home_of(name: str) -> str | None:
        found = users.get(name.lower(), {None})
        return next(iter(found)) if len(found) == 1 and name.lower() not in texts else None

    tables: dict[str, Any] = {}
    if unit is not None:
        tables = {table: {} for table in _DATA_TABLES} | {"procedures": ()}
    for table in _TARGET_TABLES:
        places = getattr(program, table)
        tables[table] = {n: place for n, place in places.items() if home_of(n) == unit}
    return replace(program, **tables)
